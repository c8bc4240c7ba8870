//! Equilibrium by Newton's method, load step by load step.

use super::drive::{Progress, stopped};
use super::statics::{Acting, Standing, StaticsReport, Way, told};
use super::{LogLevel, Simulation};
use crate::error::{Result, argument};
use crate::solver::balance::Balance;
use crate::solver::newton_krylov::preconditioner::{Preconditioner, Preconditioning};
use crate::solver::newton_krylov::{self, Ended, Krylov, Limits, Reason, Scale};

/// A load step of so many linear systems was easy.
const EASY: usize = 5;

/// How [`Simulation::solve`] looks for equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveOptions {
    /// Time at the end, along which tables and functions are asked; the current time if not given.
    pub time_end: Option<f64>,
    /// Size of the forces out of balance, over that of loads or reactions, whichever are larger.
    pub tolerance: f64,
    /// Load steps, equally long; they are cut where one fails, and as long again where they are easy.
    pub load_steps: u64,
    /// Share of the way that a load step has at least.
    pub smallest_load_step: f64,
    /// Linear systems that a load step may take, each time bonds have broken.
    pub iterations: u64,
    /// Products of the stiffness with a vector that a linear system may take, each of one force.
    pub products: u64,
    /// How often bonds may break within a load step.
    pub breaks: u64,
    /// The method for linear systems.
    pub krylov: Krylov,
    /// How they are preconditioned.
    pub preconditioning: Preconditioning,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self {
            time_end: None,
            tolerance: 1e-8,
            load_steps: 1,
            smallest_load_step: 1e-3,
            iterations: 25,
            products: 2000,
            breaks: 200,
            krylov: Krylov::default(),
            preconditioning: Preconditioning::default(),
        }
    }
}

/// A search on its way; see [`Simulation::start_solving`].
pub struct Solving {
    options: SolveOptions,
    way: Way,
    share: f64,
    step: f64,
    work: f64,
    preconditioner: Option<Preconditioner>,
    report: StaticsReport,
}

impl Solving {
    /// What it has done so far.
    pub fn report(&self) -> &StaticsReport {
        &self.report
    }
}

impl Simulation {
    /// Finds the equilibrium under the conditions by Newton's method on the forces, going on from the last completed
    /// step. Constants go linearly from what they were to what they are, tables and functions are asked along the time
    /// to [`SolveOptions::time_end`]. Bonds that an equilibrium would break are broken, for good, and equilibrium is
    /// looked for again; materials remember at the end of each load step, which counts as a completed step. The body is
    /// at rest afterwards.
    ///
    /// # Errors
    /// `Argument` for options out of range; `State` where a velocity is prescribed; `Convergence` when load steps have
    /// been cut to the smallest without success: the text has reason and residuals, the simulation is as the last load
    /// step that succeeded left it; `Numeric`, `Interrupted`, `Memory` as [`Simulation::step`].
    pub fn solve(&mut self, options: &SolveOptions) -> Result<StaticsReport> {
        let mut run = self.start_solving(options)?;
        while self.continue_solving(&mut run)?.is_some() {}
        Ok(run.report)
    }

    /// As [`Simulation::solve`], calling `progress` after each load step; it can stop the run. The total that it is told
    /// is the number of load steps as it looks then.
    ///
    /// # Errors
    /// As [`Simulation::solve`]; `Interrupted` when `progress` stops the run.
    pub fn solve_watched(
        &mut self,
        options: &SolveOptions,
        mut progress: impl FnMut(&Self, Progress) -> std::ops::ControlFlow<()>,
    ) -> Result<StaticsReport> {
        let mut run = self.start_solving(options)?;
        while let Some(made) = self.continue_solving(&mut run)? {
            if progress(self, made).is_break() {
                return Err(stopped(made));
            }
        }
        Ok(run.report)
    }

    /// Begins a run that [`Simulation::continue_solving`] makes, for hosts that need their simulation between load
    /// steps.
    ///
    /// # Errors
    /// As [`Simulation::solve`].
    pub fn start_solving(&mut self, options: &SolveOptions) -> Result<Solving> {
        options.check(self.state.time)?;
        let way = self.prepare_statics(options.time_end.unwrap_or(self.state.time))?;
        let report =
            StaticsReport { time: self.state.time, evaluations: 1, ..StaticsReport::default() };
        Ok(Solving {
            options: *options,
            way,
            share: 0.0,
            step: 1.0 / options.load_steps as f64,
            work: self.state.ledger.work,
            preconditioner: None,
            report,
        })
    }

