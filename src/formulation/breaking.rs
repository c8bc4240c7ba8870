//! Which bonds a rule breaks at a displacement, for formulations that look at bonds before they pull.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Scene;
use crate::damage::Breaking;
use crate::families::LANES;
use crate::workers::Ragged;

/// Breaks in the masks aside what is stretched beyond its limit; whether there was any.
pub(super) fn break_stretched(scene: &Scene<'_>, breaking: &mut Breaking<'_>) -> bool {
    let Breaking { rule, intact, .. } = breaking;
    let masks = Ragged { values: intact, offsets: &scene.families.offsets, width: 1 };
    let broke = AtomicBool::new(false);
    let dimension = scene.dimension;
    scene.workers.sweep(scene.places.len(), masks, |range, masks| {
        let first = scene.families.offsets[range.start] as usize;
        let last = scene.families.offsets[range.end] as usize;
        masks.values.copy_from_slice(&scene.bonds.intact[first..last]);
        for point in range {
            for bond in scene.families.bonds(point) {
                let (block, bit) = (bond.slot / LANES, 1_u8 << (bond.slot % LANES));
                if masks.values[block - first] & bit & rule.breakable(block) == 0 {
                    continue;
                }
                let stretch = stretch(scene, dimension, point, bond.neighbor, bond.length);
                if stretch > rule.threshold(bond.slot, point, bond.neighbor) {
                    masks.values[block - first] &= !bit;
                    broke.store(true, Ordering::Relaxed);
                }
            }
        }
    });
    broke.into_inner()
}

/// Stretch of a bond; the same bits from both ends.
fn stretch(scene: &Scene<'_>, dimension: usize, from: usize, to: usize, length: f64) -> f64 {
    let (mut squared, mut change) = (0.0, 0.0);
    for axis in 0..dimension {
        let reference = scene.places[to][axis] - scene.places[from][axis];
        let moved =
            scene.displacement[to * dimension + axis] - scene.displacement[from * dimension + axis];
        let now = reference + moved;
        squared += now * now;
        change += moved * (reference + now);
    }
    change / (length * (length + squared.sqrt()))
}
