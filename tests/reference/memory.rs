//! Laws with memory: the rotated frame of Flanagan and Taylor against the reference, plasticity against closed forms.

use crate::data::{Reference, assert_close};
use perion::{Field, Model, Points, Simulation};

/// The formulations that ask a law, and what they need beside it.
pub const FORMS: [(&str, f64); 8] = [
    ("correspondence", 1.0),
    ("correspondence", 2.0),
    ("correspondence_silling", 1.0),
    ("correspondence_wan", 1.0),
    ("bond_associated", 1.0),
    ("bond_associated_quadrature", 1.0),
    ("bond_associated_quadrature", 2.0),
    ("total_lagrangian", 1.0),
];

type Matrix = [[f64; 3]; 3];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// A turn about a unit vector.
fn turn(axis: [f64; 3], angle: f64) -> Matrix {
    let [x, y, z] = axis;
    let spin = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let twice = times(&spin, &spin);
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            unit(i, j) + angle.sin() * spin[i][j] + 2.0 * (0.5 * angle).sin().powi(2) * twice[i][j]
        })
    })
}

fn model(form: (&str, f64), constants: &[(&str, f64)], law: &str) -> Model {
    let mut model = Model::new(form.0).unwrap();
    for &(key, value) in constants {
        model.set(key, value).unwrap();
    }
    model.set("density", 1.0).unwrap();
    if form.1 == 2.0 {
        model.set("gradient_order", 2.0).unwrap();
    }
    model.choose("material", law).unwrap();
    model
}

/// A cube of points in which all families bear second order, in a state without memory.
fn cube(model: &Model) -> Simulation {
    let points = Points::block(3, &[-1.5; 3], &[1.5; 3], 1.0).unwrap();
    Simulation::new(&points, model).unwrap()
}

/// Moves all points by F, and accepts it.
fn accept(body: &mut Simulation, f: &Matrix) {
    let places = body.points().coordinates().to_vec();
    let dimension = body.points().dimension();
    let moved: Vec<f64> = places
        .chunks_exact(dimension)
        .flat_map(|x| (0..dimension).map(|i| (0..dimension).map(|j| f[i][j] * x[j]).sum::<f64>()))
        .collect();
    body.set(Field::Position, &moved).unwrap();
    body.evaluate().unwrap();
    body.commit(0.0).unwrap();
}

#[test]
fn the_rotated_frame_is_that_of_the_reference_in_every_formulation() {
    let reference = Reference::load("flanagan_taylor");
    let steps = reference.number("inputs/nsteps") as usize;
    let (dt, rate) = (reference.number("inputs/dt"), reference.number("inputs/rate"));
    let axis: [f64; 3] = reference.numbers("inputs/axis").try_into().unwrap();
    let rows = |key: &str| -> Matrix {
        [0, 1, 2].map(|row| reference.numbers(&format!("{key}/{row}")).try_into().unwrap())
    };
    let slope = rows("inputs/H");
    let constants = [
        ("youngs_modulus", reference.number("inputs/E")),
        ("poissons_ratio", reference.number("inputs/nu")),
        ("horizon", 4.0),
    ];
    for form in FORMS {
        let mut body = cube(&model(form, &constants, "hypoelastic"));
        for step in 1..=steps {
            let time = dt * step as f64;
            let stretched = [0, 1, 2]
                .map(|i| [0, 1, 2].map(|j| f64::from(u8::from(i == j)) + time * slope[i][j]));
            accept(&mut body, &times(&turn(axis, rate * time), &stretched));
            for (when, key) in [(steps / 2, "sigma_half"), (steps, "sigma_final")] {
                if step == when {
                    let expected = rows(&format!("expected/{key}")).concat().repeat(27);
                    let found = body.get(Field::CauchyStress).unwrap();
                    assert_close(&format!("{form:?} {key}"), &found, &expected, 1e-11);
                }
            }
        }
    }
}

