//! Instructions and lattices: every level that this machine has, and points on a grid computed together or one by one,
//! come to the same forces but for rounding, and break the same bonds.

use perion::{Field, Model, Points, SimdLevel, Simulation};
use proptest::prelude::*;

use crate::random::{Random, cases};
use crate::scene::{Horizons, Recipe, Scene, bits, bonds, state_bits};

/// The levels of this machine; says which it does not have.
fn levels() -> Vec<SimdLevel> {
    let (here, missing): (Vec<_>, Vec<_>) =
        SimdLevel::ALL.into_iter().partition(|level| level.is_available());
    for level in missing {
        println!("skipped: this machine does not have the level {}", level.name());
    }
    here
}

/// Clouds and lattices of one horizon and material, or of several, large enough for a lattice to be worth it.
fn bodies() -> impl Strategy<Value = Recipe> {
    let shape = prop_oneof![
        (18..40_usize, 18..40_usize).prop_map(|(nx, ny)| (2, [nx, ny, 1])),
        (9..13_usize, 9..12_usize, 8..11_usize).prop_map(|(nx, ny, nz)| (3, [nx, ny, nz])),
    ];
    (shape, any::<bool>(), 1..3_usize, any::<u64>()).prop_map(
        |((dimension, counts), lattice, materials, seed)| Recipe {
            dimension,
            counts,
            jitter: if lattice { 0.0 } else { 0.25 },
            horizons: Horizons::Uniform,
            materials,
            plane_stress: false,
            units: [-3, 9, 3],
            seed,
        },
    )
}

/// The body on a level, with lattices looked for or not.
fn body(scene: &Scene, level: SimdLevel, lattices: bool, critical: Option<f64>) -> Simulation {
    let mut simulation = scene.simulation(critical);
    simulation.set_simd(level).unwrap();
    simulation.set_lattices(lattices).unwrap();
    simulation
}

/// Largest difference over the largest number.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    a.iter().zip(b).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs())) / largest
}

/// Forces on points of one volume add up to nothing.
fn balances(name: &str, simulation: &Simulation) {
    let forces = simulation.get(Field::InternalForce).unwrap();
    let size: f64 = forces.iter().map(|force| force.abs()).sum();
    for axis in 0..3 {
        let sum: f64 = forces.iter().skip(axis).step_by(3).sum();
        assert!(sum.abs() < 1e-13 * size, "{name}: {sum}, {size}");
    }
}

/// What moves, what is lost, and what is shown of it.
const SHOWN: [Field; 6] = [
    Field::Displacement,
    Field::InternalForce,
    Field::DissipatedEnergyDensity,
    Field::StrainEnergyDensity,
    Field::DeformationGradient,
    Field::FirstPiolaStress,
];

/// Fields are the same but for rounding.
fn agree(name: &str, bodies: [&Simulation; 2], fields: &[Field]) {
    for &field in fields {
        let [a, b] = bodies.map(|body| body.get(field).unwrap());
        let distance = distance(&a, &b);
        assert!(distance < 1e-9, "{name}, {field:?}: {distance}");
    }
}

/// Which bonds are left; lattices have them in another order.
fn intact(simulation: &Simulation) -> Vec<[usize; 2]> {
    let whole = |&(_, _, integrity): &([usize; 2], f64, f64)| integrity > 0.0;
    let left = bonds(simulation).into_iter().filter(whole);
    let mut left: Vec<[usize; 2]> = left.map(|(pair, _, _)| pair).collect();
    left.sort_unstable();
    left
}

