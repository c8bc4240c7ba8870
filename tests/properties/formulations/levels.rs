//! Sweeps in lanes, on every level of instructions that the machine has, against the loops over single bonds.

use std::ops::ControlFlow;

use perion::{Field, MaterialBatch, Model, Quantity, SimdLevel, Simulation};

use super::{Body, Form, INFLUENCES, apart, bodies, forms, largest};
use crate::scene::{Horizons, Recipe, bonds, state_bits};

/// Bodies of one horizon and one influence function, of one material and of two, in 3D, plane strain and plane stress.
fn even_bodies() -> impl Iterator<Item = Body> {
    (0..12).map(|number| {
        let (state, influence) = (number % 3, INFLUENCES[number / 3]);
        let recipe = Recipe {
            dimension: if state == 0 { 3 } else { 2 },
            counts: if state == 0 { [5, 4, 4] } else { [8, 7, 1] },
            jitter: 0.25,
            horizons: Horizons::Uniform,
            materials: 1 + number % 2,
            plane_stress: state == 2,
            units: [number as i32 % 5 - 2, 6, 3],
            seed: 4000 + number as u64,
        };
        Body {
            scene: recipe.scene(),
            influences: [influence; 2],
            law: ["saint_venant_kirchhoff", "neo_hookean", "small_strain"][(number / 2) % 3],
            partial_volume: false,
        }
    })
}

/// Breaks a share of the bonds, and all bonds of every thirteenth point but one.
fn cut(body: &Body, simulation: &mut Simulation, share: f64) {
    let mut random = body.scene.random(78);
    let mut kept = vec![0; body.scene.count()];
    let mut broken = Vec::new();
    for (pair, _, _) in bonds(simulation) {
        let bare = pair.into_iter().filter(|point| point % 13 == 5).max();
        let spare = bare.is_some_and(|point| kept[point] > 0);
        if let Some(point) = bare {
            kept[point] += 1;
        }
        if spare || random.chance(share) {
            broken.push(pair);
        }
    }
    simulation.break_bonds(&broken).unwrap();
}

/// Has bonds computed on a level, or one by one.
fn compute_on(simulation: &mut Simulation, level: Option<SimdLevel>) {
    match level {
        Some(level) => simulation.set_simd(level).unwrap(),
        None => simulation.set_lanes(false).unwrap(),
    }
}

/// Weakens a share of the bonds.
fn weaken(body: &Body, simulation: &mut Simulation, share: f64) {
    let mut random = body.scene.random(79);
    let weak: Vec<_> = bonds(simulation)
        .into_iter()
        .filter(|(_, _, integrity)| *integrity > 0.0 && random.chance(share))
        .map(|(pair, ..)| pair)
        .collect();
    let values: Vec<_> = weak.iter().map(|_| random.between(0.1, 1.0)).collect();
    simulation.set_bond_integrity(&weak, &values).unwrap();
}

/// These, and bodies with unequal horizons, influence functions of two materials, and part volumes at the rim.
fn all_bodies() -> impl Iterator<Item = Body> {
    even_bodies().chain(bodies())
}

fn levels() -> impl Iterator<Item = SimdLevel> {
    SimdLevel::ALL.into_iter().filter(|level| level.is_available())
}

/// A body with a share of its bonds cut, on a level, or computed by the loops over single bonds.
fn ready(
    body: &Body,
    mut simulation: Simulation,
    level: Option<SimdLevel>,
    share: f64,
) -> Simulation {
    compute_on(&mut simulation, level);
    cut(body, &mut simulation, share);
    simulation
}

#[test]
fn every_level_gives_the_forces_of_single_bonds() {
    for body in all_bodies() {
        let moved = body.shaken();
        for form in forms(body.scene.dimension) {
            for share in [0.0, 0.3] {
                let force = |level: Option<SimdLevel>| {
                    let mut simulation = ready(&body, body.simulation(form), level, share);
                    simulation.set(Field::Displacement, &moved).unwrap();
                    simulation.evaluate().unwrap();
                    let force = simulation.get(Field::InternalForce).unwrap();
                    // What has been left by another cut must not matter.
                    cut(&body, &mut simulation, 0.05);
                    simulation.evaluate().unwrap();
                    [force, simulation.get(Field::InternalForce).unwrap()]
                };
                let expected = force(None);
                for level in levels() {
                    for (force, expected) in force(Some(level)).iter().zip(&expected) {
                        let error = apart(force, expected) / largest(expected);
                        assert!(error < 1e-12, "{form:?} {level:?} {share}: {error}");
                    }
                }
            }
        }
    }
}

