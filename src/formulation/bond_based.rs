//! Bond-based peridynamics: every bond a spring of its own. [P 3.8-3.11]
//!
//! t_ij = 1/2 c d s m, W_i = 1/4 sum c d s^2 L V_j, with the bond constant c of the bulk modulus in 3D
//! and of Young's modulus in 2D. Poisson's ratio is 1/4 in 3D and plane strain, 1/3 in plane stress.

use std::f64::consts::PI;

use super::body::{Body, ByModel, Link, Weights};
use super::breaking::stretch;
use super::constants;
use super::ordinary_state_based::extension;
use super::{
    EnergyPart, Formulation, FormulationEntry, Kinematics, Materials, Read, Scene, surface,
};
use crate::damage::{BreakRule, Breaking};
use crate::error::{Error, Result};
use crate::families::{Bond, Families, LANES, Property};
use crate::kernel::bond_based::{BondLaw, Cloud, ForceSweep, Part, Record};
use crate::kernel::simd::Simd;
use crate::material::Law;
use crate::model::{Elastic, Influence, Model, Plane};
use crate::workers::{PerPoint, Ragged};
use std::sync::atomic::{AtomicUsize, Ordering};

pub(super) const ENTRY: FormulationEntry = FormulationEntry {
    name: "bond_based",
    description: "bond-based (PMB): each bond a spring; Poisson's ratio 1/4, in plane stress 1/3",
    refused_keys: &[
        "influence",
        "material",
        "yield_stress",
        "hardening_modulus",
        "silling_coefficient",
        "bond_horizon",
        "force_form",
        "operator_bonds",
        "gradient_order",
        "divergence",
    ],
    check: |model, dimension| elastic(model, dimension).map(|_| ()),
    critical_stretch,
    prepare,
};

struct BondBased {
    bond_constants: Property,
    /// lambda/2 + mu, where the surface is to be corrected.
    corrected: Option<Property>,
    /// Factor of each lane, once they are known.
    correction: Option<Vec<f64>>,
    /// Every bond counts alike in the deformation gradient.
    weights: Weights,
    /// For what lies across; bonds do not ask it.
    laws: ByModel<Law>,
}

fn elastic(model: &Model, dimension: usize) -> Result<Elastic> {
    let (ratio, reason) = match (dimension, model.plane()) {
        (3, _) => (0.25, "bond_based has 1/4 in 3D"),
        (_, Plane::Strain) => (0.25, "bond_based has 1/4 in plane strain"),
        (_, Plane::Stress) => (1.0 / 3.0, "bond_based has 1/3 in plane stress"),
    };
    Elastic::with_fixed_ratio(&model.elastic_constants(), ratio, reason)
}

/// c [P 3.9]: force per volume squared at stretch 1.
fn bond_constant(model: &Model, dimension: usize, horizon: f64) -> Result<f64> {
    let elastic = elastic(model, dimension)?;
    let constant = constants::bond_constant(&elastic, model, dimension, horizon);
    if constant > 0.0 && constant.is_finite() {
        return Ok(constant);
    }
    Err(Error::Argument(format!(
        "the elastic constants with 'horizon' {horizon} give the bond constant {constant}, out of \
         the range of numbers; use other units"
    )))
}

/// The stretch at which opening a unit of crack takes the energy `rate`.
fn critical_stretch(model: &Model, dimension: usize, horizon: f64, rate: f64) -> Result<f64> {
    let elastic = elastic(model, dimension)?;
    let per_modulus = match (dimension, model.plane()) {
        (3, _) => 5.0 / (9.0 * elastic.bulk_modulus),
        (_, Plane::Stress) => 4.0 * PI / (9.0 * elastic.youngs_modulus),
        (_, Plane::Strain) => 5.0 * PI / (12.0 * elastic.youngs_modulus),
    };
    Ok((per_modulus * rate / horizon).sqrt())
}

