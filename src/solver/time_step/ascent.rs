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

/// How likely it may be that the largest eigenvalue is beyond a limit that it is called to be below.
const DOUBT: f64 = 1e-6;

/// Share of the turns that count as products of a Krylov space: the space of a turn is a part of that.
const COUNTED: f64 = 0.75;

/// What is left of a step of size 1 must be more than rounding, and a residual, over the largest value there was.
const NEW: f64 = 1e-4;
const ROUNDING: f64 = 1e-5;

/// Values below 0, over the largest, up to which bodies count as stable.
const UNSTABLE: f64 = 0.05;

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

/// Whether the largest eigenvalue is surely below a limit, when so many turns from a start of n numbers without order have
/// come to a value, and none is below 0 by more than a tenth of that.
///
/// That the best value of a Krylov space of k products falls short of the largest eigenvalue by a share `open` of what
/// there is between that and the smallest is no more likely than 1.648 sqrt(n) exp(-(2 k - 1) sqrt(open)) (Kuczynski and Wozniakowski,
/// 1992). And an eigenvalue beyond the limit of whose mode the start has a part 1/(c sqrt(n)), which is missed with a likelihood
/// of about 1/c, would have brought the value further where Chebyshev's polynomial of degree k - 1, over eigenvalues from the
/// smallest to twice the value, has more than c sqrt(n) at the limit. Both take a start that is as likely to lie in any direction:
/// that of points of hardly any volume is less so.
fn is_surely_below(limit: f64, value: f64, turns: usize, n: usize) -> bool {
    let (products, root) = (COUNTED * turns as f64, (n as f64).sqrt());
    let least = -2.0 * UNSTABLE * value;
    let open = (limit - value) / (limit - least);
    let near = 1.648 * root * (-(2.0 * products - 1.0) * open.sqrt()).exp();
    let beyond = 2.0 * (limit - least) / (2.0 * value - least) - 1.0;
    let far = root / ((products - 1.0) * beyond.acosh()).cosh();
    value > 0.0 && products > 1.0 && (near < DOUBT || far < DOUBT)
}

/// `limit`: no more is wanted than to know that the eigenvalue is below it.
pub(super) fn top(
    operator: &mut Linearised<'_>,
    start: Vec<f64>,
    products: usize,
    limit: Option<f64>,
) -> Result<Top> {
    let mut x = Pair { vector: start, product: operator.empty()? };
    let (mut r, mut p) = (Pair::empty(operator)?, Pair::empty(operator)?);
    operator.multiply(&x.vector, &mut x.product)?;
    let (mut turn, mut least, mut largest) = (1, 0.0_f64, 0.0_f64);
    loop {
        let value = operator.dot(&x.vector, &x.product);
        r.vector.copy_from_slice(&x.product);
        operator.combine(&mut r.vector, 1.0, -value, &x.vector);
        let residual = operator.dot(&r.vector, &r.vector).sqrt();
        (least, largest) = (least.min(value), largest.max(value.abs()));
        let is_known = turn >= LEAST && residual <= CONVERGED * value.abs();
        let goes_on = turn < products && !is_known && residual > ROUNDING * largest;
        let is_stable = least >= -UNSTABLE * value;
        let is_below =
            |limit| value + residual < limit && is_surely_below(limit, value, turn, x.vector.len());
        let is_settled = goes_on && is_stable && limit.is_some_and(is_below);
        if !goes_on || is_settled {
            return Ok(Top { real: value, imaginary: 0.0, residual, mode: x.vector, is_settled });
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
        for &value in values.iter().filter(|&&value| value > 0.5 * f64::MIN) {
            (least, largest) = (least.min(value), largest.max(value.abs()));
        }
        let best = (0..3).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
        let [of_x, of_r, of_p] = [0, 1, 2].map(|row| vectors[row][best]);
        p.combine(operator, if has_step { of_p } else { 0.0 }, of_r, &r);
        x.combine(operator, of_x, 1.0, &p);
        x.normalise(operator);
        turn += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farther_the_limit_the_sooner_it_is_known() {
        let turns =
            |limit: f64| (1..60).find(|&turns| is_surely_below(limit, 1.0, turns, 3_000_000));
        let needed = [1e4, 100.0, 4.0, 1.6, 1.2].map(|limit| turns(limit).unwrap());
        assert_eq!(needed, [5, 7, 18, 26, 38]);
        assert_eq!([1.05, 1.0, 0.5, f64::NAN].map(turns), [None; 4]);
        assert!(!is_surely_below(1.0, 0.0, 50, 10) && !is_surely_below(1.0, f64::NAN, 50, 10));
    }
}
