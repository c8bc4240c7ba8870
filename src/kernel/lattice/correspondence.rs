//! Correspondence over groups of a lattice: stresses at the gradients of eight points, and what the other ends of bonds
//! pull. [P 3.31-3.53]
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::gradients::{Seats, TakeGradients, is_odd};
use super::{Groups, Leg, are_finite, are_whole, masks_of};
use crate::families::LANES;
use crate::families::lattice::NOBODY;
use crate::kernel::elastic::SaintVenantKirchhoff;
use crate::kernel::simd::{Kernel, Lanes, Simd};

/// What the points of a range of groups leave for others: T = P (sum w xi xi^T)^-1 at their gradients, in columns of the
/// cells, and T sum w xi as their own part of the force, eight numbers of each component a group. `N` = `D` x `D`.
pub(crate) struct Stresses<'a, L, A, const D: usize, const N: usize> {
    /// Those of points, where all have Saint Venant-Kirchhoff's law.
    pub(crate) laws: Option<L>,
    /// Puts P of some lanes of a group in the place of their displacement gradients, else: called, so that all sorts of laws do
    /// not stand between the gradients.
    pub(crate) ask: A,
    pub(crate) force: &'a mut [f64],
    pub(crate) left: [&'a mut [f64]; N],
    /// The first point whose stress is not finite.
    pub(crate) bad: Option<usize>,
}

impl<L, A, const D: usize, const N: usize> TakeGradients<D> for Stresses<'_, L, A, D, N>
where
    L: Fn(usize) -> SaintVenantKirchhoff,
    A: Fn(usize, Range<usize>, &mut [[[f64; LANES]; D]; D]),
{
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S, seats: &Seats<'_>, slopes: &[[S::Lanes; D]; D]) {
        let Self { laws, ask, force, left, bad } = self;
        let Seats { number, group, lane, members, kept, .. } = *seats;
        let mut stress = *slopes;
        match laws {
            Some(laws) => {
                let mut of = [SaintVenantKirchhoff { lambda: 0.0, mu: 0.0 }; LANES];
                for (of, &member) in of.iter_mut().zip(&members[lane..lane + S::WIDTH]) {
                    if member != NOBODY {
                        *of = laws(member as usize);
                    }
                }
                stress = SaintVenantKirchhoff::of_each(simd, &of, slopes).1;
            }
            None => {
                let mut lanes = [[[0.0; LANES]; D]; D];
                for axis in 0..D {
                    for column in 0..D {
                        slopes[axis][column].store(&mut lanes[axis][column][lane..]);
                    }
                }
                ask(group, lane..lane + S::WIDTH, &mut lanes);
                for axis in 0..D {
                    for column in 0..D {
                        stress[axis][column] = simd.load(&lanes[axis][column][lane..]);
                    }
                }
            }
        }
        let pull = seats.leave(simd, &stress, left);
        let force = &mut force[number * D * LANES..(number + 1) * D * LANES];
        for axis in 0..D {
            pull[axis].store(&mut force[axis * LANES + lane..]);
        }
        if !are_finite(simd, &pull) {
            for lane in (lane..lane + S::WIDTH).filter(|&lane| members[lane] != NOBODY) {
                let finite = (0..D).all(|axis| force[axis * LANES + lane].is_finite());
                if !finite && !is_odd(kept, members[lane], lane) {
                    let point = members[lane] as usize;
                    *bad = Some(bad.map_or(point, |bad| bad.min(point)));
                }
            }
        }
    }
}

/// Adds what the other ends pull, sum w T_j xi, to the forces of a range of groups: of each component eight numbers,
/// group by group. `N` = `D` x `D`.
pub(crate) struct PullSweep<'a, const D: usize, const N: usize> {
    pub(crate) groups: Groups<'a, D>,
    /// T of all cells, row by row.
    pub(crate) left: [&'a [f64]; N],
    pub(crate) range: Range<usize>,
    pub(crate) masks: &'a [u8],
    pub(crate) force: &'a mut [f64],
}

impl<const D: usize, const N: usize> Kernel for PullSweep<'_, D, N> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { groups, left, range, masks, force } = self;
        let cells = groups.lattice.point_of.len();
        assert_eq!(N, D * D);
        assert!(left.iter().all(|column| column.len() == cells));
        let mut pairs = Pairs { first: range.start, count: range.len(), done: 0 };
        for (number, group) in range.enumerate() {
            if pairs.is_done(number) {
                continue;
            }
            if S::WIDTH == LANES
                && let Some(second) = pairs.second(&groups, number)
            {
                pull_both::<S, D, N>(simd, &groups, &left, [number, second], (group, masks), force);
                continue;
            }
            let force = &mut force[number * D * LANES..(number + 1) * D * LANES];
            let masks = &masks[masks_of(&groups, number)];
            if are_whole(masks) {
                pull::<true, S, D, N>(simd, &groups, &left, group, masks, force);
            } else {
                pull::<false, S, D, N>(simd, &groups, &left, group, masks, force);
            }
        }
    }
}

