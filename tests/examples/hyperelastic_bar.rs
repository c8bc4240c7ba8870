//! The hyperelastic bar, against the exact stretch.

#[path = "../../examples/hyperelastic_bar/main.rs"]
#[allow(dead_code)]
mod example;

use crate::twins::{compare_twins, rust_side};

fn check(traction: f64, exact: f64, within: f64) {
    let bars = example::run(traction, 5, 1, "").unwrap();
    let end = &bars.loads[1];
    assert!((end.exact - exact).abs() < 5e-5, "{}", end.exact);
    for top in end.tops {
        assert!((top / exact - 1.0).abs() < within, "{top}, not {exact}");
    }
}

#[test]
fn the_weak_forms_stretch_as_the_law_says() {
    // Both ends share their forces over the families they cut: that is what a percent is for.
    check(0.590575, 0.01, 0.01);
}

#[test]
fn the_traction_that_the_paper_names_belongs_to_a_stretch_of_a_fifth() {
    check(14.0, 0.1857, 0.01);
}

#[test]
fn the_hyperelastic_bar_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "hyperelastic_bar::the_hyperelastic_bar_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let bars = example::run(0.590575, 3, 1, "").unwrap();
        example::write_curves(&format!("{directory}/rust.csv"), &bars).unwrap();
        return;
    }
    compare_twins(name, "hyperelastic_bar", &["0.590575", "3", "1"], 2);
}