    /// The way to the conditions, from a state that is up to date.
    pub(super) fn prepare_statics(&mut self, end: f64) -> Result<Way> {
        self.conditions.check_at_rest()?;
        self.built()?;
        self.prepare_steps()?;
        if self.state.host_load.is_some() {
            self.state.make_room_for_loads()?;
        }
        Way::new(self, end)
    }

    /// Makes the next load step. Gives where the run stands, `None` when it was complete already.
    ///
    /// # Errors
    /// As [`Simulation::solve`].
    pub fn continue_solving(&mut self, run: &mut Solving) -> Result<Option<Progress>> {
        if run.share >= 1.0 {
            return Ok(None);
        }
        loop {
            let rest = 1.0 - run.share;
            let share = if run.step >= (1.0 - 1e-9) * rest { 1.0 } else { run.share + run.step };
            let acting = run.way.at(self, share)?;
            let first = run.report.residuals.len();
            match self.load_step(run, acting)? {
                Ok(iterations) => {
                    run.share = share;
                    // Few iterations, and what was cut may be longer again.
                    if iterations <= EASY {
                        run.step = (1.5 * run.step).min(1.0 / run.options.load_steps as f64);
                    }
                    break;
                }
                Err(reason) => {
                    run.report.cuts += 1;
                    let tried = share - run.share;
                    run.step = 0.5 * tried;
                    if run.step < run.options.smallest_load_step {
                        return Err(self.not_converged(
                            &reason,
                            run.share,
                            &run.report.residuals[first..],
                        ));
                    }
                    self.tell(
                        LogLevel::Information,
                        &format!(
                            "solve: a load step of {tried:.3e} of the way is cut: {}",
                            told(&reason, &self.points.order().host)
                        ),
                    );
                }
            }
        }
        run.report.steps += 1;
        run.report.share = run.share;
        run.report.time = self.state.time;
        run.report.external_work = self.state.ledger.work - run.work;
        if run.share >= 1.0 {
            run.report.elastic = self.energy()?.elastic;
        }
        let StaticsReport { share, evaluations, residuals, .. } = &run.report;
        let residual = residuals.last().copied().unwrap_or(0.0);
        self.tell(
            LogLevel::Information,
            &format!(
                "solve: {share:.4} of the way, residual {residual:.2e}, {evaluations} forces so far"
            ),
        );
        let left = ((1.0 - run.share) / run.step).ceil().max(0.0) as u64;
        let done = run.report.steps;
        Ok(Some(Progress { done, total: done + left, time: self.state.time }))
    }

    /// One load step; gives the iterations that it took, or why it failed.
    fn load_step(
        &mut self,
        run: &mut Solving,
        acting: Acting,
    ) -> Result<std::result::Result<usize, Reason>> {
        let Solving { options, preconditioner, report, .. } = run;
        let limits = options.limits();
        let mut most = 0;
        let mut iterations = 0;
        let StaticsReport { residuals, evaluations, .. } = report;
        let mut balancer = |balance: &mut Balance<'_>,
                            displacement: &mut [f64],
                            push: Option<&[f64]>,
                            forces: f64| {
            let fits = preconditioner.take().filter(|known| {
                known.fits(balance.plan, balance.bonds, displacement, balance.held)
            });
            let known = match fits {
                Some(known) => known,
                None => Preconditioner::new(
                    options.preconditioning,
                    balance.plan,
                    balance.space.workers,
                    balance.bonds,
                    displacement,
                    balance.held,
                )?,
            };
            let known = preconditioner.insert(known);
            let mut scale = Scale { forces, history: &mut *residuals };
            let ended =
                newton_krylov::converge(balance, known, &limits, (displacement, push), &mut scale)?;
            if let Ended::Converged { iterations: made } = ended {
                most = most.max(made);
                iterations += made as u64;
            }
            Ok(Some(ended))
        };
        let mut search = self.start_search(acting, options.breaks)?;
        let standing = loop {
            match self.continue_search(&mut search, &mut balancer, evaluations)? {
                Standing::OnItsWay => {}
                standing => break standing,
            }
        };
        report.iterations += iterations;
        if let Standing::Failed(reason) = standing {
            return Ok(Err(reason));
        }
        report.broken_bonds += search.broken;
        self.accept_equilibrium(search)?;
        Ok(Ok(most))
    }
}

