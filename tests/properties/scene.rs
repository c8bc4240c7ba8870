//! Bodies: a recipe that `proptest` draws and shrinks, and the scene that follows from it.

use perion::{Field, Model, Points, Simulation};
use proptest::prelude::*;

use crate::random::Random;

/// How far points pull on each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Horizons {
    /// Alike everywhere.
    Uniform,
    /// The model's, one per material.
    PerMaterial,
    /// Each point its own.
    PerPoint,
}

/// What `proptest` draws.
#[derive(Debug, Clone)]
pub struct Recipe {
    pub dimension: usize,
    pub counts: [usize; 3],
    /// Points stand up to this share of the spacing off the lattice; above 0, a tenth is left out.
    pub jitter: f64,
    pub horizons: Horizons,
    pub materials: usize,
    pub plane_stress: bool,
    /// Decimal exponents of length, modulus and density: no unit may matter.
    pub units: [i32; 3],
    pub seed: u64,
}

/// A material's constants.
#[derive(Debug, Clone, Copy)]
pub struct Material {
    pub density: f64,
    pub youngs_modulus: f64,
    pub horizon: f64,
    pub thickness: f64,
}

/// A body, ready to be simulated.
#[derive(Debug, Clone)]
pub struct Scene {
    pub dimension: usize,
    pub spacing: f64,
    pub coordinates: Vec<f64>,
    pub volumes: Vec<f64>,
    pub horizons: Option<Vec<f64>>,
    pub materials: Vec<Material>,
    /// Points of the second material.
    pub second: Vec<usize>,
    /// The thirds of the body with the lowest and the highest x, in random order.
    pub ends: [Vec<usize>; 2],
    pub plane_stress: bool,
    pub seed: u64,
}

/// Clouds and lattices of 20 to about 200 points.
pub fn bodies() -> impl Strategy<Value = Recipe> {
    let shape = prop_oneof![
        (5..14_usize, 5..14_usize).prop_map(|(nx, ny)| (2, [nx, ny, 1])),
        (3..7_usize, 3..6_usize, 3..6_usize).prop_map(|(nx, ny, nz)| (3, [nx, ny, nz])),
    ];
    of_shape(shape)
}

/// Smaller bodies, among them bars and plates one point thick, for long runs.
pub fn small_bodies() -> impl Strategy<Value = Recipe> {
    let shape = prop_oneof![
        (4..9_usize, 1..8_usize).prop_map(|(nx, ny)| (2, [nx, ny, 1])),
        (3..5_usize, 2..5_usize, 2..4_usize).prop_map(|(nx, ny, nz)| (3, [nx, ny, nz])),
        (4..8_usize, 3..7_usize).prop_map(|(nx, ny)| (3, [nx, ny, 1])),
    ];
    of_shape(shape)
}

fn of_shape(shape: impl Strategy<Value = (usize, [usize; 3])>) -> impl Strategy<Value = Recipe> {
    let horizons = prop_oneof![
        Just(Horizons::Uniform),
        Just(Horizons::PerMaterial),
        Just(Horizons::PerPoint),
    ];
    let jitter = prop_oneof![1 => Just(0.0), 3 => Just(0.25)];
    let units = [-4..3_i32, 0..12_i32, 0..5_i32];
    (shape, jitter, horizons, 1..3_usize, any::<bool>(), units, any::<u64>()).prop_map(
        |((dimension, counts), jitter, horizons, materials, plane_stress, units, seed)| Recipe {
            dimension,
            counts,
            jitter,
            horizons,
            materials,
            plane_stress,
            units,
            seed,
        },
    )
}

