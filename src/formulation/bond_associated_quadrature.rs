//! Bond-associated quadrature points (BAQP): the material law at the middle of each bond. [P 4.21-4.35]
//!
//! F_ij = (F_i + F_j)/2 (I - n n^T) + eta xi^T/L^2, so that F_ij xi = eta, E = sum V_i sum V_j wbar_ij W(F_ij)
//! with wbar_ij = (w_ij/omega0_i + w_ji/omega0_j)/2, omega0 = sum w V;
//! t_ij = wbar_ij P_ij xi/L^2 + Z_i G_ij, Z_i = sum wbar P_ij (I - n n^T) V_j.
//!
//! Where the families of both ends span the same directions, the bond is asked in these. Where they do not,
//! an end that spans less gives no gradient and the other stands for both; where neither spans the
//! body, the bond is a string.
//!
//! The stress that is shown of a point is the mean of those of its bonds, sum (w/omega0_i) P_ij V_j; with F_i it
//! makes the Cauchy stress.

use super::body::{Body, Link, Weights};
use super::bond_associated_quadrature_lanes::GRADIENT;
use super::bond_associated_quadrature_lattice::{along, columns};
use super::constants;
use super::correspondence::{add, add_pulls, gradient_at};
use super::gradient::width;
use super::kept_rows::KeptRows;
use super::lattice_rows::LatticeRows;
use super::laws::{Laws, Sites};
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::state_based::StateBased;
use super::{Formulation, FormulationEntry, Kinematics, Materials, Scene, in_lanes};
use crate::error::Result;
use crate::families::lattice::LatticeUse;
use crate::kernel::elastic::ElasticLaw;
use crate::kernel::quadrature::LawsOfPoints;
use crate::kernel::simd::SimdLevel;
use crate::material::{Across, Answer, Deformation};
use crate::memory;
use crate::model::Model;
use crate::tensor::{
    Tensor, Vector, add_outer, applied, difference, product, read, scaled, sum, zero,
};
use std::f64::consts::PI;

/// A force comes from the stresses of the neighbours' bonds, and a stress from the families of both its ends.
const RINGS: u8 = 3;

pub(super) const ENTRY: FormulationEntry = FormulationEntry {
    name: "bond_associated_quadrature",
    description: "bond-associated quadrature points (BAQP): a material law at the middle of each bond",
    refused_keys: &[
        "silling_coefficient",
        "surface_correction",
        "bond_horizon",
        "force_form",
        "operator_bonds",
        "divergence",
    ],
    check: constants::check_law,
    critical_stretch,
    prepare,
};

/// G = 9 pi K s^2 int omega xi^3 with omega normalised over the ball; in 2D by the energy (D kappa s^2) D/2
/// that a bond's share of the disc holds.
fn critical_stretch(model: &Model, dimension: usize, horizon: f64, rate: f64) -> Result<f64> {
    let influence = model.influence();
    let kappa = constants::bulk_modulus(model, dimension)?;
    let moment = |power: i32| {
        constants::integral(|q| influence.value(dimension, q * horizon, horizon) * q.powi(power))
    };
    let per_square = if dimension == 3 {
        9.0 * PI * kappa * horizon * moment(3) / (4.0 * PI * moment(2))
    } else {
        8.0 * kappa * horizon * moment(2) / (2.0 * PI * moment(1))
    };
    Ok((rate / per_square).sqrt())
}

pub(super) struct Baqp {
    pub(super) weights: Weights,
    pub(super) laws: Laws,
    pub(super) order: usize,
    pub(super) kept: KeptRows,
    /// What sweeps over a lattice hold, where the body has one.
    lattice: Option<LatticeRows>,
    /// xi/L^2 of its steps.
    pub(super) along: Vec<[f64; 3]>,
}

fn prepare(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    let baqp = Baqp {
        weights: Weights::new(materials)?,
        laws: Laws::new(materials, Sites::Lanes)?,
        order: materials.models[0].gradient_order(),
        kept: KeptRows::default(),
        lattice: None,
        along: Vec::new(),
    };
    Ok(Box::new(StateBased::new(materials, baqp)?))
}

/// What the first pass leaves of a point.
pub(super) struct Left<'a> {
    numbers: &'a [f64],
    dimension: usize,
}

impl<'a> Left<'a> {
    /// 1/omega0, 0 without a family.
    fn weight(&self) -> f64 {
        self.numbers[0]
    }

    fn rank(&self) -> usize {
        self.numbers[1] as usize
    }

