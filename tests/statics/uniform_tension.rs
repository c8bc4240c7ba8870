//! A bar of three points across under 2 MN, three clamped layers outside its length: E = 200 GPa, nu = 1/4,
//! 1 x 0.1 x 0.1, so that its length changes by 1e-3.

use crate::bars::mean_along;
use perion::{Model, Points, Quantity, RelaxOptions, Simulation, SolveOptions};

const SPACING: f64 = 1.0 / 30.0;
const FORCE: f64 = 2e6;

fn bar(formulation: &str, choices: &[(&str, &str)]) -> Simulation {
    let clamp = -3.0 * SPACING;
    let mut points = Points::block(3, &[clamp, 0.0, 0.0], &[1.0, 0.1, 0.1], SPACING).unwrap();
    points.add_set_box("clamp", &[-1.0, 0.0, 0.0], &[0.0, 0.1, 0.1]).unwrap();
    points.add_set_box("end", &[1.0 - SPACING, 0.0, 0.0], &[1.0, 0.1, 0.1]).unwrap();
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in [
        ("density", 7850.0),
        ("youngs_modulus", 200e9),
        ("poissons_ratio", 0.25),
        ("horizon", 3.015 * SPACING),
    ] {
        model.set(key, value).unwrap();
    }
    for (key, choice) in choices {
        model.choose(key, choice).unwrap();
    }
    let mut bar = Simulation::new(&points, &model).unwrap();
    for axis in 0..3 {
        bar.prescribe("clamp", Quantity::Displacement, axis, 0.0).unwrap();
    }
    let volume = 9.0 * SPACING.powi(3);
    bar.prescribe("end", Quantity::BodyForce, 0, FORCE / volume).unwrap();
    bar
}

/// In percent; that `relax` and `solve` agree is looked at on the way.
fn error(formulation: &str, choices: &[(&str, &str)]) -> f64 {
    let (mut solved, mut relaxed) = (bar(formulation, choices), bar(formulation, choices));
    solved.solve(&SolveOptions::default()).unwrap();
    relaxed.relax(&RelaxOptions { tolerance: 1e-8, ..RelaxOptions::default() }).unwrap();
    let [grown, other] = [&solved, &relaxed].map(|bar| mean_along(bar, "end"));
    assert!((other / grown - 1.0).abs() < 1e-6, "{formulation}: {grown} solved, {other} relaxed");
    let error = 100.0 * (grown / 1e-3 - 1.0);
    println!("{formulation} {choices:?}: {error:.3} %");
    error
}

#[test]
fn length_changes_are_within_what_is_known_of_the_forms() {
    let spline = [("influence", "cubic_spline")];
    assert!(error("bond_associated_quadrature", &spline).abs() < 1.0);
    let inverse = ("influence", "inverse");
    // -12.55 of it are those of a bar without ends.
    let energy = ("surface_correction", "energy");
    assert!(error("bond_based", &[energy]).abs() < 13.1);
    error("ordinary_state_based", &[inverse, energy]);
    let tensor = ("surface_correction", "stiffness_tensor");
    for (formulation, choices, expected) in [
        ("bond_based", &[tensor][..], -1.103),
        ("ordinary_state_based", &[inverse, tensor], -2.579),
    ] {
        let error = error(formulation, choices);
        // Of the linear bar, by an independent code; strains are a thousandth.
        assert!((error - expected).abs() < 0.1, "{formulation}: {error}, not {expected}");
    }
}
