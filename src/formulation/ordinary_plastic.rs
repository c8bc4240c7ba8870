//! Perfect plasticity of the linear peridynamic solid, in 3D. (Mitchell 2011)
//!
//! A point has of each of its bonds a plastic extension p, 0 at rest. What else it is extended by is elastic: theta
//! is that of e - p, x = e - p - theta L/3, t_ij = w (3 K theta L + C x)/m m^,
//! W_i = K theta^2/2 + C/(2m) sum w x^2 V. With t_dev = C w x/m it flows where 1/2 sum t_dev^2/w V > 5 Y^2/(2m), that
//! is where the energy of x is above 5 Y^2/(2C) = Y^2/(6G), at which a solid of von Mises yields: x shrinks to s x,
//! p grows by (1 - s) x.
//!
//! x and so p have no dilatation while a family is whole: theta is that of e. As bonds break, what is left of p may
//! have one, but it is no reason to press: t remains the slope of W, and W of the size that can yield.

use super::body::{Body, ByModel, Link, Weights};
use super::breaking::Near;
use super::in_lanes;
use super::ordinary_plastic_lanes;
use super::ordinary_state_based::{Lps, extension, pulled};
use super::passes::{EnergySweep, FieldSweep, ForceSweep, Passes};
use super::state_based::StateBased;
use super::surface::Surface;
use super::{Formulation, Kinematics, Materials, Scene};
use crate::error::Result;
use crate::families::{Families, LANES};
use crate::kernel::ordinary_plastic::Extensions;
use crate::material::Law;
use crate::memory;
use crate::tensor::{Tensor, Vector, add_outer, resized, scaled, zero};
use crate::workers::{PerPoint, Ragged};

/// A state on the yield surface is there but for this.
const ROUNDING: f64 = 1.0 + 1e-12;

/// 1/m, theta, what has been dissipated, and the equivalent plastic strain of a point.
pub(super) type State = [f64; 4];
const STATE: usize = 4;

/// Numbers of a block of bonds.
const BLOCK: usize = 2 * LANES;

pub(super) struct PlasticLps {
    elastic: Lps,
    /// Y, infinite where a material does not flow.
    yield_stress: ByModel<f64>,
    /// The lane at the other end of each bond, and of lanes without one themselves; empty before the body is known, and where
    /// there are too many.
    pub(super) backs: Vec<u32>,
}

pub(super) fn prepare(materials: &Materials<'_>, elastic: Lps) -> Result<Box<dyn Formulation>> {
    let yield_stress =
        ByModel::new(materials, |model| Ok(model.number("yield_stress").unwrap_or(f64::INFINITY)))?;
    Ok(Box::new(StateBased::new(
        materials,
        PlasticLps { elastic, yield_stress, backs: Vec::new() },
    )?))
}

/// Records, of blocks of bonds and of points.
#[derive(Clone, Copy)]
pub(super) struct Records<'a> {
    pub(super) bonds: &'a [Extensions],
    pub(super) points: &'a [State],
}

impl<'a> Records<'a> {
    pub(super) fn new(records: &'a [f64], blocks: usize) -> Self {
        let (bonds, points) = records.split_at(blocks * BLOCK);
        Self { bonds: bonds.as_chunks().0.as_chunks().0, points: points.as_chunks().0 }
    }

    /// Those at the displacement of the body.
    fn of<const D: usize>(body: &Body<'a, D>) -> Self {
        let records = body.scene.asked.map_or(body.scene.bonds.records, |asked| asked.records);
        Self::new(records, body.scene.families.block_count())
    }

    fn plastic(&self, slot: usize) -> f64 {
        self.bonds[slot / LANES][0][slot % LANES]
    }

    fn elastic(&self, slot: usize) -> f64 {
        self.bonds[slot / LANES][1][slot % LANES]
    }
}

/// Records that are to be made.
pub(super) fn records_mut(records: &mut [f64], blocks: usize) -> (&mut [Extensions], &mut [State]) {
    let (bonds, points) = records.split_at_mut(blocks * BLOCK);
    (bonds.as_chunks_mut().0.as_chunks_mut().0, points.as_chunks_mut().0)
}

