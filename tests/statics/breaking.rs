//! Bonds that break on the way to equilibrium.

use perion::{Error, Field, Model, Points, Quantity, Simulation, SolveOptions};

/// A strip with a notch from its left edge, pulled apart at its upper and lower edge.
fn notched(formulation: &str, opening: f64) -> Simulation {
    let mut points = Points::block(2, &[0.0; 2], &[24.0, 16.0], 1.0).unwrap();
    points.add_set_box("lower", &[0.0; 2], &[24.0, 2.0]).unwrap();
    points.add_set_box("upper", &[0.0, 14.0], &[24.0, 16.0]).unwrap();
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in [
        ("density", 1.0),
        ("youngs_modulus", 1.0),
        ("horizon", 3.015),
        ("critical_energy_release_rate", 1e-4),
    ] {
        model.set(key, value).unwrap();
    }
    if formulation != "bond_based" {
        model.set("poissons_ratio", 0.3).unwrap();
    }
    let mut strip = Simulation::new(&points, &model).unwrap();
    strip.break_crossing(&[-1.0, 8.0, 8.0, 8.0]).unwrap();
    strip.forbid_failure("lower").unwrap();
    strip.forbid_failure("upper").unwrap();
    for axis in 0..2 {
        strip.prescribe("lower", Quantity::Displacement, axis, 0.0).unwrap();
    }
    strip.prescribe("upper", Quantity::Displacement, 0, 0.0).unwrap();
    strip.prescribe("upper", Quantity::Displacement, 1, opening).unwrap();
    strip
}

#[test]
fn a_crack_goes_as_far_as_the_opening_drives_it_and_stays() {
    for formulation in ["bond_based", "ordinary_state_based"] {
        let mut strip = notched(formulation, 0.08);
        let before = strip.health().unwrap().broken_bonds;
        let report =
            strip.solve(&SolveOptions { load_steps: 20, ..SolveOptions::default() }).unwrap();
        let health = strip.health().unwrap();
        println!(
            "{formulation}: {} bonds, {} steps, {} cuts, {} forces",
            report.broken_bonds, report.steps, report.cuts, report.evaluations
        );
        assert!(report.broken_bonds > 0);
        assert_eq!(health.broken_bonds - before, report.broken_bonds);
        let energy = strip.energy().unwrap();
        println!("{energy:?}");
        assert!(energy.dissipated > 0.0);
        // Closed again, bonds do not heal.
        strip.prescribe("upper", Quantity::Displacement, 1, 0.0).unwrap();
        strip.solve(&SolveOptions::default()).unwrap();
        assert_eq!(strip.health().unwrap().broken_bonds, health.broken_bonds);
        let left = strip.get(Field::Displacement).unwrap();
        assert!(left.iter().all(|u| u.abs() < 1e-7), "it does not close");
    }
}

#[test]
fn a_part_that_a_load_tears_off_is_told_and_the_last_load_step_is_kept() {
    let mut strip = notched("bond_based", 0.0);
    strip.release("upper", Quantity::Displacement, 0).unwrap();
    strip.release("upper", Quantity::Displacement, 1).unwrap();
    strip.prescribe("upper", Quantity::BodyForce, 1, 0.02).unwrap();
    let mut run =
        strip.start_solving(&SolveOptions { load_steps: 10, ..Default::default() }).unwrap();
    let error = loop {
        match strip.continue_solving(&mut run) {
            Ok(Some(_)) => {}
            Ok(None) => panic!("a strip torn in two came to rest"),
            Err(error) => break error,
        }
    };
    println!("{error}");
    assert!(matches!(error, Error::Convergence(_)));
    let report = run.report();
    assert!(report.steps > 0 && report.share < 1.0);
    assert_eq!(strip.step_count(), report.steps);
    let force = strip.sum(Field::BodyForce, None).unwrap()[1] / (48.0 * 0.02);
    assert!((force - report.share).abs() < 1e-12, "{force} borne, {} gone", report.share);
}

#[test]
fn a_search_that_fails_leaves_no_trace_in_what_breaks_next() {
    for formulation in ["bond_based", "ordinary_state_based"] {
        let [tried, straight] = [true, false].map(|tries| {
            let mut strip = notched(formulation, 0.08);
            if tries {
                let options =
                    SolveOptions { breaks: 1, smallest_load_step: 1.0, ..SolveOptions::default() };
                let error = strip.solve(&options).unwrap_err();
                assert!(error.to_string().contains("breaking"), "{error}");
                assert_eq!(strip.step_count(), 0);
            }
            strip.solve(&SolveOptions { load_steps: 5, ..SolveOptions::default() }).unwrap();
            strip.step(0.1, 20).unwrap();
            strip
        });
        assert!(straight.energy().unwrap().dissipated > 0.0);
        for field in [Field::Displacement, Field::Damage, Field::DissipatedEnergyDensity] {
            let [a, b] = [&tried, &straight].map(|strip| strip.get(field).unwrap());
            assert!(a.iter().zip(&b).all(|(a, b)| a.to_bits() == b.to_bits()), "{formulation}");
        }
    }
}
