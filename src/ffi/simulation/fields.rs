//! Fields in C.

use std::ffi::c_char;
use std::fmt::Display;

use super::setup::{change, look, look_back, perion_simulation};
use crate::error::argument;
use crate::ffi::arguments::{
    convert, expect_count, length, present, slice, slice_mut, text_or_null,
};
use crate::ffi::guard::{Failure, guard};
use crate::ffi::status::perion_status;
use crate::simulation::{Field, Simulation};

/// A quantity that every point has. Vectors have one number an axis, tensors one a pair of axes, row after
/// row (component i, j of a point is its number dimension * i + j, counted from 0); all others have one.
/// Numbers that are missing are kept for fields to come.
#[allow(non_camel_case_types)]
pub type perion_field = i32;
/// Position in the reference configuration, a length; a vector.
pub const PERION_FIELD_REFERENCE_POSITION: perion_field = 1;
/// Current position, a length; a vector. Can be set.
pub const PERION_FIELD_POSITION: perion_field = 2;
/// Displacement, a length; a vector. Can be set.
pub const PERION_FIELD_DISPLACEMENT: perion_field = 3;
/// Velocity; a vector. Can be set.
pub const PERION_FIELD_VELOCITY: perion_field = 4;
/// Acceleration; a vector, 0 where displacement or velocity is prescribed.
pub const PERION_FIELD_ACCELERATION: perion_field = 5;
/// Internal force per reference volume; a vector.
pub const PERION_FIELD_INTERNAL_FORCE: perion_field = 6;
/// Body force per reference volume; a vector. get gives the host's own and that of conditions together,
/// set replaces the host's own alone: what was got is not what to set.
pub const PERION_FIELD_BODY_FORCE: perion_field = 7;
/// Force that holds prescribed components; a vector, 0 elsewhere.
pub const PERION_FIELD_REACTION: perion_field = 8;
/// Volume; in 2D area times thickness.
pub const PERION_FIELD_VOLUME: perion_field = 9;
/// Mass per volume.
pub const PERION_FIELD_DENSITY: perion_field = 10;
/// Share of the volume of a point's family that broken bonds have cost it, 0 to 1.
pub const PERION_FIELD_DAMAGE: perion_field = 11;
/// Energy of the bonds per reference volume.
pub const PERION_FIELD_STRAIN_ENERGY_DENSITY: perion_field = 12;
/// Energy per reference volume of the penalty on what the material does not see.
pub const PERION_FIELD_STABILIZATION_ENERGY_DENSITY: perion_field = 13;
/// Energy that broken bonds held and that plastic flow took, per reference volume.
pub const PERION_FIELD_DISSIPATED_ENERGY_DENSITY: perion_field = 14;
/// Deformation gradient F_ij = dx_i/dX_j; a tensor. Where the bonds of a point do not span the body, what they
/// leave out turns with them and thins freely.
pub const PERION_FIELD_DEFORMATION_GRADIENT: perion_field = 15;
/// Green-Lagrange strain (F^T F - I)/2; a tensor.
pub const PERION_FIELD_STRAIN: perion_field = 16;
/// Plastic strain of j2_plastic in the rotated frame of the law; a tensor, 0 for what does not flow. Of
/// ordinary_state_based, in the reference frame, what its plastic extensions would pull on a unit of area, over 2 mu:
/// too small where a surface or a crack cuts the family.
pub const PERION_FIELD_PLASTIC_STRAIN: perion_field = 17;
/// First Piola-Kirchhoff stress P_ij, the force in axis i on the reference area across axis j; a tensor.
/// correspondence: that of the material at F, without the penalty of the stabilised forms.
/// bond_associated_quadrature: the mean over the bonds. The others: the virial or areal stress
/// 1/2 sum (t_ij - t_ji) (x) xi V_j, too small where a surface or a crack cuts the family.
pub const PERION_FIELD_FIRST_PIOLA_STRESS: perion_field = 18;
/// Cauchy stress P F^T/J of the two above, J with the thickness in plane stress; a tensor. Symmetric where P
/// is of a material at F, else as nearly as bonds deform alike.
pub const PERION_FIELD_CAUCHY_STRESS: perion_field = 19;
/// Cauchy stress across a 2D body: 0 in plane stress. ERROR_UNSUPPORTED in 3D.
pub const PERION_FIELD_STRESS_33: perion_field = 20;
/// Von Mises stress of the Cauchy stress, with that across a 2D body.
pub const PERION_FIELD_VON_MISES_STRESS: perion_field = 21;
/// Change of volume per volume, in 2D of area per area: theta of ordinary_state_based (where it flows that of what is
/// elastic, which is the same while the family is whole) and madenci_oterkus, for the others det F - 1.
pub const PERION_FIELD_DILATATION: perion_field = 22;
/// Number of points within the point's own horizon.
pub const PERION_FIELD_NEIGHBOR_COUNT: perion_field = 23;
/// Time step by the usual formula, a time; not a bound.
pub const PERION_FIELD_TIME_STEP_ESTIMATE: perion_field = 24;
/// Shape tensor K = sum w xi xi^T V over a point's family (Bergel and Li), xi the bond in the reference
/// configuration and w its weight, broken bonds left out; a tensor.
pub const PERION_FIELD_SHAPE_TENSOR: perion_field = 25;
/// N = sum w eta xi^T V with eta the bond as it is now: F = N K^-1; a tensor.
pub const PERION_FIELD_MIXED_SHAPE_TENSOR: perion_field = 26;
/// M = sum w eta eta^T V; a tensor.
pub const PERION_FIELD_DEFORMED_SHAPE_TENSOR: perion_field = 27;
/// Equivalent plastic strain: its increments are sqrt(2/3) of the size of those of the plastic strain. Of
/// ordinary_state_based: plastic work over the yield stress.
pub const PERION_FIELD_EQUIVALENT_PLASTIC_STRAIN: perion_field = 28;

