//! Bond-associated quadrature points over groups of a lattice. [P 4.21-4.35]
//!
//! The first sweep leaves halves of gradients and of 1/sum w, of which the middles of bonds take the sums. The second asks the
//! law at eight bonds of a step at once, and leaves Z (sum w xi xi^T)^-1 for what the gradients of other ends pull. The
//! volume, one for all, goes out of both.
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::gradients::{Seats, TakeGradients};
use super::{Groups, Leg, are_whole, masks_of};
use crate::families::LANES;
use crate::kernel::elastic::{ElasticLaw, LaneLaw};
use crate::kernel::gradient::kept_width;
use crate::kernel::simd::{Kernel, Lanes, Simd};

/// Leaves what the middles of bonds take of a point, in columns of the cells: H/2 row by row, and behind it 1/(2 sum w).
pub(crate) struct Halves<'a, const A: usize>(pub(crate) [&'a mut [f64]; A]);

impl<const A: usize, const D: usize> TakeGradients<D> for Halves<'_, A> {
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S, seats: &Seats<'_>, gradient: &[[S::Lanes; D]; D]) {
        let half = simd.splat(0.5);
        for axis in 0..D {
            for column in 0..D {
                let slope = gradient[axis][column] * half;
                slope.store(&mut self.0[axis * D + column][seats.place..]);
            }
        }
        (seats.inverse_weight(simd) * half).store(&mut self.0[D * D][seats.place..]);
    }
}

/// What bonds of the points of a range of groups pull by themselves, and the own part of what they pull through gradients:
/// eight numbers of each component a group. T = Z (sum w xi xi^T)^-1 is left in columns of the cells.
/// `A` = `D` x `D` + 1, `N` = `D` x `D`.
pub(crate) struct BondStressSweep<'a, const D: usize, const A: usize, const N: usize> {
    pub(crate) groups: Groups<'a, D>,
    pub(crate) law: ElasticLaw,
    /// xi/L^2 of each step.
    pub(crate) along: &'a [[f64; 3]],
    /// Of all cells.
    pub(crate) halves: [&'a [f64]; A],
    pub(crate) range: Range<usize>,
    pub(crate) masks: &'a [u8],
    /// What is kept of the groups.
    pub(crate) kept: &'a [f64],
    pub(crate) force: &'a mut [f64],
    pub(crate) left: [&'a mut [f64]; N],
    /// First cell of the range.
    pub(crate) first: usize,
}

/// Sums over the bonds of points: Z = sum wbar P (I - n n^T), and sum wbar P xi/L^2.
struct Pulls<F, const D: usize> {
    through: [[F; D]; D],
    straight: [F; D],
}

impl<const D: usize, const A: usize, const N: usize> Kernel for BondStressSweep<'_, D, A, N> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        match self.law.quadratic() {
            Some(law) => self.with(simd, law),
            None => {
                let law = self.law;
                self.with(simd, law);
            }
        }
    }
}

impl<const D: usize, const A: usize, const N: usize> BondStressSweep<'_, D, A, N> {
    #[inline(always)]
    fn with<S: Simd>(self, simd: S, law: impl LaneLaw) {
        let Self { groups, along, halves, range, masks, kept, force, mut left, first, .. } = self;
        let cells = groups.lattice.point_of.len();
        assert!(A == D * D + 1 && halves.iter().all(|column| column.len() == cells));
        assert_eq!(along.len(), groups.legs.len());
        let width = LANES * kept_width(D, D);
        for (number, group) in range.enumerate() {
            let members = &groups.lattice.members[group * LANES..(group + 1) * LANES];
            let kept = &kept[group * width..][..width];
            let force = &mut force[number * D * LANES..(number + 1) * D * LANES];
            let masks = &masks[masks_of(&groups, number)];
            let whole = are_whole(masks);
            for lane in (0..LANES).step_by(S::WIDTH) {
                let at = (groups.cell(group) + lane, lane);
                let pulls = if whole {
                    sum_up::<true, S, _, D, A>(simd, &groups, (law, along), &halves, at, masks)
                } else {
                    sum_up::<false, S, _, D, A>(simd, &groups, (law, along), &halves, at, masks)
                };
                let place = at.0 - first;
                let seats = Seats { number, group, lane, place, members, kept };
                let own = seats.leave(simd, &pulls.through, &mut left);
                for axis in 0..D {
                    let straight = pulls.straight[axis];
                    (straight + straight + own[axis]).store(&mut force[axis * LANES + lane..]);
                }
            }
        }
    }
}

