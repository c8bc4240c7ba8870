//! Where tractions act: on the layers of points that a stress up to the surface would pull on.
//!
//! Under a uniform stress P the forces in a body cancel but near its surface, where they are b_i = P h_i: to hold that
//! stress a traction has to act as -h_i does, over the depth that forces reach, and not on the outermost points alone.
//! h follows from the forces of the formulation itself, in a body as given: h_i,a from the stress that is one along axis
//! a and zero across. What lies under a point of the set then takes its traction, with the area -V_i h_i.N; N is
//! normal to the set. Over a face they add up to its area in forms that hold a uniform stress; they are scaled to do so in
//! all.

use super::Simulation;
use super::setup::Built;
use crate::conditions::Part;
use crate::damage::BondState;
use crate::error::{Result, argument};
use crate::formulation::Scene;
use crate::memory;
use crate::model::{Elastic, Model, Plane};
use crate::plan::Plan;
use crate::tensor::{Tensor, Vector, add_outer, dot, eigen};

const PURPOSE: &str = "a traction";

/// The strain at which h is found.
const STRAIN: f64 = 1e-7;

/// What lies under a point of the surface is no further aside than this share of its cell's edge.
const ASIDE: f64 = 0.75;

/// Points of a set make a plane if the spread along its normal is below this share of the next larger one.
const FLAT: f64 = 0.25;

/// A surface without vectors: less than this share of the area that its points may have.
const BARE: f64 = 1e-3;

impl Simulation {
    /// Gives the areas of the surface along a set, one for each of its points, in its order: tractions on that set make
    /// a point's area times their value, whatever the layers below. Without areas they are estimated, well on lattices;
    /// give them for clouds without order, and bodies thinner than four horizons.
    ///
    /// # Errors
    /// `Argument` for an unknown set, areas that are not positive and finite, or not one per point.
    pub fn set_surface_areas(&mut self, set: &str, areas: &[f64]) -> Result<()> {
        self.points.check_set_size(set, areas.len())?;
        if let Some(place) = areas.iter().position(|area| !(*area > 0.0 && area.is_finite())) {
            return argument(format!(
                "'areas'[{place}] is {}; it must be positive and finite",
                areas[place]
            ));
        }
        let areas = memory::copied(areas, PURPOSE)?;
        match self.areas.iter_mut().find(|(known, _)| known == set) {
            Some((_, known)) => *known = areas,
            None => memory::push(&mut self.areas, (set.to_owned(), areas), PURPOSE)?,
        }
        self.conditions.forget_spread(set);
        self.state.loads_fresh = false;
        Ok(())
    }

    /// Finds where tractions act of which it is not known.
    pub(super) fn spread_tractions(&mut self) -> Result<()> {
        if self.conditions.unspread().is_none() {
            return Ok(());
        }
        match self.points.dimension() {
            3 => self.spread::<3>(),
            _ => self.spread::<2>(),
        }
    }

    fn spread<const D: usize>(&mut self) -> Result<()> {
        while let Some((set, members)) = self.conditions.unspread() {
            let set = set.to_owned();
            let members = memory::copied(members, PURPOSE)?;
            let model = &self.models
                [self.model_of.get(members[0] as usize).map_or(0, |&number| number as usize)];
            let built = self.built()?;
            let vectors = surface_vectors::<D>(built, model)?;
            let edges = memory::collected(
                members.iter().map(|&place| self.edge_of(place as usize)),
                PURPOSE,
            )?;
            let surface = Surface::<D> {
                plan: &built.plan,
                members: &members,
                edges: &edges,
                vectors: &vectors,
            };
            let areas = self.areas.iter().find(|(known, _)| *known == set);
            let parts = surface.parts(areas.map(|(_, areas)| &areas[..]))?;
            self.conditions.spread(&set, &parts)?;
        }
        Ok(())
    }

    /// Edge of a point's cell.
    fn edge_of(&self, place: usize) -> f64 {
        let volume = self.points.volumes()[self.points.order().host[place] as usize];
        volume.powf(1.0 / self.points.dimension() as f64)
    }
}

