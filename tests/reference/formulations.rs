//! Every state-based formulation against the numbers of an independent code: forces and energies of deformed
//! clouds and lattices, intact and with broken bonds.

use crate::data::{assert_close, largest};
use perion::{Field, Model, Points, Simulation};
use serde_json::Value;

/// Sums of products of a hundred bonds with inverses of tensors of condition ten.
const TOLERANCE: f64 = 1e-11;
/// The moments of second order have a condition of three hundred, squared by what the reference does.
const SECOND_ORDER: f64 = 1e-9;

const FILES: [&str; 19] = [
    "mech2d_jitter_strain_broken",
    "mech2d_jitter_strain_intact",
    "mech2d_jitter_stress_broken",
    "mech2d_jitter_stress_intact",
    "mech3d_jitter_const_broken",
    "mech3d_jitter_const_intact",
    "mech3d_jitter_cubic_broken",
    "mech3d_jitter_cubic_intact",
    "mech3d_jitter_linear_broken",
    "mech3d_jitter_linear_intact",
    "mech3d_lattice_const",
    "mech3d_lattice_cubic",
    "mech3d_rk2_const",
    "mech3d_rk2_cubic",
    "tlul2d_jitter_linel",
    "tlul2d_jitter_svk",
    "tlul2d_lattice_linel",
    "tlul2d_lattice_svk",
    "tlul3d_jitter_svk",
];

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|it| it.as_f64().unwrap()).collect()
}

