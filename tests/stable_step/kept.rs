//! What velocity Verlet keeps at the stable step, and loses above it.

use perion::{Field, Simulation};

use crate::body::{CONSTANT, Case, INVERSE, SPLINE, VARIATIONAL, noise, some_bonds};

/// What Verlet keeps in place of the energy: KE + SE - dt^2/8 sum V |b|^2/rho, for points of unit volume and density.
fn conserved(simulation: &mut Simulation, time_step: f64) -> f64 {
    simulation.evaluate().unwrap();
    let energy = simulation.energy().unwrap();
    let force = simulation.get(Field::InternalForce).unwrap();
    let squares: f64 = force.iter().map(|b| b * b).sum();
    energy.kinetic + energy.elastic - time_step * time_step / 8.0 * squares
}

fn let_go(simulation: &mut Simulation) -> f64 {
    let count = simulation.points().coordinates().len();
    let displacement: Vec<f64> = noise(count, 5).iter().map(|u| 2e-6 * u).collect();
    simulation.set(Field::Displacement, &displacement).unwrap();
    simulation.set(Field::Velocity, &vec![0.0; count]).unwrap();
    simulation.stable_time_step().unwrap()
}

/// Over 2000 steps at the stable step within 1 %; at 1.25 times it beyond 10 times.
fn is_kept(case: Case, simulation: &mut Simulation, what: &str) {
    let step = let_go(simulation);
    assert!(simulation.health().unwrap().stable_step_is_guaranteed);
    let start = conserved(simulation, step);
    let mut worst = 0.0_f64;
    for _ in 0..8 {
        simulation.step(step, 250).unwrap();
        worst = worst.max((conserved(simulation, step) / start - 1.0).abs());
    }
    assert!((simulation.health().unwrap().time_step_ratio - 1.0).abs() < 1e-14);
    let step = 1.25 * let_go(simulation);
    let start = conserved(simulation, step).abs();
    let failed = simulation.step(step, 300).is_err();
    let grown = (conserved(simulation, step) / start).abs();
    eprintln!("{} {:?} {what}: {worst:.1e}, {grown:.1e}", case.formulation, case.texts);
    simulation
        .set(Field::Displacement, &vec![0.0; simulation.points().coordinates().len()])
        .unwrap();
    assert!(worst < 0.01, "{case:?} {what}: {worst:e}");
    assert!(failed || grown.is_nan() || grown > 10.0, "{case:?} {what}: {grown:e}");
}

#[test]
fn of_blocks_whole_and_damaged() {
    // What flows would keep nothing, once it has blown up.
    for case in VARIATIONAL.into_iter().filter(|case| !case.flows()) {
        let counts = if case.formulation == "bond_associated" { [4, 3, 3] } else { [6, 5, 4] };
        let mut block = case.body(counts, 3.015);
        is_kept(case, &mut block, "whole");
        block.break_bonds(&some_bonds(&block, 0.3, 3)).unwrap();
        is_kept(case, &mut block, "30 % of the bonds broken");
    }
}

#[test]
fn of_thin_plates() {
    let few = |case: &Case| case.texts == SPLINE || case.formulation == "bond_based";
    for case in VARIATIONAL.into_iter().filter(few) {
        for layers in 1..4 {
            let mut plate = case.body([7, 6, layers], 3.015);
            is_kept(case, &mut plate, &format!("{layers} layers"));
        }
    }
}

/// `make test-long`: each formulation with each influence function, as a block, damaged, and as plates.
#[test]
#[ignore = "takes minutes"]
fn of_every_kernel() {
    const CONICAL: &[(&str, &str)] = &[("influence", "conical")];
    for case in VARIATIONAL.into_iter().filter(|case| !case.flows()) {
        for texts in [CONSTANT, INVERSE, CONICAL, SPLINE] {
            let takes_none = ["bond_based", "madenci_oterkus"].contains(&case.formulation);
            if takes_none && texts != CONSTANT {
                continue;
            }
            let case = if takes_none { case } else { Case { texts, ..case } };
            let counts = if case.formulation == "bond_associated" { [4, 3, 3] } else { [6, 5, 4] };
            let mut block = case.body(counts, 3.015);
            is_kept(case, &mut block, "whole");
            block.break_bonds(&some_bonds(&block, 0.3, 3)).unwrap();
            is_kept(case, &mut block, "30 % of the bonds broken");
            for layers in 1..4 {
                let counts = if case.formulation == "bond_associated" { 4 } else { 7 };
                let mut plate = case.body([counts, counts - 1, layers], 3.015);
                is_kept(case, &mut plate, &format!("{layers} layers"));
            }
        }
    }
}
