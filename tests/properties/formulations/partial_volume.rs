//! Neighbours at the rim of the horizon that count in part, against sums over all pairs.

use perion::Field;

use super::{Body, Form, apart, bodies, forms, largest};

/// (horizon + h/2 - L)/h between 0 and 1, h the mean edge of both cells.
fn part(length: f64, horizon: f64, edges: [f64; 2]) -> f64 {
    let width = 0.5 * (edges[0] + edges[1]);
    ((horizon + 0.5 * width - length) / width).clamp(0.0, 1.0)
}

struct Pairs<'a> {
    body: &'a Body,
    dimension: usize,
    edges: Vec<f64>,
}

impl<'a> Pairs<'a> {
    fn new(body: &'a Body) -> Self {
        let dimension = body.scene.dimension;
        let edges = body.scene.volumes.iter().map(|v| v.powf(1.0 / dimension as f64)).collect();
        Self { body, dimension, edges }
    }

    fn horizon(&self, point: usize) -> f64 {
        let scene = &self.body.scene;
        let material = usize::from(scene.second.contains(&point));
        scene.horizons.as_ref().map_or(scene.materials[material].horizon, |each| each[point])
    }

    fn bond(&self, from: usize, to: usize, of: &[f64]) -> Vec<f64> {
        let d = self.dimension;
        (0..d).map(|axis| of[to * d + axis] - of[from * d + axis]).collect()
    }