fn prepare(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    let bond_constants = materials.property(
        |model, horizon| bond_constant(model, materials.dimension, horizon),
        "bond constants",
    )?;
    let corrected = if materials.models[0].corrects_surface() {
        let modulus = |model: &Model, _| {
            let elastic = elastic(model, materials.dimension)?;
            let lambda = match materials.dimension {
                3 => elastic.lame_lambda,
                _ => elastic.plane_lambda(model.plane()),
            };
            Ok(0.5 * lambda + elastic.shear_modulus)
        };
        Some(materials.property(modulus, "moduli")?)
    } else {
        None
    };
    let weights = Weights::with(materials, |_| Ok(Influence::Constant))?;
    let laws = ByModel::new(materials, |model| {
        Ok(Law::with(&elastic(model, materials.dimension)?, model, materials.dimension))
    })?;
    Ok(Box::new(BondBased { bond_constants, corrected, correction: None, weights, laws }))
}

impl BondBased {
    fn various<'a>(&'a self, scene: &Scene<'a>, rule: Option<&'a BreakRule>) -> Various<'a> {
        Various {
            bond_constants: &self.bond_constants,
            families: scene.families,
            integrity: scene.bonds.integrity,
            correction: self.correction.as_deref(),
            rule,
        }
    }

    /// The law of a scene in which all bonds are alike, if it is one.
    fn alike<'a>(&self, scene: &Scene<'_>, rule: Option<&'a BreakRule>) -> Option<Alike<'a>> {
        let (Property::Uniform(bond_constant), true, None, None) = (
            &self.bond_constants,
            scene.families.reach.is_sharp_and_uniform(),
            scene.bonds.integrity,
            &self.correction,
        ) else {
            return None;
        };
        let critical = rule.map_or(Some(f64::INFINITY), |rule| rule.uniform())?;
        Some(Alike { bond_constant: *bond_constant, critical, rule })
    }

    fn read_kinematics<const D: usize>(
        &self,
        scene: &Scene<'_>,
        values: &mut [f64],
        read: &Read<'_>,
    ) {
        let (body, count) = (Body::<D>::new(scene, &self.weights), scene.places.len());
        let width = values.len() / count;
        let tension = |point: usize, link: &Link<D>| {
            let (own, other) =
                (self.bond_constants.at(point), self.bond_constants.at(link.neighbor));
            let (extension, now) = extension(link);
            (0.5 * (own * link.own + other * link.other) * extension / link.length, now)
        };
        scene.workers.sweep(count, PerPoint(values, width), |range, values| {
            for (values, point) in values.0.chunks_exact_mut(width).zip(range) {
                let (law, tension) = (self.laws.at(point), |link: &Link<D>| tension(point, link));
                read(&Kinematics::of_bonds(&body, point, law, tension), values);
            }
        });
    }

    fn sum_over_bonds(
        &self,
        scene: &Scene<'_>,
        sums: &mut [f64],
        term: impl Fn(usize, Bond) -> f64 + Sync,
    ) {
        scene.workers.sweep(scene.places.len(), PerPoint(sums, 1), |range, sums| {
            for (sum, point) in sums.0.iter_mut().zip(range) {
                *sum = scene.families.bonds(point).map(|bond| term(point, bond)).sum();
            }
        });
    }
}

impl Formulation for BondBased {
    fn scratch(&self, points: usize, _: usize, _: usize, _: bool) -> usize {
        points * size_of::<Record>() / size_of::<f64>() + SLACK
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        let Some(moduli) = &self.corrected else { return Ok(()) };
        let factors = surface::factors(
            scene,
            |scene, density| {
                self.energy_density(scene, &mut [], density, EnergyPart::Strain);
                Ok(())
            },
            |point| moduli.at(point),
        )?;
        self.correction = Some(factors);
        Ok(())
    }

    fn force(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        force: &mut [f64],
        mut breaking: Option<Breaking<'_>>,
    ) -> Option<usize> {
        let rule = breaking.as_ref().map(|breaking| breaking.rule);
        let remaining = breaking.as_mut().map(|breaking| &mut *breaking.intact);
        let various = self.various(scene, rule);
        let bad = match self.alike(scene, rule) {
            Some(law) => forces(scene, law, scratch, force, remaining),
            None => forces(scene, various, scratch, force, remaining),
        };
        if let Some(breaking) = breaking {
            book(scene, various, breaking);
        }
        bad
    }

