//! The largest eigenvalue of an operator that is not symmetric, by Arnoldi's method in the inner product of the mass,
//! started again from the mode that it found.

use super::dominant::{self, Matrix, SPACE};
use super::linearised::Linearised;
use super::{PURPOSE, Top};
use crate::error::Result;
use crate::memory;

/// The residual, over the eigenvalue, at which more turns would tell nothing new.
const CONVERGED: f64 = 1e-3;

pub(super) fn top(operator: &mut Linearised<'_>, start: Vec<f64>, products: usize) -> Result<Top> {
    let (mut top, mut left) = cycle(operator, start, products)?;
    while left > 0 && top.residual > CONVERGED * top.size() {
        operator.normalise(&mut top.mode);
        (top, left) = cycle(operator, top.mode, left)?;
    }
    Ok(top)
}

/// Gives what so many products tell, and how many of them are left.
fn cycle(operator: &mut Linearised<'_>, start: Vec<f64>, products: usize) -> Result<(Top, usize)> {
    let turns = products.min(SPACE);
    let mut basis = memory::reserved(turns + 1, PURPOSE)?;
    basis.push(start);
    let mut small: Matrix = [[0.0; SPACE]; SPACE];
    let (mut size, mut rest, mut used) = (0, 0.0, 0);
    for turn in 0..turns {
        let mut next = operator.empty()?;
        operator.multiply(&basis[turn], &mut next)?;
        used += 1;
        // Twice, since the first time leaves what rounding has kept.
        for _ in 0..2 {
            for (row, vector) in basis.iter().enumerate() {
                let along = operator.dot(vector, &next);
                small[row][turn] += along;
                operator.combine(&mut next, 1.0, -along, vector);
            }
        }
        size = turn + 1;
        rest = operator.dot(&next, &next).sqrt();
        // Nothing new is left of the space that the first vector reaches.
        if rest.is_nan() || rest <= 1e-12 * small[0][0].abs() {
            used = products;
            break;
        }
        operator.normalise(&mut next);
        basis.push(next);
        if size < turns {
            small[size][turn] = rest;
        }
    }
    let found = dominant::eigenvalue(&small, size);
    let mut mode = operator.empty()?;
    for (factor, vector) in found.vector.iter().zip(&basis[..size]) {
        operator.combine(&mut mode, 1.0, *factor, vector);
    }
    let residual = rest * found.last;
    let top =
        Top { real: found.real, imaginary: found.imaginary, residual, mode, is_settled: false };
    Ok((top, products - used))
}
