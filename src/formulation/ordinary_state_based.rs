//! Ordinary state-based peridynamics, linear peridynamic solid (LPS). [P 3.14-3.20]
//!
//! m_i = sum w L^2 V_j, theta_i = (D/m_i) sum w L e V_j, e_d = e - theta_i L/D,
//! t_ij = w (D kappa theta_i L + C e_d)/m_i m^, W_i = kappa theta_i^2/2 + C/(2 m_i) sum w e_d^2 V_j;
//! kappa = K, C = 15 G in 3D, kappa = lambda + mu (of the plane state), C = 8 G in 2D.
//! With a yield stress it is `ordinary_plastic`.

use super::body::{Body, ByModel, Link, Weights};
use super::constants;
use super::correspondence::add;
use super::on_lattice::LatticeState;
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::state_based::StateBased;
use super::surface::Surface;
use super::{
    Formulation, FormulationEntry, Kinematics, Materials, Scene, extension_lanes, in_lanes,
    ordinary_plastic,
};
use crate::error::{Error, Result};
use crate::families::lattice::LatticeUse;
use crate::material::Law;
use crate::model::Model;
use crate::tensor::{Vector, dot};

pub(super) const ENTRY: FormulationEntry = FormulationEntry {
    name: "ordinary_state_based",
    description: "ordinary state-based, linear peridynamic solid (LPS): any Poisson's ratio",
    refused_keys: &[
        "material",
        "hardening_modulus",
        "silling_coefficient",
        "bond_horizon",
        "force_form",
        "operator_bonds",
        "gradient_order",
        "divergence",
    ],
    check,
    critical_stretch: constants::critical_stretch,
    prepare,
};

fn check(model: &Model, dimension: usize) -> Result<()> {
    if dimension != 3 && model.number("yield_stress").is_some() {
        return Err(Error::Unsupported(
            "'yield_stress' of ordinary_state_based is for 3D: in 2D its yield surface is not that of the \
             plane state; the correspondence kind takes j2_plastic there"
                .into(),
        ));
    }
    constants::check_law(model, dimension)
}

pub(super) struct Lps {
    pub(super) weights: Weights,
    /// kappa and C.
    pub(super) moduli: ByModel<[f64; 2]>,
    /// Where the surface is to be corrected.
    pub(super) surface: Option<Surface<ByModel<f64>>>,
    /// For what lies across; bonds do not ask it.
    pub(super) laws: ByModel<Law>,
    /// What sweeps over a lattice hold, where the body has one.
    pub(super) lattice: Option<LatticeState>,
}

fn prepare(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    let dimension = materials.dimension;
    let moduli = ByModel::new(materials, |model| {
        let factor = if dimension == 3 { 15.0 } else { 8.0 };
        let shear = model.elastic()?.shear_modulus;
        Ok([constants::bulk_modulus(model, dimension)?, factor * shear])
    })?;
    let surface = if let Some(correction) = materials.models[0].surface_correction() {
        let modulus = |model: &Model| constants::half_lambda_and_mu(model, dimension);
        Some(Surface { correction, moduli: ByModel::new(materials, modulus)? })
    } else {
        None
    };
    let laws = ByModel::new(materials, |model| Law::new(model, dimension))?;
    let lps = Lps { weights: Weights::new(materials)?, moduli, surface, laws, lattice: None };
    if materials.models.iter().any(|model| model.number("yield_stress").is_some()) {
        return ordinary_plastic::prepare(materials, lps);
    }
    Ok(Box::new(StateBased::new(materials, lps)?))
}

/// e = l - L without the cancellation, and the deformed length.
pub(super) fn extension<const D: usize>(link: &Link<D>) -> (f64, f64) {
    let now = link.deformed();
    let length = dot(&now, &now).sqrt();
    let both: Vector<D> = std::array::from_fn(|axis| link.reference[axis] + now[axis]);
    (dot(&link.moved, &both) / (link.length + length), length)
}

/// Force on a point of bonds that pull along themselves; `tension`: |t_ij| + |t_ji| and the deformed length of each.
#[inline(always)]
pub(super) fn pulled<const D: usize>(
    body: &Body<'_, D>,
    point: usize,
    tension: impl Fn(&Link<D>) -> (f64, f64),
) -> Vector<D> {
    let mut force = [0.0; D];
    for link in body.links(point) {
        let (tension, now) = tension(&link);
        if now > 0.0 {
            add(&mut force, tension * link.volume / now, &link.deformed());
        }
    }
    force
}

impl Lps {
    /// |t_ij| + |t_ji| of a bond, and its deformed length; `scratch`: what the first pass has left.
    #[inline(always)]
    fn tension<const D: usize>(&self, point: usize, link: &Link<D>, scratch: &[f64]) -> (f64, f64) {
        let dimension = D as f64;
        let (extension, now) = extension(link);
        // |t| of a point, over w.
        let pull = |point: usize| {
            let (inverse, theta) = (scratch[2 * point], scratch[2 * point + 1]);
            let [kappa, deviatoric] = *self.moduli.at(point);
            let rest = extension - theta * link.length / dimension;
            inverse * (dimension * kappa * theta * link.length + deviatoric * rest)
        };
        (link.own * pull(point) + link.other * pull(link.neighbor), now)
    }

