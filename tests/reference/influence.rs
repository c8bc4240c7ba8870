//! Influence functions, number by number.

use crate::data::{Reference, assert_near};
use perion::Influence;

/// Each value by itself: near the horizon it is (1 - q)^3 of a q rounded to 1e-16, which at q = 0.95
/// costs 3 x 1e-16/0.05 for the file and as much again for the reference.
const TOLERANCE: f64 = 3e-14;

#[test]
fn influence_functions_are_those_of_the_reference() {
    let reference = Reference::load("kernels");
    let horizon = reference.number("horizon");
    for (influence, dimension, key) in [
        (Influence::Inverse, 3, "inverse"),
        (Influence::Inverse, 2, "inverse"),
        (Influence::CubicSpline, 3, "cubic_spline_3d"),
        (Influence::CubicSpline, 2, "cubic_spline_2d"),
    ] {
        let shares = reference.numbers("length_over_horizon");
        for (share, expected) in shares.into_iter().zip(reference.numbers(key)) {
            // No bond is longer than the horizon; only the spline has a value there.
            if share <= 1.0 || influence == Influence::CubicSpline {
                let found = influence.value(dimension, share * horizon, horizon);
                assert_near(&format!("{key} at {share}"), found, expected, TOLERANCE);
            }
        }
    }
}

#[test]
fn the_constant_and_the_conical_function_are_what_their_names_say() {
    let reference = Reference::load("kernels");
    let horizon = reference.number("horizon");
    let shares = reference.numbers("length_over_horizon");
    for share in shares.into_iter().filter(|&share| share <= 1.0) {
        for dimension in [2, 3] {
            let value = |influence: Influence| influence.value(dimension, share * horizon, horizon);
            assert_eq!(value(Influence::Constant), 1.0);
            // The horizon is a power of two, so that length over horizon is exact.
            assert_eq!(value(Influence::Conical), 1.0 - share);
        }
    }
}
