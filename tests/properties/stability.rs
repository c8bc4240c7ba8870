//! Stability: the step that is called stable is, and it is not uselessly small.

use perion::{Field, Model, Points, Simulation};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use crate::random::{Random, cases};
use crate::scene::small_bodies;

/// What velocity Verlet conserves in place of the energy [formulas.md, Time]:
/// KE + SE - dt^2/8 sum V |b|^2/rho.
pub fn conserved(simulation: &Simulation, time_step: f64) -> f64 {
    let [volumes, densities, forces] = [Field::Volume, Field::Density, Field::InternalForce]
        .map(|field| simulation.get(field).unwrap());
    let dimension = simulation.points().dimension();
    let kick: f64 = forces
        .chunks_exact(dimension)
        .zip(volumes.iter().zip(&densities))
        .map(|(force, (volume, density))| {
            volume / density * force.iter().map(|b| b * b).sum::<f64>()
        })
        .sum();
    let energy = simulation.energy().unwrap();
    energy.kinetic + energy.elastic - time_step * time_step / 8.0 * kick
}

/// Lets go from random displacements and steps 2000 times at the step that is called stable.
fn stays(
    simulation: &mut Simulation,
    spacing: f64,
    random: &mut Random,
) -> Result<(), TestCaseError> {
    let components = simulation.points().coordinates().len();
    // Small enough for the stretch of bonds to be linear, so that the quantity is kept to rounding.
    simulation.set(Field::Displacement, &random.around_zero(components, 1e-6 * spacing)).unwrap();
    let time_step = simulation.stable_time_step().unwrap();
    let start = conserved(simulation, time_step);
    prop_assert!(start > 0.0);
    for _ in 0..10 {
        simulation.step(time_step, 200).unwrap();
        let now = conserved(simulation, time_step);
        prop_assert!((now / start - 1.0).abs() < 0.01, "{now} of {start}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(40))]

    #[test]
    fn the_stable_step_is_stable(recipe in small_bodies(), wound: bool) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(None);
        if wound {
            scene.wound(&mut simulation);
        }
        stays(&mut simulation, scene.spacing, &mut scene.random(20))?;
    }

    #[test]
    fn the_stable_step_of_two_points_is_stable(dimension in 2..4_usize, seed: u64) {
        let mut random = Random(seed);
        let place = random.around_zero(dimension, 1.0);
        let opposite = place.iter().map(|x| -x).collect();
        let pair = [place.clone(), opposite].concat();
        let length = 2.0 * place.iter().map(|x| x * x).sum::<f64>().sqrt();
        let volumes = [random.between(0.1, 3.0), random.between(0.1, 3.0)];
        let mut points = Points::new(dimension, &pair, &volumes).unwrap();
        points.add_set("second", &[1]).unwrap();
        // The second point reaches the first, or both reach each other.
        let short = random.between(0.3, 1.4);
        points.set_horizons(&[short * length, random.between(1.01, 2.0) * length]).unwrap();
        let mut model = Model::new("bond_based").unwrap();
        model.set("youngs_modulus", 3.0).unwrap();
        model.set("density", 1.0).unwrap();
        let mut simulation = Simulation::new(&points, &model).unwrap();
        model.set("density", random.between(0.1, 10.0)).unwrap();
        simulation.assign_model("second", &model).unwrap();
        stays(&mut simulation, length, &mut random)?;
    }

    #[test]
    fn four_times_the_stable_step_of_a_block_is_not_stable(
        counts in [4..7_i32, 4..7_i32, 4..7_i32], ratio in 2.2..3.3_f64, seed: u64,
    ) {
        let upper = counts.map(f64::from);
        let block = Points::block(3, &[0.0; 3], &upper, 1.0).unwrap();
        let model = model("bond_based", [2.0, 3.0, ratio]);
        let growth = |factor: f64| {
            let mut simulation = Simulation::new(&block, &model).unwrap();
            let components = 3 * block.count();
            let start = Random(seed).around_zero(components, 1e-6);
            simulation.set(Field::Displacement, &start).unwrap();
            let energy = simulation.energy().unwrap().elastic;
            let time_step = factor * simulation.stable_time_step().unwrap();
            let outcome = simulation.step(time_step, 100);
            assert!(!matches!(outcome, Err(perion::Error::Argument(_))), "{outcome:?}");
            let ratio = simulation.health().unwrap().time_step_ratio;
            assert!((ratio / factor - 1.0).abs() < 1e-14, "{ratio} {factor}");
            simulation.energy().unwrap().kinetic / energy
        };
        prop_assert!(growth(0.999) < 2.0);
        prop_assert!(growth(4.0) > 1e6);
        // Accepted, whatever comes of it.
        growth(2.2);
    }
}

/// A material of a density, Young's modulus and horizon.
fn model(formulation: &str, [density, youngs_modulus, horizon]: [f64; 3]) -> Model {
    let mut model = Model::new(formulation).unwrap();
    model.set("density", density).unwrap();
    model.set("youngs_modulus", youngs_modulus).unwrap();
    model.set("horizon", horizon).unwrap();
    if formulation != "bond_based" {
        model.set("poissons_ratio", 0.2).unwrap();
    }
    model
}

/// A body of a formulation with a few points that are so much stiffer, at random places.
fn with_stiff_spots(formulation: &str, stiffer: f64, spots: usize, seed: u64) -> Simulation {
    let mut random = Random(seed);
    let mut points = Points::block(3, &[0.0; 3], &[14.0, 13.0, 12.0], 1.0).unwrap();
    let picked: Vec<usize> =
        (0..spots).map(|_| random.between(0.0, points.count() as f64) as usize).collect();
    points.add_set("second", &picked).unwrap();
    let of_modulus = |modulus: f64| model(formulation, [2.0, modulus, 2.015]);
    let mut simulation = Simulation::new(&points, &of_modulus(3.0)).unwrap();
    simulation.assign_model("second", &of_modulus(3.0 * stiffer)).unwrap();
    simulation
}

/// A step that is far below the limit is let pass after a few forces; one beyond it never is, however small the place that is
/// stiffer than all others.
#[test]
fn steps_beyond_the_limit_are_told_from_those_below_wherever_it_comes_from() {
    let forms = ["bond_based", "ordinary_state_based", "correspondence_silling"];
    for (number, stiffer) in [1.0, 1.3, 2.0, 5.0, 30.0, 1e3, 1e6].into_iter().enumerate() {
        for (form, spots) in forms.into_iter().zip([1, 3, 1]) {
            let body = || with_stiff_spots(form, stiffer, spots, 50 + number as u64);
            let stable = body().stable_time_step().unwrap();
            for factor in [0.01, 0.3, 0.6, 0.8, 0.9, 0.96, 1.04, 1.2, 3.0, 9.0] {
                let name = format!("{form}, {spots} spots {stiffer} times as stiff, {factor}");
                let mut simulation = body();
                simulation.step(factor * stable, 0).unwrap();
                let known = simulation.health().unwrap().stable_time_step;
                if factor > 1.0 {
                    assert_eq!(known, stable, "{name}");
                } else {
                    assert!(known >= factor * stable, "{name}: {known} {stable}");
                }
                // Whoever asks is told the limit itself.
                assert_eq!(simulation.stable_time_step().unwrap(), stable, "{name}");
            }
            assert!(body().step(11.0 * stable, 1).is_err());
        }
    }
}

/// Pressed bodies have modes that grow by themselves, and what a search comes to begins below 0.
#[test]
fn steps_beyond_the_limit_of_pressed_bodies_are_told() {
    for (number, form) in ["bond_based", "correspondence", "bond_associated"].iter().enumerate() {
        for percent in (25..100).step_by(5) {
            let scale = f64::from(percent) / 100.0;
            let body = || {
                let points = Points::block(3, &[0.0; 3], &[5.0, 4.0, 6.0], 1.0).unwrap();
                let model = model(form, [2.0, 3.0, 2.3]);
                let mut simulation = Simulation::new(&points, &model).unwrap();
                let mut random = Random(70 + number as u64);
                let places = points.coordinates().iter();
                let pressed: Vec<f64> =
                    places.map(|x| (scale - 1.0) * x + random.between(-0.01, 0.01)).collect();
                simulation.set(Field::Displacement, &pressed).unwrap();
                simulation
            };
            let Ok(stable) = body().stable_time_step() else { continue };
            for factor in [1.05, 1.5, 2.0, 3.0, 5.0, 9.0] {
                let mut simulation = body();
                simulation.step(factor * stable, 0).unwrap();
                let known = simulation.health().unwrap().stable_time_step;
                assert_eq!(known, stable, "{form} pressed to {scale}, {factor}");
            }
        }
    }
}

#[test]
fn the_stable_step_of_a_few_points_does_not_depend_on_where_they_lie() {
    for points in [2, 3] {
        for strain in [0.0, -0.03] {
            let steps = (0..300).map(|number| {
                let (sin, cos) = (0.021 * f64::from(number)).sin_cos();
                let place = |point: i32| [cos, sin].map(|along| along * f64::from(point));
                let coordinates: Vec<f64> = (0..points).flat_map(place).collect();
                let body = Points::new(2, &coordinates, &vec![1.0; points as usize]).unwrap();
                let model = model("bond_based", [1.0, 3.0, 1.5]);
                let mut simulation = Simulation::new(&body, &model).unwrap();
                let moved: Vec<f64> = coordinates.iter().map(|x| strain * x).collect();
                simulation.set(Field::Displacement, &moved).unwrap();
                simulation.stable_time_step().unwrap()
            });
            let steps: Vec<f64> = steps.collect();
            let [least, most] =
                [f64::min, f64::max].map(|of| steps.iter().copied().fold(steps[0], of));
            assert!(most / least < 1.0 + 1e-5, "{points} {strain}: {least} {most}");
        }
    }
}

/// Hosts that break bonds and change their step are told the same as one that asks.
#[test]
fn what_is_known_of_a_step_follows_bonds_and_larger_steps() {
    let mut simulation = with_stiff_spots("correspondence", 1.0, 2, 60);
    let mut fresh = with_stiff_spots("correspondence", 1.0, 2, 60);
    let stable = fresh.stable_time_step().unwrap();
    simulation.step(0.3 * stable, 1).unwrap();
    let health = simulation.health().unwrap();
    assert!(!health.stable_step_is_guaranteed && health.stable_time_step >= 0.3 * stable);
    assert!((health.stable_time_step / stable - 1.0).abs() < 0.1, "{health:?}");
    // A larger one is compared with the limit itself, and so are all after it.
    simulation.step(0.31 * stable, 1).unwrap();
    let health = simulation.health().unwrap();
    assert!(health.stable_step_is_guaranteed);
    assert!((health.stable_time_step / stable - 1.0).abs() < 1e-3, "{health:?}");
    for simulation in [&mut simulation, &mut fresh] {
        simulation.break_bonds(&[[100, 101], [700, 701]]).unwrap();
    }
    let stable = fresh.stable_time_step().unwrap();
    simulation.step(0.3 * stable, 1).unwrap();
    let ratio = simulation.health().unwrap().time_step_ratio;
    assert!((ratio / 0.3 - 1.0).abs() < 0.06, "{ratio}");
}

/// A block of 6 x 6 x 6 points, all positions scaled by a factor and let go.
fn squeezed(factor: f64) -> Simulation {
    let points = Points::block(3, &[0.0; 3], &[6.0; 3], 1.0).unwrap();
    let model = model("bond_based", [1.0, 1.0, 3.015]);
    let mut simulation = Simulation::new(&points, &model).unwrap();
    let displacement: Vec<f64> =
        points.coordinates().iter().map(|x| (factor - 1.0) * (x - 3.0)).collect();
    simulation.set(Field::Displacement, &displacement).unwrap();
    simulation
}

/// Far beyond small strains half of the returned step holds, as its documentation says; what `health` tells of
/// compressed bonds is where nothing is promised any more.
#[test]
fn a_block_stretched_or_squeezed_by_a_sixth_neither_gains_nor_loses_energy() {
    for factor in [0.85, 1.15] {
        let mut simulation = squeezed(factor);
        let time_step = 0.5 * simulation.stable_time_step().unwrap();
        let start = simulation.energy().unwrap().elastic;
        // At such steps the energy swings by a tenth, and at which phase it is caught is chance: what counts is its mean.
        let mut mean_of = |steps: u32| {
            let totals = (0..steps).map(|_| {
                simulation.step(time_step, 1).unwrap();
                let energy = simulation.energy().unwrap();
                (energy.kinetic + energy.elastic) / start
            });
            totals.sum::<f64>() / f64::from(steps)
        };
        let means: Vec<f64> = (0..10).map(|_| mean_of(200)).collect();
        for mean in &means {
            assert!((mean - 1.0).abs() < 0.05, "{factor}: {means:?}");
        }
        for later in &means[2..] {
            assert!((later / means[1] - 1.0).abs() < 0.02, "{factor}: {means:?}");
        }
    }
    let smallest = squeezed(0.6).health().unwrap().smallest_stretch;
    assert!((smallest + 0.4).abs() < 1e-12, "{smallest}");
}
