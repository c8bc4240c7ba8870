//! Gradients of the displacement of groups of a lattice: sum w du xi^T of eight points times what is kept of them. With
//! one volume for all it goes out of du (sum w xi xi^T)^-1. [P 3.31-3.53]
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::{Breaks, Groups, Judge, Leg, Pulled, Term, are_whole, judged, walk};
use crate::families::LANES;
use crate::families::lattice::NOBODY;
use crate::kernel::gradient::{BEFORE_ROWS, Kept, Kind, Moments, kept_width};
use crate::kernel::simd::{Kernel, Lanes, Simd};

/// Gives the gradients of the points of a range of groups to `take`. Bonds break first.
pub(crate) struct GroupGradients<'a, J, K, T, const D: usize> {
    pub(crate) groups: Groups<'a, D>,
    pub(crate) range: Range<usize>,
    /// Numbers of seats, eight of each kind a group, and the masks of groups that they belong to; made anew by `keep`
    /// where a bond of the group has changed.
    pub(crate) kept: Kept<'a>,
    pub(crate) keep: K,
    pub(crate) breaks: Breaks<'a, J>,
    /// First cell of the range.
    pub(crate) first: usize,
    pub(crate) take: &'a mut T,
}

/// Seats of a group whose gradients have been made.
pub(crate) struct Seats<'a> {
    /// Number of the group in its range, and in the lattice.
    pub(super) number: usize,
    pub(super) group: usize,
    /// The first of them, and its cell from the first of the range.
    pub(super) lane: usize,
    pub(super) place: usize,
    /// Points of the group, and what is kept of them.
    pub(super) members: &'a [u32],
    pub(super) kept: &'a [f64],
}

/// What is done with gradients.
pub(crate) trait TakeGradients<const D: usize> {
    fn take<S: Simd>(&mut self, simd: S, seats: &Seats<'_>, gradient: &[[S::Lanes; D]; D]);
}

/// Whether a seat of a group is a point that is to be done otherwise, by what is kept of the group.
pub(crate) fn is_odd(kept: &[f64], member: u32, lane: usize) -> bool {
    member != NOBODY && kept[lane] != Kind::Even.number()
}

/// What is kept of a seat after the kind: 1/sum w, the rows, and sum w xi.
pub(crate) struct KeptSeat<const D: usize> {
    pub(crate) spans: bool,
    pub(crate) inverse_weight: f64,
    pub(crate) rows: [[f64; D]; D],
    pub(crate) sums: [f64; D],
}

impl<const D: usize> KeptSeat<D> {
    pub(crate) fn of(kept: &[f64], lane: usize) -> Self {
        let number = |number: usize| kept[number * LANES + lane];
        let row = |row: usize| std::array::from_fn(|k| number(BEFORE_ROWS + row * D + k));
        Self {
            spans: Kind::of(&kept[lane..]) != Kind::Odd,
            inverse_weight: number(INVERSE_WEIGHT),
            rows: std::array::from_fn(row),
            sums: std::array::from_fn(|axis| number(BEFORE_ROWS + D * D + axis)),
        }
    }
}

/// Place of 1/sum w among what is kept of a point.
const INVERSE_WEIGHT: usize = 1;

impl Seats<'_> {
    /// A number that is kept of the seats, after the kind, 1/sum w and sum V.
    #[inline(always)]
    fn kept<S: Simd>(&self, simd: S, number: usize) -> S::Lanes {
        simd.load(&self.kept[(BEFORE_ROWS + number) * LANES + self.lane..])
    }

    /// 1/sum w
    #[inline(always)]
    pub(super) fn inverse_weight<S: Simd>(&self, simd: S) -> S::Lanes {
        simd.load(&self.kept[INVERSE_WEIGHT * LANES + self.lane..])
    }

    /// Leaves T = P (sum w xi xi^T)^-1 in columns, and gives T sum w xi. `N` = `D` x `D`.
    #[inline(always)]
    pub(super) fn leave<S: Simd, const D: usize, const N: usize>(
        &self,
        simd: S,
        stress: &[[S::Lanes; D]; D],
        left: &mut [&mut [f64]; N],
    ) -> [S::Lanes; D] {
        let mut pull = [simd.splat(0.0); D];
        for axis in 0..D {
            for column in 0..D {
                let mut tensor = stress[axis][0] * self.kept(simd, column);
                for inner in 1..D {
                    tensor =
                        stress[axis][inner].mul_add(self.kept(simd, inner * D + column), tensor);
                }
                tensor.store(&mut left[axis * D + column][self.place..]);
                pull[axis] = tensor.mul_add(self.kept(simd, D * D + column), pull[axis]);
            }
        }
        pull
    }
}

