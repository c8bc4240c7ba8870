//! Bond-based peridynamics: every bond a spring of its own. [P 3.8-3.11]
//!
//! t_ij = 1/2 c d s m, W_i = 1/4 sum c d s^2 L V_j, with the bond constant c of the bulk modulus in 3D
//! and of Young's modulus in 2D. Poisson's ratio is 1/4 in 3D and plane strain, 1/3 in plane stress.

use std::f64::consts::PI;

use super::body::{Body, ByModel, Link, Weights};
use super::constants;
use super::ordinary_state_based::extension;
use super::{
    EnergyPart, Formulation, FormulationEntry, Kinematics, Materials, Read, Scene, surface,
};
use crate::damage::Breaking;
use crate::error::{Error, Result};
use crate::families::Property;
use crate::kernel::bond_based::{Alike, BlockBreaking, BondLaw, Cloud, Various};
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
    fn various<'a>(&'a self, scene: &Scene<'a>, breaking: Option<&Breaking<'a>>) -> Various<'a> {
        Various {
            bond_constants: &self.bond_constants,
            families: scene.families,
            integrity: scene.bonds.integrity,
            correction: self.correction.as_deref(),
            rule: breaking.map(|breaking| breaking.rule),
        }
    }

    /// The law of a scene in which all bonds are alike, if it is one.
    fn alike<'a>(&self, scene: &Scene<'_>, breaking: Option<&Breaking<'a>>) -> Option<Alike<'a>> {
        let (Property::Uniform(bond_constant), true, None, None) = (
            &self.bond_constants,
            scene.families.reach.is_sharp_and_uniform(),
            scene.bonds.integrity,
            &self.correction,
        ) else {
            return None;
        };
        let rule = breaking.map(|breaking| breaking.rule);
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
        term: impl Fn(usize, crate::families::Bond) -> f64 + Sync,
    ) {
        scene.workers.sweep(scene.places.len(), PerPoint(sums, 1), |range, sums| {
            for (sum, point) in sums.0.iter_mut().zip(range) {
                *sum = scene.families.bonds(point).map(|bond| term(point, bond)).sum();
            }
        });
    }
}

impl Formulation for BondBased {
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
        _: &mut [f64],
        force: &mut [f64],
        breaking: Option<Breaking<'_>>,
    ) -> Option<usize> {
        match self.alike(scene, breaking.as_ref()) {
            Some(law) => forces(scene, law, force, breaking),
            None => forces(scene, self.various(scene, breaking.as_ref()), force, breaking),
        }
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
        let cloud = Cloud::from(scene);
        let count = scene.places.len();
        scene.workers.sweep(count, PerPoint(density, 1), |range, density| match scene.dimension {
            3 => cloud.energy_density::<3>(law, range, density.0),
            _ => cloud.energy_density::<2>(law, range, density.0),
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

impl<'a> From<&Scene<'a>> for Cloud<'a> {
    fn from(scene: &Scene<'a>) -> Self {
        // What the kernel relies on without looking again.
        assert_eq!(scene.displacement.len(), scene.places.len() * scene.dimension);
        Self {
            places: scene.places,
            families: scene.families,
            displacement: scene.displacement,
            bonds: scene.bonds,
        }
    }
}

fn forces(
    scene: &Scene<'_>,
    law: impl BondLaw + Sync,
    force: &mut [f64],
    breaking: Option<Breaking<'_>>,
) -> Option<usize> {
    match scene.dimension {
        3 => sweep_forces::<3>(scene, law, force, breaking),
        _ => sweep_forces::<2>(scene, law, force, breaking),
    }
}

fn sweep_forces<const D: usize>(
    scene: &Scene<'_>,
    law: impl BondLaw + Sync,
    force: &mut [f64],
    breaking: Option<Breaking<'_>>,
) -> Option<usize> {
    let cloud = Cloud::from(scene);
    let bad = AtomicUsize::new(usize::MAX);
    let note = |found: Option<usize>| {
        if let Some(point) = found {
            bad.fetch_min(point, Ordering::Relaxed);
        }
    };
    let count = scene.places.len();
    let forces = PerPoint(force, D);
    match breaking {
        None => scene.workers.sweep(count, forces, |range, force| {
            note(cloud.force::<D>(law, range, force.0, None));
        }),
        Some(Breaking { intact, dissipated, before, .. }) => {
            // The kernel looks at it as at the displacement of the cloud.
            assert!(before.is_none_or(|before| before.len() == scene.displacement.len()));
            let offsets = &scene.families.offsets;
            let masks = Ragged { values: intact, offsets, width: 1 };
            let outputs = (forces, masks, PerPoint(dissipated, 1));
            scene.workers.sweep(count, outputs, |range, (force, masks, dissipated)| {
                let (intact, dissipated) = (masks.values, dissipated.0);
                let breaking = BlockBreaking { intact, dissipated, before };
                note(cloud.force::<D>(law, range, force.0, Some(breaking)));
            });
        }
    }
    let first = bad.into_inner();
    (first != usize::MAX).then_some(first)
}