/// A family that may flow.
pub(super) struct Yielding {
    /// C
    stiffness: f64,
    /// 1/m
    inverse: f64,
    /// Y
    stress: f64,
}

impl Yielding {
    /// What is left of x on the yield surface, where sum w x^2 V is beyond it.
    pub(super) fn left(&self, squares: f64) -> Option<f64> {
        let (limit, energy) = (
            2.5 * self.stress * self.stress / self.stiffness,
            0.5 * self.stiffness * self.inverse * squares,
        );
        let flows = energy > limit * ROUNDING;
        flows.then(|| (limit / energy).sqrt())
    }

    /// What flow to a share of x dissipates, and the growth of the equivalent plastic strain; `product`: sum w x dp V.
    pub(super) fn flowed(&self, [left, product]: [f64; 2]) -> [f64; 2] {
        // (Y/s - Y)/(3G)
        let strain = 5.0 * self.stress * (1.0 / left - 1.0) / self.stiffness;
        [self.stiffness * self.inverse * product, strain]
    }

    /// Returns the extensions `new`, x yet as if nothing flowed, to the yield surface; gives what is dissipated by
    /// that and the growth of the equivalent plastic strain. `bonds`: the lane of each bond, and w V.
    fn flow<I: Iterator<Item = (usize, f64)>>(
        &self,
        bonds: impl Fn() -> I,
        old: &[Extensions],
        new: &mut [Extensions],
    ) -> Option<[f64; 2]> {
        let square = |(at, factor): (usize, f64)| factor * new[at / LANES][1][at % LANES].powi(2);
        let left = self.left(bonds().map(square).sum())?;
        let mut product = 0.0;
        for (at, factor) in bonds() {
            let (block, lane) = (at / LANES, at % LANES);
            let [plastic, elastic] = &mut new[block];
            let flowed = (1.0 - left) * elastic[lane];
            plastic[lane] += flowed;
            elastic[lane] *= left;
            // By the trapezoid, as all work.
            product += factor * 0.5 * (old[block][1][lane] + elastic[lane]) * flowed;
        }
        Some(self.flowed([left, product]))
    }
}

/// Sets x of a point's bonds; gives 1/m and theta.
fn split<const D: usize>(
    body: &Body<'_, D>,
    point: usize,
    extensions: &mut [Extensions],
) -> [f64; 2] {
    let first = body.scene.families.blocks(point).start * LANES;
    let (mut weighted, mut sum) = (0.0, 0.0);
    for link in body.links(point) {
        let [plastic, elastic] = &mut extensions[(link.slot - first) / LANES];
        let lane = link.slot % LANES;
        elastic[lane] = extension(&link).0 - plastic[lane];
        let factor = link.own * link.length * link.volume;
        weighted += factor * link.length;
        sum += factor * elastic[lane];
    }
    let inverse = if weighted > 0.0 { 1.0 / weighted } else { 0.0 };
    let theta = D as f64 * inverse * sum;
    for link in body.links(point) {
        let [_, elastic] = &mut extensions[(link.slot - first) / LANES];
        elastic[link.slot % LANES] -= theta * link.length / D as f64;
    }
    [inverse, theta]
}

/// The plastic strain of a point, from sum w p/L xi xi^T V.
pub(super) fn strain_of<const D: usize>(sum: &Tensor<D>, [inverse, ..]: &State) -> Tensor<3> {
    scaled(&resized(sum), 7.5 * inverse)
}

impl PlasticLps {
    /// Y; infinite while the body is stretched to measure its surface.
    fn yield_stress(&self, point: usize) -> f64 {
        let measures = self.elastic.surface.is_some() && self.weights().correction.is_none();
        if measures { f64::INFINITY } else { *self.yield_stress.at(point) }
    }

    /// For what lies across.
    pub(super) fn law(&self, point: usize) -> &Law {
        self.elastic.laws.at(point)
    }