/// The constants of [`Field::ALL`].
const NUMBERS: [perion_field; 28] = [
    PERION_FIELD_REFERENCE_POSITION,
    PERION_FIELD_POSITION,
    PERION_FIELD_DISPLACEMENT,
    PERION_FIELD_VELOCITY,
    PERION_FIELD_ACCELERATION,
    PERION_FIELD_INTERNAL_FORCE,
    PERION_FIELD_BODY_FORCE,
    PERION_FIELD_REACTION,
    PERION_FIELD_VOLUME,
    PERION_FIELD_DENSITY,
    PERION_FIELD_DAMAGE,
    PERION_FIELD_STRAIN_ENERGY_DENSITY,
    PERION_FIELD_STABILIZATION_ENERGY_DENSITY,
    PERION_FIELD_DISSIPATED_ENERGY_DENSITY,
    PERION_FIELD_DEFORMATION_GRADIENT,
    PERION_FIELD_STRAIN,
    PERION_FIELD_PLASTIC_STRAIN,
    PERION_FIELD_EQUIVALENT_PLASTIC_STRAIN,
    PERION_FIELD_FIRST_PIOLA_STRESS,
    PERION_FIELD_CAUCHY_STRESS,
    PERION_FIELD_STRESS_33,
    PERION_FIELD_VON_MISES_STRESS,
    PERION_FIELD_DILATATION,
    PERION_FIELD_NEIGHBOR_COUNT,
    PERION_FIELD_TIME_STEP_ESTIMATE,
    PERION_FIELD_SHAPE_TENSOR,
    PERION_FIELD_MIXED_SHAPE_TENSOR,
    PERION_FIELD_DEFORMED_SHAPE_TENSOR,
];

pub(super) fn field_of(field: perion_field) -> Result<Field, Failure> {
    named_field(field, "'field'")
}

fn named_field(field: perion_field, name: impl Display) -> Result<Field, Failure> {
    match NUMBERS.iter().position(|&number| number == field) {
        Some(place) => Ok(Field::ALL[place]),
        None => Ok(argument(format!(
            "{name} is {field}; it must be one of the PERION_FIELD_ constants"
        ))?),
    }
}

/// Fields by their numbers.
///
/// # Safety
/// As for [`slice`].
pub(super) unsafe fn read_fields(
    fields: *const perion_field,
    count: i64,
) -> Result<Vec<Field>, Failure> {
    if count > NUMBERS.len() as i64 {
        return Ok(argument(format!(
            "'field_count' is {count}, but there are only {} fields",
            NUMBERS.len()
        ))?);
    }
    // SAFETY: the caller's promise.
    let given = unsafe { slice(fields, count, "fields") }?;
    let mut read = crate::memory::reserved(given.len(), "fields")?;
    for (place, &number) in given.iter().enumerate() {
        read.push(named_field(number, format_args!("'fields'[{place}]"))?);
    }
    Ok(read)
}

/// The length of the host's array for a set, its count checked.
fn strided(
    simulation: &Simulation,
    set: Option<&str>,
    field: Field,
    count: i64,
    stride: usize,
) -> Result<i64, Failure> {
    let points = simulation.points();
    let size = points.set_size(set.unwrap_or("all"))?;
    expect_count(count, size, "count")?;
    field.check_stride(stride, points.dimension())?;
    length(size, stride, field.components(points.dimension()), "values")
}

