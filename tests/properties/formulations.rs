//! What holds for every formulation, on bodies of fixed seeds: clouds with unequal volumes, horizons and
//! materials, with broken and weakened bonds.
//!
//! A tolerance is for the worst formulation on the worst body; what was measured stands beside it.

mod affine;
mod controls;
mod degenerate;
mod energies;
mod host_law;
mod ledger;
mod levels;
mod lps_plastic;
mod materials;
mod memory;
mod motion;
mod partial_volume;
mod precision;
mod smoothed;
mod storage;
mod surface;
mod zigzag;

use perion::{Field, Model, Simulation};

use crate::forces::cross;
use crate::random::Random;
use crate::scene::{Horizons, Material, Recipe, Scene};

/// A formulation, and the order of its gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    pub name: &'static str,
    pub order: u32,
}

/// All whose forces are the slope of an energy; the updated Lagrangian form with undeformed bonds.
const FORMS: [Form; 12] = [
    Form { name: "bond_based", order: 1 },
    Form { name: "ordinary_state_based", order: 1 },
    Form { name: "madenci_oterkus", order: 1 },
    Form { name: "correspondence", order: 1 },
    Form { name: "correspondence", order: 2 },
    Form { name: "correspondence_silling", order: 1 },
    Form { name: "correspondence_wan", order: 1 },
    Form { name: "bond_associated", order: 1 },
    Form { name: "bond_associated_quadrature", order: 1 },
    Form { name: "bond_associated_quadrature", order: 2 },
    Form { name: "total_lagrangian", order: 1 },
    Form { name: "updated_lagrangian", order: 1 },
];

impl Form {
    /// Whether it asks a material law.
    pub fn has_law(self) -> bool {
        ["correspondence", "bond_associated", "total_", "updated_"]
            .iter()
            .any(|start| self.name.starts_with(start))
    }

    fn has_influence(self) -> bool {
        self.has_law() || self.name == "ordinary_state_based"
    }

    /// Wan's penalty takes the axes of the reference body with it only where families are even [P 4.13].
    pub fn is_objective(self) -> bool {
        self.name != "correspondence_wan"
    }

    fn fits(self, dimension: usize) -> bool {
        dimension == 3 || self.name != "madenci_oterkus"
    }
}

/// The formulations there are in a body of so many dimensions.
pub fn forms(dimension: usize) -> impl Iterator<Item = Form> {
    FORMS.into_iter().filter(move |form| form.fits(dimension))
}

/// A scene and what it is made of.
#[derive(Debug, Clone)]
pub struct Body {
    pub scene: Scene,
    /// Influence function of each material.
    pub influences: [&'static str; 2],
    pub law: &'static str,
    /// Points at the rim of the horizon count in part.
    pub partial_volume: bool,
}

/// Poisson's ratio of each material, where the formulation leaves the choice.
pub const RATIOS: [f64; 2] = [0.31, 0.18];

pub const INFLUENCES: [&str; 4] = ["constant", "inverse", "conical", "cubic_spline"];

/// Bodies in 3D, plane strain and plane stress; each kind of influence function, horizon, rim and law is among them.
pub fn bodies() -> Vec<Body> {
    let mut bodies = Vec::new();
    for number in 0..12 {
        let (state, turn) = (number % 3, number / 3);
        let counts = if state == 0 { [5, 4, 4] } else { [8, 7, 1] };
        let recipe = Recipe {
            dimension: if state == 0 { 3 } else { 2 },
            counts,
            jitter: 0.25,
            horizons: [Horizons::Uniform, Horizons::PerMaterial, Horizons::PerPoint]
                [(state + turn) % 3],
            materials: 1 + usize::from(turn % 2 == 1),
            plane_stress: state == 2,
            units: [turn as i32 - 2, 3 * state as i32, 0],
            seed: 1000 + number as u64,
        };
        bodies.push(Body {
            scene: recipe.scene(),
            influences: [INFLUENCES[(turn + state) % 4], INFLUENCES[turn % 4]],
            law: ["saint_venant_kirchhoff", "neo_hookean"][(turn / 2 + state) % 2],
            partial_volume: (state + 2 * turn) % 5 == 1,
        });
    }
    bodies
}

impl Body {
    pub fn with_law(mut self, law: &'static str) -> Self {
        self.law = law;
        self
    }

