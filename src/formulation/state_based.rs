//! What all state-based formulations share: two passes over the families, of which the first leaves a few
//! numbers a point for the second, and the breaking of bonds before them.
//!
//! Between the passes only these numbers are exchanged: the seam for ranks.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::body::{Body, Weights};
pub(super) use super::breaking::Near;
use super::laws::Laws;
use super::{
    Asked, EnergyPart, Formulation, Kinematics, Materials, Read, Scene, breaking, surface,
};
use crate::damage::Breaking;
use crate::error::Result;
use crate::families::{LANES, Property};
use crate::material::Deformation;
use crate::model::Plane;
use crate::tensor::Vector;
use crate::workers::{PerPoint, Ragged};

/// The passes of a formulation.
pub(super) trait Passes: Sized + Send + Sync {
    fn weights(&self) -> &Weights;

    /// lambda/2 + mu of a point, where the surface is to be corrected.
    fn corrected_modulus(&self, _point: usize) -> Option<f64> {
        None
    }

    /// Takes the factors of the surface.
    fn correct(&mut self, _factors: Vec<f64>) {}

    /// Its laws, where it asks any.
    fn laws(&self) -> Option<&Laws> {
        None
    }

    /// The deformations at which the law of a point is asked, and the site of each. `left`: what the first pass has
    /// left of all points, where there is a pass between.
    fn each_site<const D: usize>(
        &self,
        _body: &Body<'_, D>,
        _point: usize,
        _left: &[f64],
        _ask: &mut dyn FnMut(usize, &Deformation<D>),
    ) {
    }

    /// Numbers of records that it keeps from step to step, those of its laws.
    fn records(&self, points: usize, blocks: usize) -> usize {
        self.laws().map_or(0, |laws| laws.records(points, blocks))
    }

    /// Makes the records of a displacement from the committed ones, near broken bonds only if `near` says so.
    fn ask<const D: usize>(
        &self,
        body: &Body<'_, D>,
        left: &[f64],
        near: Option<&Near<'_>>,
        records: &mut [f64],
    ) {
        if let Some(laws) = self.laws() {
            laws.ask(body, self, left, near, records);
        }
    }

    /// Numbers a point that the first pass leaves for the second.
    fn width(&self, dimension: usize) -> usize;

    /// The first pass at a point; false where what it leaves is not to be used.
    fn prepare_point<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &mut [f64],
    ) -> bool;

    /// A pass between the first and the last, which may read what the first has left of all points and
    /// changes that of its own; false where there is none.
    fn has_second(&self) -> bool {
        false
    }

    /// What the pass between makes of a point.
    fn second_at<const D: usize>(
        &self,
        _body: &Body<'_, D>,
        _point: usize,
        _scratch: &[f64],
        _result: &mut [f64],
    ) {
    }

    /// Numbers a bond that a first pass leaves, in place of numbers a point; 0 where it leaves none.
    fn lane_width(&self, _dimension: usize) -> usize {
        0
    }

    /// The first pass at a point for its bonds' lanes; false where what it leaves is not to be used.
    fn prepare_lanes<const D: usize>(
        &self,
        _body: &Body<'_, D>,
        _point: usize,
        _lanes: &mut [f64],
    ) -> bool {
        true
    }

    /// Force per volume on a point, from what the first pass has left of all lanes.
    fn force_from_lanes<const D: usize>(
        &self,
        _body: &Body<'_, D>,
        _point: usize,
        _lanes: &[f64],
    ) -> Vector<D> {
        [0.0; D]
    }

    /// Force per volume on a point, from what the passes have left of all points.
    fn force_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Vector<D>;

    /// Whether energies need what the first pass leaves.
    fn energy_needs_pass(&self) -> bool {
        false
    }

    /// Strain energy per volume of a point; `scratch`: what the first pass has left of all points, where
    /// energies need it.
    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, scratch: &[f64]) -> f64;

    /// Whether there is a penalty on modes that the material does not see.
    fn has_penalty(&self) -> bool {
        false
    }

    /// Energy per volume of that penalty.
    fn stabilisation_at<const D: usize>(&self, _body: &Body<'_, D>, _point: usize) -> f64 {
        0.0
    }

    /// Whether a point's family does not span the body, or does not bear the order of gradient asked for: what
    /// is done then says `gradient`.
    fn is_degenerate<const D: usize>(&self, _body: &Body<'_, D>, _point: usize) -> bool {
        false
    }

    /// Deformation and stress of a point; `scratch`: what the first pass has left of all points.
    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Kinematics;

    fn bytes(&self) -> usize;
}

