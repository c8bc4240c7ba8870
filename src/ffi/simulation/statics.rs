//! Equilibrium in C.

use super::drive::run;
use super::report::{HostReport, perion_report};
use super::setup::perion_simulation;
use crate::error::argument;
use crate::ffi::guard::{Failure, guard};
use crate::ffi::handle::Session;
use crate::ffi::sized::{self, Sized64};
use crate::ffi::status::perion_status;
use crate::simulation::{RelaxOptions, SolveOptions, StaticsReport};
use crate::solver::newton_krylov::Krylov;
use crate::solver::newton_krylov::preconditioner::Preconditioning;

/// A method for linear systems.
#[allow(non_camel_case_types)]
pub type perion_krylov = i32;
/// The default: conjugate gradients where forces have a potential, minimal residuals where the stiffness then turns out
/// to have a direction without resistance; else generalised minimal residuals.
pub const PERION_KRYLOV_AUTOMATIC: perion_krylov = 0;
/// Conjugate gradients: for a stiffness that is symmetric and positive.
pub const PERION_KRYLOV_CONJUGATE_GRADIENTS: perion_krylov = 1;
/// Minimal residuals: for one that is symmetric.
pub const PERION_KRYLOV_MINIMAL_RESIDUALS: perion_krylov = 2;
/// Generalised minimal residuals, started again after 40 products: for any.
pub const PERION_KRYLOV_GENERALISED_MINIMAL_RESIDUALS: perion_krylov = 3;

/// What linear systems are preconditioned by.
#[allow(non_camel_case_types)]
pub type perion_preconditioner = i32;
/// The default: a cycle over several levels of a stiffness of springs. Few iterations at any size of the body.
pub const PERION_PRECONDITIONER_GLOBAL: perion_preconditioner = 0;
/// The stiffness of each point alone: no set-up, many iterations.
pub const PERION_PRECONDITIONER_BLOCK_DIAGONAL: perion_preconditioner = 1;
/// Nothing.
pub const PERION_PRECONDITIONER_NONE: perion_preconditioner = 2;

/// How perion_simulation_solve looks for equilibrium; a member that is 0 stands for its default. Let
/// perion_solve_options_init set struct_size.
#[repr(C)]
#[allow(non_camel_case_types)]
#[derive(Clone, Copy)]
pub struct perion_solve_options {
    /// Bytes of the caller's struct.
    pub struct_size: i64,
    /// time at the end, along which tables and functions are asked; 0: the current time
    pub time_end: f64,
    /// forces out of balance over loads or reactions, whichever are larger (2-norms); default 1e-8
    pub tolerance: f64,
    /// load steps, equally long; cut where one fails, as long again where they are easy; default 1
    pub load_steps: i64,
    /// share of the way that a load step has at least; default 1e-3
    pub smallest_load_step: f64,
    /// linear systems that a load step may take, each time bonds have broken; default 25
    pub iterations: i64,
    /// products of the stiffness that a linear system may take, each of one force; default 2000
    pub products: i64,
    /// how often bonds may break within a load step; default 200
    pub breaks: i64,
    /// a method for linear systems
    pub krylov: perion_krylov,
    /// what they are preconditioned by
    pub preconditioner: perion_preconditioner,
}

/// How perion_simulation_relax looks for equilibrium; a member that is 0 stands for its default. Let
/// perion_relax_options_init set struct_size.
#[repr(C)]
#[allow(non_camel_case_types)]
#[derive(Clone, Copy)]
pub struct perion_relax_options {
    /// Bytes of the caller's struct.
    pub struct_size: i64,
    /// forces out of balance over loads or reactions, whichever are larger (2-norms); default 1e-6
    pub tolerance: f64,
    /// energy of the damped motion over the largest that it had; default 1e-9
    pub energy_tolerance: f64,
    /// steps that it may take, each time bonds have broken; default 100000
    pub steps: i64,
    /// steps over which prescribed displacements are applied; default 100
    pub ramp: i64,
    /// how often bonds may break; default 200
    pub breaks: i64,
}

// SAFETY: plain numbers behind struct_size.
unsafe impl Sized64 for perion_solve_options {}
// SAFETY: as above.
unsafe impl Sized64 for perion_relax_options {}

/// Clears the struct, which stands for all defaults, and sets its struct_size; struct_size:
/// sizeof(perion_solve_options) as the host was compiled, so that it works with later libraries too. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_solve_options_init(
    solve_options: *mut perion_solve_options,
    struct_size: i64,
) {
    // SAFETY: the header's contract.
    unsafe { sized::init(solve_options, struct_size) }
}

