//! Bonds: who is in a family, when bonds break, and what their integrity weighs.

use std::f64::consts::PI;

use perion::{Field, Model, Points, Simulation};
use proptest::prelude::*;

use crate::random::{Random, cases};
use crate::scene::{Scene, bodies, bonds, small_bodies, state_bits};

/// The horizon of each point.
fn horizons(scene: &Scene) -> Vec<f64> {
    let material = |point: usize| &scene.materials[usize::from(scene.second.contains(&point))];
    let own = |point: usize| scene.horizons.as_ref().map(|own| own[point]);
    (0..scene.count()).map(|point| own(point).unwrap_or(material(point).horizon)).collect()
}

/// The critical stretch of each point for energy release rates of the two materials. [P 3.8-3.11]
fn critical_stretches(scene: &Scene, rates: [f64; 2]) -> Vec<f64> {
    let stretch = |(point, horizon): (usize, f64)| {
        let number = usize::from(scene.second.contains(&point));
        let (rate, e) = (rates[number], scene.materials[number].youngs_modulus);
        let squared = match (scene.dimension, scene.plane_stress) {
            // K = 2 E/3 for Poisson's ratio 1/4.
            (3, _) => 5.0 * rate / (9.0 * (2.0 * e / 3.0) * horizon),
            (_, true) => 4.0 * PI * rate / (9.0 * e * horizon),
            (_, false) => 5.0 * PI * rate / (12.0 * e * horizon),
        };
        squared.sqrt()
    };
    horizons(scene).into_iter().enumerate().map(stretch).collect()
}