impl Recipe {
    /// The body.
    pub fn scene(&self) -> Scene {
        let mut random = Random(self.seed);
        let dimension = self.dimension;
        let unit = |place: usize| 10_f64.powi(self.units[place]);
        let spacing = unit(0) * random.between(1.0, 3.0);
        let offset = random.around_zero(dimension, 20.0 * spacing);
        let (mut coordinates, mut volumes) = (Vec::new(), Vec::new());
        let [nx, ny, nz] = self.counts;
        // Thrown together in random order: the host's order must not matter.
        for cell in random.order(nx * ny * nz) {
            if self.jitter > 0.0 && cell > 3 && random.chance(0.1) {
                continue;
            }
            let index = [cell % nx, cell / nx % ny, cell / nx / ny];
            let flat = |axis: usize| self.counts[axis] == 1;
            for axis in 0..dimension {
                let jitter = if flat(axis) { 0.0 } else { self.jitter };
                let cells = index[axis] as f64 + random.between(-jitter, jitter);
                coordinates.push(offset[axis] + spacing * cells);
            }
            let share = if self.jitter > 0.0 { random.between(0.5, 1.5) } else { 1.0 };
            volumes.push(share * spacing.powi(dimension as i32));
        }
        let count = volumes.len();
        let mut material = |factor: f64| Material {
            density: factor * unit(2) * random.between(1.0, 3.0),
            youngs_modulus: factor * unit(1) * random.between(1.0, 3.0),
            horizon: spacing * random.between(2.1, 3.2),
            thickness: if dimension == 2 { random.between(0.3, 2.0) } else { 1.0 },
        };
        let mut materials: Vec<Material> =
            [1.0, 4.0].iter().take(self.materials).map(|&factor| material(factor)).collect();
        if self.horizons != Horizons::PerMaterial {
            let horizon = materials[0].horizon;
            materials.iter_mut().for_each(|material| material.horizon = horizon);
        }
        let second = (0..count).filter(|_| self.materials == 2 && random.chance(0.4)).collect();
        let own = |random: &mut Random| spacing * random.between(1.6, 3.3);
        let horizons = (self.horizons == Horizons::PerPoint)
            .then(|| (0..count).map(|_| own(&mut random)).collect());
        let mut along: Vec<usize> = (0..count).collect();
        along.sort_by(|&a, &b| {
            coordinates[a * dimension].total_cmp(&coordinates[b * dimension]).then(a.cmp(&b))
        });
        let third = (count / 3).max(1);
        let ends = [&along[..third], &along[count - third..]]
            .map(|end| random.order(third).iter().map(|&place| end[place]).collect());
        Scene {
            dimension,
            spacing,
            coordinates,
            volumes,
            horizons,
            materials,
            second,
            ends,
            plane_stress: self.plane_stress,
            seed: self.seed,
        }
    }
}

impl Scene {
    pub fn count(&self) -> usize {
        self.volumes.len()
    }

    /// Number of components of a vector field.
    pub fn components(&self) -> usize {
        self.coordinates.len()
    }

    /// Random numbers of this scene; `purpose` tells streams apart.
    pub fn random(&self, purpose: u64) -> Random {
        Random(self.seed ^ purpose.wrapping_mul(0x2545_f491_4f6c_dd1d))
    }

    /// The larger of the materials' bulk moduli.
    pub fn bulk_modulus(&self) -> f64 {
        let ratio = if self.dimension == 2 && self.plane_stress { 1.0 / 3.0 } else { 0.25 };
        let bulk = |material: &Material| material.youngs_modulus / (3.0 * (1.0 - 2.0 * ratio));
        self.materials.iter().map(bulk).fold(0.0, f64::max)
    }

    /// The largest horizon.
    pub fn largest_horizon(&self) -> f64 {
        match &self.horizons {
            Some(own) => own.iter().copied().fold(0.0, f64::max),
            None => self.materials.iter().map(|material| material.horizon).fold(0.0, f64::max),
        }
    }

