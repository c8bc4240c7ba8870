//! The stable step of a simulation: found when asked for, and kept for what compares with it.

use super::Simulation;
use super::drive::stopped_by_law;
use super::setup::Built;
use crate::error::{Error, Result};
use crate::solver::time_step::StableStep;

/// Steps after which `step` looks whether damage has changed the stable one.
const LOOKS_AFTER: u64 = 100;

impl Simulation {
    /// A time step at which velocity Verlet is stable near the current displacement, with bonds as they are: 2 over the
    /// largest frequency of the forces as they are linear there, less a margin: 2 to 5 percent below the limit. Materials
    /// that flow count with their elastic stiffness. The largest number there is, where no bond acts.
    ///
    /// It costs up to sixty forces, and ten when nothing has changed since it was last asked for than that a few bonds
    /// have broken. Strains, turns of bonds and damage change it: ask again as they grow, or take a part of it (0.8;
    /// half of it where bonds stretch by a tenth and more), or let [`Simulation::advance`] see to it. It promises
    /// nothing for bonds pressed to a fraction of their length: see the smallest stretch in [`Health`](super::Health).
    ///
    /// Where forces have no potential (strong forms, deformed bonds, literal forces, laws with memory and those of the
    /// host) it follows from the eigenvalue of the largest size, and is no guarantee:
    /// [`Health::stable_step_is_guaranteed`](super::Health::stable_step_is_guaranteed) says so.
    ///
    /// # Errors
    /// What building the families can fail with; `Numeric` when forces at the current displacement are not finite, or
    /// when no step is stable: the largest eigenvalue is not real and positive, and motions grow whatever the step.
    pub fn stable_time_step(&mut self) -> Result<f64> {
        let Built { stable_step, bonds, .. } = self.built()?;
        let again = stable_step.as_ref().is_some_and(|known| known.is_near(bonds));
        self.find_stable_step(again, None)?;
        self.stable_step_if_any()
    }

    /// The stable step as it was last found, unless no step is.
    pub(super) fn stable_step_if_any(&self) -> Result<f64> {
        let Some(known) = &self.built()?.stable_step else { return Ok(f64::MAX) };
        match known.unstable {
            None => Ok(known.step),
            Some([real, imaginary]) => Err(Error::Numeric(format!(
                "no time step is stable: forces have no potential here, and the eigenvalue of the largest size of \
                 their slope is {real:.3e} {imaginary:+.3e} i, not the square of a frequency, so that motions grow at \
                 any step"
            ))),
        }
    }

    /// Finds the stable step, going on from the one that is known if `again`, or no more than that a step that is `wanted` is stable.
    pub(super) fn find_stable_step(&mut self, again: bool, wanted: Option<f64>) -> Result<()> {
        self.built()?;
        let Self { state, built, .. } = self;
        let Some(Built { workers, plan, bonds, stable_step, scratch, .. }) = built.get_mut() else {
            return Ok(());
        };
        let displacement = &state.current.displacement;
        let before = (stable_step.as_ref().filter(|_| again), state.steps);
        let found = StableStep::find(plan, workers, bonds, displacement, scratch, before, wanted);
        *stable_step = Some(stopped_by_law(plan).map_or(found, Err)?);
        Ok(())
    }

    /// Whether a stable step is known that suits a time step to be compared with it, that the host has not outdated by changing
    /// bonds, and that is not as old as so many steps: in any case, and where bonds have broken since and make others stiffer.
    pub(super) fn knows_stable_step(
        &self,
        time_step: f64,
        (in_any_case, where_broken): (u64, u64),
    ) -> Result<bool> {
        let built = self.built()?;
        Ok(built.stable_step.as_ref().is_some_and(|known| {
            let age = self.state.steps.saturating_sub(known.found_at);
            let is_outdated = age >= where_broken
                && built.plan.formulation.stiffens_by_damage()
                && known.is_of_more_bonds(&built.bonds);
            known.suits(time_step) && !known.is_stale && age < in_any_case && !is_outdated
        }))
    }

    /// The stable step for a time step to be compared with: found anew when the host or, a while ago, the rule has broken
    /// bonds. Where the time step is far below, it is no more than an estimate that is not below it; for one that is larger than it was
    /// good for, the limit itself.
    pub(super) fn current_stable_step(&mut self, time_step: f64) -> Result<f64> {
        if !self.knows_stable_step(time_step, (u64::MAX, LOOKS_AFTER))? {
            let known = self.built()?.stable_step.as_ref();
            let has_grown = known.is_some_and(|known| !known.suits(time_step));
            let (again, wanted) = (known.is_some(), (!has_grown).then_some(time_step));
            self.find_stable_step(again, wanted)?;
        }
        Ok(self.built()?.stable_step.as_ref().map_or(f64::MAX, |known| known.step))
    }
}
