//! Newton's method on the balance of forces, each of its linear systems solved by a Krylov method from products of the
//! stiffness with vectors alone, which are differences of forces. [P 3.69-3.81]

mod gmres;
mod krylov;
mod line_search;
pub(crate) mod preconditioner;

use super::balance::{Balance, PURPOSE, Stop, Trial};
use crate::error::Result;
use crate::memory;
use krylov::Left;
use preconditioner::Preconditioner;

/// How [`Simulation::solve`](crate::Simulation::solve) solves its linear systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Krylov {
    /// Conjugate gradients where forces have a potential, and minimal residuals where the stiffness turns out to have a
    /// direction without resistance; else generalised minimal residuals.
    #[default]
    Automatic,
    /// Conjugate gradients: for a stiffness that is symmetric and positive.
    ConjugateGradients,
    /// Minimal residuals: for one that is symmetric.
    MinimalResiduals,
    /// Generalised minimal residuals, started again after 40 products: for any.
    GeneralisedMinimalResiduals,
}

/// What linear systems may cost, and how far they are to be solved.
#[derive(Debug, Clone, Copy)]
struct Cycle {
    products: usize,
    /// Of the residual.
    reduction: f64,
}

/// A linear system A x = b to a Krylov method.
trait System {
    fn multiply(&mut self, v: &[f64], product: &mut [f64]) -> Trial<()>;
    fn precondition(&mut self, r: &[f64], z: &mut [f64]);
    fn dot(&mut self, v: &[f64], w: &[f64]) -> f64;
    /// v = own v + factor w
    fn combine(&self, v: &mut [f64], own: f64, factor: f64, w: &[f64]);
    fn empty(&self) -> Result<Vec<f64>>;

    fn copied(&self, v: &[f64]) -> Result<Vec<f64>> {
        memory::copied(v, PURPOSE)
    }
}

/// The stiffness of a body at a displacement.
struct Tangent<'a, 'b> {
    balance: &'a mut Balance<'b>,
    preconditioner: &'a mut Preconditioner,
    displacement: &'a [f64],
    /// V b there.
    base: &'a [f64],
}

impl System for Tangent<'_, '_> {
    fn multiply(&mut self, v: &[f64], product: &mut [f64]) -> Trial<()> {
        self.balance.stiffness((self.displacement, self.base), v, product)
    }

    fn precondition(&mut self, r: &[f64], z: &mut [f64]) {
        self.preconditioner.apply(self.balance.plan, self.balance.space.workers, r, z);
    }

    fn dot(&mut self, v: &[f64], w: &[f64]) -> f64 {
        self.balance.space.dot(v, w)
    }

    fn combine(&self, v: &mut [f64], own: f64, factor: f64, w: &[f64]) {
        self.balance.space.combine(v, own, factor, w);
    }

    fn empty(&self) -> Result<Vec<f64>> {
        self.balance.space.empty()
    }
}

/// How far Newton's method goes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Residual over loads or reactions, whichever are larger.
    pub(crate) tolerance: f64,
    /// Linear systems at most.
    pub(crate) iterations: usize,
    /// Products of the stiffness that one of them may take.
    pub(crate) products: usize,
    pub(crate) krylov: Krylov,
}

/// Why an equilibrium was not found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Reason {
    /// The force on a point, by its inner place, is not finite.
    NotFinite(usize),
    /// No step along the direction of Newton brings the forces closer to balance.
    Stuck { indefinite: bool },
    /// As many iterations as allowed.
    TooMany,
    /// Bonds go on breaking.
    Breaking,
    /// Motions of relaxation grow, whatever the masses.
    Diverged,
}

/// Where Newton's method has ended.
pub(crate) enum Ended {
    Converged { iterations: usize },
    Failed(Reason),
}

/// What forces are compared with, and what has been seen.
pub(crate) struct Scale<'a> {
    /// Size of loads and reactions before and after.
    pub(crate) forces: f64,
    /// Relative residuals, one an iteration.
    pub(crate) history: &'a mut Vec<f64>,
}

/// The first linear system is solved to this share of the residual, and none further than to the last.
const FIRST: f64 = 1e-2;
const FINEST: f64 = 1e-4;

