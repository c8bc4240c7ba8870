//! Equilibrium by adaptive dynamic relaxation.

use std::ops::ControlFlow;

use super::drive::{Progress, stopped};
use super::statics::{Search, Standing, StaticsReport};
use super::{LogLevel, Simulation};
use crate::error::{Result, argument};
use crate::solver::balance::Balance;
use crate::solver::relaxation::{Goal, Relaxation, Seen};

/// Steps between two lines of the log.
const TOLD: usize = 100;

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

/// A relaxation on its way. The simulation must not change before it has ended.
pub(crate) struct Relaxing {
    goal: Goal,
    /// `None` once it has ended.
    search: Option<Search>,
    /// Of the balance that is looked for now.
    relaxation: Option<Relaxation>,
    work: f64,
    report: StaticsReport,
}

impl Relaxing {
    /// What it has done so far.
    pub(crate) fn report(&self) -> &StaticsReport {
        &self.report
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
        let mut run = self.start_relaxing(options)?;
        while self.continue_relaxing(&mut run, false)?.is_some() {}
        Ok(run.report)
    }

    /// As [`Simulation::relax`], calling `progress` after each force of the motion; it can stop the run, and sees the
    /// simulation as it was before, in the last call at rest. The total that it is told is the number of steps that the run
    /// may come to, as it looks then: more where bonds break. The report also tells of a run that failed or was stopped.
    ///
    /// # Errors
    /// As [`Simulation::relax`]; `Interrupted` when `progress` stops the run.
    pub fn relax_watched(
        &mut self,
        options: &RelaxOptions,
        report: &mut StaticsReport,
        mut progress: impl FnMut(&Self, Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        *report = StaticsReport::default();
        let mut run = self.start_relaxing(options)?;
        let ended = loop {
            match self.continue_relaxing(&mut run, true) {
                Ok(Some(made)) if progress(self, made).is_break() => break Err(stopped(made)),
                Ok(Some(_)) => {}
                Ok(None) => break Ok(()),
                Err(error) => break Err(error),
            }
        };
        *report = run.report;
        ended
    }

    /// Begins a run that [`Simulation::continue_relaxing`] makes, for hosts that need their simulation between steps.
    pub(crate) fn start_relaxing(&mut self, options: &RelaxOptions) -> Result<Relaxing> {
        let goal = options.goal()?;
        let way = self.prepare_statics(self.state.time)?;
        let acting = way.at(self, 1.0)?;
        let report =
            StaticsReport { time: self.state.time, evaluations: 1, ..StaticsReport::default() };
        let work = self.state.ledger.work;
        let search = Some(self.start_search(acting, options.breaks)?);
        Ok(Relaxing { goal, search, relaxation: None, work, report })
    }

    /// Makes the next step of the motion, or some. Gives where the run stands, `None` when it was complete already.
    pub(crate) fn continue_relaxing(
        &mut self,
        run: &mut Relaxing,
        single: bool,
    ) -> Result<Option<Progress>> {
        let Relaxing { goal, search, relaxation, work, report } = run;
        let Some(mut found) = search.take() else { return Ok(None) };
        let StaticsReport { residuals, energies, evaluations, iterations, .. } = report;
        let before = residuals.len();
        let steps = if single { 1 } else { TOLD - before % TOLD };
        let mut balancer = |balance: &mut Balance<'_>,
                            displacement: &mut [f64],
                            push: Option<&[f64]>,
                            forces: f64| {
            let known = match relaxation {
                Some(known) => known,
                None => relaxation.insert(Relaxation::new(balance, displacement)?),
            };
            let mut seen = Seen {
                forces,
                residuals: &mut *residuals,
                energies: &mut *energies,
                steps: &mut *iterations,
            };
            let ended = known.go_on(balance, goal, (displacement, push), &mut seen, steps)?;
            if ended.is_some() {
                *relaxation = None;
            }
            Ok(ended)
        };
        let standing = self.continue_search(&mut found, &mut balancer, evaluations)?;
        report.broken_bonds = found.broken;
        let done = report.residuals.len();
        if done / TOLD > before / TOLD
            && let Some(residual) = report.residuals.last()
        {
            let broken = report.broken_bonds;
            self.tell(
                LogLevel::Information,
                &format!(
                    "relax: residual {residual:.2e} after {done} steps, {broken} bonds broken"
                ),
            );
        }
        let left = match standing {
            Standing::Failed(reason) => {
                return Err(self.not_converged(&reason, 0.0, &report.residuals));
            }
            Standing::OnItsWay => {
                *search = Some(found);
                relaxation.as_ref().map_or(goal.steps as u64, |known| known.left(goal))
            }
            Standing::Reached => {
                self.accept_equilibrium(found)?;
                (report.steps, report.share) = (1, 1.0);
                report.external_work = self.state.ledger.work - *work;
                report.elastic = self.energy()?.elastic;
                0
            }
        };
        let total = report.iterations.saturating_add(left);
        Ok(Some(Progress { done: report.iterations, total, time: self.state.time }))
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
