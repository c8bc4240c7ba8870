//! The patch of points without order, against an independent code on the same points.

#[path = "../../examples/patch/main.rs"]
#[allow(dead_code)]
mod example;

use crate::common::in_crate;
use crate::twins::{compare_twins, rust_side};

fn cloud() -> String {
    in_crate("examples/patch/points.txt").to_str().unwrap().to_owned()
}

#[test]
fn plain_correspondence_falls_into_disorder_and_the_others_swing_on() {
    let patch = example::run(&cloud(), 388, "").unwrap();
    let [plain, penalty, quadrature] = &patch.swings[..] else { panic!("three formulations") };
    // That code has 0.476, 0.027 and 0.078 there.
    assert!(plain.contractions[0] > 0.3, "{}", plain.contractions[0]);
    for (swing, most) in [(penalty, 0.06), (quadrature, 0.15)] {
        assert_eq!(swing.contractions.len(), 12);
        let largest = swing.contractions.iter().copied().fold(0.0, f64::max);
        assert!(largest < most, "{largest}");
    }
    for swing in &patch.swings {
        assert!(swing.drift < 2e-3, "{}", swing.drift);
    }
}

#[test]
fn the_patch_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "patch::the_patch_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let patch = example::run(&cloud(), 30, "").unwrap();
        example::write_curves(&format!("{directory}/rust.csv"), &patch).unwrap();
        return;
    }
    compare_twins(name, "patch", &[&cloud(), "30"], 30);
}
