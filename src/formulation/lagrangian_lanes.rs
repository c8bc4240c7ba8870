//! The Lagrangian forms in lanes.
//!
//! With F = I + H of undeformed bonds and S = sum w du du^T V all follows from sweeps that there are: N = F K,
//! sum w du eta^T V = H K + S, and t = w P N^-1 (xi + du) pulls as a penalty does.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::body::Body;
use super::breaking::Near;
use super::correspondence_lanes::PENALTY_ROW;
use super::kept_rows::{Order, Point, Points, Sweep, collocate, leave_penalty, pull_with_penalty};
use super::lagrangian::{Lagrangian, Own};
use super::operators::Moments;
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Room};
use super::{Asked, EnergyPart, Scene, in_lanes};
use crate::damage::Breaking;
use crate::kernel::gradient::UnseenSweep;
use crate::tensor::{Tensor, inverse, product, read, scaled, sum, transposed, zero};
use crate::workers::PerPoint;

/// Where a row has S, behind H.
const SQUARES: usize = 9;

/// A row that sweeps over points fill in.
type Row = [f64; PENALTY_ROW];

/// The sums of points.
struct Swept<'a, const D: usize> {
    lagrangian: &'a Lagrangian,
    body: Body<'a, D>,
    kept: &'a Points<'a>,
}

impl<const D: usize> Swept<'_, D> {
    fn own(&self, point: usize, row: &Row) -> Own<D> {
        self.lagrangian.own_of(&self.body, point, &self.moments(point, row))
    }

    fn moments(&self, point: usize, row: &Row) -> Moments<D> {
        let kept: Point<'_, D, D> = self.kept.at(point);
        if !kept.spans() {
            return Moments::new(&self.body, point);
        }
        let reference = inverse(&read(kept.rows().as_flattened()));
        let moved = product(&read(row), &reference);
        let mixed = sum(&reference, &moved);
        let moved_now = sum(&moved, &read(&row[SQUARES..]));
        let now = sum(&transposed(&mixed), &moved_now);
        Moments { reference, mixed, now, moved, moved_now }
    }
}

