//! Correspondence over groups of a lattice: sums w du xi^T of eight points, and what the other ends of bonds pull. With
//! one volume for all it goes out of the gradient du (sum w xi xi^T)^-1. [P 3.31-3.53]
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::{
    Breaks, Groups, Judge, Leg, Pulled, Term, are_finite, are_whole, judged, masks_of, walk,
};
use crate::families::LANES;
use crate::families::lattice::NOBODY;
use crate::kernel::gradient::{BEFORE_ROWS, Kept, Kind, Moments, kept_width};
use crate::kernel::quadrature::Stress;
use crate::kernel::simd::{Kernel, Lanes, Simd};

/// What the points of a range of groups leave for others: T = P (sum w xi xi^T)^-1 at their gradients, in columns of the
/// cells, and T sum w xi as their own part of the force, eight numbers of each component a group. Bonds break first.
/// `N` = `D` x `D`.
pub(crate) struct StressSweep<'a, J, K, A, const D: usize, const N: usize> {
    pub(crate) groups: Groups<'a, D>,
    pub(crate) range: Range<usize>,
    /// Numbers of seats, eight of each kind a group, and the masks of groups that they belong to; made anew by `keep`
    /// where a bond of the group has changed.
    pub(crate) kept: Kept<'a>,
    pub(crate) keep: K,
    /// The law, where all points have one that is asked in lanes.
    pub(crate) law: Option<Stress>,
    /// P of a seat whose family spans the body at a displacement gradient, else.
    pub(crate) ask: A,
    pub(crate) force: &'a mut [f64],
    pub(crate) left: [&'a mut [f64]; N],
    /// First cell of the columns.
    pub(crate) first: usize,
    pub(crate) breaks: Breaks<'a, J>,
}

/// Whether a seat of a group is a point that is to be done otherwise, by what is kept of the group.
pub(crate) fn is_odd(kept: &[f64], member: u32, lane: usize) -> bool {
    member != NOBODY && kept[lane] != Kind::Even.number()
}

/// sum w xi of a seat.
pub(crate) fn kept_sums<const D: usize>(kept: &[f64], lane: usize) -> [f64; D] {
    std::array::from_fn(|axis| kept[(BEFORE_ROWS + D * D + axis) * LANES + lane])
}

impl<J, K, A, const D: usize, const N: usize> Kernel for StressSweep<'_, J, K, A, D, N>
where
    J: Judge,
    K: Fn(&Moments, &mut [f64]),
    A: FnMut(usize, &[[f64; D]; D]) -> [[f64; D]; D],
{
    /// Whether there are odd points, which have left nothing, and the first point whose stress is not finite.
    type Output = (bool, Option<usize>);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> (bool, Option<usize>) {
        let Self { groups, range, kept, keep, law, mut ask, force, left, first, breaks } = self;
        let Breaks { masks, broke, judge, look } = breaks;
        let (row, width) = (groups.lattice.row(), LANES * kept_width(D, D));
        let (mut any_odd, mut bad) = (false, None::<usize>);
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
            let (mut stale, mut odd) = (old != all, false);
            for lane in 0..LANES {
                stale |= members[lane] != NOBODY && numbers[lane] == 0.0;
            }
            if stale {
                renew(&groups, members, numbers, (all, old), &keep);
            }
            for lane in 0..LANES {
                odd |= is_odd(numbers, members[lane], lane);
            }
            any_odd |= odd;
            let mut gradient = [[[0.0; LANES]; D]; D];
            let place = groups.cell(group) - first;
            for lane in (0..LANES).step_by(S::WIDTH) {
                let kept =
                    |number: usize| simd.load(&numbers[(BEFORE_ROWS + number) * LANES + lane..]);
                let mut slopes = [[simd.splat(0.0); D]; D];
                for axis in 0..D {
                    for column in 0..D {
                        for inner in 0..D {
                            let moved = simd.load(&moved[axis][inner][lane..]);
                            let slope =
                                moved.mul_add(kept(column * D + inner), slopes[axis][column]);
                            slopes[axis][column] = slope;
                        }
                        slopes[axis][column].store(&mut gradient[axis][column][lane..]);
                    }
                }
                let mut stress = slopes;
                match law {
                    Some(law) => stress = law.at(simd, &slopes).1,
                    None => {
                        let mut answers = [[[0.0; LANES]; D]; D];
                        for lane in lane..lane + S::WIDTH {
                            if members[lane] == NOBODY || is_odd(numbers, members[lane], lane) {
                                continue;
                            }
                            let gradient = gradient.map(|row| row.map(|lanes| lanes[lane]));
                            let answer = ask(group * LANES + lane, &gradient);
                            for axis in 0..D {
                                for column in 0..D {
                                    answers[axis][column][lane] = answer[axis][column];
                                }
                            }
                        }
                        for axis in 0..D {
                            for column in 0..D {
                                stress[axis][column] = simd.load(&answers[axis][column][lane..]);
                            }
                        }
                    }
                }
                let mut pull = [simd.splat(0.0); D];
                for axis in 0..D {
                    for column in 0..D {
                        let mut tensor = stress[axis][0] * kept(column);
                        for inner in 1..D {
                            tensor = stress[axis][inner].mul_add(kept(inner * D + column), tensor);
                        }
                        tensor.store(&mut left[axis * D + column][place + lane..]);
                        pull[axis] = tensor.mul_add(kept(D * D + column), pull[axis]);
                    }
                    pull[axis].store(&mut force[(number * D + axis) * LANES + lane..]);
                }
                if !are_finite(simd, &pull) {
                    let force = &force[number * D * LANES..(number + 1) * D * LANES];
                    for lane in (lane..lane + S::WIDTH).filter(|&lane| members[lane] != NOBODY) {
                        let finite = (0..D).all(|axis| force[axis * LANES + lane].is_finite());
                        if !finite && !is_odd(numbers, members[lane], lane) {
                            let point = members[lane] as usize;
                            bad = Some(bad.map_or(point, |bad| bad.min(point)));
                        }
                    }
                }
            }
        }
        (any_odd, bad)
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
        for (number, group) in range.enumerate() {
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
        let mut sum = [simd.splat(0.0); D];
        for axis in 0..D {
            sum[axis] = simd.load(&force[axis * LANES + lane..]);
        }
        for (leg, bits) in groups.legs.iter().zip(masks) {
            let there = cell.wrapping_add_signed(leg.cells);
            let mask = simd.mask(bits >> lane);
            for row in 0..D {
                let mut pull = simd.splat(0.0);
                for column in 0..D {
                    let tensor = left[row * D + column];
                    debug_assert!(there + S::WIDTH <= tensor.len());
                    // SAFETY: there are cells, as `Groups::new` has seen, and each has a number, as the sweep has.
                    let tensor =
                        simd.load(unsafe { tensor.get_unchecked(there..there + S::WIDTH) });
                    let weighted = simd.splat(leg.weighted[column]);
                    pull = match column {
                        0 => tensor * weighted,
                        _ => tensor.mul_add(weighted, pull),
                    };
                }
                sum[row] = sum[row] + if WHOLE { pull } else { pull.only(mask) };
            }
        }
        for axis in 0..D {
            sum[axis].store(&mut force[axis * LANES + lane..]);
        }
    }
}
