//! The bar in tension, against what is known of its errors.

#[path = "../../examples/traction_bar/main.rs"]
#[allow(dead_code)]
mod example;

use crate::twins::{compare_twins, rust_side};

#[test]
fn a_body_force_on_a_layer_and_a_clamp_have_the_errors_of_an_independent_code() {
    let bars = example::run(5, 3..=3, "all", false).unwrap();
    // bond_based, ordinary_state_based and, last, the quadrature; correspondence is not in that code.
    for (form, expected, within) in [(0, 40.5, 1.0), (1, -16.7, 0.5), (3, -0.178, 0.02)] {
        let error = bars.errors[0].1[form];
        assert!((error - expected).abs() < within, "{}: {error}", bars.formulations[form]);
    }
}

#[test]
fn a_traction_and_a_clamp_of_the_axis_alone_are_exact() {
    // One stretch along the whole bar: what is left is the tolerance of the solution, over the smallest stiffness.
    let bars = example::run(5, 2..=3, "bond_associated_quadrature", true).unwrap();
    for (ratio, errors) in &bars.errors {
        assert!(errors[0].abs() < 1e-3, "{ratio}: {} %", errors[0]);
    }
}

#[test]
fn the_tension_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name =
        "traction_bar::the_tension_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let bars = example::run(3, 2..=2, "all", true).unwrap();
        example::write_curves(&format!("{directory}/rust.csv"), &bars).unwrap();
        return;
    }
    compare_twins(name, "traction_bar", &["3", "2", "2", "all", "traction"], 1);
}
