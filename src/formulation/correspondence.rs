//! Correspondence: a material law at the family's own deformation gradient. [P 3.31-3.53; G]
//!
//! F_i = I + sum w du G_ij^T V_j with G_ij = K_i^-1 xi (with gradient_order 2 that of the reproducing
//! kernel), W_i = W(F_i), t_ij = w P(F_i) G_ij. Modes that F does not see cost nothing; the stabilised forms
//! charge z = eta - F xi: Silling's t += w beta z, beta = C_s (C_b/delta) sum V/omega0 [P 4.11], and Wan's
//! t += w C1 z, C1 = lambda tr(K^-1) I + 2 mu K^-1 [P 4.13].

use std::f64::consts::PI;

use super::body::{Body, Link, Weights};
use super::constants;
use super::correspondence_lanes::PENALTY_ROW;
use super::gradient::{Gradient, MOST, monomials, width};
use super::kept_rows::KeptRows;
use super::lattice_rows::LatticeRows;
use super::laws::{Laws, Sites};
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::state_based::StateBased;
use super::{Formulation, FormulationEntry, Kinematics, Materials, Scene, in_lanes};
use crate::error::Result;
use crate::families::Property;
use crate::families::lattice::LatticeUse;
use crate::material::{Answer, Deformation};
use crate::tensor::{
    Tensor, Vector, add_outer, applied, difference, dot, identity, product, read, scaled, sum,
    trace, zero,
};

/// A force comes from the families of the point and of its neighbours.
pub(super) const RINGS: u8 = 2;

pub(super) const ENTRY: FormulationEntry = FormulationEntry {
    name: "correspondence",
    description: "correspondence: a material law at the family's own deformation gradient",
    refused_keys: &[
        "silling_coefficient",
        "surface_correction",
        "bond_horizon",
        "force_form",
        "operator_bonds",
    ],
    check: constants::check_law,
    critical_stretch: constants::critical_stretch,
    prepare: plain,
};

pub(super) const SILLING: FormulationEntry = FormulationEntry {
    name: "correspondence_silling",
    description: "correspondence, with a penalty on what the deformation gradient does not see (Silling)",
    refused_keys: &[
        "surface_correction",
        "bond_horizon",
        "force_form",
        "operator_bonds",
        "gradient_order",
        "divergence",
    ],
    check: constants::check_law,
    critical_stretch: constants::critical_stretch,
    prepare: |materials| prepare(materials, Stabilisation::Silling),
};

pub(super) const WAN: FormulationEntry = FormulationEntry {
    name: "correspondence_wan",
    description: "correspondence, with a penalty of the material's own stiffness (Wan)",
    refused_keys: &[
        "silling_coefficient",
        "surface_correction",
        "bond_horizon",
        "force_form",
        "operator_bonds",
        "gradient_order",
        "divergence",
    ],
    check: constants::check_law,
    critical_stretch: constants::critical_stretch,
    prepare: |materials| prepare(materials, Stabilisation::Wan),
};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stabilisation {
    None,
    Silling,
    Wan,
}

pub(super) struct Correspondence {
    pub(super) weights: Weights,
    pub(super) laws: Laws,
    stabilisation: Stabilisation,
    /// C_s C_b / delta.
    penalty: Property,
    pub(super) order: usize,
    pub(super) strong: bool,
    pub(super) kept: KeptRows,
    /// What sweeps over a lattice hold, where the body has one.
    lattice: Option<LatticeRows>,
}

/// Without a penalty.
pub(super) fn plain(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    prepare(materials, Stabilisation::None)
}

fn prepare(
    materials: &Materials<'_>,
    stabilisation: Stabilisation,
) -> Result<Box<dyn Formulation>> {
    let penalty = materials.property(
        |model, horizon| {
            let coefficient = model.number("silling_coefficient").unwrap_or(0.0);
            let bulk = model.elastic()?.bulk_modulus;
            Ok(coefficient * 18.0 * bulk / (PI * horizon.powi(5)))
        },
        "penalties",
    )?;
    let first = &materials.models[0];
    let correspondence = Correspondence {
        weights: Weights::new(materials)?,
        laws: Laws::new(materials, Sites::Points)?,
        stabilisation,
        penalty,
        order: first.gradient_order(),
        strong: stabilisation == Stabilisation::None && first.is_strong(),
        kept: KeptRows::default(),
        lattice: None,
    };
    Ok(Box::new(StateBased::new(materials, correspondence)?))
}