proptest! {
    #![proptest_config(cases(12))]

    #[test]
    fn levels_and_lattices_agree_on_forces_and_on_what_breaks(recipe in bodies()) {
        let scene = recipe.scene();
        let shift = scene.random(3).around_zero(scene.components(), 0.01 * scene.spacing);
        let mut expected: Option<(Vec<f64>, Vec<[usize; 2]>)> = None;
        for level in levels() {
            for lattices in [false, true] {
                let mut simulation = body(&scene, level, lattices, Some(0.01));
                simulation.set(Field::Displacement, &shift).unwrap();
                let force = simulation.get(Field::InternalForce).unwrap();
                simulation.commit(1e-9).unwrap();
                let left = intact(&simulation);
                let total = simulation.health().unwrap().bonds as usize;
                prop_assert!(!left.is_empty() && left.len() < total);
                let torn = simulation.get(Field::InternalForce).unwrap();
                let both = [force, torn].concat();
                let (forces, bonds) = expected.get_or_insert_with(|| (both.clone(), left.clone()));
                let distance = distance(forces, &both);
                prop_assert!(distance < 1e-12, "{level:?}, {lattices}: {distance}");
                prop_assert_eq!(&*bonds, &left);
            }
        }
    }

    #[test]
    fn on_every_level_no_number_of_threads_changes_a_bit(recipe in bodies()) {
        let scene = recipe.scene();
        let speed = (scene.bulk_modulus() / scene.materials[0].density).sqrt();
        let velocities = scene.random(5).around_zero(scene.components(), 0.06 * speed);
        for level in levels() {
            let run = |threads: usize| {
                let mut simulation = body(&scene, level, true, Some(0.02));
                simulation.set_threads(threads).unwrap();
                simulation.set(Field::Velocity, &velocities).unwrap();
                let step = 0.8 * simulation.stable_time_step().unwrap();
                simulation.step(step, 10).unwrap();
                assert!(simulation.health().unwrap().broken_bonds > 0);
                state_bits(&simulation)
            };
            prop_assert_eq!(run(1), run(3));
        }
    }
}

/// A block whose upper half is jittered: part lattice, part cloud.
fn mixed() -> Points {
    let block = Points::block(3, &[0.0; 3], &[12.0, 12.0, 20.0], 1.0).unwrap();
    let mut random = Random(8);
    let mut coordinates = block.coordinates().to_vec();
    for place in coordinates.chunks_exact_mut(3).filter(|place| place[2] > 14.0) {
        place.iter_mut().for_each(|x| *x += random.between(-0.2, 0.2));
    }
    Points::new(3, &coordinates, block.volumes()).unwrap()
}

/// Formulations that have sweeps of their own over lattices.
const ON_LATTICES: [&str; 4] =
    ["bond_based", "ordinary_state_based", "correspondence", "bond_associated_quadrature"];

fn model(formulation: &str, horizon: f64) -> Model {
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", horizon)] {
        model.set(key, value).unwrap();
    }
    if formulation != "bond_based" {
        model.set("poissons_ratio", 0.3).unwrap();
    }
    model
}

fn simulation(points: &Points, formulation: &str, lattices: bool) -> Simulation {
    let mut model = model(formulation, 3.015);
    model.set("critical_stretch", 0.02).unwrap();
    let mut simulation = Simulation::new(points, &model).unwrap();
    simulation.set_lattices(lattices).unwrap();
    simulation.set_threads(2).unwrap();
    simulation
}

#[test]
fn part_lattice_and_part_cloud_break_as_a_cloud_and_keep_their_momentum() {
    for (formulation, level) in
        ON_LATTICES.into_iter().flat_map(|f| levels().into_iter().map(move |l| (f, l)))
    {
        part_lattice_and_part_cloud(formulation, level);
    }
}

fn part_lattice_and_part_cloud(formulation: &str, level: SimdLevel) {
    let points = mixed();
    let velocity = Random(9).around_zero(3 * points.count(), 0.05);
    let run = |lattices: bool, threads: usize| {
        let mut simulation = simulation(&points, formulation, lattices);
        simulation.set_simd(level).unwrap();
        simulation.set_threads(threads).unwrap();
        simulation.break_crossing(&[-1.0, 6.2, 3.0, 8.0, 6.2, 3.0, 8.0, 6.2, 17.0]).unwrap();
        simulation.set(Field::Velocity, &velocity).unwrap();
        for _ in 0..12 {
            simulation.step(0.2, 1).unwrap();
            balances(formulation, &simulation);
        }
        simulation
    };
    let [cloud, lattice] = [false, true].map(|lattices| run(lattices, 2));
    assert!(lattice.health().unwrap().broken_bonds > 2000);
    assert_eq!(intact(&cloud), intact(&lattice));
    let name = format!("{formulation}, {level:?}");
    agree(&name, [&cloud, &lattice], &SHOWN);
    assert_eq!(state_bits(&lattice), state_bits(&run(true, 3)));
}

