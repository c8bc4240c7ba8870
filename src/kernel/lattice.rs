//! The bond-based sweep over groups of a lattice: eight points of a row are computed along the stencil.
//!
//! All have one volume, so that the sum is of (1/L - 1/l) y with y = xi + du; all lengths are in a unit near that of the
//! stencil. 1/L is computed as 1/l is, from the same bits where the ends move alike: these bonds pull with exactly 0.

use std::ops::Range;

use super::simd::{Kernel, Lanes, Mask, Simd};
use crate::families::LANES;
use crate::families::lattice::{Lattice, Step};

/// A step of the stencil, ready for a sweep.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Leg {
    /// Cells from one point to the other.
    cells: isize,
    /// xi
    reference: [f64; 3],
    /// 1/L
    inverse: f64,
    /// l^2 from which the judge is asked.
    limit: f64,
}

/// Makes the steps of a stencil ready: `unit` of a length is 1, and beyond (l/L)^2 - 1 = `threshold` bonds come close to
/// their limit.
pub(crate) struct Prepare<'a> {
    pub(crate) stencil: &'a [Step],
    pub(crate) unit: f64,
    pub(crate) threshold: f64,
    pub(crate) legs: &'a mut [Leg],
}

impl Kernel for Prepare<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut lanes = [0.0; LANES];
        for (leg, step) in self.legs.iter_mut().zip(self.stencil) {
            let reference = step.reference.map(|along| along / self.unit);
            let square = square(reference.map(|along| simd.splat(along)));
            square.reciprocal_root().store(&mut lanes[..S::WIDTH]);
            let inverse = lanes[0];
            square.store(&mut lanes[..S::WIDTH]);
            let limit = lanes[0] * (1.0 + self.threshold);
            *leg = Leg { cells: step.cells, reference, inverse, limit };
        }
    }
}

#[inline(always)]
fn square<F: Lanes, const D: usize>(vector: [F; D]) -> F {
    let mut square = vector[0] * vector[0];
    for along in &vector[1..] {
        square = along.mul_add(*along, square);
    }
    square
}

/// What the sweep reads.
#[derive(Clone, Copy)]
pub(crate) struct Groups<'a, const D: usize> {
    lattice: &'a Lattice,
    legs: &'a [Leg],
    /// A component of the displacement of each cell, in the unit of the legs.
    shifts: [&'a [f64]; D],
}

impl<'a, const D: usize> Groups<'a, D> {
    /// Panics when there is not a leg for each step and a displacement for each cell.
    pub(crate) fn new(lattice: &'a Lattice, legs: &'a [Leg], shifts: [&'a [f64]; D]) -> Self {
        let cells = lattice.point_of.len();
        assert!(shifts.iter().all(|shifts| shifts.len() == cells));
        // What is read without a look at the bounds.
        let (first, last) = (lattice.groups.first(), lattice.groups.last());
        let [first, last] = [first, last].map(|cell| cell.map_or(0, |&cell| cell as usize));
        let farthest = legs.iter().map(|leg| leg.cells.unsigned_abs()).max();
        let farthest = farthest.unwrap_or(0);
        assert!(lattice.groups.is_empty() || first >= farthest && last + farthest + LANES <= cells);
        assert!(lattice.groups.is_sorted());
        assert_eq!(legs.len(), lattice.stencil.len());
        Self { lattice, legs, shifts }
    }
}

/// Says whether bonds break that come close to their limit: from one end to the other, by inner places.
pub(crate) trait Judge: Copy + Sync {
    fn breaks(&self, point: usize, neighbor: usize) -> bool;
}

/// Forces per volume, of a neighbour's volume and bond constant 1, on the points of a range of groups: of each component
/// eight numbers, group by group. Bonds that break do not pull any more: they leave the masks, and their groups are marked in `broke`.
pub(crate) struct GroupSweep<'a, J, const D: usize> {
    pub(crate) groups: Groups<'a, D>,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
    /// [`Lattice::row`] masks a group: of each step of the stencil, the points that have a bond there.
    pub(crate) masks: &'a mut [u8],
    /// One a point.
    pub(crate) broke: &'a mut [bool],
    pub(crate) judge: J,
}

impl<J: Judge, const D: usize> Kernel for GroupSweep<'_, J, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { groups, range, force, masks, broke, judge } = self;
        let (row, steps) = (groups.lattice.row(), groups.legs.len());
        let pulls = Pulls { simd, groups };
        for (number, group) in range.enumerate() {
            let force = &mut force[number * D * LANES..(number + 1) * D * LANES];
            let masks = &mut masks[number * row..number * row + steps];
            let mut all = u8::MAX;
            for mask in masks.iter() {
                all &= mask;
            }
            let (beyond, finite) = if all == u8::MAX {
                pulls.sum_up::<true, true, false>(group, masks, force)
            } else {
                pulls.sum_up::<false, true, false>(group, masks, force)
            };
            let broken = beyond && judged(groups, judge, group, masks);
            broke[number * LANES] |= broken;
            if broken || !finite {
                pulls.sum_up::<false, false, true>(group, masks, force);
            }
        }
    }
}

