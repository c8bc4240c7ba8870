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
        let mut beyond = state.seam.as_ref().map(|seam| {
            let (records, rest) = seam.record::<D>(scene, room.tables);
            let (left, _) = in_lanes::table(rest, count);
            let family = in_lanes::family(scene, records, omega);
            let outputs = (&mut *force, &mut *left);
            let pulls = |point: usize, sums: [f64; 2]| self.ab::<D>(point, sums);
            own_pulls::<D, false>((scene, resting), family, outputs, breaking, pulls);
            Beyond { seam, records, left }
        });
        let rule = breaking.as_ref().map(|breaking| breaking.rule);
        let on = OnLattice::breaking(scene, (lattice, state), rule, resting);
        let moduli = |kind: usize| {
            let [kappa, deviatoric] = *self.moduli.at(lattice.sample(kind));
            Moduli { kappa, deviatoric }
        };
        let influence = |length: f64| omega.at(length);
        let first = |parts: &mut Parts<'_, D, 2>| {
            let (groups, legs, judge) = (parts.groups, parts.legs, on.limits);
            let outputs = (parts.left.again(), parts.masks.again(), parts.broke.again());
            scene.workers.sweep(parts.seats, outputs, |range, outputs| {
                let part = |range: Range<usize>, (left, masks, broke): Outputs<'_>, state| {
                    let (rest, look, kind) = state;
                    if rest {
                        return;
                    }
                    let groups = on.of_kind(groups, legs, kind);
                    let moduli = moduli(kind);
                    let breaks = Breaks { masks: masks.0, broke: broke.0, judge, look };
                    let range = range.start / LANES..range.end / LANES;
                    let (first, left) = (left.first, left.values);
                    scene.simd.run(DilationSweep { groups, moduli, range, first, left, breaks });
                };
                let state = |group| (on.rests(group, 1), on.may_break(group), lattice.kind(group));
                by_state(range, outputs, state, part);
            });
        };
        let second = |parts: Parts<'_, D, 2>, _: &Scene<'_>, _: &mut [f64]| {
            let Parts { groups, seats, unit, masks, forces, mut left, .. } = parts;
            if let Some(Beyond { seam, records, left: rows }) = &mut beyond {
                // Numbers of cells are times the volume of a point and the square of the unit.
                let square = unit * unit;
                let to_cell = |row: &Record| [row[3], row[7]].map(|number| square * number);
                let to_row = |point: usize, numbers: [f64; 2]| {
                    let mut row = records[point];
                    [row[3], row[7]] = numbers.map(|number| number / square);
                    row
                };
                seam.exchange(scene, &mut left, rows, to_cell, to_row);
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