/// A point beside the lattice that hangs by one or two bonds, and nobody else's family is torn: members have bonds with a
/// family that does not span the body.
#[test]
fn a_point_beside_a_lattice_may_hang_by_a_few_bonds() {
    let block = Points::block(3, &[0.0; 3], &[12.0, 12.0, 20.0], 1.0).unwrap();
    let mut random = Random(8);
    let mut coordinates = block.coordinates().to_vec();
    for place in coordinates.chunks_exact_mut(3).filter(|place| place[2] > 16.0) {
        place.iter_mut().for_each(|x| *x += random.between(-0.2, 0.2));
    }
    let points = Points::new(3, &coordinates, block.volumes()).unwrap();
    let displacement = Random(9).around_zero(3 * points.count(), 1e-3);
    let hanging = 5 + 12 * (8 + 12 * 14);
    for (formulation, left) in ON_LATTICES.into_iter().flat_map(|f| [(f, 1), (f, 2)]) {
        for level in levels() {
            let [cloud, lattice] = [false, true].map(|lattices| {
                let mut simulation = Simulation::new(&points, &model(formulation, 2.015)).unwrap();
                simulation.set_lattices(lattices).unwrap();
                simulation.set_simd(level).unwrap();
                let own = |&(pair, ..): &([usize; 2], f64, f64)| pair.contains(&hanging);
                let pairs = bonds(&simulation).into_iter().filter(own).map(|(pair, ..)| pair);
                // The lowest are left, which are members.
                let mut pairs: Vec<_> = pairs.collect();
                pairs.sort_unstable_by_key(|pair| pair[0].min(pair[1]));
                simulation.break_bonds(&pairs[left..]).unwrap();
                simulation.set(Field::Displacement, &displacement).unwrap();
                simulation.evaluate().unwrap();
                simulation.get(Field::InternalForce).unwrap()
            });
            let distance = distance(&cloud, &lattice);
            assert!(distance < 1e-12, "{formulation}, {level:?}, {left}: {distance}");
        }
    }
}

/// On every level, with threads, whole families and torn ones down to sheets and single points.
#[test]
fn lattices_of_all_formulations_break_as_clouds() {
    let block = Points::block(3, &[0.0; 3], &[14.0, 11.0, 9.0], 1.0).unwrap();
    break_as_clouds(&block);
    // In the corner.
    break_as_clouds(&with_one_off(&block, 14 * (11 * 4 + 3) + 2));
}

fn break_as_clouds(points: &Points) {
    let velocity = Random(10).around_zero(3 * points.count(), 0.04);
    for formulation in ON_LATTICES {
        let run = |lattices: bool, level: SimdLevel, threads: usize| {
            let mut simulation = simulation(points, formulation, lattices);
            simulation.set_simd(level).unwrap();
            simulation.set_threads(threads).unwrap();
            // A corner of which single layers and points are left.
            for x in 1..5 {
                let x = f64::from(x);
                let plane = [x, -1.0, -1.0, x, 6.0, -1.0, x, 6.0, 12.0, x, -1.0, 12.0];
                simulation.break_crossing(&plane).unwrap();
            }
            let plane = [-1.0, 2.0, -1.0, 3.5, 2.0, -1.0, 3.5, 2.0, 12.0, -1.0, 2.0, 12.0];
            simulation.break_crossing(&plane).unwrap();
            let begun = simulation.health().unwrap().broken_bonds;
            simulation.set(Field::Velocity, &velocity).unwrap();
            simulation.step(0.2, 6).unwrap();
            assert!(simulation.health().unwrap().broken_bonds > begun + 100);
            simulation
        };
        for level in levels() {
            let [cloud, lattice] = [false, true].map(|lattices| run(lattices, level, 2));
            assert_eq!(intact(&cloud), intact(&lattice), "{formulation}, {level:?}");
            let name = format!("{formulation}, {level:?}");
            agree(&name, [&cloud, &lattice], &SHOWN);
            assert_eq!(state_bits(&lattice), state_bits(&run(true, level, 3)));
        }
    }
}

