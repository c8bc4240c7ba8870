//! Elastic laws in lanes, asked at gradients H = F - I of families that span the body.
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::simd::{Kernel, Lanes, Mask, Simd, SimdLevel, ln_1p, logarithm};
use crate::families::LANES;

/// The step of Newton's method for what lies across a plate, as a part of t^2, after which nothing is left to be done.
const CLOSE: f64 = 1e-9;

/// Most of its steps.
const MOST_STEPS: usize = 50;

/// How a law answers: as those of the same names in `material`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Elasticity {
    SaintVenantKirchhoff,
    SmallStrain,
    NeoHookean,
    /// In plane stress.
    NeoHookeanPlate,
}

/// A law and lambda and mu of it: those of the solid in the laws of Neo-Hooke, of the plane in the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ElasticLaw {
    pub(crate) elasticity: Elasticity,
    pub(crate) lambda: f64,
    pub(crate) mu: f64,
}

/// The law that is asked most, compiled by itself.
#[derive(Clone, Copy)]
pub(crate) struct SaintVenantKirchhoff {
    pub(crate) lambda: f64,
    pub(crate) mu: f64,
}

/// Puts stresses in the place of the displacement gradients of some lanes, and energies: the means of what laws answer, which
/// each lane has of its own. Called where a loop is not to be filled with all sorts of laws.
pub(crate) struct AskEach<'a, const D: usize> {
    pub(crate) laws: &'a [[ElasticLaw; LANES]],
    pub(crate) lanes: Range<usize>,
    pub(crate) gradients: &'a mut [[[f64; LANES]; D]; D],
    pub(crate) energies: &'a mut [f64; LANES],
}

impl<const D: usize> Kernel for AskEach<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { laws, lanes, gradients, energies } = self;
        let share = simd.splat(1.0 / laws.len() as f64);
        for lane in lanes.step_by(S::WIDTH) {
            let mut gradient = [[simd.splat(0.0); D]; D];
            for row in 0..D {
                for column in 0..D {
                    gradient[row][column] = simd.load(&gradients[row][column][lane..]);
                }
            }
            let (mut sum, mut sums) = (simd.splat(0.0), [[simd.splat(0.0); D]; D]);
            for laws in laws {
                let (held, stress) = ElasticLaw::of_each(simd, &laws[lane..], &gradient);
                sum = held.mul_add(share, sum);
                for row in 0..D {
                    for column in 0..D {
                        sums[row][column] = stress[row][column].mul_add(share, sums[row][column]);
                    }
                }
            }
            sum.store(&mut energies[lane..]);
            for row in 0..D {
                for column in 0..D {
                    sums[row][column].store(&mut gradients[row][column][lane..]);
                }
            }
        }
    }
}

/// The same of lanes, called.
#[inline(always)]
fn asked<S: Simd, const D: usize>(
    simd: S,
    level: SimdLevel,
    laws: &[[ElasticLaw; LANES]],
    gradient: &[[S::Lanes; D]; D],
) -> (S::Lanes, [[S::Lanes; D]; D]) {
    let (mut gradients, mut energies) = ([[[0.0; LANES]; D]; D], [0.0; LANES]);
    for row in 0..D {
        for column in 0..D {
            gradient[row][column].store(&mut gradients[row][column]);
        }
    }
    let (lanes, energies) = (0..S::WIDTH, &mut energies);
    level.run(AskEach { laws, lanes, gradients: &mut gradients, energies });
    let mut stress = *gradient;
    for row in 0..D {
        for column in 0..D {
            stress[row][column] = simd.load(&gradients[row][column]);
        }
    }
    (simd.load(energies), stress)
}

/// A law of all lanes.
pub(crate) trait LaneLaw: Copy {
    /// Energy and stress of displacement gradients, times a weight.
    fn weighted<S: Simd, const D: usize>(
        &self,
        simd: S,
        weight: S::Lanes,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]);

    /// Energy and stress of displacement gradients.
    #[inline(always)]
    fn at<S: Simd, const D: usize>(
        &self,
        simd: S,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        self.weighted(simd, simd.splat(1.0), gradient)
    }
}

