//! Krylov methods for a symmetric stiffness: conjugate gradients while it is positive, minimal residuals else.

use super::{Cycle, System};
use crate::solver::balance::Trial;

/// How a linear system was left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Left {
    Solved,
    /// As many products as were allowed.
    Open,
    /// A direction along which the body gives way.
    Indefinite,
}

/// Preconditioned conjugate gradients from x = 0.
pub(super) fn conjugate_gradients(
    system: &mut impl System,
    b: &[f64],
    x: &mut [f64],
    cycle: Cycle,
) -> Trial<Left> {
    x.fill(0.0);
    let mut r = system.copied(b)?;
    let (mut z, mut product) = (system.empty()?, system.empty()?);
    let goal = cycle.reduction * system.dot(&r, &r).sqrt();
    system.precondition(&r, &mut z);
    let mut p = system.copied(&z)?;
    let mut size = system.dot(&r, &z);
    for _ in 0..cycle.products {
        if size.is_nan() || size <= 0.0 {
            break;
        }
        system.multiply(&p, &mut product)?;
        let curvature = system.dot(&p, &product);
        if curvature.is_nan() || curvature <= 0.0 {
            return Ok(Left::Indefinite);
        }
        let step = size / curvature;
        system.combine(x, 1.0, step, &p);
        system.combine(&mut r, 1.0, -step, &product);
        if system.dot(&r, &r).sqrt() <= goal {
            return Ok(Left::Solved);
        }
        system.precondition(&r, &mut z);
        let next = system.dot(&r, &z);
        system.combine(&mut p, next / size, 1.0, &z);
        size = next;
    }
    Ok(Left::Open)
}

/// Preconditioned minimal residuals (Paige and Saunders 1975) from x = 0; the residual is judged in the norm of the
/// preconditioner.
pub(super) fn minimal_residuals(
    system: &mut impl System,
    b: &[f64],
    x: &mut [f64],
    cycle: Cycle,
) -> Trial<Left> {
    x.fill(0.0);
    let mut v = [system.empty()?, system.copied(b)?];
    let mut w = [system.empty()?, system.empty()?];
    let (mut z, mut product) = (system.empty()?, system.empty()?);
    system.precondition(&v[1], &mut z);
    let mut gamma = [1.0, system.dot(&z, &v[1]).sqrt()];
    let mut rest = gamma[1];
    let goal = cycle.reduction * rest;
    let (mut cosine, mut sine) = ([1.0, 1.0], [0.0, 0.0]);
    for _ in 0..cycle.products {
        if gamma[1].is_nan() || gamma[1] <= 0.0 {
            break;
        }
        z.iter_mut().for_each(|value| *value /= gamma[1]);
        system.multiply(&z, &mut product)?;
        let delta = system.dot(&z, &product);
        system.combine(&mut product, 1.0, -delta / gamma[1], &v[1]);
        system.combine(&mut product, 1.0, -gamma[1] / gamma[0], &v[0]);
        v.swap(0, 1);
        std::mem::swap(&mut v[1], &mut product);
        // z is needed until w has been made: the product's room takes the next one.
        system.precondition(&v[1], &mut product);
        let next = system.dot(&product, &v[1]).max(0.0).sqrt();
        let diagonal = cosine[1] * delta - cosine[0] * sine[1] * gamma[1];
        let length = diagonal.hypot(next);
        let above = sine[1] * delta + cosine[0] * cosine[1] * gamma[1];
        let two_above = sine[0] * gamma[1];
        system.combine(&mut w[0], -two_above / length, 1.0 / length, &z);
        let (old, last) = w.split_at_mut(1);
        system.combine(&mut old[0], 1.0, -above / length, &last[0]);
        w.swap(0, 1);
        (cosine, sine) = ([cosine[1], diagonal / length], [sine[1], next / length]);
        system.combine(x, 1.0, cosine[1] * rest, &w[1]);
        rest *= -sine[1];
        gamma = [gamma[1], next];
        std::mem::swap(&mut z, &mut product);
        if rest.abs() <= goal {
            return Ok(Left::Solved);
        }
    }
    Ok(Left::Open)
}