/// What a point knows of its family.
pub(super) struct Own<const D: usize> {
    pub(super) gradient: Gradient<D>,
    deformation: Deformation<D>,
    pub(super) answer: Answer<D>,
    /// sum w V and sum V.
    weight: f64,
    volume: f64,
}

impl Correspondence {
    pub(super) fn own<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> Own<D> {
        let (gradient, displacement_gradient, weight, volume) =
            gradient_at(body, point, self.order);
        let Gradient { shape, .. } = gradient;
        let deformation =
            Deformation { gradient: displacement_gradient, span: shape.span, rank: shape.rank };
        let answer = self.laws.answer(body, point, point, &deformation);
        Own { gradient, deformation, answer, weight, volume }
    }

    /// C of the penalty 1/2 z.C z, from K^-1 and sum V/sum w V.
    pub(super) fn penalty<const D: usize>(
        &self,
        point: usize,
        inverse: &Tensor<D>,
        volume_ratio: f64,
    ) -> Tensor<D> {
        match self.stabilisation {
            Stabilisation::Silling => scaled(&identity(), self.penalty.at(point) * volume_ratio),
            Stabilisation::Wan => {
                let (lambda, mu) = self.laws.at(point).plane(D);
                sum(&scaled(&identity(), lambda * trace(inverse)), &scaled(inverse, 2.0 * mu))
            }
            Stabilisation::None => zero(),
        }
    }

    /// C and H of the penalty.
    pub(super) fn penalty_of<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        own: &Own<D>,
    ) -> [Tensor<D>; 2] {
        let ratio = if own.weight > 0.0 { own.volume / own.weight } else { 0.0 };
        [self.penalty(point, &own.gradient.shape.inverse, ratio), seen(body, point, own)]
    }

    pub(super) fn is_stabilised(&self) -> bool {
        self.stabilisation != Stabilisation::None
    }
}

/// The gradient operator of a point, the displacement gradient in the directions its family spans, and
/// sum w V and sum V.
pub(super) fn gradient_at<const D: usize>(
    body: &Body<'_, D>,
    point: usize,
    order: usize,
) -> (Gradient<D>, Tensor<D>, f64, f64) {
    let (size, horizon) = (width(order, D), body.weights.horizons.at(point));
    let (mut moments, mut moved) = ([[0.0; MOST]; MOST], [[0.0; MOST]; D]);
    let (mut weight, mut volume) = (0.0, 0.0);
    for link in body.links(point) {
        let factor = link.own * link.volume;
        let q = monomials(order, &link.reference, horizon);
        for row in 0..size {
            for column in 0..size {
                moments[row][column] += factor * q[row] * q[column];
            }
        }
        for (row, moved) in moved.iter_mut().zip(&link.moved) {
            for column in 0..size {
                row[column] += factor * moved * q[column];
            }
        }
        weight += factor;
        volume += link.share * link.volume;
    }
    let gradient = Gradient::<D>::new(order, &moments, horizon);
    // sum w du (rows q)^T V
    let of = |moved: &[[f64; MOST]; D]| -> Tensor<D> {
        std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                (0..size).map(|k| moved[row][k] * gradient.rows[column][k]).sum()
            })
        })
    };
    let mut displacement_gradient = of(&moved);
    if gradient.steep {
        // The rows take linear fields exactly but for rounding: the gradient of what is left takes it back.
        let mut rest = [[0.0; MOST]; D];
        for link in body.links(point) {
            let factor = link.own * link.volume;
            let q = monomials(order, &link.reference, horizon);
            let seen = applied(&displacement_gradient, &link.reference);
            for (row, rest) in rest.iter_mut().enumerate() {
                let unseen = link.moved[row] - seen[row];
                rest.iter_mut().zip(&q).for_each(|(rest, q)| *rest += factor * unseen * q);
            }
        }
        displacement_gradient = sum(&displacement_gradient, &of(&rest));
    }
    (gradient, displacement_gradient, weight, volume)
}

/// The deformation of a point.
pub(super) fn deformation_at<const D: usize>(
    body: &Body<'_, D>,
    point: usize,
    order: usize,
) -> Deformation<D> {
    let (Gradient { shape, .. }, gradient, ..) = gradient_at(body, point, order);
    Deformation { gradient, span: shape.span, rank: shape.rank }
}

