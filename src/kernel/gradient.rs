//! The gradient of the displacement at points, over blocks of bonds: grad u = sum w du (rows q)^T V with the monomials q
//! of bonds. [P 3.31-3.53]
//!
//! The rows follow from the bonds alone. They are kept with the masks that they belong to, and made anew where a bond
//! of the family has changed.
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::family::{Bonds, BreakHere, Family, Limits, remaining};
use super::simd::{Kernel, Lanes, Simd};
use crate::families::Property;

/// Most monomials.
const MOST: usize = 9;

/// sum w q q^T V, sum w q V, sum w V and sum V of a point.
pub(crate) struct Moments {
    pub(crate) products: [[f64; MOST]; MOST],
    pub(crate) sums: [f64; MOST],
    pub(crate) weight: f64,
    pub(crate) volume: f64,
}

/// How the gradient of a point is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// As it stands.
    Even,
    /// In two steps, the second from what the first has left.
    Steep,
    /// Not here.
    Odd,
}

/// What stands for the kind where nothing is kept of a point.
pub(crate) const NOTHING_KEPT: f64 = 0.0;

/// Numbers that are kept of a point before the rows: kind, 1/sum w V and sum V.
pub(crate) const BEFORE_ROWS: usize = 3;

/// What is kept of a point: these, the rows and sum w q V.
pub(crate) const fn kept_width(dimension: usize, size: usize) -> usize {
    BEFORE_ROWS + size * (dimension + 1)
}

impl Kind {
    pub(crate) fn number(self) -> f64 {
        match self {
            Self::Even => 1.0,
            Self::Steep => 2.0,
            Self::Odd => 3.0,
        }
    }

    /// Of what is kept of a point.
    #[inline(always)]
    pub(crate) fn of(kept: &[f64]) -> Self {
        match kept[0] {
            1.0 => Self::Even,
            2.0 => Self::Steep,
            _ => Self::Odd,
        }
    }
}

/// What is kept of the points of a range, and the masks that it belongs to.
pub(crate) struct Kept<'a> {
    pub(crate) numbers: &'a mut [f64],
    pub(crate) masks: &'a mut [u8],
}

/// What is done with the gradient at a point, and what is kept of the point.
pub(crate) type Finish<'a, const D: usize> = dyn FnMut(usize, &[f64], &[[f64; D]; D]) + 'a;

/// Makes what is kept of a point from the masks of its bonds and their moments.
pub(crate) type Keep<'a> = dyn Fn(usize, &[u8], &Moments, &mut [f64]) + 'a;

/// Gradients of the points of a range that are wanted, given to `finish`; what is kept of points is made by `keep`. What
/// is asked once a point is called and not compiled in: the loops over bonds are the same for all.
pub(crate) struct GradientSweep<'a, const D: usize, const SIZE: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) horizons: &'a Property,
    pub(crate) range: Range<usize>,
    pub(crate) breaking: Option<BreakHere<'a>>,
    pub(crate) kept: Kept<'a>,
    pub(crate) wanted: &'a dyn Fn(usize) -> bool,
    pub(crate) keep: &'a Keep<'a>,
    pub(crate) finish: &'a mut Finish<'a, D>,
}