    pub fn model(&self, number: usize, critical_stretch: Option<f64>) -> Model {
        let material = &self.materials[number];
        let mut model = Model::new("bond_based").unwrap();
        model.set("density", material.density).unwrap();
        model.set("youngs_modulus", material.youngs_modulus).unwrap();
        model.set("horizon", material.horizon).unwrap();
        if self.dimension == 2 {
            model.set("thickness", material.thickness).unwrap();
            model.choose("plane", if self.plane_stress { "stress" } else { "strain" }).unwrap();
        }
        if let Some(stretch) = critical_stretch {
            model.set("critical_stretch", stretch).unwrap();
        }
        model
    }

    /// Points with the sets `left`, `right` and, of two materials, `second`.
    pub fn points(&self) -> Points {
        let mut points = Points::new(self.dimension, &self.coordinates, &self.volumes).unwrap();
        if let Some(horizons) = &self.horizons {
            points.set_horizons(horizons).unwrap();
        }
        for (name, set) in [("left", &self.ends[0]), ("right", &self.ends[1])] {
            points.add_set(name, set).unwrap();
        }
        if !self.second.is_empty() {
            points.add_set("second", &self.second).unwrap();
        }
        points
    }

    /// Ready to run, on one thread; bonds break at `critical_stretch`, if at all.
    pub fn simulation(&self, critical_stretch: Option<f64>) -> Simulation {
        let first = self.model(0, critical_stretch);
        let mut simulation = Simulation::new(&self.points(), &first).unwrap();
        simulation.set_threads(1).unwrap();
        if !self.second.is_empty() {
            simulation.assign_model("second", &self.model(1, critical_stretch)).unwrap();
        }
        simulation
    }

    /// Reference length times both volumes of a pair: what a bond's energy goes with.
    pub fn bond_weight(&self, [i, j]: [usize; 2]) -> f64 {
        let place = |point: usize| self.coordinates[point * self.dimension..].iter();
        let squares = place(i).zip(place(j)).take(self.dimension).map(|(x, y)| (x - y).powi(2));
        squares.sum::<f64>().sqrt() * self.volumes[i] * self.volumes[j]
    }

    /// Breaks a tenth of the bonds and weakens a fifth of them.
    pub fn wound(&self, simulation: &mut Simulation) {
        let mut random = self.random(77);
        let (mut broken, mut weak, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for (pair, _, _) in bonds(simulation) {
            if random.chance(0.1) {
                broken.push(pair);
            } else if random.chance(0.2) {
                weak.push(pair);
                values.push(random.between(0.0, 1.0));
            }
        }
        simulation.break_bonds(&broken).unwrap();
        simulation.set_bond_integrity(&weak, &values).unwrap();
    }
}

/// All bonds: pair, stretch, integrity.
pub fn bonds(simulation: &Simulation) -> Vec<([usize; 2], f64, f64)> {
    let mut bonds = Vec::new();
    simulation
        .for_each_bond(|pair, stretch, integrity| bonds.push((pair, stretch, integrity)))
        .unwrap();
    bonds
}

/// The bits of a field.
pub fn bits(simulation: &Simulation, field: Field) -> Vec<u64> {
    simulation.get(field).unwrap().into_iter().map(f64::to_bits).collect()
}

/// The bits of all that moves and breaks, and of the account of energy.
pub fn state_bits(simulation: &Simulation) -> Vec<Vec<u64>> {
    let fields = [
        Field::Displacement,
        Field::Velocity,
        Field::Damage,
        Field::InternalForce,
        Field::StrainEnergyDensity,
        Field::DissipatedEnergyDensity,
    ];
    let mut state: Vec<Vec<u64>> = fields.iter().map(|&field| bits(simulation, field)).collect();
    let energy = simulation.energy().unwrap();
    let numbers = [
        energy.kinetic,
        energy.elastic,
        energy.dissipated,
        energy.external_work,
        simulation.time(),
    ];
    state.push(numbers.map(f64::to_bits).to_vec());
    state.push(vec![energy.closure_error.to_bits(), simulation.step_count()]);
    state
}
