//! The gradient of a field at a point from its values in the family, and what becomes of it where a family
//! does not span all directions.
//!
//! K = sum w xi xi^T V, grad g = sum w dg (K^-1 xi)^T V; with monomials q of second order beside those of
//! first, K becomes M = sum w q q^T V [P 3.43-3.53].
//!
//! The rule for families that do not span the body, in this one place for all that invert a tensor: a
//! direction counts as spanned when its eigenvalue of K is above [`THINNEST`] of the largest. The gradient
//! is taken in the directions spanned (K^-1 becomes the inverse there), and the material is asked in these
//! alone (see `material`): two of three make a membrane, one a string, none nothing. The deformation
//! in them turns with the body, so a rigid motion stores nothing and pulls on nothing.
//!
//! A gradient that is shown is completed (`material/completion.rs`): directions not spanned turn with those that are,
//! and have the stretch at which the material has no stress in them.

use super::cholesky;
use crate::tensor::{
    Tensor, Vector, add_outer, determinant, eigen, identity, inverse, trace, zero,
};

/// Eigenvalue of K, over the largest, below which a direction is not spanned: a family flatter than a
/// hundredth of its width. Where a body is only turned, forces are rounded by 1e-16 over this, and a family that
/// thin is as many times as stiff across.
const THINNEST: f64 = 1e-4;

/// As [`THINNEST`], for what no longer tells from rounding.
const FLAT: f64 = 1e-15;

/// det K over the product of equal eigenvalues, above which no eigenvalue can be near [`THINNEST`].
const ROUND: f64 = 1e-3;

/// As [`ROUND`], above which the rounding of a gradient is of no account. Faces, edges and corners of lattices have
/// more than 0.5.
const EVEN: f64 = 0.1;

/// Pivot of M, over the diagonal it came from, below which the second order is not to be had.
const LEAST_PIVOT: f64 = 1e-9;

/// sum w |G|^2 V with second order, over that with first, above which second order is not to be had: the
/// points stand such that it is next to undetermined, and the family would pull and round that much more.
/// Unlike pivots it does not change when the body is turned. Faces, edges and corners of lattices have 5 to 45;
/// 7e4 where the horizon is two spacings of a kernel that leaves the second shell next to nothing.
const STEEPEST: f64 = 1e2;

/// As [`STEEPEST`], for gradients whose rounding is worth a second look.
const STEEP: f64 = 10.0;

/// Most monomials.
pub(super) const MOST: usize = 9;

/// A direction-wise inverse of a shape tensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape<const D: usize> {
    /// K^-1 in the directions spanned, 0 across.
    pub(super) inverse: Tensor<D>,
    /// K^-1 also in directions next to flat: too steep for a gradient, but K^-1 xi.xi stays bounded.
    pub(super) steep_inverse: Tensor<D>,
    /// Projector onto the directions spanned.
    pub(super) span: Tensor<D>,
    /// Number of directions spanned.
    pub(super) rank: usize,
    /// No direction is much less spanned than another.
    round: bool,
}

impl<const D: usize> Shape<D> {
    /// Of a symmetric tensor without negative eigenvalues.
    pub(super) fn new(tensor: &Tensor<D>) -> Self {
        let mean = trace(tensor) / D as f64;
        let (volume, ball) = (determinant(tensor), mean.powi(D as i32));
        if volume > ROUND * ball {
            return Self::full(tensor, volume > EVEN * ball);
        }
        let (values, vectors) = eigen(tensor);
        let largest = values.iter().copied().fold(0.0, f64::max);
        let nothing = zero();
        let mut shape =
            Self { inverse: nothing, steep_inverse: nothing, span: nothing, rank: 0, round: false };
        for (axis, &value) in values.iter().enumerate() {
            let direction: Vector<D> = std::array::from_fn(|row| vectors[row][axis]);
            if value > FLAT * largest && value.is_finite() {
                add_outer(&mut shape.steep_inverse, 1.0 / value, &direction, &direction);
            }
            if value > THINNEST * largest && value.is_finite() {
                add_outer(&mut shape.inverse, 1.0 / value, &direction, &direction);
                add_outer(&mut shape.span, 1.0, &direction, &direction);
                shape.rank += 1;
            }
        }
        if shape.rank == D {
            // No rounding of the projector where nothing is projected.
            shape = Self::full(tensor, false);
        }
        shape
    }

