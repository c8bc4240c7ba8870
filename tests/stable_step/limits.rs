//! The stable step lies in 0.9 to 1 of the true limit.

use perion::{AdvanceOptions, Error, Field, Simulation};

use crate::body::{
    CONSTANT, Case, INVERSE, SPLINE, VARIATIONAL, WITHOUT_POTENTIAL, case, conventional, limit,
    some_bonds,
};

/// Case and true limit over the least of [P 3.58], at horizons of 2.01 and 3.015 spacings.
const LATTICE: [(Case, [f64; 2]); 9] = [
    (case("bond_based", &[], &[]), [1.903, 2.079]),
    (case("ordinary_state_based", INVERSE, &[]), [1.623, 1.792]),
    (case("correspondence", CONSTANT, &[]), [2.351, 2.391]),
    (case("correspondence_wan", CONSTANT, &[]), [1.249, 1.350]),
    (case("correspondence_wan", SPLINE, &[]), [0.807, 0.838]),
    (case("correspondence_silling", CONSTANT, &[("silling_coefficient", 1.0)]), [1.104, 1.156]),
    (case("correspondence_silling", CONSTANT, &[("silling_coefficient", 100.0)]), [0.1107, 0.1165]),
    (case("bond_associated_quadrature", CONSTANT, &[]), [2.222, 2.329]),
    (case("bond_associated_quadrature", SPLINE, &[]), [1.609, 1.463]),
];

#[test]
fn of_a_free_lattice() {
    for (case, ratios) in LATTICE {
        for (horizon, expected) in [2.01, 3.015].into_iter().zip(ratios) {
            let mut simulation = case.body([9; 3], horizon);
            let limit = limit(&mut simulation, 80);
            let ratio = limit / conventional(&simulation);
            let share = simulation.stable_time_step().unwrap() / limit;
            eprintln!(
                "{} {:?} {horizon}: {ratio:.4} of {expected}, step {share:.4}",
                case.formulation, case.texts
            );
            assert!((ratio / expected - 1.0).abs() < 0.02, "{case:?} {horizon}: {ratio}");
            assert!((0.9..=1.0).contains(&share), "{case:?} {horizon}: {share}");
        }
    }
}

/// The share of the limit that the stable step is, which must lie in 0.9 to 1.
fn share(case: Case, simulation: &mut Simulation, what: &str) -> f64 {
    let step = simulation.stable_time_step().unwrap();
    let share = step / limit(simulation, 80);
    eprintln!("{} {:?} {what}: {share:.4}", case.formulation, case.texts);
    assert!((0.9..=1.0).contains(&share), "{case:?} {what}: {share}");
    share
}

#[test]
fn of_thin_plates() {
    let few = |case: &Case| case.formulation != "bond_associated";
    for case in VARIATIONAL.into_iter().filter(few) {
        for layers in 1..4 {
            let mut plate = case.body([12, 9, layers], 3.015);
            share(case, &mut plate, &format!("{layers} layers"));
        }
    }
    // 0.68 was stated for this plate; so it is at another of Poisson's ratios than the 1/4 that was said.
    for (poissons_ratio, expected) in
        [(&[("poissons_ratio", 0.25)], 0.717), (&[("poissons_ratio", 0.2)], 0.684)]
    {
        let case = case("bond_associated_quadrature", SPLINE, poissons_ratio);
        let mut plate = case.body([40, 16, 2], 3.015);
        let ratio = limit(&mut plate, 80) / conventional(&plate);
        assert!((ratio / expected - 1.0).abs() < 0.005, "{poissons_ratio:?} {ratio}");
        share(case, &mut plate, "40 x 16 x 2");
    }
}

#[test]
fn of_damaged_and_strained_blocks() {
    for case in VARIATIONAL {
        let counts = case.block();
        let mut block = case.body(counts, 3.015);
        share(case, &mut block, "whole");
        for (number, part) in [0.02, 0.3, 0.6].into_iter().enumerate() {
            block.break_bonds(&some_bonds(&block, part, number as u64 + 1)).unwrap();
            share(case, &mut block, &format!("{part} of the bonds broken"));
        }
        let mut block = case.body(counts, 3.015);
        let strained = strained(&block, 0.15);
        block.set(Field::Displacement, &strained).unwrap();
        if case.flows() {
            unloaded(&mut block, &strained);
        }
        share(case, &mut block, "strained");
    }
}

/// Takes the current state, which may have flowed, as committed, and unloads from it by a little.
fn unloaded(block: &mut Simulation, displacement: &[f64]) {
    block.commit(0.0).unwrap();
    let back: Vec<f64> = displacement.iter().map(|u| 0.999 * u).collect();
    block.set(Field::Displacement, &back).unwrap();
}

/// Strains, shears and bends a body.
fn strained(block: &Simulation, size: f64) -> Vec<f64> {
    let mut strained = block.get(Field::ReferencePosition).unwrap();
    for point in strained.chunks_exact_mut(3) {
        let [x, y, z] = [point[0], point[1], point[2]];
        let moved = [x + 0.7 * y, 0.03 * x * z - 0.3 * y, 0.7 * z];
        point.copy_from_slice(&moved.map(|u| size * u));
    }
    strained
}

#[test]
fn of_forces_without_a_potential() {
    for case in WITHOUT_POTENTIAL {
        let mut block = case.body(case.block(), 3.015);
        share(case, &mut block, "at rest");
        let strained = strained(&block, 0.07);
        block.set(Field::Displacement, &strained).unwrap();
        if case.flows() {
            unloaded(&mut block, &strained);
        }
        share(case, &mut block, "strained");
        assert!(!block.health().unwrap().stable_step_is_guaranteed, "{case:?}");
    }
}

#[test]
fn of_strong_forms_there_is_none() {
    for formulation in ["correspondence", "total_lagrangian", "updated_lagrangian"] {
        let mut block = case(formulation, &[("divergence", "strong")], &[]).body([7, 6, 5], 3.015);
        let error = block.stable_time_step().unwrap_err();
        assert!(matches!(error, Error::Numeric(_)), "{error}");
        assert!(error.to_string().contains("no time step is stable"), "{error}");
        // Steps can be made all the same, compared with what the size of the eigenvalue says.
        let known = block.health().unwrap().stable_time_step;
        assert!(known > 0.0 && known.is_finite());
        block.step(0.1 * known, 3).unwrap();
        assert!(block.advance(1.0, &AdvanceOptions::default()).is_err());
    }
}
