//! The total- and updated-Lagrangian forms of [B], by operators of undeformed or deformed bonds.
//!
//! With K = sum w xi xi^T V, N = sum w eta xi^T V, M = sum w eta eta^T V: undeformed bonds give F = N K^-1 and
//! t = w P K^-1 xi, which is correspondence, for both forms. Deformed bonds give F = M N^-T and
//! t = w P N^-1 eta = w J sigma M^-1 eta, which is not the slope of an energy. With divergence = strong the stress
//! is differentiated by collocation: b = sum w (P_j - P_i) K^-1 xi V or N^-1 eta, and in the updated form
//! b = J sum w (sigma_j - sigma_i) N^-T xi V or M^-1 eta.
//!
//! Where a family does not span the body, bonds count as undeformed (see `gradient`).

use super::body::{Body, Weights};
use super::constants;
use super::correspondence::{self, add};
use super::correspondence_lanes::PENALTY_ROW;
use super::gradient::Shape;
use super::kept_rows::KeptRows;
use super::kinematics::Kinematics;
use super::laws::{Laws, Sites};
use super::operators::Moments;
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::state_based::StateBased;
use super::{Formulation, FormulationEntry, Materials, Scene, in_lanes};
use crate::error::Result;
use crate::material::{Answer, Deformation};
use crate::tensor::{
    Tensor, Vector, applied, determinant, difference, inverse, product, read, scaled, transposed,
    zero,
};

const REFUSED: &[&str] =
    &["silling_coefficient", "surface_correction", "bond_horizon", "force_form", "gradient_order"];

pub(super) const TOTAL: FormulationEntry = FormulationEntry {
    name: "total_lagrangian",
    description: "total-Lagrangian form of state-based peridynamics (Bergel and Li)",
    refused_keys: REFUSED,
    check: constants::check_law,
    critical_stretch: constants::critical_stretch,
    prepare: |materials| prepare(materials, false),
};

pub(super) const UPDATED: FormulationEntry = FormulationEntry {
    name: "updated_lagrangian",
    description: "updated-Lagrangian form of state-based peridynamics (Bergel and Li)",
    refused_keys: REFUSED,
    check: constants::check_law,
    critical_stretch: constants::critical_stretch,
    prepare: |materials| prepare(materials, true),
};

pub(super) struct Lagrangian {
    pub(super) weights: Weights,
    pub(super) laws: Laws,
    updated: bool,
    pub(super) deformed: bool,
    pub(super) strong: bool,
    pub(super) kept: KeptRows,
}

fn prepare(materials: &Materials<'_>, updated: bool) -> Result<Box<dyn Formulation>> {
    let first = &materials.models[0];
    let (deformed, strong) = (first.has_deformed_bonds().unwrap_or(updated), first.is_strong());
    if !(deformed || strong) {
        return correspondence::plain(materials);
    }
    let weights = Weights::new(materials)?;
    let laws = Laws::new(materials, Sites::Points)?;
    let kept = KeptRows::default();
    let lagrangian = Lagrangian { weights, laws, updated, deformed, strong, kept };
    Ok(Box::new(StateBased::new(materials, lagrangian)?))
}

/// What a point makes of its family.
pub(super) struct Own<const D: usize> {
    pub(super) deformation: Deformation<D>,
    pub(super) answer: Answer<D>,
    /// What a bond is multiplied by for a gradient: of the undeformed one, and of the deformed one.
    pub(super) undeformed: Tensor<D>,
    pub(super) deformed: Tensor<D>,
}

impl Lagrangian {
    pub(super) fn own<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> Own<D> {
        self.own_of(body, point, &Moments::new(body, point))
    }

    /// The deformation of a point, and the shape of its family.
    pub(super) fn deformation_of<const D: usize>(
        &self,
        moments: &Moments<D>,
    ) -> (Deformation<D>, Shape<D>) {
        let Moments { reference, mixed, moved, moved_now, .. } = *moments;
        let shape = Shape::new(&reference);
        let gradient = if self.deformed && shape.rank == D {
            product(&moved_now, &inverse(&transposed(&mixed)))
        } else {
            product(&moved, &shape.inverse)
        };
        (Deformation { gradient, span: shape.span, rank: shape.rank }, shape)
    }