    /// Records of a point and its bonds, after the committed ones.
    fn remember<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        (old, old_state): (&[Extensions], &State),
        (new, state): (&mut [Extensions], &mut State),
    ) {
        let first = body.scene.families.blocks(point).start * LANES;
        // A broken bond is forgotten.
        new.as_flattened_mut().fill([0.0; LANES]);
        for link in body.links(point) {
            let (block, lane) = ((link.slot - first) / LANES, link.slot % LANES);
            new[block][0][lane] = old[block][0][lane];
        }
        let [inverse, mut theta] = split(body, point, new);
        let yielding = self.yielding(body.scene, point, inverse);
        let bonds = || body.links(point).map(|link| (link.slot - first, link.own * link.volume));
        let flowed = yielding.flow(bonds, old, new);
        if flowed.is_some() {
            // Asked again at this displacement, it answers with the same bits.
            [_, theta] = split(body, point, new);
        }
        let [dissipated, strain] = flowed.unwrap_or_default();
        *state = [inverse, theta, old_state[2] + dissipated, old_state[3] + strain];
    }

    /// The family of a point, with its 1/m.
    pub(super) fn yielding(&self, scene: &Scene<'_>, point: usize, inverse: f64) -> Yielding {
        let [_, stiffness] = self.moduli(point);
        let stress = if scene.flows { self.yield_stress(point) } else { f64::INFINITY };
        Yielding { stiffness, inverse, stress }
    }

    /// kappa and C
    pub(super) fn moduli(&self, point: usize) -> [f64; 2] {
        *self.elastic.moduli.at(point)
    }

    /// Strain energy per volume; `squares`: sum w x^2 V.
    pub(super) fn held(&self, point: usize, [inverse, theta, ..]: &State, squares: f64) -> f64 {
        let [kappa, stiffness] = self.moduli(point);
        0.5 * kappa * theta * theta + 0.5 * stiffness * inverse * squares
    }

    /// Where the bond in a lane of a point stands at its other end.
    fn back(&self, families: &Families, point: usize, bond: (usize, usize)) -> Option<usize> {
        let (slot, neighbor) = bond;
        let known = self.backs.get(slot).map(|&back| back as usize);
        known.or_else(|| families.slot(neighbor, point))
    }

    /// |t_ij| + |t_ji| of a bond, and its deformed length.
    fn tension<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        link: &Link<D>,
    ) -> (f64, f64) {
        let records = Records::of(body);
        // |t| of a point, over w.
        let pull = |point: usize, slot: usize| {
            let [inverse, theta, ..] = records.points[point];
            let [kappa, stiffness] = self.moduli(point);
            let elastic = records.elastic(slot);
            inverse * (D as f64 * kappa * theta * link.length + stiffness * elastic)
        };
        let back = self.back(body.scene.families, point, (link.slot, link.neighbor));
        let other = back.map_or(0.0, |back| link.other * pull(link.neighbor, back));
        (link.own * pull(point, link.slot) + other, extension(link).1)
    }

    /// What plastic extensions would pull on a unit of area, over 2G: the plastic strain where all bonds flow alike.
    fn plastic_strain<const D: usize>(&self, body: &Body<'_, D>, point: usize) -> Tensor<3> {
        let records = Records::of(body);
        let mut strain = zero();
        for link in body.links(point) {
            let factor = link.own * link.volume / link.length;
            let bond = &link.reference;
            add_outer(&mut strain, factor * records.plastic(link.slot), bond, bond);
        }
        strain_of(&strain, &records.points[point])
    }
}

impl Passes for PlasticLps {
    fn weights(&self) -> &Weights {
        self.elastic.weights()
    }

    fn weights_mut(&mut self) -> &mut Weights {
        self.elastic.weights_mut()
    }

    fn surface(&self) -> Option<&Surface<ByModel<f64>>> {
        self.elastic.surface()
    }

    fn records(&self, points: usize, blocks: usize) -> usize {
        blocks * BLOCK + points * STATE
    }

