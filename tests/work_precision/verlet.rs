//! Velocity Verlet: second order in time, the way back, and the energy that it keeps.

use crate::method;
use crate::precision::{Resolution, manufactured::Cube};
use perion::{Field, Model, Points, Simulation};

/// The displacement of the swinging cube at time 1, after so many steps.
fn swung(steps: u64) -> Vec<f64> {
    let (cube, model) =
        Cube::of(method("bond_associated_quadrature"), Resolution { across: 4, ratio: 2 }).unwrap();
    let mut body = cube.swinging(&model).unwrap();
    body.step(1.0 / steps as f64, steps).unwrap();
    body.get(Field::Displacement).unwrap()
}

fn largest_difference(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).fold(0.0, |largest, (one, other)| (one - other).abs().max(largest))
}

#[test]
fn errors_fall_with_the_square_of_the_step() {
    let displacements = [16, 32, 64, 128].map(swung);
    let apart: Vec<f64> =
        displacements.windows(2).map(|pair| largest_difference(&pair[0], &pair[1])).collect();
    for pair in apart.windows(2) {
        let slope = (pair[0] / pair[1]).log2();
        println!("slope in time: {slope:.4}");
        assert!((slope - 2.0).abs() < 0.05, "{slope}: {apart:?}");
    }
}

/// Of a spacing: so small that all is linear. By a thousandth, the energy of bonds that turn passes between fast and slow
/// motions, of which the step sees different parts: 8e-5 of it.
const AMPLITUDE: f64 = 1e-6;

/// A free cube of 4 x 4 x 4 points that swings, and half of its stable step.
fn shaken(formulation: &str) -> (Simulation, f64) {
    let points = Points::block(3, &[0.0; 3], &[4.0; 3], 1.0).unwrap();
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in
        [("density", 1.0), ("youngs_modulus", 1.0), ("poissons_ratio", 0.25), ("horizon", 3.015)]
    {
        model.set(key, value).unwrap();
    }
    let mut body = Simulation::new(&points, &model).unwrap();
    body.set_threads(1).unwrap();
    let start = (0..3 * points.count()).map(|k| AMPLITUDE * (1.0 + 7.0 * k as f64).sin());
    body.set(Field::Displacement, &start.collect::<Vec<_>>()).unwrap();
    let step = 0.5 * body.stable_time_step().unwrap();
    (body, step)
}

const FORMS: [&str; 4] =
    ["bond_based", "ordinary_state_based", "correspondence", "bond_associated_quadrature"];

#[test]
fn a_thousand_steps_back_end_at_the_start() {
    for formulation in FORMS {
        let (mut body, step) = shaken(formulation);
        let start = body.get(Field::Displacement).unwrap();
        body.step(step, 1000).unwrap();
        let back: Vec<f64> = body.get(Field::Velocity).unwrap().iter().map(|v| -v).collect();
        body.set(Field::Velocity, &back).unwrap();
        body.step(step, 1000).unwrap();
        let apart = largest_difference(&body.get(Field::Displacement).unwrap(), &start) / AMPLITUDE;
        println!("{formulation}: {apart:e} of the largest displacement");
        assert!(apart < 1e-9, "{formulation}: {apart}");
    }
}

/// KE + SE - dt^2/8 sum V rho a^2, what velocity Verlet keeps of a linear body, over the next thousand steps.
fn mean_energy(body: &mut Simulation, step: f64) -> f64 {
    let mut sum = 0.0;
    for _ in 0..1000 {
        body.step(step, 1).unwrap();
        let energy = body.energy().unwrap();
        // Volume and density are 1.
        let squares: f64 = body
            .get(Field::Acceleration)
            .unwrap()
            .iter()
            .map(|acceleration| acceleration * acceleration)
            .sum();
        sum += energy.kinetic + energy.elastic - step * step / 8.0 * squares;
    }
    sum / 1000.0
}

fn check_drift(formulation: &str, steps: u64) {
    let (mut body, step) = shaken(formulation);
    let first = mean_energy(&mut body, step);
    body.step(step, steps - 2000).unwrap();
    let drift = mean_energy(&mut body, step) / first - 1.0;
    println!("{formulation}: the energy drifts by {drift:e} in {steps} steps");
    assert!(drift.abs() < 1e-6, "{formulation}: {drift}");
}

#[test]
fn energy_does_not_drift_in_a_hundred_thousand_steps() {
    for formulation in FORMS {
        check_drift(formulation, 100_000);
    }
}
