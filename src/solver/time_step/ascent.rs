//! The largest eigenvalue of a symmetric operator: each turn takes the best in the space of the vector, its residual
//! and the last step (the locally optimal conjugate gradient method of Knyazev, 2001). It needs six vectors, and has
//! the mode at any time, to go on from later.

use super::Top;
use super::linearised::Linearised;
use crate::error::Result;
use crate::tensor::{Tensor, eigen};

/// The residual, over the eigenvalue, at which more turns would tell nothing new.
const CONVERGED: f64 = 1e-3;

/// Turns that a search from the start makes at least, so that what it hardly began with can grow.
const LEAST: usize = 40;

/// What is left of a step of size 1 must be more than rounding.
const NEW: f64 = 1e-6;

/// A vector and its product.
struct Pair {
    vector: Vec<f64>,
    product: Vec<f64>,
}

impl Pair {
    fn empty(operator: &Linearised<'_>) -> Result<Self> {
        Ok(Self { vector: operator.empty()?, product: operator.empty()? })
    }

    /// own self + factor other
    fn combine(&mut self, operator: &Linearised<'_>, own: f64, factor: f64, other: &Self) {
        operator.combine(&mut self.vector, own, factor, &other.vector);
        operator.combine(&mut self.product, own, factor, &other.product);
    }

    /// Takes out what it has of another of size 1.
    fn square_to(&mut self, operator: &mut Linearised<'_>, other: &Self) {
        let along = operator.dot(&self.vector, &other.vector);
        self.combine(operator, 1.0, -along, other);
    }

    /// Makes it of size 1; gives the size it had.
    fn normalise(&mut self, operator: &mut Linearised<'_>) -> f64 {
        let size = operator.dot(&self.vector, &self.vector).sqrt();
        if size > 0.0 {
            self.vector.iter_mut().chain(&mut self.product).for_each(|value| *value /= size);
        }
        size
    }
}

pub(super) fn top(operator: &mut Linearised<'_>, start: Vec<f64>, products: usize) -> Result<Top> {
    let mut x = Pair { vector: start, product: operator.empty()? };
    let (mut r, mut p) = (Pair::empty(operator)?, Pair::empty(operator)?);
    operator.multiply(&x.vector, &mut x.product)?;
    let mut turn = 1;
    loop {
        let value = operator.dot(&x.vector, &x.product);
        r.vector.copy_from_slice(&x.product);
        operator.combine(&mut r.vector, 1.0, -value, &x.vector);
        let residual = operator.dot(&r.vector, &r.vector).sqrt();
        let is_known = turn >= LEAST && residual <= CONVERGED * value.abs();
        let goes_on = turn < products && !is_known && residual > 1e-12 * value.abs();
        if !goes_on {
            return Ok(Top { real: value, imaginary: 0.0, residual, mode: x.vector });
        }
        operator.combine(&mut r.vector, 1.0 / residual, 0.0, &x.vector);
        operator.multiply(&r.vector, &mut r.product)?;
        let mut has_step = turn > 1;
        if has_step {
            p.normalise(operator);
            p.square_to(operator, &x);
            p.square_to(operator, &r);
            has_step = p.normalise(operator) > NEW;
        }
        let basis = [&x, &r, &p];
        // Without a step its place is below all eigenvalues.
        let mut small: Tensor<3> = [[0.0; 3]; 3];
        small[2][2] = f64::MIN;
        for row in 0..if has_step { 3 } else { 2 } {
            for column in 0..=row {
                let value = operator.dot(&basis[row].vector, &basis[column].product);
                (small[row][column], small[column][row]) = (value, value);
            }
        }
        let (values, vectors) = eigen(&small);
        let best = (0..3).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
        let [of_x, of_r, of_p] = [0, 1, 2].map(|row| vectors[row][best]);
        p.combine(operator, if has_step { of_p } else { 0.0 }, of_r, &r);
        x.combine(operator, of_x, 1.0, &p);
        x.normalise(operator);
        turn += 1;
    }
}
