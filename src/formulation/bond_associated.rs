//! Bond-associated correspondence: a deformation gradient of its own for each bond, from the part of the
//! family near its other end. [P 4.15-4.20; D]
//!
//! Family of bond ij: h = { k in H_i : |X_k - X_j| <= bond_horizon }, j included. F_b and K_b over h as for
//! correspondence, phi_b = V(h_b)/sum V(h), W_i = sum_b phi_b W(F_b),
//! t_ik = sum_{b: k in h_b} phi_b w_k P_b K_b^-1 xi_k. With force_form = literal the force of [P 4.20] as
//! printed, t_ib = V(h_b)/V(H_i) w_b P_b K_b^-1 xi_b, which is not the slope of an energy.

use super::body::{Body, Link, Weights};
use super::constants;
use super::correspondence::add;
use super::gradient::Shape;
use super::kinematics::Kinematics;
use super::laws::{Laws, Sites};
use super::passes::Passes;
use super::state_based::StateBased;
use super::{Formulation, FormulationEntry, Materials};
use crate::error::Result;
use crate::families::{LANES, Property};
use crate::material::{Answer, Deformation};
use crate::tensor::{Tensor, Vector, add_outer, applied, product, scaled, zero};

pub(super) const ENTRY: FormulationEntry = FormulationEntry {
    name: "bond_associated",
    description: "bond-associated correspondence: a deformation gradient of its own for each bond",
    refused_keys: &[
        "silling_coefficient",
        "surface_correction",
        "gradient_order",
        "divergence",
        "operator_bonds",
    ],
    check: constants::check_law,
    critical_stretch: constants::critical_stretch,
    prepare,
};

/// Whole multiples of the spacing are within reach in spite of rounding.
const REACH: f64 = 1.0 + 1e-10;

struct BondAssociated {
    weights: Weights,
    laws: Laws,
    /// Square of the bonds' own horizon.
    reach: Property,
    literal: bool,
}

fn prepare(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    let reach = materials.property(
        |model, horizon| Ok((model.number("bond_horizon").unwrap_or(horizon) * REACH).powi(2)),
        "horizons of bonds",
    )?;
    let bond_associated = BondAssociated {
        weights: Weights::new(materials)?,
        laws: Laws::new(materials, Sites::Lanes)?,
        reach,
        literal: materials.models[0].is_literal(),
    };
    Ok(Box::new(StateBased::new(materials, bond_associated)?))
}

/// The family of a bond.
struct Associated<const D: usize> {
    shape: Shape<D>,
    deformation: Deformation<D>,
    answer: Answer<D>,
    /// V(h)
    volume: f64,
}

impl BondAssociated {
    /// The bonds of a point's own family that are not broken.
    fn own<'a, const D: usize>(
        body: &Body<'a, D>,
        point: usize,
    ) -> impl Iterator<Item = Link<D>> + use<'a, D> {
        let families = body.scene.families;
        body.links(point).filter(move |link| families.owns(point, link.bond()))
    }

    /// Those of them in the family of a bond.
    fn near<'a, const D: usize>(
        &self,
        body: &Body<'a, D>,
        point: usize,
        bond: &Link<D>,
    ) -> impl Iterator<Item = Link<D>> + use<'a, D> {
        let (reach, end) = (self.reach.at(point), bond.reference);
        Self::own(body, point).filter(move |link| {
            let apart = link.reference.iter().zip(&end).map(|(x, end)| (x - end) * (x - end));
            apart.sum::<f64>() <= reach
        })
    }

    fn associated<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        bond: &Link<D>,
    ) -> Associated<D> {
        let (mut tensor, mut moved, mut volume) = (zero(), zero(), 0.0);
        for link in self.near(body, point, bond) {
            let factor = link.own * link.volume;
            add_outer(&mut tensor, factor, &link.reference, &link.reference);
            add_outer(&mut moved, factor, &link.moved, &link.reference);
            volume += link.share * link.volume;
        }
        let shape = Shape::new(&tensor);
        let gradient = product(&moved, &shape.inverse);
        let deformation = Deformation { gradient, span: shape.span, rank: shape.rank };
        let answer = self.laws.answer(body, point, bond.slot, &deformation);
        Associated { shape, deformation, answer, volume }
    }

    /// sum_b V(h_b), or with the literal force V(H).
    fn share<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> f64 {
        let own = |bond: Link<D>| -> f64 {
            if self.literal {
                return bond.share * bond.volume;
            }
            self.near(body, point, &bond).map(|link| link.share * link.volume).sum()
        };
        Self::own(body, point).map(own).sum()
    }
}

