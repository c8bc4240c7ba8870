//! What fields of deformation and stress are made of where bonds pull along themselves, summed up over blocks of bonds:
//! the shape tensor, that of displacements, and the stress.
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::family::{Bonds, Family, Stretches, Table};
use super::ordinary_plastic::Extensions;
use super::simd::{Kernel, Lanes, Simd};
use crate::families::LANES;

/// Sums over the bonds of a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BondSums<T, const D: usize> {
    /// sum w xi xi^T V
    pub(crate) shape: [[T; D]; D],
    /// sum w du xi^T V
    pub(crate) moved: [[T; D]; D],
    /// sum (|t_ij| + |t_ji|)/l eta xi^T V
    pub(crate) pulled: [[T; D]; D],
    /// sum w p/L xi xi^T V, of bonds that flow.
    pub(crate) flowed: [[T; D]; D],
}

/// A bond as these sums take it.
pub(super) struct Summand<F, const D: usize> {
    /// xi, du and eta
    pub(super) reference: [F; D],
    pub(super) moved: [F; D],
    pub(super) deformed: [F; D],
    /// w V, (|t_ij| + |t_ji|)/l V and w p/L V
    pub(super) weight: F,
    pub(super) pull: F,
    pub(super) flowed: Option<F>,
}

impl<F: Lanes, const D: usize> BondSums<F, D> {
    #[inline(always)]
    pub(super) fn new(zero: F) -> Self {
        let zero = [[zero; D]; D];
        Self { shape: zero, moved: zero, pulled: zero, flowed: zero }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, bond: &Summand<F, D>) {
        for row in 0..D {
            let x = bond.weight * bond.reference[row];
            let moved = bond.weight * bond.moved[row];
            let pulled = bond.pull * bond.deformed[row];
            for column in 0..D {
                let xi = bond.reference[column];
                self.moved[row][column] = moved.mul_add(xi, self.moved[row][column]);
                self.pulled[row][column] = pulled.mul_add(xi, self.pulled[row][column]);
                if column >= row {
                    self.shape[row][column] = x.mul_add(xi, self.shape[row][column]);
                }
            }
            if let Some(flowed) = bond.flowed {
                let flowed = flowed * bond.reference[row];
                for column in row..D {
                    let xi = bond.reference[column];
                    self.flowed[row][column] = flowed.mul_add(xi, self.flowed[row][column]);
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn totals(&self) -> BondSums<f64, D> {
        let zero = [[0.0; D]; D];
        let mut totals = BondSums { shape: zero, moved: zero, pulled: zero, flowed: zero };
        for row in 0..D {
            for column in 0..D {
                let (low, high) = if row < column { (row, column) } else { (column, row) };
                totals.shape[row][column] = self.shape[low][high].total();
                totals.flowed[row][column] = self.flowed[low][high].total();
                totals.moved[row][column] = self.moved[row][column].total();
                totals.pulled[row][column] = self.pulled[row][column].total();
            }
        }
        totals
    }
}

/// How bonds pull along themselves.
pub(crate) trait Pull<const D: usize>: Copy {
    /// (|t_ij| + |t_ji|)/l of the bonds from a slot of a point on, and p/L where they flow.
    fn at<S: Simd>(
        &self,
        simd: S,
        family: &Family<'_>,
        at: (usize, usize),
        bonds: &Bonds<S::Lanes, D>,
        stretches: Stretches<S::Lanes>,
    ) -> (S::Lanes, Option<S::Lanes>);
}

/// By w (a s + b) L from each end, or w (a s + b/L) L with `PER_LENGTH`: rows have a and b of points.
#[derive(Clone, Copy)]
pub(crate) struct ByPoints<'a, const PER_LENGTH: bool>(pub(crate) Table<'a, 4>);

impl<const D: usize, const PER_LENGTH: bool> Pull<D> for ByPoints<'_, PER_LENGTH> {
    #[inline(always)]
    fn at<S: Simd>(
        &self,
        simd: S,
        family: &Family<'_>,
        (point, slot): (usize, usize),
        bonds: &Bonds<S::Lanes, D>,
        stretches: Stretches<S::Lanes>,
    ) -> (S::Lanes, Option<S::Lanes>) {
        let [a, b, ..] = *self.0.row(point);
        // SAFETY: the search makes neighbours of points of the body alone, and each has a row.
        let [back_a, back_b, ..] = unsafe { self.0.columns(simd, 0, family.names::<S>(slot)) };
        let (mut b, mut back_b) = (simd.splat(b), back_b);
        if PER_LENGTH {
            let inverse = family.inverse_lengths(simd, slot, &bonds.reference);
            (b, back_b) = (b * inverse, back_b * inverse);
        }
        let own = simd.splat(a).mul_add(stretches.stretch, b);
        let back = back_a.mul_add(stretches.stretch, back_b);
        let both = family.weighted_both(simd, slot, &bonds.reference, own, back);
        (both * stretches.shrunk, None)
    }
}

/// By |t_ij|/L of each lane, with the lane at the other end of each bond, and p of each.
#[derive(Clone, Copy)]
pub(crate) struct ByLanes<'a> {
    pub(crate) pulls: &'a [f64],
    pub(crate) backs: &'a [u32],
    pub(crate) extensions: &'a [Extensions],
}

impl<const D: usize> Pull<D> for ByLanes<'_> {
    #[inline(always)]
    fn at<S: Simd>(
        &self,
        simd: S,
        family: &Family<'_>,
        (_, slot): (usize, usize),
        bonds: &Bonds<S::Lanes, D>,
        stretches: Stretches<S::Lanes>,
    ) -> (S::Lanes, Option<S::Lanes>) {
        let all = family.lane(slot);
        let pull = both_ends(simd, self.pulls, self.backs, all) * stretches.shrunk;
        let plastic = simd.load(&self.extensions[all / LANES][0][all % LANES..]);
        (pull, Some(plastic * family.inverse_lengths(simd, slot, &bonds.reference)))
    }
}

