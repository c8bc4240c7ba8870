//! What all state-based formulations share: two passes over the families, of which the first leaves a few
//! numbers a point for the second, and the breaking of bonds before them.
//!
//! Between the passes only these numbers are exchanged: the seam for ranks.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::body::{Body, Weights};
use super::breaking::Near;
use super::calm::{Calm, Resting};
use super::in_lanes::{self, of_size};
use super::laws::Laws;
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes, Room};
use super::surface::Surface;
use super::{
    Asked, EnergyPart, Formulation, LimitsFollow, Materials, Read, Scene, breaking, constants,
    surface, surface_stiffness,
};
use crate::damage::Breaking;
use crate::error::Result;
use crate::families::lattice::LatticeUse;
use crate::families::{Bond, LANES, Property};
use crate::model::SurfaceCorrection;
use crate::tensor::Vector;
use crate::workers::{PerPoint, Ragged};

/// A formulation in passes, made ready for a body.
pub(super) struct StateBased<P> {
    passes: P,
    /// C_b of [P 3.58].
    bond_constants: Property,
    breaks: bool,
    /// What the stretch follows from at which bonds break.
    limits: LimitsFollow,
    /// What is known of where nothing happens.
    calm: Option<Calm>,
    /// How far the force on a point of a body reaches that has none at rest, in families.
    rings: Option<u8>,
}

impl<P: Passes> StateBased<P> {
    pub(super) fn new(materials: &Materials<'_>, passes: P) -> Result<Self> {
        let bond_constants = materials.property(
            |model, horizon| {
                let elastic = model.elastic()?;
                Ok(constants::bond_constant(&elastic, model, materials.dimension, horizon))
            },
            "bond constants",
        )?;
        let limits = LimitsFollow::Nothing;
        Ok(Self { passes, bond_constants, breaks: false, limits, calm: None, rings: None })
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
        gather(scene, bad, force, |point| passes.force_at(&body, point, left))
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
        let lanes = &*lanes;
        gather(scene, bad, force, |point| passes.force_from_lanes(body, point, lanes))
    }

    fn forces_in_lanes(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
        resting: Resting<'_>,
    ) -> Option<usize> {
        let (passes, (records, tables)) =
            (&self.passes, scratch.split_at_mut(self.records_of(scene)));
        let room = Room { records, tables };
        let sweep = ForceSweep { scene, room, force, breaking, resting };
        of_size!(scene.dimension, passes.forces_in_lanes(sweep))
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
        let passes = &self.passes;
        let room = Room { records: &mut *records, tables: &mut *scratch };
        let sweep = EnergySweep { scene, room, density: &mut *density, part, near };
        if passes.runs_in_lanes(scene) && of_size!(D, passes.energy_in_lanes(sweep)) {
            return;
        }
        let body = Body::<D>::new(scene, self.passes.weights());
        let left = &mut scratch[..scene.places.len() * self.passes.width(D)];
        if part != EnergyPart::Stabilization && self.passes.energy_needs_pass() {
            self.first_pass(&body, left, near);
        }
        let left = &*left;
        // The penalty asks no law.
        let records = if part == EnergyPart::Stabilization { &mut [] } else { records };
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
        let (passes, count) = (&self.passes, scene.places.len());
        let width = values.len() / count;
        let room = Room { records: &mut *records, tables: &mut *scratch };
        let sweep = FieldSweep { scene, room, values: &mut *values, width, read };
        if passes.runs_in_lanes(scene) && of_size!(D, passes.kinematics_in_lanes(sweep)) {
            return;
        }
        let body = Body::<D>::new(scene, self.passes.weights());
        let left = &mut scratch[..count * self.passes.width(D)];
        if self.passes.kinematics_need_pass() {
            self.first_pass(&body, left, None);
        }
        let scene = self.asked(&body, left, None, records, false);
        let scene = &scene;
        let body = Body::<D>::new(scene, self.passes.weights());
        let left = &*left;
        scene.workers.sweep(count, PerPoint(values, width), |range, values| {
            for (values, point) in values.0.chunks_exact_mut(width).zip(range) {
                read(&self.passes.kinematics_at(&body, point, left), values);
            }
        });
    }

    /// Breaks the bonds that the rule condemns, and books what points lose by it.
    fn break_bonds(
        &self,
        (scene, resting): (&Scene<'_>, Resting<'_>),
        scratch: &mut [f64],
        breaking: &mut Breaking<'_>,
    ) {
        let room = breaking::room(scene.places.len(), scene.dimension);
        let first = scratch.len() - room;
        if breaking::break_stretched((scene, resting), &mut scratch[first..], breaking) {
            self.book(scene, scratch, breaking);
        }
    }

    /// Books what points lose by the bonds that have broken.
    fn book(&self, scene: &Scene<'_>, scratch: &mut [f64], breaking: &mut Breaking<'_>) {
        let room = breaking::room_of_booking(scene.places.len(), scene.dimension);
        let (scratch, own) = scratch.split_at_mut(scratch.len() - room);
        let needs_pass = self.passes.energy_needs_pass();
        breaking::book(scene, breaking, own, needs_pass, |scene, near, part, density| {
            match scene.dimension {
                _ if !self.has(part, scene) => return false,
                3 => self.energies::<3>(scene, scratch, density, part, Some(near)),
                _ => self.energies::<2>(scene, scratch, density, part, Some(near)),
            }
            true
        });
    }
}