/// What a body of one level shows beside the loops over single bonds, each over its largest.
fn worst_on_every_level(name: &str, shown: impl Fn(Option<SimdLevel>) -> Vec<Vec<f64>>) -> f64 {
    let expected = shown(None);
    let mut worst: f64 = 0.0;
    for level in levels() {
        for (number, (found, expected)) in shown(Some(level)).iter().zip(&expected).enumerate() {
            let error = apart(found, expected) / largest(expected).max(f64::MIN_POSITIVE);
            assert!(error.is_finite(), "{name} {level:?} {number}: {error}");
            worst = worst.max(error);
        }
    }
    worst
}

/// Looks at fields of all bodies in all forms, whole and cut, on every level.
fn check_fields(fields: &[Field], most: f64) {
    for body in all_bodies() {
        let moved = body.shaken();
        for form in forms(body.scene.dimension) {
            for share in [0.0, 0.3] {
                let name = format!("{form:?} {share}");
                let worst = worst_on_every_level(&name, |level| {
                    let mut simulation = ready(&body, body.simulation(form), level, share);
                    simulation.set(Field::Displacement, &moved).unwrap();
                    fields.iter().map(|field| simulation.get(*field).unwrap()).collect()
                });
                assert!(worst < most, "{name}: {worst}");
            }
        }
    }
}

#[test]
fn every_level_gives_the_energies_of_single_bonds() {
    check_fields(&[Field::StrainEnergyDensity, Field::StabilizationEnergyDensity], 1e-12);
}

#[test]
fn every_level_gives_the_fields_of_single_bonds() {
    let fields = [
        Field::DeformationGradient,
        Field::FirstPiolaStress,
        Field::VonMisesStress,
        Field::Dilatation,
    ];
    check_fields(&fields, 1e-11);
}

#[test]
fn every_level_gives_what_single_bonds_do_where_they_are_weakened() {
    let fields = [
        Field::InternalForce,
        Field::StrainEnergyDensity,
        Field::DeformationGradient,
        Field::FirstPiolaStress,
    ];
    for body in all_bodies() {
        let moved = body.shaken();
        for form in forms(body.scene.dimension) {
            let name = format!("{form:?}");
            let worst = worst_on_every_level(&name, |level| {
                let mut simulation = ready(&body, body.simulation(form), level, 0.1);
                let mut shown = Vec::new();
                for share in [0.5, 0.0, 1.0] {
                    // What has been left by other integrities must not matter.
                    weaken(&body, &mut simulation, share);
                    simulation.set(Field::Displacement, &moved).unwrap();
                    simulation.evaluate().unwrap();
                    shown.extend(fields.map(|field| simulation.get(field).unwrap()));
                }
                shown
            });
            assert!(worst < 1e-11, "{name}: {worst}");
        }
    }
}

/// bond_based has loops of its own.
#[test]
fn bonds_count_in_the_gradient_of_bond_based_as_in_that_of_a_constant_influence() {
    for body in bodies() {
        let gradient = |name| {
            let form = Form { name, order: 1 };
            let mut simulation = body.changed(form, |model| {
                if name != "bond_based" {
                    model.choose("influence", "constant").unwrap();
                }
            });
            let weak: Vec<_> =
                bonds(&simulation).into_iter().step_by(3).map(|bond| bond.0).collect();
            simulation.set_bond_integrity(&weak, &vec![0.4; weak.len()]).unwrap();
            simulation.set(Field::Displacement, &body.shaken()).unwrap();
            simulation.get(Field::DeformationGradient).unwrap()
        };
        let [found, expected] = ["bond_based", "ordinary_state_based"].map(gradient);
        let error = apart(&found, &expected);
        assert!(error < 1e-12, "{error}");
    }
}

/// Keys and what is chosen for them.
type Choices = &'static [(&'static str, &'static str)];

