//! The wave in a bar.

#[path = "../../examples/wave/main.rs"]
#[allow(dead_code)]
mod example;

use crate::twins::{compare_twins, rust_side};

#[test]
fn the_front_runs_at_the_speed_of_a_bar_less_what_its_lateral_inertia_costs() {
    for rise in [40.0, 60.0] {
        let wave = example::run(120, rise).unwrap();
        let deviation = wave.speed / wave.expected - 1.0;
        assert!(deviation.abs() < 0.03, "{deviation}");
        // Love: omega = c k (1 - (nu r k)^2/2), with r^2 = width^2/6 for a square. That takes a share of
        // (nu r)^2/2 v'''/v' off the speed of a place in a front, -8/rise^2 in the middle of this one. Love has
        // one mode, and the first station is two widths from the blow.
        let inertia = -0.5 * 0.25_f64.powi(2) * (20.0 * 20.0 / 6.0) * 8.0 / (rise * rise);
        assert!((deviation - inertia).abs() < 0.005, "{deviation}, Love {inertia}");

        // The free end doubles the velocity; lateral inertia lets it swing about that.
        let last = &wave.velocities[wave.velocities.len() - 1];
        assert!((last[119] - 2.0).abs() < 0.2, "{}", last[119]);
        let energy = wave.bar.energy().unwrap();
        // Nothing breaks: what is left is the swing of velocity Verlet.
        let closure = energy.closure_error / energy.external_work;
        assert!(closure.abs() < 1e-3, "{closure}");
    }
}

#[test]
fn the_wave_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "wave::the_wave_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let wave = example::run(50, 40.0).unwrap();
        example::write_matrix(&format!("{directory}/rust.csv"), &wave).unwrap();
        return;
    }
    compare_twins(name, "wave", &["50"], 200);
}
