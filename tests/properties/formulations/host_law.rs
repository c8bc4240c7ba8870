//! The host's own law in every formulation that asks a law.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;

use perion::{Error, Field, MaterialBatch, Model, Simulation};

use super::{Body, Form, apart, bodies, body_at, energy_densities, forms, largest, lattice};
use crate::random::Random;

fn laws(dimension: usize) -> impl Iterator<Item = Form> {
    forms(dimension).filter(|form| form.has_law())
}

/// Saint Venant and Kirchhoff's energy and F S of a gradient F, row after row.
fn saint_venant_kirchhoff(lambda: f64, mu: f64, moved: &[f64], stress: &mut [f64]) -> f64 {
    let size = if moved.len() == 9 { 3 } else { 2 };
    let h = |i: usize, j: usize| moved[size * i + j] - f64::from(u8::from(i == j));
    let strain = |i: usize, j: usize| {
        0.5 * (h(i, j) + h(j, i) + (0..size).map(|k| h(k, i) * h(k, j)).sum::<f64>())
    };
    let trace: f64 = (0..size).map(|i| strain(i, i)).sum();
    let mut squares = 0.0;
    for i in 0..size {
        for j in 0..size {
            squares += strain(i, j) * strain(i, j);
            let along: f64 = (0..size).map(|k| moved[size * i + k] * strain(k, j)).sum();
            stress[size * i + j] = lambda * trace * moved[size * i + j] + 2.0 * mu * along;
        }
    }
    0.5 * lambda * trace * trace + mu * squares
}

/// Lame's constants, in plane stress with what lies across condensed.
fn constants(model: &Model, plane_stress: bool) -> (f64, f64) {
    let (modulus, ratio) =
        (model.get("youngs_modulus").unwrap(), model.get("poissons_ratio").unwrap());
    let mu = modulus / (2.0 * (1.0 + ratio));
    let lambda = 2.0 * mu * ratio / (1.0 - 2.0 * ratio);
    (if plane_stress { 2.0 * lambda * mu / (lambda + 2.0 * mu) } else { lambda }, mu)
}

/// The body with its law by a function.
fn by_function(body: &Body, form: Form) -> Simulation {
    body.changed(form, |model| {
        let (lambda, mu) = constants(model, body.scene.plane_stress);
        let square = body.scene.dimension * body.scene.dimension;
        let ask = move |batch: &mut MaterialBatch<'_>| {
            let MaterialBatch { count, now, stress, energy, .. } = batch;
            for place in 0..*count {
                let own = place * square..(place + 1) * square;
                energy[place] =
                    saint_venant_kirchhoff(lambda, mu, &now[own.clone()], &mut stress[own]);
            }
            ControlFlow::Continue(())
        };
        model.set_material_function(0, ask).unwrap();
    })
}

/// Softens by the largest energy a place has had; the largest is its state.
fn softening(body: &Body, form: Form) -> Simulation {
    body.changed(form, |model| {
        let (lambda, mu) = constants(model, body.scene.plane_stress);
        let square = body.scene.dimension * body.scene.dimension;
        let half = 1e-4 * mu;
        let ask = move |batch: &mut MaterialBatch<'_>| {
            let MaterialBatch { count, now, state_before, state, stress, energy, .. } = batch;
            for place in 0..*count {
                let own = place * square..(place + 1) * square;
                let stress = &mut stress[own.clone()];
                let whole = saint_venant_kirchhoff(lambda, mu, &now[own], stress);
                state[place] = state_before[place].max(whole);
                let left = 1.0 / (1.0 + state[place] / half);
                stress.iter_mut().for_each(|stress| *stress *= left);
                energy[place] = left * whole;
            }
            ControlFlow::Continue(())
        };
        model.set_material_function(1, ask).unwrap();
    })
}

