//! Ordinary state-based peridynamics, linear peridynamic solid (LPS). [P 3.14-3.20]
//!
//! m_i = sum w L^2 V_j, theta_i = (D/m_i) sum w L e V_j, e_d = e - theta_i L/D,
//! t_ij = w (D kappa theta_i L + C e_d)/m_i m^, W_i = kappa theta_i^2/2 + C/(2 m_i) sum w e_d^2 V_j;
//! kappa = K, C = 15 G in 3D, kappa = lambda + mu (of the plane state), C = 8 G in 2D.
//! With a yield stress it is `ordinary_plastic`.

use super::body::{Body, ByModel, Link, Weights};
use super::bond_laws::{Limits, close_to};
use super::constants;
use super::correspondence::add;
use super::on_lattice::{LatticeState, OnLattice, Parts};
use super::passes::{Passes, Room};
use super::state_based::StateBased;
use super::{
    Formulation, FormulationEntry, Kinematics, Materials, Scene, in_lanes, ordinary_plastic,
};
use crate::damage::Breaking;
use crate::error::{Error, Result};
use crate::families::LANES;
use crate::kernel::family::{Omega, Record};
use crate::kernel::lattice::{Breaks, DilationSweep, Lps as Moduli, TensionSweep};
use crate::kernel::ordinary_state_based::{OtherPull, OwnPull};
use crate::material::Law;
use crate::model::Model;
use crate::tensor::{Vector, dot};
use crate::workers::PerPoint;
use std::sync::atomic::{AtomicUsize, Ordering};

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
    weights: Weights,
    /// kappa and C.
    pub(super) moduli: ByModel<[f64; 2]>,
    /// lambda/2 + mu, where the surface is to be corrected.
    pub(super) corrected: Option<ByModel<f64>>,
    /// For what lies across; bonds do not ask it.
    pub(super) laws: ByModel<Law>,
    /// What sweeps over a lattice hold, where the body is one.
    lattice: Option<LatticeState>,
}

