//! Stresses at the middle of bonds, over blocks of bonds. [P 4.21-4.35]
//!
//! With Hbar the mean of the displacement gradients of both ends, H_ij = Hbar + (du - Hbar xi) xi^T/L^2, so that F_ij xi = eta.
//! A bond pulls with 2 wbar P_ij xi/L^2 itself, and by Z_i = sum wbar P_ij (I - n n^T) V_j through the gradients of its ends.
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::elastic::{ElasticLaw, LaneLaw, SaintVenantKirchhoff};
use super::family::{Family, Table};
use super::simd::{Kernel, Lanes, Simd, SimdLevel, read_records};
use crate::families::LANES;

/// A law that is asked at bonds.
pub(crate) trait BondLaw<const D: usize> {
    /// Energy and stress of the displacement gradients of the bonds from a slot on, of those in `bits`.
    fn answer<S: Simd>(
        &mut self,
        simd: S,
        family: &Family<'_>,
        at: (usize, usize),
        bits: u8,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]);
}

/// Elastic laws of points, in lanes: bonds have the mean of the laws of their ends.
#[derive(Clone, Copy)]
pub(crate) struct LawsOfPoints<F> {
    pub(crate) of: F,
    /// Whether it is one law for all.
    pub(crate) is_common: bool,
    pub(crate) level: SimdLevel,
}

/// What a law with memory has answered at the slots of bonds.
#[derive(Clone, Copy)]
pub(crate) struct Answered<'a> {
    /// Four numbers of records a row.
    rows: &'a [[f64; 4]],
    /// Rows of a record.
    width: usize,
    /// Where it has the energy that is asked for.
    energy: usize,
}

impl<'a> Answered<'a> {
    /// Records of so many numbers, a multiple of four: P as of a solid in space, and the energy at a place.
    pub(crate) fn new(records: &'a [f64], width: usize, energy: usize) -> Self {
        assert!(width.is_multiple_of(4) && width >= 12 && (9..12).contains(&energy));
        Self { rows: records.as_chunks().0, width: width / 4, energy }
    }
}

impl<const D: usize> BondLaw<D> for Answered<'_> {
    #[inline(always)]
    fn answer<S: Simd>(
        &mut self,
        simd: S,
        family: &Family<'_>,
        (_, slot): (usize, usize),
        bits: u8,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        let first = family.lane(slot) * self.width;
        let rows = &self.rows[first..first + S::WIDTH * self.width];
        let mut at = [0; LANES];
        for lane in 0..S::WIDTH {
            at[lane] = lane * self.width;
        }
        let mut numbers = [simd.splat(0.0); 12];
        read_records(simd, rows, &at, &mut numbers);
        let (mask, mut stress) = (simd.mask(bits), *gradient);
        for row in 0..D {
            for column in 0..D {
                stress[row][column] = numbers[3 * row + column].only(mask);
            }
        }
        (numbers[self.energy], stress)
    }
}

/// One bond after the other: by point, slot, other end and displacement gradient.
#[derive(Clone, Copy)]
pub(crate) struct BondByBond<F>(pub(crate) F);

impl<F, const D: usize> BondLaw<D> for BondByBond<F>
where
    F: FnMut(usize, usize, usize, &[[f64; D]; D]) -> (f64, [[f64; D]; D]),
{
    #[inline(always)]
    fn answer<S: Simd>(
        &mut self,
        simd: S,
        family: &Family<'_>,
        (point, slot): (usize, usize),
        bits: u8,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        let (mut gradients, mut stresses) = ([[[0.0; 8]; D]; D], [[[0.0; 8]; D]; D]);
        let mut energies = [0.0; 8];
        for row in 0..D {
            for column in 0..D {
                gradient[row][column].store(&mut gradients[row][column]);
            }
        }
        let names = family.names::<S>(slot);
        for lane in 0..S::WIDTH {
            if bits >> lane & 1 == 0 {
                continue;
            }
            let mut own = [[0.0; D]; D];
            for row in 0..D {
                for column in 0..D {
                    own[row][column] = gradients[row][column][lane];
                }
            }
            let (energy, stress) =
                (self.0)(point, family.lane(slot + lane), names[lane] as usize, &own);
            energies[lane] = energy;
            for row in 0..D {
                for column in 0..D {
                    stresses[row][column][lane] = stress[row][column];
                }
            }
        }
        let mut stress = *gradient;
        for row in 0..D {
            for column in 0..D {
                stress[row][column] = simd.load(&stresses[row][column]);
            }
        }
        (simd.load(&energies), stress)
    }
}

/// Where a row of the table has 1/sum w V, behind the gradient.
pub(crate) const fn weight_place(dimension: usize) -> usize {
    dimension * dimension
}