impl<J, K, T, const D: usize> Kernel for GroupGradients<'_, J, K, T, D>
where
    J: Judge,
    K: Fn(&Moments, &mut [f64]),
    T: TakeGradients<D>,
{
    /// Whether there are odd points, whose gradients are none.
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Self { groups, range, kept, keep, breaks, first, take } = self;
        let Breaks { masks, broke, judge, look } = breaks;
        let (row, width) = (groups.lattice.row(), LANES * kept_width(D, D));
        let mut any_odd = false;
        for (number, group) in range.enumerate() {
            let members = &groups.lattice.members[group * LANES..(group + 1) * LANES];
            let numbers = &mut kept.numbers[number * width..][..width];
            let old = &mut kept.masks[number * row..][..row];
            let all = &mut masks[number * row..][..row];
            let masks = &mut all[..groups.legs.len()];
            let mut moved = [[[0.0; LANES]; D]; D];
            let beyond = match (are_whole(masks), look) {
                (true, true) => sum_up::<true, true, S, D>(simd, &groups, group, masks, &mut moved),
                (true, false) => {
                    sum_up::<true, false, S, D>(simd, &groups, group, masks, &mut moved)
                }
                (false, true) => {
                    sum_up::<false, true, S, D>(simd, &groups, group, masks, &mut moved)
                }
                (false, false) => {
                    sum_up::<false, false, S, D>(simd, &groups, group, masks, &mut moved)
                }
            };
            if beyond && judged(simd, &groups, judge, group, masks) {
                broke[number * LANES] = true;
                sum_up::<false, false, S, D>(simd, &groups, group, masks, &mut moved);
            }
            let mut stale = old != all;
            for lane in 0..LANES {
                stale |= members[lane] != NOBODY && numbers[lane] == 0.0;
            }
            if stale {
                renew(&groups, members, numbers, (all, old), &keep);
            }
            for lane in 0..LANES {
                any_odd |= is_odd(numbers, members[lane], lane);
            }
            for lane in (0..LANES).step_by(S::WIDTH) {
                let place = groups.cell(group) - first + lane;
                let seats = Seats { number, group, lane, place, members, kept: &*numbers };
                let mut slopes = [[simd.splat(0.0); D]; D];
                for axis in 0..D {
                    for column in 0..D {
                        for inner in 0..D {
                            let moved = simd.load(&moved[axis][inner][lane..]);
                            let kept = seats.kept(simd, column * D + inner);
                            slopes[axis][column] = moved.mul_add(kept, slopes[axis][column]);
                        }
                    }
                }
                take.take(simd, &seats, &slopes);
            }
        }
        any_odd
    }
}

/// Makes what is kept of the points of a group anew.
#[cold]
#[inline(never)]
fn renew<const D: usize>(
    groups: &Groups<'_, D>,
    members: &[u32],
    numbers: &mut [f64],
    (masks, old): (&[u8], &mut [u8]),
    keep: &impl Fn(&Moments, &mut [f64]),
) {
    // Nothing is kept while masks and numbers do not belong together, should a panic come between.
    numbers.fill(0.0);
    old.copy_from_slice(masks);
    let mut kept = [0.0; kept_width(3, 3)];
    let kept = &mut kept[..kept_width(D, D)];
    for lane in (0..LANES).filter(|&lane| members[lane] != NOBODY) {
        keep(&moments(groups, masks, lane), kept);
        for (number, kept) in kept.iter().enumerate() {
            numbers[number * LANES + lane] = *kept;
        }
    }
}

fn moments<const D: usize>(groups: &Groups<'_, D>, masks: &[u8], lane: usize) -> Moments {
    let mut moments = Moments { products: [[0.0; 9]; 9], sums: [0.0; 9], weight: 0.0, volume: 0.0 };
    for (leg, mask) in groups.legs.iter().zip(masks) {
        if mask >> lane & 1 == 0 {
            continue;
        }
        moments.weight += leg.weight;
        moments.volume += 1.0;
        for row in 0..D {
            moments.sums[row] += leg.weighted[row];
            for column in 0..D {
                moments.products[row][column] += leg.weighted[row] * leg.reference[column];
            }
        }
    }
    moments
}

/// sum w du xi^T of a group, and whether bonds of it come close to their limit.
#[inline(always)]
fn sum_up<const WHOLE: bool, const LOOK: bool, S: Simd, const D: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    group: usize,
    masks: &[u8],
    moved: &mut [[[f64; LANES]; D]; D],
) -> bool {
    let mut beyond = 0;
    for lane in (0..LANES).step_by(S::WIDTH) {
        let at = (groups.cell(group) + lane, lane);
        let mut sum = Sum([[simd.splat(0.0); D]; D]);
        beyond |= walk::<WHOLE, LOOK, false, S, D>(simd, groups, at, masks, &mut sum);
        for row in 0..D {
            for column in 0..D {
                sum.0[row][column].store(&mut moved[row][column][lane..]);
            }
        }
    }
    beyond != 0
}

struct Sum<F, const D: usize>([[F; D]; D]);

impl<S: Simd, const D: usize> Term<S, D> for Sum<S::Lanes, D> {
    #[inline(always)]
    fn add<const WHOLE: bool>(
        &mut self,
        simd: S,
        leg: &Leg,
        bonds: &Pulled<S::Lanes, D>,
        _: S::Lanes,
        mask: S::Mask,
    ) {
        for row in 0..D {
            let moved = if WHOLE { bonds.moved[row] } else { bonds.moved[row].only(mask) };
            for column in 0..D {
                let weighted = simd.splat(leg.weighted[column]);
                self.0[row][column] = moved.mul_add(weighted, self.0[row][column]);
            }
        }
    }
}
