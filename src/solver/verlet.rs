//! Velocity Verlet with conditions: predict, break, force, correct. [P S0-S5]
//!
//! v_1/2 = v + dt/2 a, u += dt v_1/2, break bonds, b(u), a = (b + b_ext)/rho, v = v_1/2 + dt/2 a.
//! Constrained components get no half-kick and read a = 0. Displacements and velocities at the end of
//! the step are the prescribed ones; v_1/2 is the prescribed velocity at the middle of the step, or
//! what the prescribed displacements amount to.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::conditions::{Conditions, Quantity};
use crate::damage::{Aside, BondState};
use crate::families::Property;
use crate::plan::Plan;
use crate::state::{Kinematics, State};
use crate::workers::{PerBlock, PerPoint, Workers};

/// All that one step reads and writes. Nothing of `current` changes.
pub(crate) struct VerletStep<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) workers: &'a Workers,
    pub(crate) conditions: &'a Conditions,
    pub(crate) bonds: &'a BondState,
    pub(crate) current: &'a Kinematics,
    pub(crate) next: &'a mut Kinematics,
    pub(crate) host_load: Option<&'a [f64]>,
    /// What points have lost by bonds that broke.
    pub(crate) dissipated: &'a [f64],
    pub(crate) aside: &'a mut Aside,
    pub(crate) scratch: &'a mut [f64],
    pub(crate) partial: &'a mut [f64],
    pub(crate) time_step: f64,
}

