//! Driving a simulation: evaluate and commit for hosts that step themselves, and step.

use std::ops::ControlFlow;

use super::setup::Built;
use super::{LogLevel, Simulation};
use crate::error::{Error, Result, argument};
use crate::plan::Plan;
use crate::solver::verlet::VerletStep;
use crate::state::State;
use crate::workers::PerPoint;

/// Steps more than this many times the stable one are refused.
const LARGEST_RATIO: f64 = 10.0;

/// Where a run of steps stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Steps completed of this run.
    pub done: u64,
    /// Steps of this run.
    pub total: u64,
    /// Time of the last completed step.
    pub time: f64,
}

/// A run of steps on its way; see [`Simulation::start_stepping`].
#[derive(Debug)]
pub struct Stepping {
    time_step: f64,
    done: u64,
    total: u64,
}

impl Simulation {
    /// Computes the internal force at the current displacement, with bonds as they are, and from it
    /// and the loads at the current time the acceleration. Breaks nothing, advances nothing.
    ///
    /// # Errors
    /// `Numeric` when a force is not finite (the text names the point), `Interrupted` when a function
    /// of a condition breaks off, and what building the families can fail with.
    pub fn evaluate(&mut self) -> Result<()> {
        self.built()?;
        if !self.state.force_fresh {
            let Self { state, built, points, .. } = self;
            let Some(Built { workers, plan, bonds, scratch, .. }) = built.get_mut() else {
                return Ok(());
            };
            let scene = plan.scene(workers, bonds, &state.current.displacement);
            let force = &mut state.next.force;
            let failed = plan.formulation.force(&scene, scratch, force, None);
            check_force(plan, failed.map(|point| points.order().host[point]), state.time)?;
            std::mem::swap(&mut state.current.force, &mut state.next.force);
            state.force_fresh = true;
            state.pulled = true;
            state.loads_fresh = false;
        }
        if !self.state.loads_fresh {
            self.refresh_loads()?;
        }
        Ok(())
    }

    /// Asks the loads at the current time, and sums up the acceleration.
    fn refresh_loads(&mut self) -> Result<()> {
        self.spread_tractions()?;
        let Self { state, conditions, built, points, .. } = self;
        let Some(Built { workers, plan, .. }) = built.get_mut() else { return Ok(()) };
        let dimension = plan.dimension;
        if !state.next.load.is_empty() {
            conditions.ask_loads(state.time, dimension, &mut state.next.load)?;
            state.current.load.copy_from_slice(&state.next.load);
        }
        let (force, load) = (&state.current.force, &state.current.load);
        let host = state.host_load.as_deref();
        let acceleration = PerPoint(&mut state.next.acceleration, dimension);
        workers.sweep(plan.count(), acceleration, |range, acceleration| {
            for (place, point) in range.enumerate() {
                for axis in 0..dimension {
                    let component = point * dimension + axis;
                    let total = force[component] + State::body_force(host, load, component);
                    acceleration.0[place * dimension + axis] = total / plan.density.at(point);
                }
            }
        });
        let acceleration = &mut state.next.acceleration;
        if let Some(place) = acceleration.iter().position(|component| !component.is_finite()) {
            let point = points.order().host[place / dimension];
            return Err(not_finite("acceleration", point, state.time));
        }
        conditions.for_each_ruled(dimension, |ruled| acceleration[ruled.component] = 0.0);
        std::mem::swap(&mut state.current.acceleration, &mut state.next.acceleration);
        state.loads_fresh = true;
        Ok(())
    }

