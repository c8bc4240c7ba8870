//! Hosts that step themselves get what `step` makes; looking changes nothing.

use perion::{Field, Model, Points, Simulation};
use proptest::prelude::*;

use crate::random::cases;
use crate::scene::{bits, bonds, small_bodies, state_bits};

/// Velocity Verlet as a host writes it.
fn drive(simulation: &mut Simulation, velocity: &mut [f64], time_step: f64, steps: usize) {
    let dimension = simulation.points().dimension();
    let densities = simulation.get(Field::Density).unwrap();
    let mut displacement = simulation.get(Field::Displacement).unwrap();
    simulation.evaluate().unwrap();
    let mut force = simulation.get(Field::InternalForce).unwrap();
    for _ in 0..steps {
        for (component, velocity) in velocity.iter_mut().enumerate() {
            let half = 0.5 * time_step / densities[component / dimension];
            *velocity += half * force[component];
            displacement[component] += time_step * *velocity;
        }
        simulation.set(Field::Displacement, &displacement).unwrap();
        simulation.commit(time_step).unwrap();
        simulation.evaluate().unwrap();
        simulation.get_into(Field::InternalForce, &mut force).unwrap();
        for (component, velocity) in velocity.iter_mut().enumerate() {
            *velocity += 0.5 * time_step / densities[component / dimension] * force[component];
        }
    }
}

/// Whether two fields agree to rounding, by the largest value there is.
fn agree(a: &[f64], b: &[f64]) -> bool {
    let size = a.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    a.iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-12 * size)
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn a_host_that_steps_itself_gets_what_step_makes(
        recipe in small_bodies(), wound: bool, breaking: bool,
    ) {
        let scene = recipe.scene();
        let prepare = || {
            let mut simulation = scene.simulation(breaking.then_some(0.02));
            if wound {
                scene.wound(&mut simulation);
            }
            let time_step = 0.7 * simulation.stable_time_step().unwrap();
            let size = 0.02 * scene.spacing / time_step;
            let velocity = scene.random(60).around_zero(scene.components(), size);
            (simulation, velocity, time_step)
        };
        let (mut library, start, time_step) = prepare();
        library.set(Field::Velocity, &start).unwrap();
        library.step(time_step, 30).unwrap();
        let (mut own, mut velocity, _) = prepare();
        drive(&mut own, &mut velocity, time_step, 30);
        prop_assert_eq!(own.step_count(), library.step_count());
        prop_assert_eq!(own.time(), library.time());
        prop_assert_eq!(bits(&own, Field::Damage), bits(&library, Field::Damage));
        // A handful of points may hold together.
        if breaking && scene.count() > 20 {
            prop_assert!(own.energy().unwrap().dissipated > 0.0);
        }
        let fields = [
            Field::Displacement,
            Field::InternalForce,
            Field::StrainEnergyDensity,
            Field::DissipatedEnergyDensity,
        ];
        for field in fields {
            let both = [&library, &own].map(|simulation| simulation.get(field).unwrap());
            prop_assert!(agree(&both[0], &both[1]), "{}", field.name());
        }
        prop_assert!(agree(&library.get(Field::Velocity).unwrap(), &velocity));
    }

    #[test]
    fn looking_at_a_body_changes_no_bit(recipe in small_bodies(), wound: bool) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(Some(0.02));
        if wound {
            scene.wound(&mut simulation);
        }
        let start = scene.random(61).around_zero(scene.components(), 0.02 * scene.spacing);
        simulation.set(Field::Displacement, &start).unwrap();
        let step = simulation.stable_time_step().unwrap();
        for _ in 0..3 {
            let before = state_bits(&simulation);
            simulation.evaluate().unwrap();
            let forces = bits(&simulation, Field::InternalForce);
            let accelerations = bits(&simulation, Field::Acceleration);
            simulation.evaluate().unwrap();
            prop_assert_eq!(bits(&simulation, Field::InternalForce), forces);
            prop_assert_eq!(bits(&simulation, Field::Acceleration), accelerations);
            simulation.stable_time_step().unwrap();
            simulation.health().unwrap();
            for field in Field::ALL {
                if field.is_defined(simulation.points().dimension()) {
                    simulation.get(field).unwrap();
                }
            }
            simulation.step(step, 0).unwrap();
            prop_assert_eq!(state_bits(&simulation), before);
            simulation.step(step, 4).unwrap();
        }
    }

    #[test]
    fn forces_are_those_of_the_bonds_and_displacements_as_they_are(recipe in small_bodies()) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(Some(0.02));
        let mut random = scene.random(63);
        let step = 0.5 * simulation.stable_time_step().unwrap();
        let pairs: Vec<[usize; 2]> = bonds(&simulation).iter().map(|bond| bond.0).collect();
        for change in 0..12 {
            simulation.evaluate().unwrap();
            let pair = [pairs[random.below(pairs.len())]];
            match change % 4 {
                0 => {
                    let u = random.around_zero(scene.components(), 0.03 * scene.spacing);
                    simulation.set(Field::Displacement, &u).unwrap();
                    simulation.evaluate().unwrap();
                    simulation.commit(step).unwrap();
                }
                1 => simulation.break_bonds(&pair).unwrap(),
                2 => simulation.set_bond_integrity(&pair, &[0.5]).unwrap(),
                _ => simulation.step(step, 2).unwrap(),
            }
            let forces = bits(&simulation, Field::InternalForce);
            simulation.evaluate().unwrap();
            prop_assert_eq!(&bits(&simulation, Field::InternalForce), &forces, "{}", change);
            // Written anew, the displacement makes the forces be computed from scratch.
            let u = simulation.get(Field::Displacement).unwrap();
            simulation.set(Field::Displacement, &u).unwrap();
            simulation.evaluate().unwrap();
            prop_assert_eq!(&bits(&simulation, Field::InternalForce), &forces, "{}", change);
        }
    }

    #[test]
    fn a_run_in_pieces_has_the_bits_of_one_run(recipe in small_bodies(), pieces in 1..8_u64) {
        let scene = recipe.scene();
        let velocity = scene.random(62).around_zero(scene.components(), 1.0);
        let run = |piece: u64| {
            let mut simulation = scene.simulation(Some(0.02));
            let step = 0.9 * simulation.stable_time_step().unwrap();
            let start: Vec<f64> =
                velocity.iter().map(|v| 0.03 * v * scene.spacing / step).collect();
            simulation.set(Field::Velocity, &start).unwrap();
            while simulation.step_count() < 20 {
                let left = 20 - simulation.step_count();
                simulation.step(step, piece.min(left)).unwrap();
            }
            state_bits(&simulation)
        };
        prop_assert_eq!(run(20), run(pieces));
    }
}