/// Layers and an inclusion of other moduli and limits, one of which never breaks; groups of eight points may be of two.
#[test]
fn lattices_of_several_materials_break_as_clouds() {
    let mut points = Points::block(3, &[0.0; 3], &[45.0, 9.0, 8.0], 1.0).unwrap();
    points.add_set_box("right", &[17.0, 0.0, 0.0], &[45.0, 9.0, 8.0]).unwrap();
    points.add_set_box("inside", &[3.0, 3.0, 3.0], &[5.0, 6.0, 6.0]).unwrap();
    points.add_set_box("end", &[37.0, 0.0, 0.0], &[45.0, 9.0, 8.0]).unwrap();
    let velocity = Random(13).around_zero(3 * points.count(), 0.05);
    let all = ON_LATTICES.map(|formulation| {
        [[0.02, 0.035, f64::INFINITY], [0.02; 3]].map(|limits| (formulation, limits))
    });
    for (formulation, limits) in all.into_iter().flatten() {
        let run = |lattices: bool, level: SimdLevel, threads: usize| {
            let models = [(1.0, limits[0]), (4.0, limits[1]), (2.0, limits[2])];
            let models = models.map(|(modulus, limit)| {
                let mut model = model(formulation, 3.015);
                model.set("youngs_modulus", modulus).unwrap();
                if limit.is_finite() {
                    model.set("critical_stretch", limit).unwrap();
                }
                model
            });
            let mut simulation = Simulation::new(&points, &models[0]).unwrap();
            simulation.assign_model("right", &models[1]).unwrap();
            simulation.assign_model("inside", &models[2]).unwrap();
            simulation.assign_model("end", &models[0]).unwrap();
            simulation.set_lattices(lattices).unwrap();
            simulation.set_simd(level).unwrap();
            simulation.set_threads(threads).unwrap();
            simulation.set(Field::Velocity, &velocity).unwrap();
            simulation.step(0.1, 8).unwrap();
            balances(formulation, &simulation);
            assert!(simulation.health().unwrap().broken_bonds > 500);
            simulation
        };
        for level in levels() {
            let [cloud, lattice] = [false, true].map(|lattices| run(lattices, level, 2));
            assert_eq!(intact(&cloud), intact(&lattice), "{formulation}, {level:?}");
            let [of_cloud, of_lattice] = [&cloud, &lattice].map(|body| body.memory().bonds as f64);
            if formulation == "bond_associated_quadrature" {
                // Where much of the body is interfaces, what it holds of its groups outweighs their lists.
                assert_ne!(of_lattice, of_cloud, "{formulation}: no lattice");
            } else {
                assert!(of_lattice < 0.9 * of_cloud, "{formulation}: no lattice");
            }
            let name = format!("{formulation}, {level:?}");
            agree(&name, [&cloud, &lattice], &SHOWN);
            assert_eq!(state_bits(&lattice), state_bits(&run(true, level, 3)));
        }
    }
}

#[test]
fn the_half_of_a_body_that_is_a_lattice_is_found_wherever_it_lies() {
    for upper in [[24.0, 24.0, 24.0], [40.0, 12.0, 16.0], [16.0, 40.0, 12.0]] {
        let block = Points::block(3, &[0.0; 3], &upper, 1.0).unwrap();
        for half in 0..6 {
            let (axis, middle) = (half % 3, 0.5 * upper[half % 3]);
            let (mut places, mut random) = (block.coordinates().to_vec(), Random(3));
            for place in places.chunks_exact_mut(3) {
                if (place[axis] < middle) == (half < 3) {
                    place.iter_mut().for_each(|x| *x += random.between(-0.2, 0.2));
                }
            }
            let points = Points::new(3, &places, block.volumes()).unwrap();
            let [cloud, body] = [false, true].map(|lattices| {
                let simulation = simulation(&points, "bond_based", lattices);
                simulation.bond_count().unwrap();
                simulation.memory().bonds as f64
            });
            assert!(body < 0.9 * cloud, "{upper:?}, {half}: {body} of {cloud} bytes");
        }
    }
}

#[test]
fn what_the_host_breaks_is_lost_to_a_lattice_that_cannot_break() {
    let points = Points::block(3, &[0.0; 3], &[14.0, 11.0, 9.0], 1.0).unwrap();
    let displacement = Random(11).around_zero(3 * points.count(), 1e-3);
    for formulation in ON_LATTICES {
        let [cloud, lattice] = [false, true].map(|lattices| {
            let mut simulation = Simulation::new(&points, &model(formulation, 3.015)).unwrap();
            simulation.set_lattices(lattices).unwrap();
            simulation.set(Field::Displacement, &displacement).unwrap();
            simulation.evaluate().unwrap();
            assert_eq!(simulation.energy().unwrap().dissipated, 0.0);
            for x in [5.0, 8.0] {
                let force = simulation.get(Field::InternalForce).unwrap();
                let plane = [x, -1.0, -1.0, x, 6.0, -1.0, x, 6.0, 12.0, x, -1.0, 12.0];
                simulation.break_crossing(&plane).unwrap();
                simulation.evaluate().unwrap();
                assert_ne!(force, simulation.get(Field::InternalForce).unwrap());
            }
            assert!(simulation.energy().unwrap().dissipated > 0.0);
            simulation
        });
        assert_eq!(intact(&cloud), intact(&lattice), "{formulation}");
        for field in [Field::InternalForce, Field::DissipatedEnergyDensity] {
            let [a, b] = [&cloud, &lattice].map(|body| body.get(field).unwrap());
            assert!(distance(&a, &b) < 1e-11, "{formulation}, {field:?}");
        }
    }
}

