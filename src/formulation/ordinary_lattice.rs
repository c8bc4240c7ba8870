//! The linear peridynamic solid on the part of a body that is a lattice: dilatations, then tensions, of eight points at once.

use std::ops::Range;

use super::extension_lanes::{other_pulls, own_pulls};
use super::on_lattice::{Columns, LatticeState, OnLattice, Parts, by_state};
use super::ordinary_state_based::Lps;
use super::passes::ForceSweep;
use super::seam::Seam;
use super::{Scene, in_lanes};
use crate::families::LANES;
use crate::families::lattice::Lattice;
use crate::kernel::family::Record;
use crate::kernel::lattice::{Breaks, DilationSweep, Moduli, TensionSweep};
use crate::workers::PerPoint;

/// Dilatations, masks, and whether any has broken.
type Outputs<'a> = (Columns<'a, 2>, PerPoint<'a, u8>, PerPoint<'a, bool>);

impl Lps {
    pub(super) fn forces_on_lattice<const D: usize>(
        &self,
        (lattice, state): (&Lattice, &LatticeState),
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        let ForceSweep { scene, room, force, breaking, resting } = sweep;
        let (omega, count) = (in_lanes::omega(scene, &self.weights)?, scene.places.len());
        let mut beyond = self.seam.as_ref().map(|seam| {
            let (records, rest) = seam.record::<D>(scene, room.tables);
            let (left, _) = in_lanes::table(rest, count);
            let family = in_lanes::family(scene, records, omega);
            let outputs = (&mut *force, &mut *left);
            let pulls = |point: usize, sums: [f64; 2]| self.ab::<D>(point, sums);
            own_pulls::<D, false>((scene, resting), family, outputs, breaking, pulls);
            Beyond { seam, records, left }
        });
        let on = OnLattice::breaking(scene, (lattice, state), breaking.as_ref(), resting);
        let [kappa, deviatoric] = *self.moduli.at(0);
        let moduli = Moduli { kappa, deviatoric };
        let influence = |length: f64| omega.at(length);
        let first = |parts: &mut Parts<'_, D, 2>| {
            let (groups, look, judge) = (parts.groups, parts.look, on.limits);
            let outputs = (parts.left.again(), parts.masks.again(), parts.broke.again());
            scene.workers.sweep(parts.seats, outputs, |range, outputs| {
                let part = |range: Range<usize>, (left, masks, broke): Outputs<'_>, rest| {
                    if rest {
                        return;
                    }
                    let breaks = Breaks { masks: masks.0, broke: broke.0, judge, look };
                    let range = range.start / LANES..range.end / LANES;
                    let (first, left) = (left.first, left.values);
                    scene.simd.run(DilationSweep { groups, moduli, range, first, left, breaks });
                };
                by_state(range, outputs, |group| on.rests(group, 1), part);
            });
        };
        let second = |parts: Parts<'_, D, 2>, _: &Scene<'_>| {
            let Parts { groups, seats, unit, masks, forces, mut left, .. } = parts;
            if let Some(beyond) = &mut beyond {
                beyond.exchange(scene, unit, &mut left);
            }
            let left = left.values.map(|column| &*column);
            on.pull(scene, seats, (forces, masks), |range, force, masks| {
                scene.simd.run(TensionSweep { groups, left, range, masks, force });
            });
            unit.recip()
        };
        let bad = on.sweep(scene, influence, first, second, force, breaking);
        let bad = (bad != usize::MAX).then_some(bad);
        let Some(Beyond { left, .. }) = beyond else { return bad };
        let scene = &in_lanes::remaining(scene, breaking);
        let family = in_lanes::family(scene, left, omega);
        let other = other_pulls::<D, false>((scene, resting), family, force);
        bad.into_iter().chain(other).min()
    }
}

/// The points that have no seat, and what the first sweep leaves of them.
struct Beyond<'a> {
    seam: &'a Seam,
    records: &'a [Record],
    /// Records with a V and b V.
    left: &'a mut [Record],
}

impl Beyond<'_> {
    /// Gives a and b of points without a seat to their cells, and those of members to their records. Those of cells are times the
    /// volume of a point and the square of the unit.
    fn exchange(&mut self, scene: &Scene<'_>, unit: f64, cells: &mut Columns<'_, 2>) {
        let Self { seam, records, left } = self;
        let square = unit * unit;
        for place in seam.beyond() {
            let own = &left[place.point as usize];
            for (column, number) in cells.values.iter_mut().zip([own[3], own[7]]) {
                column[place.cell as usize] = square * number;
            }
        }
        let [a, b] = cells.values.each_ref().map(|column| &**column);
        scene.workers.sweep(records.len(), PerPoint(&mut **left, 1), |range, left| {
            for place in seam.edge(&range) {
                let (point, cell) = (place.point as usize, place.cell as usize);
                let own = &mut left.0[point - range.start];
                *own = records[point];
                (own[3], own[7]) = (a[cell] / square, b[cell] / square);
            }
        });
    }
}
