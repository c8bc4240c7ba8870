//! The linear peridynamic solid over groups of a lattice. [P 3.14-3.20]
//!
//! With M = sum w L^2, a = C/M and b = theta/M (D kappa - C/D), both ends of a bond pull with w (a s + b) L, where
//! s = l (1/L - 1/l). On i that is the sum of w L ((a_i + a_j) (1/L - 1/l) + (b_i + b_j)/l) y: the volume, one for all,
//! goes out. The first sweep makes a and b of each point, the second the forces.

use std::ops::Range;

use super::{
    Breaks, Groups, Judge, Leg, Pulled, Term, are_finite, are_whole, judged, masks_of, walk,
};
use crate::families::LANES;
use crate::kernel::simd::{Kernel, Lanes, Simd};

/// The moduli kappa and C.
#[derive(Clone, Copy)]
pub(crate) struct Moduli {
    pub(crate) kappa: f64,
    pub(crate) deviatoric: f64,
}

/// a and b of the points of a range of groups, whose cells begin at `first`. Bonds break first.
pub(crate) struct DilationSweep<'a, J, const D: usize> {
    pub(crate) groups: Groups<'a, D>,
    pub(crate) moduli: Moduli,
    pub(crate) range: Range<usize>,
    pub(crate) first: usize,
    pub(crate) left: [&'a mut [f64]; 2],
    pub(crate) breaks: Breaks<'a, J>,
}

impl<J: Judge, const D: usize> Kernel for DilationSweep<'_, J, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { groups, moduli, range, first, left, breaks } = self;
        let Breaks { masks, broke, judge, look } = breaks;
        let mut whole = 0.0;
        for leg in groups.legs {
            whole += leg.moment;
        }
        let mut left = Left { simd, moduli, whole, columns: left };
        for (number, group) in range.enumerate() {
            let place = groups.cell(group) - first;
            let masks = &mut masks[masks_of(&groups, number)];
            let (beyond, finite) = match (are_whole(masks), look) {
                (true, true) => left.sum_up::<true, true, false, D>(&groups, group, masks, place),
                (true, false) => left.sum_up::<true, false, false, D>(&groups, group, masks, place),
                (false, true) => left.sum_up::<false, true, false, D>(&groups, group, masks, place),
                (false, false) => {
                    left.sum_up::<false, false, false, D>(&groups, group, masks, place)
                }
            };
            let broken = beyond && judged(simd, &groups, judge, group, masks);
            broke[number * LANES] |= broken;
            if broken || !finite {
                left.sum_up::<false, false, true, D>(&groups, group, masks, place);
            }
        }
    }
}

struct Left<'a, S> {
    simd: S,
    moduli: Moduli,
    /// sum w L^2 of a whole family.
    whole: f64,
    columns: [&'a mut [f64]; 2],
}

impl<S: Simd> Left<'_, S> {
    /// a and b of a group, to be put at a place; whether bonds of it come close to their limit, and whether both are
    /// finite.
    #[inline(always)]
    fn sum_up<const WHOLE: bool, const LOOK: bool, const CAREFUL: bool, const D: usize>(
        &mut self,
        groups: &Groups<'_, D>,
        group: usize,
        masks: &[u8],
        place: usize,
    ) -> (bool, bool) {
        let (simd, dimension) = (self.simd, D as f64);
        let Moduli { kappa, deviatoric } = self.moduli;
        let (mut beyond, mut finite) = (0, true);
        for lane in (0..LANES).step_by(S::WIDTH) {
            let at = (groups.cell(group) + lane, lane);
            let zero = simd.splat(0.0);
            let mut sums = Dilation { moment: zero, stretch: zero };
            beyond |= walk::<WHOLE, LOOK, CAREFUL, S, D>(simd, groups, at, masks, &mut sums);
            let moment = if WHOLE { simd.splat(self.whole) } else { sums.moment };
            let some = moment.above(zero);
            let inverse = (simd.splat(1.0) / moment).only(some);
            let a = inverse * simd.splat(deviatoric);
            let theta = simd.splat(dimension) * inverse * sums.stretch;
            let b = inverse * theta * simd.splat(dimension * kappa - deviatoric / dimension);
            finite &= are_finite(simd, &[a, b]);
            a.store(&mut self.columns[0][place + lane..]);
            b.store(&mut self.columns[1][place + lane..]);
        }
        (beyond != 0, finite)
    }
}

