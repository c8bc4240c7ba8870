//! The bond-based sweep over groups of a lattice: eight points of a row are computed along the stencil.
//!
//! The equations are those of [`super::bond_based`]; what they take from a list there, a stencil has for all points.

use std::ops::Range;

use super::simd::{Kernel, Lanes, Mask, Simd};
use crate::families::LANES;
use crate::families::lattice::{Lattice, Step};

/// What the sweep reads.
#[derive(Clone, Copy)]
pub(crate) struct Groups<'a, const D: usize> {
    lattice: &'a Lattice,
    /// A component of the displacement of each cell.
    shifts: [&'a [f64]; D],
}

impl<'a, const D: usize> Groups<'a, D> {
    /// Panics when there is not a displacement for each cell.
    pub(crate) fn new(lattice: &'a Lattice, shifts: [&'a [f64]; D]) -> Self {
        let cells = lattice.point_of.len();
        assert!(shifts.iter().all(|shifts| shifts.len() == cells));
        // What is read without a look at the bounds.
        let (first, last) = (lattice.groups.first(), lattice.groups.last());
        let [first, last] = [first, last].map(|cell| cell.map_or(0, |&cell| cell as usize));
        let farthest = lattice.stencil.iter().map(|step| step.cells.unsigned_abs()).max();
        let farthest = farthest.unwrap_or(0);
        assert!(lattice.groups.is_empty() || first >= farthest && last + farthest + LANES <= cells);
        assert!(lattice.groups.is_sorted());
        Self { lattice, shifts }
    }
}

/// Says whether bonds break that come close to their limit: from one end to the other, by inner places.
pub(crate) trait Judge: Copy + Sync {
    fn breaks(&self, point: usize, neighbor: usize) -> bool;
}

/// Forces per volume and bond constant on the points of a range of groups: of each component eight numbers, group by
/// group. Bonds that break do not pull any more: they leave the masks, and their groups are marked in `broke`.
pub(crate) struct GroupSweep<'a, J, const D: usize> {
    pub(crate) groups: Groups<'a, D>,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
    /// [`Lattice::row`] masks a group: of each step of the stencil, the points that have a bond there.
    pub(crate) masks: &'a mut [u8],
    /// One a point.
    pub(crate) broke: &'a mut [bool],
    /// (l/L)^2 - 1 from which the judge is asked.
    pub(crate) threshold: f64,
    pub(crate) judge: J,
}

impl<J: Judge, const D: usize> Kernel for GroupSweep<'_, J, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { groups, range, force, masks, broke, threshold, judge } = self;
        let (row, steps) = (groups.lattice.row(), groups.lattice.stencil.len());
        let pulls = Pulls { simd, groups, threshold: simd.splat(threshold) };
        for (number, group) in range.enumerate() {
            let force = &mut force[number * D * LANES..(number + 1) * D * LANES];
            let masks = &mut masks[number * row..number * row + steps];
            let mut all = u8::MAX;
            for mask in masks.iter() {
                all &= mask;
            }
            let beyond = if all == u8::MAX {
                pulls.sum_up::<true, true>(group, masks, force)
            } else {
                pulls.sum_up::<false, true>(group, masks, force)
            };
            if beyond && judged(groups, judge, group, masks) {
                broke[number * LANES] = true;
                pulls.sum_up::<false, false>(group, masks, force);
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
    threshold: S::Lanes,
}

impl<S: Simd, const D: usize> Pulls<'_, S, D> {
    /// The forces on a group, and with `LOOK` whether bonds of it come close to their limit. `WHOLE`: there are all.
    #[inline(always)]
    fn sum_up<const WHOLE: bool, const LOOK: bool>(
        &self,
        group: usize,
        masks: &[u8],
        force: &mut [f64],
    ) -> bool {
        let mut beyond = 0;
        for lane in (0..LANES).step_by(S::WIDTH) {
            let (sum, bits) = self.sum_part::<WHOLE, LOOK>(group, lane, masks);
            for (axis, sum) in sum.into_iter().enumerate() {
                sum.store(&mut force[axis * LANES + lane..]);
            }
            beyond |= bits;
        }
        beyond != 0
    }

    #[inline(always)]
    fn sum_part<const WHOLE: bool, const LOOK: bool>(
        &self,
        group: usize,
        lane: usize,
        masks: &[u8],
    ) -> ([S::Lanes; D], u8) {
        let Self { simd, groups, threshold } = *self;
        let cell = groups.lattice.groups[group] as usize + lane;
        let mut own = [threshold; D];
        for (own, shifts) in own.iter_mut().zip(groups.shifts) {
            *own = simd.load(&shifts[cell..]);
        }
        let mut sum = [simd.splat(0.0); D];
        let mut beyond = 0;
        let stencil = &groups.lattice.stencil[..];
        let Some((first, rest)) = stencil.split_first() else { return (sum, 0) };
        // While one step's root is taken, the next one's points are fetched.
        let (mut step, mut pulled) = (first, self.stretch(cell, first, &own));
        let (&last, before) = masks.split_last().unwrap_or((&0, &[]));
        for (next, &mask) in rest.iter().zip(before) {
            let ahead = self.stretch(cell, next, &own);
            beyond |= self.pull::<WHOLE, LOOK>(step, mask >> lane, pulled, &mut sum);
            (step, pulled) = (next, ahead);
        }
        beyond |= self.pull::<WHOLE, LOOK>(step, last >> lane, pulled, &mut sum);
        (sum, beyond)
    }

    #[inline(always)]
    fn stretch(&self, cell: usize, step: &Step, own: &[S::Lanes; D]) -> Pulled<S::Lanes, D> {
        let Self { simd, groups, threshold } = *self;
        let there = cell.wrapping_add_signed(step.cells);
        let (mut bond, mut product) = (*own, threshold);
        for axis in 0..D {
            debug_assert!(there + S::WIDTH <= groups.shifts[axis].len());
            // SAFETY: the stencil leads from the cells of groups to cells, as `Groups::new` has seen.
            let moved = unsafe { groups.shifts[axis].get_unchecked(there..there + S::WIDTH) };
            let shift = simd.load(moved) - own[axis];
            let reference = simd.splat(step.reference[axis]);
            bond[axis] = reference + shift;
            let both = reference + bond[axis];
            product = match axis {
                0 => shift * both,
                _ => shift.mul_add(both, product),
            };
        }
        Pulled { bond, change: product * simd.splat(step.inverse_squared) }
    }

    /// Adds the forces of a step's bonds to the sum. With `LOOK`, gives those that come close to their limit.
    #[inline(always)]
    fn pull<const WHOLE: bool, const LOOK: bool>(
        &self,
        step: &Step,
        bits: u8,
        pulled: Pulled<S::Lanes, D>,
        sum: &mut [S::Lanes; D],
    ) -> u8 {
        let mut beyond = 0;
        if LOOK {
            beyond = pulled.change.above(self.threshold).bits() & bits;
        }
        let mut weight = pulled.change.shortfall() * self.simd.splat(step.weight);
        if !WHOLE {
            weight = weight.only(self.simd.mask(bits));
        }
        for (sum, bond) in sum.iter_mut().zip(pulled.bond) {
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
    /// (l/L)^2 - 1
    change: F,
}
