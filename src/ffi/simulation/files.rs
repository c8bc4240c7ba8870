//! Files in C.

use std::ffi::c_char;

use super::fields::{perion_field, read_fields};
use super::setup::{look, perion_simulation};
use crate::ffi::arguments::text;
use crate::ffi::guard::guard;
use crate::ffi::status::perion_status;

/// Writes the current positions and `field_count` fields as a .vtu file for ParaView; an older file is
/// replaced as a whole, or kept when this fails. Vectors have 3 numbers and tensors 9, row after row; what a
/// 2D body does not have of them is 0.
///
/// ERROR_IO: it cannot be written. ERROR_ARGUMENT: unknown field, or one named twice; otherwise as
/// perion_simulation_get. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_write_vtk(
    simulation: *const perion_simulation,
    path: *const c_char,
    field_count: i64,
    fields: *const perion_field,
) -> perion_status {
    guard("perion_simulation_write_vtk", || {
        // SAFETY: the header's contract.
        unsafe {
            let (path, fields) = (text(path, "path")?, read_fields(fields, field_count)?);
            look(simulation, |simulation| Ok(simulation.write_vtk(path, &fields)?))
        }
    })
}

/// Writes the next .vtu of a series, NAME_000000.vtu and so on, beside NAME.pvd, which lists them with
/// their times and is what to open in ParaView. The series starts anew with each simulation.
///
/// ERROR_ARGUMENT: pvd_path does not end in .pvd; otherwise as perion_simulation_write_vtk. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_write_series(
    simulation: *const perion_simulation,
    pvd_path: *const c_char,
    field_count: i64,
    fields: *const perion_field,
) -> perion_status {
    guard("perion_simulation_write_series", || {
        // SAFETY: the header's contract.
        unsafe {
            let (path, fields) = (text(pvd_path, "pvd_path")?, read_fields(fields, field_count)?);
            look(simulation, |simulation| Ok(simulation.write_series(path, &fields)?))
        }
    })
}
