//! Driving a simulation in C.

use std::ffi::{CString, c_char, c_int, c_void};

use super::setup::{Hosted, change, look_back, perion_simulation};
use crate::ffi::arguments::{convert, output};
use crate::ffi::guard::{Failure, User, call_host, guard};
use crate::ffi::handle::{self, Session};
use crate::ffi::status::perion_status;
use crate::simulation::{LogLevel, Progress, Simulation, stopped};

/// Told after each step of step and advance, each load step of solve, and each step of the motion of relax: `done` of
/// `total` of this run, and the time. It runs on the calling
/// thread with the host's floating-point environment; it must not throw or jump out. It may make const
/// calls on its simulation, write_vtk and write_series among them; others give ERROR_STATE. A result
/// other than 0 stops the run (ERROR_INTERRUPTED).
#[allow(non_camel_case_types)]
pub type perion_progress =
    Option<unsafe extern "C" fn(user: *mut c_void, done: i64, total: i64, time: f64) -> c_int>;

/// How much a message matters.
#[allow(non_camel_case_types)]
pub type perion_log_level = i32;
/// Something the host should look at.
pub const PERION_LOG_LEVEL_WARNING: perion_log_level = 1;
/// Something that helps to follow what happens.
pub const PERION_LOG_LEVEL_INFORMATION: perion_log_level = 2;

/// Takes messages of the library, on the calling thread; the text lives for the call. It must not
/// throw, jump out, or call anything on the simulation.
#[allow(non_camel_case_types)]
pub type perion_log = Option<
    unsafe extern "C" fn(user: *mut c_void, level: perion_log_level, message: *const c_char),
>;

/// The progress callback of a host.
#[derive(Clone, Copy)]
pub(crate) struct Watcher {
    function: unsafe extern "C" fn(*mut c_void, i64, i64, f64) -> c_int,
    user: User,
}

/// Computes the internal force at the current displacement with bonds as they are, and from it and the
/// loads at the current time acceleration and reactions. Breaks nothing, advances nothing.
///
/// ERROR_ARGUMENT: the horizon reaches no neighbour. ERROR_NUMERIC: a force that is not finite; the
/// message names the point. ERROR_INTERRUPTED: a function stopped. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_evaluate(
    simulation: *mut perion_simulation,
) -> perion_status {
    // SAFETY: the header's contract.
    guard("perion_simulation_evaluate", || unsafe {
        change(simulation, |simulation| Ok(simulation.evaluate()?))
    })
}

/// Accepts the current displacement as a completed step of a host that steps itself: breaks the bonds
/// stretched beyond their limit, adds up what they held, and moves the clock on by time_step (0 is
/// allowed). For velocity Verlet: set the displacement, commit, evaluate.
///
/// ERROR_ARGUMENT: time_step negative or not finite. ERROR_NUMERIC. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_commit(
    simulation: *mut perion_simulation,
    time_step: f64,
) -> perion_status {
    // SAFETY: the header's contract.
    guard("perion_simulation_commit", || unsafe {
        change(simulation, |simulation| Ok(simulation.commit(time_step)?))
    })
}

/// A time step at which step() is stable near the current displacement, with bonds as they are: 2 over the largest
/// frequency of the forces as they are linear there, less a margin: 2 to 5 percent below the limit. Materials that flow
/// count with their elastic stiffness. DBL_MAX where no bond acts. Leaves the state as it is; ends set-up.
///
/// It costs up to sixty forces, and ten when nothing has changed since it was last asked for than that a few bonds have
/// broken. Strains, turns and damage change it: ask again as they grow, or take a part of it (0.8; half of it where
/// bonds stretch by a tenth and more), or let perion_simulation_advance see to it. It promises nothing for bonds
/// pressed to a fraction of their length: see smallest_stretch of perion_health. Where forces have no potential (strong
/// forms, deformed bonds, literal forces, laws with memory and those of the host) it follows from the eigenvalue of the
/// largest size and is no guarantee: see stable_step_is_guaranteed of perion_health.
///
/// ERROR_ARGUMENT: the horizon reaches no neighbour. ERROR_NUMERIC: forces at the current displacement are
/// not finite, or no step is stable. ERROR_INTERRUPTED: a function stopped. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_stable_time_step(
    simulation: *mut perion_simulation,
    time_step: *mut f64,
) -> perion_status {
    guard("perion_simulation_stable_time_step", || {
        // SAFETY: the header's contract.
        unsafe {
            let time_step = output(time_step, "time_step")?;
            change(simulation, |simulation| {
                time_step.write(simulation.stable_time_step()?);
                Ok(())
            })
        }
    })
}

