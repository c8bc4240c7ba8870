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
use super::constants;
use super::correspondence::{add, add_pulls, gradient_at};
use super::gradient::width;
use super::kept_rows::{KeptRows, Order, Point, Points, Sweep, leave, pull};
use super::laws::{Laws, Sites};
use super::passes::{Passes, Room};
use super::state_based::StateBased;
use super::{Formulation, FormulationEntry, Kinematics, Materials, Scene, in_lanes};
use crate::damage::Breaking;
use crate::error::Result;
use crate::kernel::family::{Record, Table};
use crate::kernel::quadrature::{BondStresses, Stress, odd_place, weight_place};
use crate::material::{Across, Answer, Deformation};
use crate::model::Model;
use crate::tensor::{
    Tensor, Vector, add_outer, applied, difference, product, read, scaled, sum, zero,
};
use crate::workers::PerPoint;
use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, Ordering};

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

struct Baqp {
    weights: Weights,
    laws: Laws,
    order: usize,
    kept: KeptRows,
}

fn prepare(materials: &Materials<'_>) -> Result<Box<dyn Formulation>> {
    let baqp = Baqp {
        weights: Weights::new(materials)?,
        laws: Laws::new(materials, Sites::Lanes)?,
        order: materials.models[0].gradient_order(),
        kept: KeptRows::default(),
    };
    Ok(Box::new(StateBased::new(materials, baqp)?))
}

/// What the first pass leaves of a point.
struct Left<'a> {
    numbers: &'a [f64],
    dimension: usize,
}

impl Left<'_> {
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
struct Quadrature<const D: usize> {
    /// wbar_ij
    weight: f64,
    deformation: Deformation<D>,
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

    /// Energy and stress of a bond: the mean of the laws of its ends.
    fn answer<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        link: &Link<D>,
        deformation: &Deformation<D>,
    ) -> Answer<D> {
        let answer = self.laws.answer(body, point, link.slot, deformation);
        if std::ptr::eq(self.laws.at(point), self.laws.at(link.neighbor)) {
            return answer;
        }
        let back = self.back(body, point, link);
        let second = self.laws.answer(body, link.neighbor, back, deformation);
        Answer {
            energy: 0.5 * (answer.energy + second.energy),
            stress: scaled(&sum(&answer.stress, &second.stress), 0.5),
        }
    }

    /// Where a bond stands at its other end, if a law there has a memory.
    fn back<const D: usize>(&self, body: &Body<'_, D>, point: usize, link: &Link<D>) -> usize {
        let slot = || body.scene.families.slot(link.neighbor, point);
        let back = if self.laws.remember() { slot() } else { None };
        back.unwrap_or(link.slot)
    }
}

/// Numbers of a point before the rows.
const fn before_rows(dimension: usize) -> usize {
    2 + 2 * dimension * dimension
}

/// Most numbers that the first pass leaves of a point.
const MOST_LEFT: usize = before_rows(3) + 27;

/// Gradients of points that have been swept in lanes, and what is kept of their families.
struct Swept<'a, const D: usize, const SIZE: usize> {
    baqp: &'a Baqp,
    body: &'a Body<'a, D>,
    table: &'a [[f64; GRADIENT]],
    kept: &'a Points<'a>,
}

impl<const D: usize, const SIZE: usize> Swept<'_, D, SIZE> {
    /// What the first pass would leave of a point.
    fn left(&self, point: usize) -> [f64; MOST_LEFT] {
        let mut numbers = [0.0; MOST_LEFT];
        let kept: Point<'_, D, SIZE> = self.kept.at(point);
        if !kept.spans() {
            let width = before_rows(D) + D * SIZE;
            self.baqp.prepare_point(self.body, point, &mut numbers[..width]);
            return numbers;
        }
        numbers[0] = kept.inverse_weight();
        numbers[1] = D as f64;
        numbers[2..2 + D * D].copy_from_slice(&self.table[point][..D * D]);
        let whole = crate::tensor::identity::<D>();
        numbers[2 + D * D..before_rows(D)].copy_from_slice(whole.as_flattened());
        let rows = before_rows(D)..before_rows(D) + D * SIZE;
        numbers[rows].copy_from_slice(kept.rows().as_flattened());
        numbers
    }

    /// Force of the bonds of a point themselves, and the stress that they have through its gradient.
    fn single_bonds(&self, point: usize, own: &Left<'_>) -> (Vector<D>, Tensor<D>) {
        let (mut force, mut through) = ([0.0; D], zero());
        for link in self.body.links(point) {
            let other = self.left(link.neighbor);
            let at = Baqp::quadrature(&link, own, &Left { numbers: &other, dimension: D });
            let answer = self.baqp.answer(self.body, point, &link, &at.deformation);
            let factor = 2.0 * at.weight * link.volume;
            add(&mut force, factor, &applied(&answer.stress, &at.along));
            let across = scaled(&product(&answer.stress, &at.across), at.shares[0] * factor);
            through = sum(&through, &across);
        }
        (force, through)
    }
}

