//! Stresses at the middle of bonds, over blocks of bonds. [P 4.21-4.35]
//!
//! With Hbar the mean of the displacement gradients of both ends, H_ij = Hbar + (du - Hbar xi) xi^T/L^2, so that F_ij xi = eta.
//! A bond pulls with 2 wbar P_ij xi/L^2 itself, and by Z_i = sum wbar P_ij (I - n n^T) V_j through the gradients of its ends.
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::family::{Family, Table};
use super::simd::{Kernel, Lanes, Simd};

/// A law that is asked in lanes: Saint Venant-Kirchhoff with lambda and mu.
#[derive(Clone, Copy)]
pub(crate) struct Stress {
    pub(crate) lambda: f64,
    pub(crate) mu: f64,
}

/// Where a row of the table has 1/sum w V, behind the gradient.
pub(crate) const fn weight_place(dimension: usize) -> usize {
    dimension * dimension
}

/// Where it has 1 if the family of the point does not span the body, and else 0.
pub(crate) const fn odd_place(dimension: usize) -> usize {
    weight_place(dimension) + 1
}

/// Gives Z_i and the force of all bonds themselves to `finish`, for the points of a range; and whether one of the
/// ends does not span the body, so that bonds are to be asked otherwise.
pub(crate) struct BondStresses<'a, F, const D: usize, const C: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) table: Table<'a, C>,
    pub(crate) stress: Stress,
    pub(crate) range: Range<usize>,
    pub(crate) finish: F,
}

impl<F, const D: usize, const C: usize> Kernel for BondStresses<'_, F, D, C>
where
    F: FnMut(usize, &[[f64; D]; D], &[f64; D], bool),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { family, table, stress, range, mut finish } = self;
        let (zero, one, half) = (simd.splat(0.0), simd.splat(1.0), simd.splat(0.5));
        for point in range {
            let own = family.own(simd, point);
            let row = table.row(point);
            let mut own_half = [[zero; D]; D];
            for axis in 0..D {
                for column in 0..D {
                    own_half[axis][column] = simd.splat(0.5 * row[axis * D + column]);
                }
            }
            let own_weight = simd.splat(0.5 * row[weight_place(D)]);
            let (mut through, mut straight, mut odd) = ([[zero; D]; D], [zero; D], zero);
            let (start, end) = family.slots(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let mask = simd.mask(family.bits(slot));
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let xi = bonds.reference;
                let mut columns = [zero; C];
                for first in (0..=odd_place(D)).step_by(4) {
                    // SAFETY: the search makes neighbours of points of the body alone, and each has a row.
                    let four = unsafe { table.columns(simd, first, family.names::<S>(slot)) };
                    columns[first..first + 4].copy_from_slice(&four);
                }
                odd = odd + columns[odd_place(D)].only(mask);
                let mut squared = xi[0] * xi[0];
                for x in &xi[1..] {
                    squared = x.mul_add(*x, squared);
                }
                // Lanes without a bond have no length.
                let inverse = squared.or(mask, one).reciprocal();
                let (mut along, mut gradient) = (xi, own_half);
                for axis in 0..D {
                    along[axis] = xi[axis] * inverse;
                    let mut unseen = bonds.moved[axis];
                    for column in 0..D {
                        let mean = columns[axis * D + column].mul_add(half, own_half[axis][column]);
                        gradient[axis][column] = mean;
                        unseen = mean.mul_sub_from(xi[column], unseen);
                    }
                    for column in 0..D {
                        gradient[axis][column] =
                            unseen.mul_add(xi[column] * inverse, gradient[axis][column]);
                    }
                }
                let stress = stress.answer::<S, D>(simd, &gradient);
                let weight = columns[weight_place(D)].mul_add(half, own_weight) * bonds.volume;
                let weight = family.weighted(simd, slot, &bonds.reference, weight).only(mask);
                for axis in 0..D {
                    let mut pull = stress[axis][0] * along[0];
                    for column in 1..D {
                        pull = stress[axis][column].mul_add(along[column], pull);
                    }
                    straight[axis] = weight.mul_add(pull, straight[axis]);
                    for column in 0..D {
                        let across = pull.mul_sub_from(xi[column], stress[axis][column]);
                        through[axis][column] = weight.mul_add(across, through[axis][column]);
                    }
                }
            }
            let (mut sum, mut force) = ([[0.0; D]; D], [0.0; D]);
            for axis in 0..D {
                force[axis] = 2.0 * straight[axis].total();
                for column in 0..D {
                    sum[axis][column] = through[axis][column].total();
                }
            }
            finish(point, &sum, &force, odd.total() > 0.0 || row[odd_place(D)] > 0.0);
        }
    }
}

impl Stress {
    /// P = F (lambda tr(E) I + 2 mu E) of a displacement gradient, with 2 E = H + H^T + H^T H.
    #[inline(always)]
    pub(super) fn answer<S: Simd, const D: usize>(
        &self,
        simd: S,
        gradient: &[[S::Lanes; D]; D],
    ) -> [[S::Lanes; D]; D] {
        let (half_lambda, mu) = (simd.splat(0.5 * self.lambda), simd.splat(self.mu));
        let mut second = *gradient;
        for row in 0..D {
            for column in row..D {
                let mut twice = gradient[row][column] + gradient[column][row];
                for line in gradient {
                    twice = line[row].mul_add(line[column], twice);
                }
                second[row][column] = twice;
            }
        }
        let mut trace = second[0][0];
        for axis in 1..D {
            trace = trace + second[axis][axis];
        }
        let pressure = half_lambda * trace;
        for row in 0..D {
            for column in row..D {
                let shear = mu * second[row][column];
                second[row][column] = if row == column { shear + pressure } else { shear };
                second[column][row] = second[row][column];
            }
        }
        let mut stress = second;
        for row in 0..D {
            for column in 0..D {
                for inner in 0..D {
                    stress[row][column] =
                        gradient[row][inner].mul_add(second[inner][column], stress[row][column]);
                }
            }
        }
        stress
    }
}
