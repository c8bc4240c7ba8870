//! The account of energy: what steps change is what loads, constraints and the host put in.

use std::ops::ControlFlow;

use perion::{Field, Quantity, Simulation};
use proptest::prelude::*;

use crate::random::cases;
use crate::scene::{Horizons, Recipe, Scene, bonds, small_bodies};

/// What drives a body.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drive {
    DisplacementTable,
    DisplacementFunction,
    ConstantVelocity,
    VelocityFunction,
    ConstantBodyForce,
    BodyForceTable,
    HostBodyForce,
    All,
}

fn drives() -> impl Strategy<Value = Drive> {
    prop_oneof![
        Just(Drive::DisplacementTable),
        Just(Drive::DisplacementFunction),
        Just(Drive::ConstantVelocity),
        Just(Drive::VelocityFunction),
        Just(Drive::ConstantBodyForce),
        Just(Drive::BodyForceTable),
        Just(Drive::HostBodyForce),
        Just(Drive::All),
    ]
}

/// Loads a body so that bonds strain by about `strain` within `duration`.
fn drive(scene: &Scene, simulation: &mut Simulation, drive: Drive, strain: f64, duration: f64) {
    let reach = strain * scene.spacing;
    let speed = reach / duration;
    let load = strain * scene.bulk_modulus() / scene.largest_horizon();
    let is = |wanted: Drive| drive == wanted || drive == Drive::All;
    let times = [0.0, 0.4 * duration, duration];
    if is(Drive::DisplacementTable) {
        let values = [0.0, 0.5 * reach, reach];
        simulation.prescribe_table("left", Quantity::Displacement, 0, &times, &values).unwrap();
    }
    if is(Drive::DisplacementFunction) {
        let waves = move |time: f64, places: &[f64], values: &mut [f64]| {
            let each = places.len() / values.len();
            for (value, place) in values.iter_mut().zip(places.chunks(each)) {
                *value = reach * (place[0] / reach * strain).cos() * (time / duration).powi(2);
            }
            ControlFlow::Continue(())
        };
        simulation.prescribe_function("left", Quantity::Displacement, 1, Box::new(waves)).unwrap();
    }
    if is(Drive::ConstantVelocity) {
        simulation.prescribe("right", Quantity::Velocity, 0, speed).unwrap();
    }
    if is(Drive::VelocityFunction) {
        let waves = move |time: f64, _: &[f64], values: &mut [f64]| {
            values.fill(speed * (5.0 * time / duration).sin());
            ControlFlow::Continue(())
        };
        simulation.prescribe_function("right", Quantity::Velocity, 1, Box::new(waves)).unwrap();
    }
    if is(Drive::ConstantBodyForce) {
        simulation.prescribe("all", Quantity::BodyForce, 1, load).unwrap();
    }
    if is(Drive::BodyForceTable) {
        let values = [load, -load, 0.5 * load];
        simulation.prescribe_table("right", Quantity::BodyForce, 1, &times, &values).unwrap();
    }
    if is(Drive::HostBodyForce) {
        let own = scene.random(31).around_zero(scene.components(), load);
        simulation.set(Field::BodyForce, &own).unwrap();
    }
}

/// 1/2 sum m a^2, as far as points are free.
fn half_squared_acceleration(simulation: &Simulation) -> f64 {
    let [volumes, densities, accelerations] =
        [Field::Volume, Field::Density, Field::Acceleration].map(|f| simulation.get(f).unwrap());
    let dimension = simulation.points().dimension();
    let squares = accelerations.iter().enumerate();
    squares.map(|(k, a)| 0.5 * volumes[k / dimension] * densities[k / dimension] * a * a).sum()
}

/// The largest of kinetic energy, elastic energy and work: what errors are measured by.
fn scale(simulation: &Simulation) -> f64 {
    let energy = simulation.energy().unwrap();
    energy.kinetic.max(energy.elastic).max(energy.external_work.abs()).max(energy.dissipated)
}

