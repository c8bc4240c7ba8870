//! The traction bar of [P] 5.1.

use std::time::Instant;

use crate::bars::{FORCE, LENGTH, MODULUS, TractionBar, mean_along, svk_strain};
use perion::{Preconditioning, SolveOptions};

/// Error of the length change in percent, and forces evaluated.
fn error(formulation: &str, influence: Option<&str>, across: usize, ratio: usize, preconditioning: Preconditioning) -> (f64, u64) {
    let scene = TractionBar { across, ratio };
    let mut model = scene.model(formulation);
    if let Some(influence) = influence {
        model.choose("influence", influence).unwrap();
    }
    let mut bar = scene.simulation(&model);
    let start = Instant::now();
    let options = SolveOptions { preconditioning, ..SolveOptions::default() };
    let report = bar.solve(&options);
    let seconds = start.elapsed().as_secs_f64();
    let report = match report {
        Ok(report) => report,
        Err(error) => {
            println!("{formulation} ({across},{ratio}): {error}");
            return (f64::NAN, 0);
        }
    };
    let stress = FORCE / (0.01 * LENGTH * LENGTH);
    let small = matches!(formulation, "bond_based" | "ordinary_state_based");
    let exact = LENGTH * if small { stress / MODULUS } else { svk_strain(stress, MODULUS) };
    let error = 100.0 * (mean_along(&bar, "end") / exact - 1.0);
    println!(
        "{formulation} ({across},{ratio}) {preconditioning:?}: {error:.4} %, {} forces, {seconds:.2} s, {} steps, {} cuts, {:?}",
        report.evaluations, report.steps, report.cuts, report.residuals
    );
    (error, report.evaluations)
}

#[test]
fn scratch() {
    use Preconditioning::{BlockDiagonal, Global};
    for choice in [BlockDiagonal, Global] {
        error("bond_based", None, 5, 3, choice);
        error("ordinary_state_based", Some("inverse"), 5, 3, choice);
        error("correspondence", Some("inverse"), 5, 3, choice);
        error("bond_associated_quadrature", Some("cubic_spline"), 5, 3, choice);
        error("bond_associated_quadrature", Some("cubic_spline"), 10, 3, choice);
    }
}