#[test]
fn a_stretched_body_that_spins_a_thousand_turns_keeps_its_stress() {
    // Twenty steps a turn: the published update would lead by 26 turns, and its stretch would overflow.
    let constants = [("youngs_modulus", 2.0), ("poissons_ratio", 0.3), ("horizon", 4.0)];
    let mut body = cube(&model(FORMS[0], &constants, "hypoelastic"));
    let stretch = [[1.1, 0.05, 0.0], [0.0, 0.95, 0.02], [0.0, 0.0, 1.0]];
    for part in 1..=20 {
        let share = f64::from(part) / 20.0;
        let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
        accept(
            &mut body,
            &[0, 1, 2]
                .map(|i| [0, 1, 2].map(|j| unit(i, j) + share * (stretch[i][j] - unit(i, j)))),
        );
    }
    let [stress, mises] =
        [Field::CauchyStress, Field::VonMisesStress].map(|field| body.get(field).unwrap());
    let steps = 20;
    for step in 1..=1000 * steps {
        let angle = std::f64::consts::TAU * f64::from(step % steps) / f64::from(steps);
        accept(&mut body, &times(&turn([0.6, 0.0, 0.8], angle), &stretch));
    }
    let after = body.get(Field::VonMisesStress).unwrap();
    assert_close("von Mises", &after, &mises, 1e-9);
    let after = body.get(Field::CauchyStress).unwrap();
    assert_close("every component", &after, &stress, 1e-6);
}

/// F = R diag(1 + e, 1 + t, 1 + t) with a little of everything that is not pure spin.
#[test]
fn a_body_that_spins_and_breathes_keeps_its_frame() {
    // Pulsing by 1 % at a pace of its own, four turns of twenty steps a pulse, for 250 turns: no increment is a
    // turn alone. What is left after whole pulses is the frame's error, which starts anew at a tenth, and the
    // difference of steps: far from the stress itself, and no number is lost.
    let constants = [("youngs_modulus", 2.0), ("poissons_ratio", 0.3), ("horizon", 4.0)];
    let mut body = cube(&model(FORMS[0], &constants, "hypoelastic"));
    let tau = std::f64::consts::TAU;
    for step in 0..=5000 {
        let pulse =
            0.05 * f64::from(step.min(100)) / 100.0 + 0.01 * (tau * f64::from(step) / 80.0).sin();
        let stretched = [[1.0 + pulse, 0.0, 0.0], [0.0, 1.0 - 0.3 * pulse, 0.0], [0.0, 0.0, 1.0]];
        accept(&mut body, &times(&turn([0.6, 0.0, 0.8], tau * f64::from(step) / 20.0), &stretched));
    }
    let stress = body.get(Field::VonMisesStress).unwrap()[0];
    let (lambda, mu) = (2.0 * 0.3 / (1.3 * 0.4), 1.0 / 1.3);
    let logarithms = [1.05_f64.ln(), 0.985_f64.ln(), 0.0];
    let sum: f64 = logarithms.iter().sum();
    let [a, b, c] = logarithms.map(|e| lambda * sum + 2.0 * mu * e);
    let expected = (0.5 * ((a - b).powi(2) + (b - c).powi(2) + (c - a).powi(2))).sqrt();
    eprintln!("{stress} {expected}");
    assert!((stress / expected - 1.0).abs() < 0.1, "{stress} {expected}");
}

