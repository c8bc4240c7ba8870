//! Lengths of bonds that are computed when they are needed, against lengths that are kept.

use perion::{Error, Field, Model, SimdLevel, Simulation};

use super::{Body, Form, apart, bodies, forms, largest};
use crate::scene::{bonds, state_bits};

const FAST_AND_LEAN: [&str; 2] = ["fast", "lean"];

/// Bonds break beyond this, some of them at once.
const CRITICAL: f64 = 0.03;

fn choose(model: &mut Model, storage: &str) {
    model.choose("storage", storage).unwrap();
    model.set("critical_stretch", CRITICAL).unwrap();
}

fn levels() -> impl Iterator<Item = SimdLevel> {
    SimdLevel::ALL.into_iter().filter(|level| level.is_available())
}

/// Forces before and after bonds break, which bonds are left, and what is lost.
type Outcome = (Vec<f64>, Vec<bool>, Vec<f64>);

fn outcome(body: &Body, simulation: &mut Simulation) -> Outcome {
    simulation.set(Field::Displacement, &body.shaken()).unwrap();
    simulation.evaluate().unwrap();
    let mut force = simulation.get(Field::InternalForce).unwrap();
    simulation.commit(1e-9).unwrap();
    simulation.evaluate().unwrap();
    force.extend(simulation.get(Field::InternalForce).unwrap());
    let intact = bonds(simulation).into_iter().map(|(_, _, integrity)| integrity > 0.0).collect();
    (force, intact, simulation.get(Field::Damage).unwrap())
}

/// Measured: 4e-14.
fn assert_alike(what: &str, [fast, lean]: [Outcome; 2]) {
    let distance = apart(&fast.0, &lean.0) / largest(&fast.0);
    assert!(distance < 1e-12, "{what}: {distance:e}");
    assert_eq!(fast.1, lean.1, "{what}");
    assert!(fast.1.contains(&true) && fast.1.contains(&false), "{what}");
    assert_eq!(fast.2, lean.2, "{what}");
}

#[test]
fn lean_bodies_of_any_formulation_pull_and_break_as_fast_ones() {
    for body in bodies() {
        for form in forms(body.scene.dimension) {
            for level in levels() {
                for wounded in [false, true] {
                    let each = FAST_AND_LEAN.map(|storage| {
                        let mut simulation = body.changed(form, |model| choose(model, storage));
                        simulation.set_simd(level).unwrap();
                        if wounded {
                            body.scene.wound(&mut simulation);
                        }
                        outcome(&body, &mut simulation)
                    });
                    assert_alike(&format!("{form:?} {}", level.name()), each);
                }
            }
        }
    }
}

#[test]
fn interfaces_cracks_and_corrected_surfaces_are_those_of_fast_bodies() {
    for body in bodies().into_iter().filter(|body| !body.scene.second.is_empty()) {
        for (name, correction) in [
            ("bond_based", "energy"),
            ("bond_based", "stiffness_tensor"),
            ("ordinary_state_based", "energy"),
            ("ordinary_state_based", "stiffness_tensor"),
        ] {
            let form = Form { name, order: 1 };
            let each = FAST_AND_LEAN.map(|storage| {
                let mut simulation = body.changed(form, |model| {
                    choose(model, storage);
                    model.choose("surface_correction", correction).unwrap();
                });
                let rate = 1e-5 * body.youngs_modulus() * body.scene.spacing;
                simulation.set_interface("left", "second", rate).unwrap();
                let middle = middle(&body);
                let reach = 3.0 * body.scene.spacing;
                let [x, y] = [middle[0], middle[1]];
                if body.scene.dimension == 2 {
                    simulation.break_crossing(&[x, y - reach, x, y]).unwrap();
                } else {
                    let z = middle[2];
                    let corners = [[y - reach, z - reach], [y, z - reach], [y, z + reach]];
                    let vertices = corners.map(|[y, z]| [x, y, z]).concat();
                    simulation.break_crossing(&vertices).unwrap();
                }
                outcome(&body, &mut simulation)
            });
            assert_alike(name, each);
        }
    }
}

fn middle(body: &Body) -> Vec<f64> {
    let dimension = body.scene.dimension;
    let count = body.scene.count() as f64;
    let along = |axis: usize| body.scene.coordinates[axis..].iter().step_by(dimension);
    (0..dimension)
        .map(|axis| along(axis).sum::<f64>() / count + 1e-4 * body.scene.spacing)
        .collect()
}

#[test]
fn lean_bodies_move_by_the_same_bits_on_any_number_of_threads() {
    let body = Body {
        scene: crate::scene::Recipe {
            dimension: 3,
            counts: [8, 7, 6],
            jitter: 0.25,
            horizons: crate::scene::Horizons::Uniform,
            materials: 1,
            plane_stress: false,
            units: [0, 0, 0],
            seed: 77,
        }
        .scene(),
        influences: ["inverse"; 2],
        law: "saint_venant_kirchhoff",
        partial_volume: false,
    };
    for form in forms(3) {
        let run = |threads: usize| {
            let mut simulation = body.changed(form, |model| choose(model, "lean"));
            simulation.set_threads(threads).unwrap();
            (outcome(&body, &mut simulation), state_bits(&simulation))
        };
        let expected = run(1);
        assert!(expected.0.1.contains(&false), "{form:?}");
        for threads in [2, 4] {
            assert!(run(threads) == expected, "{form:?}, {threads} threads");
        }
    }
}

#[test]
fn all_models_of_a_simulation_share_the_storage() {
    let body = &bodies()[0];
    let form = Form { name: "bond_based", order: 1 };
    let mut simulation = body.simulation(form);
    let mut lean = body.model(form, 0);
    lean.choose("storage", "lean").unwrap();
    let error = simulation.assign_model("left", &lean).unwrap_err();
    assert!(matches!(error, Error::Unsupported(_)));
    assert!(error.to_string().contains("'storage'"), "{error}");
}
