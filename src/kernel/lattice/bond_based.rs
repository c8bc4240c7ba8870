//! bond_based over groups of a lattice: with one volume and bond constant, the sum of (1/L - 1/l) y.

use std::ops::Range;

use super::{
    Breaks, Groups, Judge, Leg, Pulled, Term, are_finite, are_whole, judged, masks_of, walk,
};
use crate::families::LANES;
use crate::kernel::simd::{Kernel, Lanes, Simd};

/// Forces per volume, of a neighbour's volume and bond constant 1, on the points of a range of groups: of each component
/// eight numbers, group by group. Bonds that break do not pull any more.
pub(crate) struct BondSweep<'a, J, const D: usize> {
    pub(crate) groups: Groups<'a, D>,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
    pub(crate) breaks: Breaks<'a, J>,
}

impl<J: Judge, const D: usize> Kernel for BondSweep<'_, J, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { groups, range, force, breaks: Breaks { masks, broke, judge, look } } = self;
        for (number, group) in range.enumerate() {
            let force = &mut force[number * D * LANES..(number + 1) * D * LANES];
            let masks = &mut masks[masks_of(&groups, number)];
            let (beyond, finite) = match (are_whole(masks), look) {
                (true, true) => {
                    sum_up::<true, true, false, S, D>(simd, &groups, group, masks, force)
                }
                (true, false) => {
                    sum_up::<true, false, false, S, D>(simd, &groups, group, masks, force)
                }
                (false, true) => {
                    sum_up::<false, true, false, S, D>(simd, &groups, group, masks, force)
                }
                (false, false) => {
                    sum_up::<false, false, false, S, D>(simd, &groups, group, masks, force)
                }
            };
            let broken = beyond && judged(simd, &groups, judge, group, masks);
            broke[number * LANES] |= broken;
            if broken || !finite {
                sum_up::<false, false, true, S, D>(simd, &groups, group, masks, force);
            }
        }
    }
}

/// The forces on a group; whether bonds of it come close to their limit, and whether all forces are finite.
#[inline(always)]
fn sum_up<const WHOLE: bool, const LOOK: bool, const CAREFUL: bool, S: Simd, const D: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    group: usize,
    masks: &[u8],
    force: &mut [f64],
) -> (bool, bool) {
    let (mut beyond, mut finite) = (0, true);
    for lane in (0..LANES).step_by(S::WIDTH) {
        let at = (groups.cell(group) + lane, lane);
        let mut sum = Sum([simd.splat(0.0); D]);
        beyond |= walk::<WHOLE, LOOK, CAREFUL, S, D>(simd, groups, at, masks, &mut sum);
        finite &= are_finite(simd, &sum.0);
        for (axis, sum) in sum.0.into_iter().enumerate() {
            sum.store(&mut force[axis * LANES + lane..]);
        }
    }
    (beyond != 0, finite)
}

struct Sum<F, const D: usize>([F; D]);

impl<S: Simd, const D: usize> Term<S, D> for Sum<S::Lanes, D> {
    #[inline(always)]
    fn add<const WHOLE: bool>(
        &mut self,
        simd: S,
        leg: &Leg,
        bonds: &Pulled<S::Lanes, D>,
        root: S::Lanes,
        mask: S::Mask,
    ) {
        let mut weight = simd.splat(leg.inverse) - root;
        if !WHOLE {
            weight = weight.only(mask);
        }
        for (sum, bond) in self.0.iter_mut().zip(bonds.bond) {
            *sum = weight.mul_add(bond, *sum);
        }
    }
}