impl SolveOptions {
    fn check(&self, time: f64) -> Result<()> {
        let Self { time_end, tolerance, load_steps, smallest_load_step, .. } = *self;
        if let Some(end) = time_end
            && !(end.is_finite() && end >= time)
        {
            return argument(format!(
                "'time_end' is {end}; it must be finite and not before the current time, {time}"
            ));
        }
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return argument(format!("'tolerance' is {tolerance}; it must lie between 0 and 1"));
        }
        if !(smallest_load_step > 0.0 && smallest_load_step <= 1.0) {
            return argument(format!(
                "'smallest_load_step' is {smallest_load_step}; it must be above 0 and at most 1"
            ));
        }
        for (name, value) in [
            ("load_steps", load_steps),
            ("iterations", self.iterations),
            ("products", self.products),
        ] {
            if value == 0 {
                return argument(format!("'{name}' is 0; it must be at least 1"));
            }
        }
        Ok(())
    }

    fn limits(&self) -> Limits {
        let counted = |count: u64| usize::try_from(count).unwrap_or(usize::MAX);
        Limits {
            tolerance: self.tolerance,
            iterations: counted(self.iterations),
            products: counted(self.products),
            krylov: self.krylov,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;
    use crate::points::Points;
    use crate::simulation::setup::Built;
    use crate::solver::balance::Under;

    /// Against differences of fourth order with a hundredth of a spacing, whose rounding and truncation are both below
    /// 1e-9: the differences that are solved with are good to 1e-6, what a reduction by 1e-4 needs and more.
    #[test]
    fn products_of_the_stiffness_are_good_to_a_millionth() {
        for formulation in ["bond_based", "ordinary_state_based", "bond_associated_quadrature"] {
            let points = Points::block(3, &[0.0; 3], &[6.0, 4.0, 4.0], 1.0).unwrap();
            let mut model = Model::new(formulation).unwrap();
            for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 2.51)] {
                model.set(key, value).unwrap();
            }
            if formulation != "bond_based" {
                model.set("poissons_ratio", 0.3).unwrap();
            }
            let mut body = Simulation::new(&points, &model).unwrap();
            body.built().unwrap();
            let Some(Built { plan, workers, bonds, scratch, .. }) = body.built.get_mut() else {
                panic!("nothing was built");
            };
            let count = plan.count() * plan.dimension;
            let wave = |factor: f64| -> Vec<f64> {
                (0..count).map(|k| 0.02 * (factor * k as f64).sin()).collect()
            };
            let (displacement, v) = (wave(1.3), wave(0.71));
            let (held, load) = (vec![false; count], vec![0.0; count]);
            let under = Under { held: &held, load: &load };
            let mut balance = Balance::new(plan, workers, bonds, scratch, &under).unwrap();
            let mut force = vec![0.0; count];
            let mut product = vec![0.0; count];
            assert!(balance.residual(&displacement, &mut force).is_ok());
            let base = balance.forces.clone();
            assert!(balance.stiffness((&displacement, &base), &v, &mut product).is_ok());
            let mut exact = vec![0.0; count];
            for (steps, weight) in [(1.0, -8.0), (-1.0, 8.0), (2.0, 1.0), (-2.0, -1.0)] {
                let step = 0.02;
                let moved: Vec<f64> =
                    displacement.iter().zip(&v).map(|(u, v)| u + steps * step * v).collect();
                assert!(balance.residual(&moved, &mut force).is_ok());
                for (sum, force) in exact.iter_mut().zip(&force) {
                    *sum += weight * force / (12.0 * step);
                }
            }
            let largest = exact.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let error = exact.iter().zip(&product).map(|(a, b)| (a - b).abs());
            let error = error.fold(0.0, f64::max) / largest;
            println!("{formulation}: {error:.1e}");
            assert!(error < 1e-6, "{formulation}: {error}");
        }
    }
}