pub fn body(file: &Value, case: &Value) -> Simulation {
    let dimension = file["dimension"].as_u64().unwrap() as usize;
    let points =
        Points::new(dimension, &numbers(&file["positions"]), &numbers(&file["volumes"])).unwrap();
    let formulation = case["formulation"].as_str().unwrap();
    let mut model = Model::new(formulation).unwrap();
    model.set("density", 1.0).unwrap();
    for key in ["horizon", "youngs_modulus", "poissons_ratio", "lame_lambda", "shear_modulus"] {
        if let Some(value) = file.get(key) {
            model.set(key, value.as_f64().unwrap()).unwrap();
        }
    }
    if !["madenci_oterkus", "bond_based"].contains(&formulation) {
        model.choose("influence", file["influence"].as_str().unwrap()).unwrap();
    }
    if let Some(plane) = file["plane"].as_str() {
        model.choose("plane", plane).unwrap();
    }
    for (key, value) in case["options"].as_object().unwrap() {
        match (key.as_str(), value.as_str(), value.as_f64()) {
            ("bond_horizon", _, Some(number)) => {
                model.set(key, number * file["horizon"].as_f64().unwrap()).unwrap();
            }
            (_, Some(choice), _) => model.choose(key, choice).unwrap(),
            (_, _, number) => model.set(key, number.unwrap()).unwrap(),
        }
    }
    let mut body = Simulation::new(&points, &model).unwrap();
    let pairs: Vec<[usize; 2]> = file["broken_pairs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pair| [0, 1].map(|end| pair[end].as_u64().unwrap() as usize))
        .collect();
    // The reference takes its surface factors from the whole body: its broken bonds are damage, and not a
    // notch that was there before.
    if case["options"].get("surface_correction").is_some() {
        body.set_bond_integrity(&pairs, &vec![0.0; pairs.len()]).unwrap();
    } else {
        body.break_bonds(&pairs).unwrap();
    }
    body.set(Field::Position, &numbers(&file["current"])).unwrap();
    body
}

#[test]
fn forces_energies_and_deformations_of_all_formulations_are_those_of_the_reference() {
    let mut cases = 0;
    for name in FILES {
        let file = load(name);
        for (case, expected) in file["models"].as_object().unwrap() {
            let known = perion::FORMULATIONS.iter().any(|it| expected["formulation"] == it.name);
            assert!(known, "{name}, {case}");
            let body = body(&file, expected);
            let tolerance = if case.contains("rk2") { SECOND_ORDER } else { TOLERANCE };
            let what = |field: &str| format!("{name}, {case}, {field}");
            let force = body.get(Field::InternalForce).unwrap();
            assert_close(&what("force"), &force, &numbers(&expected["force"]), tolerance);
            for (key, field) in [
                ("energy", Field::StrainEnergyDensity),
                ("stabilization", Field::StabilizationEnergyDensity),
                ("dilatation", Field::Dilatation),
                ("gradient", Field::DeformationGradient),
            ] {
                let Some(values) = expected.get(key).map(numbers) else { continue };
                assert!(largest(&values) > 0.0);
                assert_close(&what(key), &body.get(field).unwrap(), &values, tolerance);
            }
            cases += 1;
        }
    }
    eprintln!("{cases} cases");
    assert!(cases > 100, "{cases}");
}

pub fn load(name: &str) -> Value {
    let path = format!("{}/tests/data/formulations/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub fn model_of(file: &Value, formulation: &str) -> Model {
    let mut model = Model::new(formulation).unwrap();
    for key in ["horizon", "youngs_modulus", "poissons_ratio", "density", "critical_stretch"] {
        match file[key].as_f64() {
            Some(value) => model.set(key, value).unwrap(),
            None if key == "density" => model.set(key, 1.0).unwrap(),
            None => {}
        }
    }
    if let Some(influence) = file["influence"].as_str() {
        model.choose("influence", influence).unwrap();
    }
    model
}

fn points_of(file: &Value) -> Points {
    let dimension = file["dimension"].as_u64().unwrap() as usize;
    Points::new(dimension, &numbers(&file["positions"]), &numbers(&file["volumes"])).unwrap()
}

/// Sixty steps of forces that agree to 1e-13 each.
const TRAJECTORY: f64 = 1e-8;

#[test]
fn sixty_steps_go_where_the_reference_goes_with_and_without_breaking() {
    for name in
        ["verlet_osb", "verlet_osb_fracture", "verlet_cc", "verlet_baqp", "verlet_baqp_fracture"]
    {
        let file = load(name);
        let model = model_of(&file, file["formulation"].as_str().unwrap());
        let mut body = Simulation::new(&points_of(&file), &model).unwrap();
        body.set(Field::Velocity, &numbers(&file["initial_velocity"])).unwrap();
        let (kinetic, strain) = (numbers(&file["kinetic_energy"]), numbers(&file["strain_energy"]));
        let broken = numbers(&file["broken_ends"]);
        let step = file["time_step"].as_f64().unwrap();
        for number in 0..file["steps"].as_u64().unwrap() as usize {
            body.step(step, 1).unwrap();
            let energy = body.energy().unwrap();
            let total = kinetic[number] + strain[number];
            assert!(
                (energy.kinetic - kinetic[number]).abs() < TRAJECTORY * total,
                "{name}, {number}"
            );
            assert!(
                (energy.elastic - strain[number]).abs() < TRAJECTORY * total,
                "{name}, {number}"
            );
            let ends = 2 * body.health().unwrap().broken_bonds;
            assert_eq!(ends as f64, broken[number], "{name}, step {number}");
        }
        assert!(name.ends_with("fracture") == (broken[broken.len() - 1] > 0.0), "{name}");
        for (field, key) in
            [(Field::Position, "current"), (Field::Velocity, "velocity"), (Field::Damage, "damage")]
        {
            let expected = numbers(&file[key]);
            let found = body.get(field).unwrap();
            if largest(&expected) == 0.0 {
                assert_eq!(found, expected, "{name}, {key}");
            } else {
                assert_close(&format!("{name}, {key}"), &found, &expected, TRAJECTORY);
            }
        }
    }
}

#[test]
fn partial_integrities_weigh_bonds_as_in_the_reference() {
    let file = load("baqp_continuous_damage");
    let model = model_of(&file, "bond_associated_quadrature");
    let mut body = Simulation::new(&points_of(&file), &model).unwrap();
    let pairs: Vec<[usize; 2]> = file["pairs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pair| [0, 1].map(|end| pair[end].as_u64().unwrap() as usize))
        .collect();
    body.set_bond_integrity(&pairs, &numbers(&file["integrity"])).unwrap();
    body.set(Field::Position, &numbers(&file["current"])).unwrap();
    for (field, key) in [(Field::InternalForce, "force"), (Field::StrainEnergyDensity, "energy")] {
        assert_close(key, &body.get(field).unwrap(), &numbers(&file[key]), TOLERANCE);
    }
}

/// A displacement whose sign changes from point to point [P 4.44] costs nothing where a gradient does not see
/// it.
#[test]
fn the_checkerboard_costs_what_it_should() {
    let (count, spacing) = (14, 0.025);
    let edge = count as f64 * spacing;
    let lower = [-0.5 * spacing; 3];
    let points = Points::block(3, &lower, &lower.map(|x| x + edge), spacing).unwrap();
    let amplitude = 1e-3 * spacing;
    let shift: Vec<f64> = points
        .coordinates()
        .chunks(3)
        .flat_map(|place| {
            let sign = |axis: usize| {
                if (place[axis] / spacing).round() as i64 % 2 == 0 { 1.0 } else { -1.0 }
            };
            let (x, y, z) = (sign(0), sign(1), sign(2));
            [y * z, x * z, x * y].map(|sign| sign * amplitude)
        })
        .collect();
    // In the middle, two horizons from every face.
    let middle = |place: &[f64]| place.iter().all(|x| (x / spacing - 6.5).abs() < 0.6);
    let at = points.coordinates().chunks(3).position(middle).unwrap();
    let density = |formulation: &str, influence: &str, field: Field| {
        let mut model = Model::new(formulation).unwrap();
        for (key, value) in
            [("density", 1.0), ("horizon", 3.015 * spacing), ("youngs_modulus", 210e9)]
        {
            model.set(key, value).unwrap();
        }
        if formulation != "bond_based" {
            model.set("poissons_ratio", 0.25).unwrap();
            model.choose("influence", influence).unwrap();
        }
        let mut body = Simulation::new(&points, &model).unwrap();
        body.set(Field::Displacement, &shift).unwrap();
        body.get(field).unwrap()[at]
    };
    let quadrature =
        |influence| density("bond_associated_quadrature", influence, Field::StrainEnergyDensity);
    for (found, expected) in [
        (quadrature("constant"), 1.037664e5),
        (quadrature("inverse"), 1.324901e5),
        (quadrature("cubic_spline"), 2.510877e5),
        (density("bond_based", "", Field::StrainEnergyDensity), 2.664566e5),
    ] {
        // As many digits as the figures have.
        assert!((found / expected - 1.0).abs() < 1e-5, "{found}, not {expected}");
    }
    for formulation in ["correspondence", "correspondence_silling", "correspondence_wan"] {
        let found = density(formulation, "constant", Field::StrainEnergyDensity);
        assert!(found < 1e-12 * 1.037664e5, "{formulation}: {found}");
        let penalty = density(formulation, "constant", Field::StabilizationEnergyDensity);
        assert_eq!(penalty > 1e3, formulation != "correspondence", "{formulation}: {penalty}");
    }
}