/// Numbers of a column from a cell on: that of a group, or one that a step leads to from there.
#[inline(always)]
fn at<S: Simd>(simd: S, column: &[f64], cell: usize) -> S::Lanes {
    debug_assert!(cell + S::WIDTH <= column.len());
    // SAFETY: there are cells, as `Groups::new` has seen, and each has a number, as the sweep has.
    simd.load(unsafe { column.get_unchecked(cell..cell + S::WIDTH) })
}

/// The middles of the bonds of a step.
struct Middle<F, const D: usize> {
    /// H_ij = Hbar + (du - Hbar xi) xi^T/L^2
    gradient: [[F; D]; D],
    /// wbar_ij
    weight: F,
}

#[inline(always)]
fn middle<S: Simd, const D: usize, const A: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    halves: &[&[f64]; A],
    cell: usize,
    (leg, along): (&Leg, &[f64; 3]),
) -> Middle<S::Lanes, D> {
    let there = cell.wrapping_add_signed(leg.cells);
    let mut gradient = [[simd.splat(0.0); D]; D];
    for row in 0..D {
        let shifts = groups.shifts[row];
        let mut unseen = at(simd, shifts, there) - at(simd, shifts, cell);
        for column in 0..D {
            let halves = halves[row * D + column];
            let mean = at(simd, halves, cell) + at(simd, halves, there);
            gradient[row][column] = mean;
            unseen = mean.mul_sub_from(simd.splat(leg.reference[column]), unseen);
        }
        for column in 0..D {
            let along = simd.splat(along[column]);
            gradient[row][column] = unseen.mul_add(along, gradient[row][column]);
        }
    }
    let weights = at(simd, halves[D * D], cell) + at(simd, halves[D * D], there);
    Middle { gradient, weight: weights * simd.splat(leg.weight) }
}

impl<F, const D: usize> Pulls<F, D> {
    /// Adds the bonds of a step, of which a law has made wbar P.
    #[inline(always)]
    fn add<S: Simd<Lanes = F>>(
        &mut self,
        simd: S,
        (leg, along): (&Leg, &[f64; 3]),
        stress: &[[F; D]; D],
    ) where
        F: Lanes,
    {
        for row in 0..D {
            let mut pull = stress[row][0] * simd.splat(along[0]);
            for column in 1..D {
                pull = stress[row][column].mul_add(simd.splat(along[column]), pull);
            }
            self.straight[row] = self.straight[row] + pull;
            for column in 0..D {
                let through = self.through[row][column] + stress[row][column];
                let reference = simd.splat(leg.reference[column]);
                self.through[row][column] = pull.mul_sub_from(reference, through);
            }
        }
    }
}

/// Number of the first step from one on that leads to bonds of the points of some lanes, or of steps.
#[inline(always)]
fn next_step<const WHOLE: bool>(mut step: usize, masks: &[u8], lanes: u8) -> usize {
    while !WHOLE && step < masks.len() && masks[step] & lanes == 0 {
        step += 1;
    }
    step
}

/// Sums over the bonds of `WIDTH` points from a cell on, those of the masks from a lane on. `WHOLE`: there are all bonds.
#[inline(always)]
fn sum_up<const WHOLE: bool, S: Simd, L: LaneLaw, const D: usize, const A: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    (law, along): (L, &[[f64; 3]]),
    halves: &[&[f64]; A],
    (cell, lane): (usize, usize),
    masks: &[u8],
) -> Pulls<S::Lanes, D> {
    let zero = simd.splat(0.0);
    let mut pulls = Pulls { through: [[zero; D]; D], straight: [zero; D] };
    let lanes = u8::MAX >> (LANES - S::WIDTH) << lane;
    let mut step = next_step::<WHOLE>(0, masks, lanes);
    if step >= masks.len() {
        return pulls;
    }
    let mut ahead = middle(simd, groups, halves, cell, (&groups.legs[step], &along[step]));
    while step < masks.len() {
        let Middle { gradient, weight } = ahead;
        let (_, mut stress) = law.weighted(simd, weight, &gradient);
        // While the law's answer is made, and multiplied, the next step's bonds are fetched.
        let next = next_step::<WHOLE>(step + 1, masks, lanes);
        let following = next.min(masks.len() - 1);
        let leg = (&groups.legs[following], &along[following]);
        ahead = middle(simd, groups, halves, cell, leg);
        if !WHOLE {
            let mask = simd.mask(masks[step] >> lane);
            for row in 0..D {
                for column in 0..D {
                    stress[row][column] = stress[row][column].only(mask);
                }
            }
        }
        pulls.add(simd, (&groups.legs[step], &along[step]), &stress);
        step = next;
    }
    pulls
}