impl SaintVenantKirchhoff {
    /// Energy and stress of displacement gradients by the law of each lane.
    #[inline(always)]
    pub(super) fn of_each<S: Simd, const D: usize>(
        simd: S,
        laws: &[Self; LANES],
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        let lambda = simd.each(|lane| laws[lane].lambda);
        let mu = simd.each(|lane| laws[lane].mu);
        saint_venant_kirchhoff(simd, lambda, mu, gradient)
    }
}

impl LaneLaw for SaintVenantKirchhoff {
    #[inline(always)]
    fn weighted<S: Simd, const D: usize>(
        &self,
        simd: S,
        weight: S::Lanes,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        let (lambda, mu) = (simd.splat(self.lambda) * weight, simd.splat(self.mu) * weight);
        saint_venant_kirchhoff(simd, lambda, mu, gradient)
    }

    #[inline(always)]
    fn at<S: Simd, const D: usize>(
        &self,
        simd: S,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        saint_venant_kirchhoff(simd, simd.splat(self.lambda), simd.splat(self.mu), gradient)
    }
}

impl LaneLaw for ElasticLaw {
    #[inline(always)]
    fn weighted<S: Simd, const D: usize>(
        &self,
        simd: S,
        weight: S::Lanes,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        let mut constants = Constants::all(simd, *self);
        constants.lambda = constants.lambda * weight;
        constants.mu = constants.mu * weight;
        self.elasticity.answer(simd, &constants, gradient)
    }
}

impl ElasticLaw {
    /// That of lanes without a point.
    pub(crate) const NONE: Self =
        Self { elasticity: Elasticity::SmallStrain, lambda: 0.0, mu: 0.0 };

    pub(crate) fn quadratic(self) -> Option<SaintVenantKirchhoff> {
        let Self { elasticity, lambda, mu } = self;
        let is_quadratic = elasticity == Elasticity::SaintVenantKirchhoff;
        is_quadratic.then_some(SaintVenantKirchhoff { lambda, mu })
    }

    /// Whether the mean of two laws is the law of the mean of their constants.
    #[inline(always)]
    fn is_linear_beside(self, other: Self) -> bool {
        let plate = self.elasticity == Elasticity::NeoHookeanPlate;
        self.elasticity == other.elasticity && (!plate || self == other)
    }

    /// The mean of its answer and those of other laws, one a lane, or its own.
    #[inline(always)]
    pub(super) fn with_each<S: Simd, const D: usize>(
        self,
        (simd, level): (S, SimdLevel),
        others: Option<&[Self; LANES]>,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        let mut constants = Constants::all(simd, self);
        if let Some(others) = others {
            let (laws, linear) = self.beside::<S>(others);
            if !linear {
                return asked(simd, level, &laws, gradient);
            }
            constants = Constants::each(simd, &laws[0]);
        }
        self.elasticity.answer(simd, &constants, gradient)
    }

    /// Laws of both ends, one of each a lane, and whether they are the same at both: the law of the mean constants where that
    /// is the mean of both.
    #[inline(always)]
    fn beside<S: Simd>(self, others: &[Self; LANES]) -> ([[Self; LANES]; 2], bool) {
        // Lane by lane, so that a bond has the same bits at both ends, whatever stands beside it there.
        let (mut laws, mut linear) = ([[self; LANES], *others], true);
        for lane in 0..S::WIDTH {
            let other = others[lane];
            if self.is_linear_beside(other) {
                let mean = |one: f64, other: f64| 0.5 * (one + other);
                let (lambda, mu) = (mean(self.lambda, other.lambda), mean(self.mu, other.mu));
                laws[0][lane] = Self { lambda, mu, ..self };
                laws[1][lane] = laws[0][lane];
            } else {
                linear = false;
            }
        }
        (laws, linear)
    }

