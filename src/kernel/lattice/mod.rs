//! Sweeps over groups of a lattice: the points of eight cells are computed along the stencil.
//!
//! All points have one volume. Lengths are in a unit near those of the stencil, and 1/L is computed as 1/l is, from the
//! same bits where the ends of a bond move alike: 1/L - 1/l is exactly 0 there.

mod bond_based;
mod correspondence;
mod gradients;
mod ordinary_state_based;
mod quadrature;

use super::simd::{Kernel, Lanes, Mask, Simd};
use crate::families::LANES;
use crate::families::lattice::{Lattice, Step};

pub(crate) use bond_based::BondSweep;
pub(crate) use correspondence::{PullSweep, Stresses};
pub(crate) use gradients::{GroupGradients, KeptSeat, TakeGradients, is_odd};
pub(crate) use ordinary_state_based::{DilationSweep, Moduli, TensionSweep};
pub(crate) use quadrature::{BondStressSweep, Halves};

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
    /// w
    weight: f64,
    /// w xi
    weighted: [f64; 3],
    /// L, as l is made of l^2 and 1/l.
    length: f64,
    /// w L
    pull: f64,
    /// w L^2
    moment: f64,
}

/// Makes the steps of a stencil ready: `unit` of a length is 1, and beyond (l/L)^2 - 1 = `threshold` bonds come close to
/// their limit.
pub(crate) struct Prepare<'a, W> {
    pub(crate) stencil: &'a [Step],
    pub(crate) unit: f64,
    pub(crate) threshold: f64,
    /// w of a length.
    pub(crate) influence: W,
    pub(crate) legs: &'a mut [Leg],
}

impl<W: Fn(f64) -> f64> Kernel for Prepare<'_, W> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let first = |lanes: S::Lanes| {
            let mut numbers = [0.0; LANES];
            lanes.store(&mut numbers);
            numbers[0]
        };
        for (leg, step) in self.legs.iter_mut().zip(self.stencil) {
            let reference = step.reference.map(|along| along / self.unit);
            let square = square(reference.map(|along| simd.splat(along)));
            let (inverse, squared) = (first(square.reciprocal_root()), first(square));
            let length = squared.sqrt();
            let weight = (self.influence)(length * self.unit);
            *leg = Leg {
                cells: step.cells,
                reference,
                inverse,
                limit: squared * (1.0 + self.threshold),
                weight,
                weighted: reference.map(|along| weight * along),
                length: squared * inverse,
                pull: weight * length,
                moment: weight * squared,
            };
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

/// What the sweeps read.
#[derive(Clone, Copy)]
pub(crate) struct Groups<'a, const D: usize> {
    lattice: &'a Lattice,
    legs: &'a [Leg],
    /// A component of the displacement of each cell, in the unit of the legs.
    shifts: [&'a [f64]; D],
    /// Whether groups without bonds are left out.
    skips_bare: bool,
}

impl<'a, const D: usize> Groups<'a, D> {
    /// Panics when there is not a leg for each step and a displacement for each cell.
    pub(crate) fn new(
        lattice: &'a Lattice,
        legs: &'a [Leg],
        shifts: [&'a [f64]; D],
        skips_bare: bool,
    ) -> Self {
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
        Self { lattice, legs, shifts, skips_bare }
    }

    /// The same with other limits. Panics when these are not legs of the same steps.
    pub(crate) fn with_legs(self, legs: &'a [Leg]) -> Self {
        assert_eq!(legs.len(), self.legs.len());
        assert!(legs.iter().zip(self.legs).all(|(leg, own)| leg.cells == own.cells));
        Self { legs, ..self }
    }

    fn cell(&self, group: usize) -> usize {
        self.lattice.groups[group] as usize
    }
}

/// Says whether bonds break that come close to their limit: those of points along steps of the stencil.
pub(crate) trait Judge: Copy + Sync {
    fn breaks(&self, point: usize, step: usize) -> bool;
}

/// The bonds of a range of groups, and where they break.
pub(crate) struct Breaks<'a, J> {
    /// [`Lattice::row`] masks a group: of each step of the stencil, the points that have a bond there.
    pub(crate) masks: &'a mut [u8],
    /// One a point: that of a group's first tells of bonds that have broken in it.
    pub(crate) broke: &'a mut [bool],
    pub(crate) judge: J,
    /// Whether any can break at all.
    pub(crate) look: bool,
}

/// Masks of a group of a range.
#[inline(always)]
fn masks_of<const D: usize>(groups: &Groups<'_, D>, number: usize) -> std::ops::Range<usize> {
    let first = number * groups.lattice.row();
    first..first + groups.legs.len()
}

#[inline(always)]
fn are_whole(masks: &[u8]) -> bool {
    let mut all = u8::MAX;
    for mask in masks {
        all &= mask;
    }
    all == u8::MAX
}

/// Takes the bonds of a group that break from its masks, and says whether there were any.
#[inline(always)]
fn judged<S: Simd, const D: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    judge: impl Judge,
    group: usize,
    masks: &mut [u8],
) -> bool {
    let mut broke = false;
    for lane in (0..LANES).step_by(S::WIDTH) {
        let cell = groups.cell(group) + lane;
        let mut own = [simd.splat(0.0); D];
        for (own, shifts) in own.iter_mut().zip(groups.shifts) {
            *own = simd.load(&shifts[cell..]);
        }
        for (step, leg) in groups.legs.iter().enumerate() {
            let close = stretch(simd, groups, cell, leg, &own).square.above(simd.splat(leg.limit));
            let mut bits = (close.bits() << lane) & masks[step];
            while bits != 0 {
                let own = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let point = groups.lattice.members[group * LANES + own] as usize;
                if judge.breaks(point, step) {
                    masks[step] &= !(1 << own);
                    broke = true;
                }
            }
        }
    }
    broke
}

