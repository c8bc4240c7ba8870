//! Bond-based peridynamics: every bond a spring of its own. [P 3.8-3.11]
//!
//! t_ij = 1/2 c d s m, W_i = 1/4 sum c d s^2 L V_j, with the bond constant c of the bulk modulus in 3D
//! and of Young's modulus in 2D. Poisson's ratio is 1/4 in 3D and plane strain, 1/3 in plane stress.

use std::f64::consts::PI;

use super::body::{Body, ByModel, Link, Weights};
use super::bond_forces::{BondForces, book, energies, fields};
use super::bond_laws::{Alike, Common, Limits, Various};
use super::calm::{Calm, Resting};
use super::constants;
use super::on_lattice::{LatticeState, OnLattice};
use super::ordinary_state_based::extension;
use super::surface::{Correction, Surface};
use super::{
    EnergyPart, Formulation, FormulationEntry, Kinematics, LimitsFollow, Materials, Read, Scene,
    in_lanes, surface, surface_stiffness,
};
use crate::damage::{BreakRule, Breaking};
use crate::error::{Error, Result};
use crate::families::lattice::LatticeUse;
use crate::families::{Bond, Property};
use crate::kernel::bond_based::BondLaw;
use crate::material::Law;
use crate::model::{Elastic, Influence, Model, Plane, SurfaceCorrection};
use crate::workers::PerPoint;

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
    /// Where the surface is to be corrected.
    surface: Option<Surface<Property>>,
    /// Factors of bonds, once they are known.
    correction: Option<Correction>,
    /// Every bond counts alike in the deformation gradient.
    weights: Weights,
    /// For what lies across; bonds do not ask it.
    laws: ByModel<Law>,
    breaks: bool,
    /// What the stretch follows from at which bonds break.
    limits: LimitsFollow,
    /// What sweeps over the lattice hold, where there is one.
    lattice: Option<LatticeState>,
    /// What is known of where nothing happens.
    calm: Option<Calm>,
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
    let surface = if let Some(correction) = materials.models[0].surface_correction() {
        let modulus = |model: &Model, _| {
            let elastic = elastic(model, materials.dimension)?;
            let lambda = match materials.dimension {
                3 => elastic.lame_lambda,
                _ => elastic.plane_lambda(model.plane()),
            };
            Ok(0.5 * lambda + elastic.shear_modulus)
        };
        Some(Surface { correction, moduli: materials.property(modulus, "moduli")? })
    } else {
        None
    };
    let weights = Weights::with(materials, |_| Ok(Influence::Constant))?;
    let laws = ByModel::new(materials, |model| {
        Ok(Law::with(&elastic(model, materials.dimension)?, model, materials.dimension))
    })?;
    let (correction, lattice) = (None, None);
    let limits = LimitsFollow::Nothing;
    Ok(Box::new(BondBased {
        bond_constants,
        surface,
        correction,
        weights,
        laws,
        limits,
        lattice,
        breaks: false,
        calm: None,
    }))
}

impl BondBased {
    fn various<'a>(&'a self, scene: &'a Scene<'a>, rule: Option<&'a BreakRule>) -> Various<'a> {
        Various {
            common: Common {
                bond_constant: self.common_constant(scene),
                critical: rule.and_then(BreakRule::uniform),
            },
            bond_constants: &self.bond_constants,
            families: scene.families,
            integrity: scene.bonds.integrity,
            correction: self.correction.as_ref(),
            limits: Limits { scene, rule },
        }
    }

    /// The bond constant of all bonds but for integrity and correction, if they have one.
    fn common_constant(&self, scene: &Scene<'_>) -> Option<f64> {
        match self.bond_constants {
            Property::Uniform(constant) if scene.families.reach.is_sharp_and_uniform() => {
                Some(constant)
            }
            _ => None,
        }
    }