proptest! {
    #![proptest_config(cases(64))]

    /// Where bonds are linear, velocity Verlet misses the energy by dt^2/8 sum m (a_n^2 - a_0^2)
    /// and nothing else: the work of every load and constraint is exact.
    #[test]
    fn the_closure_error_is_that_of_velocity_verlet_alone(
        recipe in small_bodies(), wound: bool, kind in drives(), share in 0.3..1.0_f64,
    ) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(None);
        if wound {
            scene.wound(&mut simulation);
        }
        let time_step = share * simulation.stable_time_step().unwrap();
        let start = scene.random(32).around_zero(scene.components(), 1e-9 * scene.spacing);
        simulation.set(Field::Displacement, &start).unwrap();
        drive(&scene, &mut simulation, kind, 1e-7, 60.0 * time_step);
        simulation.evaluate().unwrap();
        let before = half_squared_acceleration(&simulation);
        let mut largest = 0.0;
        for steps in [1, 9, 50] {
            simulation.step(time_step, steps).unwrap();
            let kick = half_squared_acceleration(&simulation) - before;
            let expected = 0.25 * time_step * time_step * kick;
            let error = simulation.energy().unwrap().closure_error - expected;
            // Bonds bend the straight line by their strain, 1e-7, and by the turn of long bodies.
            largest = scale(&simulation).max(largest);
            let relative = error.abs() / largest;
            prop_assert!(relative < 1e-5, "{relative:e} after {steps} steps");
        }
    }
}