/// Which groups of a range are computed together with that beside them in the next row.
struct Pairs {
    first: usize,
    count: usize,
    /// A bit for each that was the second of two.
    done: u128,
}

impl Pairs {
    fn is_done(&self, number: usize) -> bool {
        number < u128::BITS as usize && self.done >> number & 1 != 0
    }

    /// The group beside another in the next row, if it is in the range.
    fn second<const D: usize>(&mut self, groups: &Groups<'_, D>, number: usize) -> Option<usize> {
        let cells = &groups.lattice.groups[self.first..][..self.count.min(u128::BITS as usize)];
        let beside = *cells.get(number)? as usize + groups.lattice.next_row;
        let second = number + cells[number..].binary_search(&(beside as u32)).ok()?;
        self.done |= 1 << second;
        Some(second)
    }
}

/// No step.
const NOWHERE: Leg = Leg {
    cells: 0,
    reference: [0.0; 3],
    inverse: 0.0,
    limit: 0.0,
    weight: 0.0,
    weighted: [0.0; 3],
    length: 0.0,
    pull: 0.0,
    moment: 0.0,
};

/// Pulls on two groups of neighbouring rows: each tensor is read once for both. Sums have the bits that they have one by one.
#[inline(always)]
fn pull_both<S: Simd, const D: usize, const N: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    left: &[&[f64]; N],
    numbers: [usize; 2],
    (group, masks): (usize, &[u8]),
    force: &mut [f64],
) {
    let (cell, legs) = (groups.cell(group), groups.legs);
    let [low, high] = numbers.map(|number| &masks[masks_of(groups, number)]);
    let places = numbers.map(|number| number * D * LANES);
    let mut sums = [[simd.splat(0.0); D]; 2];
    for end in 0..2 {
        for axis in 0..D {
            sums[end][axis] = simd.load(&force[places[end] + axis * LANES..]);
        }
    }
    for shared in &groups.lattice.shared {
        let there = cell.wrapping_add_signed(shared.cells);
        let [first, second] = [shared.steps[0] as usize, shared.steps[1] as usize];
        let bits = [low.get(first).copied().unwrap_or(0), high.get(second).copied().unwrap_or(0)];
        let both = [legs.get(first).unwrap_or(&NOWHERE), legs.get(second).unwrap_or(&NOWHERE)];
        add_pulls::<false, S, D, N, 2>(simd, left, there, (both, bits), &mut sums);
    }
    for end in 0..2 {
        for axis in 0..D {
            sums[end][axis].store(&mut force[places[end] + axis * LANES..]);
        }
    }
}

/// Adds what the tensors of cells pull by the same step, or by a step each, to the sums of `E` groups: to those of the masks, or
/// with `WHOLE` to all.
#[inline(always)]
fn add_pulls<const WHOLE: bool, S: Simd, const D: usize, const N: usize, const E: usize>(
    simd: S,
    left: &[&[f64]; N],
    there: usize,
    (legs, bits): ([&Leg; E], [u8; E]),
    sums: &mut [[S::Lanes; D]; E],
) {
    for row in 0..D {
        let mut pulls = [simd.splat(0.0); E];
        for column in 0..D {
            let tensor = left[row * D + column];
            debug_assert!(there + S::WIDTH <= tensor.len());
            // SAFETY: a step of a group leads there: there are cells, as `Groups::new` has seen, and each has a number, as
            // the sweep has.
            let tensor = simd.load(unsafe { tensor.get_unchecked(there..there + S::WIDTH) });
            for end in 0..E {
                let weighted = simd.splat(legs[end].weighted[column]);
                pulls[end] = match column {
                    0 => tensor * weighted,
                    _ => tensor.mul_add(weighted, pulls[end]),
                };
            }
        }
        for end in 0..E {
            let pull = if WHOLE { pulls[end] } else { pulls[end].only(simd.mask(bits[end])) };
            sums[end][row] = sums[end][row] + pull;
        }
    }
}

#[inline(always)]
fn pull<const WHOLE: bool, S: Simd, const D: usize, const N: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    left: &[&[f64]; N],
    group: usize,
    masks: &[u8],
    force: &mut [f64],
) {
    for lane in (0..LANES).step_by(S::WIDTH) {
        let cell = groups.cell(group) + lane;
        let mut sums = [[simd.splat(0.0); D]];
        for axis in 0..D {
            sums[0][axis] = simd.load(&force[axis * LANES + lane..]);
        }
        for (leg, bits) in groups.legs.iter().zip(masks) {
            let there = cell.wrapping_add_signed(leg.cells);
            let step = ([leg], [bits >> lane]);
            add_pulls::<WHOLE, S, D, N, 1>(simd, left, there, step, &mut sums);
        }
        for axis in 0..D {
            sums[0][axis].store(&mut force[axis * LANES + lane..]);
        }
    }
}
