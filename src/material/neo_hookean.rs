//! Neo-Hooke: W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2, P = mu (F - F^-T) + lambda ln J F^-T.
//!
//! Free directions share a stretch at which their stress is 0: mu (t^2 - 1) + lambda ln J = 0.

use super::{Answer, Deformation, Law};
use crate::tensor::{determinant, identity, inverse, product, scaled, sum, symmetric, trace, zero};

pub(super) fn answer<const D: usize>(law: &Law, deformation: &Deformation<D>) -> Answer<D> {
    let (lambda, mu) = law.solid();
    let (rank, gradient) = (deformation.rank, deformation.full());
    if rank == 0 || deformation.gradient == zero() {
        // Nothing is spanned, and J would be that of nothing; or nothing is deformed, to the last bit.
        return Answer { energy: 0.0, stress: zero() };
    }
    let twice_strain = deformation.twice_strain();
    let metric = symmetric(&sum(&deformation.span, &twice_strain));
    // det C - 1 by the invariants of C - 1, which keep their digits where strains are small.
    let squares = trace(&product(&twice_strain, &twice_strain));
    let mut growth = trace(&twice_strain) + 0.5 * (trace(&twice_strain).powi(2) - squares);
    if rank == 3 {
        growth += determinant(&twice_strain);
    }
    // C^-1 in the directions spanned.
    let inverse = if rank == D {
        inverse(&metric)
    } else if rank == 2 {
        let rest = sum(&scaled(&deformation.span, trace(&metric)), &scaled(&metric, -1.0));
        scaled(&rest, 1.0 / (1.0 + growth))
    } else {
        scaled(&deformation.span, 1.0 / trace(&metric))
    };
    let inside_out = rank == D && determinant(&gradient) <= 0.0;
    // ln J in the directions spanned.
    let in_plane = if inside_out { f64::NAN } else { 0.5 * growth.ln_1p() };
    let free = f64::from(law.free[rank]);
    let across = if free > 0.0 { free_stretch(lambda / mu, in_plane, free) } else { 0.0 };
    let volume_change = in_plane + free * across;
    let energy = 0.5 * mu * (trace(&twice_strain) + free * (2.0 * across).exp_m1())
        - mu * volume_change
        + 0.5 * lambda * volume_change * volume_change;
    let pull = sum(&scaled(&identity(), mu), &scaled(&inverse, lambda * volume_change - mu));
    Answer { energy, stress: product(&gradient, &pull) }
}

/// Logarithm x of the stretch of the free directions: e^2x - 1 + ratio (in_plane + free x) = 0, which grows
/// with x where ratio >= 0. Not a number where none is found.
pub(super) fn free_stretch(ratio: f64, in_plane: f64, free: f64) -> f64 {
    let (mut x, mut last) = (-ratio * in_plane / (2.0 + ratio * free), f64::INFINITY);
    for _ in 0..50 {
        let value = (2.0 * x).exp_m1() + ratio * (in_plane + free * x);
        let step = value / (2.0 * (2.0 * x).exp() + ratio * free);
        x -= step;
        if step.abs() <= 1e-16 * (1.0 + x.abs()) {
            return x;
        }
        last = step.abs();
    }
    // Rounding may go on; with lambda < 0 there may be no such stretch.
    if last <= 1e-9 * (1.0 + x.abs()) { x } else { f64::NAN }
}

/// J in the directions spanned: negative where a deformation of the whole body is turned inside out.
pub(super) fn jacobian<const D: usize>(deformation: &Deformation<D>) -> f64 {
    if deformation.rank == D {
        return determinant(&deformation.full());
    }
    let metric = sum(&deformation.span, &deformation.twice_strain());
    if deformation.rank == 1 {
        return trace(&metric).sqrt();
    }
    (0.5 * (trace(&metric).powi(2) - trace(&product(&metric, &metric)))).sqrt()
}
