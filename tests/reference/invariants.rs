//! What needs no other code to be known: affine, rigid and quadratic motions of the reference's clouds.

use super::formulations::{load, model_of, numbers};
use crate::data::{assert_close, largest};
use perion::{Field, Points, Simulation};
use serde_json::Value;

/// A formulation with an order of gradient, where it has one.
fn moved(file: &Value, formulation: &str, order: Option<f64>) -> Simulation {
    let points = Points::new(3, &numbers(&file["positions"]), &numbers(&file["volumes"])).unwrap();
    let mut file = file.clone();
    if formulation == "bond_based" {
        file["poissons_ratio"] = Value::Null;
    }
    if ["bond_based", "madenci_oterkus"].contains(&formulation) {
        file["influence"] = Value::Null;
    }
    let mut model = model_of(&file, formulation);
    if let Some(order) = order {
        model.set("gradient_order", order).unwrap();
    }
    let mut body = Simulation::new(&points, &model).unwrap();
    body.set(Field::Position, &numbers(&file["current"])).unwrap();
    body
}

const OF_A_LAW: [(&str, Option<f64>); 9] = [
    ("correspondence", Some(1.0)),
    ("correspondence", Some(2.0)),
    ("correspondence_silling", None),
    ("correspondence_wan", None),
    ("bond_associated", None),
    ("bond_associated_quadrature", Some(1.0)),
    ("bond_associated_quadrature", Some(2.0)),
    ("total_lagrangian", None),
    ("updated_lagrangian", None),
];

#[test]
fn an_affine_motion_is_exact_at_every_point() {
    let file = load("affine3d");
    let count = file["volumes"].as_array().unwrap().len();
    for (formulation, order) in OF_A_LAW {
        let body = moved(&file, formulation, order);
        for (key, field) in [
            ("gradient", Field::DeformationGradient),
            ("first_piola_stress", Field::FirstPiolaStress),
            ("cauchy_stress", Field::CauchyStress),
        ] {
            let what = format!("{formulation} {order:?} {key}");
            let expected = numbers(&file[key]).repeat(count);
            assert_close(&what, &body.get(field).unwrap(), &expected, 1e-11);
        }
        let energy = vec![file["energy"].as_f64().unwrap(); count];
        let what = format!("{formulation} {order:?} energy");
        assert_close(&what, &body.get(Field::StrainEnergyDensity).unwrap(), &energy, 1e-11);
    }
}

#[test]
fn a_rigid_motion_stores_nothing_and_pulls_on_nothing() {
    let file = load("../rigid3d");
    let [horizon, young, ratio] =
        ["horizon", "youngs_modulus", "poissons_ratio"].map(|key| file[key].as_f64().unwrap());
    let bulk = young / (3.0 - 6.0 * ratio);
    for entry in &perion::FORMULATIONS {
        let body = moved(&file, entry.name, None);
        let energy = largest(&body.get(Field::StrainEnergyDensity).unwrap());
        let force = largest(&body.get(Field::InternalForce).unwrap());
        assert!(energy < 1e-12 * young, "{} {energy:e}", entry.name);
        assert!(force < 1e-11 * bulk / horizon, "{} {force:e}", entry.name);
    }
}

#[test]
fn a_quadratic_motion_is_exact_in_second_order() {
    let file = load("rk2_quadratic_exact");
    let body = moved(&file, "correspondence", Some(2.0));
    let found = body.get(Field::DeformationGradient).unwrap();
    assert_close("second order", &found, &numbers(&file["gradient"]), 1e-9);
    // First order is not exact, or this would show nothing.
    let first = moved(&file, "correspondence", Some(1.0)).get(Field::DeformationGradient).unwrap();
    let off: Vec<f64> = first.iter().zip(&found).map(|(a, b)| a - b).collect();
    assert!(largest(&off) > 1e-3);
}
