//! Runs that follow the stable step, and hosts that make the steps themselves.

use std::ops::ControlFlow;

use perion::{AdvanceOptions, Error, Field, Quantity, Simulation};

use crate::body::{CONSTANT, Case, SPLINE, VARIATIONAL, case, noise};

const SPINNING: Case = case("correspondence", CONSTANT, &[]);

fn moving(case: Case, speed: f64) -> Simulation {
    let mut block = case.body([6, 5, 4], 3.015);
    let velocity: Vec<f64> = noise(360, 8).iter().map(|v| speed * v).collect();
    block.set(Field::Velocity, &velocity).unwrap();
    block
}

#[test]
fn it_lands_on_its_time_exactly_in_equal_steps() {
    for case in VARIATIONAL {
        let mut block = moving(case, 1e-4);
        let stable = block.stable_time_step().unwrap();
        let mut until = 0.0;
        for share in [0.3, 7.77, 1e-3, 20.1] {
            until += share * stable;
            let report = block.advance(until, &AdvanceOptions::default()).unwrap();
            assert_eq!(block.time().to_bits(), until.to_bits(), "{case:?}");
            assert_eq!(report.time.to_bits(), until.to_bits());
            let steps = (share / 0.8 / (1.0 - 1e-2)).ceil();
            assert!(report.steps as f64 <= steps && report.steps > 0, "{case:?} {report:?}");
            let largest = report.largest_time_step;
            assert!(largest <= 0.8 * report.stable_time_step * (1.0 + 1e-12), "{report:?}");
            assert!(report.smallest_time_step > 0.999 * largest, "{report:?}");
        }
        assert_eq!(block.advance(until, &AdvanceOptions::default()).unwrap().steps, 0);
    }
}

#[test]
fn steps_of_one_length_are_those_of_step() {
    let options = AdvanceOptions { largest_time_step: 0.25, ..AdvanceOptions::default() };
    let (mut one, mut other) = (moving(SPINNING, 1e-3), moving(SPINNING, 1e-3));
    let report = one.advance(5.0, &options).unwrap();
    assert_eq!(
        (report.steps, report.smallest_time_step, report.largest_time_step),
        (20, 0.25, 0.25)
    );
    other.step(0.25, 20).unwrap();
    for field in [Field::Displacement, Field::Velocity, Field::Acceleration] {
        assert_eq!(one.get(field).unwrap(), other.get(field).unwrap());
    }
}

/// A bar is stretched to one and a half times its length: Saint Venant-Kirchhoff stiffens, and the stable step falls by
/// a third. What was stable at rest blows up; a run that follows keeps its safety.
#[test]
fn it_follows_a_body_that_stiffens() {
    let pulled = || {
        let case = case("correspondence", SPLINE, &[]);
        let mut bar = case.body([10, 4, 4], 3.015);
        let stretched = |time: f64, positions: &[f64], values: &mut [f64]| {
            let strain = 0.5 * (time / 400.0).min(1.0);
            for (value, position) in values.iter_mut().zip(positions.chunks_exact(3)) {
                *value = strain * position[0];
            }
            ControlFlow::Continue(())
        };
        bar.prescribe_function("all", Quantity::Displacement, 0, Box::new(stretched)).unwrap();
        for axis in [1, 2] {
            bar.prescribe("all", Quantity::Displacement, axis, 0.0).unwrap();
        }
        bar
    };
    let mut bar = pulled();
    let rest = bar.stable_time_step().unwrap();
    let options = AdvanceOptions { interval: 40, ..AdvanceOptions::default() };
    let mut ratios = Vec::new();
    let report = bar
        .advance_watched(400.0, &options, |bar, _| {
            ratios.push(bar.health().unwrap().time_step_ratio);
            ControlFlow::Continue(())
        })
        .unwrap();
    assert!(report.stable_time_step < 0.75 * rest, "{report:?} {rest}");
    assert!(report.smallest_time_step < 0.75 * report.largest_time_step, "{report:?}");
    assert!(report.estimates >= 4, "{report:?}");
    assert!(ratios.iter().all(|&ratio| ratio <= 0.8 + 1e-9), "{ratios:?}");
    let now = bar.stable_time_step().unwrap();
    assert!(report.smallest_time_step < now, "{report:?} {now}");
}

