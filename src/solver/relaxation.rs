//! Adaptive dynamic relaxation (Kilic and Madenci 2010): motions of another mass, damped so that they die away.
//!
//! Masses follow the stiffness of each point, scaled by the largest eigenvalue of the forces as they are, so that a
//! pseudo time step of 1 is stable in every formulation. Damping follows the frequency that the motion shows.

use super::balance::{Balance, PURPOSE, Stop, Trial};
use super::newton_krylov::{Ended, Reason};
use super::space::largest;
use super::time_step::largest_eigenvalue;
use crate::error::Result;
use crate::families::Property;
use crate::memory;

/// Products by which the largest eigenvalue is found.
const PRODUCTS: usize = 25;

/// What is kept below the limit of stability, for stiffness that grows on the way.
const MARGIN: f64 = 1.1;

/// A mass is at least this share of the mean, so that what hardly has bonds does not fly.
const LEAST: f64 = 1e-3;

/// Damping stays below critical damping of the fastest motion.
const MOST_DAMPING: f64 = 1.9;

/// A residual so many times the first is a run that diverges: masses are doubled, so often at most.
const DIVERGED: f64 = 1e4;
const DOUBLINGS: usize = 6;

/// When relaxation ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Goal {
    /// Residual over loads or reactions.
    pub(crate) tolerance: f64,
    /// Energy of the motion over the largest that it had.
    pub(crate) energy_tolerance: f64,
    pub(crate) steps: usize,
    /// Steps over which what is held is moved.
    pub(crate) ramp: usize,
}

/// What has been seen, step by step.
pub(crate) struct Seen<'a> {
    /// Size of loads and reactions before and after.
    pub(crate) forces: f64,
    pub(crate) residuals: &'a mut Vec<f64>,
    /// Energy of the motion over the largest that it had.
    pub(crate) energies: &'a mut Vec<f64>,
    /// Steps made.
    pub(crate) steps: &'a mut u64,
}

/// A relaxation on its way to the equilibrium of a displacement.
pub(crate) struct Relaxation {
    /// The displacement at its beginning.
    start: Vec<f64>,
    masses: Vec<f64>,
    doublings: usize,
    motion: Motion,
}

/// The damped motion, after so many steps.
struct Motion {
    step: usize,
    velocity: Vec<f64>,
    residual: Vec<f64>,
    /// Residual of the step before.
    before: Vec<f64>,
    /// The largest residual while held components moved.
    first: f64,
    /// The largest energy so far.
    most: f64,
}

/// What a step has come to.
enum Stepped {
    On,
    Diverged,
    Ended(Ended),
}

impl Relaxation {
    pub(crate) fn new(balance: &mut Balance<'_>, displacement: &[f64]) -> Result<Self> {
        Ok(Self {
            start: memory::copied(displacement, PURPOSE)?,
            masses: masses(balance, displacement)?,
            doublings: 0,
            motion: Motion::new(balance)?,
        })
    }

    /// Steps that are left to it, as it looks now.
    pub(crate) fn left(&self, goal: &Goal) -> u64 {
        goal.steps.saturating_sub(self.motion.step) as u64
    }

    /// Moves the displacement by so many steps, its held components by `push`, if any; `None` where there is more to do.
    pub(crate) fn go_on(
        &mut self,
        balance: &mut Balance<'_>,
        goal: &Goal,
        (displacement, push): (&mut [f64], Option<&[f64]>),
        seen: &mut Seen<'_>,
        steps: usize,
    ) -> Result<Option<Ended>> {
        for _ in 0..steps {
            let Self { start, masses, motion, .. } = self;
            match motion.step(balance, goal, (displacement, push), (start, masses), seen) {
                Ok(Stepped::On) => *seen.steps += 1,
                Ok(Stepped::Ended(ended)) => return Ok(Some(ended)),
                Err(Stop::Error(error)) => return Err(error),
                Ok(Stepped::Diverged) | Err(Stop::NotFinite(_)) => {
                    if self.doublings == DOUBLINGS {
                        return Ok(Some(Ended::Failed(Reason::Diverged)));
                    }
                    self.doublings += 1;
                    masses.iter_mut().for_each(|mass| *mass *= 2.0);
                    displacement.copy_from_slice(start);
                    *motion = Motion::new(balance)?;
                }
            }
        }
        Ok(None)
    }
}

