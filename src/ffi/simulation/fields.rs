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

/// A quantity that every point has. Vectors have one number an axis; all others have one. Numbers that are
/// missing are kept for fields to come.
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
/// Energy that broken bonds held, per reference volume.
pub const PERION_FIELD_DISSIPATED_ENERGY_DENSITY: perion_field = 14;
/// Number of points within the point's own horizon.
pub const PERION_FIELD_NEIGHBOR_COUNT: perion_field = 23;
/// Time step by the usual formula, a time; not a bound.
pub const PERION_FIELD_TIME_STEP_ESTIMATE: perion_field = 24;

/// The constants of [`Field::ALL`].
const NUMBERS: [perion_field; 15] = [
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
    PERION_FIELD_DISSIPATED_ENERGY_DENSITY,
    PERION_FIELD_NEIGHBOR_COUNT,
    PERION_FIELD_TIME_STEP_ESTIMATE,
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
/// points, times the dimension for vectors. Derived fields are computed when asked for.
///
/// ERROR_ARGUMENT: unknown field, another length. ERROR_STATE: ACCELERATION, REACTION or BODY_FORCE of
/// conditions after a change of state or conditions; evaluate first. ERROR_NUMERIC: a force that is not
/// finite. ERROR_MEMORY. Since 0.1.
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

/// Sums a field over a set (NULL: all points), into `dimension` numbers for vectors, else one. A
/// force-displacement curve is the sum of REACTION over the held end, step by step.
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
