//! The sweeps of bond_based for forces: groups of a lattice where there is one, blocks of bonds elsewhere.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::bond_laws::Various;
use super::calm::Resting;
use super::on_lattice::{OnLattice, Parts, by_state};
use super::{Scene, in_lanes};
use crate::damage::{BreakRule, Breaking, close_to};
use crate::families::lattice::NOBODY;
use crate::families::{LANES, Property};
use crate::kernel::bond_based::{
    BondLaw, Cloud, EnergySweep, FieldSweep, ForceSweep, Record, Remaining,
};
use crate::kernel::fields::BondSums;
use crate::kernel::lattice::{BondSweep, Breaks};
use crate::workers::{PerPoint, Ragged};

/// Forces, masks, and whether any has broken.
type Outputs<'a> = (PerPoint<'a, f64>, PerPoint<'a, u8>, PerPoint<'a, bool>);

/// How bonds pull in a sweep.
pub(super) struct BondForces<'a, L> {
    pub(super) law: L,
    pub(super) lattice: Option<OnLattice<'a>>,
    /// Bond constants of points, where models differ by them and groups of a lattice pull by those of their kind.
    pub(super) constants: Option<&'a Property>,
    /// Where nothing happens.
    pub(super) resting: Resting<'a>,
}

impl<L: BondLaw> BondForces<'_, L> {
    /// Forces per volume on all points; with `breaking`, bonds beyond their limit break first. Gives the first point whose
    /// force is not finite.
    pub(super) fn sweep<const D: usize>(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> Option<usize> {
        let (lattice, count) = (&self.lattice, scene.places.len());
        let mut first = usize::MAX;
        if lattice.as_ref().is_none_or(|on| on.lattice.count < count) {
            let steps = lattice.is_none() && scene.families.lattice.is_some();
            first = first.min(match scene.families.inverse_lengths {
                _ if steps => self.sweep_cloud::<true, true, D>(scene, scratch, force, breaking),
                Some(_) => self.sweep_cloud::<false, false, D>(scene, scratch, force, breaking),
                None => self.sweep_cloud::<true, false, D>(scene, scratch, force, breaking),
            });
        }
        if let Some(on) = lattice {
            first = first.min(self.sweep_lattice::<D>(scene, on, force, breaking));
        }
        (first != usize::MAX).then_some(first)
    }

    /// As [`BondForces::sweep`], of the points that have a seat on a lattice. Gives a number beyond all points where all
    /// is finite.
    fn sweep_lattice<const D: usize>(
        &self,
        scene: &Scene<'_>,
        on: &OnLattice<'_>,
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> usize {
        let first = |parts: &mut Parts<'_, D, 0>| {
            let (groups, legs, judge) = (parts.groups, parts.legs, on.limits);
            let outputs = (parts.forces.again(), parts.masks.again(), parts.broke.again());
            scene.workers.sweep(parts.seats, outputs, |range, outputs| {
                let part = |range: Range<usize>, (force, masks, broke): Outputs<'_>, state| {
                    let (rest, look, kind) = state;
                    if rest {
                        return force.0.fill(0.0);
                    }
                    let groups = on.of_kind(groups, legs, kind);
                    let breaks = Breaks { masks: masks.0, broke: broke.0, judge, look };
                    let range = range.start / LANES..range.end / LANES;
                    let force = force.0;
                    scene.simd.run(BondSweep { groups, range, force: &mut *force, breaks });
                    if let Some(constants) = self.constants {
                        let constant = constants.at(on.lattice.sample(kind));
                        force.iter_mut().for_each(|force| *force *= constant);
                    }
                };
                let state =
                    |group| (on.rests(group, 0), on.may_break(group), on.lattice.kind(group));
                by_state(range, outputs, state, part);
            });
        };
        let second = |_: Parts<'_, D, 0>, _: &Scene<'_>, _: &mut [f64]| {
            self.law.factor() * on.lattice.volume
        };
        on.sweep(scene, |_| 1.0, first, second, force, breaking)
    }

    /// As [`BondForces::sweep`], of the points that are no members of a lattice, and with `STEPS` of all; `LEAN`: lengths are
    /// computed. Gives a number beyond all points where all is finite.
    fn sweep_cloud<const LEAN: bool, const STEPS: bool, const D: usize>(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> usize {
        let (law, count) = (self.law, scene.places.len());
        let seats = self.lattice.as_ref().map(|on| &on.lattice.seat_of[..]);
        let seam = self.lattice.as_ref().and_then(|on| on.state.seam.as_ref());
        let wanted = |first: usize| seam.is_none_or(|seam| seam.is_near(first));
        let records = records_of::<LEAN, D>(scene, scratch, wanted);
        let cloud = Cloud::new(scene.families, records, scene.bonds.intact);
        let bad = AtomicUsize::new(usize::MAX);
        let rule = breaking.as_ref().map(|breaking| breaking.rule);
        let threshold = rule.and_then(BreakRule::uniform).map(close_to);
        let masks = breaking.as_mut().map(|breaking| breaking.shared(scene.families));
        let (masks, broke) = masks.unzip();
        scene.workers.sweep(count, (PerPoint(force, D), masks), |range, (force, masks)| {
            let force = force.0;
            if self.resting.block(range.start, 0) {
                return rest::<D>(range, seats, force);
            }
            let remaining = masks
                .zip(broke)
                .filter(|_| !self.resting.is_short(range.start, threshold))
                .map(|(masks, broke)| Remaining { masks: masks.values, broke });
            let skips_bare = scene.skips.without_bonds;
            let sweep =
                ForceSweep::<_, LEAN, STEPS, D> { cloud, law, range, force, remaining, skips_bare };
            if let Some(point) = scene.simd.run(sweep) {
                bad.fetch_min(point, Ordering::Relaxed);
            }
        });
        bad.into_inner()
    }
}