    /// The model of a material.
    pub fn model(&self, form: Form, number: usize) -> Model {
        let (scene, material) = (&self.scene, &self.scene.materials[number]);
        let mut model = Model::new(form.name).unwrap();
        model.set("density", material.density).unwrap();
        model.set("youngs_modulus", material.youngs_modulus).unwrap();
        model.set("horizon", material.horizon).unwrap();
        if form.name != "bond_based" {
            model.set("poissons_ratio", RATIOS[number]).unwrap();
        }
        if scene.dimension == 2 {
            model.set("thickness", material.thickness).unwrap();
            model.choose("plane", if scene.plane_stress { "stress" } else { "strain" }).unwrap();
        }
        if form.has_influence() {
            model.choose("influence", self.influences[number]).unwrap();
        }
        if form.has_law() {
            model.choose("material", self.law).unwrap();
        }
        if self.partial_volume {
            model.choose("partial_volume", "linear").unwrap();
        }
        if form.name == "updated_lagrangian" {
            model.choose("operator_bonds", "undeformed").unwrap();
        }
        if form.order != 1 {
            model.set("gradient_order", f64::from(form.order)).unwrap();
        }
        model
    }

    /// Ready to run, on one thread, with what `change` does to the models.
    pub fn changed(&self, form: Form, change: impl Fn(&mut Model)) -> Simulation {
        let mut models = [0, self.scene.materials.len() - 1].map(|number| self.model(form, number));
        models.iter_mut().for_each(change);
        let mut simulation = Simulation::new(&self.scene.points(), &models[0]).unwrap();
        simulation.set_threads(1).unwrap();
        if !self.scene.second.is_empty() {
            simulation.assign_model("second", &models[1]).unwrap();
        }
        simulation
    }

    /// Ready to run, on one thread.
    pub fn simulation(&self, form: Form) -> Simulation {
        self.changed(form, |_| {})
    }

    /// With a tenth of the bonds broken and a fifth weakened.
    pub fn wounded(&self, form: Form) -> Simulation {
        let mut simulation = self.simulation(form);
        self.scene.wound(&mut simulation);
        simulation
    }

    /// Displacements without order, of up to a twentieth of the spacing an axis.
    pub fn shaken(&self) -> Vec<f64> {
        self.scene.random(5).around_zero(self.scene.components(), 0.05 * self.scene.spacing)
    }

    pub fn youngs_modulus(&self) -> f64 {
        let moduli = self.scene.materials.iter().map(|material| material.youngs_modulus);
        moduli.fold(0.0, f64::max)
    }
}

/// A body of one material from places; volumes of 1.
pub fn body_at(dimension: usize, coordinates: Vec<f64>, horizon: f64) -> Body {
    let recipe = Recipe {
        dimension,
        counts: [1, 1, 1],
        jitter: 0.0,
        horizons: Horizons::Uniform,
        materials: 1,
        plane_stress: false,
        units: [0, 0, 0],
        seed: 7,
    };
    let mut scene = recipe.scene();
    let count = coordinates.len() / dimension;
    (scene.spacing, scene.coordinates, scene.volumes) = (1.0, coordinates, vec![1.0; count]);
    scene.ends = [vec![0], vec![count - 1]];
    scene.materials[0] = Material { density: 1.3, youngs_modulus: 1.7, horizon, thickness: 1.0 };
    Body {
        scene,
        influences: ["constant"; 2],
        law: "saint_venant_kirchhoff",
        partial_volume: false,
    }
}

/// Places of a lattice with spacing 1.
pub fn lattice(dimension: usize, counts: [usize; 3]) -> Vec<f64> {
    let [nx, ny, nz] = counts;
    let index = |cell: usize| [cell % nx, cell / nx % ny, cell / nx / ny];
    let places = (0..nx * ny * nz).flat_map(|cell| index(cell).into_iter().take(dimension));
    places.map(|place| place as f64).collect()
}

/// A turn about an axis.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    pub axis: [f64; 3],
    pub angle: f64,
}

