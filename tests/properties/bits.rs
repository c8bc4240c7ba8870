//! Bits: neither threads nor the host's order of points change a single one.

use perion::{Field, Points, Quantity, Simulation};
use proptest::prelude::*;

use crate::random::{Random, cases};
use crate::scene::{Horizons, Recipe, Scene, state_bits};

/// Bodies of several blocks of 256 points, so that threads share the work.
fn wide_bodies() -> impl Strategy<Value = Recipe> {
    let shape = prop_oneof![
        (18..40_usize, 18..40_usize).prop_map(|(nx, ny)| (2, [nx, ny, 1])),
        (8..11_usize, 7..11_usize, 6..10_usize).prop_map(|(nx, ny, nz)| (3, [nx, ny, nz])),
    ];
    let horizons =
        prop_oneof![Just(Horizons::Uniform), Just(Horizons::PerMaterial), Just(Horizons::PerPoint)];
    (shape, horizons, 1..3_usize, any::<bool>(), any::<u64>()).prop_map(
        |((dimension, counts), horizons, materials, lattice, seed)| Recipe {
            dimension,
            counts,
            jitter: if lattice { 0.0 } else { 0.25 },
            horizons,
            materials,
            plane_stress: false,
            units: [-3, 9, 3],
            seed,
        },
    )
}

/// Pulls at both ends hard enough to break bonds, with every kind of load.
fn tear(scene: &Scene, simulation: &mut Simulation, velocities: &[f64]) {
    let time_step = 0.8 * simulation.stable_time_step().unwrap();
    let speed = 0.05 * scene.spacing / time_step;
    let load = 1e-3 * scene.bulk_modulus() / scene.spacing;
    simulation.set(Field::Velocity, velocities).unwrap();
    simulation.prescribe("left", Quantity::Velocity, 0, -speed).unwrap();
    let times = [0.0, 100.0 * time_step];
    let values = [0.0, 100.0 * time_step * speed];
    simulation.prescribe_table("right", Quantity::Displacement, 0, &times, &values).unwrap();
    simulation.prescribe("all", Quantity::BodyForce, 1, load).unwrap();
    simulation.prescribe_table("right", Quantity::BodyForce, 1, &times, &[0.0, -load]).unwrap();
    simulation.step(time_step, 20).unwrap();
}

/// The same body with its points in another order; point `k` of it is `order[k]` of the first.
fn reordered(scene: &Scene, order: &[usize]) -> Scene {
    let dimension = scene.dimension;
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, &old)| place[old] = new);
    let pick = |values: &Vec<f64>| order.iter().map(|&old| values[old]).collect::<Vec<f64>>();
    let map = |set: &Vec<usize>| set.iter().map(|&old| place[old]).collect::<Vec<usize>>();
    Scene {
        coordinates: vectors(&scene.coordinates, order, dimension),
        volumes: pick(&scene.volumes),
        horizons: scene.horizons.as_ref().map(pick),
        second: map(&scene.second),
        ends: [map(&scene.ends[0]), map(&scene.ends[1])],
        ..scene.clone()
    }
}

fn vectors<T: Copy>(values: &[T], order: &[usize], width: usize) -> Vec<T> {
    order.iter().flat_map(|&old| values[old * width..(old + 1) * width].iter().copied()).collect()
}

/// What `state_bits` gives, with fields put into another order.
fn state_in_order(simulation: &Simulation, order: &[usize]) -> Vec<Vec<u64>> {
    let mut state = state_bits(simulation);
    let dimension = simulation.points().dimension();
    for values in &mut state {
        if values.len() == order.len() {
            *values = vectors(values, order, 1);
        } else if values.len() == order.len() * dimension {
            *values = vectors(values, order, dimension);
        }
    }
    state
}

proptest! {
    #![proptest_config(cases(10))]

    #[test]
    fn threads_change_no_bit(recipe in wide_bodies()) {
        let scene = recipe.scene();
        let speed = 3.0 * (scene.bulk_modulus() / scene.materials[0].density).sqrt();
        let velocities = scene.random(10).around_zero(scene.components(), 0.02 * speed);
        let mut expected = None;
        for threads in [1, 2, 3, 4] {
            let mut simulation = scene.simulation(Some(0.02));
            simulation.set_threads(threads).unwrap();
            tear(&scene, &mut simulation, &velocities);
            let health = simulation.health().unwrap();
            prop_assert!(0 < health.broken_bonds && health.broken_bonds < health.bonds);
            let state = state_bits(&simulation);
            prop_assert_eq!(expected.get_or_insert_with(|| state.clone()), &state);
        }
    }

    #[test]
    fn the_hosts_order_of_points_changes_no_bit(recipe in wide_bodies()) {
        let scene = recipe.scene();
        let mut random = scene.random(11);
        let order = random.order(scene.count());
        let other = reordered(&scene, &order);
        let speed = (scene.bulk_modulus() / scene.materials[0].density).sqrt();
        let velocities = random.around_zero(scene.components(), 0.06 * speed);
        let moved = vectors(&velocities, &order, scene.dimension);
        let mut first = scene.simulation(Some(0.02));
        tear(&scene, &mut first, &velocities);
        let mut second = other.simulation(Some(0.02));
        second.set_threads(2).unwrap();
        tear(&other, &mut second, &moved);
        prop_assert_eq!(state_in_order(&first, &order), state_bits(&second));
        for field in [Field::Reaction, Field::Damage] {
            let sums = [&first, &second].map(|body| body.sum(field, Some("left")).unwrap());
            prop_assert_eq!(&sums[0], &sums[1]);
        }
    }
}

/// A box lists the points of its set in the host's order, which must not show in sums over them.
#[test]
fn the_hosts_order_of_points_in_a_box_changes_no_bit_of_the_work() {
    let block = Points::block(2, &[0.0; 2], &[20.0, 20.0], 1.0).unwrap();
    let start = Random(1).around_zero(800, 1e-3);
    let work = |order: &[usize]| {
        let coordinates = vectors(block.coordinates(), order, 2);
        let mut points = Points::new(2, &coordinates, block.volumes()).unwrap();
        points.add_set_box("edge", &[0.0, 0.0], &[20.0, 3.0]).unwrap();
        let mut model = perion::Model::new("bond_based").unwrap();
        for (key, value) in [("density", 1.3), ("youngs_modulus", 1.7), ("horizon", 3.015)] {
            model.set(key, value).unwrap();
        }
        let mut simulation = Simulation::new(&points, &model).unwrap();
        simulation.set(Field::Velocity, &vectors(&start, order, 2)).unwrap();
        simulation.prescribe("edge", Quantity::Velocity, 1, 1e-3).unwrap();
        simulation.step(0.3, 20).unwrap();
        let energy = simulation.energy().unwrap();
        let sum = simulation.sum(Field::Reaction, Some("edge")).unwrap()[1];
        [energy.kinetic, energy.elastic, sum, energy.external_work].map(f64::to_bits)
    };
    let order: Vec<usize> = (0..400).collect();
    assert_eq!(work(&order), work(&Random(2).order(400)));
}