/// Clears the struct, which stands for all defaults, and sets its struct_size; struct_size:
/// sizeof(perion_relax_options) as the host was compiled, so that it works with later libraries too. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_relax_options_init(
    relax_options: *mut perion_relax_options,
    struct_size: i64,
) {
    // SAFETY: the header's contract.
    unsafe { sized::init(relax_options, struct_size) }
}

/// Finds the equilibrium under the conditions by Newton's method on the forces, going on from the last completed step.
/// Constants go linearly from what they were at the last equilibrium to what they are, tables and functions are asked
/// along the time to time_end. Bonds that an equilibrium would break are broken for good, and it is looked for again.
/// Each load step counts as a completed step, at which the body is at rest and materials remember. NULL options are the
/// defaults. The report, unless NULL, tells what was done, also of a run that failed on its way; it may bring room for
/// the residuals. The progress callback is told of each load step, with the total as it looks then.
///
/// ERROR_ARGUMENT: an option out of range, struct_size not set. ERROR_STATE: a velocity is prescribed.
/// ERROR_CONVERGENCE: load steps were cut to the smallest without success; the text has reason and residuals.
/// ERROR_INTERRUPTED: a callback stopped. ERROR_MEMORY. A failure leaves the simulation as the last completed load step
/// left it. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_solve(
    simulation: *mut perion_simulation,
    solve_options_or_null: *const perion_solve_options,
    report_or_null: *mut perion_report,
) -> perion_status {
    guard("perion_simulation_solve", || {
        // SAFETY: the header's contract.
        let options = unsafe { solve_options(solve_options_or_null) }?;
        // SAFETY: as above.
        let host = unsafe { HostReport::of(report_or_null, true) }?;
        // SAFETY: as above.
        let mut session = unsafe { Session::begin(simulation) }?;
        let mut solving =
            session.with_mut(|hosted| Ok(hosted.free()?.start_solving(&options)?))?;
        let done = run(&mut session, |simulation, _| simulation.continue_solving(&mut solving));
        // SAFETY: as above.
        unsafe { tell(&host, solving.report()) }?;
        done
    })
}

/// Finds the equilibrium under the conditions at the current time by adaptive dynamic relaxation: a damped motion with
/// masses of its own, of one force a step, for bodies whose linear systems are hard to solve. Loads act at once,
/// displacements over the first steps. Bonds that the equilibrium would break are broken for good, and the body relaxes
/// again. The result counts as one completed step, at which the body is at rest; the time stands still. NULL options are
/// the defaults. The report, unless NULL, tells what was done, also of a run that failed; it may bring room for the
/// residuals and the energies of the motion. The progress callback is told after each force of the motion how many steps it has made
/// and, as the total, may come to, as it looks then; it sees the body as it was, in the last call at rest. The log is told of
/// the residual every hundred steps.
///
/// ERROR_ARGUMENT: an option out of range, struct_size not set. ERROR_STATE: a velocity is prescribed.
/// ERROR_CONVERGENCE: the steps did not lead there; the text has reason and residuals. ERROR_INTERRUPTED: a callback
/// stopped. ERROR_MEMORY. A failure leaves the simulation as the last completed step left it. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn perion_simulation_relax(
    simulation: *mut perion_simulation,
    relax_options_or_null: *const perion_relax_options,
    report_or_null: *mut perion_report,
) -> perion_status {
    guard("perion_simulation_relax", || {
        // SAFETY: the header's contract.
        let options = unsafe { relax_options(relax_options_or_null) }?;
        // SAFETY: as above.
        let host = unsafe { HostReport::of(report_or_null, true) }?;
        // SAFETY: as above.
        let mut session = unsafe { Session::begin(simulation) }?;
        let mut relaxing =
            session.with_mut(|hosted| Ok(hosted.free()?.start_relaxing(&options)?))?;
        let done = run(&mut session, |simulation, single| {
            simulation.continue_relaxing(&mut relaxing, single)
        });
        // SAFETY: as above.
        unsafe { tell(&host, relaxing.report()) }?;
        done
    })
}

