//! Surface correction by the stiffness tensor: bonds are weighted by their direction n until each family has the
//! stiffness tensor of the material.
//!
//! A family stores 1/2 sum mu q (n.e n)^2 at a uniform strain e, mu of its bonds. Its tensor sum mu q nnnn is to be the
//! isotropic T (I I + 2 I4)/(D (D+2)), which is Hooke's for springs. Of all weights q > 0 that do so q = exp(l:nnnn)
//! differ least from 1, with one symmetric l of fourth order a point. No springs do it in all directions where a
//! family is cut by two planes: l is asked that sum mu q nnnn + T P l be that tensor; such an l always exists, is only one and
//! changes smoothly with the points. P is [`ALONG`] or [`ACROSS`].
//!
//! Kin to the position-aware linear solid (Mitchell, Silling and Littlewood 2015), which matches energies, too, by two
//! influence functions a point.

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

/// A step of Newton's method after which there is only rounding.
const SMALL: f64 = 1e-7;

/// A step short enough to be taken whole.
const SHORT: f64 = 0.1;

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
        3 => Quartic::<3, 15, 45>::new(SOLID).factors(scene, weight, total),
        _ => Quartic::<2, 5, 9>::new(FLAT).factors(scene, weight, total),
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

/// Symmetric tensors of fourth order by their K components, such that the product of two is that of the tensors; those
/// of eighth order have E.
struct Quartic<const D: usize, const K: usize, const E: usize> {
    exponents: [[usize; D]; K],
    /// Root of how often each component stands in the tensor.
    roots: [f64; K],
    /// The isotropic tensor whose double trace is 1.
    isotropic: [f64; K],
    regularization: [f64; K],
    /// Exponents of eighth order, and which is the product of two components.
    octic: [[usize; D]; E],
    products: [[usize; K]; K],
}

/// Bonds of a family side by side: directions and weights, 0 where there is none.
struct Block<const D: usize> {
    directions: [[f64; LANES]; D],
    weights: [f64; LANES],
}

/// n^0 to n^8 of each axis.
type Powers<const D: usize> = [[[f64; LANES]; 9]; D];

impl<const D: usize> Block<D> {
    const EMPTY: Self = Self { directions: [[0.0; LANES]; D], weights: [0.0; LANES] };

    fn powers(&self) -> Powers<D> {
        let mut powers = [[[1.0; LANES]; 9]; D];
        for (powers, direction) in powers.iter_mut().zip(&self.directions) {
            for power in 1..9 {
                for lane in 0..LANES {
                    powers[power][lane] = powers[power - 1][lane] * direction[lane];
                }
            }
        }
        powers
    }
}

/// A product of powers in all lanes.
#[inline(always)]
fn monomial<const D: usize>(powers: &Powers<D>, exponents: &[usize; D]) -> [f64; LANES] {
    let mut product = powers[0][exponents[0]];
    for axis in 1..D {
        let factor = &powers[axis][exponents[axis]];
        (0..LANES).for_each(|lane| product[lane] *= factor[lane]);
    }
    product
}

impl<const D: usize, const K: usize, const E: usize> Quartic<D, K, E> {
    fn new(exponents: [[usize; D]; K]) -> Self {
        let factorial = |n: usize| (1..=n).product::<usize>() as f64;
        let is_even = |powers: &[usize; D]| powers.iter().all(|power| power % 2 == 0);
        let often = |powers: [usize; D]| 24.0 / powers.map(factorial).iter().product::<f64>();
        let roots = exponents.map(|powers| often(powers).sqrt());
        let mut isotropic = roots;
        for (value, powers) in isotropic.iter_mut().zip(&exponents) {
            // (power - 1)!! of each
            let mean = if powers.contains(&4) { 3.0 } else { f64::from(u8::from(is_even(powers))) };
            *value *= mean / (D * (D + 2)) as f64;
        }
        let regularization = exponents.map(|powers| if is_even(&powers) { ALONG } else { ACROSS });
        let (mut octic, mut products, mut known) = ([[0; D]; E], [[0; K]; K], 0);
        for row in 0..K {
            for column in 0..K {
                let sum =
                    std::array::from_fn(|axis| exponents[row][axis] + exponents[column][axis]);
                let place = octic[..known].iter().position(|it| *it == sum).unwrap_or(known);
                octic[place] = sum;
                known = known.max(place + 1);
                products[row][column] = place;
            }
        }
        Self { exponents, roots, isotropic, regularization, octic, products }
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
                    let tensor = self.of(&direction(scene, point, bond));
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
        let each_block = |read: &mut dyn FnMut(&Block<D>)| blocks(scene, point, weight, read);
        let mut exponent = [0.0; K];
        let mut sum = 0.0;
        each_block(&mut |block| sum += block.weights.iter().sum::<f64>());
        let total = total(point, sum);
        if total.is_nan() || total <= 0.0 {
            return exponent;
        }
        for _ in 0..MOST_STEPS {
            let Some(step) = self.step(&each_block, total, &exponent) else { break };
            let size = product(&step, &step).sqrt();
            let mut damping = 1.0;
            if size > SHORT {
                let mut largest = 0.0_f64;
                each_block(&mut |block| {
                    let changes = self.in_lanes(&block.powers(), &step);
                    largest = changes.iter().fold(largest, |most, change| most.max(change.abs()));
                });
                damping = if largest > 0.0 { largest.ln_1p() / largest } else { 1.0 };
            }
            for (value, step) in exponent.iter_mut().zip(step) {
                *value += damping * step;
            }
            if size <= SMALL {
                break;
            }
        }
        exponent
    }

