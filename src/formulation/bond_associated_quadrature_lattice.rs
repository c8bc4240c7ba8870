//! Bond-associated quadrature points on the part of a body that is a lattice: gradients, middles of bonds and pulls of eight points at
//! once.
//!
//! Points whose families do not span the body leave no number for 1/sum w: sums over bonds with such an end are none
//! either, and are made by single bonds.

use std::cell::Cell;
use std::ops::Range;

use super::body::Body;
use super::bond_associated_quadrature::{Baqp, before_rows};
use super::bond_associated_quadrature_lanes::{GRADIENT, halves_of_row, left_of, row_of_halves};
use super::correspondence::gradient_at;
use super::in_lanes::Which;
use super::kept_rows::{Order, Points, Sweep, pull};
use super::lattice_rows::{self as on_lattice, Gradients, LatticeRows, Seat};
use super::on_lattice::{Columns, OnLattice, Parts, by_state, unit_of};
use super::passes::ForceSweep;
use super::seam::Seam;
use super::{Scene, in_lanes};
use crate::error::Result;
use crate::families::LANES;
use crate::families::lattice::{Lattice, NOBODY, Step};
use crate::kernel::lattice::{BondStressSweep, Halves};
use crate::memory;
use crate::tensor::{Tensor, dot, product, read, scaled};
use crate::workers::PerPoint;

/// Columns of the cells: halves of gradients and of 1/sum w, and the tensors that gradients pull with.
pub(super) const fn columns(dimension: usize) -> usize {
    2 * dimension * dimension + 1
}

/// Forces, tensors and masks.
type Outputs<'a, const N: usize> = (PerPoint<'a, f64>, Columns<'a, N>, PerPoint<'a, u8>);

/// The points that have no seat, and what the sweeps leave of them.
struct Beyond<'a, const C: usize> {
    seam: &'a Seam,
    sweep: Sweep<'a>,
    gradients: &'a mut [[f64; GRADIENT]],
    kept: Points<'a>,
    left: &'a mut [[f64; C]],
}

/// xi/L^2 of the steps of a lattice, in its unit.
pub(super) fn along(lattice: &Lattice) -> Result<Vec<[f64; 3]>> {
    let unit = unit_of(lattice);
    let along = |step: &Step| {
        let reference = step.reference.map(|along| along / unit);
        let square = dot(&reference, &reference);
        reference.map(|along| along / square)
    };
    memory::collected(lattice.stencil.iter().map(along), "lattices")
}

impl Baqp {
    /// Whether its sweeps run on a lattice.
    pub(super) fn fits_lattice(&self) -> bool {
        self.order == 1 && self.weights.are_shared() && self.laws.are_elastic()
    }

