//! Surface correction by the stiffness tensor: bonds are weighted by their direction n until each family has the
//! stiffness tensor of the material.
//!
//! A family stores 1/2 sum mu q (n.e n)^2 at a uniform strain e, mu of its bonds. Its tensor sum mu q nnnn is to be the
//! isotropic T (I I + 2 I4)/(D (D+2)), which is Hooke's for springs. Of all weights q > 0 that do so q = exp(l:nnnn)
//! differ least from 1, with one symmetric l of fourth order a point. No springs do it in all directions where a
//! family is cut by two planes: what is asked of l is sum mu q nnnn + T P l, the root of which always exists, is only one and
//! turns smoothly with the points. P is [`ALONG`] or [`ACROSS`].

use super::Scene;
use super::cholesky;
use super::surface::Correction;
use crate::error::Result;
use crate::families::{Bond, LANES};
use crate::memory;
use crate::tensor::Vector;
use crate::workers::{PerPoint, Ragged};

/// P of the components that are even in each axis. Bars along the axes have their modulus to 1 %; a tenth of it gains
/// little and takes more from some bonds.
const ALONG: f64 = 1e-3;

/// P of all others. Edges along the axes have only these to give up; as small as [`ALONG`] it would cost bars along the axes
/// 2 % and let bonds go slack, ten times as large bars that are turned 5 %.
const ACROSS: f64 = 1e-2;

/// A step of Newton's method that no longer changes a factor.
const SMALL: f64 = 1e-10;

/// Newton's method takes 3 to 12 steps.
const MOST_STEPS: usize = 100;

const PURPOSE: &str = "surface factors";

/// q of each lane in the families of both ends. `weight` gives mu of a bond in the family of a point, `total` T from
/// the sum of mu.
pub(super) fn factors(
    scene: &Scene<'_>,
    weight: impl Fn(usize, Bond) -> f64 + Sync,
    total: impl Fn(usize, f64) -> f64 + Sync,
) -> Result<Correction> {
    match scene.dimension {
        3 => Quartic::<3, 15>::new(SOLID).factors(scene, weight, total),
        _ => Quartic::<2, 5>::new(FLAT).factors(scene, weight, total),
    }
}

/// Exponents of the components of nnnn, those even in each axis first.
const SOLID: [[usize; 3]; 15] = [
    [4, 0, 0],
    [0, 4, 0],
    [0, 0, 4],
    [2, 2, 0],
    [0, 2, 2],
    [2, 0, 2],
    [3, 1, 0],
    [3, 0, 1],
    [1, 3, 0],
    [0, 3, 1],
    [1, 0, 3],
    [0, 1, 3],
    [2, 1, 1],
    [1, 2, 1],
    [1, 1, 2],
];
const FLAT: [[usize; 2]; 5] = [[4, 0], [0, 4], [2, 2], [3, 1], [1, 3]];

/// Symmetric tensors of fourth order by their K components, such that the product of two is that of the tensors.
struct Quartic<const D: usize, const K: usize> {
    exponents: [[usize; D]; K],
    /// Root of how often each component stands in the tensor.
    roots: [f64; K],
    /// The isotropic tensor whose double trace is 1.
    isotropic: [f64; K],
    regularization: [f64; K],
}

impl<const D: usize, const K: usize> Quartic<D, K> {
    fn new(exponents: [[usize; D]; K]) -> Self {
        let factorial = |n: usize| (1..=n).product::<usize>() as f64;
        let is_even = |powers: [usize; D]| powers.iter().all(|power| power % 2 == 0);
        let roots =
            exponents.map(|powers| (24.0 / powers.map(factorial).iter().product::<f64>()).sqrt());
        let mut isotropic = roots;
        for (value, powers) in isotropic.iter_mut().zip(exponents) {
            // (power - 1)!! of each
            let mean = if powers.contains(&4) { 3.0 } else { f64::from(u8::from(is_even(powers))) };
            *value *= mean / (D * (D + 2)) as f64;
        }
        let regularization = exponents.map(|powers| if is_even(powers) { ALONG } else { ACROSS });
        Self { exponents, roots, isotropic, regularization }
    }