impl Passes for BondAssociated {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn has_potential(&self) -> bool {
        !self.literal
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
        for bond in Self::own(body, point) {
            ask(bond.slot, &self.associated(body, point, &bond).deformation);
        }
    }

    fn width(&self, _: usize) -> usize {
        0
    }

    fn prepare_point<const D: usize>(&self, _: &Body<'_, D>, _: usize, _: &mut [f64]) -> bool {
        true
    }

    fn force_at<const D: usize>(&self, _: &Body<'_, D>, _: usize, _: &[f64]) -> Vector<D> {
        [0.0; D]
    }

    /// The force state of each bond.
    fn lane_width(&self, dimension: usize) -> usize {
        dimension
    }

    fn prepare_lanes<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        lanes: &mut [f64],
    ) -> bool {
        lanes.fill(0.0);
        let (states, _) = lanes.as_chunks_mut::<D>();
        let first = body.scene.families.blocks(point).start * LANES;
        let whole = self.share(body, point);
        let mut sound = true;
        for bond in Self::own(body, point) {
            let at = self.associated(body, point, &bond);
            sound &= at.answer.energy.is_finite();
            let pull: Tensor<D> =
                scaled(&product(&at.answer.stress, &at.shape.inverse), at.volume / whole);
            if self.literal {
                let state = &mut states[bond.slot - first];
                add(state, bond.own, &applied(&pull, &bond.reference));
                continue;
            }
            for link in self.near(body, point, &bond) {
                let state = &mut states[link.slot - first];
                add(state, link.own, &applied(&pull, &link.reference));
            }
        }
        sound
    }

    fn force_from_lanes<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        lanes: &[f64],
    ) -> Vector<D> {
        let (states, _) = lanes.as_chunks::<D>();
        let mut force = [0.0; D];
        for link in body.links(point) {
            add(&mut force, link.volume, &states[link.slot]);
            if let Some(back) = body.scene.families.slot(link.neighbor, point) {
                add(&mut force, -link.volume, &states[back]);
            }
        }
        force
    }

    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, _: &[f64]) -> f64 {
        let whole: f64 = Self::own(body, point)
            .map(|bond| {
                self.near(body, point, &bond).map(|link| link.share * link.volume).sum::<f64>()
            })
            .sum();
        let terms = Self::own(body, point).map(|bond| {
            let at = self.associated(body, point, &bond);
            at.volume * at.answer.energy
        });
        let sum: f64 = terms.sum();
        if whole > 0.0 { sum / whole } else { 0.0 }
    }

    /// The mean over the bonds, by the volumes of their families.
    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        _: &[f64],
    ) -> Kinematics {
        let bonds = Self::own(body, point).map(|bond| {
            let at = self.associated(body, point, &bond);
            let across = self.laws.across(body, point, bond.slot, &at.deformation);
            let plastic = self.laws.plastic(body, point, bond.slot);
            let made = Kinematics::new(&at.deformation, &at.answer.stress, across);
            (at.volume, made.with_plastic(plastic))
        });
        Kinematics::mean(bonds)
    }

    /// Where the family of one of its bonds does not span the body.
    fn is_degenerate<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> bool {
        let mut bonds = Self::own(body, point);
        bonds.any(|bond| self.associated(body, point, &bond).shape.rank < D)
    }

    fn bytes(&self) -> usize {
        self.laws.bytes() + self.reach.bytes()
    }
}