impl Baqp {
    /// The law in lanes, if it is one for them and all points share it.
    fn stress(&self, dimension: usize) -> Option<Stress> {
        let (lambda, mu) = self.laws.only()?.saint_venant_kirchhoff(dimension)?;
        Some(Stress { lambda, mu })
    }

    fn swept<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        scene: &Scene<'_>,
        room: Room<'_>,
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> Option<usize> {
        let (omega, count) = (self.kept.omega(scene, &self.weights)?, scene.places.len());
        let stress = self.stress(D)?;
        let (records, rest) = in_lanes::table(room.tables, count);
        let (gradients, rest) = in_lanes::table::<GRADIENT>(rest, count);
        let (left, _) = in_lanes::table::<C>(rest, count);
        in_lanes::record::<D>(scene, records);
        let records = &*records;
        let order = Order { order: self.order, looks_twice: true };
        let sweep = Sweep { scene, omega, records };
        let kept = self.kept.sweep::<D, SIZE, _>(
            order,
            sweep,
            breaking,
            PerPoint(&mut *gradients, 1),
            |_| true,
            |_, kept, gradient, row| row.0[0] = gradient_row(gradient, kept, 0.0),
        );
        let remaining = &in_lanes::remaining(scene, breaking);
        let body = &Body::<D>::new(remaining, &self.weights);
        kept.odd::<D, SIZE, _>(remaining, PerPoint(&mut *gradients, 1), |point, kept, row| {
            let (_, gradient, ..) = gradient_at(body, point, self.order);
            row.0[0] = gradient_row(&gradient, kept, 1.0);
        });
        let family = in_lanes::family(remaining, records, omega);
        let (gradients, any_odd) = (&*gradients, AtomicBool::new(false));
        let table = Table::new(&family, gradients);
        let outputs = (PerPoint(&mut *force, D), PerPoint(&mut *left, 1));
        scene.workers.sweep(count, outputs, |range, (force, left)| {
            let (forces, _) = force.0.as_chunks_mut::<D>();
            let first = range.start;
            let finish = |point: usize, through: &Tensor<D>, force: &Vector<D>, odd: bool| {
                let (at, kept) = (point - first, kept.at::<D, SIZE>(point));
                let own = leave(&records[point], through, kept.rows(), kept, &mut left.0[at]);
                forces[at] = std::array::from_fn(|axis| force[axis] + own[axis]);
                if odd {
                    left.0[at][MARK] = 1.0;
                    any_odd.store(true, Ordering::Relaxed);
                }
            };
            scene.simd.run(BondStresses::<_, D, GRADIENT> { family, table, stress, range, finish });
        });
        if any_odd.into_inner() {
            let swept = Swept::<D, SIZE> { baqp: self, body, table: gradients, kept: &kept };
            swept.mend(records, force, left);
        }
        drop(kept);
        pull::<D, C>(Sweep { scene: remaining, ..sweep }, left, force)
    }
}

/// Numbers of a row of the table of gradients.
const GRADIENT: usize = 12;

fn gradient_row<const D: usize, const SIZE: usize>(
    gradient: &Tensor<D>,
    kept: Point<'_, D, SIZE>,
    odd: f64,
) -> [f64; GRADIENT] {
    let mut row = [0.0; GRADIENT];
    row[..D * D].copy_from_slice(gradient.as_flattened());
    row[weight_place(D)] = kept.inverse_weight();
    row[odd_place(D)] = odd;
    row
}

/// Where a row that is left marks a point with an end of a bond that does not span the body.
const MARK: usize = 3;