/// V h of all points.
fn surface_vectors<const D: usize>(built: &Built, model: &Model) -> Result<Vec<Vector<D>>> {
    let Built { plan, workers, .. } = built;
    let bonds = BondState::new(workers, &plan.families, plan.records())?;
    let (modulus, ratio) = uniaxial(model, D);
    let count = plan.count();
    let mut vectors = memory::filled([0.0; D], count, PURPOSE)?;
    let mut displacement = memory::filled(0.0, count * D, PURPOSE)?;
    let mut force = memory::filled(0.0, count * D, PURPOSE)?;
    let mut scratch = memory::filled(0.0, plan.scratch(false), PURPOSE)?;
    for along in 0..D {
        // Both signs, since the law may bend.
        for sign in [1.0, -1.0] {
            for (component, value) in displacement.iter_mut().enumerate() {
                let (point, axis) = (component / D, component % D);
                let strain = if axis == along { STRAIN } else { -ratio * STRAIN };
                *value = sign * strain * plan.places()[point][axis];
            }
            let scene = Scene { flows: false, ..plan.scene(workers, &bonds, &displacement) };
            plan.formulation.force(&scene, &mut scratch, &mut force, None);
            if let Some(error) = super::drive::stopped_by_law(plan) {
                return Err(error);
            }
            for (point, vector) in vectors.iter_mut().enumerate() {
                let slope = force[point * D + along] / (2.0 * modulus * sign * STRAIN);
                let value = plan.places()[point][3] * slope;
                vector[along] += if value.is_finite() { value } else { 0.0 };
            }
        }
    }
    Ok(vectors)
}

/// Stress over strain along an axis of a body that is free across, and what it shrinks there.
fn uniaxial(model: &Model, dimension: usize) -> (f64, f64) {
    let fixed = match (dimension, model.plane()) {
        (2, Plane::Stress) => 1.0 / 3.0,
        _ => 0.25,
    };
    let elastic = match model.elastic() {
        Ok(elastic) => elastic,
        Err(_) => Elastic::with_fixed_ratio(&model.elastic_constants(), fixed, "")
            .unwrap_or_else(|_| Elastic::new(1.0, fixed)),
    };
    let (modulus, ratio) = (elastic.youngs_modulus, elastic.poissons_ratio);
    match (dimension, model.plane()) {
        (2, Plane::Strain) => (modulus / (1.0 - ratio * ratio), ratio / (1.0 - ratio)),
        _ => (modulus, ratio),
    }
}

/// The surface along a set.
struct Surface<'a, const D: usize> {
    plan: &'a Plan,
    members: &'a [u32],
    /// Edge of the cell of each of them.
    edges: &'a [f64],
    /// V h
    vectors: &'a [Vector<D>],
}

/// What a point under the surface belongs to.
#[derive(Clone, Copy)]
struct Under {
    member: u32,
    aside: f64,
    area: f64,
}

