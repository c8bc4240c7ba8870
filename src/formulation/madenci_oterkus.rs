//! Ordinary state-based peridynamics by Madenci and Oterkus, in 3D. [M]
//!
//! With w = d delta/L: theta_i = d sum w e V_j, W_i = a theta^2 + b sum w e^2 V_j, t = 2 w (a d theta_i + b e) m^,
//! a = (K - 5 mu/3)/2, b = 15 mu/(2 pi delta^5), d = 9/(4 pi delta^4). The factor m^.n of the source
//! is 1: with it the model is neither objective nor consistent with its energy.

use std::f64::consts::PI;

use super::body::{Body, ByModel, Link, Weights};
use super::constants;
use super::ordinary_state_based::{extension, pulled};
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::state_based::StateBased;
use super::{
    Formulation, FormulationEntry, Kinematics, Materials, Scene, extension_lanes, in_lanes,
};
use crate::error::{Error, Result};
use crate::families::Property;
use crate::material::Law;
use crate::model::{Influence, Model};
use crate::tensor::Vector;

pub(super) const ENTRY: FormulationEntry = FormulationEntry {
    name: "madenci_oterkus",
    description: "ordinary state-based by Madenci and Oterkus: constants of the full ball, 3D",
    refused_keys: &[
        "influence",
        "material",
        "yield_stress",
        "hardening_modulus",
        "silling_coefficient",
        "surface_correction",
        "bond_horizon",
        "force_form",
        "operator_bonds",
        "gradient_order",
        "divergence",
    ],
    check: |model, dimension| {
        if dimension == 3 {
            return constants::check_law(model, dimension);
        }
        Err(Error::Unsupported(
            "madenci_oterkus is for 3D; in 2D ordinary_state_based takes any Poisson's ratio"
                .into(),
        ))
    },
    critical_stretch,
    prepare,
};

/// The stretch at which opening a unit of crack takes the energy `rate`: at isotropic stretch s a bond holds
/// psi = 2 w (3 a d s + b e) e, and pi int psi xi^3 = (27 K + 3 mu)/16 delta s^2.
fn critical_stretch(model: &Model, _: usize, horizon: f64, rate: f64) -> Result<f64> {
    let elastic = model.elastic()?;
    let per_square = (27.0 * elastic.bulk_modulus + 3.0 * elastic.shear_modulus) / 16.0 * horizon;
    constants::usable((rate / per_square).sqrt(), horizon)
}

struct MadenciOterkus {
    weights: Weights,
    /// a and mu.
    moduli: ByModel<[f64; 2]>,
    /// For what lies across; bonds do not ask it.
    laws: ByModel<Law>,
    /// d
    scale: Property,
}

fn prepare(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    let moduli = ByModel::new(materials, |model| {
        let elastic = model.elastic()?;
        let mu = elastic.shear_modulus;
        Ok([0.5 * (elastic.bulk_modulus - 5.0 * mu / 3.0), mu])
    })?;
    let scale =
        materials.property(|_, horizon| Ok(9.0 / (4.0 * PI * horizon.powi(4))), "dilatations")?;
    let weights = Weights::with(materials, |_| Ok(Influence::Inverse))?;
    let laws = ByModel::new(materials, |model| Law::new(model, materials.dimension))?;
    Ok(Box::new(StateBased::new(materials, MadenciOterkus { weights, moduli, laws, scale })?))
}

impl MadenciOterkus {
    /// a, b and d of a point.
    fn constants(&self, point: usize) -> [f64; 3] {
        let [a, mu] = *self.moduli.at(point);
        [a, 15.0 * mu / (2.0 * PI * self.weights.horizons.at(point).powi(5)), self.scale.at(point)]
    }

    /// What bonds pull by the stretch and by the dilatation, and that.
    fn pulls(&self, point: usize, [_, sum]: [f64; 2]) -> [f64; 3] {
        let [a, b, d] = self.constants(point);
        [2.0 * b, 2.0 * a * d * d * sum, d * sum]
    }

    fn dilatation<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> f64 {
        let terms = body.links(point).map(|link| link.own * extension(&link).0 * link.volume);
        self.scale.at(point) * terms.sum::<f64>()
    }

    /// |t_ij| + |t_ji| of a bond, and its deformed length; `scratch`: what the first pass has left.
    #[inline(always)]
    fn tension<const D: usize>(&self, point: usize, link: &Link<D>, scratch: &[f64]) -> (f64, f64) {
        let (extension, now) = extension(link);
        // |t| of a point, over w.
        let pull = |point: usize| {
            let [a, b, d] = self.constants(point);
            2.0 * (a * d * scratch[point] + b * extension)
        };
        (link.own * pull(point) + link.other * pull(link.neighbor), now)
    }
}

impl Passes for MadenciOterkus {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn room_of_lanes(&self, points: usize, _: usize, _: usize) -> usize {
        extension_lanes::room(points)
    }

    fn runs_in_lanes(&self, scene: &Scene<'_>) -> bool {
        in_lanes::omega(scene, &self.weights).is_some()
    }

    fn rings(&self, _: usize) -> Option<u8> {
        Some(extension_lanes::RINGS)
    }

    /// t = w (2 b s + 2 a d theta/L) L, with theta = d sum w L s V.
    fn forces_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        let pulls = |point: usize, sums: [f64; 2]| {
            let [a, b, _] = self.pulls(point, sums);
            [a, b]
        };
        extension_lanes::forces::<D, true>(sweep, &self.weights, pulls)
    }

    fn energy_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: EnergySweep<'_>,
    ) -> bool {
        let energy = |point: usize, [_, sum]: [f64; 2], squares: f64| {
            let [a, b, d] = self.constants(point);
            a * (d * sum).powi(2) + b * squares
        };
        extension_lanes::energies::<D, true>(sweep, &self.weights, energy)
    }

    fn kinematics_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: FieldSweep<'_>,
    ) -> bool {
        let pulls = |point: usize, sums: [f64; 2]| self.pulls(point, sums);
        extension_lanes::fields::<D, true>(sweep, &self.weights, &self.laws, pulls)
    }

    /// theta
    fn width(&self, _: usize) -> usize {
        1
    }

    fn prepare_point<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &mut [f64],
    ) -> bool {
        scratch[0] = self.dilatation(body, point);
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
        let [a, b, _] = self.constants(point);
        let theta = self.dilatation(body, point);
        let squares = body.links(point).map(|link| {
            let extension = extension(&link).0;
            link.own * extension * extension * link.volume
        });
        a * theta * theta + b * squares.sum::<f64>()
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
        let dilatation = scratch[point];
        Kinematics { dilatation, ..Kinematics::of_bonds(body, point, self.laws.at(point), tension) }
    }

    fn bytes(&self) -> usize {
        self.laws.bytes() + self.moduli.bytes() + self.scale.bytes()
    }
}
