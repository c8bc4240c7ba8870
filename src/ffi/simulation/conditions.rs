//! Conditions in C.

use std::ffi::{c_char, c_int, c_void};
use std::ops::ControlFlow;

use super::setup::{change, perion_simulation};
use crate::conditions::Quantity;
use crate::error::argument;
use crate::ffi::arguments::{convert, slice, text};
use crate::ffi::guard::{Failure, User, call_host, guard};
use crate::ffi::status::perion_status;

/// What a condition prescribes.
#[allow(non_camel_case_types)]
pub type perion_quantity = i32;
/// Displacement, a length.
pub const PERION_QUANTITY_DISPLACEMENT: perion_quantity = 1;
/// Velocity.
pub const PERION_QUANTITY_VELOCITY: perion_quantity = 2;
/// Force per reference volume.
pub const PERION_QUANTITY_BODY_FORCE: perion_quantity = 3;
/// Force per reference area of the surface along a set of points, the outermost layer; a dead load.
pub const PERION_QUANTITY_TRACTION: perion_quantity = 4;

/// A function that the host prescribes: fills values[count] at `time` for the points of its set, whose
/// reference positions [count][dimension] come in the set's order. Runs on the calling thread, with the
/// host's floating-point environment; must not throw or jump out, and may not call anything on the
/// simulation. A result other than 0 stops the run (ERROR_INTERRUPTED).
#[allow(non_camel_case_types)]
pub type perion_function = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        time: f64,
        count: i64,
        reference_positions: *const f64,
        values: *mut f64,
    ) -> c_int,
>;

fn quantity_of(quantity: perion_quantity) -> Result<Quantity, Failure> {
    match quantity {
        PERION_QUANTITY_DISPLACEMENT => Ok(Quantity::Displacement),
        PERION_QUANTITY_VELOCITY => Ok(Quantity::Velocity),
        PERION_QUANTITY_BODY_FORCE => Ok(Quantity::BodyForce),
        PERION_QUANTITY_TRACTION => Ok(Quantity::Traction),
        _ => Ok(argument(format!(
            "'quantity' is {quantity}; it must be one of the PERION_QUANTITY_ constants, 1 to 4"
        ))?),
    }
}

/// Prescribes a constant on a set along an axis (from 0), from the next step on. Per point and axis the
/// last displacement or velocity wins and replaces the other for good; body forces and tractions of different
/// sets add, the same set and axis replaces. A traction acts on the layers below its set, see
/// perion_simulation_set_surface_areas. A displacement is where the point is put at once at the end of
/// the next step: ramp it by a table for smooth loading.
///
/// ERROR_ARGUMENT: unknown set or quantity, axis out of range, value not finite. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_prescribe(
    simulation: *mut perion_simulation,
    set: *const c_char,
    quantity: perion_quantity,
    axis: i32,
    value: f64,
) -> perion_status {
    guard("perion_simulation_prescribe", || {
        let (quantity, axis) = (quantity_of(quantity)?, convert(axis.into(), "axis")?);
        // SAFETY: the header's contract.
        unsafe {
            let set = text(set, "set")?;
            change(simulation, |simulation| Ok(simulation.prescribe(set, quantity, axis, value)?))
        }
    })
}

/// Prescribes a table over time: linear between its times, constant outside. times: [count],
/// increasing; values: [count]. Both are copied.
///
/// ERROR_ARGUMENT: as perion_simulation_prescribe; count below 1, times that do not increase. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_prescribe_table(
    simulation: *mut perion_simulation,
    set: *const c_char,
    quantity: perion_quantity,
    axis: i32,
    count: i64,
    times: *const f64,
    values: *const f64,
) -> perion_status {
    guard("perion_simulation_prescribe_table", || {
        let (quantity, axis) = (quantity_of(quantity)?, convert(axis.into(), "axis")?);
        // SAFETY: the header's contract.
        unsafe {
            let set = text(set, "set")?;
            let times = slice(times, count, "times")?;
            let values = slice(values, count, "values")?;
            change(simulation, |simulation| {
                Ok(simulation.prescribe_table(set, quantity, axis, times, values)?)
            })
        }
    })
}