    /// The law of a scene in which all bonds are alike, if it is one.
    fn alike<'a>(&self, scene: &'a Scene<'a>, rule: Option<&'a BreakRule>) -> Option<Alike<'a>> {
        if self.tells_models_apart() || self.differ_one_by_one(scene) {
            return None;
        }
        let bond_constant = self.common_constant(scene)?;
        let critical = rule.map_or(Some(f64::INFINITY), |rule| rule.uniform())?;
        let limits = Limits { scene, rule };
        Some(Alike { bond_constant, critical, limits })
    }

    /// Whether there are bonds that differ from others between points of the same models.
    fn differ_one_by_one(&self, scene: &Scene<'_>) -> bool {
        let graded = scene.bonds.integrity.is_some() || self.correction.is_some();
        graded || self.limits == LimitsFollow::Bonds
    }

    /// The lattice, if the body has one and its bonds do not differ one by one.
    fn on_lattice<'a>(
        &'a self,
        scene: &'a Scene<'a>,
        rule: Option<&'a BreakRule>,
        resting: Resting<'a>,
    ) -> Option<OnLattice<'a>> {
        let (lattice, state) = (scene.families.lattice.as_ref()?, self.lattice.as_ref()?);
        let on = OnLattice::breaking(scene, (lattice, state), rule, resting);
        (!self.differ_one_by_one(scene)).then_some(on)
    }

    fn read_kinematics<const D: usize>(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        values: &mut [f64],
        read: &Read<'_>,
    ) {
        let body = Body::<D>::new(scene, &self.weights);
        let width = values.len() / scene.places.len();
        let tension = |point: usize, link: &Link<D>| {
            let (own, other) =
                (self.bond_constants.at(point), self.bond_constants.at(link.neighbor));
            let [of_own, of_other] =
                self.correction.as_ref().map_or([1.0; 2], |factors| factors.at(link.slot));
            let (extension, now) = extension(link);
            let stiffness = 0.5 * (own * link.own * of_own + other * link.other * of_other);
            (stiffness * extension / link.length, now)
        };
        let give = |point: usize, sums: &_, values: &mut [f64]| {
            let (law, tension) = (self.laws.at(point), |link: &Link<D>| tension(point, link));
            let even = Kinematics::of_sums(sums, law);
            let made = even.unwrap_or_else(|| Kinematics::of_bonds(&body, point, law, tension));
            read(&made, values);
        };
        let values = PerPoint(values, width);
        match self.alike(scene, None) {
            Some(law) => fields::<D>(scene, law, scratch, values, give),
            None => fields::<D>(scene, self.various(scene, None), scratch, values, give),
        }
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
        in_lanes::room_of_records(points)
    }

    fn use_of_a_lattice(&self) -> LatticeUse {
        let fits = self.limits != LimitsFollow::Bonds && self.surface.is_none();
        if fits { LatticeUse::Groups } else { LatticeUse::None }
    }

    fn know_limits(&mut self, any: bool, limits: LimitsFollow) {
        (self.breaks, self.limits) = (any, limits);
    }

    fn tells_models_apart(&self) -> bool {
        let differ = matches!(self.bond_constants, Property::PerPoint(_));
        differ || self.limits == LimitsFollow::Models
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        if let Some(lattice) = &scene.families.lattice {
            self.lattice = Some(LatticeState::new(scene, lattice, 0)?);
        }
        if let Some(reach) = scene.families.reach.uniform_radius() {
            let tests = self.breaks && self.limits == LimitsFollow::Nothing;
            self.calm = Some(Calm::new(scene, reach, tests, 0)?);
        }
        let Some(Surface { correction, moduli }) = &self.surface else { return Ok(()) };
        let factors = match correction {
            SurfaceCorrection::Energy => surface::factors(scene, self, |point| moduli.at(point)),
            SurfaceCorrection::StiffnessTensor => {
                let (law, size) = (self.various(scene, None), scene.dimension as f64);
                // W = 1/4 sum c d s^2 L V is lambda/2 + mu at a strain of 1 along an axis.
                let weight = |point: usize, bond: Bond| {
                    let volume = scene.places[bond.neighbor][3];
                    0.5 * law.own_constant(point, bond) * volume * bond.length
                };
                let total = |point: usize, _| 2.0 / 3.0 * size * (size + 2.0) * moduli.at(point);
                surface_stiffness::factors(scene, weight, total)
            }
        }?;
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
        let various = self.various(scene, rule);
        let look = self.calm.as_ref().map(|calm| calm.look(scene));
        let resting = Resting::new(look.as_ref(), Some(1));
        let lattice = self.on_lattice(scene, rule, resting);
        let bad = match self.alike(scene, rule) {
            Some(law) => {
                let bonds = BondForces { law, lattice, constants: None, resting };
                forces(scene, &bonds, scratch, force, &mut breaking)
            }
            None => {
                let (law, constants) = (various, Some(&self.bond_constants));
                let bonds = BondForces { law, lattice, constants, resting };
                forces(scene, &bonds, scratch, force, &mut breaking)
            }
        };
        if let Some(breaking) = breaking
            && breaking.has_broken()
        {
            book(scene, various, breaking);
        }
        bad
    }

    fn energy_density(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        density: &mut [f64],
        part: EnergyPart,
    ) {
        if part == EnergyPart::Stabilization {
            density.fill(0.0);
            return;
        }
        match (self.alike(scene, None), scene.dimension) {
            (Some(law), 3) => energies::<3>(scene, law, scratch, density),
            (Some(law), _) => energies::<2>(scene, law, scratch, density),
            (None, 3) => energies::<3>(scene, self.various(scene, None), scratch, density),
            (None, _) => energies::<2>(scene, self.various(scene, None), scratch, density),
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
        &self.weights
    }

    fn spring_shape(&self, _: usize, length: f64) -> f64 {
        length.recip()
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
            + self.surface.as_ref().map_or(0, |surface| surface.moduli.bytes())
            + self.correction.as_ref().map_or(0, Correction::bytes)
            + self.weights.bytes()
            + self.laws.bytes()
            + self.lattice.as_ref().map_or(0, LatticeState::bytes)
            + self.calm.as_ref().map_or(0, Calm::bytes)
    }
}

fn forces(
    scene: &Scene<'_>,
    bonds: &BondForces<'_, impl BondLaw>,
    scratch: &mut [f64],
    force: &mut [f64],
    breaking: &mut Option<Breaking<'_>>,
) -> Option<usize> {
    match scene.dimension {
        3 => bonds.sweep::<3>(scene, scratch, force, breaking),
        _ => bonds.sweep::<2>(scene, scratch, force, breaking),
    }
}