impl VerletStep<'_> {
    /// Makes the step in `next`. Gives the work of body forces and constraints, or the inner place of
    /// a point whose motion is not finite.
    pub(crate) fn run(mut self) -> Result<f64, usize> {
        self.predict();
        self.force()?;
        let work = self.correct()?;
        Ok(work + self.constrain()?)
    }

    fn dimension(&self) -> usize {
        self.plan.dimension
    }

    fn predict(&mut self) {
        let (dimension, half, step) = (self.dimension(), 0.5 * self.time_step, self.time_step);
        let current = self.current;
        let Kinematics { displacement, velocity, .. } = &mut *self.next;
        let outputs = (PerPoint(displacement, dimension), PerPoint(velocity, dimension));
        self.workers.sweep(self.plan.count(), outputs, |range, (displacement, velocity)| {
            let components = range.start * dimension..range.end * dimension;
            let before = [&current.velocity, &current.acceleration, &current.displacement];
            let [old_velocity, old_acceleration, old_displacement] =
                before.map(|values| values[components.clone()].iter());
            let next = velocity.0.iter_mut().zip(displacement.0);
            let old = old_velocity.zip(old_acceleration).zip(old_displacement);
            for ((midway, place), ((velocity, acceleration), before)) in next.zip(old) {
                *midway = velocity + half * acceleration;
                *place = before + step * *midway;
            }
        });
        let (current, next) = (self.current, &mut *self.next);
        self.conditions.for_each_ruled(dimension, |ruled| {
            let component = ruled.component;
            let before = current.displacement[component];
            if ruled.quantity == Quantity::Displacement {
                next.displacement[component] = ruled.value;
                next.velocity[component] = (ruled.value - before) / step;
            } else {
                next.displacement[component] = before + step * ruled.midway;
                next.velocity[component] = ruled.midway;
            }
        });
    }

    fn force(&mut self) -> Result<(), usize> {
        let Kinematics { displacement, force, .. } = &mut *self.next;
        let scene = self.plan.scene(self.workers, self.bonds, displacement);
        let breaking = self.plan.rule.as_ref().map(|rule| {
            let before = Some(&*self.current.displacement);
            self.aside.breaking(self.workers, rule, (self.bonds, self.dissipated), before)
        });
        self.plan.formulation.force(&scene, self.scratch, force, breaking).map_or(Ok(()), Err)
    }

    /// Ends the half-kick; gives the work of the body forces.
    fn correct(&mut self) -> Result<f64, usize> {
        let (dimension, half) = (self.dimension(), 0.5 * self.time_step);
        let (plan, current, host) = (self.plan, self.current, self.host_load);
        let Kinematics { displacement, velocity, acceleration, force, load } = &mut *self.next;
        let (displacement, force, load) = (&*displacement, &*force, &*load);
        let bad = AtomicUsize::new(usize::MAX);
        let outputs = (
            PerPoint(velocity, dimension),
            PerPoint(acceleration, dimension),
            PerBlock(&mut *self.partial),
        );
        self.workers.sweep(plan.count(), outputs, |range, (velocity, acceleration, work)| {
            let components = range.start * dimension..range.end * dimension;
            let pulls = |values: &[f64]| {
                let bits = values.get(components.clone()).unwrap_or_default().iter();
                bits.fold(0, |bits, value| bits | value.to_bits()) << 1 != 0
            };
            let loaded = pulls(host.unwrap_or_default()) || pulls(load) || pulls(&current.load);
            if let (false, &Property::Uniform(density)) = (loaded, &plan.density) {
                let moves = force[components.clone()].iter().zip(&displacement[components]);
                let next = velocity.0.iter_mut().zip(acceleration.0);
                let mut finite = true;
                for ((velocity, acceleration), (force, displacement)) in next.zip(moves) {
                    *acceleration = force / density;
                    *velocity += half * *acceleration;
                    finite &= velocity.is_finite() & displacement.is_finite();
                }
                if !finite {
                    let of = |point: usize| point * dimension..(point + 1) * dimension;
                    let rests = |point: usize| {
                        let own = of(point - range.start);
                        let mut moving = velocity.0[own].iter().chain(&displacement[of(point)]);
                        moving.all(|component| component.is_finite())
                    };
                    let first = range.clone().find(|&point| !rests(point));
                    bad.fetch_min(first.unwrap_or(range.start), Ordering::Relaxed);
                }
                work.0[0] = 0.0;
                return;
            }
            let mut sum = 0.0;
            for (number, point) in range.enumerate() {
                let (density, volume) = (plan.density.at(point), plan.places()[point][3]);
                for axis in 0..dimension {
                    let (place, component) = (number * dimension + axis, point * dimension + axis);
                    let mut total = force[component];
                    if loaded {
                        let after = State::body_force(host, load, component);
                        let before = State::body_force(host, &current.load, component);
                        let moved = displacement[component] - current.displacement[component];
                        sum += 0.5 * volume * (before + after) * moved;
                        total += after;
                    }
                    acceleration.0[place] = total / density;
                    velocity.0[place] += half * acceleration.0[place];
                    if !(velocity.0[place].is_finite() && displacement[component].is_finite()) {
                        bad.fetch_min(point, Ordering::Relaxed);
                    }
                }
            }
            work.0[0] = sum;
        });
        match bad.into_inner() {
            usize::MAX => Ok(self.partial.iter().sum()),
            point => Err(point),
        }
    }

    /// Puts constrained components right; gives the work of the constraints: that of the reactions
    /// R = -V (b + b_ext), and the kinetic energy that the constraint sets.
    fn constrain(&mut self) -> Result<f64, usize> {
        let (dimension, host, plan) = (self.dimension(), self.host_load, self.plan);
        let (current, next) = (self.current, &mut *self.next);
        let (mut work, mut bad) = (0.0, None);
        self.conditions.for_each_ruled(dimension, |ruled| {
            let component = ruled.component;
            let point = component / dimension;
            let moved = next.displacement[component] - current.displacement[component];
            next.velocity[component] = match ruled.quantity {
                Quantity::Velocity => ruled.value,
                _ => moved / self.time_step,
            };
            next.acceleration[component] = 0.0;
            let acting = |state: &Kinematics| {
                state.force[component] + State::body_force(host, &state.load, component)
            };
            let volume = plan.places()[point][3];
            work -= 0.5 * volume * (acting(current) + acting(next)) * moved;
            let (before, after) = (current.velocity[component], next.velocity[component]);
            work += 0.5 * plan.density.at(point) * volume * (after * after - before * before);
            if !(work.is_finite() && after.is_finite()) {
                bad.get_or_insert(point);
            }
        });
        bad.map_or(Ok(work), Err)
    }
}