    fn energy_density(
        &self,
        scene: &Scene<'_>,
        _: &mut [f64],
        density: &mut [f64],
        part: EnergyPart,
    ) {
        if part == EnergyPart::Stabilization {
            density.fill(0.0);
            return;
        }
        let law = self.various(scene, None);
        self.sum_over_bonds(scene, density, |point, bond| {
            if !scene.bonds.is_intact(bond.slot) {
                return 0.0;
            }
            let stretch = stretch(scene, point, bond.neighbor, bond.length);
            law.energy(scene, point, bond, [stretch; 2])
        });
    }

    fn kinematics(&self, scene: &Scene<'_>, _: &mut [f64], values: &mut [f64], read: &Read<'_>) {
        match scene.dimension {
            3 => self.read_kinematics::<3>(scene, values, read),
            _ => self.read_kinematics::<2>(scene, values, read),
        }
    }

    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn has_potential(&self) -> bool {
        true
    }

    fn stiffens_by_damage(&self) -> bool {
        false
    }

    fn conventional_stiffness(&self, scene: &Scene<'_>, stiffness: &mut [f64]) {
        let law = self.various(scene, None);
        self.sum_over_bonds(scene, stiffness, |point, bond| {
            law.own_constant(point, bond) * scene.places[bond.neighbor][3] / bond.length
        });
    }

    fn bytes(&self) -> usize {
        self.bond_constants.bytes()
            + self.correction.as_ref().map_or(0, crate::memory::bytes)
            + self.weights.bytes()
            + self.laws.bytes()
    }
}

/// All bonds alike: one material, one horizon, no integrity set by hand.
#[derive(Clone, Copy)]
struct Alike<'a> {
    bond_constant: f64,
    critical: f64,
    rule: Option<&'a BreakRule>,
}

/// Bonds that differ by their ends or one by one.
#[derive(Clone, Copy)]
struct Various<'a> {
    bond_constants: &'a Property,
    families: &'a Families,
    integrity: Option<&'a [f64]>,
    /// Factor of each lane by which bonds near a surface are stiffer.
    correction: Option<&'a [f64]>,
    rule: Option<&'a BreakRule>,
}

/// (l/L)^2 - 1 at a stretch.
fn squared_ratio_less_one(stretch: f64) -> f64 {
    stretch * (2.0 + stretch)
}

fn breakable(rule: Option<&BreakRule>, block: usize) -> u8 {
    rule.map_or(0, |rule| rule.breakable(block))
}

impl BondLaw for Alike<'_> {
    #[inline(always)]
    fn factor(&self) -> f64 {
        self.bond_constant
    }
    #[inline(always)]
    fn weight<S: Simd>(&self, _: S, _: &Part<'_>, inverse: S::Lanes, volume: S::Lanes) -> S::Lanes {
        inverse * volume
    }
    #[inline(always)]
    fn threshold<S: Simd>(&self, simd: S, _: &Part<'_>) -> S::Lanes {
        simd.splat(squared_ratio_less_one(self.critical))
    }
    fn breakable(&self, block: usize) -> u8 {
        breakable(self.rule, block)
    }
}

impl Various<'_> {
    #[inline(always)]
    fn constant(&self, point: usize, neighbor: usize, length: f64) -> f64 {
        self.families.reach.share(point, neighbor, length) * self.bond_constants.at(point)
    }

    /// Integrity of a bond, and with it what the surface adds.
    #[inline(always)]
    fn integrity(&self, slot: usize) -> f64 {
        let correction = self.correction.map_or(1.0, |values| values[slot]);
        correction * self.integrity.map_or(1.0, |values| values[slot])
    }

    /// Bond constant times integrity that acts between both ends of one bond.
    fn stiffness(&self, point: usize, bond: Bond) -> f64 {
        let Bond { slot, neighbor, length } = bond;
        let (own, other) =
            (self.constant(point, neighbor, length), self.constant(neighbor, point, length));
        0.5 * (own + other) * self.integrity(slot)
    }

    /// Bond constant of the point's own material, whatever the bond's integrity; less in the rim of its
    /// horizon, 0 outside.
    fn own_constant(&self, point: usize, bond: Bond) -> f64 {
        self.constant(point, bond.neighbor, bond.length)
    }

    /// Energy per volume that a point has in a bond: 1/4 c d s r L V_j at the stretches s and r.
    fn energy(&self, scene: &Scene<'_>, point: usize, bond: Bond, stretches: [f64; 2]) -> f64 {
        let stiffness = self.own_constant(point, bond) * self.integrity(bond.slot);
        let [now, pulled] = stretches;
        0.25 * stiffness * now * scene.places[bond.neighbor][3] * pulled * bond.length
    }

    /// Energy per volume that the point loses by the bonds that are not in the masks `remaining` of its blocks any
    /// more: with the stretch at which the bond pulled last, where it pulled; as it is where nothing was before.
    fn lost(
        &self,
        scene: &Scene<'_>,
        point: usize,
        remaining: &[u8],
        before: Option<&[f64]>,
    ) -> f64 {
        let first = scene.families.blocks(point).start * LANES;
        let broken = |bond: &Bond| {
            let (block, bit) = ((bond.slot - first) / LANES, 1 << (bond.slot % LANES));
            remaining[block] & bit == 0 && scene.bonds.is_intact(bond.slot)
        };
        let each = scene.families.bonds(point).filter(broken).map(|bond| {
            let stretch = |displacement| {
                let scene = Scene { displacement, ..*scene };
                stretch(&scene, point, bond.neighbor, bond.length)
            };
            let now = stretch(scene.displacement);
            let pulled = before.map_or(now, |before| stretch(before).max(0.0));
            self.energy(scene, point, bond, [now, pulled])
        });
        each.sum()
    }
}