/// Prescribes a function of time and place, asked once per time that a step needs: displacements at the
/// step's end, velocities at its middle and end, body forces at its end (and at the first step's
/// beginning). `user` is handed back to it.
///
/// ERROR_NULL: no function. ERROR_ARGUMENT: as perion_simulation_prescribe. A value that is not finite
/// ends a later step with ERROR_NUMERIC. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_prescribe_function(
    simulation: *mut perion_simulation,
    set: *const c_char,
    quantity: perion_quantity,
    axis: i32,
    function: perion_function,
    user: *mut c_void,
) -> perion_status {
    guard("perion_simulation_prescribe_function", || {
        let (quantity, axis) = (quantity_of(quantity)?, convert(axis.into(), "axis")?);
        let function = function.ok_or(Failure::Null { argument: "function" })?;
        let user = User(user);
        let ask = move |time: f64, positions: &[f64], values: &mut [f64]| {
            let User(user) = { user };
            let count = values.len() as i64;
            let (positions, values) = (positions.as_ptr(), values.as_mut_ptr());
            // SAFETY: the host's promise for its function; both arrays have what `count` says.
            match call_host(|| unsafe { function(user, time, count, positions, values) }) {
                0 => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        };
        // SAFETY: the header's contract.
        unsafe {
            let set = text(set, "set")?;
            change(simulation, |simulation| {
                Ok(simulation.prescribe_function(set, quantity, axis, Box::new(ask))?)
            })
        }
    })
}

/// Prescribes one value a point of the set, in the set's order; copied and held until replaced.
///
/// ERROR_ARGUMENT: as perion_simulation_prescribe; count is not the set's size. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_prescribe_values(
    simulation: *mut perion_simulation,
    set: *const c_char,
    quantity: perion_quantity,
    axis: i32,
    count: i64,
    values: *const f64,
) -> perion_status {
    guard("perion_simulation_prescribe_values", || {
        let (quantity, axis) = (quantity_of(quantity)?, convert(axis.into(), "axis")?);
        // SAFETY: the header's contract.
        unsafe {
            let set = text(set, "set")?;
            change(simulation, |simulation| {
                simulation.points().check_set_size(set, convert(count, "count")?)?;
                let values = slice(values, count, "values")?;
                Ok(simulation.prescribe_values(set, quantity, axis, values)?)
            })
        }
    })
}

/// Ends what was prescribed on a set along an axis; the points are free there from the next step on.
///
/// ERROR_ARGUMENT: nothing is prescribed there, or other sets have taken all its points. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_release(
    simulation: *mut perion_simulation,
    set: *const c_char,
    quantity: perion_quantity,
    axis: i32,
) -> perion_status {
    guard("perion_simulation_release", || {
        let (quantity, axis) = (quantity_of(quantity)?, convert(axis.into(), "axis")?);
        // SAFETY: the header's contract.
        unsafe {
            let set = text(set, "set")?;
            change(simulation, |simulation| Ok(simulation.release(set, quantity, axis)?))
        }
    })
}

/// Gives the areas of the surface along a set, one a point of the set, in its order: a traction then makes a force of a
/// point's area times its value, spread over the layers below the point that a stress up to the surface would pull on.
/// Without areas they are estimated, well on lattices; give them for clouds without order and for bodies thinner than
/// four horizons. areas: [count], copied.
///
/// ERROR_ARGUMENT: unknown set, count is not the set's size, an area not positive and finite. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set_surface_areas(
    simulation: *mut perion_simulation,
    set: *const c_char,
    count: i64,
    areas: *const f64,
) -> perion_status {
    guard("perion_simulation_set_surface_areas", || {
        // SAFETY: the header's contract.
        unsafe {
            let set = text(set, "set")?;
            change(simulation, |simulation| {
                simulation.points().check_set_size(set, convert(count, "count")?)?;
                Ok(simulation.set_surface_areas(set, slice(areas, count, "areas")?)?)
            })
        }
    })
}