/// The sum of the numbers that both ends of the bonds have that stand from a lane on among all.
#[inline(always)]
pub(super) fn both_ends<S: Simd>(simd: S, numbers: &[f64], backs: &[u32], lane: usize) -> S::Lanes {
    let backs = &backs[lane..lane + S::WIDTH];
    let back = simd.each(|lane| numbers[backs[lane] as usize]);
    simd.load(&numbers[lane..lane + S::WIDTH]) + back
}

/// Gives the sums of the points of a range to `finish`.
pub(crate) struct FieldSums<'a, P, F, const D: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) pull: P,
    pub(crate) range: Range<usize>,
    pub(crate) finish: F,
}

impl<P, F, const D: usize> Kernel for FieldSums<'_, P, F, D>
where
    P: Pull<D>,
    F: FnMut(usize, &BondSums<f64, D>),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { family, pull, range, mut finish } = self;
        for point in range {
            let own = family.own(simd, point);
            let mut sums = BondSums::new(simd.splat(0.0));
            let (start, end) = family.swept(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let mask = simd.mask(family.bits(slot));
                let stretches = bonds.lengths(simd).stretches(simd, &family, slot);
                let (pull, mut flowed) = pull.at(simd, &family, (point, slot), &bonds, stretches);
                let weight = family.weighted(simd, slot, &bonds.reference, bonds.volume).only(mask);
                if let Some(flowed) = &mut flowed {
                    *flowed = (*flowed * weight).only(mask);
                }
                sums.add(&Summand {
                    reference: bonds.reference,
                    moved: bonds.moved,
                    deformed: bonds.deformed(),
                    weight,
                    pull: (pull * bonds.volume).only(mask),
                    flowed,
                });
            }
            finish(point, &sums.totals());
        }
    }
}
