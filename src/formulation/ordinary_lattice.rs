//! The linear peridynamic solid on a body that is a lattice: dilatations, then tensions, of eight points at once.

use std::ops::Range;

use super::on_lattice::{Columns, LatticeState, OnLattice, Parts, by_state};
use super::ordinary_state_based::Lps;
use super::passes::ForceSweep;
use super::{Scene, in_lanes};
use crate::families::LANES;
use crate::families::lattice::Lattice;
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
        let ForceSweep { scene, force, breaking, resting, .. } = sweep;
        let omega = in_lanes::omega(scene, &self.weights)?;
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
            let Parts { groups, seats, unit, masks, forces, left, .. } = parts;
            let left = left.values.map(|column| &*column);
            on.pull(scene, seats, (forces, masks), |range, force, masks| {
                scene.simd.run(TensionSweep { groups, left, range, masks, force });
            });
            unit.recip()
        };
        let bad = on.sweep(scene, influence, first, second, force, breaking);
        (bad != usize::MAX).then_some(bad)
    }
}