/// Where it has 1 if the family of the point does not span the body, and else 0.
pub(crate) const fn odd_place(dimension: usize) -> usize {
    weight_place(dimension) + 1
}

/// What sweeps over the middles of bonds share.
#[derive(Clone, Copy)]
pub(crate) struct Middles<'a, const C: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) table: Table<'a, C>,
}

/// What the middles of all bonds of a point share.
struct End<F, const D: usize> {
    record: [F; 8],
    /// Halves of its gradient and of 1/sum w V.
    half_gradient: [[F; D]; D],
    half_weight: F,
}

/// The middles of a block of bonds.
struct Middle<F, const D: usize> {
    /// xi and xi/L^2
    reference: [F; D],
    along: [F; D],
    /// H_ij
    gradient: [[F; D]; D],
    /// 1/sum w V of the other end, and 1 if its family does not span the body.
    weight: F,
    odd: F,
    volume: F,
}

impl<const C: usize> Middles<'_, C> {
    #[inline(always)]
    fn end<S: Simd, const D: usize>(&self, simd: S, point: usize) -> End<S::Lanes, D> {
        let row = self.table.row(point);
        let mut half_gradient = [[simd.splat(0.0); D]; D];
        for axis in 0..D {
            for column in 0..D {
                half_gradient[axis][column] = simd.splat(0.5 * row[axis * D + column]);
            }
        }
        let half_weight = simd.splat(0.5 * row[weight_place(D)]);
        End { record: self.family.own(simd, point), half_gradient, half_weight }
    }

    #[inline(always)]
    fn at<S: Simd, const D: usize>(
        &self,
        simd: S,
        end: &End<S::Lanes, D>,
        slot: usize,
        mask: S::Mask,
    ) -> Middle<S::Lanes, D> {
        let Self { family, table } = *self;
        let (zero, one, half) = (simd.splat(0.0), simd.splat(1.0), simd.splat(0.5));
        let bonds = family.bonds::<S, D>(simd, &end.record, slot);
        let xi = bonds.reference;
        let mut columns = [zero; C];
        table.ask_ahead(&family, slot, S::WIDTH);
        for first in (0..odd_place(D) + 1).step_by(4) {
            // SAFETY: the search makes neighbours of points of the body alone, and each has a row.
            let four = unsafe { table.columns(simd, first, family.names::<S>(slot)) };
            columns[first..first + 4].copy_from_slice(&four);
        }
        let mut squared = xi[0] * xi[0];
        for x in &xi[1..] {
            squared = x.mul_add(*x, squared);
        }
        // Lanes without a bond have no length.
        let inverse = family.inverse_squares(simd, slot, squared.or(mask, one));
        let (mut along, mut gradient) = (xi, end.half_gradient);
        for axis in 0..D {
            along[axis] = xi[axis] * inverse;
            let mut unseen = bonds.moved[axis];
            for column in 0..D {
                let own = end.half_gradient[axis][column];
                let mean = columns[axis * D + column].mul_add(half, own);
                gradient[axis][column] = mean;
                unseen = mean.mul_sub_from(xi[column], unseen);
            }
            for column in 0..D {
                gradient[axis][column] =
                    unseen.mul_add(xi[column] * inverse, gradient[axis][column]);
            }
        }
        let (weight, odd) = (columns[weight_place(D)], columns[odd_place(D)].only(mask));
        Middle { reference: xi, along, gradient, weight, odd, volume: bonds.volume }
    }
}

/// Gives Z_i and the force of all bonds themselves to `finish`, for the points of a range that are wanted; and whether
/// one of the ends does not span the body, so that bonds are to be asked otherwise.
pub(crate) struct BondStresses<'a, L, W, F, const D: usize, const C: usize> {
    pub(crate) middles: Middles<'a, C>,
    pub(crate) law: L,
    pub(crate) range: Range<usize>,
    pub(crate) wanted: W,
    pub(crate) finish: F,
}