/// Takes the bonds of a group that break from its masks, and says whether there were any.
#[cold]
#[inline(never)]
fn judged<const D: usize>(
    groups: Groups<'_, D>,
    judge: impl Judge,
    group: usize,
    masks: &mut [u8],
) -> bool {
    let lattice = groups.lattice;
    let mut broke = false;
    for (step, mask) in lattice.stencil.iter().zip(masks) {
        let bits = *mask;
        for lane in (0..LANES).filter(|lane| bits >> lane & 1 == 1) {
            let seat = group * LANES + lane;
            let there = lattice.cell(seat).wrapping_add_signed(step.cells);
            let [point, neighbor] = [lattice.members[seat], lattice.point_of[there]];
            if judge.breaks(point as usize, neighbor as usize) {
                *mask &= !(1 << lane);
                broke = true;
            }
        }
    }
    broke
}

#[derive(Clone, Copy)]
struct Pulls<'a, S: Simd, const D: usize> {
    simd: S,
    groups: Groups<'a, D>,
}

/// The least l^2 that a root is taken of, in units of the legs, where ends may fall together.
const LEAST: f64 = 1e-15;

impl<S: Simd, const D: usize> Pulls<'_, S, D> {
    /// The forces on a group, with `LOOK` whether bonds of it come close to their limit, and whether all forces are
    /// finite. `WHOLE`: there are all bonds. Without `CAREFUL` points must not fall together.
    #[inline(always)]
    fn sum_up<const WHOLE: bool, const LOOK: bool, const CAREFUL: bool>(
        &self,
        group: usize,
        masks: &[u8],
        force: &mut [f64],
    ) -> (bool, bool) {
        let (mut beyond, mut finite) = (0, true);
        for lane in (0..LANES).step_by(S::WIDTH) {
            let (sum, bits) = self.sum_part::<WHOLE, LOOK, CAREFUL>(group, lane, masks);
            let mut none = self.simd.splat(1.0);
            for (axis, sum) in sum.into_iter().enumerate() {
                sum.store(&mut force[axis * LANES + lane..]);
                none = sum.mul_add(self.simd.splat(0.0), none);
            }
            let wanted = (1_u32 << S::WIDTH) - 1;
            finite &= u32::from(none.above(self.simd.splat(0.0)).bits()) & wanted == wanted;
            beyond |= bits;
        }
        (beyond != 0, finite)
    }

    #[inline(always)]
    fn sum_part<const WHOLE: bool, const LOOK: bool, const CAREFUL: bool>(
        &self,
        group: usize,
        lane: usize,
        masks: &[u8],
    ) -> ([S::Lanes; D], u8) {
        let Self { simd, groups } = *self;
        let cell = groups.lattice.groups[group] as usize + lane;
        let mut own = [simd.splat(0.0); D];
        let mut sum = own;
        for (own, shifts) in own.iter_mut().zip(groups.shifts) {
            *own = simd.load(&shifts[cell..]);
        }
        let mut beyond = 0;
        let Some((first, rest)) = groups.legs.split_first() else { return (sum, 0) };
        // While one step's root is taken, the next one's points are fetched.
        let (mut leg, mut pulled) = (first, self.stretch(cell, first, &own));
        let (&last, before) = masks.split_last().unwrap_or((&0, &[]));
        for (next, &mask) in rest.iter().zip(before) {
            let ahead = self.stretch(cell, next, &own);
            beyond |= self.pull::<WHOLE, LOOK, CAREFUL>(leg, mask >> lane, pulled, &mut sum);
            (leg, pulled) = (next, ahead);
        }
        beyond |= self.pull::<WHOLE, LOOK, CAREFUL>(leg, last >> lane, pulled, &mut sum);
        (sum, beyond)
    }

    #[inline(always)]
    fn stretch(&self, cell: usize, leg: &Leg, own: &[S::Lanes; D]) -> Pulled<S::Lanes, D> {
        let Self { simd, groups } = *self;
        let there = cell.wrapping_add_signed(leg.cells);
        let mut bond = *own;
        for axis in 0..D {
            debug_assert!(there + S::WIDTH <= groups.shifts[axis].len());
            // SAFETY: the legs lead from the cells of groups to cells, as `Groups::new` has seen.
            let moved = unsafe { groups.shifts[axis].get_unchecked(there..there + S::WIDTH) };
            bond[axis] = simd.load(moved) - own[axis] + simd.splat(leg.reference[axis]);
        }
        Pulled { bond, square: square(bond) }
    }

    /// Adds the forces of a step's bonds to the sum. With `LOOK`, gives those that come close to their limit.
    #[inline(always)]
    fn pull<const WHOLE: bool, const LOOK: bool, const CAREFUL: bool>(
        &self,
        leg: &Leg,
        bits: u8,
        pulled: Pulled<S::Lanes, D>,
        sum: &mut [S::Lanes; D],
    ) -> u8 {
        let Pulled { bond, mut square } = pulled;
        let mut beyond = 0;
        if LOOK {
            beyond = square.above(self.simd.splat(leg.limit)).bits() & bits;
        }
        if CAREFUL {
            square = square.max(self.simd.splat(LEAST));
        }
        let mut weight = self.simd.splat(leg.inverse) - square.reciprocal_root();
        if !WHOLE {
            weight = weight.only(self.simd.mask(bits));
        }
        for (sum, bond) in sum.iter_mut().zip(bond) {
            *sum = weight.mul_add(bond, *sum);
        }
        beyond
    }
}

/// Bonds at a displacement.
#[derive(Clone, Copy)]
struct Pulled<F, const D: usize> {
    /// y
    bond: [F; D],
    /// l^2
    square: F,
}