/// Copies a field of all points to the host, point after point in the host's order. length: number of
/// points, times the dimension for vectors and its square for tensors, which lie row after row as an array
/// [count][dimension][dimension] does. Derived fields are computed when asked for.
///
/// ERROR_ARGUMENT: unknown field, another length. ERROR_STATE: ACCELERATION, REACTION or BODY_FORCE of
/// conditions after a change of state or conditions; evaluate first. ERROR_NUMERIC: a force, deformation or
/// stress that is not finite. ERROR_UNSUPPORTED: STRESS_33 in 3D. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_get(
    simulation: *const perion_simulation,
    field: perion_field,
    values: *mut f64,
    length: i64,
) -> perion_status {
    guard("perion_simulation_get", || {
        let field = field_of(field)?;
        // SAFETY: the header's contract.
        unsafe {
            look_back(simulation, |simulation| {
                let points = simulation.points();
                let components = field.components(points.dimension());
                expect_count(length, points.count() * components, "length")?;
                copy_out(simulation, None, field, values, components)
            })
        }
    })
}

/// Copies a field to the host, point by point: what lies between may be another thread's.
///
/// # Safety
/// `values` leads to room for the components of each point of the set, `stride` numbers apart.
unsafe fn copy_out(
    simulation: &Simulation,
    set: Option<&str>,
    field: Field,
    values: *mut f64,
    stride: usize,
) -> Result<(), Failure> {
    let first = present(values, "values")?;
    let mut start = 0;
    simulation.for_each_value(set, field, |components| {
        // SAFETY: the caller's promise.
        unsafe {
            let place = first.add(start);
            std::ptr::copy_nonoverlapping(components.as_ptr(), place, components.len());
        }
        start += stride;
    })?;
    Ok(())
}

/// Sets DISPLACEMENT, POSITION, VELOCITY or the host's BODY_FORCE of all points, point after point in the
/// host's order. length: number of points times the dimension. Nothing is set unless all values are
/// finite.
///
/// ERROR_ARGUMENT: unknown field, another length, a value that is not finite. ERROR_UNSUPPORTED: a field
/// that cannot be set. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set(
    simulation: *mut perion_simulation,
    field: perion_field,
    values: *const f64,
    length: i64,
) -> perion_status {
    guard("perion_simulation_set", || {
        let field = field_of(field)?;
        field.check_settable()?;
        // SAFETY: the header's contract.
        unsafe {
            change(simulation, |simulation| {
                let points = simulation.points();
                let numbers = points.count() * field.components(points.dimension());
                expect_count(length, numbers, "length")?;
                Ok(simulation.set(field, slice(values, length, "values")?)?)
            })
        }
    })
}

/// As perion_simulation_get for the points of a set in its order (NULL: all points), with `stride`
/// doubles from one point to the next; what lies between is not touched. count: number of these points.
///
/// ERROR_ARGUMENT: also unknown set, another count, stride below the numbers of a point. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_get_strided(
    simulation: *const perion_simulation,
    set_or_null: *const c_char,
    field: perion_field,
    values: *mut f64,
    count: i64,
    stride: i64,
) -> perion_status {
    guard("perion_simulation_get_strided", || {
        let (field, stride) = (field_of(field)?, convert(stride, "stride")?);
        // SAFETY: the header's contract.
        unsafe {
            let set = text_or_null(set_or_null, "set")?;
            look_back(simulation, |simulation| {
                strided(simulation, set, field, count, stride)?;
                copy_out(simulation, set, field, values, stride)
            })
        }
    })
}

/// As perion_simulation_set for the points of a set in its order (NULL: all points), with `stride`
/// doubles from one point to the next. count: number of these points.
///
/// ERROR_ARGUMENT: also unknown set, another count, stride below the dimension. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set_strided(
    simulation: *mut perion_simulation,
    set_or_null: *const c_char,
    field: perion_field,
    values: *const f64,
    count: i64,
    stride: i64,
) -> perion_status {
    guard("perion_simulation_set_strided", || {
        let (field, stride) = (field_of(field)?, convert(stride, "stride")?);
        field.check_settable()?;
        // SAFETY: the header's contract.
        unsafe {
            let set = text_or_null(set_or_null, "set")?;
            change(simulation, |simulation| {
                let numbers = strided(simulation, set, field, count, stride)?;
                let values = slice(values, numbers, "values")?;
                Ok(simulation.set_strided(set, field, values, stride)?)
            })
        }
    })
}

/// Sums a field over a set (NULL: all points), into `dimension` numbers for vectors, their square
/// for tensors, else one. A force-displacement curve is the sum of REACTION over the held end, step by step.
///
/// ERROR_ARGUMENT: unknown field or set; otherwise as perion_simulation_get. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_sum(
    simulation: *const perion_simulation,
    field: perion_field,
    set_or_null: *const c_char,
    components: *mut f64,
) -> perion_status {
    guard("perion_simulation_sum", || {
        let field = field_of(field)?;
        // SAFETY: the header's contract.
        unsafe {
            let set = text_or_null(set_or_null, "set")?;
            look(simulation, |simulation| {
                let numbers = field.components(simulation.points().dimension()) as i64;
                let out = slice_mut(components, numbers, "components")?;
                out.copy_from_slice(&simulation.sum(field, set)?);
                Ok(())
            })
        }
    })
}