/// Makes `steps` velocity Verlet steps: predict, break bonds, force, correct. A failure leaves the
/// simulation as the last completed step left it; perion_simulation_step_count says which. Above the
/// stable step it warns through the log and in health. The first call looks whether it is, and calls with a larger
/// step or after bonds have changed: where forces are the slope of an energy that takes some 5 forces at a hundredth
/// of the stable step, 20 at half of it, up to 60 near it.
///
/// ERROR_ARGUMENT: time_step not positive and finite or more than 10 times the stable one, steps below
/// 0. ERROR_NUMERIC: a motion that is not finite; the message names the point. ERROR_INTERRUPTED: a
/// callback stopped. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_step(
    simulation: *mut perion_simulation,
    time_step: f64,
    steps: i64,
) -> perion_status {
    guard("perion_simulation_step", || {
        let steps = convert(steps, "steps")? as u64;
        // SAFETY: the header's contract.
        let mut session = unsafe { Session::begin(simulation) }?;
        let begin = |free: &mut Simulation| free.start_stepping(time_step, steps);
        let mut stepping = session.with_mut(|hosted| Ok(begin(hosted.free()?)?))?;
        run(&mut session, |simulation, single| simulation.continue_stepping(&mut stepping, single))
    })
}

/// Goes on until there is nothing more to do; `go_on` makes one step if it is told so. Between steps the host's
/// progress callback has the simulation to look at.
pub(super) fn run(
    session: &mut Session<perion_simulation>,
    mut go_on: impl FnMut(&mut Simulation, bool) -> crate::error::Result<Option<Progress>>,
) -> Result<(), Failure> {
    let mut once = |hosted: &mut Hosted| {
        let watcher = hosted.watcher;
        Ok((go_on(hosted.free()?, watcher.is_some())?, watcher))
    };
    while let (Some(made), watcher) = session.with_mut(&mut once)? {
        let Some(Watcher { function, user }) = watcher else { continue };
        let told = |count: u64| i64::try_from(count).unwrap_or(i64::MAX);
        let (done, total) = (told(made.done), told(made.total));
        // SAFETY: the host's promise for its callback.
        let call = || unsafe { function(user.0, done, total, made.time) };
        if session.while_shared(|| call_host(call))? != 0 {
            return Err(stopped(made).into());
        }
    }
    Ok(())
}

/// Sets the callback that step, advance, solve and relax tell of their progress, NULL for none; `user` is handed back to
/// it. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set_progress(
    simulation: *mut perion_simulation,
    callback: perion_progress,
    user: *mut c_void,
) -> perion_status {
    guard("perion_simulation_set_progress", || {
        let watcher = callback.map(|function| Watcher { function, user: User(user) });
        // SAFETY: the header's contract.
        unsafe {
            handle::exclusive(simulation, |hosted| {
                hosted.free()?;
                hosted.watcher = watcher;
                Ok(())
            })
        }
    })
}

/// Sets the callback that takes messages, NULL for none (the default: silence); `user` is handed back
/// to it. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set_log(
    simulation: *mut perion_simulation,
    callback: perion_log,
    user: *mut c_void,
) -> perion_status {
    guard("perion_simulation_set_log", || {
        let user = User(user);
        let log = callback.map(|function| -> crate::simulation::Log {
            Box::new(move |level, message| {
                let User(user) = { user };
                let level = match level {
                    LogLevel::Warning => PERION_LOG_LEVEL_WARNING,
                    LogLevel::Information => PERION_LOG_LEVEL_INFORMATION,
                };
                let Ok(message) = CString::new(message) else { return };
                // SAFETY: the host's promise for its callback; the text ends in NUL.
                call_host(|| unsafe { function(user, level, message.as_ptr()) });
            })
        });
        // SAFETY: the header's contract.
        unsafe {
            change(simulation, |simulation| {
                simulation.set_log(log);
                Ok(())
            })
        }
    })
}

/// Time of the last completed step. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_time(
    simulation: *const perion_simulation,
    time: *mut f64,
) -> perion_status {
    guard("perion_simulation_time", || {
        // SAFETY: the header's contract.
        unsafe {
            let time = output(time, "time")?;
            look_back(simulation, |simulation| {
                time.write(simulation.time());
                Ok(())
            })
        }
    })
}

/// Sets the clock, along which tables and functions are asked. ERROR_ARGUMENT: not finite. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set_time(
    simulation: *mut perion_simulation,
    time: f64,
) -> perion_status {
    // SAFETY: the header's contract.
    guard("perion_simulation_set_time", || unsafe {
        change(simulation, |simulation| Ok(simulation.set_time(time)?))
    })
}

/// Number of completed steps, commits included. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_step_count(
    simulation: *const perion_simulation,
    count: *mut i64,
) -> perion_status {
    guard("perion_simulation_step_count", || {
        // SAFETY: the header's contract.
        unsafe {
            let count = output(count, "count")?;
            look_back(simulation, |simulation| {
                count.write(simulation.step_count() as i64);
                Ok(())
            })
        }
    })
}
