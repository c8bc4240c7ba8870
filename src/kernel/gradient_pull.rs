//! What bonds pull that a gradient has been taken of: sum w V_j T_j q(-xi) over the other ends j, with tensors T of so
//! many columns as there are monomials. [P 3.31-3.53]
//!
//! Here rows are not turned into columns: a bond is a few products of a column of its tensor with a number.

#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::ops::Range;

use super::family::{Family, Table};
use super::simd::{Kernel, Lanes, Quad, Simd};

/// Adds the pull of other ends to the forces of a range. Rows of the table have the place of a point and 1 over its horizon,
/// and the columns of V T, in four numbers each. Gives the first point whose force is not finite.
pub(crate) struct GradientPull<'a, const D: usize, const C: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) table: Table<'a, C>,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
}

/// Sums that are kept apart, so that one does not wait for the other.
const APART: usize = 4;

impl<const D: usize, const C: usize> Kernel for GradientPull<'_, D, C> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<usize> {
        let Self { family, table, range, force } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        let weighs = family.is_weighted();
        let mut bad = None;
        for (force, point) in forces.iter_mut().zip(range) {
            let place = simd.quad(&place_of(table.row(point)));
            let mut sums = [simd.quad_of(0.0); APART];
            each_bond::<S, D, C, false>(
                simd,
                (&family, &table),
                point,
                |lane, name, [weight, _]| {
                    // SAFETY: the search makes neighbours of points of the body alone, and each has a row.
                    let row = unsafe { table.row_of(name) };
                    let pull = pull::<S, D, C>(simd, row, place);
                    let sum = &mut sums[lane % APART];
                    *sum =
                        if weighs { pull.fused(simd.quad_of(weight), *sum) } else { *sum + pull };
                },
            );
            let sum = ((sums[0] + sums[1]) + (sums[2] + sums[3])).numbers();
            for axis in 0..D {
                force[axis] += sum[axis];
            }
            note(&mut bad, point, force);
        }
        bad
    }
}

/// The same with a penalty: sum w_ji V_j (T_j xi + C_j du) over the other ends j, and C_i sum w_ij V_j du. Rows of the table
/// have place and volume, displacement, and the columns of T and C, in four numbers each.
pub(crate) struct PenaltyPull<'a, const D: usize, const C: usize> {
    pub(crate) family: Family<'a>,
    pub(crate) table: Table<'a, C>,
    pub(crate) range: Range<usize>,
    pub(crate) force: &'a mut [f64],
}

impl<const D: usize, const C: usize> Kernel for PenaltyPull<'_, D, C> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<usize> {
        if self.family.ends_differ() {
            self.pull::<S, true>(simd)
        } else {
            self.pull::<S, false>(simd)
        }
    }
}

impl<const D: usize, const C: usize> PenaltyPull<'_, D, C> {
    /// `DIFFER`: the ends of a bond count it differently.
    #[inline(always)]
    fn pull<S: Simd, const DIFFER: bool>(self, simd: S) -> Option<usize> {
        let Self { family, table, range, force } = self;
        let (forces, _) = force.as_chunks_mut::<D>();
        let weighs = family.is_weighted();
        let mut bad = None;
        for (force, point) in forces.iter_mut().zip(range) {
            let own = table.row(point);
            let (place, shift) = (simd.quad(&place_of(own)), simd.quad(quad_at(own, 1)));
            let mut sums = [simd.quad_of(0.0); APART];
            let mut moves = [simd.quad_of(0.0); APART];
            each_bond::<S, D, C, DIFFER>(simd, (&family, &table), point, |lane, name, weights| {
                // SAFETY: the search makes neighbours of points of the body alone, and each has a row.
                let row = unsafe { table.row_of(name) };
                let column = |number: usize| simd.quad(quad_at(row, number));
                let reference = column(0) - place;
                let moved = column(1) - shift;
                let mut pull = column(2) * reference.component::<0>();
                pull = column(2 + D).fused(moved.component::<0>(), pull);
                pull = column(3).fused(reference.component::<1>(), pull);
                pull = column(3 + D).fused(moved.component::<1>(), pull);
                if D == 3 {
                    pull = column(4).fused(reference.component::<2>(), pull);
                    pull = column(4 + D).fused(moved.component::<2>(), pull);
                }
                let volume = reference.component::<3>();
                let [mut back, mut own] = [volume; 2];
                if weighs {
                    back = volume * simd.quad_of(weights[0]);
                    own = if DIFFER { volume * simd.quad_of(weights[1]) } else { back };
                }
                sums[lane % APART] = pull.fused(back, sums[lane % APART]);
                moves[lane % APART] = moved.fused(own, moves[lane % APART]);
            });
            let moved = ((moves[0] + moves[1]) + (moves[2] + moves[3])).numbers();
            let mut sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
            for axis in 0..D {
                let column = simd.quad(quad_at(own, 2 + D + axis));
                sum = column.fused(simd.quad_of(moved[axis]), sum);
            }
            let sum = sum.numbers();
            for axis in 0..D {
                force[axis] += sum[axis];
            }
            note(&mut bad, point, force);
        }
        bad
    }
}

