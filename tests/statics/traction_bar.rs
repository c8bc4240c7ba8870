//! The traction bar of [P] 5.1: errors of the length change that an independent code has, and what they cost.

use std::time::Instant;

use crate::bars::{TractionBar, mean_along};
use perion::{Preconditioning, RelaxOptions, Simulation, SolveOptions};

fn bar(formulation: &str, across: usize, ratio: usize) -> Simulation {
    let scene = TractionBar { across, ratio };
    scene.simulation(&scene.usual_model(formulation)).unwrap()
}

/// Error in percent, and forces evaluated.
fn solved(formulation: &str, (across, ratio): (usize, usize), by: Preconditioning) -> (f64, u64) {
    let mut bar = bar(formulation, across, ratio);
    let options = SolveOptions { preconditioning: by, ..SolveOptions::default() };
    let start = Instant::now();
    let report = bar.solve(&options).unwrap();
    let (seconds, error) = (start.elapsed().as_secs_f64(), TractionBar::error(&bar, formulation));
    let forces = report.evaluations;
    println!(
        "{formulation} ({across},{ratio}) {by:?}: {error:.4} %, {forces} forces, {seconds:.2} s"
    );
    (error, forces)
}

fn check(formulation: &str, of: (usize, usize), expected: f64, within: f64) {
    let (error, _) = solved(formulation, of, Preconditioning::Global);
    assert!((error - expected).abs() <= within, "{formulation} {of:?}: {error}, not {expected}");
}

const BAQP: &str = "bond_associated_quadrature";

#[test]
fn the_errors_of_five_points_across_are_the_known_ones() {
    check(BAQP, (5, 3), -0.178, 0.02);
    check(BAQP, (5, 2), -0.468, 0.02);
    check("bond_based", (5, 3), 40.5, 1.0);
    check("ordinary_state_based", (5, 3), -16.7, 0.5);
}

#[test]
#[ignore = "takes minutes: make test-long"]
fn the_errors_of_finer_bars_and_larger_families_are_the_known_ones() {
    check(BAQP, (5, 4), 0.376, 0.02);
    check(BAQP, (5, 7), 2.72, 0.1);
    check("bond_based", (5, 7), 210.0, 5.0);
    check("bond_based", (10, 3), 18.8, 0.5);
}

#[test]
fn ten_points_across_take_few_forces() {
    let (error, forces) = solved(BAQP, (10, 3), Preconditioning::Global);
    assert!((error + 0.199).abs() <= 0.02, "{error}");
    assert!(forces <= 120, "{forces} forces with the global preconditioner");
}

#[test]
#[ignore = "takes a minute: make test-long"]
fn ten_points_across_take_some_hundred_forces_with_blocks_alone() {
    let (error, forces) = solved(BAQP, (10, 3), Preconditioning::BlockDiagonal);
    assert!((error + 0.199).abs() <= 0.02, "{error}");
    assert!(forces <= 500, "{forces} forces with the blocks of the points");
}

#[test]
#[ignore = "takes a minute: make test-long"]
fn twenty_points_across_are_solved_within_a_minute() {
    let start = Instant::now();
    solved(BAQP, (20, 3), Preconditioning::Global);
    assert!(start.elapsed().as_secs_f64() < 60.0);
}

/// Error in percent of a bar whose families have the stiffness tensor of the material.
fn corrected(formulation: &str, (across, ratio): (usize, usize)) -> f64 {
    let scene = TractionBar { across, ratio };
    let mut model = scene.usual_model(formulation);
    model.choose("surface_correction", "stiffness_tensor").unwrap();
    let mut bar = scene.simulation(&model).unwrap();
    let report = bar.solve(&SolveOptions::default()).unwrap();
    let error = TractionBar::error(&bar, formulation);
    let forces = report.evaluations;
    println!("{formulation} ({across},{ratio}), corrected: {error:.3} %, {forces} forces");
    error
}

#[test]
fn bars_with_corrected_surfaces_are_within_two_percent() {
    for formulation in ["bond_based", "ordinary_state_based"] {
        let error = corrected(formulation, (5, 3));
        assert!(error.abs() < 2.0, "{formulation}: {error}");
    }
}

#[test]
#[ignore = "takes a minute: make test-long"]
fn finer_bars_with_corrected_surfaces_are_within_two_percent() {
    for formulation in ["bond_based", "ordinary_state_based"] {
        let error = corrected(formulation, (10, 3));
        assert!(error.abs() < 2.0, "{formulation}: {error}");
    }
}

#[test]
fn relaxed_and_solved_bars_agree() {
    for formulation in ["bond_based", "ordinary_state_based", BAQP] {
        let (mut relaxed, mut solved) = (bar(formulation, 5, 2), bar(formulation, 5, 2));
        solved.solve(&SolveOptions::default()).unwrap();
        let options = RelaxOptions { tolerance: 1e-8, ..RelaxOptions::default() };
        let report = relaxed.relax(&options).unwrap();
        let [by_motion, by_newton] = [&relaxed, &solved].map(|bar| mean_along(bar, "end"));
        println!(
            "{formulation}: {} steps of relaxation, {} forces",
            report.iterations, report.evaluations
        );
        let apart = (by_motion / by_newton - 1.0).abs();
        assert!(apart < 1e-6, "{formulation}: {by_motion} and {by_newton}");
    }
}
