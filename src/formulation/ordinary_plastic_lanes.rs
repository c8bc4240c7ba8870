//! The linear peridynamic solid that flows, in lanes: its records, and the forces and energies they give.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::body::Body;
use super::breaking::Near;
use super::in_lanes;
use super::ordinary_plastic::{PlasticLps, Records, State, records_mut, strain_of};
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::{Asked, EnergyPart, Kinematics, Scene};
use crate::families::LANES;
use crate::kernel::family::Family;
use crate::kernel::fields::{BondSums, ByLanes, FieldSums};
use crate::kernel::ordinary_plastic::{PullAlong, Return, Sums};
use crate::workers::{PerPoint, Ragged};

/// Numbers of the tables.
pub(super) fn room(points: usize, blocks: usize) -> usize {
    in_lanes::room_of_records(points) + blocks * LANES
}

/// What a sweep that makes records leaves besides.
struct Leaves<'a> {
    /// |t_ij|/L of each lane.
    pulls: Option<&'a mut [f64]>,
    density: Option<(&'a mut [f64], EnergyPart)>,
}

impl PlasticLps {
    /// Makes the records of a displacement from the committed ones, near broken bonds only if `near` says so.
    fn return_in_lanes<const D: usize>(
        &self,
        scene: &Scene<'_>,
        family: Family<'_>,
        near: Option<&Near<'_>>,
        records: &mut [f64],
        leaves: Leaves<'_>,
    ) {
        let (blocks, offsets) = (scene.families.block_count(), &scene.families.offsets);
        let old = Records::new(scene.bonds.records, blocks);
        let (bonds, points) = records_mut(records, blocks);
        let Leaves { pulls, density } = leaves;
        let (density, part) = density.unzip();
        let outputs = (
            Ragged { values: bonds, offsets, width: 1 },
            PerPoint(points, 1),
            pulls.map(|values| Ragged { values, offsets, width: LANES }),
            density.map(|density| PerPoint(density, 1)),
        );
        let wanted = |point| near.is_none_or(|near| near.wants_energy(point));
        scene.workers.sweep(scene.places.len(), outputs, |range, outputs| {
            let (bonds, states, pulls, mut density) = outputs;
            let first = range.start;
            states.0.copy_from_slice(&old.points[range.clone()]);
            let yielding = |point: usize, inverse: f64| self.yielding(scene, point, inverse);
            let finish = |point: usize, sums: Sums, flowed: Option<[f64; 2]>| {
                let Sums { inverse, theta, squares } = sums;
                let state: &mut State = &mut states.0[point - first];
                let [_, _, dissipated, strain] = *state;
                let yielding = yielding(point, inverse);
                let [more, further] = flowed.map_or([0.0; 2], |flowed| yielding.flowed(flowed));
                *state = [inverse, theta, dissipated + more, strain + further];
                if let Some(density) = &mut density {
                    density.0[point - first] = match part {
                        Some(EnergyPart::Plastic) => state[2],
                        _ => self.held(point, state, squares),
                    };
                }
            };
            scene.simd.run(Return::<_, _, _, _, D> {
                family,
                range,
                wanted,
                old: old.bonds,
                new: bonds.values,
                pulls: pulls.map(|pulls| pulls.values),
                moduli: |point: usize| {
                    let [kappa, stiffness] = self.moduli(point);
                    [D as f64 * kappa, stiffness]
                },
                left: |point: usize, sums: Sums| yielding(point, sums.inverse).left(sums.squares),
                finish,
            });
        });
    }

    pub(super) fn swept_forces<const D: usize>(&self, sweep: ForceSweep<'_, '_>) -> Option<usize> {
        let ForceSweep { scene, room, force, .. } = sweep;
        let omega = in_lanes::omega(scene, self.weights())?;
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let pulls = &mut rest[..scene.families.block_count() * LANES];
        let family = in_lanes::family(scene, records, omega);
        let leaves = Leaves { pulls: Some(&mut *pulls), density: None };
        self.return_in_lanes::<D>(scene, family, None, room.records, leaves);
        let (pulls, backs, bad) = (&*pulls, &self.backs[..], AtomicUsize::new(usize::MAX));
        scene.workers.sweep(scene.places.len(), PerPoint(force, D), |range, force| {
            let sweep = PullAlong::<D> { family, range, pulls, backs, force: force.0 };
            if let Some(point) = scene.simd.run(sweep) {
                bad.fetch_min(point, Ordering::Relaxed);
            }
        });
        in_lanes::first(bad)
    }

    pub(super) fn swept_energy<const D: usize>(&self, sweep: EnergySweep<'_>) -> bool {
        let EnergySweep { scene, room, density, part, near } = sweep;
        let Some(omega) = in_lanes::omega(scene, self.weights()) else { return false };
        let (records, _) = in_lanes::record::<D>(scene, room.tables);
        let family = in_lanes::family(scene, records, omega);
        density.fill(0.0);
        let leaves = Leaves { pulls: None, density: Some((density, part)) };
        self.return_in_lanes::<D>(scene, family, near, room.records, leaves);
        true
    }

    pub(super) fn swept_fields<const D: usize>(&self, sweep: FieldSweep<'_>) -> bool {
        let FieldSweep { scene, room, values, width, read } = sweep;
        let Some(omega) = in_lanes::omega(scene, self.weights()) else { return false };
        let (records, rest) = in_lanes::record::<D>(scene, room.tables);
        let pulls = &mut rest[..scene.families.block_count() * LANES];
        let family = in_lanes::family(scene, records, omega);
        let leaves = Leaves { pulls: Some(&mut *pulls), density: None };
        self.return_in_lanes::<D>(scene, family, None, room.records, leaves);
        let made = Records::new(room.records, scene.families.block_count());
        let pull = ByLanes { pulls, backs: &self.backs, extensions: made.bonds };
        let asked = Some(Asked { records: room.records, dissipated: false });
        let asked = &Scene { asked, ..*scene };
        let body = &Body::<D>::new(asked, self.weights());
        scene.workers.sweep(scene.places.len(), PerPoint(values, width), |range, values| {
            let first = range.start;
            let finish = |point: usize, sums: &BondSums<f64, D>| {
                let state = &made.points[point];
                let [_, dilatation, _, equivalent] = *state;
                let even = Kinematics::of_sums(sums, self.law(point)).map(|of| {
                    let plastic = (strain_of(&sums.flowed, state), equivalent);
                    Kinematics { dilatation, ..of }.with_plastic(plastic)
                });
                let made = even.unwrap_or_else(|| self.kinematics_at(body, point, &[]));
                read(&made, &mut values.0[(point - first) * width..][..width]);
            };
            scene.simd.run(FieldSums::<_, _, D> { family, pull, range, finish });
        });
        true
    }
}