    /// a and b of t = w (a s + b) L, and theta.
    fn pulls<const D: usize>(&self, point: usize, sums: [f64; 2]) -> [f64; 3] {
        let (dimension, [inverse, theta]) = (D as f64, Self::state::<D>(sums));
        let [kappa, deviatoric] = *self.moduli.at(point);
        let a = inverse * deviatoric;
        [a, inverse * theta * (dimension * kappa - deviatoric / dimension), theta]
    }

    pub(super) fn ab<const D: usize>(&self, point: usize, sums: [f64; 2]) -> [f64; 2] {
        let [a, b, _] = self.pulls::<D>(point, sums);
        [a, b]
    }

    /// 1/m (0 without a family) and theta, from m and sum w L e V.
    fn state<const D: usize>([weighted, sum]: [f64; 2]) -> [f64; 2] {
        let inverse = if weighted > 0.0 { 1.0 / weighted } else { 0.0 };
        [inverse, D as f64 * inverse * sum]
    }
}

impl Passes for Lps {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn surface(&self) -> Option<&Surface<ByModel<f64>>> {
        self.surface.as_ref()
    }

    fn use_of_a_lattice(&self) -> LatticeUse {
        let fits = self.weights.are_shared() && self.surface.is_none();
        if fits { LatticeUse::Groups } else { LatticeUse::None }
    }

    fn models_differ(&self) -> Option<bool> {
        Some(self.moduli.differ())
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        if let Some(lattice) = &scene.families.lattice {
            self.lattice = Some(LatticeState::new(scene, lattice, 2)?);
        }
        Ok(())
    }

    fn room_of_lanes(&self, points: usize, _: usize, _: usize) -> usize {
        extension_lanes::room(points)
    }

    fn room_of_energies(&self, points: usize, _: usize) -> usize {
        in_lanes::room_of_records(points)
    }

    fn runs_in_lanes(&self, scene: &Scene<'_>) -> bool {
        in_lanes::omega(scene, &self.weights).is_some()
    }

    fn rings(&self, _: usize) -> Option<u8> {
        Some(extension_lanes::RINGS)
    }

    fn forces_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        if let (Some(lattice), Some(state)) = (sweep.scene.lattice(), &self.lattice) {
            return self.forces_on_lattice::<D>((lattice, state), sweep);
        }
        let pulls = |point: usize, sums: [f64; 2]| self.ab::<D>(point, sums);
        extension_lanes::forces::<D, false>(sweep, &self.weights, pulls)
    }

    fn energy_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: EnergySweep<'_>,
    ) -> bool {
        let energy = |point: usize, sums: [f64; 2], squares: f64| {
            let [inverse, theta] = Self::state::<D>(sums);
            let [kappa, deviatoric] = *self.moduli.at(point);
            // sum w e_d^2 V/m
            let sheared = squares * inverse - (theta / D as f64).powi(2);
            0.5 * (kappa * theta * theta + deviatoric * sheared)
        };
        extension_lanes::energies::<D, false>(sweep, &self.weights, energy)
    }

    fn kinematics_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: FieldSweep<'_>,
    ) -> bool {
        let pulls = |point: usize, sums: [f64; 2]| self.pulls::<D>(point, sums);
        extension_lanes::fields::<D, false>(sweep, &self.weights, &self.laws, pulls)
    }

    /// 1/m (0 without a family) and theta.
    fn width(&self, _: usize) -> usize {
        2
    }

    fn prepare_point<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &mut [f64],
    ) -> bool {
        let (mut weighted, mut sum) = (0.0, 0.0);
        for link in body.links(point) {
            let factor = link.own * link.length * link.volume;
            weighted += factor * link.length;
            sum += factor * extension(&link).0;
        }
        scratch.copy_from_slice(&Self::state::<D>([weighted, sum]));
        true
    }

    fn force_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Vector<D> {
        pulled(body, point, |link| self.tension(point, link, scratch))
    }

    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, _: &[f64]) -> f64 {
        let mut state = [0.0; 2];
        self.prepare_point(body, point, &mut state);
        let [inverse, theta] = state;
        let [kappa, deviatoric] = *self.moduli.at(point);
        let mut sum = 0.0;
        for link in body.links(point) {
            let rest = extension(&link).0 - theta * link.length / D as f64;
            sum += link.own * rest * rest * link.volume;
        }
        0.5 * kappa * theta * theta + 0.5 * deviatoric * inverse * sum
    }

    fn kinematics_need_pass(&self) -> bool {
        true
    }

    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Kinematics {
        let tension = |link: &Link<D>| self.tension(point, link, scratch);
        let dilatation = scratch[2 * point + 1];
        Kinematics { dilatation, ..Kinematics::of_bonds(body, point, self.laws.at(point), tension) }
    }

    fn bytes(&self) -> usize {
        let lattice = self.lattice.as_ref().map_or(0, LatticeState::bytes);
        let surface = self.surface.as_ref().map_or(0, |surface| surface.moduli.bytes());
        self.laws.bytes() + self.moduli.bytes() + surface + lattice
    }
}
