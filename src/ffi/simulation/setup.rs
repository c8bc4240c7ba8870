//! Making a simulation, its materials and threads, and its end.

use std::ffi::c_char;

use super::drive::Watcher;
use super::views::Loans;
use crate::error::state;
use crate::ffi::arguments::{convert, output, text};
use crate::ffi::guard::{Failure, guard};
use crate::ffi::handle::{self, Handle, Opaque};
use crate::ffi::model::perion_model;
use crate::ffi::points::perion_points;
use crate::ffi::status::perion_status;
use crate::simulation::Simulation;

/// A body of points that moves under a model.
#[allow(non_camel_case_types)]
pub struct perion_simulation(Handle<Hosted>);

/// A simulation and what its host has left with it.
pub(crate) struct Hosted {
    pub(super) simulation: Simulation,
    pub(super) watcher: Option<Watcher>,
    pub(super) loans: Loans,
}

impl Opaque for perion_simulation {
    type Value = Hosted;
    const NAME: &'static str = "simulation";
    const MAGIC: u64 = 0x7065_7269_6f6e_0003;
    fn wrap(handle: Handle<Hosted>) -> Self {
        Self(handle)
    }
    fn handle(&self) -> &Handle<Hosted> {
        &self.0
    }
}

impl Hosted {
    /// The simulation, to change it: not while the host holds views of it.
    pub(super) fn free(&mut self) -> Result<&mut Simulation, Failure> {
        match self.loans.count() {
            0 => Ok(&mut self.simulation),
            count => Ok(state(format!(
                "{count} borrowed views are not yet returned; call perion_simulation_return first"
            ))?),
        }
    }
}

/// Changes a simulation.
///
/// # Safety
/// As for [`handle::exclusive`].
pub(super) unsafe fn change<R>(
    simulation: *mut perion_simulation,
    body: impl FnOnce(&mut Simulation) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: the caller's promise.
    unsafe { handle::exclusive(simulation, |hosted| body(hosted.free()?)) }
}

/// Reads a simulation.
///
/// # Safety
/// As for [`handle::shared`].
pub(super) unsafe fn look<R>(
    simulation: *const perion_simulation,
    body: impl FnOnce(&Simulation) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: the caller's promise.
    unsafe { handle::shared(simulation, |hosted| body(&hosted.simulation)) }
}

/// Reads the last completed step of a simulation, even of one that an internal error has poisoned.
///
/// # Safety
/// As for [`handle::shared`].
pub(super) unsafe fn look_back<R>(
    simulation: *const perion_simulation,
    body: impl FnOnce(&Simulation) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: the caller's promise.
    unsafe { handle::shared_even_poisoned(simulation, |hosted| body(&hosted.simulation)) }
}

/// Brings points and a model together; both are copied and can be destroyed or used again.
///
/// What follows is set-up, until the first call that needs the bonds: evaluate, commit, step,
/// stable_time_step, energy, health, bond_count, get_bonds, borrow and borrow_const, write_vtk and write_series
/// with such fields, or a get or sum of anything but positions, displacement, velocity and body force. Only then
/// a horizon that reaches no neighbour is found.
///
/// ERROR_ARGUMENT: the model lacks density, horizon or an elastic constant, or holds what does not fit
/// together or to the dimension. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_create(
    points: *const perion_points,
    model: *const perion_model,
    simulation: *mut *mut perion_simulation,
) -> perion_status {
    guard("perion_simulation_create", || {
        // SAFETY: the header's contract.
        unsafe {
            handle::create(simulation, || {
                handle::shared(points, |points| {
                    handle::shared(model, |model| {
                        let simulation = Simulation::new(points, model)?;
                        Ok(Hosted { simulation, watcher: None, loans: Loans::default() })
                    })
                })
            })
        }
    })
}

/// Gives the points of a set another material. All models of a simulation share the formulation and,
/// in 2D, the plane state. Belongs to set-up (see perion_simulation_create).
///
/// ERROR_ARGUMENT: unknown set, or a model that could not stand alone. ERROR_UNSUPPORTED: another
/// formulation or plane state. ERROR_STATE: set-up has ended. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_assign_model(
    simulation: *mut perion_simulation,
    set: *const c_char,
    model: *const perion_model,
) -> perion_status {
    guard("perion_simulation_assign_model", || {
        // SAFETY: the header's contract.
        unsafe {
            let set = text(set, "set")?;
            handle::shared(model, |model| {
                change(simulation, |simulation| Ok(simulation.assign_model(set, model)?))
            })
        }
    })
}

/// Gives the bonds between two sets a critical energy release rate of their own (energy per area).
/// Belongs to set-up (see perion_simulation_create).
///
/// ERROR_ARGUMENT: unknown set, a rate that is not positive. ERROR_STATE: set-up has ended. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set_interface(
    simulation: *mut perion_simulation,
    set_a: *const c_char,
    set_b: *const c_char,
    critical_energy_release_rate: f64,
) -> perion_status {
    guard("perion_simulation_set_interface", || {
        // SAFETY: the header's contract.
        unsafe {
            let (set_a, set_b) = (text(set_a, "set_a")?, text(set_b, "set_b")?);
            change(simulation, |simulation| {
                Ok(simulation.set_interface(set_a, set_b, critical_energy_release_rate)?)
            })
        }
    })
}

/// Lets no bond break by its stretch that has an end in the set; the host can still break it.
///
/// ERROR_ARGUMENT: unknown set. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_forbid_failure(
    simulation: *mut perion_simulation,
    set: *const c_char,
) -> perion_status {
    guard("perion_simulation_forbid_failure", || {
        // SAFETY: the header's contract.
        unsafe {
            let set = text(set, "set")?;
            change(simulation, |simulation| Ok(simulation.forbid_failure(set)?))
        }
    })
}

/// Sets the number of threads, 1 to 4096. Results do not depend on it, to the last bit. The default is
/// PERION_NUM_THREADS, else OMP_NUM_THREADS, else all cores.
///
/// ERROR_ARGUMENT: out of range. ERROR_STATE: the threads could not be started. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_set_threads(
    simulation: *mut perion_simulation,
    threads: i32,
) -> perion_status {
    guard("perion_simulation_set_threads", || {
        let threads = convert(threads.into(), "threads")?;
        // SAFETY: the header's contract.
        unsafe { change(simulation, |simulation| Ok(simulation.set_threads(threads)?)) }
    })
}

/// Number of points. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_point_count(
    simulation: *const perion_simulation,
    count: *mut i64,
) -> perion_status {
    guard("perion_simulation_point_count", || {
        // SAFETY: the header's contract.
        unsafe {
            let count = output(count, "count")?;
            look_back(simulation, |simulation| {
                count.write(simulation.points().count() as i64);
                Ok(())
            })
        }
    })
}

/// Number of axes, 2 or 3. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_dimension(
    simulation: *const perion_simulation,
    dimension: *mut i32,
) -> perion_status {
    guard("perion_simulation_dimension", || {
        // SAFETY: the header's contract.
        unsafe {
            let dimension = output(dimension, "dimension")?;
            look_back(simulation, |simulation| {
                dimension.write(simulation.points().dimension() as i32);
                Ok(())
            })
        }
    })
}

/// Frees a simulation, ends its threads and sets the pointer to NULL; NULL, or the address of NULL, is
/// fine. Views that are still borrowed end with it. ERROR_STATE: another call is using it, such as the one whose callback this is. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_destroy(
    simulation: *mut *mut perion_simulation,
) -> perion_status {
    // SAFETY: the header's contract.
    guard("perion_simulation_destroy", || unsafe { handle::destroy(simulation) })
}