impl BondLaw for Various<'_> {
    #[inline(always)]
    fn factor(&self) -> f64 {
        1.0
    }
    #[inline(always)]
    fn weight<S: Simd>(
        &self,
        simd: S,
        part: &Part<'_>,
        inverse: S::Lanes,
        volume: S::Lanes,
    ) -> S::Lanes {
        inverse * volume * simd.each(|lane| self.stiffness(part.point, part.bond(lane)))
    }
    #[inline(always)]
    fn threshold<S: Simd>(&self, simd: S, part: &Part<'_>) -> S::Lanes {
        let Some(rule) = self.rule else { return simd.splat(f64::INFINITY) };
        simd.each(|lane| {
            let bond = part.bond(lane);
            squared_ratio_less_one(rule.threshold(bond.slot, part.point, bond.neighbor))
        })
    }
    fn breakable(&self, block: usize) -> u8 {
        breakable(self.rule, block)
    }
}

fn forces(
    scene: &Scene<'_>,
    law: impl BondLaw,
    scratch: &mut [f64],
    force: &mut [f64],
    remaining: Option<&mut [u8]>,
) -> Option<usize> {
    match scene.dimension {
        3 => sweep_forces::<3>(scene, law, scratch, force, remaining),
        _ => sweep_forces::<2>(scene, law, scratch, force, remaining),
    }
}

fn sweep_forces<const D: usize>(
    scene: &Scene<'_>,
    law: impl BondLaw,
    scratch: &mut [f64],
    force: &mut [f64],
    remaining: Option<&mut [u8]>,
) -> Option<usize> {
    let count = scene.places.len();
    let records = records_of::<D>(scene, scratch);
    let cloud = Cloud::new(scene.families, records, scene.bonds.intact);
    let bad = AtomicUsize::new(usize::MAX);
    let offsets = &scene.families.offsets;
    let remaining = remaining.map(|values| Ragged { values, offsets, width: 1 });
    scene.workers.sweep(count, (PerPoint(force, D), remaining), |range, (force, remaining)| {
        let remaining = remaining.map(|masks| masks.values);
        let sweep = ForceSweep::<_, D> { cloud, law, range, force: force.0, remaining };
        if let Some(point) = scene.simd.run(sweep) {
            bad.fetch_min(point, Ordering::Relaxed);
        }
    });
    let first = bad.into_inner();
    (first != usize::MAX).then_some(first)
}

/// Numbers beyond those of the records that let the first of them begin a line of the cache.
const SLACK: usize = 7;

/// A record of each point, in the scratch.
fn records_of<'a, const D: usize>(scene: &Scene<'_>, scratch: &'a mut [f64]) -> &'a [Record] {
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
                record[axis] += 0.5 * shift;
                record[4 + axis] = 2.0 * shift;
            }
        }
    });
    records
}

/// Adds what points lose by the bonds that have broken.
fn book(scene: &Scene<'_>, law: Various<'_>, breaking: Breaking<'_>) {
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