impl Lagrangian {
    /// H and S of points that are wanted.
    fn swept_rows<const D: usize>(
        &self,
        sweep: Sweep<'_>,
        rows: &mut [Row],
        breaking: &mut Option<Breaking<'_>>,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Points<'_> {
        let kept = self.kept.sweep::<D, D, _>(
            Order { order: 1, counts_volumes: false },
            sweep,
            breaking,
            PerPoint(&mut *rows, 1),
            &wanted,
            |_, _, gradient, row| row.0[0][..D * D].copy_from_slice(gradient.as_flattened()),
        );
        if !self.deformed {
            return kept;
        }
        let scene = &in_lanes::remaining(sweep.scene, breaking);
        let family = in_lanes::family(scene, sweep.records, sweep.omega);
        scene.workers.sweep(rows.len(), PerPoint(rows, 1), |range, rows| {
            let first = range.start;
            scene.simd.run(UnseenSweep {
                family,
                range,
                gradient: |point: usize| {
                    (wanted(point) && kept.at::<D, D>(point).spans()).then(zero::<D>)
                },
                finish: |point: usize, squares: &Tensor<D>| {
                    let place = &mut rows.0[point - first][SQUARES..];
                    place[..D * D].copy_from_slice(squares.as_flattened());
                },
            });
        });
        kept
    }

    /// Makes the records of laws, where they have a memory.
    fn ask_swept<const D: usize>(
        &self,
        swept: &Swept<'_, D>,
        rows: &[Row],
        records: &mut [f64],
        near: Option<&Near<'_>>,
    ) {
        let (laws, scene) = (&self.laws, swept.body.scene);
        if !laws.remember() {
            return;
        }
        let width = laws.width();
        let outputs = PerPoint(&mut *records, width);
        scene.workers.sweep(scene.places.len(), outputs, |range, records| {
            for (record, point) in records.0.chunks_exact_mut(width).zip(range.clone()) {
                if near.is_none_or(|near| near.wants_energy(point)) {
                    let moments = swept.moments(point, &rows[point]);
                    let (deformation, _) = self.deformation_of(&moments);
                    laws.defer_at(scene, (point, point), &deformation, record);
                } else {
                    record.copy_from_slice(&scene.bonds.records[point * width..][..width]);
                }
            }
            laws.settle(scene, range.clone(), &|site| range.start + site, records.0);
        });
        laws.ask_host(scene, records);
    }

    pub(super) fn swept_forces<const D: usize>(&self, sweep: ForceSweep<'_, '_>) -> Option<usize> {
        let ForceSweep { scene, room, force, breaking, resting } = sweep;
        let (omega, count) = (self.kept.omega(scene, &self.weights)?, scene.places.len());
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let (left, _) = in_lanes::table::<PENALTY_ROW>(rest, count);
        let sweep = Sweep::new(scene, omega, records).resting(resting, 1);
        let kept = &self.swept_rows::<D>(sweep, left, breaking, |_| true);
        let scene = &in_lanes::remaining(scene, breaking);
        let sweep = Sweep { scene, ..sweep };
        let swept = Swept::<D> { lagrangian: self, body: Body::new(scene, &self.weights), kept };
        self.ask_swept(&swept, left, room.records, None);
        let asked =
            self.laws.remember().then_some(Asked { records: room.records, dissipated: false });
        let asked = &Scene { asked, ..*scene };
        let swept = Swept { body: Body::new(asked, &self.weights), ..swept };
        let bad = AtomicUsize::new(usize::MAX);
        let outputs = (PerPoint(&mut *force, D), PerPoint(&mut *left, 1));
        scene.workers.sweep(count, outputs, |range, (force, left)| {
            if resting.block(range.start, 1) {
                return;
            }
            let (forces, _) = force.0.as_chunks_mut::<D>();
            for ((force, left), point) in forces.iter_mut().zip(left.0).zip(range) {
                let own = swept.own(point, left);
                if !own.answer.energy.is_finite() {
                    bad.fetch_min(point, Ordering::Relaxed);
                }
                if self.strong {
                    self.leave(&own, left);
                    continue;
                }
                let both = sum(&own.undeformed, &own.deformed);
                let [straight, moved] =
                    [both, own.deformed].map(|operator| product(&own.answer.stress, &operator));
                let kept: Point<'_, D, D> = kept.at(point);
                *force = leave_penalty(&records[point], &straight, &moved, kept, left);
            }
        });
        let square = D * D;
        let operators = |point: usize| {
            let (row, ratio) = (&left[point], left[point][3 * square]);
            // Of eta = xi + du.
            let deformed = scaled(&read(&row[square..]), ratio);
            (sum(&scaled(&read(row), ratio), &deformed), deformed)
        };
        in_lanes::first(bad).or_else(|| match self.strong {
            true => collocate::<D, D, PENALTY_ROW>(sweep, left, 2 * square, operators, force),
            false => pull_with_penalty::<D, PENALTY_ROW>(sweep, left, force),
        })
    }

    pub(super) fn swept_energy<const D: usize>(&self, sweep: EnergySweep<'_>) -> bool {
        let EnergySweep { scene, room, density, part, near } = sweep;
        let (density, dissipated) = (PerPoint(density, 1), part == EnergyPart::Plastic);
        self.each_own::<D>(scene, room, near, dissipated, density, |_, _, own, density| {
            density[0] = own.map_or(0.0, |own| own.answer.energy);
        })
    }

    pub(super) fn swept_fields<const D: usize>(&self, sweep: FieldSweep<'_>) -> bool {
        let FieldSweep { scene, room, values, width, read } = sweep;
        let values = PerPoint(values, width);
        self.each_own::<D>(scene, room, None, false, values, |body, point, own, values| {
            if let Some(own) = own {
                read(&self.shown(body, point, own), values);
            }
        })
    }

    /// Calls `give` with what each point makes of its family and the part of the values that is its own; with nothing where `near`
    /// does not want it. False where this is not swept in lanes.
    fn each_own<const D: usize>(
        &self,
        scene: &Scene<'_>,
        room: Room<'_>,
        near: Option<&Near<'_>>,
        dissipated: bool,
        values: PerPoint<'_, f64>,
        give: impl Fn(&Body<'_, D>, usize, Option<&Own<D>>, &mut [f64]) + Sync,
    ) -> bool {
        let Some(omega) = self.kept.omega(scene, &self.weights) else { return false };
        let count = scene.places.len();
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let (rows, _) = in_lanes::table::<PENALTY_ROW>(rest, count);
        let wanted = |point| near.is_none_or(|near| near.wants_energy(point));
        let sweep = Sweep::new(scene, omega, records);
        let kept = &self.swept_rows::<D>(sweep, rows, &mut None, wanted);
        let swept = Swept::<D> { lagrangian: self, body: Body::new(scene, &self.weights), kept };
        self.ask_swept(&swept, rows, room.records, near);
        let asked = self.laws.remember().then_some(Asked { records: room.records, dissipated });
        let asked = &Scene { asked, ..*scene };
        let swept = Swept { body: Body::new(asked, &self.weights), ..swept };
        scene.workers.sweep(count, values, |range, PerPoint(values, width)| {
            for (values, point) in values.chunks_exact_mut(width).zip(range) {
                let own = wanted(point).then(|| swept.own(point, &rows[point]));
                give(&swept.body, point, own.as_ref(), values);
            }
        });
        true
    }
}
