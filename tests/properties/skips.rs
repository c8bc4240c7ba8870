//! What sweeps leave out where nothing happens changes no bit of the result.

use perion::{Field, Model, Points, Simulation, Skips};

use crate::random::Random;
use crate::scene::state_bits;

const NONE: Skips = Skips { at_rest: false, stretch_tests: false, without_bonds: false };

/// A bar, its first half jittered, and some points beyond the reach of all others.
fn bar(upper: &[f64], jitter: f64, alone: usize) -> Points {
    let dimension = upper.len();
    let block = Points::block(dimension, &vec![0.0; dimension], upper, 1.0).unwrap();
    let (mut coordinates, mut random) = (block.coordinates().to_vec(), Random(5));
    for place in coordinates.chunks_exact_mut(dimension).filter(|place| place[0] < 0.5 * upper[0]) {
        place.iter_mut().for_each(|x| *x += random.between(-jitter, jitter));
    }
    let mut volumes = block.volumes().to_vec();
    for alone in 1..=alone {
        coordinates.extend(vec![-20.0 * alone as f64; dimension]);
        volumes.push(volumes[0]);
    }
    Points::new(dimension, &coordinates, &volumes).unwrap()
}

fn simulation(points: &Points, formulation: &str, skips: Skips) -> Simulation {
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
    simulation
}

fn run(points: &Points, formulation: &str, steps: u64, skips: Skips) -> (Vec<Vec<u64>>, u64) {
    let mut simulation = simulation(points, formulation, skips);
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
        let points = bar(upper, jitter, 3);
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

/// Those whose forces come from families of families.
const IN_SWEEPS: [&str; 6] = [
    "ordinary_state_based",
    "madenci_oterkus",
    "correspondence",
    "correspondence_silling",
    "correspondence_wan",
    "bond_associated_quadrature",
];

fn is_for(formulation: &str, dimension: usize) -> bool {
    formulation != "madenci_oterkus" || dimension == 3
}

/// These forces reach far: a long bar and few steps, so that most of it rests until the end. Without points that stand alone it
/// is a lattice where it is not jittered.
#[test]
fn what_rests_is_left_out_of_two_sweeps_and_three() {
    for formulation in IN_SWEEPS {
        for (upper, jitter, alone) in [
            (&[150.0, 6.0, 6.0][..], 0.0, 0),
            (&[150.0, 6.0, 6.0], 0.2, 3),
            (&[400.0, 12.0], 0.0, 0),
            (&[400.0, 12.0], 0.2, 3),
        ] {
            if !is_for(formulation, upper.len()) {
                continue;
            }
            let points = bar(upper, jitter, alone);
            let (expected, broken) = run(&points, formulation, 3, NONE);
            assert!(broken > 100, "{broken}");
            let rested = run(&points, formulation, 3, Skips::default()).0;
            assert!(rested == expected, "{formulation}, {upper:?}, {jitter}");
        }
    }
}

/// Sweeps over lattices go by groups of eight points in a row, which may be of several blocks: what was left in the tables by a
/// body that was strained everywhere must not come back where it rests.
#[test]
fn a_body_that_comes_to_rest_around_a_spot_has_no_force_elsewhere() {
    for (upper, spot) in [
        (&[50.0, 240.0][..], &[25.5, 116.5][..]),
        (&[44.0, 200.0], &[22.5, 101.5]),
        (&[60.0, 280.0], &[30.5, 139.5]),
        (&[240.0, 50.0], &[116.5, 25.5]),
        (&[12.0, 10.0, 120.0], &[6.5, 5.5, 58.5]),
        (&[14.0, 90.0, 12.0], &[7.5, 44.5, 6.5]),
    ] {
        let dimension = upper.len();
        let points = Points::block(dimension, &vec![0.0; dimension], upper, 1.0).unwrap();
        let places = points.coordinates().to_vec();
        let strained = Random(7).around_zero(places.len(), 1e-3);
        let mut moved = strained.clone();
        for (shift, place) in moved.chunks_exact_mut(dimension).zip(places.chunks_exact(dimension))
        {
            let apart = place.iter().zip(spot).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
            if apart > 2.2 {
                shift.fill(0.25);
            }
        }
        for formulation in IN_SWEEPS.into_iter().chain(["bond_based"]) {
            if !is_for(formulation, dimension) {
                continue;
            }
            let forces = [Skips::default(), NONE].map(|skips| {
                let mut body = simulation(&points, formulation, skips);
                for displacement in [&strained, &moved] {
                    body.set(Field::Displacement, displacement).unwrap();
                    body.evaluate().unwrap();
                }
                body.get(Field::InternalForce).unwrap()
            });
            let [left_out, whole] = forces.map(|forces| forces.into_iter().map(f64::to_bits));
            let differ = left_out.zip(whole).filter(|(left_out, whole)| left_out != whole).count();
            assert_eq!(differ, 0, "{formulation}, {upper:?}");
        }
    }
}