    /// H = F - I in the directions spanned.
    fn gradient<const D: usize>(&self) -> Tensor<D> {
        read(&self.numbers[2..])
    }

    fn span<const D: usize>(&self) -> Tensor<D> {
        read(&self.numbers[2 + D * D..])
    }

    /// The rows that make a gradient, or in the last pass Z times them.
    fn rows(&self) -> &[f64] {
        &self.numbers[2 + 2 * self.dimension * self.dimension..]
    }
}

/// A bond and what it is asked in.
pub(super) struct Quadrature<const D: usize> {
    /// wbar_ij
    weight: f64,
    pub(super) deformation: Deformation<D>,
    /// What of F_i and of F_j is in F_ij.
    shares: [f64; 2],
    /// xi/L^2
    along: Vector<D>,
    /// I - n n^T in the directions asked.
    across: Tensor<D>,
}

impl Baqp {
    fn left<'a>(&self, scratch: &'a [f64], point: usize, dimension: usize) -> Left<'a> {
        let width = Passes::width(self, dimension);
        Left { numbers: &scratch[point * width..(point + 1) * width], dimension }
    }

    fn quadrature<const D: usize>(
        link: &Link<D>,
        own: &Left<'_>,
        other: &Left<'_>,
    ) -> Quadrature<D> {
        let weight = 0.5 * (link.own * own.weight() + link.other * other.weight());
        let along = link.reference.map(|x| x / (link.length * link.length));
        let mut axis = zero();
        add_outer(&mut axis, 1.0, &along, &link.reference);
        let (own_rank, other_rank) = (own.rank(), other.rank());
        let (span, shares) = if own_rank == D && other_rank == D {
            (own.span(), [0.5, 0.5])
        } else if own_rank == D {
            (own.span(), [1.0, 0.0])
        } else if other_rank == D {
            (other.span(), [0.0, 1.0])
        } else if own_rank == other_rank && agree(&own.span::<D>(), &other.span()) {
            (own.span(), [0.5, 0.5])
        } else {
            (axis, [0.0, 0.0])
        };
        let rank = if shares == [0.0, 0.0] { 1 } else { own_rank.max(other_rank) };
        let across = difference(&span, &axis);
        let mean = sum(
            &scaled(&own.gradient::<D>(), shares[0]),
            &scaled(&other.gradient::<D>(), shares[1]),
        );
        // Hbar (I - n n^T) + (eta - xi) xi^T/L^2
        let mut gradient = product(&mean, &across);
        add_outer(&mut gradient, 1.0, &link.moved, &along);
        let deformation = Deformation { gradient, span, rank };
        Quadrature { weight, deformation, shares, along, across }
    }

    /// Calls `take` for the bonds of a point, with what a pass has left of points.
    pub(super) fn each_quadrature<const D: usize, N: AsRef<[f64]>>(
        body: &Body<'_, D>,
        point: usize,
        left: impl Fn(usize) -> N,
        mut take: impl FnMut(&Link<D>, &Quadrature<D>),
    ) {
        let own = left(point);
        let own = Left { numbers: own.as_ref(), dimension: D };
        for link in body.links(point) {
            let other = left(link.neighbor);
            let other = Left { numbers: other.as_ref(), dimension: D };
            take(&link, &Self::quadrature(&link, &own, &other));
        }
    }

    /// sum w W(F_ij) V_j
    pub(super) fn held<const D: usize, N: AsRef<[f64]>>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        left: impl Fn(usize) -> N,
    ) -> f64 {
        let mut sum = 0.0;
        Self::each_quadrature(body, point, left, |link, at| {
            let answer = self.answer(body, (point, link.slot), link.neighbor, &at.deformation);
            sum += link.own * answer.energy * link.volume;
        });
        sum
    }

    /// Force of the bonds of a point themselves, and Z, the stress that they have through its gradient.
    pub(super) fn single_bonds<const D: usize, N: AsRef<[f64]>>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        left: impl Fn(usize) -> N,
    ) -> (Vector<D>, Tensor<D>) {
        let (mut force, mut through) = ([0.0; D], zero());
        Self::each_quadrature(body, point, left, |link, at| {
            let answer = self.answer(body, (point, link.slot), link.neighbor, &at.deformation);
            let factor = 2.0 * at.weight * link.volume;
            add(&mut force, factor, &applied(&answer.stress, &at.along));
            let across = scaled(&product(&answer.stress, &at.across), at.shares[0] * factor);
            through = sum(&through, &across);
        });
        (force, through)
    }

    /// F_i, and the mean of the stresses of the bonds: sum (w/omega0_i) P_ij V_j.
    pub(super) fn shown_by_bonds<const D: usize, N: AsRef<[f64]>>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        left: impl Fn(usize) -> N,
    ) -> Kinematics {
        let (mut stress, mut held) = (zero(), 0.0);
        let (mut plastic, mut equivalent) = (zero(), 0.0);
        let mut remembered = Across { stretch: 0.0, thickness: 0.0, held: 0.0 };
        let numbers = left(point);
        let own = Left { numbers: numbers.as_ref(), dimension: D };
        Self::each_quadrature(body, point, left, |link, at| {
            let factor = link.own * own.weight() * link.volume;
            let answer = self.answer(body, (point, link.slot), link.neighbor, &at.deformation);
            stress = sum(&stress, &scaled(&answer.stress, factor));
            let ends = [
                (point, link.slot),
                (link.neighbor, self.back(body, (point, link.slot), link.neighbor)),
            ];
            let across = ends.map(|(end, site)| self.laws.across(body, end, site, &at.deformation));
            let (strain, amount) = self.laws.plastic(body, point, link.slot);
            plastic = sum(&plastic, &scaled(&strain, factor));
            equivalent += factor * amount;
            held += 0.5 * factor * (across[0].held + across[1].held);
            remembered.stretch += factor * across[0].stretch;
            remembered.thickness += factor * across[0].thickness;
        });
        let (gradient, span) = (own.gradient(), own.span());
        let deformation = Deformation { gradient, span, rank: own.rank() };
        // The law of a point answers its own gradient too; one with a memory has been asked at the bonds alone.
        let across = match self.laws.at(point) {
            law if law.has_memory() && own.weight() > 0.0 => Across { held, ..remembered },
            law => Across { held, ..law.across(&deformation) },
        };
        let made = Kinematics::new(&deformation, &product(&stress, &span), across);
        made.with_plastic((plastic, equivalent))
    }

    /// Energy and stress of a bond: the mean of the laws of its ends.
    pub(super) fn answer<const D: usize>(
        &self,
        body: &Body<'_, D>,
        (point, slot): (usize, usize),
        neighbor: usize,
        deformation: &Deformation<D>,
    ) -> Answer<D> {
        let answer = self.laws.answer(body, point, slot, deformation);
        if std::ptr::eq(self.laws.at(point), self.laws.at(neighbor)) {
            return answer;
        }
        let back = self.back(body, (point, slot), neighbor);
        let second = self.laws.answer(body, neighbor, back, deformation);
        Answer {
            energy: 0.5 * (answer.energy + second.energy),
            stress: scaled(&sum(&answer.stress, &second.stress), 0.5),
        }
    }

    /// Where a bond stands at its other end, if a law there has a memory.
    fn back<const D: usize>(
        &self,
        body: &Body<'_, D>,
        (point, slot): (usize, usize),
        neighbor: usize,
    ) -> usize {
        let back = || body.scene.families.slot(neighbor, point);
        let back = if self.laws.remember() { back() } else { None };
        back.unwrap_or(slot)
    }

    /// The laws of points, if all are ones for lanes.
    pub(super) fn laws_of_points(
        &self,
        level: SimdLevel,
    ) -> Option<LawsOfPoints<impl Fn(usize) -> ElasticLaw + Copy + Sync>> {
        let is_common = self.laws.are_common();
        self.laws.of_points().map(|of| LawsOfPoints { of, is_common, level })
    }
}