    fn length(&self, from: usize, to: usize) -> f64 {
        let bond = self.bond(from, to, &self.body.scene.coordinates);
        bond.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    fn share(&self, from: usize, to: usize) -> f64 {
        let edges = [self.edges[from], self.edges[to]];
        part(self.length(from, to), self.horizon(from), edges)
    }

    /// Neighbours of a point, and the part of each.
    fn family(&self, point: usize) -> Vec<(usize, f64)> {
        let others = (0..self.edges.len()).filter(|&other| other != point);
        others
            .map(|other| (other, self.share(point, other)))
            .filter(|&(_, part)| part > 0.0)
            .collect()
    }
}

fn with_rim() -> impl Iterator<Item = Body> {
    bodies().into_iter().map(|body| Body { partial_volume: true, ..body })
}

#[test]
fn families_reach_half_a_cell_beyond_the_horizon_and_count_by_parts() {
    for body in with_rim() {
        let pairs = Pairs::new(&body);
        let simulation = body.simulation(Form { name: "correspondence", order: 1 });
        let thickness = body.scene.materials[0].thickness;
        let counts = simulation.get(Field::NeighborCount).unwrap();
        let shapes = simulation.get(Field::ShapeTensor).unwrap();
        let mut in_part = 0;
        for (point, &count) in counts.iter().enumerate() {
            let family = pairs.family(point);
            in_part += family.iter().filter(|(_, part)| *part < 1.0).count();
            assert_eq!(count as usize, family.len(), "point {point}");
            if body.influences != ["constant"; 2] || !body.scene.second.is_empty() {
                continue;
            }
            // K = sum xi xi^T V_j part
            let d = pairs.dimension;
            let mut expected = vec![0.0; d * d];
            for (other, part) in family {
                let bond = pairs.bond(point, other, &body.scene.coordinates);
                let volume = body.scene.volumes[other] * if d == 2 { thickness } else { 1.0 };
                for row in 0..d {
                    for column in 0..d {
                        expected[row * d + column] += part * volume * bond[row] * bond[column];
                    }
                }
            }
            let found = &shapes[point * d * d..(point + 1) * d * d];
            assert!(apart(found, &expected) < 1e-13 * largest(&expected), "point {point}");
        }
        assert!(in_part > counts.len(), "{in_part} neighbours in part");
    }
}

#[test]
fn bonds_pull_by_the_part_that_each_end_sees() {
    // W_i = 1/4 sum c part s^2 L V_j, c of each point's own material and horizon.
    for body in with_rim() {
        let (pairs, scene) = (Pairs::new(&body), &body.scene);
        let mut simulation = body.simulation(Form { name: "bond_based", order: 1 });
        let moved = body.shaken();
        simulation.set(Field::Displacement, &moved).unwrap();
        let energies = simulation.get(Field::StrainEnergyDensity).unwrap();
        let now: Vec<f64> = scene.coordinates.iter().zip(&moved).map(|(x, u)| x + u).collect();
        for (point, &energy) in energies.iter().enumerate() {
            let material = &scene.materials[usize::from(scene.second.contains(&point))];
            let (modulus, horizon) = (material.youngs_modulus, pairs.horizon(point));
            let pi = std::f64::consts::PI;
            let constant = match (scene.dimension, scene.plane_stress) {
                (3, _) => 12.0 * modulus / (pi * horizon.powi(4)),
                (_, true) => 9.0 * modulus / (pi * material.thickness * horizon.powi(3)),
                _ => 48.0 * modulus / (5.0 * pi * material.thickness * horizon.powi(3)),
            };
            let mut expected = 0.0;
            for (other, part) in pairs.family(point) {
                let length = pairs.length(point, other);
                let bond = pairs.bond(point, other, &now);
                let stretch = bond.iter().map(|x| x * x).sum::<f64>().sqrt() / length - 1.0;
                let second = &scene.materials[usize::from(scene.second.contains(&other))];
                let thickness = if scene.dimension == 2 { second.thickness } else { 1.0 };
                let volume = scene.volumes[other] * thickness;
                expected += 0.25 * constant * part * stretch * stretch * length * volume;
            }
            assert!((energy - expected).abs() < 1e-12 * expected, "{energy} {expected}");
        }
    }
}

#[test]
fn a_block_stores_nearer_to_what_its_material_says() {
    // Isotropic stretch of the bulk of a lattice, horizon 3 spacings, on which 30 neighbours lie.
    let stored = |choice: &str| {
        let points = perion::Points::block(3, &[0.0; 3], &[11.0; 3], 1.0).unwrap();
        let mut model = perion::Model::new("bond_based").unwrap();
        model.set("density", 1.0).unwrap();
        model.set("bulk_modulus", 1.0).unwrap();
        model.set("horizon", 3.0).unwrap();
        model.choose("partial_volume", choice).unwrap();
        let mut simulation = perion::Simulation::new(&points, &model).unwrap();
        let moved: Vec<f64> = points.coordinates().iter().map(|x| 1e-3 * x).collect();
        simulation.set(Field::Displacement, &moved).unwrap();
        let middle = (5 * 11 + 5) * 11 + 5;
        // 9/2 K s^2
        simulation.get(Field::StrainEnergyDensity).unwrap()[middle] / (4.5e-6)
    };
    let [sharp, linear] = ["none", "linear"].map(stored);
    // c/4 s^2 sum L V over 9/2 K s^2 is sum L V/(pi horizon^4).
    let sum = |weight: &dyn Fn(f64) -> f64| {
        let mut sum = 0.0;
        for cell in 0..9_i32.pow(3) {
            let place = [cell % 9 - 4, cell / 9 % 9 - 4, cell / 81 - 4].map(f64::from);
            let length = place.iter().map(|x| x * x).sum::<f64>().sqrt();
            sum += weight(length) * length;
        }
        sum / (81.0 * std::f64::consts::PI)
    };
    let expected = [
        sum(&|length| f64::from(u8::from(length <= 3.0))),
        sum(&|length| (3.5 - length).clamp(0.0, 1.0)),
    ];
    // By 1e-16/1e-3, the rounding of a stretch.
    assert!(apart(&[sharp, linear], &expected) < 1e-12, "{sharp} {linear} {expected:?}");
    assert!((sharp - 1.1208).abs() < 1e-4 && (linear - 1.0622).abs() < 1e-4, "{expected:?}");
}

#[test]
fn models_of_one_body_share_the_choice() {
    let body = &bodies()[0];
    for form in forms(3) {
        let mut simulation = body.simulation(form);
        let mut other = body.model(form, 0);
        let choice = if body.partial_volume { "none" } else { "linear" };
        other.choose("partial_volume", choice).unwrap();
        let error = simulation.assign_model("all", &other).unwrap_err().to_string();
        assert!(error.contains("'partial_volume'"), "{error}");
    }
}
