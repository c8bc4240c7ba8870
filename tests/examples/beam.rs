//! The beam, against a beam that bends and shears, and against an elastica.

#[path = "../../examples/beam/main.rs"]
#[allow(dead_code)]
mod example;

use std::f64::consts::FRAC_PI_2;

use crate::twins::{compare_twins, rust_side};

const LAW: &str = "saint_venant_kirchhoff";
const HALF_SPAN: f64 = 8.0;
const BENDING_STIFFNESS: f64 = 1e5 / 12.0;

fn bent(deflection: f64, across: usize) -> [example::Beam; 4] {
    let beams = example::run(deflection, across, 2, LAW, "").unwrap().beams;
    beams.try_into().unwrap_or_else(|_| panic!("four formulations"))
}

#[test]
fn plain_correspondence_loses_the_line_of_its_points_and_the_others_keep_it() {
    let beams = bent(6.4, 9);
    for (beam, (form, _)) in beams.iter().zip(example::FORMS) {
        assert!((beam.solved_to - 6.4).abs() < 1e-12, "{form}: {}", beam.solved_to);
        let apart = beam.out_of_line[1];
        // The elastica has a root mean square curvature of 0.3/mm there, so that smooth bending is 0.008 spacings.
        let kept = if form == "correspondence" { apart > 0.5 } else { apart < 0.012 };
        assert!(kept, "{form}: {apart}");
    }
}

#[test]
fn the_quadrature_bends_as_a_beam_and_nearer_to_it_with_more_points() {
    let [coarse, fine] = [5, 9].map(|across| {
        let [.., quadrature] = bent(3.2, across);
        quadrature
    });
    // Families that a surface cuts average over what lies inside it, where bending strains less.
    let [far, near] = [&coarse, &fine].map(|beam| 1.0 - beam.stiffness);
    assert!(near > 0.0 && near < 0.1 && far > 2.0 * near, "{far} and {near}");
    // That is the same at large deflections: what is left is shear, 1.2 %, and that the axis gets longer.
    for beam in [coarse, fine] {
        let of_elastica = beam.force / elastica(3.2);
        assert!((of_elastica / beam.stiffness - 1.0).abs() < 0.025, "{of_elastica}");
    }
}

/// Force in the middle of a beam on two supports that slide, which resists bending alone.
fn elastica(deflection: f64) -> f64 {
    // Half of it is held in the middle, and its end bears half of the force, upright at any slope.
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..40 {
        let slope = 0.5 * (low + high);
        let (length, height) = half_elastica(slope);
        if height / length * HALF_SPAN < deflection { low = slope } else { high = slope }
    }
    let (length, _) = half_elastica(low);
    2.0 * BENDING_STIFFNESS * (length / HALF_SPAN).powi(2)
}

/// Length and height from an end of this slope to where the slope is 0, for a force of 1 and a stiffness of 1.
fn half_elastica(slope: f64) -> (f64, f64) {
    let step = 1e-3;
    let (mut slope, mut curvature, mut length, mut height) = (slope, 0.0, 0.0, 0.0);
    while slope > 0.0 {
        // By the middle of each step.
        let middle: f64 = slope - 0.5 * step * curvature;
        curvature += step * middle.cos();
        height += step * middle.sin();
        slope = middle - 0.5 * step * curvature;
        length += step;
    }
    (length, height)
}

#[test]
fn the_beam_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "beam::the_beam_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let beams = example::run(1.6, 5, 2, LAW, "").unwrap();
        example::write_curves(&format!("{directory}/rust.csv"), &beams).unwrap();
        return;
    }
    compare_twins(name, "beam", &["1.6", "5", "2", LAW], 2);
}