/// A formulation in passes, made ready for a body.
pub(super) struct StateBased<P> {
    passes: P,
    /// C_b of [P 3.58].
    bond_constants: Property,
}

impl<P: Passes> StateBased<P> {
    pub(super) fn new(materials: &Materials<'_>, passes: P) -> Result<Self> {
        let bond_constants = materials.property(
            |model, horizon| {
                let thickness = model.number("thickness").unwrap_or(1.0);
                let elastic = model.elastic()?;
                Ok(match (materials.dimension, model.plane()) {
                    (3, _) => 18.0 * elastic.bulk_modulus / (PI * horizon.powi(4)),
                    (_, Plane::Stress) => {
                        9.0 * elastic.youngs_modulus / (PI * thickness * horizon.powi(3))
                    }
                    (_, Plane::Strain) => {
                        48.0 * elastic.youngs_modulus / (5.0 * PI * thickness * horizon.powi(3))
                    }
                })
            },
            "bond constants",
        )?;
        Ok(Self { passes, bond_constants })
    }

    fn passes<const D: usize>(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        force: &mut [f64],
    ) -> Option<usize> {
        let (passes, count) = (&self.passes, scene.places.len());
        let (records, scratch) = scratch.split_at_mut(self.records_of(scene));
        let body = Body::<D>::new(scene, passes.weights());
        let width = passes.width(D);
        let (first, second) = scratch.split_at_mut(count * width);
        let mut bad = AtomicUsize::new(usize::MAX);
        if passes.has_second() {
            bad = self.first_pass(&body, first, None);
        }
        let scene = self.asked(&body, first, None, records, false);
        let scene = &scene;
        let body = Body::<D>::new(scene, passes.weights());
        if passes.lane_width(D) > 0 {
            return self.passes_over_lanes(&body, second, force);
        }
        if !passes.has_second() {
            bad = self.first_pass(&body, first, None);
        }
        let left = if passes.has_second() {
            let first = &*first;
            scene.workers.sweep(count, PerPoint(&mut *second, width), |range, result| {
                for (place, point) in range.enumerate() {
                    let own = &mut result.0[place * width..(place + 1) * width];
                    passes.second_at(&body, point, first, own);
                }
            });
            &*second
        } else {
            &*first
        };
        // A point whose own material fails is to be named, not one that it pulls on.
        let found = bad.load(Ordering::Relaxed);
        if found != usize::MAX {
            return Some(found);
        }
        scene.workers.sweep(count, PerPoint(force, D), |range, force| {
            let (forces, _) = force.0.as_chunks_mut::<D>();
            for (force, point) in forces.iter_mut().zip(range) {
                *force = passes.force_at(&body, point, left);
                if !force.iter().all(|component| component.is_finite()) {
                    bad.fetch_min(point, Ordering::Relaxed);
                }
            }
        });
        let found = bad.into_inner();
        (found != usize::MAX).then_some(found)
    }

    fn passes_over_lanes<const D: usize>(
        &self,
        body: &Body<'_, D>,
        scratch: &mut [f64],
        force: &mut [f64],
    ) -> Option<usize> {
        let (passes, scene) = (&self.passes, body.scene);
        let (count, offsets) = (scene.places.len(), &scene.families.offsets);
        let width = LANES * passes.lane_width(D);
        let lanes = &mut scratch[..scene.families.block_count() * width];
        let bad = AtomicUsize::new(usize::MAX);
        let left = Ragged { values: &mut *lanes, offsets, width };
        scene.workers.sweep(count, left, |range, left| {
            let first = offsets[range.start] as usize;
            for point in range {
                let blocks = scene.families.blocks(point);
                let own = (blocks.start - first) * width..(blocks.end - first) * width;
                if !passes.prepare_lanes(body, point, &mut left.values[own]) {
                    bad.fetch_min(point, Ordering::Relaxed);
                }
            }
        });
        let found = bad.load(Ordering::Relaxed);
        if found != usize::MAX {
            return Some(found);
        }
        let lanes = &*lanes;
        scene.workers.sweep(count, PerPoint(force, D), |range, force| {
            let (forces, _) = force.0.as_chunks_mut::<D>();
            for (force, point) in forces.iter_mut().zip(range) {
                *force = passes.force_from_lanes(body, point, lanes);
                if !force.iter().all(|component| component.is_finite()) {
                    bad.fetch_min(point, Ordering::Relaxed);
                }
            }
        });
        let found = bad.into_inner();
        (found != usize::MAX).then_some(found)
    }