#[test]
fn it_follows_damage() {
    let mut model = case("ordinary_state_based", SPLINE, &[]).model(3.015);
    model.set("critical_stretch", 0.02).unwrap();
    let points = crate::body::lattice([10, 6, 3]);
    let mut plate = Simulation::new(&points, &model).unwrap();
    let mut velocity = plate.get(Field::ReferencePosition).unwrap();
    velocity.chunks_exact_mut(3).for_each(|point| {
        let side = (point[0] - 5.0).signum();
        point.copy_from_slice(&[0.03 * side, 0.0, 0.0]);
    });
    plate.set(Field::Velocity, &velocity).unwrap();
    let options = AdvanceOptions { interval: 20, ..AdvanceOptions::default() };
    let report = plate.advance(60.0, &options).unwrap();
    let health = plate.health().unwrap();
    assert!(health.broken_bonds > 100, "{health:?}");
    assert!(report.estimates > report.steps / 20, "{report:?}");
    assert!(health.time_step_ratio <= 0.8 + 1e-9);
    let energy = plate.energy().unwrap();
    assert!(
        energy.closure_error.abs() < 0.05 * energy.kinetic.max(energy.dissipated),
        "{energy:?}"
    );
}

/// Bonds that the rule breaks change the stable step; `step` looks at it again after a while, and `health` tells.
#[test]
fn steps_of_the_host_are_compared_with_the_body_as_it_is() {
    let mut model = case("correspondence", CONSTANT, &[]).model(3.015);
    model.set("critical_stretch", 0.02).unwrap();
    let mut plate = Simulation::new(&crate::body::lattice([10, 6, 3]), &model).unwrap();
    let mut velocity = plate.get(Field::ReferencePosition).unwrap();
    velocity.chunks_exact_mut(3).for_each(|point| {
        let side = (point[0] - 5.0).signum();
        point.copy_from_slice(&[0.02 * side, 0.0, 0.0]);
    });
    plate.set(Field::Velocity, &velocity).unwrap();
    let step = 0.2 * plate.stable_time_step().unwrap();
    let whole = plate.health().unwrap().stable_time_step;
    for _ in 0..3 {
        plate.step(step, 60).unwrap();
    }
    let health = plate.health().unwrap();
    assert!(health.broken_bonds > 100, "{health:?}");
    assert!((health.stable_time_step / whole - 1.0).abs() > 0.01, "{health:?} {whole}");
    assert!((health.time_step_ratio * health.stable_time_step / step - 1.0).abs() < 1e-14);
}

#[test]
fn what_is_wrong_is_refused_and_changes_nothing() {
    let mut block = moving(SPINNING, 1e-3);
    block.set_time(3.0).unwrap();
    let default = AdvanceOptions::default();
    let refused = [
        (2.9, default, "'until' is 2.9"),
        (f64::NAN, default, "'until' is NaN"),
        (f64::INFINITY, default, "'until' is inf"),
        (4.0, AdvanceOptions { safety: 0.0, ..default }, "'safety' is 0"),
        (4.0, AdvanceOptions { safety: 1.1, ..default }, "'safety' is 1.1"),
        (4.0, AdvanceOptions { safety: f64::NAN, ..default }, "'safety' is NaN"),
        (4.0, AdvanceOptions { largest_time_step: -1.0, ..default }, "'largest_time_step' is -1"),
        (4.0, AdvanceOptions { largest_time_step: f64::NAN, ..default }, "'largest_time_step'"),
        (4.0, AdvanceOptions { interval: 0, ..default }, "'interval' is 0"),
    ];
    for (until, options, text) in refused {
        let error = block.advance(until, &options).unwrap_err();
        assert!(matches!(error, Error::Argument(_)) && error.to_string().contains(text), "{error}");
    }
    assert_eq!((block.time(), block.step_count()), (3.0, 0));
    // Steps that the rounding of the time would swallow.
    block.set_time(1e17).unwrap();
    let error = block.advance(1e17 + 64.0, &default).unwrap_err();
    assert!(matches!(error, Error::Numeric(_)), "{error}");
    assert_eq!(block.step_count(), 0);
}