/// # Safety
/// As for [`HostReport::tell`] and [`HostReport::list`].
unsafe fn tell(host: &HostReport, report: &StaticsReport) -> Result<(), Failure> {
    // SAFETY: the caller's promise.
    unsafe {
        host.list(&report.residuals, &report.energies);
        host.tell(|told| {
            told.steps = report.steps as i64;
            told.time = report.time;
            told.cuts = report.cuts as i64;
            told.iterations = report.iterations as i64;
            told.evaluations = report.evaluations as i64;
            told.broken_bonds = report.broken_bonds as i64;
            told.share = report.share;
            told.residual = report.residuals.last().copied().unwrap_or(0.0);
            told.elastic = report.elastic;
            told.external_work = report.external_work;
            told.residual_count = report.residuals.len() as i64;
        })
    }
}

/// Takes what the host gives, unless it is 0.
fn take(option: &mut f64, given: f64) {
    if given != 0.0 {
        *option = given;
    }
}

/// As [`take`], for a count.
fn take_count(option: &mut u64, given: i64, name: &str) -> Result<(), Failure> {
    if given < 0 {
        return Ok(argument(format!("'{name}' is {given}; it must not be negative"))?);
    }
    if given > 0 {
        *option = given as u64;
    }
    Ok(())
}

/// What the host asks for; a member that is 0 is the default.
///
/// # Safety
/// The pointer is NULL or leads to a struct whose first member says how many bytes it has.
unsafe fn solve_options(
    solve_options_or_null: *const perion_solve_options,
) -> Result<SolveOptions, Failure> {
    let mut options = SolveOptions::default();
    if solve_options_or_null.is_null() {
        return Ok(options);
    }
    let unset = perion_solve_options {
        struct_size: 0,
        time_end: 0.0,
        tolerance: 0.0,
        load_steps: 0,
        smallest_load_step: 0.0,
        iterations: 0,
        products: 0,
        breaks: 0,
        krylov: PERION_KRYLOV_AUTOMATIC,
        preconditioner: PERION_PRECONDITIONER_GLOBAL,
    };
    // SAFETY: the caller's promise.
    let given = unsafe { sized::read(solve_options_or_null, unset, "solve_options") }?;
    if given.time_end != 0.0 {
        options.time_end = Some(given.time_end);
    }
    take(&mut options.tolerance, given.tolerance);
    take(&mut options.smallest_load_step, given.smallest_load_step);
    take_count(&mut options.load_steps, given.load_steps, "load_steps")?;
    take_count(&mut options.iterations, given.iterations, "iterations")?;
    take_count(&mut options.products, given.products, "products")?;
    take_count(&mut options.breaks, given.breaks, "breaks")?;
    options.krylov = match given.krylov {
        PERION_KRYLOV_AUTOMATIC => Krylov::Automatic,
        PERION_KRYLOV_CONJUGATE_GRADIENTS => Krylov::ConjugateGradients,
        PERION_KRYLOV_MINIMAL_RESIDUALS => Krylov::MinimalResiduals,
        PERION_KRYLOV_GENERALISED_MINIMAL_RESIDUALS => Krylov::GeneralisedMinimalResiduals,
        other => {
            return Ok(argument(format!(
                "'krylov' is {other}; it must be one of the PERION_KRYLOV_ constants, 0 to 3"
            ))?);
        }
    };
    options.preconditioning = match given.preconditioner {
        PERION_PRECONDITIONER_GLOBAL => Preconditioning::Global,
        PERION_PRECONDITIONER_BLOCK_DIAGONAL => Preconditioning::BlockDiagonal,
        PERION_PRECONDITIONER_NONE => Preconditioning::None,
        other => {
            return Ok(argument(format!(
                "'preconditioner' is {other}; it must be one of the PERION_PRECONDITIONER_ constants, 0 to 2"
            ))?);
        }
    };
    Ok(options)
}

/// As [`solve_options`].
///
/// # Safety
/// As for [`solve_options`].
unsafe fn relax_options(
    relax_options_or_null: *const perion_relax_options,
) -> Result<RelaxOptions, Failure> {
    let mut options = RelaxOptions::default();
    if relax_options_or_null.is_null() {
        return Ok(options);
    }
    let unset = perion_relax_options {
        struct_size: 0,
        tolerance: 0.0,
        energy_tolerance: 0.0,
        steps: 0,
        ramp: 0,
        breaks: 0,
    };
    // SAFETY: the caller's promise.
    let given = unsafe { sized::read(relax_options_or_null, unset, "relax_options") }?;
    take(&mut options.tolerance, given.tolerance);
    take(&mut options.energy_tolerance, given.energy_tolerance);
    take_count(&mut options.steps, given.steps, "steps")?;
    take_count(&mut options.ramp, given.ramp, "ramp")?;
    take_count(&mut options.breaks, given.breaks, "breaks")?;
    Ok(options)
}