/// sum w L^2 and sum w L (l - L)
struct Dilation<F> {
    moment: F,
    stretch: F,
}

impl<S: Simd, const D: usize> Term<S, D> for Dilation<S::Lanes> {
    #[inline(always)]
    fn add<const WHOLE: bool>(
        &mut self,
        simd: S,
        leg: &Leg,
        bonds: &Pulled<S::Lanes, D>,
        root: S::Lanes,
        mask: S::Mask,
    ) {
        let mut extension = bonds.square * root - simd.splat(leg.length);
        if !WHOLE {
            extension = extension.only(mask);
            self.moment = self.moment + simd.splat(leg.moment).only(mask);
        }
        self.stretch = extension.mul_add(simd.splat(leg.pull), self.stretch);
    }
}

/// Forces per volume, times the unit of the legs, on the points of a range of groups: of each component eight numbers,
/// group by group.
pub(crate) struct TensionSweep<'a, const D: usize> {
    pub(crate) groups: Groups<'a, D>,
    /// a and b of all cells.
    pub(crate) left: [&'a [f64]; 2],
    pub(crate) range: Range<usize>,
    pub(crate) masks: &'a [u8],
    pub(crate) force: &'a mut [f64],
}

impl<const D: usize> Kernel for TensionSweep<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { groups, left, range, masks, force } = self;
        let cells = groups.lattice.point_of.len();
        assert!(left.iter().all(|column| column.len() == cells));
        for (number, group) in range.enumerate() {
            let force = &mut force[number * D * LANES..(number + 1) * D * LANES];
            let masks = &masks[masks_of(&groups, number)];
            let finite = if are_whole(masks) {
                tension::<true, false, S, D>(simd, &groups, left, group, masks, force)
            } else {
                tension::<false, false, S, D>(simd, &groups, left, group, masks, force)
            };
            if !finite {
                tension::<false, true, S, D>(simd, &groups, left, group, masks, force);
            }
        }
    }
}

#[inline(always)]
fn tension<const WHOLE: bool, const CAREFUL: bool, S: Simd, const D: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    left: [&[f64]; 2],
    group: usize,
    masks: &[u8],
    force: &mut [f64],
) -> bool {
    let mut finite = true;
    for lane in (0..LANES).step_by(S::WIDTH) {
        let cell = groups.cell(group) + lane;
        let own = left.map(|column| simd.load(&column[cell..]));
        let mut tension = Tension { left, own, sum: [simd.splat(0.0); D] };
        walk::<WHOLE, false, CAREFUL, S, D>(simd, groups, (cell, lane), masks, &mut tension);
        finite &= are_finite(simd, &tension.sum);
        for (axis, sum) in tension.sum.into_iter().enumerate() {
            sum.store(&mut force[axis * LANES + lane..]);
        }
    }
    finite
}

struct Tension<'a, F, const D: usize> {
    left: [&'a [f64]; 2],
    /// a and b of the points themselves.
    own: [F; 2],
    sum: [F; D],
}

impl<S: Simd, const D: usize> Term<S, D> for Tension<'_, S::Lanes, D> {
    #[inline(always)]
    fn add<const WHOLE: bool>(
        &mut self,
        simd: S,
        leg: &Leg,
        bonds: &Pulled<S::Lanes, D>,
        root: S::Lanes,
        mask: S::Mask,
    ) {
        let there = bonds.there..bonds.there + S::WIDTH;
        let mut both = self.own;
        for (both, column) in both.iter_mut().zip(self.left) {
            // SAFETY: there are cells, as `Groups::new` has seen, and each has a number, as the sweep has.
            *both = *both + simd.load(unsafe { column.get_unchecked(there.clone()) });
        }
        let [a, b] = both;
        let tension = b.mul_add(root, a * (simd.splat(leg.inverse) - root));
        let mut pull = tension * simd.splat(leg.pull);
        if !WHOLE {
            pull = pull.only(mask);
        }
        for (sum, bond) in self.sum.iter_mut().zip(bonds.bond) {
            *sum = pull.mul_add(bond, *sum);
        }
    }
}