    /// Accepts the current displacement as a completed step of a host that steps itself: breaks the
    /// bonds whose stretch is beyond their threshold and moves time on.
    ///
    /// # Errors
    /// `Argument` for a time step that is negative or not finite; `Numeric` when a force is not
    /// finite. The state is unchanged then.
    pub fn commit(&mut self, time_step: f64) -> Result<()> {
        if !(time_step >= 0.0 && (self.state.time + time_step).is_finite()) {
            return argument(format!(
                "'time_step' is {time_step}; it must be finite and not negative"
            ));
        }
        self.built_mut()?;
        self.close_ledger()?;
        let Self { state, built, points, .. } = self;
        let Some(Built { workers, plan, bonds, aside, dissipated, scratch, .. }) = built.get_mut()
        else {
            return Ok(());
        };
        // What breaks, and what materials will remember, comes with the forces.
        if plan.rule.is_some() || !bonds.records.is_empty() {
            let before = (!state.pulled).then_some(&*state.next.displacement);
            let breaking = plan
                .rule
                .as_ref()
                .map(|rule| aside.breaking(workers, rule, (bonds, dissipated), before));
            let scene = plan.scene(workers, bonds, &state.current.displacement);
            let force = &mut state.next.force;
            let failed = plan.formulation.force(&scene, scratch, force, breaking);
            check_force(plan, failed.map(|point| points.order().host[point]), state.time)?;
            if plan.rule.is_some() && aside.accept(bonds, dissipated) {
                state.force_fresh = false;
            }
            bonds.keep_records(scratch);
        }
        state.pulled = true;
        state.time += time_step;
        state.steps += 1;
        state.loads_fresh = false;
        Ok(())
    }

    /// Makes `steps` velocity Verlet steps of `time_step`. Above the stable step it warns. The first call looks whether it is,
    /// and calls with a larger step or after bonds have changed: where forces have a potential that takes some 5 forces at a
    /// hundredth of the stable step, 20 at half of it, up to 60 near it.
    ///
    /// # Errors
    /// `Argument` for a step that is not positive and finite or more than ten times the stable one;
    /// `Numeric` when a force or motion is not finite (the text names the point), `Interrupted` when a
    /// function breaks off. The simulation is then as the last completed step left it.
    pub fn step(&mut self, time_step: f64, steps: u64) -> Result<()> {
        self.step_with(time_step, steps, false, |_, _| ControlFlow::Continue(()))
    }

    /// As [`Simulation::step`], calling `progress` after each step; it can stop the run.
    ///
    /// # Errors
    /// As [`Simulation::step`]; `Interrupted` when `progress` stops the run.
    pub fn step_watched(
        &mut self,
        time_step: f64,
        steps: u64,
        progress: impl FnMut(&Self, Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        self.step_with(time_step, steps, true, progress)
    }

    fn step_with(
        &mut self,
        time_step: f64,
        steps: u64,
        watched: bool,
        mut progress: impl FnMut(&Self, Progress) -> ControlFlow<()>,
    ) -> Result<()> {
        let mut stepping = self.start_stepping(time_step, steps)?;
        while let Some(made) = self.continue_stepping(&mut stepping, watched)? {
            if progress(self, made).is_break() {
                return Err(stopped(made));
            }
        }
        Ok(())
    }

    /// Begins a run of steps that [`Simulation::continue_stepping`] makes, for hosts that need their simulation
    /// between the steps.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn start_stepping(&mut self, time_step: f64, steps: u64) -> Result<Stepping> {
        if !(time_step > 0.0 && time_step.is_finite()) {
            return argument(format!("'time_step' is {time_step}; it must be positive and finite"));
        }
        if !(self.state.time + time_step * steps as f64).is_finite() {
            return argument(format!(
                "'steps' is {steps}: the time would leave the range of numbers"
            ));
        }
        let stable = self.current_stable_step(time_step)?;
        let ratio = time_step / stable;
        if ratio > LARGEST_RATIO {
            return argument(format!(
                "'time_step' is {time_step}, {ratio:.3} times the stable step {stable}; at most \
                 {LARGEST_RATIO} times is accepted"
            ));
        }
        if ratio > 1.0 {
            self.tell(
                LogLevel::Warning,
                &format!(
                    "the time step {time_step} is {ratio:.3} times the step known to be stable, \
                     {stable}; watch the energy"
                ),
            );
        }
        Ok(Stepping { time_step, done: 0, total: steps })
    }