#[test]
fn a_watcher_can_stop_it() {
    let mut block = moving(SPINNING, 1e-3);
    let mut told = Vec::new();
    let error = block
        .advance_watched(100.0, &AdvanceOptions::default(), |_, progress| {
            told.push((progress.done, progress.total));
            if progress.done == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap_err();
    assert!(matches!(error, Error::Interrupted(_)));
    assert_eq!(block.step_count(), 3);
    assert!(told.iter().all(|&(done, total)| done <= total && total == told[0].1), "{told:?}");
}

/// A host that keeps velocities at the middle of steps, and asks for forces alone, makes the same motion: leap-frog is
/// velocity Verlet seen half a step later.
#[test]
fn leap_frog_by_a_host_is_the_same_motion() {
    for case in VARIATIONAL.into_iter().filter(|case| !case.flows()) {
        let (mut verlet, mut hosted) = (moving(case, 0.02), moving(case, 0.02));
        let step = 0.4 * verlet.stable_time_step().unwrap();
        hosted.evaluate().unwrap();
        let mut midway = hosted.get(Field::Velocity).unwrap();
        let mut displacement = hosted.get(Field::Displacement).unwrap();
        let kick = |midway: &mut [f64], hosted: &Simulation, step: f64| {
            let acceleration = hosted.get(Field::Acceleration).unwrap();
            midway.iter_mut().zip(&acceleration).for_each(|(v, a)| *v += step * a);
        };
        // The start is half a step back.
        kick(&mut midway, &hosted, -0.5 * step);
        for number in 1..=30 {
            kick(&mut midway, &hosted, step);
            displacement.iter_mut().zip(&midway).for_each(|(u, v)| *u += step * v);
            hosted.set(Field::Displacement, &displacement).unwrap();
            hosted.commit(step).unwrap();
            hosted.evaluate().unwrap();
            verlet.step(step, 1).unwrap();
            let mut velocity = midway.clone();
            kick(&mut velocity, &hosted, 0.5 * step);
            for (values, field) in
                [(&displacement, Field::Displacement), (&velocity, Field::Velocity)]
            {
                let expected = verlet.get(field).unwrap();
                let largest = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                let apart = values.iter().zip(&expected).map(|(a, b)| (a - b).abs());
                let apart = apart.fold(0.0, f64::max);
                assert!(apart < 1e-11 * largest, "{case:?} {number}: {apart:e} of {largest}");
            }
        }
    }
}

/// A host that makes the two halves of a Verlet step itself comes to the same bits.
#[test]
fn velocity_verlet_by_a_host_has_the_same_bits() {
    for case in VARIATIONAL.into_iter().filter(|case| !case.flows()) {
        let (mut verlet, mut hosted) = (moving(case, 0.02), moving(case, 0.02));
        let step = 0.4 * verlet.stable_time_step().unwrap();
        hosted.evaluate().unwrap();
        let mut velocity = hosted.get(Field::Velocity).unwrap();
        let mut displacement = hosted.get(Field::Displacement).unwrap();
        let kick = |velocity: &mut [f64], hosted: &Simulation| {
            let acceleration = hosted.get(Field::Acceleration).unwrap();
            velocity.iter_mut().zip(&acceleration).for_each(|(v, a)| *v += 0.5 * step * a);
        };
        for _ in 0..30 {
            kick(&mut velocity, &hosted);
            displacement.iter_mut().zip(&velocity).for_each(|(u, v)| *u += step * v);
            hosted.set(Field::Displacement, &displacement).unwrap();
            hosted.commit(step).unwrap();
            hosted.evaluate().unwrap();
            kick(&mut velocity, &hosted);
        }
        verlet.step(step, 30).unwrap();
        assert_eq!(verlet.get(Field::Displacement).unwrap(), displacement, "{case:?}");
        assert_eq!(verlet.get(Field::Velocity).unwrap(), velocity, "{case:?}");
    }
}
