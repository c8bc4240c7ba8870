//! The sweeps of bonds that pull along themselves, over blocks: of the linear peridynamic solid [P 3.14-3.20] and of the
//! form of Madenci and Oterkus [M].
//!
//! With s = l/L - 1 both ends of a bond pull with w (a s + b) L, so that the force on i is sum w V_j L/l (a_i s + b_i) y +
//! sum w V_j L/l (a_j s + b_j) y. The sums of the first part need nothing of the neighbours: the first sweep makes them with
//! those that a and b follow from, and leaves a_j V_j and b_j V_j for the second. In the linear solid a = C/m and
//! b = theta/m (D kappa - C/D); in the other form what is of the dilatation is divided by L (`PER_LENGTH`).

use std::ops::Range;

use super::family::{BreakHere, Family, Limits, Record, remaining};
use super::simd::{Kernel, Lanes, Simd};
use crate::families::LANES;

/// The first sweep: what the ends of bonds pull at their own points, and records with a V and b V for the second.
pub(crate) struct OwnPull<'a, M, const D: usize, const PER_LENGTH: bool> {
    pub(crate) family: Family<'a>,
    /// a and b of a point, of sum w L^2 V and sum w L^2 s V, per length of sum w L V and sum w L s V.
    pub(crate) pulls: M,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
    pub(crate) left: &'a mut [Record],
    pub(crate) breaking: Option<BreakHere<'a>>,
}

impl<M, const D: usize, const PER_LENGTH: bool> Kernel for OwnPull<'_, M, D, PER_LENGTH>
where
    M: Fn(usize, [f64; 2]) -> [f64; 2],
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { family, pulls, range, force, left, mut breaking } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        for ((force, left), point) in forces.iter_mut().zip(left).zip(range) {
            let mut limits = breaking.as_ref().map(|breaking| breaking.limits);
            let sums = loop {
                let masks = (remaining(&family, &breaking, point), limits);
                let (sums, close) = own_sums::<S, PER_LENGTH, D>(simd, &family, point, masks);
                if close == 0 || !breaking.as_mut().is_some_and(|of| of.judged(family, point)) {
                    break sums;
                }
                // Without those that broke.
                limits = None;
            };
            let OwnSums { weighted, sum, shear, dilated } = sums;
            let [a, b] = pulls(point, [weighted.total(), sum.total()]);
            for axis in 0..D {
                force[axis] = a * shear[axis].total() + b * dilated[axis].total();
            }
            *left = *family.record(point);
            left[7] = b * left[3];
            left[3] *= a;
        }
    }
}

/// What a point sums up in the first sweep.
struct OwnSums<F, const D: usize> {
    weighted: F,
    sum: F,
    /// What a and b are multiplied with.
    shear: [F; D],
    dilated: [F; D],
}

/// The sums over the bonds of a point that are in its masks, and with limits which bonds come close to theirs.
#[inline(always)]
fn own_sums<S: Simd, const PER_LENGTH: bool, const D: usize>(
    simd: S,
    family: &Family<'_>,
    point: usize,
    (masks, limits): (&[u8], Option<Limits<'_>>),
) -> (OwnSums<S::Lanes, D>, u8) {
    let zero = simd.splat(0.0);
    let own = family.own(simd, point);
    let (mut weighted, mut sum) = (zero, zero);
    let (mut shear, mut dilated) = ([zero; D], [zero; D]);
    let mut close = 0;
    let (start, end) = family.swept(point);
    for slot in (start..end).step_by(S::WIDTH) {
        let bonds = family.bonds::<S, D>(simd, &own, slot);
        let lengths = bonds.lengths(simd);
        let bits = masks[(slot - start) / LANES] >> (slot % LANES);
        if let Some(limits) = limits {
            close |= limits.close(simd, family, (point, slot), &lengths, bits);
        }
        let mask = simd.mask(bits);
        let at = lengths.stretches(simd, family, slot);
        let weight = family.weighted(simd, slot, &bonds.reference, bonds.volume);
        let along = if PER_LENGTH {
            weight * family.inverse_lengths(simd, slot, &bonds.reference)
        } else {
            weight
        };
        let moment = (along * lengths.squared).only(mask);
        weighted = weighted + moment;
        sum = sum + (moment * at.stretch).only(mask);
        let dilating = (along * at.shrunk).only(mask);
        let shearing = if PER_LENGTH { weight * at.shrunk } else { dilating };
        let shearing = (shearing * at.stretch).only(mask);
        let deformed = bonds.deformed();
        for axis in 0..D {
            shear[axis] = shearing.mul_add(deformed[axis], shear[axis]);
            dilated[axis] = dilating.mul_add(deformed[axis], dilated[axis]);
        }
    }
    (OwnSums { weighted, sum, shear, dilated }, close)
}

/// The second sweep: adds what the other ends of bonds pull. Gives the first point whose force is not finite.
pub(crate) struct OtherPull<'a, const D: usize, const PER_LENGTH: bool> {
    /// With the records that the first sweep has left.
    pub(crate) family: Family<'a>,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
}