/// Moves `displacement` to equilibrium; its held components first by `push`, if any.
pub(crate) fn converge(
    balance: &mut Balance<'_>,
    preconditioner: &mut Preconditioner,
    limits: &Limits,
    (displacement, push): (&mut [f64], Option<&[f64]>),
    scale: &mut Scale<'_>,
) -> Result<Ended> {
    match newton(balance, preconditioner, limits, (displacement, push), scale) {
        Ok(ended) => Ok(ended),
        Err(Stop::NotFinite(place)) => Ok(Ended::Failed(Reason::NotFinite(place))),
        Err(Stop::Error(error)) => Err(error),
    }
}

fn newton(
    balance: &mut Balance<'_>,
    preconditioner: &mut Preconditioner,
    limits: &Limits,
    (displacement, mut push): (&mut [f64], Option<&[f64]>),
    scale: &mut Scale<'_>,
) -> Trial<Ended> {
    let mut residual = balance.space.empty()?;
    let mut direction = balance.space.empty()?;
    let mut reaction = balance.residual(displacement, &mut residual)?;
    let mut base = memory::copied(&balance.forces, PURPOSE)?;
    let mut forcing = FIRST;
    let mut size = balance.space.norm(&residual);
    for iterations in 0..=limits.iterations {
        let whole = scale.forces.max(reaction);
        let relative = if size == 0.0 { 0.0 } else { size / whole };
        if push.is_none() {
            memory::push(scale.history, relative, PURPOSE)?;
            if relative <= limits.tolerance {
                return Ok(Ended::Converged { iterations });
            }
        }
        if iterations == limits.iterations {
            break;
        }
        if let Some(push) = push {
            // The stiffness of what is held goes over to the other side.
            let mut pull = balance.space.empty()?;
            balance.stiffness((displacement, &base), push, &mut pull)?;
            balance.space.combine(&mut residual, 1.0, -1.0, &pull);
            size = balance.space.norm(&residual);
        }
        let reduction = forcing.max(0.3 * limits.tolerance * whole / size).min(0.5);
        let cycle = Cycle { products: limits.products, reduction };
        let indefinite = {
            let (displacement, base) = (&*displacement, &base[..]);
            let mut tangent = Tangent { balance, preconditioner, displacement, base };
            solve(&mut tangent, limits.krylov, &residual, &mut direction, cycle)?
        };
        let before = size;
        if let Some(push) = push.take() {
            balance.space.combine(&mut direction, 1.0, 1.0, push);
            balance.space.combine(displacement, 1.0, 1.0, &direction);
            reaction = balance.residual(displacement, &mut residual)?;
        } else {
            let searched =
                line_search::search(balance, displacement, &direction, &mut residual, size)?;
            match searched {
                Some(found) => reaction = found,
                None => return Ok(Ended::Failed(Reason::Stuck { indefinite })),
            }
        }
        size = balance.space.norm(&residual);
        base.copy_from_slice(&balance.forces);
        // Eisenstat and Walker's second choice.
        forcing = (0.9 * (size / before).powi(2)).clamp(FINEST, 0.1);
    }
    Ok(Ended::Failed(Reason::TooMany))
}

/// Solves one linear system; whether the stiffness was found to be indefinite.
fn solve(
    tangent: &mut Tangent<'_, '_>,
    krylov: Krylov,
    b: &[f64],
    x: &mut [f64],
    cycle: Cycle,
) -> Trial<bool> {
    let symmetric = tangent.balance.plan.formulation.has_potential();
    match (krylov, symmetric) {
        (Krylov::Automatic, false) | (Krylov::GeneralisedMinimalResiduals, _) => {
            gmres::gmres(tangent, b, x, cycle)?;
            Ok(false)
        }
        (Krylov::MinimalResiduals, _) => {
            krylov::minimal_residuals(tangent, b, x, cycle)?;
            Ok(false)
        }
        (Krylov::Automatic | Krylov::ConjugateGradients, _) => {
            let left = krylov::conjugate_gradients(tangent, b, x, cycle)?;
            if left == Left::Indefinite && krylov == Krylov::Automatic {
                krylov::minimal_residuals(tangent, b, x, cycle)?;
            }
            Ok(left == Left::Indefinite)
        }
    }
}

#[cfg(test)]
mod tests;
