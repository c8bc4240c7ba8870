//! Messages: what the library tells the host's log, and that it is silent otherwise.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

use std::sync::{Arc, Mutex};

use perion::{LogLevel, Model, Points, Simulation};

/// A bar of ten points in 3D, and what it says.
fn bar(coordinates: &[f64]) -> (Simulation, Arc<Mutex<Vec<String>>>) {
    let points = Points::new(3, coordinates, &vec![1.0; coordinates.len() / 3]).unwrap();
    let mut model = Model::new("bond_based").unwrap();
    for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 2.015)] {
        model.set(key, value).unwrap();
    }
    let mut simulation = Simulation::new(&points, &model).unwrap();
    let said = Arc::new(Mutex::new(Vec::new()));
    let listener = Arc::clone(&said);
    let log = move |level: LogLevel, text: &str| {
        assert_eq!(level, LogLevel::Warning);
        listener.lock().unwrap().push(text.to_owned());
    };
    simulation.set_log(Some(Box::new(log)));
    (simulation, said)
}

fn row(count: usize) -> Vec<f64> {
    (0..count).flat_map(|k| [k as f64, 0.0, 0.0]).collect()
}

#[test]
fn a_sound_scene_says_nothing() {
    let (mut simulation, said) = bar(&row(10));
    simulation.break_crossing(&[4.5, -1.0, -1.0, 4.5, 1.0, -1.0, 4.5, 0.0, 1.0]).unwrap();
    simulation.break_bonds(&[[0, 1]]).unwrap();
    let time_step = simulation.stable_time_step().unwrap();
    simulation.step(time_step, 3).unwrap();
    simulation.health().unwrap();
    assert_eq!(*said.lock().unwrap(), Vec::<String>::new());
}

#[test]
fn requests_that_meet_no_bond_are_told_before_and_after_set_up() {
    let (mut simulation, said) = bar(&row(10));
    let metres_for_millimetres = [4500.0, -1.0, -1.0, 4500.0, 1.0, -1.0, 4500.0, 0.0, 1.0];
    for ready in [false, true] {
        if ready {
            simulation.stable_time_step().unwrap();
        }
        simulation.break_crossing(&metres_for_millimetres).unwrap();
        simulation.break_bonds(&[[0, 1], [0, 9]]).unwrap();
        simulation.set_bond_integrity(&[[2, 7]], &[0.5]).unwrap();
    }
    let said = said.lock().unwrap();
    assert_eq!(said.len(), 6, "{said:?}");
    for round in [0, 3] {
        assert!(said[round].contains("no bond crosses the crack"), "{said:?}");
        assert!(said[round + 1].contains("break_bonds: 1 of 2 pairs"), "{said:?}");
        assert!(said[round + 2].contains("set_bond_integrity: 1 of 1 pairs"), "{said:?}");
    }
}

#[test]
fn isolated_points_and_a_bold_time_step_are_told() {
    let mut coordinates = row(10);
    coordinates.extend([50.0, 0.0, 0.0]);
    let (mut simulation, said) = bar(&coordinates);
    let stable = simulation.stable_time_step().unwrap();
    simulation.step(1.5 * stable, 1).unwrap();
    let said = said.lock().unwrap();
    assert!(said[0].starts_with("1 points have no neighbour"), "{said:?}");
    assert!(said[1].contains("1.500 times the step known to be stable"), "{said:?}");
    assert!((simulation.health().unwrap().time_step_ratio - 1.5).abs() < 1e-12);
}
