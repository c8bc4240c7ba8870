//! The linear peridynamic solid on a body that is a lattice: dilatations, then tensions, of eight points at once.

use super::on_lattice::{LatticeState, OnLattice, Parts, masks_as_they_are};
use super::ordinary_state_based::Lps;
use super::passes::ForceSweep;
use super::{Scene, extension_lanes, in_lanes};
use crate::families::LANES;
use crate::families::lattice::Lattice;
use crate::kernel::lattice::{Breaks, DilationSweep, Moduli, TensionSweep};

impl Lps {
    pub(super) fn forces_on_lattice<const D: usize>(
        &self,
        (lattice, state): (&Lattice, &LatticeState),
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        let ForceSweep { scene, force, breaking, look: calm, .. } = sweep;
        let rest = |first, rings| calm.is_some_and(|calm| calm.rest_around_seats(first, rings));
        let omega = in_lanes::omega(scene, &self.weights)?;
        let on = OnLattice::breaking(scene, (lattice, state), breaking.as_ref());
        let [kappa, deviatoric] = *self.moduli.at(0);
        let moduli = Moduli { kappa, deviatoric };
        let influence = |length: f64| omega.at(length);
        let first = |parts: &mut Parts<'_, D, 2>| {
            let (groups, look, judge) = (parts.groups, parts.look, on.limits);
            let outputs = (parts.left.again(), parts.masks.again(), parts.broke.again());
            scene.workers.sweep(parts.seats, outputs, |range, (left, masks, broke)| {
                if rest(range.start, extension_lanes::RINGS + 1) {
                    return;
                }
                let breaks = Breaks { masks: masks.0, broke: broke.0, judge, look };
                let range = range.start / LANES..range.end / LANES;
                let (first, left) = (left.first, left.values);
                scene.simd.run(DilationSweep { groups, moduli, range, first, left, breaks });
            });
        };
        let second = |parts: Parts<'_, D, 2>, _: &Scene<'_>| {
            let Parts { groups, seats, unit, masks, forces, left, .. } = parts;
            let left = left.values.map(|column| &*column);
            scene.workers.sweep(seats, (forces, masks), |range, (force, masks)| {
                if rest(range.start, extension_lanes::RINGS) {
                    return force.0.fill(0.0);
                }
                let range = range.start / LANES..range.end / LANES;
                let (force, masks) = (force.0, &*masks.0);
                scene.simd.run(TensionSweep { groups, left, range, masks, force });
            });
            unit.recip()
        };
        let remaining = masks_as_they_are(scene, breaking);
        let bad = on.sweep(scene, influence, first, second, force, remaining);
        (bad != usize::MAX).then_some(bad)
    }
}
