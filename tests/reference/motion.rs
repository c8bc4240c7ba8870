//! Sixty steps of velocity Verlet, with and without bonds that break.

use crate::data::{Reference, assert_close, assert_near, difference, largest};
use perion::{Field, Model, Simulation};
use std::ops::ControlFlow;

/// Forces differ by 1e-14 as at rest, and 60 steps add that up: the motion is not chaotic, and no bond
/// comes nearer to its critical stretch than 6e-7.
const TOLERANCE: f64 = 1e-12;

pub fn model(reference: &Reference) -> Model {
    let mut model = Model::new("bond_based").unwrap();
    for key in ["density", "horizon", "youngs_modulus", "poissons_ratio", "critical_stretch"] {
        model.set(key, reference.number(key)).unwrap();
    }
    model
}

fn body(reference: &Reference, model: &Model) -> Simulation {
    let mut body = Simulation::new(&reference.points(), model).unwrap();
    body.set(Field::Velocity, &reference.numbers("initial_velocity")).unwrap();
    body
}

/// What the energies and the number of broken bonds are after each step.
#[derive(Default)]
struct History {
    kinetic: Vec<f64>,
    elastic: Vec<f64>,
    broken: Vec<f64>,
}

fn run(reference: &Reference, body: &mut Simulation) -> History {
    let mut history = History::default();
    let steps = reference.numbers("kinetic_energy").len() as u64;
    body.step_watched(reference.number("time_step"), steps, |body, _| {
        let energy = body.energy().unwrap();
        history.kinetic.push(energy.kinetic);
        history.elastic.push(energy.elastic);
        history.broken.push(body.health().unwrap().broken_bonds as f64);
        ControlFlow::Continue(())
    })
    .unwrap();
    history
}

fn compare(name: &str, storage: &str) -> Simulation {
    let reference = Reference::load(name);
    let mut model = model(&reference);
    model.choose("storage", storage).unwrap();
    let mut body = body(&reference, &model);
    let history = run(&reference, &mut body);
    // The reference counts a broken bond at both of its ends.
    let ends: Vec<f64> = history.broken.iter().map(|bonds| 2.0 * bonds).collect();
    assert_eq!(ends, reference.numbers("broken_ends"), "{name}");
    for (key, found) in [("kinetic_energy", &history.kinetic), ("strain_energy", &history.elastic)]
    {
        assert_close(key, found, &reference.numbers(key), TOLERANCE);
    }
    for (key, field) in [("current", Field::Position), ("velocity", Field::Velocity)] {
        assert_close(key, &body.get(field).unwrap(), &reference.numbers(key), TOLERANCE);
    }
    // Displacements are a hundredth of the positions, so this asks more than the line above.
    let found = body.get(Field::Displacement).unwrap();
    assert_close("displacement", &found, &reference.displacement(), TOLERANCE);
    for (found, expected) in
        body.get(Field::Damage).unwrap().iter().zip(reference.numbers("damage"))
    {
        // The same bonds are broken: what differs are roundings of two sums of volumes.
        assert!((found - expected).abs() <= 1e-14, "{name}: {found}, not {expected}");
    }
    body
}

#[test]
fn sixty_steps_of_a_whole_body_are_those_of_the_reference() {
    for storage in ["fast", "lean"] {
        let energy = compare("verlet_bb", storage).energy().unwrap();
        assert_eq!((energy.dissipated, energy.external_work), (0.0, 0.0));
    }
}

#[test]
fn sixty_steps_of_a_breaking_body_are_those_of_the_reference() {
    for storage in ["fast", "lean"] {
        let body = compare("verlet_bb_fracture", storage);
        assert_eq!(body.step_count(), 60);
        assert_eq!(body.health().unwrap().broken_bonds, 165);
    }
}

#[test]
fn bonds_that_never_break_move_as_if_they_could_not() {
    let reference = Reference::load("verlet_bb");
    let mut lasting = Model::new("bond_based").unwrap();
    for key in ["density", "horizon", "youngs_modulus"] {
        lasting.set(key, reference.number(key)).unwrap();
    }
    let run = |model: &Model| {
        let mut body = body(&reference, model);
        body.step(reference.number("time_step"), 60).unwrap();
        [Field::Displacement, Field::Velocity].map(|field| body.get(field).unwrap())
    };
    assert_eq!(run(&lasting), run(&model(&reference)));
}

/// The step by hand, from forces that other simulations evaluate: both accelerations hold the internal
/// and the body force, the first one those at time zero.
#[test]
fn the_first_step_starts_from_the_acceleration_at_time_zero() {
    let (reference, density, step) = (Reference::load("mech3d_jitter_const_broken"), 2.5, 1e-3);
    let mut model = reference.model();
    model.set("density", density).unwrap();
    let count = reference.points().count();
    let gravity: Vec<f64> = (0..3 * count).map(|place| 7.0 - (place % 5) as f64).collect();
    let speed: Vec<f64> = (0..3 * count).map(|place| 0.1 * (place % 7) as f64 - 0.3).collect();
    let mut body = reference.body_of(&model);
    body.set(Field::BodyForce, &gravity).unwrap();
    body.set(Field::Velocity, &speed).unwrap();
    body.evaluate().unwrap();
    let before = body.get(Field::Acceleration).unwrap();
    let acceleration = |force: Vec<f64>| -> Vec<f64> {
        force.iter().zip(&gravity).map(|(force, load)| (force + load) / density).collect()
    };
    assert_eq!(before, acceleration(body.get(Field::InternalForce).unwrap()));

    let start = body.get(Field::Displacement).unwrap();
    let halfway: Vec<f64> = speed.iter().zip(&before).map(|(v, a)| v + 0.5 * step * a).collect();
    let moved: Vec<f64> = start.iter().zip(&halfway).map(|(u, v)| u + step * v).collect();
    let mut there = reference.body_of(&model);
    there.set(Field::Displacement, &moved).unwrap();
    let after = acceleration(there.get(Field::InternalForce).unwrap());
    let speed: Vec<f64> = halfway.iter().zip(&after).map(|(v, a)| v + 0.5 * step * a).collect();

    // One step with the same formulas and at most a rounding apart in each.
    body.step(step, 1).unwrap();
    assert_close("displacement", &body.get(Field::Displacement).unwrap(), &moved, 1e-15);
    assert_close("acceleration", &body.get(Field::Acceleration).unwrap(), &after, 1e-14);
    assert_close("velocity", &body.get(Field::Velocity).unwrap(), &speed, 1e-14);
}

/// At the reference positions nothing pulls, so the first step of the reference is v0 times the step.
#[test]
fn an_unstrained_body_drifts_freely_in_its_first_step() {
    let reference = Reference::load("verlet_bb");
    let mut body = body(&reference, &model(&reference));
    body.evaluate().unwrap();
    assert_eq!(largest(&body.get(Field::Acceleration).unwrap()), 0.0);
    let step = reference.number("time_step");
    let drift: Vec<f64> = reference.numbers("initial_velocity").iter().map(|v| v * step).collect();
    let mut there = Simulation::new(&reference.points(), &model(&reference)).unwrap();
    there.set(Field::Displacement, &drift).unwrap();
    let expected = reference.numbers("strain_energy")[0];
    assert_near("strain energy", there.energy().unwrap().elastic, expected, 1e-12);
    body.step(step, 1).unwrap();
    let apart = difference(&body.get(Field::Displacement).unwrap(), &drift);
    assert_eq!(largest(&apart), 0.0);
}
