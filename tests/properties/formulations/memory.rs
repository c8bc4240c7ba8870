//! What holds for laws with memory in every formulation that asks a law.

use perion::{Field, Simulation};

use super::{Body, Form, Turn, apart, bodies, body_at, forms, largest, lattice};
use crate::random::Random;

/// A body whose material flows at a strain of a thousandth.
fn plastic(body: &Body, form: Form) -> Simulation {
    body.changed(form, |model| {
        let modulus = model.get("youngs_modulus").unwrap();
        model.choose("material", "j2_plastic").unwrap();
        model.set("yield_stress", 1e-3 * modulus).unwrap();
        model.set("hardening_modulus", 0.1 * modulus).unwrap();
    })
}

fn laws(dimension: usize) -> impl Iterator<Item = Form> {
    forms(dimension).filter(|form| form.has_law())
}

/// Lets go of random displacements, with random velocities.
fn shake(body: &Body, simulation: &mut Simulation, share: f64) {
    let mut random = body.scene.random(11);
    let components = body.scene.components();
    let displacement = random.around_zero(components, share * body.scene.spacing);
    simulation.set(Field::Displacement, &displacement).unwrap();
    simulation.evaluate().unwrap();
    simulation.commit(0.0).unwrap();
}

#[test]
fn plastic_flow_is_in_the_balance_of_energy() {
    for (number, body) in bodies().iter().enumerate().take(6) {
        for form in laws(body.scene.dimension) {
            let mut error = [0.0, 0.0];
            let mut share = 0.0;
            for (error, parts) in error.iter_mut().zip([1, 4]) {
                let mut simulation = plastic(body, form);
                shake(body, &mut simulation, 0.02);
                let step = 0.3 * simulation.stable_time_step().unwrap() / parts as f64;
                simulation.step(step, 60 * parts).unwrap();
                let energy = simulation.energy().unwrap();
                let whole = energy.kinetic + energy.elastic + energy.dissipated;
                *error = energy.closure_error.abs() / whole;
                share = energy.plastic / whole;
                assert!(energy.elastic > 0.0 && share < 1.0, "{energy:?}");
                assert_eq!(energy.plastic, energy.dissipated);
                let told = simulation.sum(Field::DissipatedEnergyDensity, None).unwrap();
                assert!(told[0] > 0.0 && energy.plastic > 0.0);
            }
            let name = format!("{} {} on body {number}", form.name, form.order);
            eprintln!("{name}: {:.1e}, {:.1e} in quarters, {share:.2} plastic", error[0], error[1]);
            // Verlet's swing at 0.3 of the stable step, (omega dt)^2/8 = 0.6^2/8, and by the square of the step less.
            assert!(error[0] < 0.045 && error[1] < (0.2 * error[0]).max(1e-5), "{name}: {error:?}");
        }
    }
}

#[test]
fn what_flow_has_dissipated_stays_so_where_the_host_breaks_bonds() {
    for body in bodies().iter().take(4) {
        for form in laws(body.scene.dimension) {
            let mut simulation = plastic(body, form);
            shake(body, &mut simulation, 0.02);
            let before = simulation.energy().unwrap();
            assert!(before.plastic > 0.0);
            let mut pairs = Vec::new();
            simulation.for_each_bond(|pair, _, _| pairs.push(pair)).unwrap();
            let some: Vec<_> = pairs.into_iter().step_by(7).collect();
            simulation.break_bonds(&some).unwrap();
            let after = simulation.energy().unwrap();
            // What points hold less is lost, and what they hold more was given.
            let lost = (before.elastic - after.elastic).max(0.0);
            let more = after.dissipated - before.dissipated;
            assert!(
                more >= lost * (1.0 - 1e-9) - 1e-12 * before.dissipated,
                "{form:?} {more} {lost}"
            );
        }
    }
}

