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

/// What runs: a formulation, and with it a material or a divergence.
#[derive(Debug, Clone, Copy)]
struct Scene {
    formulation: &'static str,
    chosen: Option<(&'static str, &'static str)>,
}

const fn of(formulation: &'static str) -> Scene {
    Scene { formulation, chosen: None }
}

const fn with(formulation: &'static str, key: &'static str, choice: &'static str) -> Scene {
    Scene { formulation, chosen: Some((key, choice)) }
}

fn simulation(points: &Points, scene: Scene, skips: Skips) -> Simulation {
    let Scene { formulation, chosen } = scene;
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in
        [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 3.015), ("critical_stretch", 0.02)]
    {
        model.set(key, value).unwrap();
    }
    if formulation != "bond_based" {
        model.set("poissons_ratio", 0.2).unwrap();
    }
    if let Some((key, choice)) = chosen {
        model.choose(key, choice).unwrap();
        if choice == "j2_plastic" {
            model.set("yield_stress", 0.01).unwrap();
        }
    }
    let mut simulation = Simulation::new(points, &model).unwrap();
    simulation.set_skips(skips).unwrap();
    simulation.set_threads(2).unwrap();
    simulation
}

fn run(points: &Points, scene: Scene, steps: u64, skips: Skips) -> (Vec<Vec<u64>>, u64) {
    let mut simulation = simulation(points, scene, skips);
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
        let run = |skips| run(&points, of("bond_based"), 12, skips);
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
const IN_SWEEPS: [Scene; 11] = [
    of("ordinary_state_based"),
    of("madenci_oterkus"),
    of("correspondence"),
    of("correspondence_silling"),
    of("correspondence_wan"),
    of("bond_associated_quadrature"),
    with("correspondence", "material", "neo_hookean"),
    with("bond_associated_quadrature", "material", "neo_hookean"),
    with("correspondence", "material", "small_strain"),
    with("total_lagrangian", "divergence", "strong"),
    with("correspondence", "divergence", "strong"),
];

fn is_for(scene: Scene, dimension: usize) -> bool {
    scene.formulation != "madenci_oterkus" || dimension == 3
}

/// These forces reach far: a long bar and few steps, so that most of it rests until the end. Without points that stand alone it
/// is a lattice where it is not jittered.
#[test]
fn what_rests_is_left_out_of_two_sweeps_and_three() {
    for scene in IN_SWEEPS {
        for (upper, jitter, alone) in [
            (&[110.0, 5.0, 5.0][..], 0.0, 0),
            (&[110.0, 5.0, 5.0], 0.2, 3),
            (&[300.0, 10.0], 0.0, 0),
            (&[300.0, 10.0], 0.2, 3),
        ] {
            if !is_for(scene, upper.len()) {
                continue;
            }
            let points = bar(upper, jitter, alone);
            let (expected, broken) = run(&points, scene, 3, NONE);
            assert!(broken > 100, "{broken}");
            let rested = run(&points, scene, 3, Skips::default()).0;
            assert!(rested == expected, "{scene:?}, {upper:?}, {jitter}");
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
        for scene in IN_SWEEPS.into_iter().chain([of("bond_based")]) {
            if !is_for(scene, dimension) {
                continue;
            }
            let forces = [Skips::default(), NONE].map(|skips| {
                let mut body = simulation(&points, scene, skips);
                for displacement in [&strained, &moved] {
                    body.set(Field::Displacement, displacement).unwrap();
                    body.evaluate().unwrap();
                }
                body.get(Field::InternalForce).unwrap()
            });
            let [left_out, whole] = forces.map(|forces| forces.into_iter().map(f64::to_bits));
            let differ = left_out.zip(whole).filter(|(left_out, whole)| left_out != whole).count();
            assert_eq!(differ, 0, "{scene:?}, {upper:?}");
        }
    }
}

/// Bonds of laws with a memory are looked at before anything else: what rests is not known of them, but which bonds can break is.
#[test]
fn stretch_tests_that_are_left_out_change_no_bit_where_laws_have_a_memory() {
    for scene in [
        with("correspondence", "material", "j2_plastic"),
        with("bond_associated_quadrature", "material", "hypoelastic"),
        of("bond_associated"),
    ] {
        for jitter in [0.0, 0.2] {
            let points = bar(&[24.0, 5.0, 5.0], jitter, 2);
            let (expected, broken) = run(&points, scene, 3, NONE);
            assert!(broken > 100, "{broken}");
            let skips = Skips { stretch_tests: true, ..NONE };
            assert!(run(&points, scene, 3, skips).0 == expected, "{scene:?}, {jitter}");
        }
    }
}

/// The same where bonds differ: two materials with their own limits, and bonds that the host has weakened.
#[test]
fn nothing_that_is_left_out_changes_a_bit_where_bonds_differ() {
    for formulation in ["bond_based", "ordinary_state_based", "correspondence"] {
        for (limit, weakened) in [(0.02, 0.0), (0.03, 0.0), (0.02, 0.5)] {
            let mut points = bar(&[150.0, 6.0, 6.0], 0.0, 0);
            let count = points.count();
            let places = points.coordinates().to_vec();
            let right: Vec<_> = (0..count).filter(|&point| places[3 * point] > 75.0).collect();
            points.add_set("right", &right).unwrap();
            let states = [NONE, Skips::default()].map(|skips| {
                let mut body = simulation(&points, of(formulation), skips);
                let mut other = Model::new(formulation).unwrap();
                for (key, value) in [
                    ("density", 1.0),
                    ("youngs_modulus", 2.0),
                    ("horizon", 3.015),
                    ("critical_stretch", limit),
                ] {
                    other.set(key, value).unwrap();
                }
                if formulation != "bond_based" {
                    other.set("poissons_ratio", 0.2).unwrap();
                }
                body.assign_model("right", &other).unwrap();
                if weakened > 0.0 {
                    body.set_bond_integrity(&[[0, 1], [40, 41]], &[weakened; 2]).unwrap();
                }
                let mut velocities = Random(6).around_zero(3 * count, 0.2);
                let slow = velocities.chunks_exact_mut(3).zip(places.chunks_exact(3));
                slow.filter(|(_, place)| place[0] > 6.0).for_each(|(v, _)| v.fill(0.0));
                body.set(Field::Velocity, &velocities).unwrap();
                body.step(0.25, 3).unwrap();
                assert!(body.health().unwrap().broken_bonds > 100);
                state_bits(&body)
            });
            assert!(states[0] == states[1], "{formulation}, {limit}, {weakened}");
        }
    }
}

/// A corner, and single points, all bonds of which are broken; some of them in whole groups of a lattice.
#[test]
fn points_without_bonds_are_left_out_to_the_last_bit() {
    for scene in IN_SWEEPS.into_iter().chain([of("bond_based")]) {
        for jitter in [0.0, 0.2] {
            let points = bar(&[20.0, 9.0, 8.0], jitter, 0);
            let places = points.coordinates();
            let bare = |point: usize| {
                let corner = places[3 * point..][..3].iter().zip([9.0, 3.0, 3.0]);
                corner.clone().all(|(x, most)| *x < most) || point % 97 == 5
            };
            let states = [NONE, Skips { without_bonds: true, ..NONE }].map(|skips| {
                let mut body = simulation(&points, scene, skips);
                let pairs: Vec<_> = crate::scene::bonds(&body)
                    .into_iter()
                    .map(|(pair, ..)| pair)
                    .filter(|pair| pair.iter().any(|&point| bare(point)))
                    .collect();
                body.break_bonds(&pairs).unwrap();
                let damage = body.get(Field::Damage).unwrap();
                assert!(damage.iter().filter(|&&damage| damage == 1.0).count() > 60);
                let velocities = Random(6).around_zero(3 * points.count(), 0.02);
                body.set(Field::Velocity, &velocities).unwrap();
                body.step(0.25, 3).unwrap();
                state_bits(&body)
            });
            assert!(states[0] == states[1], "{scene:?}, {jitter}");
        }
    }
}