impl<const D: usize, const SIZE: usize> Swept<'_, D, SIZE> {
    /// Computes marked points by single bonds.
    fn mend<const C: usize>(&self, records: &[Record], force: &mut [f64], left: &mut [[f64; C]]) {
        let scene = self.body.scene;
        let outputs = (PerPoint(force, D), PerPoint(left, 1));
        scene.workers.sweep(scene.places.len(), outputs, |range, (force, left)| {
            let (forces, _) = force.0.as_chunks_mut::<D>();
            for ((force, left), point) in forces.iter_mut().zip(left.0).zip(range) {
                if left[MARK] == 0.0 {
                    continue;
                }
                let numbers = self.left(point);
                let own = Left { numbers: &numbers, dimension: D };
                let (straight, through) = self.single_bonds(point, &own);
                let (rows, _) = own.rows().as_chunks();
                let kept = self.kept.at::<D, SIZE>(point);
                let pulled = leave(&records[point], &through, rows, kept, left);
                *force = std::array::from_fn(|axis| straight[axis] + pulled[axis]);
            }
        });
    }
}

/// Whether two projectors are the same but for rounding.
fn agree<const D: usize>(one: &Tensor<D>, other: &Tensor<D>) -> bool {
    let apart = difference(one, other);
    apart.as_flattened().iter().all(|value| value.abs() < 1e-9)
}

impl Passes for Baqp {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        if self.stress(scene.dimension).is_some() {
            self.kept.refer_to(scene, &self.weights, self.order)?;
        }
        Ok(())
    }

    fn room_of_lanes(&self, points: usize, dimension: usize) -> usize {
        if self.stress(dimension).is_none() {
            return 0;
        }
        let row = 4 * (1 + width(self.order, dimension));
        let tables = size_of::<Record>() / size_of::<f64>() + GRADIENT + row;
        points * tables + 3 * in_lanes::SLACK
    }

    fn gradient_order(&self) -> usize {
        self.order
    }

    fn runs_in_lanes(&self, scene: &Scene<'_>) -> bool {
        self.kept.omega(scene, &self.weights).is_some()
    }

    fn forces_in_lanes<const D: usize, const SIZE: usize, const C: usize>(
        &self,
        scene: &Scene<'_>,
        room: Room<'_>,
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> Option<usize> {
        self.swept::<D, SIZE, C>(scene, room, force, breaking)
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
        let own = self.left(left, point, D);
        for link in body.links(point) {
            let other = self.left(left, link.neighbor, D);
            ask(link.slot, &Self::quadrature(&link, &own, &other).deformation);
        }
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
        let mut stress: Tensor<D> = zero();
        for link in body.links(point) {
            let other = self.left(scratch, link.neighbor, D);
            let at = Self::quadrature(&link, &own, &other);
            if at.shares[0] == 0.0 {
                continue;
            }
            let answer = self.answer(body, point, &link, &at.deformation);
            let factor = 2.0 * at.shares[0] * at.weight * link.volume;
            stress = sum(&stress, &scaled(&product(&answer.stress, &at.across), factor));
        }
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
            let answer = self.answer(body, point, &link, &at.deformation);
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
        let own = self.left(scratch, point, D);
        let terms = body.links(point).map(|link| {
            let other = self.left(scratch, link.neighbor, D);
            let at = Self::quadrature(&link, &own, &other);
            let energy = self.answer(body, point, &link, &at.deformation).energy;
            link.own * own.weight() * energy * link.volume
        });
        terms.sum()
    }

    fn is_degenerate<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> bool {
        let (gradient, ..) = gradient_at(body, point, self.order);
        gradient.shape.rank < D || gradient.lowered
    }

    /// F_i, and the mean of the stresses of the bonds: sum (w/omega0_i) P_ij V_j.
    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        scratch: &[f64],
    ) -> Kinematics {
        let own = self.left(scratch, point, D);
        let (mut stress, mut held) = (zero(), 0.0);
        let (mut plastic, mut equivalent) = (zero(), 0.0);
        let mut remembered = Across { stretch: 0.0, thickness: 0.0, held: 0.0 };
        for link in body.links(point) {
            let other = self.left(scratch, link.neighbor, D);
            let at = Self::quadrature(&link, &own, &other);
            let factor = link.own * own.weight() * link.volume;
            let answer = self.answer(body, point, &link, &at.deformation);
            stress = sum(&stress, &scaled(&answer.stress, factor));
            let ends = [(point, link.slot), (link.neighbor, self.back(body, point, &link))];
            let across = ends.map(|(end, site)| self.laws.across(body, end, site, &at.deformation));
            let (strain, amount) = self.laws.plastic(body, point, link.slot);
            plastic = sum(&plastic, &scaled(&strain, factor));
            equivalent += factor * amount;
            held += 0.5 * factor * (across[0].held + across[1].held);
            remembered.stretch += factor * across[0].stretch;
            remembered.thickness += factor * across[0].thickness;
        }
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

    fn bytes(&self) -> usize {
        self.laws.bytes() + self.kept.bytes()
    }
}
