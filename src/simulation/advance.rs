//! Advancing to a time with steps that follow the stable one.

use std::ops::ControlFlow;

use super::Simulation;
use super::drive::{Progress, stopped};
use crate::error::{Error, Result, argument};

/// How [`Simulation::advance`] chooses its steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdvanceOptions {
    /// Time step over the stable one, above 0 and at most 1.
    pub safety: f64,
    /// Steps are never longer than this.
    pub largest_time_step: f64,
    /// Steps after which the stable one is found anew, at the cost of ten forces; after a quarter of them when bonds have
    /// broken.
    pub interval: u64,
}

impl Default for AdvanceOptions {
    fn default() -> Self {
        Self { safety: 0.8, largest_time_step: f64::INFINITY, interval: 100 }
    }
}

/// What a run has done.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Report {
    /// Steps completed.
    pub steps: u64,
    /// How often the stable step was found.
    pub estimates: u64,
    /// The smallest and the largest time step, 0 when none was made.
    pub smallest_time_step: f64,
    /// See above.
    pub largest_time_step: f64,
    /// The stable step as it was last found.
    pub stable_time_step: f64,
    /// Time of the last completed step.
    pub time: f64,
}

/// A run on its way; see [`Simulation::start_advancing`].
#[derive(Debug)]
pub struct Advancing {
    until: f64,
    options: AdvanceOptions,
    time_step: f64,
    /// Steps of this length up to `until`.
    left: u64,
    /// Steps before the stable one is looked at again.
    before_look: u64,
    report: Report,
}

impl Advancing {
    /// What it has done so far.
    pub fn report(&self) -> Report {
        self.report
    }
}

impl Simulation {
    /// Makes velocity Verlet steps up to the time `until`, and lands on it exactly. Steps are a share of the stable step,
    /// which is found anew on the way.
    ///
    /// # Errors
    /// `Argument` for a time that is not finite or lies before the current one, a safety outside 0 to 1, a largest step
    /// that is not positive or an interval of 0; `Numeric` when a motion is not finite or no step is stable;
    /// `Interrupted` when a function breaks off. The simulation is then as the last completed step left it.
    pub fn advance(&mut self, until: f64, options: &AdvanceOptions) -> Result<Report> {
        let mut run = self.start_advancing(until, options)?;
        while self.continue_advancing(&mut run, false)?.is_some() {}
        Ok(run.report)
    }

    /// As [`Simulation::advance`], calling `progress` after each step; it can stop the run. The total that it is told is
    /// the number of steps as it looks then.
    ///
    /// # Errors
    /// As [`Simulation::advance`]; `Interrupted` when `progress` stops the run.
    pub fn advance_watched(
        &mut self,
        until: f64,
        options: &AdvanceOptions,
        mut progress: impl FnMut(&Self, Progress) -> ControlFlow<()>,
    ) -> Result<Report> {
        let mut run = self.start_advancing(until, options)?;
        while let Some(made) = self.continue_advancing(&mut run, true)? {
            if progress(self, made).is_break() {
                return Err(stopped(made));
            }
        }
        Ok(run.report)
    }

    /// Begins a run that [`Simulation::continue_advancing`] makes, for hosts that need their simulation between the
    /// steps.
    ///
    /// # Errors
    /// As [`Simulation::advance`].
    pub fn start_advancing(&mut self, until: f64, options: &AdvanceOptions) -> Result<Advancing> {
        let AdvanceOptions { safety, largest_time_step, interval } = *options;
        let time = self.state.time;
        if !(until.is_finite() && until >= time) {
            return argument(format!(
                "'until' is {until}; it must be finite and not before the current time, {time}"
            ));
        }
        if !(safety > 0.0 && safety <= 1.0) {
            return argument(format!("'safety' is {safety}; it must be above 0 and at most 1"));
        }
        if largest_time_step.is_nan() || largest_time_step <= 0.0 {
            return argument(format!(
                "'largest_time_step' is {largest_time_step}; it must be positive"
            ));
        }
        if interval == 0 {
            return argument("'interval' is 0; it must be at least 1");
        }
        self.built()?;
        let report = Report { time, ..Report::default() };
        Ok(Advancing { until, options: *options, time_step: 0.0, left: 0, before_look: 0, report })
    }

    /// Makes the next step of a run when `single`, else as many as there are before the stable step is looked at again.
    /// Gives where the run stands, `None` when it was complete already.
    ///
    /// # Errors
    /// As [`Simulation::advance`].
    pub fn continue_advancing(
        &mut self,
        run: &mut Advancing,
        single: bool,
    ) -> Result<Option<Progress>> {
        if self.state.time >= run.until {
            return Ok(None);
        }
        if run.before_look == 0 {
            self.choose_step(run)?;
        }
        self.prepare_steps()?;
        for _ in 0..if single { 1 } else { run.before_look } {
            let end = if run.left == 1 { run.until } else { self.state.time + run.time_step };
            self.step_once(run.time_step, end)?;
            run.left -= 1;
            run.before_look -= 1;
            let Report { steps, smallest_time_step: smallest, .. } = run.report;
            let smallest = if steps == 0 { run.time_step } else { smallest.min(run.time_step) };
            run.report.smallest_time_step = smallest;
            run.report.largest_time_step = run.report.largest_time_step.max(run.time_step);
            run.report.steps += 1;
            run.report.time = end;
        }
        let done = run.report.steps;
        Ok(Some(Progress { done, total: done + run.left, time: self.state.time }))
    }

    /// Looks whether the stable step is to be found anew, and cuts what is left into equal steps.
    fn choose_step(&mut self, run: &mut Advancing) -> Result<()> {
        let AdvanceOptions { safety, largest_time_step, interval } = run.options;
        let soon = interval.div_ceil(4);
        // What the host has moved since is another body.
        let is_known = self.knows_stable_step(f64::INFINITY, (interval, soon))?;
        if !(self.state.force_fresh && is_known) {
            self.find_stable_step(self.built()?.stable_step.is_some(), None)?;
            run.report.estimates += 1;
        }
        let stable = self.stable_step_if_any()?;
        run.report.stable_time_step = stable;
        let span = run.until - self.state.time;
        let longest = (safety * stable).min(largest_time_step);
        let mut count = (span / longest).ceil().max(1.0);
        if span / count > longest {
            count += 1.0;
        }
        run.time_step = span / count;
        if self.state.time + run.time_step == self.state.time {
            return Err(Error::Numeric(format!(
                "'until' is {}: steps of {} are lost in the rounding of the time {}",
                run.until, run.time_step, self.state.time
            )));
        }
        run.left = count as u64;
        run.before_look = run.left.min(soon);
        Ok(())
    }
}