    /// `A` = `D` x `D` + 1, `N` = `D` x `D`, `M`: both; `C` = 4 (`D` + 1).
    pub(super) fn forces_on_lattice<
        const D: usize,
        const M: usize,
        const A: usize,
        const N: usize,
        const C: usize,
    >(
        &self,
        (lattice, rows): (&Lattice, &LatticeRows),
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        let ForceSweep { scene, room, force, breaking, resting } = sweep;
        let (omega, laws) = (self.kept.omega(scene, &self.weights)?, self.laws.of_points()?);
        let mut beyond = rows.state.seam.as_ref().map(|seam| {
            let count = scene.places.len();
            let (records, rest) = seam.record::<D>(scene, room.tables);
            let (gradients, rest) = in_lanes::table(rest, count);
            let (left, _) = in_lanes::table::<C>(rest, count);
            let sweep = Sweep { which: Which::Listed, ..Sweep::new(scene, omega, records) };
            let sweep = sweep.resting(resting, 2);
            let kept = self.swept_gradients::<D, D>(sweep, gradients, breaking, |_| true);
            Beyond { seam, sweep, gradients, kept, left }
        });
        let rule = breaking.as_ref().map(|breaking| breaking.rule);
        let on = OnLattice::breaking(scene, (lattice, &rows.state), rule, resting);
        let order = Order { order: self.order, counts_volumes: false };
        let any_odd = Cell::new(false);
        // Members have bonds with those, too.
        let odd_beyond = beyond.as_ref().is_some_and(|beyond| beyond.kept.any_odd());
        let first = |parts: &mut Parts<'_, D, M>| {
            let take = |_: &mut [f64], left: Columns<'_, M>, gradients: Gradients<'_, D>| {
                gradients.give(&mut Halves(left.parted::<A, N>().0.values));
            };
            let odd = rows.sweep(&on, scene, (order, omega.horizon), parts, 2, take);
            any_odd.set(odd || odd_beyond);
        };
        let second = |parts: Parts<'_, D, M>, scene: &Scene<'_>, force: &mut [f64]| {
            let Parts { groups, seats, unit, mut masks, mut forces, left, .. } = parts;
            let (mut halves, mut tensors) = left.parted::<A, N>();
            let (kept, body) = (rows.kept(), &Body::<D>::new(scene, &self.weights));
            if any_odd.get() {
                let outputs = (forces.again(), halves.again());
                kept.each_seat(scene, lattice, outputs, |seat: Seat<'_, '_, D, A>| {
                    if seat.is_odd() {
                        self.leave_halves(body, seat);
                    }
                });
            }
            if let Some(Beyond { seam, gradients, .. }) = &mut beyond {
                // Lattices have a volume of 1.
                let to_cell = |row: &[f64; GRADIENT]| {
                    let mut halves = halves_of_row::<D, A>(row);
                    halves[D * D] *= lattice.volume;
                    halves
                };
                let to_row = |_: usize, mut halves: [f64; A]| {
                    halves[D * D] /= lattice.volume;
                    row_of_halves::<D>(&halves)
                };
                seam.exchange(scene, &mut halves, gradients, to_cell, to_row);
            }
            let halves = halves.values.map(|column| &*column);
            let outputs = (forces.again(), tensors.again(), masks.again());
            scene.workers.sweep(seats, outputs, |range, outputs| {
                let part = |range: Range<usize>, (force, left, masks): Outputs<'_, N>, state| {
                    let (rest, kind) = state;
                    if rest {
                        return;
                    }
                    scene.simd.run(BondStressSweep {
                        groups,
                        law: laws(lattice.sample(kind)),
                        along: &self.along,
                        halves,
                        range: range.start / LANES..range.end / LANES,
                        masks: masks.0,
                        kept: kept.numbers(),
                        force: force.0,
                        first: left.first,
                        left: left.values,
                    });
                };
                let state = |group| (on.rests(group, 1), lattice.kind(group));
                by_state(range, outputs, state, part);
            });
            if any_odd.get() {
                // sum w xi xi^T of the lattice, with lengths in its unit and a volume of 1, over that of the body.
                let less = lattice.volume * unit * unit;
                let left = |point: usize| {
                    let seat = lattice.seat_of[point];
                    if seat == NOBODY {
                        return self.prepared(body, point);
                    }
                    let seat = seat as usize;
                    let (kept, cell) = (kept.at::<D>(seat), lattice.cell(seat));
                    if !kept.spans {
                        return self.prepared(body, point);
                    }
                    let gradient: [f64; N] = std::array::from_fn(|k| 2.0 * halves[k][cell]);
                    let rows = scaled(&kept.rows, less.recip());
                    let inverse_weight = kept.inverse_weight / lattice.volume;
                    left_of::<D>(inverse_weight, &gradient, rows.as_flattened())
                };
                let outputs = (forces.again(), tensors.again());
                kept.each_seat(scene, lattice, outputs, |mut seat: Seat<'_, '_, D, N>| {
                    if seat.has_force() {
                        return;
                    }
                    let (straight, through) = self.single_bonds(body, seat.point, left);
                    let rows: Tensor<D> = read(&left(seat.point)[before_rows(D)..]);
                    let tensor = scaled(&product(&through, &rows), less);
                    seat.pull(&tensor, &straight.map(|along| along * unit));
                });
            }
            drop(kept);
            if let Some(Beyond { seam, sweep, gradients, kept, left }) = &mut beyond {
                let sweep = Sweep { scene, ..*sweep };
                self.stresses_beyond::<D, C>(sweep, gradients, kept, (force, &mut *left));
                seam.exchange_tensors::<D, N, C>(sweep, unit, &mut tensors, left);
            }
            on_lattice::pull((&on, scene), groups, (forces, masks), tensors);
            unit.recip()
        };
        let influence = |length: f64| omega.at(length);
        let found = on.sweep(scene, influence, first, second, force, breaking);
        let found = (found != usize::MAX).then_some(found);
        let Some(Beyond { sweep, left, .. }) = beyond else { return found };
        let sweep = Sweep { scene: &in_lanes::remaining(scene, breaking), ..sweep };
        let other = pull::<D, C>(sweep, left, force);
        found.into_iter().chain(other).min()
    }

    /// Of a seat whose gradient is made otherwise.
    fn leave_halves<const D: usize, const A: usize>(
        &self,
        body: &Body<'_, D>,
        mut seat: Seat<'_, '_, D, A>,
    ) {
        let (gradient, displacement_gradient, ..) = gradient_at(body, seat.point, self.order);
        for (column, value) in displacement_gradient.as_flattened().iter().enumerate() {
            seat.leave(column, 0.5 * value);
        }
        if gradient.shape.rank < D {
            seat.leave(D * D, f64::NAN);
        }
    }
}