#[test]
fn deformed_bonds_and_strong_forms_pull_the_same_on_every_level() {
    let options: [(&str, u32, Choices); 7] = [
        ("total_lagrangian", 1, &[("operator_bonds", "deformed")]),
        ("total_lagrangian", 1, &[("divergence", "strong")]),
        ("total_lagrangian", 1, &[("operator_bonds", "deformed"), ("divergence", "strong")]),
        ("updated_lagrangian", 1, &[("operator_bonds", "undeformed"), ("divergence", "strong")]),
        ("updated_lagrangian", 1, &[("operator_bonds", "deformed"), ("divergence", "strong")]),
        ("correspondence", 1, &[("divergence", "strong")]),
        ("correspondence", 2, &[("divergence", "strong")]),
    ];
    for body in all_bodies() {
        let laws = [body.law, "hypoelastic"];
        for (law, (name, order, choices)) in
            laws.into_iter().flat_map(|law| options.map(|option| (law, option)))
        {
            let form = Form { name, order };
            let name = format!("{form:?} {choices:?} {law}");
            let worst = worst_on_every_level(&name, |level| {
                let simulation = body.changed(form, |model| {
                    model.choose("material", law).unwrap();
                    for (key, choice) in choices {
                        model.choose(key, choice).unwrap();
                    }
                });
                let mut simulation = ready(&body, simulation, level, 0.2);
                let moved = body.shaken();
                let less: Vec<f64> = moved.iter().map(|u| 0.5 * u).collect();
                simulation.set(Field::Displacement, &less).unwrap();
                simulation.commit(0.0).unwrap();
                simulation.set(Field::Displacement, &moved).unwrap();
                simulation.evaluate().unwrap();
                [Field::InternalForce, Field::StrainEnergyDensity]
                    .map(|field| simulation.get(field).unwrap())
                    .into()
            });
            assert!(worst < 1e-11, "{name}: {worst}");
        }
    }
}

#[test]
fn a_corrected_surface_is_the_same_on_every_level() {
    let corrections = ["energy", "stiffness_tensor"];
    for (body, correction) in all_bodies().flat_map(|body| corrections.map(|it| (body.clone(), it)))
    {
        let form = Form { name: "ordinary_state_based", order: 1 };
        let worst = worst_on_every_level("a corrected surface", |level| {
            let simulation =
                body.changed(form, |model| model.choose("surface_correction", correction).unwrap());
            let mut simulation = ready(&body, simulation, level, 0.2);
            simulation.set(Field::Displacement, &body.shaken()).unwrap();
            simulation.evaluate().unwrap();
            [Field::InternalForce, Field::StrainEnergyDensity]
                .map(|field| simulation.get(field).unwrap())
                .into()
        });
        assert!(worst < 1e-12, "{worst}");
    }
}

/// A law of the host's that softens by the largest stretch of an edge that a place has had.
fn soften(batch: &mut MaterialBatch<'_>) -> ControlFlow<()> {
    let MaterialBatch { count, now, state_before, state, stress, energy, .. } = batch;
    let square = now.len() / *count;
    let size = if square == 9 { 3 } else { 2 };
    for place in 0..*count {
        let own = place * square..(place + 1) * square;
        let strain =
            |k: usize| now[place * square + k] - f64::from(u8::from(k.is_multiple_of(size + 1)));
        let most = (0..square).map(|k| strain(k).abs()).fold(state_before[place], f64::max);
        state[place] = most;
        let stiffness = 1.0 / (1.0 + 10.0 * most);
        stress[own].iter_mut().enumerate().for_each(|(k, stress)| *stress = stiffness * strain(k));
        energy[place] = 0.5 * stiffness * (0..square).map(|k| strain(k).powi(2)).sum::<f64>();
    }
    ControlFlow::Continue(())
}

/// A law with memory, in place of one that has none.
fn choose(model: &mut Model, law: &str) {
    let modulus = model.get("youngs_modulus").unwrap();
    if law == "host" {
        return model.set_material_function(1, soften).unwrap();
    }
    model.choose("material", law).unwrap();
    if law == "j2_plastic" {
        model.set("yield_stress", 0.01 * modulus).unwrap();
        model.set("hardening_modulus", 0.1 * modulus).unwrap();
    }
}

#[test]
fn laws_with_memory_answer_the_same_on_every_level() {
    for (number, body) in all_bodies().step_by(2).enumerate() {
        let laws =
            [["hypoelastic"; 2], ["j2_plastic"; 2], ["host"; 2], ["j2_plastic", "neo_hookean"]];
        for form in forms(body.scene.dimension).filter(|form| form.has_law()) {
            for law in laws {
                let name = format!("{form:?} {law:?} {number}");
                let mut models =
                    [0, body.scene.materials.len() - 1].map(|number| body.model(form, number));
                models.iter_mut().zip(law).for_each(|(model, law)| choose(model, law));
                let worst = worst_after_steps(&name, &body, models);
                assert!(worst < 1e-11, "{name}: {worst}");
            }
        }
    }
}

#[test]
fn a_solid_that_flows_answers_the_same_on_every_level() {
    let form = Form { name: "ordinary_state_based", order: 1 };
    let solids = all_bodies().filter(|body| body.scene.dimension == 3);
    for (number, body) in solids.enumerate() {
        for (correction, flows) in
            [("none", [true; 2]), ("energy", [true, false]), ("stiffness_tensor", [true; 2])]
        {
            let name = format!("{correction} {flows:?} {number}");
            let mut models =
                [0, body.scene.materials.len() - 1].map(|number| body.model(form, number));
            for (model, flows) in models.iter_mut().zip(flows) {
                model.choose("surface_correction", correction).unwrap();
                if flows {
                    let modulus = model.get("youngs_modulus").unwrap();
                    model.set("yield_stress", 0.03 * modulus).unwrap();
                }
            }
            let worst = worst_after_steps(&name, &body, models);
            assert!(worst < 1e-11, "{name}: {worst}");
        }
    }
}