/// Monomials of bonds: their vectors, and with second order these over the horizon and their products.
#[inline(always)]
pub(super) fn monomials<S: Simd, const D: usize, const SIZE: usize>(
    simd: S,
    reference: &[S::Lanes; D],
    horizon: f64,
) -> [S::Lanes; SIZE] {
    let mut terms = [simd.splat(0.0); SIZE];
    if SIZE == D {
        terms[..D].copy_from_slice(reference);
        return terms;
    }
    let scale = simd.splat(1.0 / horizon);
    for axis in 0..D {
        let q = reference[axis] * scale;
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

impl<const D: usize, const SIZE: usize> Kernel for GradientSweep<'_, D, SIZE> {
    /// Whether there are odd points among them, which `finish` has not seen.
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Self { family, horizons, range, mut breaking, kept, wanted, keep, finish } = self;
        let (width, start) = (kept_width(D, SIZE), family.slots(range.start).0 / 8);
        let mut odd = false;
        for (kept_here, point) in kept.numbers.chunks_exact_mut(width).zip(range) {
            if !wanted(point) {
                continue;
            }
            let sums = Sums { simd, family, horizon: horizons.at(point) };
            let mut limits = breaking.as_ref().map(|breaking| breaking.limits);
            let moved = loop {
                let masks = remaining(&family, &breaking, point);
                let (moved, close) = sums.moved::<D, SIZE>(point, (masks, limits));
                if close == 0 || !breaking.as_mut().is_some_and(|of| of.judged(family, point)) {
                    break moved;
                }
                // Without those that broke.
                limits = None;
            };
            let masks = remaining(&family, &breaking, point);
            let (first, end) = family.slots(point);
            let blocks = first / 8 - start..end / 8 - start;
            let old = &mut kept.masks[blocks];
            if kept_here[0] == NOTHING_KEPT || old != masks {
                // Nothing is kept while masks and rows do not belong together, should a panic come between.
                kept_here[0] = NOTHING_KEPT;
                old.copy_from_slice(masks);
                keep(point, masks, &sums.moments::<D, SIZE>(point, masks), kept_here);
            }
            let kind = Kind::of(kept_here);
            if kind == Kind::Odd {
                odd = true;
                continue;
            }
            let mut gradient = times_rows::<D, SIZE>(&moved, kept_here);
            if kind == Kind::Steep {
                let rest = sums.unseen::<D, SIZE>(point, old, &gradient);
                let rest = times_rows::<D, SIZE>(&rest, kept_here);
                for (row, rest) in gradient.iter_mut().zip(&rest) {
                    for (value, rest) in row.iter_mut().zip(rest) {
                        *value += rest;
                    }
                }
            }
            finish(point, kept_here, &gradient);
        }
        odd
    }
}

/// sum w du (rows q)^T V of sum w du q^T V.
#[inline(always)]
fn times_rows<const D: usize, const SIZE: usize>(
    moved: &[[f64; SIZE]; D],
    kept: &[f64],
) -> [[f64; D]; D] {
    let rows = &kept[BEFORE_ROWS..BEFORE_ROWS + D * SIZE];
    let mut gradient = [[0.0; D]; D];
    for row in 0..D {
        for column in 0..D {
            let mut sum = 0.0;
            for k in 0..SIZE {
                sum += moved[row][k] * rows[column * SIZE + k];
            }
            gradient[row][column] = sum;
        }
    }
    gradient
}

/// What the loops over bonds share.
struct Sums<'a, S> {
    simd: S,
    family: Family<'a>,
    horizon: f64,
}