    /// Energy and stress of displacement gradients by the law of each lane.
    #[inline(always)]
    pub(crate) fn of_each<S: Simd, const D: usize>(
        simd: S,
        laws: &[Self],
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        let constants = Constants::each(simd, laws);
        let (mut held, mut stress) = (simd.splat(0.0), *gradient);
        let mut left = u8::MAX >> (LANES - S::WIDTH);
        while left != 0 {
            let elasticity = laws[left.trailing_zeros() as usize].elasticity;
            let mut own = 0;
            for lane in 0..S::WIDTH {
                own |= u8::from(laws[lane].elasticity == elasticity) << lane;
            }
            let (mask, answer) = (simd.mask(own), elasticity.answer(simd, &constants, gradient));
            held = answer.0.or(mask, held);
            for row in 0..D {
                for column in 0..D {
                    stress[row][column] = answer.1[row][column].or(mask, stress[row][column]);
                }
            }
            left &= !own;
        }
        (held, stress)
    }
}

/// lambda and mu of each lane, times a weight, and lambda/mu.
struct Constants<F> {
    lambda: F,
    mu: F,
    ratio: F,
}

impl<F: Lanes> Constants<F> {
    #[inline(always)]
    fn all<S: Simd<Lanes = F>>(simd: S, law: ElasticLaw) -> Self {
        let ElasticLaw { lambda, mu, .. } = law;
        Self { lambda: simd.splat(lambda), mu: simd.splat(mu), ratio: simd.splat(lambda / mu) }
    }

    #[inline(always)]
    fn each<S: Simd<Lanes = F>>(simd: S, laws: &[ElasticLaw]) -> Self {
        Self {
            lambda: simd.each(|lane| laws[lane].lambda),
            mu: simd.each(|lane| laws[lane].mu),
            ratio: simd.each(|lane| laws[lane].lambda / laws[lane].mu),
        }
    }
}

impl Elasticity {
    #[inline(always)]
    fn answer<S: Simd, const D: usize>(
        self,
        simd: S,
        constants: &Constants<S::Lanes>,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        let Constants { lambda, mu, .. } = *constants;
        match self {
            Self::SaintVenantKirchhoff => saint_venant_kirchhoff(simd, lambda, mu, gradient),
            Self::SmallStrain => small_strain(simd, lambda, mu, gradient),
            Self::NeoHookean => neo_hookean::<false, S, D>(simd, constants, gradient),
            Self::NeoHookeanPlate => neo_hookean::<true, S, D>(simd, constants, gradient),
        }
    }
}

/// 2 E = H + H^T + H^T H
#[inline(always)]
fn twice_strain<S: Simd, const D: usize>(gradient: &[[S::Lanes; D]; D]) -> [[S::Lanes; D]; D] {
    let mut strain = *gradient;
    for row in 0..D {
        for column in row..D {
            let mut twice = gradient[row][column] + gradient[column][row];
            for line in gradient {
                twice = line[row].mul_add(line[column], twice);
            }
            (strain[row][column], strain[column][row]) = (twice, twice);
        }
    }
    strain
}

#[inline(always)]
pub(crate) fn trace<F: Lanes, const D: usize>(tensor: &[[F; D]; D]) -> F {
    let mut sum = tensor[0][0];
    for axis in 1..D {
        sum = sum + tensor[axis][axis];
    }
    sum
}

/// lambda/2 tr(e)^2 + mu e:e and lambda tr(e) I + 2 mu e of 2 e.
#[inline(always)]
fn quadratic<S: Simd, const D: usize>(
    simd: S,
    lambda: S::Lanes,
    mu: S::Lanes,
    twice: &[[S::Lanes; D]; D],
) -> (S::Lanes, [[S::Lanes; D]; D]) {
    let trace = trace(twice);
    let pressure = simd.splat(0.5) * lambda * trace;
    let (mut held, mut sheared) = (pressure * trace, simd.splat(0.0));
    let mut stress = *twice;
    for row in 0..D {
        for column in row..D {
            let strain = twice[row][column];
            let shear = mu * strain;
            let diagonal = row == column;
            sheared = shear.mul_add(if diagonal { strain } else { strain + strain }, sheared);
            stress[row][column] = if diagonal { shear + pressure } else { shear };
            stress[column][row] = stress[row][column];
        }
    }
    held = (held + sheared) * simd.splat(0.25);
    (held, stress)
}