#[test]
fn the_law_of_saint_venant_and_kirchhoff_is_the_same_by_a_function() {
    let (mut worst, mut compared) = ([0.0_f64; 2], 0);
    for (number, body) in bodies().into_iter().enumerate() {
        let body = body.with_law("saint_venant_kirchhoff");
        for form in laws(body.scene.dimension) {
            if body.simulation(form).health().unwrap().degenerate.count > 0 {
                // Where a family does not span the body, only the built-in law thins what is missing.
                continue;
            }
            compared += 1;
            let both = [body.simulation(form), by_function(&body, form)].map(|mut simulation| {
                simulation.set(Field::Displacement, &body.shaken()).unwrap();
                simulation.evaluate().unwrap();
                (simulation.get(Field::InternalForce).unwrap(), energy_densities(&simulation))
            });
            let [(force, energy), (by_function, energy_by_function)] = both;
            let off = [
                apart(&force, &by_function) / largest(&force),
                apart(&energy, &energy_by_function) / largest(&energy),
            ];
            worst = [worst[0].max(off[0]), worst[1].max(off[1])];
            // F = I + H rounds H, of some hundredths, to 1e-14 of it.
            let name = format!("{} {} on body {number}", form.name, form.order);
            assert!(off[0] < 1e-13 && off[1] < 1e-13, "{name}: {off:?}");
        }
    }
    assert!(compared > 90, "{compared}");
    eprintln!("forces {:.1e}, energies {:.1e} of the largest in {compared}", worst[0], worst[1]);
}

#[test]
fn what_a_function_remembers_is_kept_when_it_is_committed() {
    for body in &bodies()[..3] {
        for form in laws(body.scene.dimension) {
            let far = body.shaken();
            let near: Vec<f64> = far.iter().map(|u| 0.3 * u).collect();
            let force = |trial: bool, commits: bool| {
                let mut simulation = softening(body, form);
                if trial {
                    simulation.set(Field::Displacement, &far).unwrap();
                    simulation.evaluate().unwrap();
                    simulation.get(Field::CauchyStress).unwrap();
                    simulation.energy().unwrap();
                    if commits {
                        simulation.commit(0.0).unwrap();
                    }
                }
                simulation.set(Field::Displacement, &near).unwrap();
                [Field::InternalForce, Field::StrainEnergyDensity]
                    .map(|field| simulation.get(field).unwrap())
            };
            let fresh = force(false, false);
            let name = format!("{} {}", form.name, form.order);
            assert_eq!(fresh, force(true, false), "{name}");
            // At 0.3 of the displacement W is a tenth of what there was, which has softened the material by W/half.
            let softened = force(true, true);
            assert!(apart(&fresh[1], &softened[1]) > 0.5 * largest(&fresh[1]), "{name}");
            assert!(apart(&fresh[0], &softened[0]) > 1e-3 * largest(&fresh[0]), "{name}");
        }
    }
}

#[test]
fn bits_do_not_depend_on_threads_and_the_function_runs_on_the_thread_that_drives() {
    let strange = Arc::new(AtomicBool::new(false));
    for body in &bodies()[2..4] {
        for form in laws(body.scene.dimension) {
            let run = |threads: usize| {
                let mut simulation = softening(body, form);
                simulation.set_threads(threads).unwrap();
                simulation.set(Field::Displacement, &body.shaken()).unwrap();
                let step = 0.3 * simulation.stable_time_step().unwrap();
                simulation.step(step, 10).unwrap();
                simulation.get(Field::Velocity).unwrap()
            };
            assert_eq!(run(1), run(2), "{}", form.name);
            let (here, seen) = (thread::current().id(), Arc::clone(&strange));
            let mut simulation = body.changed(form, |model| {
                let seen = Arc::clone(&seen);
                let ask = move |batch: &mut MaterialBatch<'_>| {
                    seen.fetch_or(thread::current().id() != here, Ordering::Relaxed);
                    batch.stress.fill(0.0);
                    batch.energy.fill(0.0);
                    ControlFlow::Continue(())
                };
                model.set_material_function(3, ask).unwrap();
            });
            simulation.set_threads(2).unwrap();
            simulation.evaluate().unwrap();
        }
    }
    assert!(!strange.load(Ordering::Relaxed));
}