impl<S: Simd> Sums<'_, S> {
    /// sum w du q^T V, and with limits which bonds come close to theirs.
    #[inline(always)]
    fn moved<const D: usize, const SIZE: usize>(
        &self,
        point: usize,
        (masks, limits): (&[u8], Option<Limits<'_>>),
    ) -> ([[f64; SIZE]; D], u8) {
        let Self { simd, family, .. } = *self;
        let mut close = 0;
        let own = family.own(simd, point);
        let mut sum = [[simd.splat(0.0); SIZE]; D];
        let (start, end) = family.swept(point);
        for slot in (start..end).step_by(S::WIDTH) {
            let bonds = family.bonds::<S, D>(simd, &own, slot);
            let bits = masks[(slot - start) / 8] >> (slot % 8);
            if let Some(limits) = limits {
                close |= limits.close(simd, &family, (point, slot), &bonds.lengths(simd), bits);
            }
            self.add(&mut sum, slot, bits, &bonds, &bonds.moved);
        }
        (totals(&sum), close)
    }

    /// Adds w du q^T V of the bonds from a slot on.
    #[inline(always)]
    fn add<const D: usize, const SIZE: usize>(
        &self,
        sum: &mut [[S::Lanes; SIZE]; D],
        slot: usize,
        bits: u8,
        bonds: &Bonds<S::Lanes, D>,
        moved: &[S::Lanes; D],
    ) {
        let Self { simd, family, horizon } = *self;
        let weight =
            family.weighted(simd, slot, &bonds.reference, bonds.volume).only(simd.mask(bits));
        let q = monomials::<S, D, SIZE>(simd, &bonds.reference, horizon);
        for row in 0..D {
            let weighted = weight * moved[row];
            for k in 0..SIZE {
                sum[row][k] = weighted.mul_add(q[k], sum[row][k]);
            }
        }
    }

    /// The same of what a gradient does not see of du.
    #[inline(always)]
    fn unseen<const D: usize, const SIZE: usize>(
        &self,
        point: usize,
        masks: &[u8],
        gradient: &[[f64; D]; D],
    ) -> [[f64; SIZE]; D] {
        let Self { simd, family, .. } = *self;
        let own = family.own(simd, point);
        let mut sum = [[simd.splat(0.0); SIZE]; D];
        let (start, end) = family.swept(point);
        for slot in (start..end).step_by(S::WIDTH) {
            let bonds = family.bonds::<S, D>(simd, &own, slot);
            let bits = masks[(slot - start) / 8] >> (slot % 8);
            let rest = unseen_of(simd, &bonds, gradient);
            self.add(&mut sum, slot, bits, &bonds, &rest);
        }
        totals(&sum)
    }

    #[inline(always)]
    fn moments<const D: usize, const SIZE: usize>(&self, point: usize, masks: &[u8]) -> Moments {
        let Self { simd, family, horizon } = *self;
        let own = family.own(simd, point);
        let zero = simd.splat(0.0);
        let (mut products, mut sums) = ([[zero; SIZE]; SIZE], [zero; SIZE]);
        let (mut weights, mut volumes) = (zero, zero);
        let (start, end) = family.swept(point);
        for slot in (start..end).step_by(S::WIDTH) {
            let bonds = family.bonds::<S, D>(simd, &own, slot);
            let bits = masks[(slot - start) / 8] >> (slot % 8);
            let mask = simd.mask(bits);
            let weight = family.weighted(simd, slot, &bonds.reference, bonds.volume).only(mask);
            let q = monomials::<S, D, SIZE>(simd, &bonds.reference, horizon);
            weights = weights + weight;
            volumes = volumes + bonds.volume.only(mask);
            for row in 0..SIZE {
                let weighted = weight * q[row];
                sums[row] = sums[row] + weighted;
                for column in 0..=row {
                    products[row][column] = weighted.mul_add(q[column], products[row][column]);
                }
            }
        }
        let mut moments = Moments {
            products: [[0.0; MOST]; MOST],
            sums: [0.0; MOST],
            weight: weights.total(),
            volume: volumes.total(),
        };
        for row in 0..SIZE {
            moments.sums[row] = sums[row].total();
            for column in 0..=row {
                let total = products[row][column].total();
                moments.products[row][column] = total;
                moments.products[column][row] = total;
            }
        }
        moments
    }
}

/// Gives sum w z z^T V to `finish` for the points of a range, with z = du - H xi what a gradient H does not see of bonds.
pub(crate) struct UnseenSweep<'a, H, F, const D: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) range: Range<usize>,
    pub(crate) gradient: H,
    pub(crate) finish: F,
}

impl<H, F, const D: usize> Kernel for UnseenSweep<'_, H, F, D>
where
    H: Fn(usize) -> Option<[[f64; D]; D]>,
    F: FnMut(usize, &[[f64; D]; D]),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { family, range, gradient, mut finish } = self;
        for point in range {
            let Some(gradient) = gradient(point) else { continue };
            let own = family.own(simd, point);
            let mut sum = [[simd.splat(0.0); D]; D];
            let (start, end) = family.swept(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let mask = simd.mask(family.bits(slot));
                let weight = family.weighted(simd, slot, &bonds.reference, bonds.volume).only(mask);
                let rest = unseen_of(simd, &bonds, &gradient);
                for row in 0..D {
                    let weighted = weight * rest[row];
                    for column in 0..D {
                        sum[row][column] = weighted.mul_add(rest[column], sum[row][column]);
                    }
                }
            }
            finish(point, &totals(&sum));
        }
    }
}

/// du - H xi
#[inline(always)]
fn unseen_of<S: Simd, const D: usize>(
    simd: S,
    bonds: &Bonds<S::Lanes, D>,
    gradient: &[[f64; D]; D],
) -> [S::Lanes; D] {
    let mut rest = bonds.moved;
    for row in 0..D {
        for axis in 0..D {
            let slope = simd.splat(gradient[row][axis]);
            rest[row] = slope.mul_sub_from(bonds.reference[axis], rest[row]);
        }
    }
    rest
}

#[inline(always)]
fn totals<F: Lanes, const D: usize, const SIZE: usize>(sums: &[[F; SIZE]; D]) -> [[f64; SIZE]; D] {
    let mut totals = [[0.0; SIZE]; D];
    for row in 0..D {
        for k in 0..SIZE {
            totals[row][k] = sums[row][k].total();
        }
    }
    totals
}