/// Largest difference between levels of what a body whose materials remember has come to, as its bonds break.
fn worst_after_steps(name: &str, body: &Body, mut models: [Model; 2]) -> f64 {
    for model in &mut models {
        model.set("critical_stretch", 0.14).unwrap();
    }
    worst_on_every_level(name, |level| {
        let mut simulation = Simulation::new(&body.scene.points(), &models[0]).unwrap();
        simulation.set_threads(1).unwrap();
        if !body.scene.second.is_empty() {
            simulation.assign_model("second", &models[1]).unwrap();
        }
        let mut simulation = ready(body, simulation, level, 0.1);
        let mut random = body.scene.random(31);
        for _ in 0..3 {
            let components = body.scene.components();
            let moved = random.around_zero(components, 0.05 * body.scene.spacing);
            simulation.set(Field::Displacement, &moved).unwrap();
            simulation.commit(0.0).unwrap();
        }
        let moved = body.shaken();
        simulation.set(Field::Displacement, &moved).unwrap();
        simulation.evaluate().unwrap();
        [
            Field::InternalForce,
            Field::StrainEnergyDensity,
            Field::DissipatedEnergyDensity,
            Field::CauchyStress,
            Field::PlasticStrain,
            Field::EquivalentPlasticStrain,
            Field::Damage,
        ]
        .map(|field| simulation.get(field).unwrap())
        .into()
    })
}

#[test]
fn every_level_breaks_the_same_bonds_and_books_the_same_loss() {
    for body in all_bodies().step_by(2) {
        let moved: Vec<f64> = body
            .scene
            .coordinates
            .iter()
            .map(|x| 0.02 * x)
            .zip(body.shaken())
            .map(|(x, y)| x + 0.5 * y)
            .collect();
        for form in forms(body.scene.dimension) {
            let step = 1e-3 * body.simulation(form).stable_time_step().unwrap();
            let torn = |level: Option<SimdLevel>| {
                let mut simulation =
                    body.changed(form, |model| drop(model.set("critical_stretch", 0.05)));
                compute_on(&mut simulation, level);
                simulation.set(Field::Displacement, &moved).unwrap();
                simulation.step(step, 1).unwrap();
                let health = simulation.health().unwrap();
                assert!(0 < health.broken_bonds && health.broken_bonds < health.bonds);
                [Field::Damage, Field::InternalForce, Field::DissipatedEnergyDensity]
                    .map(|field| simulation.get(field).unwrap())
            };
            let expected = torn(None);
            for level in levels() {
                let found = torn(Some(level));
                for (found, expected) in found.iter().zip(&expected) {
                    let error = apart(found, expected) / largest(expected);
                    assert!(error < 1e-11, "{form:?} {level:?}: {error}");
                }
            }
        }
    }
}

#[test]
fn threads_change_no_bit_of_any_formulation() {
    for dimension in [2, 3] {
        let recipe = Recipe {
            dimension,
            counts: if dimension == 3 { [11, 8, 7] } else { [30, 24, 1] },
            jitter: 0.25,
            horizons: Horizons::Uniform,
            materials: 2,
            plane_stress: false,
            units: [0, 6, 3],
            seed: 99,
        };
        let body = Body {
            scene: recipe.scene(),
            influences: ["conical"; 2],
            law: "saint_venant_kirchhoff",
            partial_volume: false,
        };
        let slow = |form: &Form| !["madenci_oterkus", "bond_associated"].contains(&form.name);
        for form in forms(dimension).filter(slow) {
            let mut expected = None;
            for threads in [1, 2, 3] {
                let mut simulation =
                    body.changed(form, |model| drop(model.set("critical_stretch", 0.03)));
                simulation.set_threads(threads).unwrap();
                let step = 0.5 * simulation.stable_time_step().unwrap();
                let speed = 0.03 * body.scene.spacing / step;
                simulation.prescribe("left", Quantity::Velocity, 0, -speed).unwrap();
                simulation.step(step, 5).unwrap();
                let health = simulation.health().unwrap();
                assert!(0 < health.broken_bonds && health.broken_bonds < health.bonds);
                let state = state_bits(&simulation);
                assert_eq!(expected.get_or_insert_with(|| state.clone()), &state, "{form:?}");
            }
        }
    }
}
