//! The bond-based sweep over blocks of bonds: forces, and which bonds break. [P 3.8-3.11]
//!
//! With xi the bond's reference vector, y = xi + du, L = |xi|, l = |y| and z = du.(xi + y)/L^2 = (l/L)^2 - 1, the
//! force on i is the sum of c d V_j (1/L - 1/l) y = c d V_j/L g(z) y, where g is [`Lanes::shortfall`]: exactly zero where
//! the ends move alike, and without the cancellation of l - L. A stretch beyond s is a z beyond s (2 + s).

use std::ops::Range;

use super::simd::{Kernel, Lanes, Mask, Simd};
use crate::families::{Bond, Families, LANES};

/// A point where it is: place, volume and displacement, in a line of the cache.
pub(crate) type Record = [f64; 8];

/// What the sweep reads.
#[derive(Clone, Copy)]
pub(crate) struct Cloud<'a> {
    families: &'a Families,
    records: &'a [Record],
    /// One bit a lane.
    intact: &'a [u8],
}

impl<'a> Cloud<'a> {
    /// Panics when there is not a record a point and a mask a block.
    pub(crate) fn new(families: &'a Families, records: &'a [Record], intact: &'a [u8]) -> Self {
        assert_eq!(records.len() + 1, families.offsets.len());
        assert_eq!(intact.len(), families.block_count());
        Self { families, records, intact }
    }
}

/// Bonds of a point that are computed together.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) point: usize,
    /// Where the first of them stands among all lanes.
    pub(crate) slot: usize,
    pub(crate) neighbors: &'a [u32],
    pub(crate) lengths: &'a [f64],
}

impl Part<'_> {
    #[inline(always)]
    pub(crate) fn bond(&self, lane: usize) -> Bond {
        Bond {
            slot: self.slot + lane,
            neighbor: self.neighbors[lane] as usize,
            length: self.lengths[lane],
        }
    }
}

/// How stiff bonds are and when they break, for one scene.
pub(crate) trait BondLaw: Copy + Sync {
    /// What all forces are multiplied with.
    fn factor(&self) -> f64;
    /// Weights of bonds, each times what else its stiffness has.
    fn stiffen<S: Simd>(&self, simd: S, part: &Part<'_>, weight: S::Lanes) -> S::Lanes;
    /// (l/L)^2 - 1 beyond which a bond breaks.
    fn threshold<S: Simd>(&self, simd: S, part: &Part<'_>) -> S::Lanes;
    /// Lanes of a block that may break.
    fn breakable(&self, block: usize) -> u8;
}

/// Forces per volume on the points of a range. With `remaining`, bonds beyond their threshold break first, and the
/// masks of the range's blocks are written there. Gives the first point whose force is not finite.
pub(crate) struct ForceSweep<'a, L, const D: usize> {
    pub(crate) cloud: Cloud<'a>,
    pub(crate) law: L,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
    pub(crate) remaining: Option<&'a mut [u8]>,
}

impl<L: BondLaw, const D: usize> Kernel for ForceSweep<'_, L, D> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { cloud, law, range, force, mut remaining } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        let first = cloud.families.offsets[range.start] as usize;
        let mut bad = None;
        for (force, point) in forces.iter_mut().zip(range) {
            let mut sum = [simd.splat(0.0); D];
            for block in cloud.families.blocks(point) {
                let mask = cloud.intact[block];
                if let Some(remaining) = &mut remaining {
                    remaining[block - first] =
                        cloud.pull::<S, true, D>(simd, law, point, block, mask, &mut sum);
                } else {
                    cloud.pull::<S, false, D>(simd, law, point, block, mask, &mut sum);
                }
            }
            *force = sum.map(|sum| law.factor() * sum.total());
            if bad.is_none() && !force.iter().all(|component| component.is_finite()) {
                bad = Some(point);
            }
        }
        bad
    }
}

impl Cloud<'_> {
    /// Adds the pull of a block's bonds to the sum. Gives the mask of those that remain.
    #[inline(always)]
    fn pull<S: Simd, const BREAK: bool, const D: usize>(
        &self,
        simd: S,
        law: impl BondLaw,
        point: usize,
        block: usize,
        mut mask: u8,
        sum: &mut [S::Lanes; D],
    ) -> u8 {
        if mask == 0 {
            return 0;
        }
        let own = self.records[point];
        let lanes = block * LANES..(block + 1) * LANES;
        let neighbors = &self.families.neighbors[lanes.clone()];
        let lengths = &self.families.lengths[lanes.clone()];
        for first in (0..LANES).step_by(S::WIDTH) {
            let end = first + S::WIDTH;
            let (neighbors, lengths) = (&neighbors[first..end], &lengths[first..end]);
            let part = Part { point, slot: lanes.start + first, neighbors, lengths };
            // SAFETY: the search makes neighbours of points of the body alone, and each has a record.
            let [x, y, z, volume] = unsafe { simd.columns(self.records, 0, neighbors) };
            // SAFETY: as above.
            let [u, v, w, _] = unsafe { simd.columns(self.records, 4, neighbors) };
            let (places, shifts) = ([x, y, z], [u, v, w]);
            let mut change = simd.splat(0.0);
            let mut bond = [change; D];
            for axis in 0..D {
                let reference = places[axis] - simd.splat(own[axis]);
                let shift = shifts[axis] - simd.splat(own[4 + axis]);
                bond[axis] = reference + shift;
                change = shift.mul_add(reference + bond[axis], change);
            }
            let inverse = simd.load(lengths).reciprocal();
            change = change * (inverse * inverse);
            if BREAK {
                let beyond = change.above(law.threshold(simd, &part)).bits() << first & mask;
                if beyond != 0 {
                    // What is beyond all numbers shall be noticed, and not break.
                    let finite = simd.splat(f64::INFINITY).above(change).bits() << first;
                    mask &= !(beyond & finite & law.breakable(block));
                }
            }
            let weight = law.stiffen(simd, &part, inverse * volume) * change.shortfall();
            let weight = weight.only(simd.mask(mask >> first));
            for axis in 0..D {
                sum[axis] = weight.mul_add(bond[axis], sum[axis]);
            }
        }
        mask
    }
}
