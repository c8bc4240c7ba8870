//! Formulations whose bonds pull along themselves, in lanes: w (a s + b) L from each end, with a and b of points.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::body::{Body, ByModel, Link, Weights};
use super::calm::Resting;
use super::in_lanes::{HowTheyBreak, Which};
use super::ordinary_state_based::extension;
use super::passes::{EnergySweep, FieldSweep, ForceSweep};
use super::{Kinematics, Scene, in_lanes};
use crate::damage::Breaking;
use crate::kernel::family::{Family, Record, Table};
use crate::kernel::fields::{ByPoints, FieldSums};
use crate::kernel::ordinary_state_based::{Extensions, OtherPull, OwnPull};
use crate::material::Law;
use crate::workers::PerPoint;

/// A force comes from the families of the point and of its neighbours.
pub(super) const RINGS: u8 = 2;

/// Numbers of the tables.
pub(super) fn room(points: usize) -> usize {
    2 * in_lanes::room_of_records(points)
}

/// Forces of a scene that can be swept in lanes; `pulls`: a and b of a point, from its sums.
pub(super) fn forces<const D: usize, const PER_LENGTH: bool>(
    sweep: ForceSweep<'_, '_>,
    weights: &Weights,
    pulls: impl Fn(usize, [f64; 2]) -> [f64; 2] + Sync,
) -> Option<usize> {
    let ForceSweep { scene, room, force, breaking, resting } = sweep;
    let omega = in_lanes::omega(scene, weights)?;
    let (records, rest) = in_lanes::record::<D>(scene, room.tables);
    let (left, _) = in_lanes::table(rest, scene.places.len());
    let family = in_lanes::family(scene, records, omega);
    let outputs = (&mut *force, &mut *left);
    own_pulls::<D, PER_LENGTH>((scene, resting), family, outputs, breaking, pulls);
    let scene = &in_lanes::remaining(scene, breaking);
    let family = in_lanes::family(scene, left, omega);
    other_pulls::<D, PER_LENGTH>((scene, resting), family, force)
}

/// The first sweep of listed bonds: forces, and records with a V and b V.
pub(super) fn own_pulls<const D: usize, const PER_LENGTH: bool>(
    (scene, resting): (&Scene<'_>, Resting<'_>),
    family: Family<'_>,
    (force, left): (&mut [f64], &mut [Record]),
    breaking: &mut Option<Breaking<'_>>,
    pulls: impl Fn(usize, [f64; 2]) -> [f64; 2] + Sync,
) {
    let (masks, how) = HowTheyBreak::if_any(scene, breaking, resting);
    let outputs = (PerPoint(force, D), PerPoint(left, 1), masks);
    in_lanes::sweep(
        scene,
        family,
        Which::Listed,
        outputs,
        |family, range, (force, left, masks)| {
            let breaking = masks.zip(how).and_then(|(masks, how)| how.here(range.start, masks));
            if resting.block(range.start, 1) {
                return;
            }
            let (force, left, pulls) = (force.0, left.0, &pulls);
            let sweep = OwnPull::<_, D, PER_LENGTH> { family, pulls, range, force, left, breaking };
            scene.simd.run(sweep);
        },
    );
}

/// The second, with the records that are left. Gives the first point whose force is not finite.
pub(super) fn other_pulls<const D: usize, const PER_LENGTH: bool>(
    (scene, resting): (&Scene<'_>, Resting<'_>),
    family: Family<'_>,
    force: &mut [f64],
) -> Option<usize> {
    let bad = AtomicUsize::new(usize::MAX);
    in_lanes::sweep(scene, family, Which::Listed, PerPoint(force, D), |family, range, force| {
        if resting.block(range.start, 0) {
            return force.0.fill(0.0);
        }
        let sweep = OtherPull::<D, PER_LENGTH> { family, range, force: force.0 };
        if let Some(point) = scene.simd.run(sweep) {
            bad.fetch_min(point, Ordering::Relaxed);
        }
    });
    in_lanes::first(bad)
}

/// Energies of such a scene; `energy`: that of a point, from its sums and sum w e^2 V.
pub(super) fn energies<const D: usize, const PER_LENGTH: bool>(
    sweep: EnergySweep<'_>,
    weights: &Weights,
    energy: impl Fn(usize, [f64; 2], f64) -> f64 + Sync,
) -> bool {
    let EnergySweep { scene, room, density, near, .. } = sweep;
    let Some(omega) = in_lanes::omega(scene, weights) else { return false };
    let (records, _) = in_lanes::record::<D>(scene, room.tables);
    let family = in_lanes::family(scene, records, omega);
    let wanted = |point| near.is_none_or(|near| near.wants_energy(point));
    density.fill(0.0);
    in_lanes::sweep(scene, family, Which::All, PerPoint(density, 1), |family, range, density| {
        let first = range.start;
        let finish = |point: usize, sums: [f64; 2], squares: f64| {
            density.0[point - first] = energy(point, sums, squares);
        };
        scene.simd.run(Extensions::<_, _, D, PER_LENGTH> { family, range, wanted, finish });
    });
    true
}

/// Where a row of the table of points has the dilatation, behind a and b.
const DILATATION: usize = 2;

/// Deformation and stress of such a scene; `pulls`: a, b and the dilatation of a point, from its sums.
pub(super) fn fields<const D: usize, const PER_LENGTH: bool>(
    sweep: FieldSweep<'_>,
    weights: &Weights,
    laws: &ByModel<Law>,
    pulls: impl Fn(usize, [f64; 2]) -> [f64; 3] + Sync,
) -> bool {
    let FieldSweep { scene, room, values, width, read } = sweep;
    let Some(omega) = in_lanes::omega(scene, weights) else { return false };
    let count = scene.places.len();
    let (records, rest) = in_lanes::record::<D>(scene, room.tables);
    let (rows, _) = in_lanes::table::<4>(rest, count);
    let family = in_lanes::family(scene, records, omega);
    in_lanes::sweep(scene, family, Which::All, PerPoint(&mut *rows, 1), |family, range, rows| {
        let first = range.start;
        let finish = |point: usize, sums: [f64; 2], _| {
            let [a, b, dilatation] = pulls(point, sums);
            rows.0[point - first] = [a, b, dilatation, 0.0];
        };
        let wanted = |_| true;
        scene.simd.run(Extensions::<_, _, D, PER_LENGTH> { family, range, wanted, finish });
    });
    let (rows, body) = (&*rows, &Body::<D>::new(scene, weights));
    // |t_ij| + |t_ji| of a bond, and its deformed length.
    let tension = |point: usize, link: &Link<D>| {
        let (extension, now) = extension(link);
        let pull = |point: usize| {
            let [a, b, ..] = rows[point];
            a * extension + if PER_LENGTH { b } else { b * link.length }
        };
        (link.own * pull(point) + link.other * pull(link.neighbor), now)
    };
    let pull = ByPoints::<PER_LENGTH>(Table::new(&family, rows));
    in_lanes::sweep(scene, family, Which::All, PerPoint(values, width), |family, range, values| {
        let first = range.start;
        let finish = |point: usize, sums: &_| {
            let law = laws.at(point);
            let made = Kinematics::of_sums(sums, law).unwrap_or_else(|| {
                Kinematics::of_bonds(body, point, law, |link| tension(point, link))
            });
            let made = Kinematics { dilatation: rows[point][DILATATION], ..made };
            read(&made, &mut values.0[(point - first) * width..][..width]);
        };
        scene.simd.run(FieldSums::<_, _, D> { family, pull, range, finish });
    });
    true
}