    fn refer_to(&mut self, scene: &Scene<'_>) -> Result<()> {
        let (families, purpose) = (scene.families, "ends of bonds");
        let lanes = families.block_count() * LANES;
        if u32::try_from(lanes).is_err() {
            return Ok(());
        }
        self.backs = memory::collected(0..lanes as u32, purpose)?;
        let backs =
            Ragged { values: &mut self.backs[..], offsets: &families.offsets, width: LANES };
        scene.workers.sweep(scene.places.len(), backs, |range, backs| {
            let first = families.blocks(range.start).start * LANES;
            for point in range {
                for bond in families.bonds(point) {
                    let back = families.slot(bond.neighbor, point);
                    backs.values[bond.slot - first] = back.unwrap_or(bond.slot) as u32;
                }
            }
        });
        Ok(())
    }

    fn room_of_lanes(&self, points: usize, blocks: usize, _: usize) -> usize {
        ordinary_plastic_lanes::room(points, blocks)
    }

    fn runs_in_lanes(&self, scene: &Scene<'_>) -> bool {
        !self.backs.is_empty() && in_lanes::omega(scene, self.weights()).is_some()
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

    fn ask<const D: usize>(
        &self,
        body: &Body<'_, D>,
        _: &[f64],
        near: Option<&Near<'_>>,
        records: &mut [f64],
    ) {
        let (scene, offsets) = (body.scene, &body.scene.families.offsets);
        let blocks = scene.families.block_count();
        let old = Records::new(scene.bonds.records, blocks);
        let (bonds, points) = records_mut(records, blocks);
        let outputs = (Ragged { values: bonds, offsets, width: 1 }, PerPoint(points, 1));
        scene.workers.sweep(scene.places.len(), outputs, |range, (bonds, points)| {
            let start = offsets[range.start] as usize;
            for (state, point) in points.0.iter_mut().zip(range) {
                let blocks = scene.families.blocks(point);
                let new = &mut bonds.values[blocks.start - start..blocks.end - start];
                let before = &old.bonds[blocks];
                if near.is_some_and(|near| !near.wants_pass(point)) {
                    new.copy_from_slice(before);
                    *state = old.points[point];
                    continue;
                }
                self.remember(body, point, (before, &old.points[point]), (new, state));
            }
        });
    }

    /// All that forces need is in the records.
    fn width(&self, _: usize) -> usize {
        0
    }

    fn prepare_point<const D: usize>(&self, _: &Body<'_, D>, _: usize, _: &mut [f64]) -> bool {
        true
    }

    fn force_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, _: &[f64]) -> Vector<D> {
        pulled(body, point, |link| self.tension(body, point, link))
    }

    fn energy_at<const D: usize>(&self, body: &Body<'_, D>, point: usize, _: &[f64]) -> f64 {
        let records = Records::of(body);
        let state = &records.points[point];
        if body.scene.asked.is_some_and(|asked| asked.dissipated) {
            return state[2];
        }
        let squares = body.links(point).map(|link| {
            let elastic = records.elastic(link.slot);
            link.own * elastic * elastic * link.volume
        });
        self.held(point, state, squares.sum())
    }

    fn kinematics_at<const D: usize>(
        &self,
        body: &Body<'_, D>,
        point: usize,
        _: &[f64],
    ) -> Kinematics {
        let tension = |link: &Link<D>| self.tension(body, point, link);
        let [_, dilatation, _, equivalent] = Records::of(body).points[point];
        let made = Kinematics::of_bonds(body, point, self.law(point), tension);
        let plastic = (self.plastic_strain(body, point), equivalent);
        Kinematics { dilatation, ..made }.with_plastic(plastic)
    }