/// A point that leaves the range of numbers is named, or one that it pulls on, and no other that stands beside it in memory.
#[test]
fn the_point_that_is_named_does_not_depend_on_lattices() {
    let block = Points::block(3, &[0.0; 3], &[31e-3, 9e-3, 9e-3], 1e-3).unwrap();
    named_points(&block);
    let mut coordinates = block.coordinates().to_vec();
    coordinates[3 * (31 * 9 * 4 + 31 * 4 + 15)] += 1e-4;
    named_points(&Points::new(3, &coordinates, block.volumes()).unwrap());
}

fn named_points(points: &Points) {
    for (formulation, level) in
        ON_LATTICES.into_iter().flat_map(|f| levels().into_iter().map(move |l| (f, l)))
    {
        for odd in [30, 31 * 9 * 4 + 31 * 4 + 30, 31 * 9 * 4] {
            let named = [false, true].map(|lattices| {
                let mut simulation =
                    Simulation::new(points, &model(formulation, 3.015e-3)).unwrap();
                simulation.set_lattices(lattices).unwrap();
                simulation.set_simd(level).unwrap();
                let mut displacement = vec![0.0; 3 * points.count()];
                displacement[3 * odd] = 1e306;
                simulation.set(Field::Displacement, &displacement).unwrap();
                simulation.evaluate().unwrap_err().to_string()
            });
            assert_eq!(named[0], named[1], "{formulation}, {}", level.name());
        }
    }
}

#[test]
fn what_a_failed_step_has_broken_is_whole_again() {
    let block = Points::block(3, &[0.0; 3], &[14.0, 11.0, 9.0], 1.0).unwrap();
    failed_steps(&block);
    failed_steps(&with_one_off(&block, 14 * 11 * 4 + 9));
}

/// The same points, of which one is off the grid.
fn with_one_off(block: &Points, odd: usize) -> Points {
    let mut coordinates = block.coordinates().to_vec();
    coordinates[3 * odd + 1] += 0.1;
    Points::new(3, &coordinates, block.volumes()).unwrap()
}

fn failed_steps(points: &Points) {
    let torn = |start: f64| -> Vec<f64> {
        let places = points.coordinates().chunks(3);
        places.flat_map(|place| [start * (place[0] - 7.0).max(0.0), 0.0, 0.0]).collect()
    };
    // One point flies out of the range of numbers while others tear their bonds.
    let mut beyond = torn(0.2);
    beyond[0] = f64::MAX;
    for (formulation, lattices) in ON_LATTICES.into_iter().flat_map(|f| [(f, true), (f, false)]) {
        let [tried, straight] = [true, false].map(|tries| {
            let mut model = model(formulation, 3.015);
            model.set("critical_stretch", 0.01).unwrap();
            let mut simulation = Simulation::new(points, &model).unwrap();
            simulation.set_lattices(lattices).unwrap();
            for step in 1..4 {
                if tries {
                    simulation.set(Field::Velocity, &beyond).unwrap();
                    let before = bonds(&simulation);
                    assert!(simulation.step(0.1, 1).is_err());
                    assert_eq!(before, bonds(&simulation));
                }
                if step == 2 {
                    // A bond that is broken by hand between, and one that there is not.
                    simulation.break_bonds(&[[0, 1]]).unwrap();
                    simulation.set_bond_integrity(&[[0, points.count() - 1]], &[0.0]).unwrap();
                }
                simulation.set(Field::Velocity, &torn(0.07 * f64::from(step))).unwrap();
                simulation.step(0.1, 1).unwrap();
            }
            simulation
        });
        let name = format!("{formulation}, lattices {lattices}");
        assert!(bonds(&straight).iter().any(|&(_, _, integrity)| integrity == 0.0), "{name}");
        assert_eq!(bonds(&tried), bonds(&straight), "{name}");
        // But for the account of energy, which books each velocity that is given.
        let fields = |body| state_bits(body).into_iter().take(6);
        assert!(fields(&tried).eq(fields(&straight)), "{name}");
    }
}

