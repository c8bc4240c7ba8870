//! The boundary tension test of [P] 5.3 at full size: the crack branches, and the energy balance holds.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

use perion::{Energy, Field, Model, Points, Quantity, Simulation};

const SPACING: f64 = 0.5e-3;
const LENGTH: f64 = 0.1;
const HEIGHT: f64 = 0.04;
const DEPTH: f64 = 0.004;

fn plate() -> Simulation {
    let (lower, upper) = ([0.0, -HEIGHT / 2.0, 0.0], [LENGTH, HEIGHT / 2.0, DEPTH]);
    let mut points = Points::block(3, &lower, &upper, SPACING).unwrap();
    points.add_set_box("top", &[0.0, HEIGHT / 2.0 - SPACING, 0.0], &upper).unwrap();
    points.add_set_box("bottom", &lower, &[LENGTH, SPACING - HEIGHT / 2.0, DEPTH]).unwrap();
    assert_eq!(points.count(), 200 * 80 * 8);
    assert_eq!(points.set_size("top").unwrap(), 200 * 8);
    let mut glass = Model::new("bond_based").unwrap();
    for (key, value) in [
        ("youngs_modulus", 32e9),
        ("density", 2440.0),
        ("horizon", 3.015 * SPACING),
        ("critical_energy_release_rate", 0.75),
    ] {
        glass.set(key, value).unwrap();
    }
    let mut plate = Simulation::new(&points, &glass).unwrap();
    let crack =
        [[0.0, 0.0, 0.0], [LENGTH / 2.0, 0.0, 0.0], [LENGTH / 2.0, 0.0, DEPTH], [0.0, 0.0, DEPTH]];
    plate.break_crossing(crack.as_flattened()).unwrap();
    for (set, force) in [("top", 2e9), ("bottom", -2e9)] {
        plate.prescribe(set, Quantity::BodyForce, 1, force).unwrap();
        plate.forbid_failure(set).unwrap();
    }
    plate
}

/// Heights of the cracks at a column of points: middles of the runs of damaged points.
fn cracks_at(damage: &[f64], column: usize) -> Vec<f64> {
    // The layer in the middle of the thickness; x runs fastest, then y.
    let at = |row: usize| damage[(4 * 80 + row) * 200 + column];
    let cracked: Vec<usize> = (0..80).filter(|&row| at(row) > 0.35).collect();
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for row in cracked {
        match runs.last_mut() {
            Some(run) if run[run.len() - 1] + 1 == row => run.push(row),
            _ => runs.push(vec![row]),
        }
    }
    let height = |row: usize| (row as f64 + 0.5) * SPACING - HEIGHT / 2.0;
    runs.iter().map(|run| 0.5 * (height(run[0]) + height(run[run.len() - 1]))).collect()
}

#[test]
fn the_crack_branches_into_two_symmetric_arms_and_no_energy_comes_out_of_nothing() {
    let mut plate = plate();
    let end = 50e-6;
    // Half of it: bonds stretch by much before they break.
    let steps = (end / (0.5 * plate.stable_time_step().unwrap())).ceil() as u64;
    let mut history: Vec<Energy> = Vec::new();
    let chunk = 4;
    let mut done = 0;
    while done < steps {
        let now = chunk.min(steps - done);
        plate.step(end / steps as f64, now).unwrap();
        done += now;
        history.push(plate.energy().unwrap());
    }
    let last = history[history.len() - 1];
    for energy in &history {
        if energy.external_work > 0.01 * last.external_work {
            let ratio = (energy.kinetic + energy.elastic) / energy.external_work;
            assert!(ratio <= 1.001, "{ratio}");
            let closure = energy.closure_error / energy.external_work;
            assert!(closure.abs() < 0.01, "{closure}");
        }
    }
    // The surface of a crack and two arms of 40 mm together, with G_c, is a fair share of this.
    assert!(last.dissipated > 0.75 * DEPTH * 0.06, "{}", last.dissipated);

    let damage = plate.get(Field::Damage).unwrap();
    assert_eq!(cracks_at(&damage, 60).len(), 1, "one crack before the branching");
    let mut apart = 0.0;
    for column in (145..170).step_by(5) {
        let arms = cracks_at(&damage, column);
        assert_eq!(arms.len(), 2, "column {column}: {arms:?}");
        assert!((arms[0] + arms[1]).abs() <= 2.0 * SPACING, "column {column}: {arms:?}");
        assert!(arms[1] - arms[0] > apart, "the arms part: column {column}: {arms:?}");
        apart = arms[1] - arms[0];
    }
    let health = plate.health().unwrap();
    assert!(health.broken_bonds > 0 && health.isolated.count == 0);
    // No bond of a layer that may not fail has broken.
    let protected: Vec<bool> = {
        let mut flags = vec![false; 128_000];
        for set in ["top", "bottom"] {
            plate.points().set(set).unwrap().iter().for_each(|&point| flags[point] = true);
        }
        flags
    };
    plate
        .for_each_bond(|pair, _, integrity| {
            assert!(integrity == 1.0 || !pair.iter().any(|&point| protected[point]));
        })
        .unwrap();
}