    /// nnnn, the same bits from both ends of a bond.
    fn of(&self, direction: &Vector<D>) -> [f64; K] {
        let powers = direction.map(|n| [1.0, n, n * n, n * n * n, n * n * (n * n)]);
        std::array::from_fn(|k| {
            let exponents = &self.exponents[k];
            powers.iter().zip(exponents).map(|(powers, &e)| powers[e]).product::<f64>()
                * self.roots[k]
        })
    }

    fn of_bond(&self, scene: &Scene<'_>, point: usize, bond: Bond) -> [f64; K] {
        let (from, to) = (&scene.places[point], &scene.places[bond.neighbor]);
        self.of(&std::array::from_fn(|axis| (to[axis] - from[axis]) / bond.length))
    }

    fn factors(
        &self,
        scene: &Scene<'_>,
        weight: impl Fn(usize, Bond) -> f64 + Sync,
        total: impl Fn(usize, f64) -> f64 + Sync,
    ) -> Result<Correction> {
        let (families, count) = (scene.families, scene.places.len());
        let mut exponents = memory::filled([0.0; K], count, PURPOSE)?;
        scene.workers.sweep(count, PerPoint(&mut exponents[..], 1), |range, exponents| {
            for (exponent, point) in exponents.0.iter_mut().zip(range) {
                *exponent = self.exponent(scene, point, &weight, &total);
            }
        });
        let exponents = &exponents;
        let lanes = families.block_count() * LANES;
        let mut own = memory::filled(1.0, lanes, PURPOSE)?;
        let mut other = memory::filled(1.0, lanes, PURPOSE)?;
        let ragged = |values| Ragged { values, offsets: &families.offsets, width: LANES };
        let outputs = (ragged(&mut own[..]), ragged(&mut other[..]));
        scene.workers.sweep(count, outputs, |range, (own, other)| {
            let first = families.offsets[range.start] as usize * LANES;
            for point in range {
                for bond in families.bonds(point) {
                    let tensor = self.of_bond(scene, point, bond);
                    let factor = |point: usize| product(&exponents[point], &tensor).exp();
                    own.values[bond.slot - first] = factor(point);
                    other.values[bond.slot - first] = factor(bond.neighbor);
                }
            }
        });
        Ok(Correction { own, other })
    }

    /// l of a point: Newton's method on a convex function, with the steps by which it always falls.
    fn exponent(
        &self,
        scene: &Scene<'_>,
        point: usize,
        weight: &impl Fn(usize, Bond) -> f64,
        total: &impl Fn(usize, f64) -> f64,
    ) -> [f64; K] {
        let bonds = || {
            let intact =
                scene.families.bonds(point).filter(|bond| scene.bonds.is_intact(bond.slot));
            intact.map(|bond| (self.of_bond(scene, point, bond), weight(point, bond)))
        };
        let mut exponent = [0.0; K];
        let total = total(point, bonds().map(|(_, weight)| weight).sum());
        if total.is_nan() || total <= 0.0 {
            return exponent;
        }
        for _ in 0..MOST_STEPS {
            let mut step: [f64; K] = std::array::from_fn(|k| {
                total * (self.isotropic[k] - self.regularization[k] * exponent[k])
            });
            let mut slope = [[0.0; K]; K];
            for k in 0..K {
                slope[k][k] = total * self.regularization[k];
            }
            for (tensor, weight) in bonds() {
                let weight = weight * product(&exponent, &tensor).exp();
                for row in 0..K {
                    let part = weight * tensor[row];
                    step[row] -= part;
                    for column in 0..=row {
                        slope[row][column] += part * tensor[column];
                    }
                }
            }
            let Some(lower) = cholesky::factor(&slope, K, 0.0) else { break };
            cholesky::solve(&lower, K, &mut step);
            let largest =
                bonds().map(|(tensor, _)| product(&step, &tensor).abs()).fold(0.0, f64::max);
            let damping = if largest > 0.0 { largest.ln_1p() / largest } else { 1.0 };
            for (value, step) in exponent.iter_mut().zip(step) {
                *value += damping * step;
            }
            if largest <= SMALL {
                break;
            }
        }
        exponent
    }
}

fn product<const K: usize>(a: &[f64; K], b: &[f64; K]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