    /// Whether there is such an energy at all.
    fn has(&self, part: EnergyPart, scene: &Scene<'_>) -> bool {
        match part {
            EnergyPart::Strain => true,
            EnergyPart::Stabilization => self.passes.has_penalty(),
            EnergyPart::Plastic => self.records_of(scene) > 0,
        }
    }

    fn records_of(&self, scene: &Scene<'_>) -> usize {
        self.passes.records(scene.places.len(), scene.families.block_count())
    }

    /// The scene with the answers of laws that have a memory.
    fn asked<'a, const D: usize>(
        &self,
        body: &Body<'a, D>,
        left: &[f64],
        near: Option<&Near<'_>>,
        records: &'a mut [f64],
        dissipated: bool,
    ) -> Scene<'a> {
        if records.is_empty() {
            return *body.scene;
        }
        self.passes.ask(body, left, near, records);
        Scene { asked: Some(Asked { records, dissipated }), ..*body.scene }
    }

    /// Runs the first pass, of all points or those that `near` wants; gives the first point where what it
    /// leaves is not to be used.
    fn first_pass<const D: usize>(
        &self,
        body: &Body<'_, D>,
        left: &mut [f64],
        near: Option<&Near<'_>>,
    ) -> AtomicUsize {
        let (passes, width) = (&self.passes, self.passes.width(D));
        let bad = AtomicUsize::new(usize::MAX);
        let count = body.scene.places.len();
        body.scene.workers.sweep(count, PerPoint(left, width), |range, left| {
            for (place, point) in range.enumerate() {
                if near.is_some_and(|near| !near.wants_pass(point)) {
                    continue;
                }
                let own = &mut left.0[place * width..(place + 1) * width];
                if !passes.prepare_point(body, point, own) {
                    bad.fetch_min(point, Ordering::Relaxed);
                }
            }
        });
        bad
    }

    fn energies<const D: usize>(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        density: &mut [f64],
        part: EnergyPart,
        near: Option<&Near<'_>>,
    ) {
        let (records, scratch) = scratch.split_at_mut(self.records_of(scene));
        let body = Body::<D>::new(scene, self.passes.weights());
        let left = &mut scratch[..scene.places.len() * self.passes.width(D)];
        if part != EnergyPart::Stabilization && self.passes.energy_needs_pass() {
            self.first_pass(&body, left, near);
        }
        let left = &*left;
        let scene = self.asked(&body, left, near, records, part == EnergyPart::Plastic);
        let scene = &scene;
        let body = Body::<D>::new(scene, self.passes.weights());
        scene.workers.sweep(scene.places.len(), PerPoint(density, 1), |range, density| {
            for (value, point) in density.0.iter_mut().zip(range) {
                if near.is_some_and(|near| !near.wants_energy(point)) {
                    *value = 0.0;
                    continue;
                }
                *value = match part {
                    EnergyPart::Strain | EnergyPart::Plastic => {
                        self.passes.energy_at(&body, point, left)
                    }
                    EnergyPart::Stabilization => self.passes.stabilisation_at(&body, point),
                };
            }
        });
    }

    fn mark_degenerate<const D: usize>(&self, scene: &Scene<'_>, marks: &mut [f64]) {
        let body = Body::<D>::new(scene, self.passes.weights());
        scene.workers.sweep(scene.places.len(), PerPoint(marks, 1), |range, marks| {
            for (mark, point) in marks.0.iter_mut().zip(range) {
                *mark = f64::from(u8::from(self.passes.is_degenerate(&body, point)));
            }
        });
    }

    fn read_kinematics<const D: usize>(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        values: &mut [f64],
        read: &Read<'_>,
    ) {
        let (records, scratch) = scratch.split_at_mut(self.records_of(scene));
        let (body, count) = (Body::<D>::new(scene, self.passes.weights()), scene.places.len());
        let left = &mut scratch[..count * self.passes.width(D)];
        if self.passes.has_second() || self.records_of(scene) == 0 {
            self.first_pass(&body, left, None);
        }
        let scene = self.asked(&body, left, None, records, false);
        let scene = &scene;
        let body = Body::<D>::new(scene, self.passes.weights());
        let (left, width) = (&*left, values.len() / count);
        scene.workers.sweep(count, PerPoint(values, width), |range, values| {
            for (values, point) in values.0.chunks_exact_mut(width).zip(range) {
                read(&self.passes.kinematics_at(&body, point, left), values);
            }
        });
    }

    /// Breaks the bonds that the rule condemns, and books what points lose by it.
    fn break_bonds(&self, scene: &Scene<'_>, scratch: &mut [f64], breaking: &mut Breaking<'_>) {
        if !breaking::break_stretched(scene, breaking) {
            return;
        }
        let room = breaking::room(scene.places.len(), scene.dimension);
        let (scratch, own) = scratch.split_at_mut(scratch.len() - room);
        let needs_pass = self.passes.energy_needs_pass();
        breaking::book(scene, breaking, own, needs_pass, |scene, near, part, density| {
            match (part, scene.dimension) {
                _ if !self.has(part, scene) => density.fill(0.0),
                (_, 3) => self.energies::<3>(scene, scratch, density, part, Some(near)),
                _ => self.energies::<2>(scene, scratch, density, part, Some(near)),
            }
        });
    }
}