impl Passes for Correspondence {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn has_potential(&self) -> bool {
        !self.strong
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
        ask(point, &deformation_at(body, point, self.order));
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        self.kept.refer_to(scene, &self.weights, self.order)?;
        if let Some(lattice) = &scene.families.lattice {
            self.lattice = Some(LatticeRows::new(scene, lattice, scene.dimension.pow(2))?);
        }
        Ok(())
    }

    fn gradient_order(&self) -> usize {
        self.order
    }

    fn use_of_a_lattice(&self) -> LatticeUse {
        if self.fits_lattice() { LatticeUse::Pairs } else { LatticeUse::None }
    }

    /// Laws are those of points, whatever their group.
    fn models_differ(&self) -> Option<bool> {
        Some(false)
    }

    fn room_of_lanes(&self, points: usize, _: usize, dimension: usize) -> usize {
        let row = match self.is_stabilised() {
            true => PENALTY_ROW,
            false => 4 * (1 + width(self.order, dimension)),
        };
        in_lanes::room_of_records(points) + points * row + in_lanes::SLACK
    }

    fn room_of_energies(&self, points: usize, _: usize) -> usize {
        in_lanes::room_of_records(points)
    }

    fn runs_in_lanes(&self, scene: &Scene<'_>) -> bool {
        self.kept.omega(scene, &self.weights).is_some()
    }

    fn rings(&self, dimension: usize) -> Option<u8> {
        self.laws.rest_without_stress(dimension).then_some(RINGS)
    }

    fn forces_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        if let (Some(lattice), Some(rows)) = (sweep.scene.lattice(), &self.lattice) {
            let on = (lattice, rows);
            return match D {
                3 => self.forces_on_lattice::<3, 9, 16>(on, sweep),
                _ => self.forces_on_lattice::<2, 4, 12>(on, sweep),
            };
        }
        if self.is_stabilised() {
            return self.swept_forces::<D, D, PENALTY_ROW, true>(sweep);
        }
        self.swept_forces::<D, SIZE, C, false>(sweep)
    }

    fn energy_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: EnergySweep<'_>,
    ) -> bool {
        self.swept_energy::<D, SIZE>(sweep)
    }

    fn kinematics_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        sweep: FieldSweep<'_>,
    ) -> bool {
        self.swept_fields::<D, SIZE>(sweep)
    }

    /// P rows (with strong divergence: P and rows), and C and H with a penalty.
    fn width(&self, dimension: usize) -> usize {
        let rows = dimension * width(self.order, dimension);
        let square = dimension * dimension;
        match (self.strong, self.is_stabilised()) {
            (true, _) => square + rows,
            (_, true) => rows + 2 * square,
            _ => rows,
        }
    }

    fn prepare_point<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &mut [f64],
    ) -> bool {
        let own = self.own(body, point);
        let size = width(self.order, D);
        let (rows, rest) = scratch.split_at_mut(D * size);
        let stress = if self.strong { identity() } else { own.answer.stress };
        for (row, place) in rows.chunks_exact_mut(size).enumerate() {
            for (column, value) in place.iter_mut().enumerate() {
                *value = (0..D).map(|k| stress[row][k] * own.gradient.rows[k][column]).sum();
            }
        }
        if self.strong {
            rest.copy_from_slice(own.answer.stress.as_flattened());
        } else if self.is_stabilised() {
            let penalty = self.penalty_of(body, point, &own);
            rest.copy_from_slice(penalty.as_flattened().as_flattened());
        }
        own.answer.energy.is_finite()
    }

    fn force_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Vector<D> {
        let (size, all) = (width(self.order, D), self.width(D));
        let of = |point: usize| &scratch[point * all..(point + 1) * all];
        let mut force = [0.0; D];
        let own = of(point);
        for link in body.links(point) {
            let other = of(link.neighbor);
            if self.strong {
                // sum (P_j - P_i) G_ij V_j [P 3.51]
                let apart = difference(&read(&other[D * size..]), &read(&own[D * size..]));
                let q = monomials(self.order, &link.reference, body.weights.horizons.at(point));
                let pull = applied(&apart, &times_rows(own, size, &q));
                add(&mut force, link.own * link.volume, &pull);
                continue;
            }
            add_pulls(&mut force, body, point, &link, self.order, [own, other]);
            if self.is_stabilised() {
                add_penalty(&mut force, &link, &own[D * size..], &other[D * size..]);
            }
        }
        force
    }

    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, _: &[f64]) -> f64 {
        self.own(body, point).answer.energy
    }

    fn has_penalty(&self) -> bool {
        self.is_stabilised()
    }

    fn stabilisation_at<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> f64 {
        let own = self.own(body, point);
        let [penalty, gradient] = self.penalty_of(body, point, &own);
        let mut energy = 0.0;
        for link in body.links(point) {
            // eta - F xi = du - H xi
            let seen = applied(&gradient, &link.reference);
            let unseen: Vector<D> = std::array::from_fn(|axis| link.moved[axis] - seen[axis]);
            let cost = dot(&unseen, &applied(&penalty, &unseen));
            energy += 0.5 * link.own * link.volume * cost;
        }
        energy
    }

    fn is_degenerate<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> bool {
        let (gradient, ..) = gradient_at(body, point, self.order);
        gradient.shape.rank < D || gradient.lowered
    }

    /// F_i, and the law's stress at it, without what the penalty adds.
    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        _: &[f64],
    ) -> Kinematics {
        let own = self.own(body, point);
        self.laws.kinematics(body, point, &own.deformation, &own.answer)
    }

    fn bytes(&self) -> usize {
        let lattice = self.lattice.as_ref().map_or(0, LatticeRows::bytes);
        self.laws.bytes() + self.penalty.bytes() + self.kept.bytes() + lattice
    }
}

