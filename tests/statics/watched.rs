//! Relaxations that are looked at on their way.

use std::ops::ControlFlow;

use perion::{Error, Field, Model, Points, Quantity, RelaxOptions, Simulation, StaticsReport};

/// A plate of springs whose ends are pulled apart until bonds break.
fn plate() -> Simulation {
    let mut points = Points::block(2, &[0.0; 2], &[12.0, 6.0], 1.0).unwrap();
    points.add_set_box("left", &[0.0, 0.0], &[2.0, 6.0]).unwrap();
    points.add_set_box("right", &[10.0, 0.0], &[12.0, 6.0]).unwrap();
    let mut model = Model::new("bond_based").unwrap();
    for (key, value) in
        [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 2.015), ("critical_stretch", 0.03)]
    {
        model.set(key, value).unwrap();
    }
    model.choose("damage", "critical_stretch").unwrap();
    let mut plate = Simulation::new(&points, &model).unwrap();
    for axis in 0..2 {
        plate.prescribe("left", Quantity::Displacement, axis, 0.0).unwrap();
    }
    plate.prescribe("right", Quantity::Displacement, 0, 0.26).unwrap();
    plate
}

fn displacements(plate: &Simulation) -> Vec<u64> {
    plate.get(Field::Displacement).unwrap().iter().map(|value| value.to_bits()).collect()
}

#[test]
fn looking_changes_nothing_and_tells_of_each_step() {
    let (mut alone, mut watched) = (plate(), plate());
    let expected = alone.relax(&RelaxOptions::default()).unwrap();
    assert!(expected.broken_bonds > 0, "nothing has broken");
    let before = displacements(&watched);
    let (mut report, mut calls, mut at_rest) = (StaticsReport::default(), 0, 0);
    watched
        .relax_watched(&RelaxOptions::default(), &mut report, |plate, made| {
            calls += 1;
            assert!(made.done <= calls && made.done <= made.total);
            at_rest += u64::from(displacements(plate) != before);
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(report, expected);
    // A force a step, and one more wherever forces were balanced; of the last alone the body has changed.
    assert_eq!((calls as usize, at_rest), (report.residuals.len(), 1));
    assert!(calls > report.iterations + 1);
    assert_eq!(displacements(&watched), displacements(&alone));
}

#[test]
fn a_relaxation_that_is_stopped_leaves_the_body_as_it_was_and_tells_what_it_did() {
    let mut plate = plate();
    let before = displacements(&plate);
    let mut report = StaticsReport::default();
    let stopped = plate.relax_watched(&RelaxOptions::default(), &mut report, |_, made| {
        if made.done == 40 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(matches!(&stopped, Err(Error::Interrupted(text)) if text.contains("step 40")));
    assert_eq!((report.residuals.len(), report.iterations, report.steps), (40, 40, 0));
    assert_eq!(displacements(&plate), before);
    assert_eq!(plate.health().unwrap().broken_bonds, 0);
    plate.relax(&RelaxOptions::default()).unwrap();
}

#[test]
fn the_log_hears_of_residuals() {
    let mut plate = plate();
    let heard = std::sync::Arc::new(std::sync::Mutex::new(Vec::new()));
    let keeper = heard.clone();
    plate
        .set_log(Some(Box::new(move |_, text: &str| keeper.lock().unwrap().push(text.to_owned()))));
    let report = plate.relax(&RelaxOptions::default()).unwrap();
    let heard = heard.lock().unwrap();
    let lines = heard.iter().filter(|line| line.starts_with("relax: residual")).count();
    assert_eq!(lines, report.residuals.len() / 100, "{heard:?}");
}
