//! The bar with a law of its own.

#[path = "../../examples/own_material/main.rs"]
#[allow(dead_code)]
mod example;

use crate::twins::{compare_twins, rust_side};

#[test]
fn the_force_of_a_bar_with_a_law_of_its_own_relaxes_as_its_closed_form() {
    let bar = example::run(20).unwrap();
    // The pull, of u in T, ends with an acceleration of 4 u/T^2 taken off at once: the bar swings by up to twice the
    // force of its inertia, rho A L 2 u/T^2, about E A u/L.
    let (density, length, ramp) = (1.2e-3, 17.0, 0.5_f64);
    let swing = 4.0 * density * length * length / (1000.0 * ramp * ramp);
    assert!(swing < 0.006 && bar.worst < swing, "{}, swing {swing}", bar.worst);
    // (1 + c)/(1 + c exp(-3)), c = ((1 - exp(-1/2))/(1/2))^2.
    let relaxed = bar.forces[60] / bar.forces[240];
    let left = (2.0 * (1.0 - (-0.5_f64).exp())).powi(2);
    let closed = (1.0 + left) / (1.0 + left * (-3.0_f64).exp());
    assert!((relaxed / closed - 1.0).abs() < swing, "{relaxed}, closed form {closed}");
    // Between the innermost points of the grips, 17 mm apart; families of grips reach beyond them.
    let elastic = 1000.0 * 16.0 * 0.16 / length;
    assert!((bar.bearing / elastic - 1.0).abs() < 0.02, "{} N, {elastic}", bar.bearing);
    // Held for three tau, Q keeps exp(-6) of its energy, and the motion less: what was put in and is neither in the
    // elastic springs, E A u^2/2L, nor given back is in the dashpots.
    let energy = &bar.energy;
    let springs = 0.5 * bar.bearing * 0.16;
    assert!((energy.elastic / springs - 1.0).abs() < 0.01, "{} mJ, {springs}", energy.elastic);
    let taken = energy.external_work - energy.elastic;
    assert!((-energy.closure_error / taken - 1.0).abs() < 1e-3, "{energy:?}");
}

#[test]
fn the_own_material_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "own_material::the_own_material_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let outcome = example::run(10).unwrap();
        example::write_curve(&format!("{directory}/rust.csv"), &outcome).unwrap();
        return;
    }
    compare_twins(name, "own_material", &["10"], 200);
}