/// Root mean square of the closure error at ten times up to `duration`, and the largest scale.
fn closure(scene: &Scene, kind: Drive, strain: f64, duration: f64, tenth: u64) -> (f64, f64) {
    let mut simulation = scene.simulation(None);
    drive(scene, &mut simulation, kind, strain, duration);
    let (mut sum, mut largest) = (0.0, 0.0);
    for _ in 0..10 {
        simulation.step(duration / (10 * tenth) as f64, tenth).unwrap();
        sum += simulation.energy().unwrap().closure_error.powi(2);
        largest = scale(&simulation).max(largest);
    }
    ((sum / 10.0).sqrt(), largest)
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn the_closure_error_falls_with_the_square_of_the_step(
        recipe in small_bodies(), kind in drives(), strain in 0.001..0.02_f64,
    ) {
        let scene = recipe.scene();
        let stable = scene.simulation(None).stable_time_step().unwrap();
        let duration = 40.0 * stable;
        let (coarse, _) = closure(&scene, kind, strain, duration, 32);
        let (fine, size) = closure(&scene, kind, strain, duration, 64);
        // A sixteenth of the stable step: the highest frequency's share of (omega dt)^2/8.
        prop_assert!(fine < 2e-3 * size, "{fine:e} of {size:e}");
        let ratio = coarse / fine;
        // A body that falls as a whole has no error but rounding.
        prop_assert!((3.6..4.4).contains(&ratio) || fine < 1e-12 * size, "{ratio} {fine} {size}");
    }

    /// A bond that breaks within a step has pulled last at its beginning: it has been given
    /// E s_n/s_{n+1} of the energy E at its end, and that is dissipated. Only a bond that was pressed at
    /// the beginning of the very step in which it breaks leaves an error, since it dissipates nothing.
    #[test]
    fn energy_closes_while_bonds_break(
        recipe in small_bodies(), kind in drives(), share in 0.05..1.0_f64,
    ) {
        let recipe = Recipe { horizons: Horizons::Uniform, materials: 1, ..recipe };
        let scene = recipe.scene();
        let critical = 1e-6;
        let mut simulation = scene.simulation(Some(critical));
        let time_step = share * simulation.stable_time_step().unwrap();
        let steps = (20.0 / share) as u64;
        let size = 0.2 * critical * scene.spacing;
        let start = scene.random(34).around_zero(scene.components(), size);
        simulation.set(Field::Displacement, &start).unwrap();
        drive(&scene, &mut simulation, kind, 10.0 * critical, steps as f64 * time_step);
        simulation.evaluate().unwrap();
        let start = half_squared_acceleration(&simulation);
        let mut missed = 0.0;
        let mut before = bonds(&simulation);
        let mut largest = 0.0;
        for _ in 0..steps {
            simulation.step(time_step, 1).unwrap();
            let after = bonds(&simulation);
            let weighed = |bond: &([usize; 2], f64, f64)| bond.1 * bond.1 * scene.bond_weight(bond.0);
            let (mut pressed, mut intact) = (0.0, 0.0);
            for (old, new) in before.iter().zip(&after) {
                if old.2 != new.2 {
                    prop_assert!(new.1 > critical && new.2 == 0.0);
                    pressed += weighed(new) * (-old.1 / new.1).max(0.0);
                }
                intact += new.2 * weighed(new);
            }
            if pressed > 0.0 {
                missed += pressed * simulation.energy().unwrap().elastic / intact;
            }
            before = after;
            let kick = half_squared_acceleration(&simulation) - start;
            let expected = 0.25 * time_step * time_step * kick;
            let error = simulation.energy().unwrap().closure_error - expected;
            // Bonds bend the straight line by their strain, 1e-5, and more once parts fly about.
            largest = scale(&simulation).max(largest);
            let rounding = 1e-4 * largest;
            prop_assert!(error.abs() <= missed + rounding, "{error:e} {missed:e} {rounding:e}");
        }
    }

    #[test]
    fn what_the_host_changes_by_hand_is_no_closure_error(
        recipe in small_bodies(), kind in drives(),
    ) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(Some(0.05));
        let time_step = 0.2 * simulation.stable_time_step().unwrap();
        drive(&scene, &mut simulation, kind, 0.02, 100.0 * time_step);
        let mut random = scene.random(33);
        let pairs: Vec<[usize; 2]> =
            bonds(&simulation).iter().map(|bond| bond.0).collect();
        for change in 0..12 {
            simulation.step(time_step, 8).unwrap();
            let before = simulation.energy().unwrap();
            let pair = [pairs[random.below(pairs.len())]];
            let host = |field| simulation.get(field).unwrap();
            match change % 6 {
                0 | 1 => {
                    let field = [Field::Displacement, Field::Velocity][change % 2];
                    let mut values = host(field);
                    let per = [1.0, time_step][change % 2];
                    let size = 0.01 * scene.spacing / per;
                    let shake = random.around_zero(scene.components(), size);
                    values.iter_mut().zip(&shake).for_each(|(value, by)| *value += by);
                    simulation.set(field, &values).unwrap();
                    // Once more: changes may come one on another.
                    simulation.set(field, &values).unwrap();
                }
                2 => simulation.break_bonds(&pair).unwrap(),
                3 => simulation.set_bond_integrity(&pair, &[random.between(0.0, 1.0)]).unwrap(),
                4 => simulation.set_time(0.5 * simulation.time()).unwrap(),
                _ => {
                    let load = 0.01 * scene.bulk_modulus() / scene.largest_horizon();
                    let own = random.around_zero(scene.components(), load);
                    simulation.set(Field::BodyForce, &own).unwrap();
                }
            }
            let size = scale(&simulation).max(before.kinetic).max(before.elastic);
            let jump = |simulation: &Simulation| {
                (simulation.energy().unwrap().closure_error - before.closure_error).abs() / size
            };
            prop_assert!(jump(&simulation) < 1e-13, "{change}: {:e}", jump(&simulation));
            simulation.evaluate().unwrap();
            simulation.start_stepping(time_step, 1).unwrap();
            prop_assert!(jump(&simulation) < 1e-13, "{change}: {:e}", jump(&simulation));
        }
    }
}