#[test]
fn momentum_and_its_moment_are_kept_while_material_flows() {
    for body in bodies().iter().take(6) {
        for form in laws(body.scene.dimension) {
            let mut simulation = plastic(body, form);
            shake(body, &mut simulation, 0.02);
            let force = simulation.get(Field::InternalForce).unwrap();
            let volumes = simulation.get(Field::Volume).unwrap();
            let dimension = body.scene.dimension;
            let mut sums = vec![0.0; dimension];
            let mut sizes = 0.0;
            for (force, volume) in force.chunks_exact(dimension).zip(&volumes) {
                for (sum, force) in sums.iter_mut().zip(force) {
                    *sum += volume * force;
                    sizes += (volume * force).abs();
                }
            }
            assert!(largest(&sums) < 1e-13 * sizes, "{}: {sums:?} of {sizes}", form.name);
        }
    }
}

#[test]
fn a_plate_one_point_thick_and_a_chain_turn_without_stress() {
    // Turned in thirty steps, each accepted: the rate form sees a turn, and what is not spanned turns along.
    for (places, horizon) in [(lattice(3, [5, 5, 1]), 2.3), (lattice(3, [6, 1, 1]), 2.3)] {
        let body = body_at(3, places, horizon);
        for form in laws(3) {
            let mut simulation = plastic(&body, form);
            let mut random = Random(5);
            let turn = Turn::random(3, &mut random);
            let rest = vec![0.0; body.scene.components()];
            for step in 1..=30 {
                let part = Turn { angle: turn.angle * f64::from(step) / 30.0, ..turn };
                let moved = part.displacement(&body.scene, &rest);
                simulation.set(Field::Displacement, &moved).unwrap();
                simulation.evaluate().unwrap();
                simulation.commit(0.0).unwrap();
            }
            let energy = largest(&simulation.get(Field::StrainEnergyDensity).unwrap());
            let force = largest(&simulation.get(Field::InternalForce).unwrap());
            let name = format!("{} {}", form.name, form.order);
            eprintln!("{name}: {energy:.1e} {force:.1e}");
            // As the bar for all: W below 1e-12 E, b below 1e-11 K/delta.
            let modulus = body.youngs_modulus();
            assert!(energy < 1e-12 * modulus, "{name}: {energy}");
            assert!(force < 1e-11 * modulus / horizon, "{name}: {force}");
        }
    }
}

#[test]
fn looking_and_evaluating_leave_what_is_remembered_as_it_is() {
    let body = &bodies()[0];
    for form in laws(3) {
        let run = |looks: bool| {
            let mut simulation = plastic(body, form);
            shake(body, &mut simulation, 0.02);
            let step = 0.3 * simulation.stable_time_step().unwrap();
            for _ in 0..5 {
                if looks {
                    simulation.get(Field::CauchyStress).unwrap();
                    simulation.get(Field::PlasticStrain).unwrap();
                    simulation.energy().unwrap();
                    simulation.evaluate().unwrap();
                    simulation.stable_time_step().unwrap();
                }
                simulation.step(step, 2).unwrap();
            }
            simulation.get(Field::Displacement).unwrap()
        };
        assert_eq!(run(false), run(true), "{} {}", form.name, form.order);
    }
}

#[test]
fn a_hosts_trial_displacement_is_forgotten_unless_it_is_committed() {
    let body = &bodies()[1];
    for form in laws(body.scene.dimension) {
        let forces = |stray: bool| {
            let mut simulation = plastic(body, form);
            shake(body, &mut simulation, 0.01);
            let kept = simulation.get(Field::Displacement).unwrap();
            if stray {
                let far: Vec<f64> = kept.iter().map(|u| 5.0 * u).collect();
                simulation.set(Field::Displacement, &far).unwrap();
                simulation.evaluate().unwrap();
                simulation.set(Field::Displacement, &kept).unwrap();
            }
            simulation.get(Field::InternalForce).unwrap()
        };
        assert_eq!(apart(&forces(false), &forces(true)), 0.0, "{}", form.name);
    }
}

#[test]
fn bits_do_not_depend_on_threads_while_material_flows() {
    let body = &bodies()[3];
    for form in laws(body.scene.dimension) {
        let run = |threads: usize| {
            let mut simulation = plastic(body, form);
            simulation.set_threads(threads).unwrap();
            shake(body, &mut simulation, 0.02);
            let step = 0.3 * simulation.stable_time_step().unwrap();
            simulation.step(step, 10).unwrap();
            simulation.get(Field::Velocity).unwrap()
        };
        assert_eq!(run(1), run(2), "{}", form.name);
    }
}