/// w_i C_i z_ij - w_j C_j z_ji, with z_ij = du - H_i xi and z_ji = -(du - H_j xi); each end has C and H.
fn add_penalty<const D: usize>(force: &mut Vector<D>, link: &Link<D>, own: &[f64], other: &[f64]) {
    for (weight, of) in [(link.own, own), (link.other, other)] {
        let mut unseen = link.moved;
        add(&mut unseen, -1.0, &applied(&read(&of[D * D..]), &link.reference));
        add(force, weight * link.volume, &applied(&read(of), &unseen));
    }
}

/// w_ij P_i (rows q) V_j - w_ji P_j (rows q) V_j of a bond, with what each end has of P times its rows.
#[inline(always)]
pub(super) fn add_pulls<const D: usize>(
    force: &mut Vector<D>,
    body: &Body<'_, D>,
    point: usize,
    link: &Link<D>,
    order: usize,
    [own, other]: [&[f64]; 2],
) {
    let (size, horizons) = (width(order, D), &body.weights.horizons);
    let q = monomials(order, &link.reference, horizons.at(point));
    let back = link.reference.map(|x| -x);
    let q_back = monomials(order, &back, horizons.at(link.neighbor));
    add(force, link.own * link.volume, &times_rows(own, size, &q));
    add(force, -link.other * link.volume, &times_rows(other, size, &q_back));
}

/// Rows of so many numbers, one an axis, times monomials.
#[inline(always)]
fn times_rows<const D: usize>(rows: &[f64], size: usize, q: &[f64; MOST]) -> Vector<D> {
    std::array::from_fn(|row| {
        let row = &rows[row * size..(row + 1) * size];
        row.iter().zip(q).map(|(a, b)| a * b).sum()
    })
}

/// The displacement gradient H that the penalty compares bonds with. In a family that is flat but for a
/// little it looks across too, or a turn of what stands out would count as deformation.
fn seen<const D: usize>(body: &Body<'_, D>, point: usize, own: &Own<D>) -> Tensor<D> {
    let Gradient { shape, .. } = &own.gradient;
    if shape.rank == D {
        return own.deformation.gradient;
    }
    let mut gradient = zero();
    // The second time takes back what the steep inverse has rounded.
    for _ in 0..2 {
        let mut unseen = zero();
        for link in body.links(point) {
            let mut rest = link.moved;
            add(&mut rest, -1.0, &applied(&gradient, &link.reference));
            add_outer(&mut unseen, link.own * link.volume, &rest, &link.reference);
        }
        gradient = sum(&gradient, &product(&unseen, &shape.steep_inverse));
    }
    gradient
}

/// a + factor b, in place.
#[inline(always)]
pub(super) fn add<const D: usize>(a: &mut Vector<D>, factor: f64, b: &Vector<D>) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * b;
    }
}
