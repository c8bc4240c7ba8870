//! The stable step of velocity Verlet: 2 over the largest frequency.
//!
//! Formulations that know a bound on their stiffness say so. For the others the largest eigenvalue of
//! -rho^-1 db/du at the current displacement is found by Lanczos's iteration in the inner product of the mass,
//! with products by central differences; its residual is the margin.

use crate::damage::BondState;
use crate::error::{Error, Result};
use crate::memory;
use crate::plan::Plan;
use crate::workers::{Workers, block_count};

/// Iterations, of two forces each.
const ITERATIONS: usize = 30;

/// What is kept below the limit for what the differences leave out.
const MARGIN: f64 = 0.98;

/// Differences move points by this share of the mean distance of points.
const MOVE: f64 = 1e-6;

const PURPOSE: &str = "the stable step";

/// A stable step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StableStep {
    pub(crate) step: f64,
    /// It holds at any displacement and whatever breaks, not only at the displacement it was found at.
    pub(crate) holds: bool,
}

pub(crate) fn stable(
    plan: &Plan,
    workers: &Workers,
    bonds: &BondState,
    displacement: &[f64],
    scratch: &mut [f64],
) -> Result<StableStep> {
    let mut bound = memory::filled(0.0, plan.count(), PURPOSE)?;
    let scene = plan.scene(workers, bonds, &[]);
    if plan.formulation.stiffness_bound(&scene, &mut bound) {
        let own = bound.iter().enumerate().map(|(point, bound)| bound / plan.density.at(point));
        let largest = own.fold(0.0, f64::max);
        let step = if largest > 0.0 { 0.99 / largest.sqrt() } else { f64::MAX };
        return Ok(StableStep { step, holds: true });
    }
    let largest = largest_eigenvalue(plan, workers, bonds, displacement, scratch)?;
    let step = if largest > 0.0 { MARGIN * 2.0 / largest.sqrt() } else { f64::MAX };
    Ok(StableStep { step, holds: false })
}

/// An upper estimate of the largest eigenvalue.
fn largest_eigenvalue(
    plan: &Plan,
    workers: &Workers,
    bonds: &BondState,
    displacement: &[f64],
    scratch: &mut [f64],
) -> Result<f64> {
    let (dimension, count) = (plan.dimension, displacement.len());
    let mut partial = memory::filled(0.0, block_count(plan.count()), PURPOSE)?;
    let mut dot = |a: &[f64], b: &[f64]| {
        workers.sum(plan.count(), &mut partial, |point| {
            let own = point * dimension..(point + 1) * dimension;
            let product: f64 = own.map(|component| a[component] * b[component]).sum();
            plan.density.at(point) * plan.places[point][3] * product
        })
    };
    let mut vector = memory::filled(0.0, count, PURPOSE)?;
    let mut before = memory::filled(0.0, count, PURPOSE)?;
    let mut moved = memory::filled(0.0, count, PURPOSE)?;
    let mut force = [memory::filled(0.0, count, PURPOSE)?, memory::filled(0.0, count, PURPOSE)?];
    // Numbers without order that follow from the inner order alone.
    for (component, value) in vector.iter_mut().enumerate() {
        let word = (component as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        *value = ((word ^ word >> 31).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64
            / (1_u64 << 53) as f64
            - 0.5;
    }
    let spacing = spacing(plan);
    let (mut diagonal, mut off) = ([0.0; ITERATIONS], [0.0; ITERATIONS]);
    let mut norm = dot(&vector, &vector).sqrt();
    for turn in 0..ITERATIONS {
        if norm.is_nan() || norm <= 0.0 {
            break;
        }
        vector.iter_mut().for_each(|value| *value /= norm);
        let reach = vector.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let step = MOVE * spacing / reach;
        for (sign, force) in [1.0, -1.0].into_iter().zip(&mut force) {
            for ((moved, at), value) in moved.iter_mut().zip(displacement).zip(&vector) {
                *moved = at + sign * step * value;
            }
            let scene = plan.scene(workers, bonds, &moved);
            if plan.formulation.force(&scene, scratch, force, None).is_some() {
                return Err(Error::Numeric(
                    "the stable step cannot be found, since forces at the current displacement are not \
                     finite"
                        .into(),
                ));
            }
        }
        let [forth, back] = &force;
        for (component, moved) in moved.iter_mut().enumerate() {
            let density = plan.density.at(component / dimension);
            *moved = -(forth[component] - back[component]) / (2.0 * step * density);
        }
        diagonal[turn] = dot(&vector, &moved);
        let last = if turn > 0 { off[turn - 1] } else { 0.0 };
        for (component, moved) in moved.iter_mut().enumerate() {
            *moved -= diagonal[turn] * vector[component] + last * before[component];
        }
        std::mem::swap(&mut before, &mut vector);
        std::mem::swap(&mut vector, &mut moved);
        norm = dot(&vector, &vector).sqrt();
        off[turn] = norm;
        // Nothing new is left of the space that the first vector reaches.
        if norm <= 1e-12 * diagonal[0].abs() {
            return Ok(top(&diagonal[..=turn], &off[..turn]).0);
        }
    }
    let (value, last) = top(&diagonal, &off[..ITERATIONS - 1]);
    Ok(value + off[ITERATIONS - 1] * last)
}

/// The mean distance of points.
fn spacing(plan: &Plan) -> f64 {
    let volume: f64 = plan.places.iter().map(|place| place[3]).sum();
    (volume / plan.count() as f64).powf(1.0 / plan.dimension as f64)
}

/// The largest eigenvalue of a tridiagonal matrix, by bisection, and the size of the last component of its
/// eigenvector.
fn top(diagonal: &[f64], off: &[f64]) -> (f64, f64) {
    let reach = |k: usize| {
        let below = if k > 0 { off[k - 1].abs() } else { 0.0 };
        below + off.get(k).map_or(0.0, |value| value.abs())
    };
    let ends = (0..diagonal.len()).map(|k| (diagonal[k] - reach(k), diagonal[k] + reach(k)));
    let (mut low, mut high) =
        ends.fold((f64::INFINITY, 0.0_f64), |(low, high), (a, b)| (low.min(a), high.max(b)));
    // Whether all eigenvalues are below: by the signs of the pivots.
    let above_all = |value: f64| {
        let mut pivot = value - diagonal[0];
        for k in 1..diagonal.len() {
            if pivot <= 0.0 {
                return false;
            }
            pivot = value - diagonal[k] - off[k - 1] * off[k - 1] / pivot;
        }
        pivot > 0.0
    };
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if above_all(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    let (mut earlier, mut now, mut squares) = (0.0, 1.0, 1.0);
    for k in 0..diagonal.len() - 1 {
        let below = if k > 0 { off[k - 1] * earlier } else { 0.0 };
        let next = ((high - diagonal[k]) * now - below) / off[k];
        (earlier, now) = (now, next);
        squares += now * now;
    }
    (high, now.abs() / squares.sqrt())
}