impl Turn {
    pub fn random(dimension: usize, random: &mut Random) -> Self {
        let axis = [0, 1, 2].map(|_| random.between(-1.0, 1.0));
        let axis = if dimension == 2 { [0.0, 0.0, 1.0] } else { axis };
        Self { axis, angle: random.between(0.3, 3.0) }
    }

    /// (R - 1) v for each vector: sin a k x v + (1 - cos a) k x (k x v), small where the angle is.
    pub fn change(self, dimension: usize, vectors: &[f64]) -> Vec<f64> {
        let size = self.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        let axis = self.axis.map(|x| x / size);
        let share = 2.0 * (0.5 * self.angle).sin().powi(2);
        let mut change = Vec::new();
        for vector in vectors.chunks_exact(dimension) {
            let once = cross(&axis, vector);
            let twice = cross(&axis, &once);
            change.extend((0..dimension).map(|k| self.angle.sin() * once[k] + share * twice[k]));
        }
        change
    }

    /// R v for each vector.
    pub fn turned(self, dimension: usize, vectors: &[f64]) -> Vec<f64> {
        let change = self.change(dimension, vectors);
        change.iter().zip(vectors).map(|(change, v)| v + change).collect()
    }

    /// Displacements of a body that, moved by `moved`, is turned about its first point and shifted.
    pub fn displacement(self, scene: &Scene, moved: &[f64]) -> Vec<f64> {
        let dimension = scene.dimension;
        let first = scene.coordinates[..dimension].iter().cycle();
        let arms: Vec<f64> = scene.coordinates.iter().zip(first).map(|(x, p)| x - p).collect();
        let shift = [0.3, -0.7, 0.2].map(|share| share * scene.spacing);
        let (arms, moved) = (self.change(dimension, &arms), self.turned(dimension, moved));
        let both = arms.iter().zip(&moved).enumerate();
        both.map(|(place, (a, b))| a + b + shift[place % dimension]).collect()
    }
}

pub fn largest(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0.0, |most, value| if value.is_nan() { f64::NAN } else { value.abs().max(most) })
}

/// The largest difference of two lists.
pub fn apart(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    largest(&one.iter().zip(other).map(|(a, b)| a - b).collect::<Vec<f64>>())
}

/// W of the material and of the penalty, point after point.
pub fn energy_densities(simulation: &Simulation) -> Vec<f64> {
    let [strain, penalty] = [Field::StrainEnergyDensity, Field::StabilizationEnergyDensity]
        .map(|field| simulation.get(field).unwrap());
    strain.iter().zip(&penalty).map(|(a, b)| a + b).collect()
}

/// The largest deviation of each formulation on the bodies that it fits, held to a tolerance.
pub fn hold(
    what: &str,
    bodies: &[Body],
    tolerance: impl Fn(Form) -> Option<f64>,
    mut deviation: impl FnMut(Form, &Body) -> f64,
) {
    let mut failures = Vec::new();
    for form in FORMS {
        let Some(tolerance) = tolerance(form) else { continue };
        let (mut worst, mut on) = (0.0, 0);
        for (number, body) in bodies.iter().enumerate() {
            if !form.fits(body.scene.dimension) {
                continue;
            }
            let found = deviation(form, body);
            if found > worst || found.is_nan() {
                (worst, on) = (if found.is_nan() { f64::INFINITY } else { found }, number);
            }
        }
        let line = format!("{what}: {} {}: {worst:.1e} on body {on}", form.name, form.order);
        eprintln!("{line}");
        if worst > tolerance {
            failures.push(format!("{line}, allowed {tolerance:.0e}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