/// Numbers of a point before the rows.
pub(super) const fn before_rows(dimension: usize) -> usize {
    2 + 2 * dimension * dimension
}

/// Most numbers that the first pass leaves of a point.
pub(super) const MOST_LEFT: usize = before_rows(3) + 27;

/// Whether two projectors are the same but for rounding.
fn agree<const D: usize>(one: &Tensor<D>, other: &Tensor<D>) -> bool {
    let apart = difference(one, other);
    apart.as_flattened().iter().all(|value| value.abs() < 1e-9)
}

impl Passes for Baqp {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        self.kept.refer_to(scene, &self.weights, self.order)?;
        if let Some(lattice) = &scene.families.lattice {
            let left = columns(scene.dimension);
            self.lattice = Some(LatticeRows::new(scene, lattice, left)?);
            self.along = along(lattice)?;
        }
        Ok(())
    }

    fn use_of_a_lattice(&self) -> LatticeUse {
        if self.fits_lattice() { LatticeUse::Pairs } else { LatticeUse::None }
    }

    fn models_differ(&self) -> Option<bool> {
        Some(!self.laws.are_common())
    }

    fn room_of_lanes(&self, points: usize, _: usize, dimension: usize) -> usize {
        let row = 4 * (1 + width(self.order, dimension));
        self.room_of_energies(points, dimension) + points * row + in_lanes::SLACK
    }

    fn room_of_energies(&self, points: usize, _: usize) -> usize {
        in_lanes::room_of_records(points) + points * GRADIENT + in_lanes::SLACK
    }

    fn gradient_order(&self) -> usize {
        self.order
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
                3 => self.forces_on_lattice::<3, { columns(3) }, 10, 9, 16>(on, sweep),
                _ => self.forces_on_lattice::<2, { columns(2) }, 5, 4, 12>(on, sweep),
            };
        }
        self.swept_forces::<D, SIZE, C>(sweep)
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

    fn width(&self, dimension: usize) -> usize {
        before_rows(dimension) + dimension * width(self.order, dimension)
    }

    fn prepare_point<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &mut [f64],
    ) -> bool {
        let (gradient, displacement_gradient, weight, _) = gradient_at(body, point, self.order);
        scratch[0] = if weight > 0.0 { 1.0 / weight } else { 0.0 };
        scratch[1] = gradient.shape.rank as f64;
        let (of, span) = (2..2 + D * D, 2 + D * D..2 + 2 * D * D);
        scratch[of].copy_from_slice(displacement_gradient.as_flattened());
        scratch[span].copy_from_slice(gradient.shape.span.as_flattened());
        let size = width(self.order, D);
        for (row, place) in scratch[2 + 2 * D * D..].chunks_exact_mut(size).enumerate() {
            place.copy_from_slice(&gradient.rows[row][..size]);
        }
        true
    }

    fn laws(&self) -> Option<&Laws> {
        Some(&self.laws)
    }

    fn each_site<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        left: &[f64],
        ask: &mut dyn FnMut(usize, &Deformation<D>),
    ) {
        let left = |point| self.left(left, point, D).numbers;
        Self::each_quadrature(body, point, left, |link, at| ask(link.slot, &at.deformation));
    }

    fn has_second(&self) -> bool {
        true
    }

    /// Puts Z times the rows in the place of the rows.
    fn second_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
        result: &mut [f64],
    ) {
        let own = self.left(scratch, point, D);
        let left = |point| self.left(scratch, point, D).numbers;
        let (_, stress) = self.single_bonds(body, point, left);
        let before = 2 + 2 * D * D;
        result[..before].copy_from_slice(&own.numbers[..before]);
        let (size, rows) = (width(self.order, D), own.rows());
        for (row, place) in result[before..].chunks_exact_mut(size).enumerate() {
            for (column, value) in place.iter_mut().enumerate() {
                *value = (0..D).map(|k| stress[row][k] * rows[k * size + column]).sum();
            }
        }
    }

    fn force_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Vector<D> {
        let own = self.left(scratch, point, D);
        let mut force = [0.0; D];
        for link in body.links(point) {
            let other = self.left(scratch, link.neighbor, D);
            let at = Self::quadrature(&link, &own, &other);
            let answer = self.answer(body, (point, link.slot), link.neighbor, &at.deformation);
            let straight = applied(&answer.stress, &at.along);
            add(&mut force, 2.0 * at.weight * link.volume, &straight);
            add_pulls(&mut force, body, point, &link, self.order, [own.rows(), other.rows()]);
        }
        force
    }

    fn energy_needs_pass(&self) -> bool {
        true
    }

    /// sum (w/omega0_i) W(F_ij) V_j
    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, scratch: &[f64]) -> f64 {
        let left = |point| self.left(scratch, point, D);
        left(point).weight() * self.held(body, point, |point| left(point).numbers)
    }

    fn is_degenerate<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> bool {
        let (gradient, ..) = gradient_at(body, point, self.order);
        gradient.shape.rank < D || gradient.lowered
    }

    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Kinematics {
        self.shown_by_bonds(body, point, |point| self.left(scratch, point, D).numbers)
    }

    fn bytes(&self) -> usize {
        let lattice = self.lattice.as_ref().map_or(0, LatticeRows::bytes);
        self.laws.bytes() + self.kept.bytes() + lattice + memory::bytes(&self.along)
    }
}