/// Energies per volume of all points.
pub(super) fn energies<const D: usize>(
    scene: &Scene<'_>,
    law: impl BondLaw,
    scratch: &mut [f64],
    density: &mut [f64],
) {
    let records = records_of::<true, D>(scene, scratch, |_| true);
    let cloud = Cloud::new(scene.families, records, scene.bonds.intact);
    let has_steps = scene.families.lattice.is_some();
    scene.workers.sweep(scene.places.len(), PerPoint(density, 1), |range, density| {
        let density = density.0;
        if has_steps {
            scene.simd.run(EnergySweep::<_, true, D> { cloud, law, range, density });
        } else {
            scene.simd.run(EnergySweep::<_, false, D> { cloud, law, range, density });
        }
    });
}

/// Gives the sums of which fields are made to `give`, of all points.
pub(super) fn fields<const D: usize>(
    scene: &Scene<'_>,
    law: impl BondLaw,
    scratch: &mut [f64],
    values: PerPoint<'_, f64>,
    give: impl Fn(usize, &BondSums<f64, D>, &mut [f64]) + Sync,
) {
    let records = records_of::<true, D>(scene, scratch, |_| true);
    let cloud = Cloud::new(scene.families, records, scene.bonds.intact);
    let has_steps = scene.families.lattice.is_some();
    scene.workers.sweep(scene.places.len(), values, |range, PerPoint(values, width)| {
        let first = range.start;
        let finish = |point: usize, sums: &_| {
            give(point, sums, &mut values[(point - first) * width..][..width]);
        };
        if has_steps {
            scene.simd.run(FieldSweep::<_, _, true, D> { cloud, law, range, finish });
        } else {
            scene.simd.run(FieldSweep::<_, _, false, D> { cloud, law, range, finish });
        }
    });
}

/// No force on points that have no seat.
fn rest<const D: usize>(range: Range<usize>, seats: Option<&[u32]>, force: &mut [f64]) {
    for (force, point) in force.chunks_exact_mut(D).zip(range) {
        if seats.is_none_or(|seats| seats[point] == NOBODY) {
            force.fill(0.0);
        }
    }
}

/// A record of each point, in the scratch, but for blocks that are not wanted, by their first points.
fn records_of<'a, const LEAN: bool, const D: usize>(
    scene: &Scene<'_>,
    scratch: &'a mut [f64],
    wanted: impl Fn(usize) -> bool + Sync,
) -> &'a [Record] {
    let count = scene.places.len();
    let (records, _) = in_lanes::table(scratch, count);
    let (shifts, _) = scene.displacement.as_chunks::<D>();
    scene.workers.sweep(count, PerPoint(&mut *records, 1), |range, records| {
        if !wanted(range.start) {
            return;
        }
        for (record, point) in records.0.iter_mut().zip(range) {
            *record = [0.0; 8];
            record[..4].copy_from_slice(&scene.places[point]);
            for (axis, shift) in shifts[point].iter().enumerate() {
                record[axis] += if LEAN { 0.0 } else { 0.5 * shift };
                record[4 + axis] = 2.0 * shift;
            }
        }
    });
    records
}

/// Adds what points lose by the bonds that have broken.
pub(super) fn book(scene: &Scene<'_>, law: Various<'_>, breaking: Breaking<'_>) {
    let Breaking { intact, dissipated, before, .. } = breaking;
    let offsets = &scene.families.offsets;
    let masks = Ragged { values: intact, offsets, width: 1 };
    let outputs = (masks, PerPoint(dissipated, 1));
    scene.workers.sweep(scene.places.len(), outputs, |range, (masks, dissipated)| {
        let first = offsets[range.start] as usize;
        let old = &scene.bonds.intact[first..offsets[range.end] as usize];
        if old == masks.values {
            return;
        }
        for (dissipated, point) in dissipated.0.iter_mut().zip(range) {
            let blocks = scene.families.blocks(point);
            let remaining = &masks.values[blocks.start - first..blocks.end - first];
            if remaining != &scene.bonds.intact[blocks] {
                *dissipated += law.lost(scene, point, remaining, before);
            }
        }
    });
}
