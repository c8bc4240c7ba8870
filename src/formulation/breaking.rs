//! Which bonds a rule breaks at a displacement, and what that dissipates, for formulations that look at bonds
//! before they pull.
//!
//! Bonds that break between displacements u_n and u_n+1 pulled last at u_n. With Q(u) what the body holds more
//! with them than without, the motion has been paid by half the pull that they had at u_n, and so
//! Q(u_n) + 1/2 dQ/du (u_n+1 - u_n) is lost. To second order that is 2 Q(u_n+1/2) - (Q(u_n) + Q(u_n+1))/2,
//! which each point can say of its own energy.

use super::calm::Resting;
use super::in_lanes::{HowTheyBreak, Which};
use super::{EnergyPart, Scene, in_lanes};
use crate::damage::{self, BondsView, Breaking};
use crate::kernel::family::{BreakSweep, Omega};
use crate::workers::PerPoint;

/// Breaks in the masks aside what is stretched beyond its limit; whether there was any. Needs [`room`].
pub(super) fn break_stretched(
    (scene, resting): (&Scene<'_>, Resting<'_>),
    room: &mut [f64],
    breaking: &mut Breaking<'_>,
) -> bool {
    match scene.dimension {
        3 => sweep_stretches::<3>((scene, resting), room, breaking),
        _ => sweep_stretches::<2>((scene, resting), room, breaking),
    }
    breaking.has_broken()
}

fn sweep_stretches<const D: usize>(
    (scene, resting): (&Scene<'_>, Resting<'_>),
    room: &mut [f64],
    breaking: &mut Breaking<'_>,
) {
    let (records, _) = in_lanes::record::<D>(scene, room);
    let family = in_lanes::family(scene, records, Omega::EVEN);
    let (masks, how) = HowTheyBreak::of(scene, breaking, resting);
    in_lanes::sweep(scene, family, Which::All, masks, |family, range, masks| {
        if let Some(breaking) = how.here(range.start, masks) {
            scene.simd.run(BreakSweep::<D> { family, range, breaking });
        }
    });
}

/// Numbers that breaking and booking write aside.
pub(super) fn room(points: usize, dimension: usize) -> usize {
    room_of_booking(points, dimension).max(in_lanes::room_of_records(points))
}

/// Those of booking alone.
pub(super) fn room_of_booking(points: usize, dimension: usize) -> usize {
    points * (3 + dimension)
}

/// Points that broken bonds are near to.
pub(super) struct Near<'a> {
    marks: &'a [f64],
}

const PASS: f64 = 1.0;
const ENERGY: f64 = 2.0;

impl Near<'_> {
    /// Whether the energy of a point may have changed.
    pub(super) fn wants_energy(&self, point: usize) -> bool {
        self.marks[point] >= ENERGY
    }

    /// Whether such an energy may need what a first pass leaves of a point.
    pub(super) fn wants_pass(&self, point: usize) -> bool {
        self.marks[point] >= PASS
    }
}

/// Adds what points lose by the bonds that have broken to `breaking.dissipated`. `energy` gives a part of the energy
/// per volume of the points near them, false where there is none; with `needs_pass` it depends on what a first pass leaves of neighbours.
pub(super) fn book(
    scene: &Scene<'_>,
    breaking: &mut Breaking<'_>,
    scratch: &mut [f64],
    needs_pass: bool,
    mut energy: impl FnMut(&Scene<'_>, &Near<'_>, EnergyPart, &mut [f64]) -> bool,
) {
    let count = scene.places.len();
    let (density, rest) = scratch.split_at_mut(count);
    let (marks, rest) = rest.split_at_mut(count);
    let (aside, rest) = rest.split_at_mut(count);
    let midway = &mut rest[..scene.displacement.len()];
    let broken = BondsView { intact: breaking.intact, edition: breaking.edition, ..scene.bonds };
    scene.workers.sweep(count, PerPoint(&mut *marks, 1), |range, marks| {
        for (mark, point) in marks.0.iter_mut().zip(range) {
            let blocks = scene.families.blocks(point);
            let changed = scene.bonds.intact[blocks.clone()] != broken.intact[blocks];
            *mark = if changed { ENERGY } else { 0.0 };
        }
    });
    if needs_pass {
        spread(scene, marks, aside, ENERGY);
        spread(scene, aside, marks, PASS);
    }
    let near = Near { marks };
    let mut add = |displacement: &[f64], factor: f64| {
        for (sign, bonds) in [(factor, scene.bonds), (-factor, broken)] {
            let scene = Scene { bonds, displacement, ..*scene };
            for part in [EnergyPart::Strain, EnergyPart::Stabilization, EnergyPart::Plastic] {
                if !energy(&scene, &near, part, density) {
                    continue;
                }
                for (dissipated, density) in breaking.dissipated.iter_mut().zip(&*density) {
                    *dissipated += sign * density;
                }
            }
        }
    };
    let Some(before) = breaking.before else { return add(scene.displacement, 1.0) };
    for ((midway, before), now) in midway.iter_mut().zip(before).zip(scene.displacement) {
        *midway = 0.5 * (before + now);
    }
    add(midway, 2.0);
    add(before, -0.5);
    add(scene.displacement, -0.5);
}

/// Marks the neighbours of points that have mark [`ENERGY`].
fn spread(scene: &Scene<'_>, marks: &[f64], wider: &mut [f64], mark: f64) {
    scene.workers.sweep(scene.places.len(), PerPoint(wider, 1), |range, wider| {
        for (value, point) in wider.0.iter_mut().zip(range) {
            let mut neighbors = scene.families.bonds(point);
            *value =
                if marks[point] < ENERGY && neighbors.any(|bond| marks[bond.neighbor] >= ENERGY) {
                    mark
                } else {
                    marks[point]
                };
        }
    });
}

/// Stretch of a bond; the same bits from both ends.
pub(super) fn stretch(scene: &Scene<'_>, from: usize, to: usize, length: f64) -> f64 {
    let dimension = scene.dimension;
    let axes = (0..dimension).map(|axis| {
        let of = |point: usize| scene.displacement[point * dimension + axis];
        [scene.places[to][axis] - scene.places[from][axis], of(to) - of(from)]
    });
    damage::stretch(length, axes)
}