/// Bonds at a displacement.
#[derive(Clone, Copy)]
struct Pulled<F, const D: usize> {
    /// y - xi
    moved: [F; D],
    /// y
    bond: [F; D],
    /// l^2
    square: F,
    /// First cell of their other ends.
    there: usize,
}

/// What a sweep sums up over the bonds of points.
trait Term<S: Simd, const D: usize> {
    /// Adds the bonds of a step, with their 1/l. `WHOLE`: all are there, else those of the mask.
    fn add<const WHOLE: bool>(
        &mut self,
        simd: S,
        leg: &Leg,
        bonds: &Pulled<S::Lanes, D>,
        root: S::Lanes,
        mask: S::Mask,
    );
}

/// The least l^2 that a root is taken of, where ends may fall together.
const LEAST: f64 = 1e-30;

/// Sums up a term over the bonds of `WIDTH` points from a cell on, those of the masks from a lane on. With `LOOK`, gives the
/// points that have bonds close to their limit. `WHOLE`: there are all bonds. Without `CAREFUL` the sums are not finite
/// where points fall together.
#[inline(always)]
fn walk<const WHOLE: bool, const LOOK: bool, const CAREFUL: bool, S: Simd, const D: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    (cell, lane): (usize, usize),
    masks: &[u8],
    term: &mut impl Term<S, D>,
) -> u8 {
    if !WHOLE && groups.skips_bare && masks.iter().all(|&mask| mask == 0) {
        return 0;
    }
    let mut own = [simd.splat(0.0); D];
    for (own, shifts) in own.iter_mut().zip(groups.shifts) {
        *own = simd.load(&shifts[cell..]);
    }
    let Some((first, rest)) = groups.legs.split_first() else { return 0 };
    // Below 0 where a bond is longer than its limit: to compare each takes a slot of the units that multiply.
    let mut room = simd.splat(0.0);
    let (&last, before) = masks.split_last().unwrap_or((&0, &[]));
    // While one step's root is taken, the next one's points are fetched.
    let (mut leg, mut pulled) = (first, stretch(simd, groups, cell, first, &own));
    for (next, &mask) in rest.iter().zip(before) {
        let ahead = stretch(simd, groups, cell, next, &own);
        pull::<WHOLE, LOOK, CAREFUL, S, D>(simd, leg, mask >> lane, pulled, &mut room, term);
        (leg, pulled) = (next, ahead);
    }
    pull::<WHOLE, LOOK, CAREFUL, S, D>(simd, leg, last >> lane, pulled, &mut room, term);
    room.signs()
}

#[inline(always)]
fn stretch<S: Simd, const D: usize>(
    simd: S,
    groups: &Groups<'_, D>,
    cell: usize,
    leg: &Leg,
    own: &[S::Lanes; D],
) -> Pulled<S::Lanes, D> {
    let there = cell.wrapping_add_signed(leg.cells);
    let (mut moved, mut bond) = (*own, *own);
    for axis in 0..D {
        debug_assert!(there + S::WIDTH <= groups.shifts[axis].len());
        // SAFETY: the legs lead from the cells of groups to cells, as `Groups::new` has seen.
        let shifts = unsafe { groups.shifts[axis].get_unchecked(there..there + S::WIDTH) };
        moved[axis] = simd.load(shifts) - own[axis];
        bond[axis] = moved[axis] + simd.splat(leg.reference[axis]);
    }
    Pulled { moved, bond, square: square(bond), there }
}

#[inline(always)]
fn pull<const WHOLE: bool, const LOOK: bool, const CAREFUL: bool, S: Simd, const D: usize>(
    simd: S,
    leg: &Leg,
    bits: u8,
    mut pulled: Pulled<S::Lanes, D>,
    room: &mut S::Lanes,
    term: &mut impl Term<S, D>,
) {
    let mask = simd.mask(bits);
    if LOOK {
        let own = simd.splat(leg.limit) - pulled.square;
        *room = room.joined(if WHOLE { own } else { own.only(mask) });
    }
    if CAREFUL {
        pulled.square = pulled.square.max(simd.splat(LEAST));
        // Where a step is no bond, what it leads to may be no number.
        for bond in &mut pulled.bond {
            *bond = bond.only(mask);
        }
    }
    let root = pulled.square.reciprocal_root();
    term.add::<WHOLE>(simd, leg, &pulled, root, mask);
}

/// Whether all lanes of some numbers are finite.
#[inline(always)]
fn are_finite<S: Simd, const N: usize>(simd: S, numbers: &[S::Lanes; N]) -> bool {
    let mut one = simd.splat(1.0);
    for number in numbers {
        one = number.mul_add(simd.splat(0.0), one);
    }
    let wanted = (1_u32 << S::WIDTH) - 1;
    u32::from(one.above(simd.splat(0.0)).bits()) & wanted == wanted
}
