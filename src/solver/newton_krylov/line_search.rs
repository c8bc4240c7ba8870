//! How far to go along a direction: as far as forces come closer to balance.

use crate::solver::balance::{Balance, Stop, Trial};

/// Steps tried, each at most half of the one before.
const TRIES: usize = 8;

/// Share of what a linear body would win that is enough.
const ENOUGH: f64 = 1e-4;

/// Moves `displacement`, and gives the size of the reactions there; `None`, and nothing moved, where no step helps.
/// `residual` comes as at the start, of size `size`.
///
/// A step is taken where the residual falls, or, with a potential, where what is left of the force along the direction
/// is small: a bar that turns is pulled long on the way.
pub(super) fn search(
    balance: &mut Balance<'_>,
    displacement: &mut [f64],
    direction: &[f64],
    residual: &mut [f64],
    size: f64,
) -> Trial<Option<f64>> {
    let has_potential = balance.plan.formulation.has_potential();
    let along = balance.space.dot(direction, residual);
    let mut trial = balance.space.empty()?;
    let mut step = 1.0;
    for _ in 0..TRIES {
        trial.copy_from_slice(displacement);
        balance.space.combine(&mut trial, 1.0, step, direction);
        let found = match balance.residual(&trial, residual) {
            Ok(reaction) => Some(reaction),
            Err(Stop::NotFinite(_)) => None,
            Err(stop) => return Err(stop),
        };
        let mut shorter = 0.5;
        if let Some(reaction) = found {
            let now = balance.space.norm(residual);
            let still = balance.space.dot(direction, residual);
            let falls = now <= (1.0 - ENOUGH * step) * size;
            let settles = has_potential && along > 0.0 && still.abs() <= 0.5 * along;
            if now.is_finite() && (falls || settles) {
                displacement.copy_from_slice(&trial);
                return Ok(Some(reaction));
            }
            if has_potential && along > 0.0 && still < 0.0 {
                shorter = (along / (along - still)).clamp(0.1, 0.5);
            }
        }
        step *= shorter;
    }
    Ok(None)
}
