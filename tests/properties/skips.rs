//! What sweeps leave out where nothing happens changes no bit of the result.

use perion::{Field, Model, Points, Simulation, Skips};

use crate::random::Random;
use crate::scene::state_bits;

/// A bar, its first half jittered, and three points beyond the reach of all others.
fn bar(dimension: usize, jitter: f64) -> Points {
    let upper = if dimension == 3 { vec![70.0, 8.0, 8.0] } else { vec![200.0, 20.0] };
    let block = Points::block(dimension, &vec![0.0; dimension], &upper, 1.0).unwrap();
    let (mut coordinates, mut random) = (block.coordinates().to_vec(), Random(5));
    for place in coordinates.chunks_exact_mut(dimension).filter(|place| place[0] < 0.5 * upper[0]) {
        place.iter_mut().for_each(|x| *x += random.between(-jitter, jitter));
    }
    let mut volumes = block.volumes().to_vec();
    for alone in 1..4 {
        coordinates.extend(vec![-20.0 * f64::from(alone); dimension]);
        volumes.push(volumes[0]);
    }
    Points::new(dimension, &coordinates, &volumes).unwrap()
}

fn run(points: &Points, skips: Skips) -> (Vec<Vec<u64>>, u64) {
    let mut model = Model::new("bond_based").unwrap();
    for (key, value) in
        [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 3.015), ("critical_stretch", 0.02)]
    {
        model.set(key, value).unwrap();
    }
    let mut simulation = Simulation::new(points, &model).unwrap();
    simulation.set_skips(skips).unwrap();
    simulation.set_threads(2).unwrap();
    let dimension = points.dimension();
    let mut velocities = Random(6).around_zero(dimension * points.count(), 0.2);
    for (velocity, place) in
        velocities.chunks_exact_mut(dimension).zip(points.coordinates().chunks_exact(dimension))
    {
        if place[0] > 6.0 {
            // Behind the corner that flies apart a part drifts as one.
            velocity.fill(if place[0] < 40.0 { 0.125 } else { 0.0 });
        }
    }
    simulation.set(Field::Velocity, &velocities).unwrap();
    simulation.step(0.25, 12).unwrap();
    (state_bits(&simulation), simulation.health().unwrap().broken_bonds)
}

#[test]
fn nothing_that_is_left_out_changes_a_bit() {
    for (dimension, jitter) in [(3, 0.0), (3, 0.2), (2, 0.0), (2, 0.2)] {
        let points = bar(dimension, jitter);
        let none = Skips { at_rest: false, stretch_tests: false, without_bonds: false };
        let (expected, broken) = run(&points, none);
        assert!(broken > 100, "{broken}");
        for skips in [
            Skips { at_rest: true, ..none },
            Skips { stretch_tests: true, ..none },
            Skips { without_bonds: true, ..none },
            Skips::default(),
        ] {
            assert!(run(&points, skips).0 == expected, "{dimension}D, {jitter}: {skips:?}");
        }
    }
}
