//! The sweeps of bond_based for forces: groups of a lattice where there is one, blocks of bonds elsewhere.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::Scene;
use super::bond_lattice::OnLattice;
use super::bond_laws::Various;
use crate::damage::Breaking;
use crate::kernel::bond_based::{BondLaw, Cloud, ForceSweep, Record};
use crate::workers::{PerPoint, Ragged};

/// Forces per volume on all points; with `remaining`, bonds beyond their limit break first, and the masks without them
/// are left there. Gives the first point whose force is not finite.
pub(super) fn sweep<const D: usize>(
    scene: &Scene<'_>,
    law: impl BondLaw,
    lattice: Option<OnLattice<'_>>,
    scratch: &mut [f64],
    force: &mut [f64],
    mut remaining: Option<&mut [u8]>,
) -> Option<usize> {
    let count = scene.places.len();
    let mut first = usize::MAX;
    if lattice.as_ref().is_none_or(|on| on.lattice.count < count) {
        let masks = remaining.as_deref_mut();
        let steps = lattice.is_none() && scene.families.lattice.is_some();
        first = first.min(match scene.families.inverse_lengths {
            _ if steps => sweep_cloud::<true, true, D>(scene, law, scratch, force, masks),
            Some(_) => sweep_cloud::<false, false, D>(scene, law, scratch, force, masks),
            None => sweep_cloud::<true, false, D>(scene, law, scratch, force, masks),
        });
    }
    if let Some(on) = lattice {
        first = first.min(on.sweep::<D>(scene, force, remaining));
    }
    (first != usize::MAX).then_some(first)
}

/// As [`sweep`], of the points that are no members of a lattice, and with `STEPS` of all; `LEAN`: lengths are computed.
/// Gives a number beyond all points where all is finite.
fn sweep_cloud<const LEAN: bool, const STEPS: bool, const D: usize>(
    scene: &Scene<'_>,
    law: impl BondLaw,
    scratch: &mut [f64],
    force: &mut [f64],
    remaining: Option<&mut [u8]>,
) -> usize {
    let count = scene.places.len();
    let records = records_of::<LEAN, D>(scene, scratch);
    let (intact, offsets) = (scene.bonds.intact, &scene.families.offsets);
    let cloud = Cloud::new(scene.families, records, intact);
    let bad = AtomicUsize::new(usize::MAX);
    let remaining = remaining.map(|values| Ragged { values, offsets, width: 1 });
    scene.workers.sweep(count, (PerPoint(force, D), remaining), |range, (force, remaining)| {
        let remaining = remaining.map(|masks| masks.values);
        let force = force.0;
        let sweep = ForceSweep::<_, LEAN, STEPS, D> { cloud, law, range, force, remaining };
        if let Some(point) = scene.simd.run(sweep) {
            bad.fetch_min(point, Ordering::Relaxed);
        }
    });
    bad.into_inner()
}

/// Numbers beyond those of the records that let the first of them begin a line of the cache.
pub(super) const SLACK: usize = 7;

/// A record of each point, in the scratch.
fn records_of<'a, const LEAN: bool, const D: usize>(
    scene: &Scene<'_>,
    scratch: &'a mut [f64],
) -> &'a [Record] {
    let count = scene.places.len();
    let ahead = scratch.as_ptr().align_offset(64).min(SLACK);
    let (records, _) = scratch[ahead..].as_chunks_mut();
    let records = &mut records[..count];
    let (shifts, _) = scene.displacement.as_chunks::<D>();
    scene.workers.sweep(count, PerPoint(&mut *records, 1), |range, records| {
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
