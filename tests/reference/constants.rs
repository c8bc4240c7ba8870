//! Moduli, bond constants and critical stretches, read off two points and their bond.

use crate::data::{Reference, assert_near, pair};
use perion::{Elastic, Field, Model, Simulation};
use serde_json::Value;
use std::f64::consts::PI;

/// Nothing is summed: what is left are a dozen roundings of 1e-16, on either side.
const TOLERANCE: f64 = 4e-15;

/// One row of the file, by key.
fn rows() -> Vec<impl Fn(&str) -> f64> {
    let rows = Reference::load("scalars").value("rows").as_array().unwrap().clone();
    rows.into_iter()
        .map(|row| move |key: &str| row.get(key).and_then(Value::as_f64).unwrap())
        .collect()
}

/// A body of two points in 3D, plane strain or plane stress.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Solid,
    Strain,
    Stress,
}

impl Form {
    fn dimension(self) -> usize {
        if self == Self::Solid { 3 } else { 2 }
    }

    fn model(self, horizon: f64) -> Model {
        let mut model = Model::new("bond_based").unwrap();
        model.set("density", 1.0).unwrap();
        model.set("horizon", horizon).unwrap();
        match self {
            Self::Solid => {}
            Self::Strain => model.choose("plane", "strain").unwrap(),
            Self::Stress => model.choose("plane", "stress").unwrap(),
        }
        model
    }
}

/// Two points half a horizon apart, of volume 1, their bond stretched by `stretch`.
fn stretched(form: Form, model: &Model, horizon: f64, stretch: f64) -> Simulation {
    let dimension = form.dimension();
    let mut two = Simulation::new(&pair(dimension, 0.5 * horizon), model).unwrap();
    let mut shift = vec![0.0; 2 * dimension];
    shift[dimension] = stretch * 0.5 * horizon;
    two.set(Field::Displacement, &shift).unwrap();
    two
}

/// Force on the first point over the stretch: the bond constant, since the volume is 1.
fn bond_constant(form: Form, model: &Model, horizon: f64) -> f64 {
    let stretch = 1.0 / 1024.0;
    let two = stretched(form, model, horizon, stretch);
    two.get(Field::InternalForce).unwrap()[0] / stretch
}

/// Whether the bond breaks a rounding or a few above the critical stretch and not below.
#[track_caller]
fn assert_breaks_at(critical: f64, form: Form, model: &Model, horizon: f64) {
    for (factor, damage) in [(1.0 - 1e-14, 0.0), (1.0 + 1e-14, 1.0)] {
        let mut two = stretched(form, model, horizon, factor * critical);
        two.commit(0.0).unwrap();
        assert_eq!(two.get(Field::Damage).unwrap(), [damage; 2], "{form:?}, factor {factor}");
    }
}

#[test]
fn moduli_follow_from_youngs_modulus_and_poissons_ratio() {
    for row in rows() {
        let elastic = Elastic::new(row("youngs_modulus"), row("poissons_ratio"));
        assert_near("K", elastic.bulk_modulus, row("bulk_modulus"), TOLERANCE);
        assert_near("G", elastic.shear_modulus, row("shear_modulus"), TOLERANCE);
        assert_near("lambda", elastic.lame_lambda, row("lame_lambda"), TOLERANCE);
    }
}

#[test]
fn the_bond_constant_of_a_solid_is_that_of_its_bulk_modulus() {
    for row in rows() {
        let horizon = row("horizon");
        let mut model = Form::Solid.model(horizon);
        model.set("bulk_modulus", row("bulk_modulus")).unwrap();
        let found = bond_constant(Form::Solid, &model, horizon);
        assert_near("c", found, row("bond_constant"), TOLERANCE);
    }
}

