//! Reads the reference data, makes bodies of it, and holds numbers against it.

use perion::{Model, Points, Simulation};
use serde_json::Value;

/// Deformed clouds and lattices in 3D, whole and with broken bonds.
pub const SOLIDS: [&str; 3] =
    ["mech3d_jitter_const_intact", "mech3d_jitter_const_broken", "mech3d_lattice_const"];

/// Deformed clouds in 2D, in both plane states, whole and with broken bonds.
pub const PLATES: [&str; 4] = [
    "mech2d_jitter_strain_intact",
    "mech2d_jitter_strain_broken",
    "mech2d_jitter_stress_intact",
    "mech2d_jitter_stress_broken",
];

/// One file of `tests/data`. Keys are JSON pointers without the first slash.
pub struct Reference {
    name: String,
    root: Value,
}

impl Reference {
    pub fn load(name: &str) -> Self {
        let path = format!("{}/tests/data/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        Self { name: name.to_owned(), root: serde_json::from_str(&text).unwrap() }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn value(&self, key: &str) -> &Value {
        let found = self.root.pointer(&format!("/{key}"));
        found.unwrap_or_else(|| panic!("{} has no '{key}'", self.name))
    }

    pub fn number(&self, key: &str) -> f64 {
        self.value(key).as_f64().unwrap()
    }

    pub fn numbers(&self, key: &str) -> Vec<f64> {
        let list = self.value(key).as_array().unwrap();
        list.iter().map(|value| value.as_f64().unwrap()).collect()
    }

    pub fn dimension(&self) -> usize {
        self.number("dimension") as usize
    }

    pub fn points(&self) -> Points {
        let (positions, volumes) = (self.numbers("positions"), self.numbers("volumes"));
        Points::new(self.dimension(), &positions, &volumes).unwrap()
    }

    pub fn broken_pairs(&self) -> Vec<[usize; 2]> {
        let pairs = self.value("broken_pairs").as_array().unwrap();
        let index = |value: &Value| value.as_u64().unwrap() as usize;
        pairs.iter().map(|pair| [index(&pair[0]), index(&pair[1])]).collect()
    }

    /// The displacement that takes the reference positions to the current ones.
    pub fn displacement(&self) -> Vec<f64> {
        difference(&self.numbers("current"), &self.numbers("positions"))
    }

    /// A bond-based model. The reference takes the bond constant of a solid from its bulk modulus and
    /// that of a plate from Young's modulus, whatever Poisson's ratio the other formulations have.
    pub fn model(&self) -> Model {
        let mut model = Model::new("bond_based").unwrap();
        model.set("density", 1.0).unwrap();
        model.set("horizon", self.number("horizon")).unwrap();
        if self.dimension() == 3 {
            model.set("bulk_modulus", self.number("bulk_modulus")).unwrap();
        } else {
            model.set("youngs_modulus", self.number("youngs_modulus")).unwrap();
            model.choose("plane", self.value("plane").as_str().unwrap()).unwrap();
        }
        model
    }

    /// The deformed body with its broken bonds.
    pub fn body(&self) -> Simulation {
        self.body_of(&self.model())
    }

    pub fn body_of(&self, model: &Model) -> Simulation {
        let mut body = Simulation::new(&self.points(), model).unwrap();
        body.break_bonds(&self.broken_pairs()).unwrap();
        body.set(perion::Field::Position, &self.numbers("current")).unwrap();
        body
    }
}

/// Two points on the first axis, a `length` apart, each of volume (in 2D area) 1.
pub fn pair(dimension: usize, length: f64) -> Points {
    let mut positions = vec![0.0; 2 * dimension];
    positions[dimension] = length;
    Points::new(dimension, &positions, &[1.0, 1.0]).unwrap()
}

pub fn difference(of: &[f64], and: &[f64]) -> Vec<f64> {
    of.iter().zip(and).map(|(of, and)| of - and).collect()
}

pub fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|value| factor * value).collect()
}

pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}

/// Holds every number to `tolerance` times the largest magnitude expected.
#[track_caller]
pub fn assert_close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}: number of values");
    let allowed = tolerance * largest(expected);
    for (place, (found, expected)) in found.iter().zip(expected).enumerate() {
        let error = (found - expected).abs();
        assert!(
            error <= allowed,
            "{what}, value {place}: {found:e}, not {expected:e}; off by {error:e}, allowed {allowed:e}"
        );
    }
}

/// Holds one number to a relative `tolerance`.
#[track_caller]
pub fn assert_near(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert_close(what, &[found], &[expected], tolerance);
}