#[test]
fn a_lattice_at_rest_or_moved_as_a_whole_has_no_force() {
    let points = Points::block(3, &[0.1; 3], &[1.7, 1.3, 1.2], 0.1).unwrap();
    for (level, formulation) in
        levels().into_iter().flat_map(|level| ON_LATTICES.map(|f| (level, f)))
    {
        let mut simulation = Simulation::new(&points, &model(formulation, 0.3015)).unwrap();
        simulation.set_simd(level).unwrap();
        assert!(simulation.get(Field::InternalForce).unwrap().iter().all(|&force| force == 0.0));
        let shift = [0.3, -1e3, 1e-7].repeat(points.count());
        simulation.set(Field::Displacement, &shift).unwrap();
        assert!(simulation.get(Field::InternalForce).unwrap().iter().all(|&force| force == 0.0));
    }
}

#[test]
fn points_that_fall_together_do_not_pull_on_each_other() {
    let points = Points::block(3, &[0.0; 3], &[12.0, 9.0, 9.0], 1.0).unwrap();
    let mut shift = vec![0.0; 3 * points.count()];
    (shift[3 * 500], shift[3 * 501]) = (0.5, -0.5);
    for formulation in ON_LATTICES {
        let [one_by_one, lattice] = [false, true].map(|lattices| {
            let mut simulation = simulation(&points, formulation, lattices);
            simulation.set_lanes(lattices).unwrap();
            simulation.set(Field::Displacement, &shift).unwrap();
            simulation.get(Field::InternalForce).unwrap()
        });
        let distance = distance(&one_by_one, &lattice);
        // Bond by bond l^2 is L^2 and a difference, which has fewer digits where nothing is left of l.
        assert!(distance < 1e-10, "{formulation}: {distance}");
    }
}

/// Rows and sheets along any axis: a stencil may lead nowhere along the first.
#[test]
fn bodies_one_point_thick_are_lattices_too() {
    let bodies: [(&[f64], f64); 7] = [
        (&[1.0, 60.0], 3.015),
        (&[60.0, 1.0], 3.015),
        (&[1.0, 60.0, 1.0], 3.015),
        (&[1.0, 1.0, 60.0], 3.015),
        (&[1.0, 14.0, 14.0], 2.015),
        (&[14.0, 1.0, 14.0], 2.015),
        (&[14.0, 14.0, 1.0], 2.015),
    ];
    for (formulation, (upper, horizon)) in
        ON_LATTICES.into_iter().flat_map(|name| bodies.map(|body| (name, body)))
    {
        let points = Points::block(upper.len(), &vec![0.0; upper.len()], upper, 1.0).unwrap();
        let shift = Random(11).around_zero(upper.len() * points.count(), 0.01);
        let [cloud, lattice] = [false, true].map(|lattices| {
            let model = model(formulation, horizon);
            let mut simulation = Simulation::new(&points, &model).unwrap();
            simulation.set_lattices(lattices).unwrap();
            simulation.set(Field::Displacement, &shift).unwrap();
            simulation.get(Field::InternalForce).unwrap()
        });
        let distance = distance(&cloud, &lattice);
        assert!(distance < 1e-12, "{formulation}, {upper:?}: {distance}");
    }
}

/// Integrities that come and go between steps, in a lattice with holes.
#[test]
fn groups_follow_integrities() {
    let block = Points::block(3, &[0.0; 3], &[14.0, 9.0, 9.0], 1.0).unwrap();
    let whole = block.coordinates().chunks_exact(3);
    let kept = whole.enumerate().filter(|(number, _)| number % 11 != 3);
    let coordinates: Vec<f64> = kept.flat_map(|(_, place)| place.to_vec()).collect();
    let points = Points::new(3, &coordinates, &vec![1.0; coordinates.len() / 3]).unwrap();
    follow_integrities(&points);
    follow_integrities(&with_one_off(&points, 330));
}