impl<const D: usize> Surface<'_, D> {
    fn place(&self, point: usize) -> Vector<D> {
        std::array::from_fn(|axis| self.plan.places()[point][axis])
    }

    fn parts(&self, areas: Option<&[f64]>) -> Result<Vec<Part>> {
        let under = self.points_under()?;
        let size = self.members.len();
        let mut sums = memory::filled(0.0, size, PURPOSE)?;
        for known in under.iter().filter(|known| known.member != u32::MAX) {
            sums[known.member as usize] += known.area;
        }
        // What the surface under a cell may have.
        let mut bare = memory::filled(0.0, size, PURPOSE)?;
        for (bare, (&place, edge)) in bare.iter_mut().zip(self.members.iter().zip(self.edges)) {
            *bare = self.plan.places()[place as usize][3] / edge;
        }
        // A formulation without forces at its surface has no layers: the points of the set bear it all.
        let (whole, layered) = (bare.iter().sum::<f64>(), sums.iter().sum::<f64>());
        let has_layers = layered > BARE * whole;
        let estimated = whole / layered;
        let mut parts = memory::reserved(0, PURPOSE)?;
        for (member, &place) in self.members.iter().enumerate() {
            let given = areas.map(|areas| areas[member]);
            let lies_bare = match given {
                Some(_) => sums[member] <= BARE * bare[member],
                None => !has_layers,
            };
            if lies_bare {
                let area = given.unwrap_or(bare[member]);
                let weight = area / self.plan.places()[place as usize][3];
                memory::push(&mut parts, Part { place, member: member as u32, weight }, PURPOSE)?;
                // Its layers are not to count as well.
                sums[member] = f64::NAN;
            }
        }
        for (point, known) in under.iter().enumerate() {
            if known.member == u32::MAX || sums[known.member as usize].is_nan() {
                continue;
            }
            let member = known.member as usize;
            let scale = areas.map_or(estimated, |areas| areas[member] / sums[member]);
            let weight = scale * known.area / self.plan.places()[point][3];
            let part = Part { place: point as u32, member: known.member, weight };
            memory::push(&mut parts, part, PURPOSE)?;
        }
        Ok(parts)
    }

    /// All points, with those of the set that they lie under.
    fn points_under(&self) -> Result<Vec<Under>> {
        let count = self.plan.count();
        let nothing = Under { member: u32::MAX, aside: f64::INFINITY, area: 0.0 };
        let mut under = memory::filled(nothing, count, PURPOSE)?;
        let mut in_set = memory::filled(false, count, PURPOSE)?;
        for &member in self.members {
            in_set[member as usize] = true;
        }
        let mut seen = memory::filled(u32::MAX, count, PURPOSE)?;
        for (number, &member) in self.members.iter().enumerate() {
            let (member, number) = (member as usize, number as u32);
            let Some(normal) = self.normal(member, &in_set) else { continue };
            let (here, reach) = (self.place(member), ASIDE * self.edges[number as usize]);
            let mut take = |point: usize| {
                if std::mem::replace(&mut seen[point], number) == number {
                    return;
                }
                let there = self.place(point);
                let apart: Vector<D> = std::array::from_fn(|axis| there[axis] - here[axis]);
                let depth = -dot(&apart, &normal);
                let aside = (dot(&apart, &apart) - depth * depth).max(0.0).sqrt();
                if aside <= reach && aside < under[point].aside - 1e-9 * reach {
                    let area = -dot(&self.vectors[point], &normal);
                    under[point] = Under { member: number, aside, area };
                }
            };
            take(member);
            // Forces reach two horizons, since families of families act.
            for bond in self.plan.families.bonds(member) {
                take(bond.neighbor);
                for next in self.plan.families.bonds(bond.neighbor) {
                    take(next.neighbor);
                }
            }
        }
        Ok(under)
    }

    /// Outward normal of the set at one of its points: across its neighbours there, or, where they make no plane, along
    /// what the surface pulls on.
    fn normal(&self, member: usize, in_set: &[bool]) -> Option<Vector<D>> {
        let here = self.place(member);
        let mut spread: Tensor<D> = [[0.0; D]; D];
        let mut outward = self.vectors[member].map(|value| -value);
        for bond in self.plan.families.bonds(member).filter(|bond| in_set[bond.neighbor]) {
            let there = self.place(bond.neighbor);
            let apart: Vector<D> = std::array::from_fn(|axis| there[axis] - here[axis]);
            add_outer(&mut spread, 1.0, &apart, &apart);
            let pulled = &self.vectors[bond.neighbor];
            outward.iter_mut().zip(pulled).for_each(|(outward, pulled)| *outward -= pulled);
        }
        let (values, vectors) = eigen(&spread);
        let least = (0..D).min_by(|&a, &b| values[a].total_cmp(&values[b]))?;
        let others = (0..D).filter(|&axis| axis != least).map(|axis| values[axis]);
        let next = others.fold(f64::INFINITY, f64::min);
        let flat = next > 0.0 && values[least] <= FLAT * next;
        let mut normal: Vector<D> =
            if flat { std::array::from_fn(|axis| vectors[axis][least]) } else { outward };
        let sign = if dot(&normal, &outward) < 0.0 { -1.0 } else { 1.0 };
        let size = dot(&normal, &normal).sqrt();
        if size == 0.0 || !size.is_finite() {
            return None;
        }
        normal.iter_mut().for_each(|value| *value *= sign / size);
        Some(normal)
    }
}