impl<const D: usize, const PER_LENGTH: bool> Kernel for OtherPull<'_, D, PER_LENGTH> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { family, range, force } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        let mut bad = None;
        for (force, point) in forces.iter_mut().zip(range) {
            let own = family.own(simd, point);
            let mut sum = [simd.splat(0.0); D];
            let (start, end) = family.swept(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let at = bonds.lengths(simd).stretches(simd, &family, slot);
                let dilating = if PER_LENGTH {
                    bonds.last * family.inverse_lengths(simd, slot, &bonds.reference)
                } else {
                    bonds.last
                };
                let tension = at.stretch.mul_add(bonds.volume, dilating);
                let pull = family.weighted_back(simd, slot, &bonds.reference, tension) * at.shrunk;
                let pull = pull.only(simd.mask(family.bits(slot)));
                let deformed = bonds.deformed();
                for axis in 0..D {
                    sum[axis] = pull.mul_add(deformed[axis], sum[axis]);
                }
            }
            for axis in 0..D {
                force[axis] += sum[axis].total();
            }
            if bad.is_none() && !force.iter().all(|component| component.is_finite()) {
                bad = Some(point);
            }
        }
        bad
    }
}

/// Gives the sums that the first sweep makes, and sum w L^2 s^2 V, of the points of a range that are wanted to `finish`.
pub(crate) struct Extensions<'a, W, F, const D: usize, const PER_LENGTH: bool> {
    pub(crate) family: Family<'a>,
    pub(crate) range: Range<usize>,
    pub(crate) wanted: W,
    pub(crate) finish: F,
}

impl<W, F, const D: usize, const PER_LENGTH: bool> Kernel for Extensions<'_, W, F, D, PER_LENGTH>
where
    W: Fn(usize) -> bool,
    F: FnMut(usize, [f64; 2], f64),
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { family, range, wanted, mut finish } = self;
        for point in range {
            if !wanted(point) {
                continue;
            }
            let zero = simd.splat(0.0);
            let own = family.own(simd, point);
            let (mut weighted, mut sum, mut squares) = (zero, zero, zero);
            let (start, end) = family.swept(point);
            for slot in (start..end).step_by(S::WIDTH) {
                let bonds = family.bonds::<S, D>(simd, &own, slot);
                let lengths = bonds.lengths(simd);
                let mask = simd.mask(family.bits(slot));
                let at = lengths.stretches(simd, &family, slot);
                let square =
                    family.weighted(simd, slot, &bonds.reference, bonds.volume) * lengths.squared;
                let moment = if PER_LENGTH {
                    square * family.inverse_lengths(simd, slot, &bonds.reference)
                } else {
                    square
                };
                weighted = weighted + moment.only(mask);
                sum = sum + (moment * at.stretch).only(mask);
                squares = squares + (square * at.stretch * at.stretch).only(mask);
            }
            finish(point, [weighted.total(), sum.total()], squares.total());
        }
    }
}