fn follow_integrities(points: &Points) {
    let velocity = Random(12).around_zero(3 * points.count(), 0.02);
    let near =
        |first: usize| -> Vec<[usize; 2]> { (first..first + 60).map(|i| [i, i + 1]).collect() };
    for formulation in ON_LATTICES {
        let [cloud, lattice] = [false, true].map(|lattices| {
            let mut simulation = simulation(points, formulation, lattices);
            simulation.set(Field::Velocity, &velocity).unwrap();
            let bonded: Vec<_> = bonds(&simulation).into_iter().map(|(pair, ..)| pair).collect();
            let of = |first: usize| -> Vec<[usize; 2]> {
                near(first).into_iter().filter(|pair| bonded.contains(pair)).collect()
            };
            let (some, others) = (of(200), of(400));
            simulation.step(0.1, 1).unwrap();
            for (pairs, value) in [(&some, 0.0), (&some, 1.0), (&others, 0.5), (&others, 1.0)] {
                simulation.set_bond_integrity(pairs, &vec![value; pairs.len()]).unwrap();
                simulation.step(0.1, 1).unwrap();
            }
            simulation
        });
        assert_eq!(intact(&cloud), intact(&lattice), "{formulation}");
        let fields = [Field::Displacement, Field::InternalForce, Field::DissipatedEnergyDensity];
        agree(formulation, [&cloud, &lattice], &fields);
    }
}

/// A failed step gives back what it broke, and bonds that are broken and set whole by hand are seen.
#[test]
fn groups_follow_the_bonds_whatever_changes_them() {
    let points = Points::block(2, &[0.0; 2], &[30.0, 20.0], 1.0).unwrap();
    let shift = Random(4).around_zero(2 * points.count(), 0.004);
    let run = |formulation: &str, lattices: bool| {
        let mut simulation = simulation(&points, formulation, lattices);
        simulation.set(Field::Displacement, &shift).unwrap();
        let mut forces = vec![simulation.get(Field::InternalForce).unwrap()];
        let far: Vec<f64> = shift.iter().map(|x| 1e200 * x).collect();
        simulation.set(Field::Velocity, &far).unwrap();
        assert!(simulation.step(0.1, 1).is_err());
        simulation.set(Field::Velocity, &vec![0.0; 2 * points.count()]).unwrap();
        forces.push(simulation.get(Field::InternalForce).unwrap());
        simulation.break_bonds(&[[0, 1], [33, 34], [33, 63]]).unwrap();
        forces.push(simulation.get(Field::InternalForce).unwrap());
        simulation.break_crossing(&[10.1, -1.0, 10.1, 9.0]).unwrap();
        simulation.step(0.1, 5).unwrap();
        forces.push(simulation.get(Field::InternalForce).unwrap());
        assert!(simulation.health().unwrap().broken_bonds > 10);
        forces.push(simulation.get(Field::DissipatedEnergyDensity).unwrap());
        forces
    };
    for formulation in ON_LATTICES {
        let (cloud, lattice) = (run(formulation, false), run(formulation, true));
        for (number, (cloud, lattice)) in cloud.iter().zip(&lattice).enumerate() {
            let distance = distance(cloud, lattice);
            assert!(distance < 1e-11, "{formulation}, {number}: {distance}");
        }
    }
}

#[test]
fn a_level_is_chosen_before_set_up() {
    let points = Points::block(2, &[0.0; 2], &[5.0, 5.0], 1.0).unwrap();
    let mut simulation = simulation(&points, "bond_based", true);
    simulation.set_simd(SimdLevel::Baseline).unwrap();
    bits(&simulation, Field::InternalForce);
    assert!(simulation.set_simd(SimdLevel::Baseline).is_err());
    assert!(simulation.set_lattices(false).is_err());
}

/// Bonds with an integrity of their own are computed one point after the other, on a lattice as in a cloud.
#[test]
fn weakened_bonds_of_a_lattice_pull_and_break_as_those_of_a_cloud() {
    for points in [mixed(), Points::block(2, &[0.0; 2], &[30.0, 20.0], 1.0).unwrap()] {
        let dimension = points.dimension();
        let shift = Random(4).around_zero(dimension * points.count(), 0.02);
        for level in levels() {
            let run = |lattices: bool| {
                let mut simulation = simulation(&points, "bond_based", lattices);
                simulation.set_simd(level).unwrap();
                simulation.break_bonds(&[[0, 1], [33, 34]]).unwrap();
                let weak: Vec<[usize; 2]> = (1..points.count() - 1).map(|k| [k, k + 1]).collect();
                simulation.set_bond_integrity(&weak, &vec![0.6; weak.len()]).unwrap();
                simulation.set(Field::Displacement, &shift).unwrap();
                let before = simulation.get(Field::InternalForce).unwrap();
                simulation.commit(1e-9).unwrap();
                let after = simulation.get(Field::InternalForce).unwrap();
                ([before, after].concat(), intact(&simulation))
            };
            let [cloud, lattice] = [run(false), run(true)];
            assert!(distance(&cloud.0, &lattice.0) < 1e-12, "{level:?}");
            assert!(cloud.1 == lattice.1, "{level:?}");
        }
    }
}