    fn bytes(&self) -> usize {
        self.elastic.bytes() + self.yield_stress.bytes() + memory::bytes(&self.backs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One bond of a family: X = (0,0,0), (1,1,0), V = 1, omega = 1, so that m = 2; E = 68.9e3, nu = 0.33.
    struct Pair {
        yielding: Yielding,
        extensions: [Extensions; 1],
        dissipated: f64,
    }

    impl Pair {
        fn new(stress: f64) -> Self {
            let stiffness = 15.0 * 68.9e3 / (2.0 * 1.33);
            let yielding = Yielding { stiffness, inverse: 0.5, stress };
            Self { yielding, extensions: [[[0.0; LANES]; 2]], dissipated: 0.0 }
        }

        /// Force of the bond, both ends alike, with the far end moved by u along x and theta left out.
        fn force(&mut self, u: f64) -> f64 {
            let extension = ((1.0 + u) * (1.0 + u) + 1.0).sqrt() - 2_f64.sqrt();
            let old = self.extensions;
            self.extensions[0][1][0] = extension - old[0][0][0];
            let bonds = || std::iter::once((0, 1.0));
            let flowed = self.yielding.flow(bonds, &old, &mut self.extensions);
            self.dissipated += flowed.unwrap_or_default()[0];
            let state = self.yielding.stiffness * self.yielding.inverse * self.extensions[0][1][0];
            2.0 * state
        }
    }

    #[test]
    fn two_points_sheared_without_dilatation_flow_at_a_closed_form() {
        let yield_stress: f64 = 150.0;
        let mut pair = Pair::new(yield_stress);
        let plateau = 2.0 * (2.0 * 5.0 * yield_stress.powi(2) / (2.0 * 2.0)).sqrt();
        let move_at = |step: u32| 0.0051 * f64::from(step) / 50.0;
        let forces: Vec<f64> = (1..=50).map(|step| pair.force(move_at(step))).collect();
        // Numbers of an independent code; extensions of 7e-5 are differences of lengths of 1.4, exact to 2e-16.
        assert!((forces[0] - 28.023_675_283_010_87).abs() < 1e-10 * forces[0], "{}", forces[0]);
        assert!((forces[1] - 56.048_779_518_371_8).abs() < 1e-10 * forces[1], "{}", forces[1]);
        let elastic = Pair::new(f64::INFINITY);
        let (mut elastic, mut flows) = (elastic, 0);
        for (step, force) in (1..=50).zip(&forces) {
            let expected = elastic.force(move_at(step)).min(plateau);
            flows += u32::from(expected == plateau);
            assert!((force - expected).abs() < 1e-12 * plateau, "step {step}: {force}");
        }
        assert!(flows > 10 && flows < 45, "{flows}");
        // Unloads along the elastic line, and shortened enough flows the other way.
        let slope = pair.yielding.stiffness;
        let far = pair.force(move_at(50));
        let back = pair.force(move_at(45));
        let length = |u: f64| ((1.0 + u) * (1.0 + u) + 1.0).sqrt();
        let shortened = length(move_at(50)) - length(move_at(45));
        assert!((far - back - slope * shortened).abs() < 1e-10 * far, "{far} {back}");
        assert!((pair.force(-0.0051) + plateau).abs() < 1e-12 * plateau);
    }

    #[test]
    fn the_work_of_the_plateau_is_dissipated() {
        let yield_stress: f64 = 150.0;
        let error = |steps: u32| {
            let mut pair = Pair::new(yield_stress);
            for step in 1..=steps {
                pair.force(0.0051 * f64::from(step) / f64::from(steps));
            }
            let whole = (1.0051_f64.powi(2) + 1.0).sqrt() - 2_f64.sqrt();
            let state = (5.0 * yield_stress.powi(2) / 2.0).sqrt();
            let elastic = state / (pair.yielding.stiffness * pair.yielding.inverse);
            let [plastic, left] = pair.extensions[0].map(|lanes| lanes[0]);
            assert!((plastic + left - whole).abs() < 1e-15 && (left - elastic).abs() < 1e-15);
            (pair.dissipated / (state * (whole - elastic)) - 1.0).abs()
        };
        // Only the step that crosses the yield surface is off, by the square of a step.
        let (coarse, fine) = (error(50), error(800));
        assert!(coarse < 2e-3 && fine < 1e-5, "{coarse} {fine}");
    }
}
