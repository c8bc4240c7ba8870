//! Advancing to a time in C.

use super::drive::run;
use super::report::{HostReport, perion_report};
use super::setup::perion_simulation;
use crate::error::argument;
use crate::ffi::guard::{Failure, guard};
use crate::ffi::handle::Session;
use crate::ffi::sized::{self, Sized64};
use crate::ffi::status::perion_status;
use crate::simulation::{AdvanceOptions, Report};

/// How perion_simulation_advance chooses its steps; a member that is 0 stands for its default. Let
/// perion_advance_options_init set struct_size.
#[repr(C)]
#[allow(non_camel_case_types)]
#[derive(Clone, Copy)]
pub struct perion_advance_options {
    /// Bytes of the caller's struct.
    pub struct_size: i64,
    /// time step over the stable one, at most 1; default 0.8
    pub safety: f64,
    /// steps are never longer; default: no limit
    pub largest_time_step: f64,
    /// steps after which the stable one is found anew, at the cost of ten forces; after a quarter of them when bonds
    /// have broken; default 100
    pub interval: i64,
}

// SAFETY: plain numbers behind struct_size.
unsafe impl Sized64 for perion_advance_options {}

/// Clears the struct, which stands for all defaults, and sets its struct_size; struct_size:
/// sizeof(perion_advance_options) as the host was compiled, so that it works with later libraries too. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_advance_options_init(
    advance_options: *mut perion_advance_options,
    struct_size: i64,
) {
    // SAFETY: the header's contract.
    unsafe { sized::init(advance_options, struct_size) }
}

/// Makes velocity Verlet steps up to the time `until`, and lands on it exactly. Steps are a share of the stable step,
/// which is found anew on the way; NULL options are the defaults. The report, unless NULL, tells what was done, also
/// of a run that failed on its way. The progress callback is told of each step, with the total as it looks then.
///
/// ERROR_ARGUMENT: until not finite or before the current time, safety outside 0 to 1, largest_time_step or interval
/// below 0, struct_size not set. ERROR_NUMERIC: a motion that is not finite, no step that is stable.
/// ERROR_INTERRUPTED: a callback stopped. ERROR_MEMORY. A failure leaves the simulation as the last completed step left
/// it. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_advance(
    simulation: *mut perion_simulation,
    until: f64,
    advance_options_or_null: *const perion_advance_options,
    report_or_null: *mut perion_report,
) -> perion_status {
    guard("perion_simulation_advance", || {
        // SAFETY: the header's contract.
        let options = unsafe { options(advance_options_or_null) }?;
        // SAFETY: as above.
        let host = unsafe { HostReport::of(report_or_null, false) }?;
        // SAFETY: as above.
        let mut session = unsafe { Session::begin(simulation) }?;
        let mut advancing =
            session.with_mut(|hosted| Ok(hosted.free()?.start_advancing(until, &options)?))?;
        let done = run(&mut session, |simulation, single| {
            simulation.continue_advancing(&mut advancing, single)
        });
        // SAFETY: as above.
        unsafe { host.tell(|told| fill(told, &advancing.report())) }?;
        done
    })
}

/// What the host asks for; a member that is 0 is the default.
///
/// # Safety
/// The pointer is NULL or leads to a struct whose first member says how many bytes it has.
unsafe fn options(
    advance_options_or_null: *const perion_advance_options,
) -> Result<AdvanceOptions, Failure> {
    let mut options = AdvanceOptions::default();
    if advance_options_or_null.is_null() {
        return Ok(options);
    }
    let unset =
        perion_advance_options { struct_size: 0, safety: 0.0, largest_time_step: 0.0, interval: 0 };
    // SAFETY: the caller's promise.
    let given = unsafe { sized::read(advance_options_or_null, unset, "advance_options") }?;
    if given.safety != 0.0 {
        options.safety = given.safety;
    }
    if given.largest_time_step != 0.0 {
        options.largest_time_step = given.largest_time_step;
    }
    if given.interval < 0 {
        let interval = given.interval;
        return Ok(argument(format!("'interval' is {interval}; it must not be negative"))?);
    }
    if given.interval > 0 {
        options.interval = given.interval as u64;
    }
    Ok(options)
}

fn fill(told: &mut perion_report, report: &Report) {
    told.steps = report.steps as i64;
    told.estimates = report.estimates as i64;
    told.smallest_time_step = report.smallest_time_step;
    told.largest_time_step = report.largest_time_step;
    told.stable_time_step = report.stable_time_step;
    told.time = report.time;
}