impl<L, W, F, const D: usize, const C: usize> Kernel for BondStresses<'_, L, W, F, D, C>
where
    L: BondLaw<D>,
    W: Fn(usize) -> bool,
    F: FnMut(usize, &[[f64; D]; D], &[f64; D], bool),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { middles, mut law, range, wanted, mut finish } = self;
        let (family, zero, half) = (middles.family, simd.splat(0.0), simd.splat(0.5));
        for point in range {
            if !wanted(point) {
                continue;
            }
            let end = middles.end::<S, D>(simd, point);
            let (mut through, mut straight, mut odd) = ([[zero; D]; D], [zero; D], zero);
            let (start, stop) = family.swept(point);
            for slot in (start..stop).step_by(S::WIDTH) {
                let bits = family.bits(slot);
                let mask = simd.mask(bits);
                let at = middles.at(simd, &end, slot, mask);
                odd = odd + at.odd;
                let (_, stress) = law.answer(simd, &family, (point, slot), bits, &at.gradient);
                let weight = family.weighted_both(
                    simd,
                    slot,
                    &at.reference,
                    end.half_weight,
                    at.weight * half,
                );
                let weight = (weight * at.volume).only(mask);
                for axis in 0..D {
                    let mut pull = stress[axis][0] * at.along[0];
                    for column in 1..D {
                        pull = stress[axis][column].mul_add(at.along[column], pull);
                    }
                    straight[axis] = weight.mul_add(pull, straight[axis]);
                    for column in 0..D {
                        let across = pull.mul_sub_from(at.reference[column], stress[axis][column]);
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
            finish(point, &sum, &force, odd.total() + middles.table.row(point)[odd_place(D)] > 0.0);
        }
    }
}

/// Gives the means of energies and, with `STRESS`, of stresses, sum w P_ij V_j/sum w V, to `finish` in the same way.
pub(crate) struct BondMeans<'a, L, W, F, const STRESS: bool, const D: usize, const C: usize> {
    pub(crate) middles: Middles<'a, C>,
    pub(crate) law: L,
    pub(crate) range: Range<usize>,
    pub(crate) wanted: W,
    pub(crate) finish: F,
}

impl<L, W, F, const STRESS: bool, const D: usize, const C: usize> Kernel
    for BondMeans<'_, L, W, F, STRESS, D, C>
where
    L: BondLaw<D>,
    W: Fn(usize) -> bool,
    F: FnMut(usize, f64, &[[f64; D]; D], bool),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { middles, mut law, range, wanted, mut finish } = self;
        let family = middles.family;
        for point in range {
            if !wanted(point) {
                continue;
            }
            let end = middles.end::<S, D>(simd, point);
            let (mut sum, mut odd) = (simd.splat(0.0), simd.splat(0.0));
            let mut stresses = [[simd.splat(0.0); D]; D];
            let (start, stop) = family.swept(point);
            for slot in (start..stop).step_by(S::WIDTH) {
                let bits = family.bits(slot);
                let mask = simd.mask(bits);
                let at = middles.at(simd, &end, slot, mask);
                odd = odd + at.odd;
                let (energy, stress) = law.answer(simd, &family, (point, slot), bits, &at.gradient);
                if !STRESS {
                    let held = family.weighted(simd, slot, &at.reference, energy * at.volume);
                    sum = sum + held.only(mask);
                    continue;
                }
                let weight = family.weighted(simd, slot, &at.reference, at.volume).only(mask);
                sum = sum + (weight * energy).only(mask);
                for row in 0..D {
                    for column in 0..D {
                        let stress = stress[row][column].only(mask);
                        stresses[row][column] = weight.mul_add(stress, stresses[row][column]);
                    }
                }
            }
            let row = middles.table.row(point);
            let mut stress = [[0.0; D]; D];
            if STRESS {
                for axis in 0..D {
                    for column in 0..D {
                        stress[axis][column] =
                            stresses[axis][column].total() * row[weight_place(D)];
                    }
                }
            }
            let held = sum.total() * row[weight_place(D)];
            finish(point, held, &stress, odd.total() + row[odd_place(D)] > 0.0);
        }
    }
}

impl<F: Fn(usize) -> ElasticLaw, const D: usize> BondLaw<D> for LawsOfPoints<F> {
    #[inline(always)]
    fn answer<S: Simd>(
        &mut self,
        simd: S,
        family: &Family<'_>,
        (point, slot): (usize, usize),
        bits: u8,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        // What lanes without a bond hold may be turned inside out.
        let (mask, mut gradient) = (simd.mask(bits), *gradient);
        for row in 0..D {
            for column in 0..D {
                gradient[row][column] = gradient[row][column].only(mask);
            }
        }
        let own = (self.of)(point);
        if self.is_common {
            return own.with_each((simd, self.level), None, &gradient);
        }
        let mut others = [own; LANES];
        for (other, &name) in others.iter_mut().zip(family.names::<S>(slot)) {
            *other = (self.of)(name as usize);
        }
        own.with_each((simd, self.level), Some(&others), &gradient)
    }
}

impl<const D: usize> BondLaw<D> for SaintVenantKirchhoff {
    #[inline(always)]
    fn answer<S: Simd>(
        &mut self,
        simd: S,
        _: &Family<'_>,
        _: (usize, usize),
        _: u8,
        gradient: &[[S::Lanes; D]; D],
    ) -> (S::Lanes, [[S::Lanes; D]; D]) {
        self.at(simd, gradient)
    }
}
