//! Equilibrium by adaptive dynamic relaxation.

use super::Simulation;
use super::statics::StaticsReport;
use crate::error::{Result, argument};
use crate::solver::balance::Balance;
use crate::solver::newton_krylov::Ended;
use crate::solver::relaxation::{self, Goal, Seen};

/// How [`Simulation::relax`] looks for equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelaxOptions {
    /// Size of the forces out of balance, over that of loads or reactions, whichever are larger.
    pub tolerance: f64,
    /// Energy of the damped motion, over the largest that it had.
    pub energy_tolerance: f64,
    /// Steps that it may take, each time bonds have broken.
    pub steps: u64,
    /// Steps over which prescribed displacements are applied.
    pub ramp: u64,
    /// How often bonds may break.
    pub breaks: u64,
}

impl Default for RelaxOptions {
    fn default() -> Self {
        Self { tolerance: 1e-6, energy_tolerance: 1e-9, steps: 100_000, ramp: 100, breaks: 200 }
    }
}

impl Simulation {
    /// Finds the equilibrium under the conditions at the current time by adaptive dynamic relaxation: a damped motion with
    /// masses of its own, of one force a step. Loads act at once, displacements are applied over the first steps. Bonds
    /// that the equilibrium would break are broken, for good, and the body relaxes again. The result counts as one
    /// completed step, at which the body is at rest; the time stands still.
    ///
    /// # Errors
    /// `Argument` for options out of range; `State` where a velocity is prescribed; `Convergence` when the steps do not
    /// lead there: the simulation is as the last completed step left it; `Numeric`, `Interrupted`, `Memory` as
    /// [`Simulation::step`].
    pub fn relax(&mut self, options: &RelaxOptions) -> Result<StaticsReport> {
        let mut report = StaticsReport::default();
        self.relax_into(options, &mut report)?;
        Ok(report)
    }

    /// Refuses what a relaxation cannot begin with.
    pub(crate) fn check_relaxing(&self, options: &RelaxOptions) -> Result<()> {
        options.goal()?;
        self.conditions.check_at_rest()
    }

    /// As [`Simulation::relax`]; the report also tells of a run that failed.
    ///
    /// # Errors
    /// As [`Simulation::relax`].
    pub fn relax_into(&mut self, options: &RelaxOptions, report: &mut StaticsReport) -> Result<()> {
        *report =
            StaticsReport { time: self.state.time, evaluations: 1, ..StaticsReport::default() };
        let goal = options.goal()?;
        let way = self.prepare_statics(self.state.time)?;
        let acting = way.at(self, 1.0)?;
        let before = self.state.ledger.work;
        let StaticsReport { residuals, energies, evaluations, iterations, .. } = report;
        let mut balancer = |balance: &mut Balance<'_>,
                            displacement: &mut [f64],
                            push: Option<&[f64]>,
                            forces: f64| {
            let (residuals, energies) = (&mut *residuals, &mut *energies);
            let mut seen = Seen { forces, residuals, energies };
            let ended = relaxation::relax(balance, &goal, (displacement, push), &mut seen)?;
            if let Ended::Converged { iterations: made } = ended {
                *iterations += made as u64;
            }
            Ok(ended)
        };
        let found = self.find_equilibrium(&acting, options.breaks, &mut balancer, evaluations)?;
        let found = match found {
            Ok(found) => found,
            Err(reason) => return Err(self.not_converged(&reason, 0.0, &report.residuals)),
        };
        report.broken_bonds = found.broken;
        self.accept_equilibrium(acting, found)?;
        (report.steps, report.share) = (1, 1.0);
        report.external_work = self.state.ledger.work - before;
        report.elastic = self.energy()?.elastic;
        Ok(())
    }
}

impl RelaxOptions {
    fn goal(&self) -> Result<Goal> {
        let Self { tolerance, energy_tolerance, steps, .. } = *self;
        for (name, value) in [("tolerance", tolerance), ("energy_tolerance", energy_tolerance)] {
            if !(value > 0.0 && value < 1.0) {
                return argument(format!("'{name}' is {value}; it must lie between 0 and 1"));
            }
        }
        if steps == 0 {
            return argument("'steps' is 0; it must be at least 1");
        }
        let counted = |count: u64| usize::try_from(count).unwrap_or(usize::MAX);
        Ok(Goal { tolerance, energy_tolerance, steps: counted(steps), ramp: counted(self.ramp) })
    }
}
