//! What sweeps leave out where nothing happens changes no bit of the result.

use perion::{Field, Model, Points, Simulation, Skips};

use crate::random::Random;
use crate::scene::state_bits;

const NONE: Skips = Skips { at_rest: false, stretch_tests: false, without_bonds: false };

/// A bar, its first half jittered, and three points beyond the reach of all others.
fn bar(upper: &[f64], jitter: f64) -> Points {
    let dimension = upper.len();
    let block = Points::block(dimension, &vec![0.0; dimension], upper, 1.0).unwrap();
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

fn run(points: &Points, formulation: &str, steps: u64, skips: Skips) -> (Vec<Vec<u64>>, u64) {
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in
        [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 3.015), ("critical_stretch", 0.02)]
    {
        model.set(key, value).unwrap();
    }
    if formulation != "bond_based" {
        model.set("poissons_ratio", 0.2).unwrap();
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
    simulation.step(0.25, steps).unwrap();
    (state_bits(&simulation), simulation.health().unwrap().broken_bonds)
}

#[test]
fn nothing_that_is_left_out_changes_a_bit() {
    for (upper, jitter) in [
        (&[70.0, 8.0, 8.0][..], 0.0),
        (&[70.0, 8.0, 8.0], 0.2),
        (&[200.0, 20.0], 0.0),
        (&[200.0, 20.0], 0.2),
    ] {
        let points = bar(upper, jitter);
        let run = |skips| run(&points, "bond_based", 12, skips);
        let (expected, broken) = run(NONE);
        assert!(broken > 100, "{broken}");
        for skips in [
            Skips { at_rest: true, ..NONE },
            Skips { stretch_tests: true, ..NONE },
            Skips { without_bonds: true, ..NONE },
            Skips::default(),
        ] {
            assert!(run(skips).0 == expected, "{upper:?}, {jitter}: {skips:?}");
        }
    }
}

/// Forces from families of families reach far: a long bar and few steps, so that most of it rests until the end.
#[test]
fn what_rests_is_left_out_of_two_sweeps_and_three() {
    for formulation in [
        "ordinary_state_based",
        "madenci_oterkus",
        "correspondence",
        "correspondence_silling",
        "correspondence_wan",
        "total_lagrangian",
        "bond_associated_quadrature",
    ] {
        for (upper, jitter) in [
            (&[150.0, 6.0, 6.0][..], 0.0),
            (&[150.0, 6.0, 6.0], 0.2),
            (&[400.0, 12.0], 0.0),
            (&[400.0, 12.0], 0.2),
        ] {
            if formulation == "madenci_oterkus" && upper.len() == 2 {
                continue;
            }
            let points = bar(upper, jitter);
            let (expected, broken) = run(&points, formulation, 3, NONE);
            assert!(broken > 100, "{broken}");
            let rested = run(&points, formulation, 3, Skips::default()).0;
            assert!(rested == expected, "{formulation}, {upper:?}, {jitter}");
        }
    }
}