/// A mass for each point at which a time step of 1 is stable.
fn masses(balance: &mut Balance<'_>, displacement: &[f64]) -> Result<Vec<f64>> {
    let (plan, workers) = (balance.plan, balance.space.workers);
    let mut own = memory::filled(0.0, plan.count(), PURPOSE)?;
    plan.formulation
        .conventional_stiffness(&plan.scene(workers, balance.bonds, displacement), &mut own);
    let mean = own.iter().sum::<f64>() / own.len() as f64;
    own.iter_mut().for_each(|mass| *mass = mass.max(LEAST * mean));
    let density = Property::PerPoint(own);
    let state = (balance.bonds, displacement);
    let scratch = &mut *balance.scratch;
    let found = largest_eigenvalue(plan, workers, state, scratch, &density, PRODUCTS)?;
    balance.evaluations += PRODUCTS as u64 + 1;
    let Property::PerPoint(mut masses) = density else { return Ok(Vec::new()) };
    for (mass, place) in masses.iter_mut().zip(plan.places()) {
        *mass *= MARGIN * 0.25 * found * place[3];
    }
    Ok(masses)
}

impl Motion {
    fn new(balance: &Balance<'_>) -> Result<Self> {
        let empty = || balance.space.empty();
        let (velocity, residual, before) = (empty()?, empty()?, empty()?);
        Ok(Self { step: 0, velocity, residual, before, first: 0.0, most: 0.0 })
    }

    fn step(
        &mut self,
        balance: &mut Balance<'_>,
        goal: &Goal,
        (displacement, push): (&mut [f64], Option<&[f64]>),
        (start, masses): (&[f64], &[f64]),
        seen: &mut Seen<'_>,
    ) -> Trial<Stepped> {
        let dimension = balance.plan.dimension;
        let Self { step, velocity, residual, before, first, most } = self;
        let ramped = push.is_none() || *step >= goal.ramp;
        if let Some(push) = push
            && (*step < goal.ramp || goal.ramp == 0 && *step == 0)
        {
            let share = 1.0 / goal.ramp.max(1) as f64;
            balance.space.combine(displacement, 1.0, share, push);
        }
        std::mem::swap(residual, before);
        let reaction = balance.residual(displacement, residual)?;
        let size = balance.space.norm(residual);
        let whole = seen.forces.max(reaction);
        let relative = if size == 0.0 { 0.0 } else { size / whole };
        let kinetic = 0.5 * balance.space.weighted_dot(velocity, velocity, |point| masses[point]);
        *most = most.max(kinetic);
        let energy = if kinetic == 0.0 { 0.0 } else { kinetic / *most };
        // In this order: as many energies as residuals there are, should memory end between.
        memory::push(seen.energies, energy, PURPOSE)?;
        memory::push(seen.residuals, relative, PURPOSE)?;
        if ramped && relative <= goal.tolerance && energy <= goal.energy_tolerance {
            return Ok(Stepped::Ended(Ended::Converged { iterations: *step }));
        }
        *first = first.max(if *step <= goal.ramp { size } else { 0.0 });
        if !size.is_finite() || size > DIVERGED * first.max(whole) {
            return Ok(Stepped::Diverged);
        }
        let damping = if *step == 0 {
            0.0
        } else {
            let moved = displacement.iter().zip(start).map(|(is, was)| is - was);
            damping(moved, [residual, before], velocity, masses, dimension)
        };
        let (kept, share) = if *step == 0 {
            (0.0, 0.5)
        } else {
            ((2.0 - damping) / (2.0 + damping), 2.0 / (2.0 + damping))
        };
        for (component, velocity) in velocity.iter_mut().enumerate() {
            *velocity =
                kept * *velocity + share * residual[component] / masses[component / dimension];
        }
        balance.space.combine(displacement, 1.0, 1.0, velocity);
        if !largest(displacement).is_finite() {
            return Ok(Stepped::Diverged);
        }
        *step += 1;
        if *step > goal.steps {
            return Ok(Stepped::Ended(Ended::Failed(Reason::TooMany)));
        }
        Ok(Stepped::On)
    }
}

/// Twice the frequency that Rayleigh's quotient of what has moved shows, with the stiffness that each component had in
/// the last step.
fn damping(
    moved: impl Iterator<Item = f64>,
    [residual, before]: [&[f64]; 2],
    velocity: &[f64],
    masses: &[f64],
    dimension: usize,
) -> f64 {
    let (mut above, mut below) = (0.0, 0.0);
    for (component, moved) in moved.enumerate() {
        let mass = masses[component / dimension];
        if velocity[component] != 0.0 {
            let stiffness =
                (before[component] - residual[component]) / (mass * velocity[component]);
            above += moved * moved * stiffness;
        }
        below += moved * moved;
    }
    let squared: f64 = above / below;
    if squared > 0.0 { (2.0 * squared.sqrt()).min(MOST_DAMPING) } else { 0.0 }
}
