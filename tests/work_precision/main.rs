//! A small form of `make work-precision`: errors of problems with known answers, and how they fall with resolution.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

#[path = "../../benches/precision/mod.rs"]
mod precision;
mod verlet;

use precision::{METHODS, Method, PROBLEMS, Resolution};

fn method(name: &str) -> Method {
    *METHODS.iter().find(|method| method.name() == name).unwrap()
}

/// Errors at some resolutions, with a horizon of so many spacings.
fn errors<const N: usize>(problem: &str, name: &str, ratio: usize, across: [usize; N]) -> [f64; N] {
    let known = PROBLEMS.iter().find(|known| known.name == problem).unwrap();
    let errors = across.map(|across| {
        let outcome = known.run(method(name), Resolution { across, ratio }).unwrap();
        assert!(outcome.evaluations > 1 && outcome.bytes > 0, "{problem}, {name}");
        outcome.error
    });
    println!("{problem}, {name}, {ratio}: {across:?} points across: {errors:?}");
    errors
}

/// Orders at which errors fall between two resolutions.
fn order(errors: [f64; 2], across: [usize; 2]) -> f64 {
    (errors[0] / errors[1]).ln() / (across[1] as f64 / across[0] as f64).ln()
}

/// The form of the gradient is exact in affine motion, whatever the horizon: errors are of second order, and more where
/// horizons are still wide.
fn check_order(problem: &str, name: &str, across: [usize; 2]) {
    let order = order(errors(problem, name, 2, across), across);
    println!("of order {order:.2}");
    assert!(order > 1.9, "{problem}, {name}: {order}");
}

#[test]
fn errors_of_correspondence_fall_with_the_square_of_the_spacing() {
    for name in ["correspondence", "bond_associated_quadrature"] {
        check_order("smooth_dynamic", name, [6, 9]);
        check_order("plane_wave", name, [6, 12]);
    }
    check_order("smooth_static", "bond_associated_quadrature", [6, 9]);
}

#[test]
fn errors_stay_below_what_is_known() {
    for (problem, name, ratio, across, allowed) in [
        ("traction_bar", "bond_associated_quadrature", 3, 5, 0.001),
        ("traction_bar", "correspondence_silling", 3, 5, 0.01),
        ("traction_bar", "bond_based + energy", 3, 5, 0.07),
        ("traction_bar", "bond_based + stiffness_tensor", 3, 5, 0.02),
        ("hyperelastic_bar", "bond_associated_quadrature", 2, 5, 1e-8),
        ("hyperelastic_bar", "correspondence", 2, 3, 1e-8),
        ("smooth_static", "bond_based", 2, 6, 0.05),
        ("smooth_static", "ordinary_state_based", 2, 6, 0.035),
        ("smooth_dynamic", "bond_based", 2, 6, 0.04),
        ("smooth_dynamic", "ordinary_state_based", 2, 6, 0.025),
    ] {
        let [error] = errors(problem, name, ratio, [across]);
        assert!(error < allowed, "{problem}, {name}: {error}");
    }
}