    pub(super) fn own_of<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        moments: &Moments<D>,
    ) -> Own<D> {
        let (deformation, shape) = self.deformation_of(moments);
        let (&Moments { mixed, now, .. }, spans) = (moments, shape.rank == D);
        let answer = self.laws.answer(body, point, point, &deformation);
        // In the weak form both forms pull alike; the operators differ in the strong one.
        let (undeformed, deformed) = match (self.deformed && spans, self.updated && self.strong) {
            (false, false) => (shape.inverse, zero()),
            (false, true) if spans => (transposed(&inverse(&mixed)), zero()),
            (false, true) => (shape.inverse, zero()),
            (true, false) => (zero(), inverse(&mixed)),
            (true, true) => (zero(), inverse(&now)),
        };
        Own { deformation, answer, undeformed, deformed }
    }

    pub(super) fn shown<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        own: &Own<D>,
    ) -> Kinematics {
        self.laws.kinematics(body, point, &own.deformation, &own.answer)
    }

    /// Leaves what bonds are multiplied by; with strong divergence stress and J too.
    pub(super) fn leave<const D: usize>(&self, own: &Own<D>, scratch: &mut [f64]) {
        let square = D * D;
        let pull = |operator: &Tensor<D>| {
            if self.strong { *operator } else { product(&own.answer.stress, operator) }
        };
        scratch[..square].copy_from_slice(pull(&own.undeformed).as_flattened());
        scratch[square..2 * square].copy_from_slice(pull(&own.deformed).as_flattened());
        if self.strong {
            let ratio = self.volume_ratio(own);
            let mut stress = own.answer.stress;
            if self.updated {
                // sigma = P F^T/J
                let full = transposed(&own.deformation.full());
                stress = scaled(&product(&stress, &full), 1.0 / ratio);
            }
            scratch[2 * square..3 * square].copy_from_slice(stress.as_flattened());
            scratch[3 * square] = ratio;
        }
    }

    /// J where it counts.
    fn volume_ratio<const D: usize>(&self, own: &Own<D>) -> f64 {
        let spans = own.deformation.rank == D;
        if self.updated && self.strong && spans {
            determinant(&own.deformation.full())
        } else {
            1.0
        }
    }
}

impl Passes for Lagrangian {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn has_potential(&self) -> bool {
        !(self.deformed || self.strong)
    }

    fn laws(&self) -> Option<&Laws> {
        Some(&self.laws)
    }

    fn each_site<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        _: &[f64],
        ask: &mut dyn FnMut(usize, &Deformation<D>),
    ) {
        ask(point, &self.deformation_of(&Moments::new(body, point)).0);
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        self.kept.refer_to(scene, &self.weights, 1)
    }

    fn room_of_lanes(&self, points: usize, _: usize, _: usize) -> usize {
        in_lanes::room_of_records(points) + points * PENALTY_ROW + in_lanes::SLACK
    }

    fn runs_in_lanes(&self, scene: &Scene<'_>) -> bool {
        self.kept.omega(scene, &self.weights).is_some()
    }

    /// Deformed bonds give F = I at rest but for rounding.
    fn rings(&self, dimension: usize) -> Option<u8> {
        (!self.deformed && self.laws.rest_without_stress(dimension))
            .then_some(correspondence::RINGS)
    }

    fn forces_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        self.swept_forces::<D>(sweep)
    }

    fn energy_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: EnergySweep<'_>,
    ) -> bool {
        self.swept_energy::<D>(sweep)
    }

    fn kinematics_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: FieldSweep<'_>,
    ) -> bool {
        self.swept_fields::<D>(sweep)
    }

    /// What bonds are multiplied by; with strong divergence stress and J too.
    fn width(&self, dimension: usize) -> usize {
        let square = dimension * dimension;
        if self.strong { 3 * square + 1 } else { 2 * square }
    }

    fn prepare_point<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &mut [f64],
    ) -> bool {
        let own = self.own(body, point);
        self.leave(&own, scratch);
        own.answer.energy.is_finite()
    }

    fn force_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Vector<D> {
        let (square, width) = (D * D, self.width(D));
        let of = |point: usize, number: usize| -> Tensor<D> {
            read(&scratch[point * width + number * square..])
        };
        let own = [of(point, 0), of(point, 1)];
        let mut force = [0.0; D];
        for link in body.links(point) {
            let bond = |operators: &[Tensor<D>; 2]| {
                let mut sum = applied(&operators[0], &link.reference);
                add(&mut sum, 1.0, &applied(&operators[1], &link.deformed()));
                sum
            };
            if self.strong {
                let apart = difference(&of(link.neighbor, 2), &of(point, 2));
                let ratio = scratch[point * width + 3 * square];
                add(&mut force, ratio * link.own * link.volume, &applied(&apart, &bond(&own)));
                continue;
            }
            let other = [of(link.neighbor, 0), of(link.neighbor, 1)];
            add(&mut force, link.own * link.volume, &bond(&own));
            add(&mut force, link.other * link.volume, &bond(&other));
        }
        force
    }

    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, _: &[f64]) -> f64 {
        self.own(body, point).answer.energy
    }

    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        _: &[f64],
    ) -> Kinematics {
        self.shown(body, point, &self.own(body, point))
    }

    fn is_degenerate<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> bool {
        Shape::new(&Moments::new(body, point).reference).rank < D
    }

    fn bytes(&self) -> usize {
        self.laws.bytes() + self.kept.bytes()
    }
}