/// What a bond gives up when it breaks does not depend on how its host looks at forces.
#[test]
fn a_host_that_only_commits_dissipates_what_one_that_evaluates_does() {
    let points = Points::block(2, &[0.0; 2], &[12.0; 2], 1.0).unwrap();
    let mut model = Model::new("bond_based").unwrap();
    for (key, value) in
        [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 3.015), ("critical_stretch", 0.01)]
    {
        model.set(key, value).unwrap();
    }
    let dissipated = |look: &dyn Fn(&mut Simulation)| {
        let mut simulation = Simulation::new(&points, &model).unwrap();
        for step in 1..=20 {
            let strain = 1e-3 * f64::from(step);
            let stretched = points.coordinates().chunks_exact(2).flat_map(|x| [strain * x[0], 0.0]);
            let displacement: Vec<f64> = stretched.collect();
            simulation.set(Field::Displacement, &displacement).unwrap();
            simulation.commit(1.0).unwrap();
            look(&mut simulation);
        }
        simulation.energy().unwrap().dissipated
    };
    let plain = dissipated(&|_| ());
    assert!(plain > 0.0);
    assert_eq!(plain, dissipated(&|simulation| simulation.evaluate().unwrap()));
    assert_eq!(
        plain,
        dissipated(&|simulation| {
            simulation.get(Field::InternalForce).unwrap();
        })
    );
}