#[test]
fn a_function_that_breaks_off_leaves_the_state_as_it_was() {
    let body = &bodies()[0];
    for form in laws(3) {
        let stop = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&stop);
        let mut simulation = body.changed(form, |model| {
            let (lambda, mu) = constants(model, false);
            let told = Arc::clone(&told);
            let ask = move |batch: &mut MaterialBatch<'_>| {
                for place in 0..batch.count {
                    let own = 9 * place..9 * place + 9;
                    let (now, stress) = (&batch.now[own.clone()], &mut batch.stress[own]);
                    batch.energy[place] = saint_venant_kirchhoff(lambda, mu, now, stress);
                }
                if told.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            model.set_material_function(0, ask).unwrap();
            model.set("critical_stretch", 0.02).unwrap();
        });
        simulation.set(Field::Displacement, &body.shaken()).unwrap();
        let step = 0.3 * simulation.stable_time_step().unwrap();
        simulation.step(step, 3).unwrap();
        let state = |simulation: &Simulation| {
            [Field::Displacement, Field::Velocity, Field::Damage, Field::DissipatedEnergyDensity]
                .map(|field| simulation.get(field).unwrap())
        };
        let before = state(&simulation);
        stop.store(true, Ordering::Relaxed);
        for _ in 0..2 {
            let failed = simulation.step(step, 3);
            assert!(matches!(failed, Err(Error::Interrupted(_))), "{}: {failed:?}", form.name);
            assert!(matches!(simulation.energy(), Err(Error::Interrupted(_))), "{}", form.name);
        }
        stop.store(false, Ordering::Relaxed);
        assert_eq!(before, state(&simulation), "{}", form.name);
        simulation.step(step, 1).unwrap();
    }
}

#[test]
fn a_chain_in_a_plane_tells_of_no_stretch_and_no_flow_across() {
    // The state is long and not 0: none of it is taken for what built-in laws remember.
    let body = body_at(2, lattice(2, [6, 1, 1]), 2.3);
    for form in laws(2) {
        let turned = Arc::new(Mutex::new(0.0_f64));
        let asked = Arc::clone(&turned);
        let mut simulation = body.changed(form, |model| {
            let (lambda, mu) = constants(model, false);
            let asked = Arc::clone(&asked);
            let ask = move |batch: &mut MaterialBatch<'_>| {
                for place in 0..batch.count {
                    let own = 4 * place..4 * place + 4;
                    let (now, stress) = (&batch.now[own.clone()], &mut batch.stress[own]);
                    batch.energy[place] = saint_venant_kirchhoff(lambda, mu, now, stress);
                    let mut most = asked.lock().unwrap();
                    *most = most.max((now[3] - 1.0).abs());
                }
                batch.state.fill(7.0);
                ControlFlow::Continue(())
            };
            model.set_material_function(60, ask).unwrap();
        });
        let mut random = Random(3);
        let mut moved = vec![0.0; body.scene.components()];
        moved.iter_mut().step_by(2).for_each(|u| *u = random.between(-0.05, 0.05));
        simulation.set(Field::Displacement, &moved).unwrap();
        simulation.evaluate().unwrap();
        simulation.commit(0.0).unwrap();
        for field in [Field::PlasticStrain, Field::EquivalentPlasticStrain] {
            assert_eq!(largest(&simulation.get(field).unwrap()), 0.0, "{}", form.name);
        }
        let gradient = simulation.get(Field::DeformationGradient).unwrap();
        for gradient in gradient.chunks_exact(4) {
            // Straight along x: the plane's y is as it was, to rounding.
            assert!((gradient[3] - 1.0).abs() < 1e-12, "{} {gradient:?}", form.name);
        }
        assert!(*turned.lock().unwrap() < 1e-12, "{}", form.name);
    }
}