/// A block whose halves have these laws.
fn of_two_laws(
    name: &str,
    plane: Option<&str>,
    laws: [&str; 2],
    change: impl Fn(&mut Simulation),
) -> Simulation {
    let dimension = if plane.is_some() { 2 } else { 3 };
    let upper = if dimension == 2 { vec![44.0, 30.0] } else { vec![24.0, 11.0, 10.0] };
    let mut points = Points::block(dimension, &vec![0.0; dimension], &upper, 1.0).unwrap();
    let places = points.coordinates().chunks_exact(dimension).enumerate();
    let second: Vec<usize> =
        places.filter(|(_, place)| place[0] > 0.5 * upper[0]).map(|(point, _)| point).collect();
    points.add_set("second", &second).unwrap();
    let models = laws.map(|law| {
        let mut model = model(name, 3.015);
        model.choose("material", law).unwrap();
        plane.into_iter().for_each(|plane| model.choose("plane", plane).unwrap());
        model
    });
    let mut simulation = Simulation::new(&points, &models[0]).unwrap();
    simulation.assign_model("second", &models[1]).unwrap();
    change(&mut simulation);
    // Each edge is drawn or pressed by a third, each point shaken, and a few bonds are gone.
    let mut random = Random(21);
    let moved: Vec<f64> = points
        .coordinates()
        .iter()
        .enumerate()
        .map(|(k, x)| [0.35, -0.3, 0.1][k % dimension] * x + random.between(-0.05, 0.05))
        .collect();
    simulation.break_bonds(&[[0, 1], [70, 71], [400, 401]]).unwrap();
    simulation.set(Field::Displacement, &moved).unwrap();
    simulation.evaluate().unwrap();
    simulation
}

#[test]
fn elastic_laws_of_all_kinds_run_on_lattices() {
    let kinds = ["saint_venant_kirchhoff", "neo_hookean", "small_strain"];
    let fields = [Field::InternalForce, Field::StrainEnergyDensity, Field::FirstPiolaStress];
    for (name, plane) in ["correspondence", "bond_associated_quadrature"]
        .into_iter()
        .flat_map(|name| [None, Some("strain"), Some("stress")].map(|plane| (name, plane)))
    {
        for laws in [[kinds[1]; 2], [kinds[2]; 2], [kinds[0], kinds[1]], [kinds[1], kinds[2]]] {
            let body = |change: &dyn Fn(&mut Simulation)| of_two_laws(name, plane, laws, change);
            let single = body(&|simulation| simulation.set_lanes(false).unwrap());
            let cloud = body(&|simulation| simulation.set_lattices(false).unwrap());
            for level in levels() {
                let lattice = body(&|simulation| simulation.set_simd(level).unwrap());
                assert_ne!(lattice.memory().bonds, cloud.memory().bonds, "{name}: no lattice");
                for body in [&lattice, &cloud] {
                    for field in fields {
                        let [found, expected] =
                            [body, &single].map(|body| body.get(field).unwrap());
                        let distance = distance(&found, &expected);
                        let name = format!("{name}, {plane:?}, {laws:?}, {level:?}, {field:?}");
                        assert!(distance < 1e-11, "{name}: {distance}");
                    }
                }
            }
        }
    }
}

/// A point through which its neighbours have been drawn has no answer, and is named.
#[test]
fn a_lattice_that_is_turned_inside_out_is_refused_as_a_cloud_is() {
    let block = Points::block(3, &[0.0; 3], &[14.0, 11.0, 9.0], 1.0).unwrap();
    for name in ["correspondence", "bond_associated_quadrature"] {
        let mut moved = vec![0.0; 3 * block.count()];
        for (place, moved) in block.coordinates().chunks(3).zip(moved.chunks_exact_mut(3)) {
            moved[0] = -2.0 * (place[0] - 7.0).clamp(-1.0, 1.0);
        }
        let errors = [true, false].map(|lattices| {
            let mut model = model(name, 3.015);
            model.choose("material", "neo_hookean").unwrap();
            let mut simulation = Simulation::new(&block, &model).unwrap();
            simulation.set_lattices(lattices).unwrap();
            simulation.set(Field::Displacement, &moved).unwrap();
            simulation.evaluate().unwrap_err().to_string()
        });
        assert_eq!(errors[0], errors[1], "{name}");
    }
}