/// W = lambda/2 tr(E)^2 + mu E:E and P = F (lambda tr(E) I + 2 mu E).
#[inline(always)]
fn saint_venant_kirchhoff<S: Simd, const D: usize>(
    simd: S,
    lambda: S::Lanes,
    mu: S::Lanes,
    gradient: &[[S::Lanes; D]; D],
) -> (S::Lanes, [[S::Lanes; D]; D]) {
    let (held, second) = quadratic(simd, lambda, mu, &twice_strain::<S, D>(gradient));
    let mut stress = second;
    for row in 0..D {
        for column in 0..D {
            for inner in 0..D {
                stress[row][column] =
                    gradient[row][inner].mul_add(second[inner][column], stress[row][column]);
            }
        }
    }
    (held, stress)
}

/// W = lambda/2 tr(e)^2 + mu e:e and P = lambda tr(e) I + 2 mu e, with 2 e = H + H^T.
#[inline(always)]
fn small_strain<S: Simd, const D: usize>(
    simd: S,
    lambda: S::Lanes,
    mu: S::Lanes,
    gradient: &[[S::Lanes; D]; D],
) -> (S::Lanes, [[S::Lanes; D]; D]) {
    let mut twice = *gradient;
    for row in 0..D {
        for column in row..D {
            twice[row][column] = gradient[row][column] + gradient[column][row];
            twice[column][row] = twice[row][column];
        }
    }
    quadratic(simd, lambda, mu, &twice)
}

/// W = mu/2 tr(2 E) - mu ln J + lambda/2 (ln J)^2, and P = F^-T (2 mu E + lambda ln J I), so that it is exactly 0 at rest and
/// has all digits of small strains. Not a number where J is not positive.
#[inline(always)]
fn neo_hookean<const PLATE: bool, S: Simd, const D: usize>(
    simd: S,
    constants: &Constants<S::Lanes>,
    gradient: &[[S::Lanes; D]; D],
) -> (S::Lanes, [[S::Lanes; D]; D]) {
    let Constants { lambda, mu, ratio } = *constants;
    let (one, half) = (simd.splat(1.0), simd.splat(0.5));
    let twice = twice_strain::<S, D>(gradient);
    let of_gradient = cofactors(simd, gradient);
    // J - 1 = tr H + tr cof H + det H, and cof F = (1 + tr H) I - H^T + cof H.
    let spread = trace(gradient);
    let (growth, mut cofactors) = if D == 3 {
        let mut determinant = gradient[0][0] * of_gradient[0][0];
        for column in 1..D {
            determinant = gradient[0][column].mul_add(of_gradient[0][column], determinant);
        }
        let growth = spread + (trace(&of_gradient) + determinant);
        let mut cofactors = of_gradient;
        for row in 0..D {
            for column in 0..D {
                cofactors[row][column] = of_gradient[row][column] - gradient[column][row];
            }
            cofactors[row][row] = cofactors[row][row] + (one + spread);
        }
        (growth, cofactors)
    } else {
        let determinant = gradient[0][0]
            .mul_add(gradient[1][1], gradient[0][1].mul_sub_from(gradient[1][0], simd.splat(0.0)));
        let mut cofactors = of_gradient;
        for axis in 0..D {
            cofactors[axis][axis] = cofactors[axis][axis] + one;
        }
        (spread + determinant, cofactors)
    };
    let mut volume_change = ln_1p(simd, growth);
    let (mut stretched, mut pressure) = (trace(&twice), lambda * volume_change);
    if PLATE {
        let [across, thickening] = across_plate(simd, ratio, volume_change, one + growth);
        stretched = stretched + across;
        volume_change = volume_change + thickening;
        pressure = across.mul_sub_from(mu, simd.splat(0.0));
    }
    let held = mu * stretched.mul_add(half, simd.splat(0.0) - volume_change);
    let held = (lambda * volume_change).mul_add(volume_change * half, held);
    let inverse = (one + growth).reciprocal();
    for row in 0..D {
        for column in 0..D {
            cofactors[row][column] = cofactors[row][column] * inverse;
        }
    }
    let mut second = twice;
    for row in 0..D {
        for column in 0..D {
            second[row][column] = mu * twice[row][column];
        }
        second[row][row] = second[row][row] + pressure;
    }
    let mut stress = second;
    for row in 0..D {
        for column in 0..D {
            let mut sum = cofactors[row][0] * second[0][column];
            for inner in 1..D {
                sum = cofactors[row][inner].mul_add(second[inner][column], sum);
            }
            stress[row][column] = sum;
        }
    }
    (held, stress)
}

