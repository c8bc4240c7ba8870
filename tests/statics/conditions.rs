//! What load steps ask of conditions.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

use perion::{Field, Model, Points, Quantity, Simulation, SolveOptions};

fn bar() -> Simulation {
    let mut points = Points::block(2, &[0.0; 2], &[12.0, 4.0], 1.0).unwrap();
    points.add_set_box("left", &[0.0; 2], &[1.0, 4.0]).unwrap();
    points.add_set_box("right", &[11.0, 0.0], &[12.0, 4.0]).unwrap();
    let mut model = Model::new("bond_based").unwrap();
    for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 2.51)] {
        model.set(key, value).unwrap();
    }
    let mut bar = Simulation::new(&points, &model).unwrap();
    bar.prescribe("left", Quantity::Displacement, 0, 0.0).unwrap();
    bar.prescribe("left", Quantity::Displacement, 1, 0.0).unwrap();
    bar
}

fn in_steps(load_steps: u64) -> SolveOptions {
    SolveOptions { load_steps, ..SolveOptions::default() }
}

fn applied(bar: &Simulation) -> f64 {
    bar.sum(Field::BodyForce, None).unwrap()[0]
}

#[test]
fn constants_go_on_from_what_they_were() {
    let mut bar = bar();
    let (mut seen, mut most_elastic) = (Vec::new(), 0.0_f64);
    for force in [1e-3, 3e-3, 0.0] {
        bar.prescribe("right", Quantity::BodyForce, 0, force).unwrap();
        bar.solve_watched(&in_steps(2), |bar, _| {
            seen.push(applied(bar) / 4e-3);
            most_elastic = most_elastic.max(bar.energy().unwrap().elastic);
            ControlFlow::Continue(())
        })
        .unwrap();
    }
    let expected = [0.5, 1.0, 2.0, 3.0, 1.5, 0.0];
    assert!(seen.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{seen:?}");
    let most = bar.get(Field::Displacement).unwrap().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(most < 1e-8, "unloaded, it is as it was: {most}");
    // The work is a trapezoid over load steps: what is bent between them is left out.
    let energy = bar.energy().unwrap();
    assert!(energy.closure_error.abs() < 1e-3 * most_elastic, "{energy:?}, {most_elastic}");
}

#[test]
fn tables_and_functions_are_asked_along_the_time() {
    let mut bar = bar();
    let asked = Arc::new(Mutex::new(Vec::new()));
    let times = asked.clone();
    let function = move |time: f64, _: &[f64], values: &mut [f64]| {
        times.lock().unwrap().push(time);
        values.fill(1e-3 * time * time);
        ControlFlow::Continue(())
    };
    bar.prescribe_function("right", Quantity::Displacement, 0, Box::new(function)).unwrap();
    bar.prescribe_table("right", Quantity::BodyForce, 1, &[0.0, 2.0], &[0.0, 2e-4]).unwrap();
    let mut seen = Vec::new();
    let options = SolveOptions { time_end: Some(2.0), ..in_steps(4) };
    let report = bar
        .solve_watched(&options, |bar, made| {
            let end = bar.get(Field::Displacement).unwrap()[2 * 11];
            seen.push((made.time, end, bar.sum(Field::BodyForce, None).unwrap()[1]));
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!((report.time, bar.time()), (2.0, 2.0));
    for (time, end, force) in seen {
        assert!((end - 1e-3 * time * time).abs() < 1e-15, "{end} at {time}");
        assert!((force - 4.0 * 1e-4 * time).abs() < 1e-15, "{force} at {time}");
    }
    assert!(asked.lock().unwrap().contains(&0.5));
}

#[test]
fn a_body_at_rest_goes_on_to_move_without_a_jolt() {
    let mut bar = bar();
    bar.prescribe("right", Quantity::Traction, 0, 1e-3).unwrap();
    bar.solve(&SolveOptions::default()).unwrap();
    let before = bar.get(Field::Displacement).unwrap();
    let step = 0.5 * bar.stable_time_step().unwrap();
    bar.step(step, 50).unwrap();
    let after = bar.get(Field::Displacement).unwrap();
    let moved = before.iter().zip(&after).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(moved < 1e-9, "{moved}");
    assert!(bar.energy().unwrap().kinetic < 1e-18);
}