    /// Makes the next step of a run when `single`, else all of them. Gives where the run stands, `None`
    /// when it was complete already.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn continue_stepping(
        &mut self,
        stepping: &mut Stepping,
        single: bool,
    ) -> Result<Option<Progress>> {
        let Stepping { time_step, total, .. } = *stepping;
        if stepping.done == total {
            return Ok(None);
        }
        self.prepare_steps()?;
        let steps = if single { 1 } else { total - stepping.done };
        for _ in 0..steps {
            self.step_once(time_step, self.state.time + time_step)?;
        }
        stepping.done += steps;
        Ok(Some(Progress { done: stepping.done, total, time: self.state.time }))
    }

    /// What steps begin from: the acceleration is up to date, and the energy that is there is known.
    pub(super) fn prepare_steps(&mut self) -> Result<()> {
        self.evaluate()?;
        self.open_ledger()
    }

    /// One step to the time `end`, from a state that is prepared. It is made aside and becomes current
    /// as a whole.
    pub(super) fn step_once(&mut self, time_step: f64, end: f64) -> Result<()> {
        let Self { state, conditions, built, points, .. } = self;
        let Some(built) = built.get_mut() else { return Ok(()) };
        conditions.ask_motion(state.time, time_step)?;
        if conditions.loads_vary() {
            conditions.ask_loads(end, built.plan.dimension, &mut state.next.load)?;
        } else {
            built.workers.copy(&state.current.load, &mut state.next.load);
        }
        let step = VerletStep {
            plan: &built.plan,
            workers: &built.workers,
            conditions,
            bonds: &built.bonds,
            current: &state.current,
            next: &mut state.next,
            host_load: state.host_load.as_deref(),
            dissipated: &built.dissipated,
            aside: &mut built.aside,
            scratch: &mut built.scratch,
            partial: &mut built.partial,
            time_step,
        };
        let made = step.run();
        if let Some(error) = stopped_by_law(&built.plan) {
            return Err(error);
        }
        let work =
            made.map_err(|place| not_finite("motion", points.order().host[place], state.time))?;
        if !work.is_finite() {
            return Err(Error::Numeric(format!(
                "the work of body forces is not finite after time {}; smaller loads may help",
                state.time
            )));
        }
        std::mem::swap(&mut state.current, &mut state.next);
        let Built { plan, bonds, aside, dissipated, scratch, .. } = built;
        if plan.rule.is_some() {
            aside.accept(bonds, dissipated);
        }
        bonds.keep_records(scratch);
        state.ledger.work += work;
        state.time = end;
        state.steps += 1;
        state.last_time_step = time_step;
        Ok(())
    }
}

/// The error of a run that the host's progress callback has stopped.
pub(crate) fn stopped(made: Progress) -> Error {
    Error::Interrupted(format!(
        "the progress callback asked to stop after step {} of {}",
        made.done, made.total
    ))
}

/// Whether a sweep for forces was stopped or has failed at a point.
fn check_force(plan: &Plan, failed: Option<u32>, time: f64) -> Result<()> {
    match (stopped_by_law(plan), failed) {
        (Some(error), _) => Err(error),
        (None, Some(point)) => Err(not_finite("force", point, time)),
        (None, None) => Ok(()),
    }
}

/// The error of a call that a law of the host's has stopped.
pub(super) fn stopped_by_law(plan: &Plan) -> Option<Error> {
    let text = "the material's function asked to stop";
    plan.formulation.was_stopped().then(|| Error::Interrupted(text.into()))
}

/// The error that names a point, by the host's index, whose `what` is not finite.
fn not_finite(what: &str, point: u32, time: f64) -> Error {
    Error::Numeric(format!(
        "the {what} on point {point} is not finite after time {time}; a smaller time step or smaller \
         loads may help"
    ))
}