/// The cofactors of a tensor.
#[inline(always)]
pub(crate) fn cofactors<S: Simd, const D: usize>(
    simd: S,
    tensor: &[[S::Lanes; D]; D],
) -> [[S::Lanes; D]; D] {
    let mut cofactors = *tensor;
    if D == 3 {
        for row in 0..D {
            let (below, above) = ((row + 1) % D, (row + 2) % D);
            for column in 0..D {
                let (right, left) = ((column + 1) % D, (column + 2) % D);
                let product = tensor[below][right] * tensor[above][left];
                cofactors[row][column] =
                    tensor[below][left].mul_sub_from(tensor[above][right], product);
            }
        }
    } else {
        let zero = simd.splat(0.0);
        for row in 0..D {
            for column in 0..D {
                let opposite = tensor[1 - row][1 - column];
                cofactors[row][column] = if row == column { opposite } else { zero - opposite };
            }
        }
    }
    cofactors
}

/// z = t^2 - 1 and ln t of the stretch t across a plate at which the law of Neo-Hooke has no stress: z + r (p + ln t) = 0, with
/// r = lambda/mu, p = ln J and J of the plane. Newton's method starts with the tangent at rest, or where that is less with t = 1/J,
/// which undoes all of a growing plane: for r > 0 both lie below, where it rises from step to step. Not a number where
/// it does not end, since for r < 0 there may be no such stretch.
#[inline(always)]
fn across_plate<S: Simd>(
    simd: S,
    ratio: S::Lanes,
    volume_change: S::Lanes,
    jacobian: S::Lanes,
) -> [S::Lanes; 2] {
    let (zero, one, half) = (simd.splat(0.0), simd.splat(1.0), simd.splat(0.5));
    let target = ratio * volume_change;
    let half_ratio = half * ratio;
    let tangent = (zero - target) / (one + half_ratio);
    let undoing = one / (jacobian * jacobian);
    let undone = undoing - one;
    let undoes = undone.above(tangent) & one.above(undoing);
    // z loses the digits of a small t^2, and t^2 those of a small z.
    let mut z = undone.or(undoes, tangent);
    let mut square = undoing.or(undoes, one + tangent);
    let mut moves = simd.mask(u8::MAX);
    for _ in 0..MOST_STEPS {
        let beyond = half_ratio.mul_add(logarithm(simd, square, z), z + target);
        let step = beyond * square / (square + half_ratio);
        let size = step.max(zero - step);
        // What is left is below the square of a step over t^2.
        let goes_on = size.above(square * simd.splat(CLOSE));
        z = (z - step).or(moves, z);
        square = (square - step).or(moves, square);
        moves = moves & goes_on;
        if moves.bits() == 0 {
            break;
        }
    }
    let z = simd.splat(f64::NAN).or(moves, z);
    [z, logarithm(simd, square, z) * half]
}