    /// A step of Newton's method.
    fn step(
        &self,
        each_block: &impl Fn(&mut dyn FnMut(&Block<D>)),
        total: f64,
        exponent: &[f64; K],
    ) -> Option<[f64; K]> {
        let (mut fourth, mut eighth) = ([[0.0; LANES]; K], [[0.0; LANES]; E]);
        each_block(&mut |block| {
            let mut powers = block.powers();
            let logarithms = self.in_lanes(&powers, exponent);
            let weights: [f64; LANES] =
                std::array::from_fn(|lane| block.weights[lane] * logarithms[lane].exp());
            // Every monomial has one power of the first axis.
            for power in &mut powers[0] {
                (0..LANES).for_each(|lane| power[lane] *= weights[lane]);
            }
            for (sums, exponents) in fourth.iter_mut().zip(&self.exponents) {
                let terms = monomial(&powers, exponents);
                (0..LANES).for_each(|lane| sums[lane] += terms[lane]);
            }
            for (sums, exponents) in eighth.iter_mut().zip(&self.octic) {
                let terms = monomial(&powers, exponents);
                (0..LANES).for_each(|lane| sums[lane] += terms[lane]);
            }
        });
        let eighth = eighth.map(|lanes| lanes.iter().sum::<f64>());
        let mut step = [0.0; K];
        let mut slope = [[0.0; K]; K];
        for row in 0..K {
            let stored = self.roots[row] * fourth[row].iter().sum::<f64>();
            let penalty = total * self.regularization[row];
            step[row] = total * self.isotropic[row] - stored - penalty * exponent[row];
            for column in 0..=row {
                let roots = self.roots[row] * self.roots[column];
                slope[row][column] = roots * eighth[self.products[row][column]];
            }
            slope[row][row] += penalty;
        }
        cholesky::solve(&cholesky::factor(&slope, K, 0.0)?, K, &mut step);
        Some(step)
    }

    /// l:nnnn of each lane.
    fn in_lanes(&self, powers: &Powers<D>, tensor: &[f64; K]) -> [f64; LANES] {
        let mut sums = [0.0; LANES];
        for (k, exponents) in self.exponents.iter().enumerate() {
            let (factor, terms) = (tensor[k] * self.roots[k], monomial(powers, exponents));
            (0..LANES).for_each(|lane| sums[lane] += factor * terms[lane]);
        }
        sums
    }
}

/// The bonds of a point that are not broken, in blocks.
fn blocks<const D: usize>(
    scene: &Scene<'_>,
    point: usize,
    weight: &impl Fn(usize, Bond) -> f64,
    read: &mut dyn FnMut(&Block<D>),
) {
    let (mut block, mut lane) = (Block::EMPTY, 0);
    for bond in scene.families.bonds(point).filter(|bond| scene.bonds.is_intact(bond.slot)) {
        let direction = direction::<D>(scene, point, bond);
        (0..D).for_each(|axis| block.directions[axis][lane] = direction[axis]);
        block.weights[lane] = weight(point, bond);
        lane += 1;
        if lane == LANES {
            read(&block);
            (block, lane) = (Block::EMPTY, 0);
        }
    }
    if lane > 0 {
        read(&block);
    }
}

fn direction<const D: usize>(scene: &Scene<'_>, point: usize, bond: Bond) -> Vector<D> {
    let (from, to) = (&scene.places[point], &scene.places[bond.neighbor]);
    std::array::from_fn(|axis| (to[axis] - from[axis]) / bond.length)
}

fn product<const K: usize>(a: &[f64; K], b: &[f64; K]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