fn prepare(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    let dimension = materials.dimension;
    let moduli = ByModel::new(materials, |model| {
        let factor = if dimension == 3 { 15.0 } else { 8.0 };
        let shear = model.elastic()?.shear_modulus;
        Ok([constants::bulk_modulus(model, dimension)?, factor * shear])
    })?;
    let corrected = if materials.models[0].corrects_surface() {
        Some(ByModel::new(materials, |model| constants::half_lambda_and_mu(model, dimension))?)
    } else {
        None
    };
    let laws = ByModel::new(materials, |model| Law::new(model, dimension))?;
    let lps = Lps { weights: Weights::new(materials)?, moduli, corrected, laws, lattice: None };
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

    fn swept<const D: usize>(
        &self,
        scene: &Scene<'_>,
        room: Room<'_>,
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> Option<usize> {
        let (omega, count) = (in_lanes::omega(scene, &self.weights)?, scene.places.len());
        if let (Some(lattice), Some(state)) = (&scene.families.lattice, &self.lattice) {
            let rule = breaking.as_ref().map(|breaking| breaking.rule);
            let critical = rule.and_then(|rule| rule.uniform()).unwrap_or(f64::INFINITY);
            let (threshold, limits) = (close_to(critical), Limits { scene, rule });
            let on = OnLattice { lattice, state, threshold, limits };
            return self.swept_on_lattice::<D>(scene, omega, &on, force, breaking);
        }
        let (records, rest) = in_lanes::table(room.tables, count);
        let (left, _) = in_lanes::table(rest, count);
        in_lanes::record::<D>(scene, records);
        let family = in_lanes::family(scene, records, omega);
        let moduli = |point: usize| *self.moduli.at(point);
        let (masks, limits) = in_lanes::masks(scene, breaking);
        let outputs = (PerPoint(&mut *force, D), PerPoint(&mut *left, 1), masks);
        scene.workers.sweep(count, outputs, |range, (force, left, masks)| {
            let breaking = masks
                .zip(limits)
                .map(|(masks, limits)| in_lanes::break_here(scene, range.start, masks, limits));
            let (force, left) = (force.0, left.0);
            scene.simd.run(OwnPull::<_, D> { family, moduli, range, force, left, breaking });
        });
        let scene = &in_lanes::remaining(scene, breaking);
        let family = in_lanes::family(scene, left, omega);
        let bad = AtomicUsize::new(usize::MAX);
        scene.workers.sweep(count, PerPoint(force, D), |range, force| {
            let sweep = OtherPull::<D> { family, range, force: force.0 };
            if let Some(point) = scene.simd.run(sweep) {
                bad.fetch_min(point, Ordering::Relaxed);
            }
        });
        in_lanes::first(bad)
    }
}

impl Lps {
    fn swept_on_lattice<const D: usize>(
        &self,
        scene: &Scene<'_>,
        omega: Omega,
        on: &OnLattice<'_>,
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> Option<usize> {
        let [kappa, deviatoric] = *self.moduli.at(0);
        let moduli = Moduli { kappa, deviatoric };
        let influence = |length: f64| omega.influence.value(D, length, omega.horizon);
        let first = |parts: &mut Parts<'_, D, 2>| {
            let (groups, look, judge) = (parts.groups, parts.look, on.limits);
            let outputs = (parts.left.again(), parts.masks.again(), parts.broke.again());
            scene.workers.sweep(parts.seats, outputs, |range, (left, masks, broke)| {
                let breaks = Breaks { masks: masks.0, broke: broke.0, judge, look };
                let range = range.start / LANES..range.end / LANES;
                let (first, left) = (left.first, left.values);
                scene.simd.run(DilationSweep { groups, moduli, range, first, left, breaks });
            });
        };
        let second = |parts: Parts<'_, D, 2>, _: &Scene<'_>| {
            let Parts { groups, seats, unit, masks, forces, left, .. } = parts;
            let left = left.values.map(|column| &*column);
            scene.workers.sweep(seats, (forces, masks), |range, (force, masks)| {
                let range = range.start / LANES..range.end / LANES;
                let (force, masks) = (force.0, &*masks.0);
                scene.simd.run(TensionSweep { groups, left, range, masks, force });
            });
            unit.recip()
        };
        let remaining = breaking.as_mut().map(|breaking| {
            breaking.intact.copy_from_slice(scene.bonds.intact);
            &mut *breaking.intact
        });
        let bad = on.sweep(scene, influence, first, second, force, remaining);
        (bad != usize::MAX).then_some(bad)
    }
}

impl Passes for Lps {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn corrected_modulus(&self, point: usize) -> Option<f64> {
        self.corrected.as_ref().map(|moduli| *moduli.at(point))
    }

    fn correct(&mut self, factors: Vec<f64>) {
        self.weights.correction = Some(factors);
    }

    fn has_use_for_a_lattice(&self) -> bool {
        let alike = self.moduli.only().is_some() && self.weights.are_uniform();
        alike && self.corrected.is_none()
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        if let Some(lattice) = &scene.families.lattice {
            self.lattice = Some(LatticeState::new(scene, lattice, 2)?);
        }
        Ok(())
    }

    fn room_of_lanes(&self, points: usize, _: usize) -> usize {
        2 * points * size_of::<Record>() / size_of::<f64>() + 2 * in_lanes::SLACK
    }

    fn runs_in_lanes(&self, scene: &Scene<'_>) -> bool {
        in_lanes::omega(scene, &self.weights).is_some()
    }

    fn forces_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        scene: &Scene<'_>,
        room: Room<'_>,
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> Option<usize> {
        self.swept::<D>(scene, room, force, breaking)
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
        let inverse = if weighted > 0.0 { 1.0 / weighted } else { 0.0 };
        scratch[0] = inverse;
        scratch[1] = D as f64 * inverse * sum;
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
        self.laws.bytes() + self.moduli.bytes() + lattice
    }
}