/// Whatever constant is given, with nu = 1/4 all of them describe one solid.
#[test]
fn every_elastic_constant_gives_the_same_bond_constant() {
    for row in rows().into_iter().filter(|row| row("poissons_ratio") == 0.25) {
        let horizon = row("horizon");
        for key in ["youngs_modulus", "bulk_modulus", "shear_modulus", "lame_lambda"] {
            let mut model = Form::Solid.model(horizon);
            model.set(key, row(key)).unwrap();
            let found = bond_constant(Form::Solid, &model, horizon);
            assert_near(key, found, row("bond_constant"), TOLERANCE);
        }
    }
}

#[test]
fn the_bond_constant_of_a_plate_is_that_of_youngs_modulus() {
    for row in rows() {
        let (horizon, modulus) = (row("horizon"), row("youngs_modulus"));
        let cube = horizon.powi(3);
        for (form, expected) in [
            (Form::Strain, 48.0 * modulus / (5.0 * PI * cube)),
            (Form::Stress, 9.0 * modulus / (PI * cube)),
        ] {
            let mut model = form.model(horizon);
            model.set("youngs_modulus", modulus).unwrap();
            assert_near("c", bond_constant(form, &model, horizon), expected, TOLERANCE);
        }
    }
}

#[test]
fn a_bond_of_a_solid_breaks_at_the_stretch_of_its_energy_release_rate() {
    for row in rows() {
        let horizon = row("horizon");
        let mut model = Form::Solid.model(horizon);
        model.set("bulk_modulus", row("bulk_modulus")).unwrap();
        model.set("critical_energy_release_rate", row("critical_energy_release_rate")).unwrap();
        assert_breaks_at(row("critical_stretch"), Form::Solid, &model, horizon);
    }
}

#[test]
fn a_bond_of_a_plate_breaks_at_the_stretch_of_its_energy_release_rate() {
    for row in rows() {
        let (horizon, modulus) = (row("horizon"), row("youngs_modulus"));
        let rate = row("critical_energy_release_rate");
        for (form, critical) in [
            (Form::Strain, (5.0 * PI * rate / (12.0 * modulus * horizon)).sqrt()),
            (Form::Stress, (4.0 * PI * rate / (9.0 * modulus * horizon)).sqrt()),
        ] {
            for thickness in [1.0, 0.3] {
                let mut model = form.model(horizon);
                model.set("youngs_modulus", modulus).unwrap();
                model.set("critical_energy_release_rate", rate).unwrap();
                model.set("thickness", thickness).unwrap();
                assert_breaks_at(critical, form, &model, horizon);
            }
        }
    }
}

#[test]
fn a_bond_breaks_at_the_critical_stretch_that_was_set() {
    for row in rows() {
        let horizon = row("horizon");
        for form in [Form::Solid, Form::Strain, Form::Stress] {
            let mut model = form.model(horizon);
            model.set("youngs_modulus", row("youngs_modulus")).unwrap();
            model.set("critical_stretch", row("critical_stretch")).unwrap();
            assert_breaks_at(row("critical_stretch"), form, &model, horizon);
        }
    }
}

/// Peridynamics codes check themselves by these two points.
#[test]
fn two_points_a_metre_apart_pull_with_the_force_known_from_other_codes() {
    let horizon: f64 = 1.5;
    let mut model = Form::Solid.model(horizon);
    model.set("youngs_modulus", 210e9).unwrap();
    model.set("poissons_ratio", 0.25).unwrap();
    let mut two = Simulation::new(&pair(3, 1.0), &model).unwrap();
    two.set(Field::Position, &[0.0, 0.0, 0.0, 1.0015, 0.0, 0.0]).unwrap();
    let force = two.get(Field::InternalForce).unwrap();
    let expected = 18.0 * 140e9 / (PI * horizon.powi(4)) * 0.0015;
    // Half a unit in the last place of 1.0015, over 0.0015: 7.4e-14.
    assert_near("pull", force[0], expected, 1e-13);
    assert_eq!(force, [force[0], 0.0, 0.0, -force[0], 0.0, 0.0]);
    let density = 0.25 * expected * 0.0015;
    // Twice that, since the stretch enters squared.
    for found in two.get(Field::StrainEnergyDensity).unwrap() {
        assert_near("energy", found, density, 2e-13);
    }
}