impl<P: Passes> Formulation for StateBased<P> {
    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        if self.passes.corrected_modulus(0).is_none() {
            return Ok(());
        }
        let (points, blocks) = (scene.places.len(), scene.families.block_count());
        let mut scratch = crate::memory::filled(
            0.0,
            self.scratch(points, blocks, scene.dimension, false),
            "surface factors",
        )?;
        let factors = surface::factors(
            scene,
            |scene, density| {
                self.energy_density(scene, &mut scratch, density, EnergyPart::Strain);
                Ok(())
            },
            |point| self.passes.corrected_modulus(point).unwrap_or(0.0),
        )?;
        self.passes.correct(factors);
        Ok(())
    }

    fn scratch(&self, points: usize, blocks: usize, dimension: usize, breaks: bool) -> usize {
        let passes = 1 + usize::from(self.passes.has_second());
        let lanes = blocks * LANES * self.passes.lane_width(dimension);
        let room = if breaks { breaking::room(points, dimension) } else { 0 };
        let records = self.records(points, blocks);
        records + points * passes * self.passes.width(dimension) + lanes + room
    }

    fn was_stopped(&self) -> bool {
        self.passes.laws().is_some_and(Laws::was_stopped)
    }

    fn records(&self, points: usize, blocks: usize) -> usize {
        self.passes.records(points, blocks)
    }

    fn force(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        force: &mut [f64],
        breaking: Option<Breaking<'_>>,
    ) -> Option<usize> {
        let mut bonds = scene.bonds;
        let mut breaking = breaking;
        if let Some(breaking) = &mut breaking {
            self.break_bonds(scene, scratch, breaking);
        }
        if let Some(breaking) = &breaking {
            bonds.intact = &*breaking.intact;
        }
        let scene = Scene { bonds, ..*scene };
        match scene.dimension {
            3 => self.passes::<3>(&scene, scratch, force),
            _ => self.passes::<2>(&scene, scratch, force),
        }
    }

    fn energy_density(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        density: &mut [f64],
        part: EnergyPart,
    ) {
        match (part, scene.dimension) {
            _ if !self.has(part, scene) => density.fill(0.0),
            (_, 3) => self.energies::<3>(scene, scratch, density, part, None),
            _ => self.energies::<2>(scene, scratch, density, part, None),
        }
    }

    fn kinematics(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        values: &mut [f64],
        read: &Read<'_>,
    ) {
        match scene.dimension {
            3 => self.read_kinematics::<3>(scene, scratch, values, read),
            _ => self.read_kinematics::<2>(scene, scratch, values, read),
        }
    }

    fn weights(&self) -> &Weights {
        self.passes.weights()
    }

    fn stiffness_bound(&self, _: &Scene<'_>, _: &mut [f64]) -> bool {
        false
    }

    fn degenerate(&self, scene: &Scene<'_>, marks: &mut [f64]) {
        match scene.dimension {
            3 => self.mark_degenerate::<3>(scene, marks),
            _ => self.mark_degenerate::<2>(scene, marks),
        }
    }

    fn conventional_stiffness(&self, scene: &Scene<'_>, stiffness: &mut [f64]) {
        scene.workers.sweep(scene.places.len(), PerPoint(stiffness, 1), |range, sums| {
            for (sum, point) in sums.0.iter_mut().zip(range) {
                let own = scene.families.bonds(point).map(|bond| {
                    let volume = scene.families.share(point, bond) * scene.places[bond.neighbor][3];
                    volume / bond.length
                });
                *sum = own.sum::<f64>() * self.bond_constants.at(point);
            }
        });
    }

    fn bytes(&self) -> usize {
        self.passes.bytes() + self.passes.weights().bytes() + self.bond_constants.bytes()
    }
}