/// Reference vector of a pair, and its vector after a displacement.
fn vectors(scene: &Scene, u: &[f64], [i, j]: [usize; 2]) -> (Vec<f64>, Vec<f64>) {
    let d = scene.dimension;
    let difference = |values: &[f64], axis: usize| values[j * d + axis] - values[i * d + axis];
    let reference: Vec<f64> = (0..d).map(|axis| difference(&scene.coordinates, axis)).collect();
    let now = (0..d).map(|axis| reference[axis] + difference(u, axis)).collect();
    (reference, now)
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn bonds_join_points_within_either_horizon(recipe in bodies(), wound: bool) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(None);
        if wound {
            scene.wound(&mut simulation);
        }
        let u = scene.random(70).around_zero(scene.components(), 0.1 * scene.spacing);
        simulation.set(Field::Displacement, &u).unwrap();
        let horizons = horizons(&scene);
        let volumes = simulation.get(Field::Volume).unwrap();
        let mut expected = Vec::new();
        let mut neighbors = vec![0.0; scene.count()];
        for i in 0..scene.count() {
            for j in i + 1..scene.count() {
                let reference = length(&vectors(&scene, &u, [i, j]).0);
                let within = [i, j].map(|point| reference <= horizons[point] * (1.0 + 1e-10));
                if within[0] || within[1] {
                    expected.push([i, j]);
                }
                neighbors[i] += f64::from(u8::from(within[0]));
                neighbors[j] += f64::from(u8::from(within[1]));
            }
        }
        let mut found = Vec::new();
        let mut family = vec![(0.0, 0.0); scene.count()];
        for ([i, j], stretch, integrity) in bonds(&simulation) {
            found.push([i.min(j), i.max(j)]);
            let (reference, now) = vectors(&scene, &u, [i, j]);
            let own = length(&now) / length(&reference) - 1.0;
            prop_assert!((own - stretch).abs() < 1e-12, "{own} {stretch}");
            for (point, other) in [(i, j), (j, i)] {
                if length(&reference) <= horizons[point] * (1.0 + 1e-10) {
                    family[point].0 += integrity * volumes[other];
                    family[point].1 += volumes[other];
                }
            }
        }
        found.sort_unstable();
        prop_assert_eq!(&found, &expected);
        prop_assert_eq!(simulation.bond_count().unwrap(), expected.len() as u64);
        prop_assert_eq!(simulation.get(Field::NeighborCount).unwrap(), neighbors);
        let damage = simulation.get(Field::Damage).unwrap();
        for (point, (held, whole)) in family.into_iter().enumerate() {
            let expected = if whole > 0.0 { 1.0 - held / whole } else { 0.0 };
            prop_assert!((damage[point] - expected).abs() < 1e-13);
        }
    }

    #[test]
    fn no_bond_with_an_end_in_a_set_that_must_not_fail_breaks_by_stretch(
        recipe in bodies(), late: bool, step: bool,
    ) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(Some(0.01));
        if late {
            simulation.evaluate().unwrap();
        }
        simulation.forbid_failure("left").unwrap();
        simulation.forbid_failure("right").unwrap();
        let u = scene.random(71).around_zero(scene.components(), 0.05 * scene.spacing);
        simulation.set(Field::Displacement, &u).unwrap();
        if step {
            // So short that nothing moves by more than rounding.
            let tiny = 1e-9 * simulation.stable_time_step().unwrap();
            simulation.step(tiny, 1).unwrap();
        } else {
            simulation.commit(0.0).unwrap();
        }
        let held = |point: &usize| scene.ends.iter().any(|end| end.contains(point));
        let mut protected = Vec::new();
        let (mut kept, mut broken) = (0, 0);
        for (pair, stretch, integrity) in bonds(&simulation) {
            let safe = pair.iter().any(held);
            prop_assert_eq!(integrity, if safe || stretch <= 0.01 { 1.0 } else { 0.0 });
            kept += usize::from(safe && stretch > 0.01);
            broken += usize::from(integrity == 0.0);
            if safe {
                protected.push(pair);
            }
        }
        prop_assert!(kept > 0 && broken > 0);
        simulation.break_bonds(&protected[..1]).unwrap();
        let (first, rest) = (protected[0], protected.len() - 1);
        let left = |simulation: &Simulation| {
            let bonds = bonds(simulation).into_iter();
            bonds.filter(|(pair, _, d)| *d == 1.0 && protected.contains(pair)).count()
        };
        prop_assert_eq!(left(&simulation), rest);
        let all = bonds(&simulation);
        prop_assert!(all.iter().any(|&(pair, _, d)| pair == first && d == 0.0));
        simulation.break_bonds(&protected).unwrap();
        prop_assert_eq!(left(&simulation), 0);
    }

    #[test]
    fn bonds_break_at_the_smaller_critical_stretch_of_their_ends_or_that_of_their_interface(
        recipe in small_bodies(), interface: bool, brittle: bool,
    ) {
        let scene = recipe.scene();
        let scale = scene.bulk_modulus() * scene.spacing;
        let mut random = scene.random(72);
        let rates = [1e-4, 3e-4].map(|rate| rate * scale * random.between(0.5, 2.0));
        let across = 1e-4 * scale * random.between(0.5, 2.0);
        let model = |number: usize| {
            let mut model = scene.model(number, None);
            if brittle {
                model.set("critical_energy_release_rate", rates[number]).unwrap();
            }
            model
        };
        let mut simulation = Simulation::new(&scene.points(), &model(0)).unwrap();
        if !scene.second.is_empty() {
            simulation.assign_model("second", &model(1)).unwrap();
        }
        if interface {
            simulation.set_interface("left", "right", across).unwrap();
            simulation.set_interface("left", "left", across).unwrap();
        }
        let u = random.around_zero(scene.components(), 0.02 * scene.spacing);
        simulation.set(Field::Displacement, &u).unwrap();
        simulation.commit(0.0).unwrap();
        let infinite = vec![f64::INFINITY; scene.count()];
        let ends = if brittle { critical_stretches(&scene, rates) } else { infinite };
        let own = critical_stretches(&scene, [across; 2]);
        let [left, right] = &scene.ends;
        for ([i, j], stretch, integrity) in bonds(&simulation) {
            let between = |a: &Vec<usize>, b: &Vec<usize>| {
                (a.contains(&i) && b.contains(&j)) || (a.contains(&j) && b.contains(&i))
            };
            let (low, high) = if interface && (between(left, right) || between(left, left)) {
                // Unlike materials share the interface: it breaks between what each would take.
                (own[i].min(own[j]), own[i].max(own[j]))
            } else {
                (ends[i].min(ends[j]), ends[i].min(ends[j]))
            };
            let broken = integrity == 0.0;
            if stretch > high * (1.0 + 1e-12) {
                prop_assert!(broken, "{stretch} {high}");
            } else if stretch < low * (1.0 - 1e-12) {
                prop_assert!(!broken, "{stretch} {low}");
            }
        }
    }

    #[test]
    fn bonds_changed_before_set_up_ends_are_changed_as_after_it(recipe in small_bodies()) {
        let scene = recipe.scene();
        let mut after = scene.simulation(Some(0.02));
        scene.wound(&mut after);
        let mut before = scene.simulation(Some(0.02));
        let (mut broken, mut weak, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for ([i, j], _, integrity) in bonds(&after) {
            if integrity == 0.0 {
                broken.push([j, i]);
            } else if integrity < 1.0 {
                weak.push([j, i]);
                values.push(integrity);
            }
        }
        before.set_bond_integrity(&weak, &values).unwrap();
        before.break_bonds(&broken).unwrap();
        let step = 0.8 * after.stable_time_step().unwrap();
        prop_assert_eq!(step, 0.8 * before.stable_time_step().unwrap());
        let size = 0.05 * scene.spacing / step;
        let start = scene.random(73).around_zero(scene.components(), size);
        for simulation in [&mut after, &mut before] {
            simulation.set(Field::Velocity, &start).unwrap();
            simulation.step(step, 20).unwrap();
        }
        prop_assert_eq!(state_bits(&after), state_bits(&before));
    }

    #[test]
    fn two_points_of_two_materials_pull_with_the_mean_bond_constant(
        dimension in 2..4_usize, stress: bool, seed: u64,
    ) {
        let mut random = Random(seed);
        let length = random.between(0.5, 2.0);
        let mut coordinates = vec![0.3; 2 * dimension];
        coordinates[dimension] += length;
        let volumes = [random.between(0.1, 2.0), random.between(0.1, 2.0)];
        let mut points = Points::new(dimension, &coordinates, &volumes).unwrap();
        points.add_set("second", &[1]).unwrap();
        let thickness = if dimension == 2 { random.between(0.5, 2.0) } else { 1.0 };
        let mut constants = [0.0; 2];
        let mut models = Vec::new();
        for constant in &mut constants {
            let (e, horizon) = (random.between(1.0, 9.0), length * random.between(0.7, 2.0));
            let mut model = Model::new("bond_based").unwrap();
            for (key, value) in [("density", 1.0), ("youngs_modulus", e), ("horizon", horizon)] {
                model.set(key, value).unwrap();
            }
            if dimension == 2 {
                model.set("thickness", thickness).unwrap();
                model.choose("plane", if stress { "stress" } else { "strain" }).unwrap();
            }
            *constant = match (dimension, stress) {
                _ if horizon < length => 0.0,
                (3, _) => 12.0 * e / (PI * horizon.powi(4)),
                (_, true) => 9.0 * e / (PI * thickness * horizon.powi(3)),
                (_, false) => 9.6 * e / (PI * thickness * horizon.powi(3)),
            };
            models.push(model);
        }
        prop_assume!(constants != [0.0; 2]);
        let mut simulation = Simulation::new(&points, &models[0]).unwrap();
        simulation.assign_model("second", &models[1]).unwrap();
        let integrity = random.between(0.1, 1.0);
        simulation.set_bond_integrity(&[[1, 0]], &[integrity]).unwrap();
        let stretch = random.between(-0.1, 0.1);
        let mut u = vec![0.0; 2 * dimension];
        u[dimension] = stretch * length;
        simulation.set(Field::Displacement, &u).unwrap();
        let force = simulation.get(Field::InternalForce).unwrap();
        let energy = simulation.get(Field::StrainEnergyDensity).unwrap();
        let mean = 0.5 * (constants[0] + constants[1]) * integrity;
        for (point, sign) in [(0, 1.0), (1, -1.0)] {
            let other = volumes[1 - point] * thickness;
            let expected = sign * mean * stretch * other;
            let error = force[point * dimension] - expected;
            prop_assert!(error.abs() <= 1e-13 * expected.abs(), "{error:e} of {expected:e}");
            let own = 0.25 * constants[point] * integrity * stretch * stretch * length * other;
            let error = energy[point] - own;
            prop_assert!(error.abs() <= 1e-13 * own, "{error:e} of {own:e}");
        }
    }
}
