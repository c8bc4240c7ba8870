//! Energy, health and memory in C.

use super::setup::{look, perion_simulation};
use crate::ffi::guard::guard;
use crate::ffi::sized::{self, Sized64};
use crate::ffi::status::perion_status;
use crate::simulation::PointReport;

/// The energy of a simulation, in units of energy. Let perion_energy_init set struct_size.
#[repr(C)]
#[allow(non_camel_case_types)]
#[derive(Clone, Copy)]
pub struct perion_energy {
    /// Bytes of the caller's struct.
    pub struct_size: i64,
    /// sum 1/2 rho V v^2
    pub kinetic: f64,
    /// sum V W, what the bonds hold
    pub elastic: f64,
    /// what broken bonds held, and the work of plastic flow
    pub dissipated: f64,
    /// work of body forces, and of what holds prescribed points
    pub external_work: f64,
    /// kinetic + elastic + dissipated that neither external work nor the start accounts for. Velocity
    /// Verlet lets it swing by about (omega dt)^2/8 of the energy; growing above that, energy comes out of
    /// nothing. Steps that the host commits itself are not in it: their work is not known
    pub closure_error: f64,
    /// part of dissipated that plastic flow took
    pub plastic: f64,
}

/// What to look at before trusting a result. Let perion_health_init set struct_size.
#[repr(C)]
#[allow(non_camel_case_types)]
#[derive(Clone, Copy)]
pub struct perion_health {
    /// Bytes of the caller's struct.
    pub struct_size: i64,
    /// points without a neighbour in the reference configuration
    pub isolated_points: i64,
    /// the first of them, -1 for none
    pub first_isolated_point: i64,
    /// points that had neighbours and have lost all bonds
    pub detached_points: i64,
    /// the first of them, -1 for none
    pub first_detached_point: i64,
    /// bonds in all
    pub bonds: i64,
    /// bonds broken
    pub broken_bonds: i64,
    /// last time step over the stable one as it was last found; 0 before the first step. Near 1 the limit is near
    pub time_step_ratio: f64,
    /// smallest stretch of a bond that is not broken, 0 when none is compressed; below about -0.3 bonds
    /// are on their way to collapse, and the stable step promises nothing
    pub smallest_stretch: f64,
    /// points with bonds whose families do not span the body (a plate one point thick, a chain, a family
    /// thinned by broken bonds) or do not bear the gradient_order asked for: the material is asked in the
    /// directions spanned alone, without stress across, and the gradient is of first order
    pub degenerate_points: i64,
    /// the first of them, -1 for none
    pub first_degenerate_point: i64,
    /// the stable step as it was last found; 0 before that. Where the host's own steps are known to be below it no more is looked for:
    /// then an estimate, no lower than these
    pub stable_time_step: f64,
    /// 1 where it was found from forces that have a potential, and is stable for small motions about the state it
    /// was found at; 0 where it is an estimate
    pub stable_step_is_guaranteed: i64,
}

/// Heap bytes that a simulation holds. Let perion_memory_init set struct_size.
#[repr(C)]
#[allow(non_camel_case_types)]
#[derive(Clone, Copy)]
pub struct perion_memory {
    /// Bytes of the caller's struct.
    pub struct_size: i64,
    /// points, their order, sets, places and materials
    pub points: i64,
    /// bonds, their state and when they break; 0 before set-up has ended
    pub bonds: i64,
    /// displacement, velocity, acceleration, forces, dissipated energy
    pub state: i64,
    /// all of it
    pub total: i64,
}

// SAFETY: plain numbers behind struct_size.
unsafe impl Sized64 for perion_energy {}
// SAFETY: as above.
unsafe impl Sized64 for perion_health {}
// SAFETY: as above.
unsafe impl Sized64 for perion_memory {}

/// Clears the struct and sets its struct_size; struct_size: sizeof(perion_energy) as the host was
/// compiled, so that it works with later libraries too. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_energy_init(energy: *mut perion_energy, struct_size: i64) {
    // SAFETY: the header's contract.
    unsafe { sized::init(energy, struct_size) }
}

/// Clears the struct and sets its struct_size; struct_size: sizeof(perion_health) as the host was
/// compiled, so that it works with later libraries too. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_health_init(health: *mut perion_health, struct_size: i64) {
    // SAFETY: the header's contract.
    unsafe { sized::init(health, struct_size) }
}

/// Clears the struct and sets its struct_size; struct_size: sizeof(perion_memory) as the host was
/// compiled, so that it works with later libraries too. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_memory_init(memory: *mut perion_memory, struct_size: i64) {
    // SAFETY: the header's contract.
    unsafe { sized::init(memory, struct_size) }
}

/// The energy balance; costs a sweep over the bonds. Ends set-up.
///
/// ERROR_ARGUMENT: struct_size not set. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_energy(
    simulation: *const perion_simulation,
    energy: *mut perion_energy,
) -> perion_status {
    guard("perion_simulation_energy", || {
        // SAFETY: the header's contract.
        unsafe {
            sized::size_of_host(energy, "energy")?;
            let known = look(simulation, |simulation| Ok(simulation.energy()?))?;
            let value = perion_energy {
                struct_size: 0,
                kinetic: known.kinetic,
                elastic: known.elastic,
                dissipated: known.dissipated,
                external_work: known.external_work,
                closure_error: known.closure_error,
                plastic: known.plastic,
            };
            sized::write(energy, &value, "energy")
        }
    })
}

/// What to look at before trusting a result: isolated, detached and degenerate points, broken bonds, time
/// step, compressed bonds. Costs a sweep over the bonds; ends set-up.
///
/// ERROR_ARGUMENT: struct_size not set, the horizon reaches no neighbour. ERROR_MEMORY. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_health(
    simulation: *const perion_simulation,
    health: *mut perion_health,
) -> perion_status {
    guard("perion_simulation_health", || {
        // SAFETY: the header's contract.
        unsafe {
            sized::size_of_host(health, "health")?;
            let known = look(simulation, |simulation| Ok(simulation.health()?))?;
            let first = |report: PointReport| report.first.map_or(-1, |point| point as i64);
            let value = perion_health {
                struct_size: 0,
                isolated_points: known.isolated.count as i64,
                first_isolated_point: first(known.isolated),
                detached_points: known.detached.count as i64,
                first_detached_point: first(known.detached),
                bonds: known.bonds as i64,
                broken_bonds: known.broken_bonds as i64,
                time_step_ratio: known.time_step_ratio,
                smallest_stretch: known.smallest_stretch,
                degenerate_points: known.degenerate.count as i64,
                first_degenerate_point: first(known.degenerate),
                stable_time_step: known.stable_time_step,
                stable_step_is_guaranteed: i64::from(known.stable_step_is_guaranteed),
            };
            sized::write(health, &value, "health")
        }
    })
}

/// Heap bytes held. ERROR_ARGUMENT: struct_size not set. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_memory(
    simulation: *const perion_simulation,
    memory: *mut perion_memory,
) -> perion_status {
    guard("perion_simulation_memory", || {
        // SAFETY: the header's contract.
        unsafe {
            sized::size_of_host(memory, "memory")?;
            let known = look(simulation, |simulation| Ok(simulation.memory()))?;
            let value = perion_memory {
                struct_size: 0,
                points: known.points as i64,
                bonds: known.bonds as i64,
                state: known.state as i64,
                total: known.total() as i64,
            };
            sized::write(memory, &value, "memory")
        }
    })
}