    /// Whether all directions are spanned alike, so that the rounding of a gradient is of no account.
    pub(super) fn is_round(&self) -> bool {
        self.round
    }

    fn full(tensor: &Tensor<D>, round: bool) -> Self {
        let inverse = inverse(tensor);
        Self { inverse, steep_inverse: inverse, span: identity(), rank: D, round }
    }
}

/// Monomials of a bond: its vector, and with second order that over the horizon and its products.
#[inline(always)]
pub(super) fn monomials<const D: usize>(
    order: usize,
    reference: &Vector<D>,
    horizon: f64,
) -> [f64; MOST] {
    let mut terms = [0.0; MOST];
    if order == 1 {
        terms[..D].copy_from_slice(reference);
        return terms;
    }
    for axis in 0..D {
        let q = reference[axis] / horizon;
        terms[axis] = q;
        terms[D + axis] = q * q;
    }
    let mut next = 2 * D;
    for first in 0..D {
        for second in first + 1..D {
            terms[next] = terms[first] * terms[second];
            next += 1;
        }
    }
    terms
}

/// Number of monomials.
pub(super) const fn width(order: usize, dimension: usize) -> usize {
    match (order, dimension) {
        (1, dimension) => dimension,
        (_, 2) => 5,
        _ => 9,
    }
}

/// What makes a gradient of differences: grad g = sum w dg (rows q)^T V.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gradient<const D: usize> {
    pub(super) rows: [[f64; MOST]; D],
    pub(super) shape: Shape<D>,
    /// Rounding of the rows is not to be neglected.
    pub(super) steep: bool,
    /// Second order was asked for and could not be had.
    pub(super) lowered: bool,
}

impl<const D: usize> Gradient<D> {
    /// From K, or with second order from M.
    pub(super) fn new(order: usize, moments: &[[f64; MOST]; MOST], horizon: f64) -> Self {
        let mut tensor = zero();
        let scale = if order == 1 { 1.0 } else { horizon * horizon };
        for row in 0..D {
            for column in 0..D {
                tensor[row][column] = scale * moments[row][column];
            }
        }
        let shape = Shape::new(&tensor);
        let mut rows = [[0.0; MOST]; D];
        if order == 2
            && shape.rank == D
            && let Some(solved) = first_rows::<D>(moments, width(2, D))
            && let steepness =
                (0..D).map(|axis| solved[axis][axis]).sum::<f64>() / (scale * trace(&shape.inverse))
            && steepness <= STEEPEST
        {
            for (row, solved) in rows.iter_mut().zip(&solved) {
                for (value, solved) in row.iter_mut().zip(solved) {
                    *value = solved / horizon;
                }
            }
            let steep = !shape.round || steepness > STEEP;
            return Self { rows, shape, steep, lowered: false };
        }
        // q begins with xi, with second order xi over the horizon.
        let unit = if order == 1 { 1.0 } else { horizon };
        for (row, inverse) in rows.iter_mut().zip(&shape.inverse) {
            for (value, inverse) in row.iter_mut().zip(inverse) {
                *value = unit * inverse;
            }
        }
        Self { rows, shape, steep: !shape.round, lowered: order == 2 }
    }
}

/// The first rows of M^-1, by Cholesky's factors; `None` where M is deficient.
fn first_rows<const D: usize>(
    moments: &[[f64; MOST]; MOST],
    size: usize,
) -> Option<[[f64; MOST]; D]> {
    let lower = cholesky::factor(moments, size, LEAST_PIVOT)?;
    let mut rows = [[0.0; MOST]; D];
    for (number, row) in rows.iter_mut().enumerate() {
        row[number] = 1.0;
        cholesky::solve(&lower, size, row);
    }
    Some(rows)
}