/// Calls `take` with lane, other end and weights, there and with `DIFFER` here, of the bonds of a point; they are 1 unless the
/// family weighs them. The other ends' rows of the table are fetched ahead.
#[inline(always)]
fn each_bond<S: Simd, const D: usize, const C: usize, const DIFFER: bool>(
    simd: S,
    (family, table): (&Family<'_>, &Table<'_, C>),
    point: usize,
    mut take: impl FnMut(usize, u32, [f64; 2]),
) {
    let weighs = family.is_weighted();
    let (start, end) = family.swept(point);
    let own = family.own(simd, point);
    let mut weights = [[1.0; 8]; 2];
    for slot in (start..end).step_by(8) {
        let bits = family.bits(slot);
        if weighs {
            for lane in (0..8).step_by(S::WIDTH) {
                let (one, slot) = (simd.splat(1.0), slot + lane);
                let reference = family.reference_for_weight::<S, D>(simd, &own, slot);
                let back = family.weighted_back(simd, slot, &reference, one);
                back.store(&mut weights[0][lane..]);
                if DIFFER {
                    let own = family.weighted(simd, slot, &reference, one);
                    own.store(&mut weights[1][lane..]);
                }
            }
        }
        table.ask_ahead(family, slot, 8);
        let names = family.block(slot);
        for lane in 0..8 {
            if bits >> lane & 1 != 0 {
                take(lane, names[lane], [weights[0][lane], weights[1][lane]]);
            }
        }
    }
}

/// Notes the first point whose force is not finite.
#[inline(always)]
fn note<const D: usize>(bad: &mut Option<usize>, point: usize, force: &[f64; D]) {
    if bad.is_none() && !force.iter().all(|component| component.is_finite()) {
        *bad = Some(point);
    }
}

#[inline(always)]
fn quad_at<const C: usize>(row: &[f64; C], number: usize) -> &[f64; 4] {
    &row.as_chunks().0[number]
}

/// The place of a point, of which what stands behind it is not to be taken off that of others.
#[inline(always)]
fn place_of<const C: usize>(row: &[f64; C]) -> [f64; 4] {
    [row[0], row[1], row[2], 0.0]
}

/// V_j (- T_j q(-xi)): what is of second order does not change its sign with xi.
#[inline(always)]
fn pull<S: Simd, const D: usize, const C: usize>(
    simd: S,
    row: &[f64; C],
    place: S::Quad,
) -> S::Quad {
    let column = |number: usize| simd.quad(quad_at(row, 1 + number));
    let reference = simd.quad(quad_at(row, 0)) - place;
    let is_first_order = C == 4 * (1 + D);
    let q = if is_first_order { reference } else { reference * reference.component::<3>() };
    let terms = [q.component::<0>(), q.component::<1>(), q.component::<2>()];
    let mut pull = column(0) * terms[0];
    pull = column(1).fused(terms[1], pull);
    if D == 3 {
        pull = column(2).fused(terms[2], pull);
    }
    if is_first_order {
        return pull;
    }
    let mut even = column(D) * (terms[0] * terms[0]);
    even = column(D + 1).fused(terms[1] * terms[1], even);
    if D == 3 {
        even = column(5).fused(terms[2] * terms[2], even);
        even = column(6).fused(terms[0] * terms[1], even);
        even = column(7).fused(terms[0] * terms[2], even);
        even = column(8).fused(terms[1] * terms[2], even);
    } else {
        even = column(4).fused(terms[0] * terms[1], even);
    }
    pull - even
}
