//! Points without bonds: they fly free, and are counted.

use perion::{Field, Model, Points, Quantity, Simulation};
use proptest::prelude::*;

use crate::random::{Random, cases};
use crate::scene::small_bodies;

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn points_without_neighbours_fly_free_and_are_counted(
        recipe in small_bodies(), lonely in 1..6_usize, breaking: bool,
    ) {
        let mut scene = recipe.scene();
        let mut random = scene.random(80);
        let (bound, dimension) = (scene.count(), scene.dimension);
        let body = scene.simulation(None);
        let isolated_before = body.health().unwrap().isolated;
        for number in 0..lonely {
            let far = scene.spacing * 100.0 * (number + 1) as f64;
            let place: Vec<f64> =
                scene.coordinates[..dimension].iter().map(|x| x + far).collect();
            scene.coordinates.extend(place);
            scene.volumes.push(random.between(0.5, 1.5) * scene.volumes[0]);
            scene.horizons.iter_mut().for_each(|own| own.push(2.0 * scene.spacing));
        }
        let mut simulation = scene.simulation(breaking.then_some(0.02));
        let step = 0.9 * simulation.stable_time_step().unwrap();
        let size = 0.05 * scene.spacing / step;
        let start = random.around_zero(scene.components(), size);
        simulation.set(Field::Velocity, &start).unwrap();
        simulation.step(step, 50).unwrap();
        let health = simulation.health().unwrap();
        prop_assert_eq!(health.isolated.count, isolated_before.count + lonely);
        prop_assert_eq!(health.isolated.first, isolated_before.first.or(Some(bound)));
        let displacement = simulation.get(Field::Displacement).unwrap();
        let velocity = simulation.get(Field::Velocity).unwrap();
        for component in bound * dimension..scene.components() {
            prop_assert_eq!(velocity[component], start[component]);
            let flown = start[component] * simulation.time();
            // Fifty sums, each rounded.
            prop_assert!((displacement[component] - flown).abs() <= 1e-14 * flown.abs());
        }
        let lone = |field: Field| {
            let values = simulation.get(field).unwrap();
            let from = values.len() / scene.count() * bound;
            values[from..].to_vec()
        };
        let nothing = [
            Field::InternalForce,
            Field::Acceleration,
            Field::Damage,
            Field::StrainEnergyDensity,
            Field::NeighborCount,
            Field::DissipatedEnergyDensity,
        ];
        for field in nothing {
            prop_assert!(lone(field).iter().all(|&value| value == 0.0), "{}", field.name());
        }
        prop_assert!(lone(Field::TimeStepEstimate).iter().all(|value| value.is_finite()));
    }

    #[test]
    fn a_point_whose_bonds_are_all_broken_is_detached_and_flies_free(recipe in small_bodies()) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(None);
        let mut random = scene.random(81);
        let all = crate::scene::bonds(&simulation);
        let loose = all[random.below(all.len())].0[0];
        let own: Vec<[usize; 2]> =
            all.iter().map(|bond| bond.0).filter(|pair| pair.contains(&loose)).collect();
        simulation.break_bonds(&own).unwrap();
        let health = simulation.health().unwrap();
        prop_assert_eq!(health.broken_bonds, own.len() as u64);
        prop_assert!(health.detached.count >= 1);
        prop_assert!(health.detached.first.unwrap() <= loose);
        prop_assert_eq!(simulation.get(Field::Damage).unwrap()[loose], 1.0);
        let step = simulation.stable_time_step().unwrap().min(1.0);
        let size = 0.01 * scene.spacing / step;
        let start = random.around_zero(scene.components(), size);
        simulation.set(Field::Velocity, &start).unwrap();
        simulation.step(step, 20).unwrap();
        let velocity = simulation.get(Field::Velocity).unwrap();
        let range = loose * scene.dimension..(loose + 1) * scene.dimension;
        prop_assert_eq!(&velocity[range.clone()], &start[range]);
    }

    #[test]
    fn a_single_point_falls_as_galileo_says(
        dimension in 2..4_usize, seed: u64, steps in 1..200_u64,
    ) {
        let mut random = Random(seed);
        let place = random.around_zero(dimension, 5.0);
        let points = Points::new(dimension, &place, &[random.between(0.1, 2.0)]).unwrap();
        let mut model = Model::new("bond_based").unwrap();
        let density = random.between(0.5, 3.0);
        model.set("density", density).unwrap();
        for key in ["youngs_modulus", "horizon", "critical_stretch"] {
            model.set(key, 1.0).unwrap();
        }
        let mut simulation = Simulation::new(&points, &model).unwrap();
        let (load, speed) = (random.between(-1.0, 1.0), random.around_zero(dimension, 1.0));
        simulation.prescribe("all", Quantity::BodyForce, 1, load).unwrap();
        simulation.set(Field::Velocity, &speed).unwrap();
        prop_assert_eq!(simulation.stable_time_step().unwrap(), f64::MAX);
        simulation.step(0.125, steps).unwrap();
        let time = simulation.time();
        let displacement = simulation.get(Field::Displacement).unwrap();
        let size: f64 = 4.0 * (1.0 + time) * (1.0 + time);
        for axis in 0..dimension {
            let pull = if axis == 1 { load / density } else { 0.0 };
            let flown = speed[axis] * time + 0.5 * pull * time * time;
            prop_assert!((displacement[axis] - flown).abs() < 1e-14 * size);
        }
        let energy = simulation.energy().unwrap();
        let scale = energy.kinetic + energy.external_work.abs();
        prop_assert!(energy.closure_error.abs() < 1e-13 * scale);
        let health = simulation.health().unwrap();
        prop_assert_eq!((health.isolated.count, health.isolated.first), (1, Some(0)));
        prop_assert_eq!((health.bonds, simulation.bond_count().unwrap()), (0, 0));
        simulation.release("all", Quantity::BodyForce, 1).unwrap();
        simulation.prescribe("all", Quantity::Displacement, 0, 2.5).unwrap();
        simulation.step(0.125, 2).unwrap();
        prop_assert_eq!(simulation.get(Field::Displacement).unwrap()[0], 2.5);
        prop_assert_eq!(simulation.get(Field::Reaction).unwrap()[0], 0.0);
    }
}