/// Uniaxial stress: the stretch across is sought so that the sides are free.
#[test]
fn a_bar_in_tension_yields_hardens_and_unloads_as_the_closed_form_says() {
    // A chain has one direction alone: its family leaves two free of stress.
    let (modulus, yield_stress, hardening) = (200.0, 0.5, 20.0);
    for (name, order) in FORMS.into_iter().filter(|form| form.1 == 1.0) {
        let constants = [
            ("youngs_modulus", modulus),
            ("poissons_ratio", 0.3),
            ("horizon", 2.1),
            ("yield_stress", yield_stress),
            ("hardening_modulus", hardening),
        ];
        let model = model((name, order), &constants, "j2_plastic");
        let places: Vec<f64> = (0..6).flat_map(|k| [f64::from(k), 0.0, 0.0]).collect();
        let points = Points::new(3, &places, &[1.0; 6]).unwrap();
        let mut chain = Simulation::new(&points, &model).unwrap();
        let (mut stress, mut flowed) = (0.0, 0.0);
        let mut last: f64 = 1.0;
        let path = (1..=40)
            .map(|k| 1.0 + 2.5e-4 * f64::from(k))
            .chain((1..=4).map(|k| 1.01 - 5e-4 * f64::from(k)));
        for now in path {
            accept(&mut chain, &[[now, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
            // The increment of the midpoint rule is the logarithmic one to the cube of the step.
            let strain = (now - last) / (0.5 * (now + last));
            last = now;
            let trial: f64 = stress + modulus * strain;
            let beyond: f64 = trial.abs() - (yield_stress + hardening * flowed);
            let amount = beyond.max(0.0) / (modulus + hardening);
            stress = trial - modulus * amount * trial.signum();
            flowed += amount;
            let found = chain.get(Field::CauchyStress).unwrap()[0];
            assert!(
                (found - stress).abs() < 1e-10 * yield_stress,
                "{name} at {now}: {found}, not {stress}"
            );
            let sides = chain.get(Field::CauchyStress).unwrap();
            assert!(sides[4].abs() < 1e-12 && sides[8].abs() < 1e-12, "{name}: {sides:?}");
        }
        assert!(flowed > 5e-3, "{flowed}");
    }
}

/// A plate pulled along x, free along y (where a search puts it), in plane stress or held across in plane strain.
#[test]
fn a_plate_yields_in_plane_stress_and_in_plane_strain_as_an_integration_of_the_law_says() {
    let (modulus, ratio, yield_stress, hardening) = (200.0, 0.3, 0.5, 20.0);
    let (lambda, mu) = (modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio)), modulus / 2.6);
    for (name, order) in FORMS {
        for plane in ["stress", "strain"] {
            let constants = [
                ("youngs_modulus", modulus),
                ("poissons_ratio", ratio),
                ("horizon", 4.5),
                ("yield_stress", yield_stress),
                ("hardening_modulus", hardening),
            ];
            let mut model = model((name, order), &constants, "j2_plastic");
            model.choose("plane", plane).unwrap();
            let points = Points::block(2, &[-2.0; 2], &[2.0; 2], 1.0).unwrap();
            let mut plate = Simulation::new(&points, &model).unwrap();
            // Held along y; the logarithmic strains of a motion along the axes add up.
            let (mut deviator, mut pressure, mut flowed) = ([0.0_f64; 3], 0.0, 0.0);
            let mut last = 1.0;
            for step in 1..=20 {
                let now = 1.0 + 5e-4 * f64::from(step);
                accept(&mut plate, &[[now, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
                let along = (now - last) / (0.5 * (now + last));
                last = now;
                // Radial return at a strain across.
                let returned = |across: f64| {
                    let strain = [along, 0.0, across];
                    let sum: f64 = strain.iter().sum();
                    let pressure = pressure + (lambda + 2.0 * mu / 3.0) * sum;
                    let trial: Vec<f64> =
                        (0..3).map(|k| deviator[k] + 2.0 * mu * (strain[k] - sum / 3.0)).collect();
                    let size = (1.5 * trial.iter().map(|s| s * s).sum::<f64>()).sqrt();
                    let beyond = (size - yield_stress - hardening * flowed).max(0.0);
                    let amount = beyond / (3.0 * mu + hardening);
                    let left = [0, 1, 2].map(|k| trial[k] * (1.0 - 3.0 * mu * amount / size));
                    (left, pressure, flowed + amount)
                };
                let across = if plane == "strain" {
                    0.0
                } else {
                    // No stress across, by bisection.
                    let (mut low, mut high) = (-0.01, 0.01);
                    for _ in 0..200 {
                        let middle = 0.5 * (low + high);
                        let (left, pressure, _) = returned(middle);
                        if left[2] + pressure > 0.0 { high = middle } else { low = middle }
                    }
                    low
                };
                (deviator, pressure, flowed) = returned(across);
                let expected =
                    [deviator[0] + pressure, 0.0, 0.0, deviator[1] + pressure].repeat(16);
                let found = plate.get(Field::CauchyStress).unwrap();
                // The search of the plate stops where its rounding is that of the stress.
                assert_close(&format!("{name} {order} {plane} {step}"), &found, &expected, 1e-10);
                let [of, across] = [Field::EquivalentPlasticStrain, Field::Stress33]
                    .map(|field| plate.get(field).unwrap());
                assert_close("equivalent plastic strain", &of, &[flowed].repeat(16), 1e-10);
                let held = if plane == "strain" { deviator[2] + pressure } else { 0.0 };
                assert!((across[0] - held).abs() < 1e-11, "{name} {plane}: {} {held}", across[0]);
            }
            assert!(flowed > 1e-3, "{flowed}");
        }
    }
}
