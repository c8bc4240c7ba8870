//! The field's usual estimate of the time step. [P 3.58]

use crate::data::{Reference, assert_near};
use perion::{Field, Model, Simulation};

#[test]
fn time_step_estimates_are_those_of_the_reference() {
    let reference = Reference::load("timestep");
    let mut model = Model::new("bond_based").unwrap();
    for key in ["density", "horizon", "youngs_modulus", "poissons_ratio"] {
        model.set(key, reference.number(key)).unwrap();
    }
    let body = Simulation::new(&reference.points(), &model).unwrap();
    let estimates = body.get(Field::TimeStepEstimate).unwrap();
    // Sums of up to 46 positive terms, with a few roundings each, and a root that halves their error;
    // each value by itself.
    for (found, expected) in estimates.iter().zip(reference.numbers("time_step")) {
        assert_near("time step", *found, expected, 1e-14);
    }
    let smallest = estimates.into_iter().fold(f64::INFINITY, f64::min);
    assert_near("smallest", smallest, reference.number("smallest_time_step"), 1e-14);
}