/// Sums up the force on each point, unless `bad` names one whose own material has failed: it is to be named, and not
/// one that it pulls on. Gives the first point without a finite force.
fn gather<const D: usize>(
    scene: &Scene<'_>,
    bad: AtomicUsize,
    force: &mut [f64],
    force_at: impl Fn(usize) -> Vector<D> + Sync,
) -> Option<usize> {
    let found = bad.load(Ordering::Relaxed);
    if found != usize::MAX {
        return Some(found);
    }
    scene.workers.sweep(scene.places.len(), PerPoint(force, D), |range, force| {
        let (forces, _) = force.0.as_chunks_mut::<D>();
        for (force, point) in forces.iter_mut().zip(range) {
            *force = force_at(point);
            if !force.iter().all(|component| component.is_finite()) {
                bad.fetch_min(point, Ordering::Relaxed);
            }
        }
    });
    let found = bad.into_inner();
    (found != usize::MAX).then_some(found)
}

impl<P: Passes> Formulation for StateBased<P> {
    fn use_of_a_lattice(&self) -> LatticeUse {
        match self.limits {
            LimitsFollow::Nothing => self.passes.use_of_a_lattice(),
            LimitsFollow::Models if self.passes.models_differ().is_some() => {
                self.passes.use_of_a_lattice()
            }
            _ => LatticeUse::None,
        }
    }

    fn know_limits(&mut self, any: bool, limits: LimitsFollow) {
        (self.breaks, self.limits) = (any, limits);
    }

    fn tells_models_apart(&self) -> bool {
        let differ = self.passes.models_differ();
        differ.is_some_and(|differ| differ || self.limits == LimitsFollow::Models)
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        let has_lanes = self.passes.room_of_lanes(1, 1, scene.dimension) > 0;
        if has_lanes {
            self.passes.weights_mut().keep(scene)?;
        }
        self.passes.refer_to(scene)?;
        self.rings = self.passes.rings(scene.dimension).filter(|_| has_lanes);
        let tests = self.breaks && self.limits == LimitsFollow::Nothing;
        if let Some(reach) = scene.families.reach.uniform_radius()
            && (tests || self.rings.is_some())
        {
            // What a sweep leaves is read by others, each a ring further in.
            let most_rings = self.rings.map_or(0, |rings| 2 * rings - 1);
            self.calm = Some(Calm::new(scene, reach, tests, most_rings)?);
        }
        let Some(Surface { correction, moduli }) = self.passes.surface() else { return Ok(()) };
        let factors = match correction {
            SurfaceCorrection::Energy => surface::factors(scene, self, |point| *moduli.at(point)),
            SurfaceCorrection::StiffnessTensor => {
                let weight = |point: usize, bond: Bond| {
                    let volume = scene.places[bond.neighbor][3];
                    self.passes.weights().own(scene, point, bond) * bond.length.powi(2) * volume
                };
                surface_stiffness::factors(scene, weight, |_, sum| sum)
            }
        }?;
        let weights = self.passes.weights_mut();
        weights.correction = Some(factors);
        if has_lanes { weights.keep(scene) } else { Ok(()) }
    }

    fn scratch(&self, points: usize, blocks: usize, dimension: usize, breaks: bool) -> usize {
        let passes = 1 + usize::from(self.passes.has_second());
        let lanes = blocks * LANES * self.passes.lane_width(dimension);
        let room = if breaks { breaking::room(points, dimension) } else { 0 };
        let records = self.records(points, blocks);
        let passes = points * passes * self.passes.width(dimension) + lanes;
        records + passes.max(self.passes.room_of_lanes(points, blocks, dimension)) + room
    }

    fn scratch_on_lattice(&self, points: usize, dimension: usize, breaks: bool) -> usize {
        if !breaks {
            return 0;
        }
        self.passes.room_of_energies(points, dimension)
            + breaking::room_of_booking(points, dimension)
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
        let mut breaking = breaking;
        let (records, in_lanes) = (self.records_of(scene), self.passes.runs_in_lanes(scene));
        let calm = self.calm.as_ref().filter(|_| breaking.is_some() || self.rings.is_some());
        let look = calm.map(|calm| calm.look(scene));
        let resting = Resting::new(look.as_ref(), self.rings);
        if in_lanes && records == 0 {
            let bad = self.forces_in_lanes(scene, scratch, force, &mut breaking, resting);
            if let Some(breaking) = &mut breaking
                && breaking.has_broken()
            {
                self.book(scene, scratch, breaking);
            }
            return bad;
        }
        // To book asks laws with memory: they are asked once more for the forces.
        if let Some(breaking) = &mut breaking {
            self.break_bonds((scene, resting), scratch, breaking);
        }
        let scene = &in_lanes::remaining(scene, &breaking);
        match scene.dimension {
            _ if in_lanes => self.forces_in_lanes(scene, scratch, force, &mut None, resting),
            3 => self.passes::<3>(scene, scratch, force),
            _ => self.passes::<2>(scene, scratch, force),
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

    fn has_potential(&self) -> bool {
        self.passes.has_potential() && !self.passes.laws().is_some_and(Laws::remember)
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
        let calm = self.calm.as_ref().map_or(0, Calm::bytes);
        self.passes.bytes() + self.passes.weights().bytes() + self.bond_constants.bytes() + calm
    }
}
