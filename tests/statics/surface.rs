//! Tractions on both ends of a bar that is held along its axis in the middle alone, so that the one-dimensional
//! solution is exact.

use crate::bars::{mean_along, svk_strain};
use perion::{Error, Field, Model, Points, Quantity, Simulation, SolveOptions};

const STRESS: f64 = 1e-2;

/// A bar of so many points across, along (an odd number) and in a horizon, of spacing 1 and modulus 1.
pub struct Bar {
    pub across: usize,
    pub along: usize,
    pub ratio: usize,
}

impl Bar {
    fn points(&self) -> Points {
        let [along, across] = [self.along as f64, self.across as f64];
        let mut points = Points::block(3, &[0.0; 3], &[along, across, across], 1.0).unwrap();
        let middle = 0.5 * (along - 1.0);
        let mut layer = |name: &str, from: f64| {
            points.add_set_box(name, &[from, 0.0, 0.0], &[from + 1.0, across, across]).unwrap();
        };
        layer("near", 0.0);
        layer("middle", middle);
        layer("far", along - 1.0);
        points.add_set_box("pin", &[middle, 0.0, 0.0], &[middle + 1.0, 1.0, 1.0]).unwrap();
        points
            .add_set_box("guide", &[middle, across - 1.0, 0.0], &[middle + 1.0, across, 1.0])
            .unwrap();
        points
    }

    /// Of modulus 1 and ratio 1/4.
    fn model(&self, formulation: &str, choices: &[(&str, &str)]) -> Model {
        let mut model = Model::new(formulation).unwrap();
        for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("poissons_ratio", 0.25)] {
            model.set(key, value).unwrap();
        }
        model.set("horizon", 1.005 * self.ratio as f64).unwrap();
        for (key, choice) in choices {
            model.choose(key, choice).unwrap();
        }
        model
    }

    pub fn loaded(&self, model: &Model, stress: f64) -> Simulation {
        let mut bar = Simulation::new(&self.points(), model).unwrap();
        bar.prescribe("middle", Quantity::Displacement, 0, 0.0).unwrap();
        for (set, axis) in [("pin", 1), ("pin", 2), ("guide", 2)] {
            bar.prescribe(set, Quantity::Displacement, axis, 0.0).unwrap();
        }
        bar.prescribe("near", Quantity::Traction, 0, -stress).unwrap();
        bar.prescribe("far", Quantity::Traction, 0, stress).unwrap();
        bar
    }

    /// What it has grown by over what lies between its end layers.
    pub fn strain(&self, bar: &Simulation) -> f64 {
        (mean_along(bar, "far") - mean_along(bar, "near")) / (self.along - 1) as f64
    }

    /// Error of what the bar has grown by, in percent.
    fn error(&self, formulation: &str, choices: &[(&str, &str)]) -> f64 {
        let mut bar = self.loaded(&self.model(formulation, choices), STRESS);
        let report = bar.solve(&SolveOptions::default()).unwrap();
        let error = 100.0 * (self.strain(&bar) / svk_strain(STRESS, 1.0) - 1.0);
        let Self { across, ratio, .. } = self;
        let forces = report.evaluations;
        println!("{formulation} {choices:?} ({across},{ratio}): {error:.6} %, {forces} forces");
        error
    }
}

const BAQP: &str = "bond_associated_quadrature";
const SPLINE: [(&str, &str); 1] = [("influence", "cubic_spline")];

#[test]
fn bars_of_any_horizon_grow_as_they_should_under_tractions() {
    for (across, along, ratio) in [(3, 31, 3), (5, 51, 2), (5, 51, 3), (5, 51, 5), (10, 101, 3)] {
        let bar = Bar { across, along, ratio };
        let error = bar.error(BAQP, &SPLINE);
        assert!(error.abs() < 1e-3, "({across},{ratio}): {error} %");
    }
    let bar = Bar { across: 3, along: 31, ratio: 3 };
    for formulation in ["correspondence", "correspondence_wan"] {
        let error = bar.error(formulation, &[("influence", "inverse")]);
        assert!(error.abs() < 1e-3, "{formulation}: {error} %");
    }
}

/// What forms without a gradient are off by near surfaces is theirs, and no longer that of the load.
#[test]
fn the_energy_correction_brings_bonds_near_their_modulus() {
    let bar = Bar { across: 5, along: 51, ratio: 3 };
    let energy = ("surface_correction", "energy");
    for (formulation, choices, most) in [
        ("bond_based", &[energy][..], 6.0),
        ("ordinary_state_based", &[("influence", "inverse"), energy], 6.0),
    ] {
        let error = bar.error(formulation, choices);
        assert!(error.abs() < most, "{formulation}: {error} %");
    }
}

#[test]
fn tractions_make_the_force_that_stress_and_area_are() {
    let bar = Bar { across: 4, along: 21, ratio: 3 };
    for formulation in perion::FORMULATIONS.iter().map(|known| known.name) {
        let mut body = bar.loaded(&bar.model(formulation, &[]), STRESS);
        body.evaluate().unwrap();
        let of = |set: &str| body.sum(Field::BodyForce, Some(set)).unwrap()[0];
        let whole = body.sum(Field::BodyForce, None).unwrap();
        assert!(whole.iter().all(|force| force.abs() < 1e-9 * STRESS), "{formulation}: {whole:?}");
        assert!(of("far") > 0.3 * 16.0 * STRESS, "{formulation}");
        let values = body.get(Field::BodyForce).unwrap();
        let half: f64 = values.iter().filter(|value| **value > 0.0).sum();
        println!("{formulation}: {} of the area", half / (16.0 * STRESS));
        // Given areas, the force is theirs to rounding.
        body.set_surface_areas("far", &[2.0; 16]).unwrap();
        body.release("near", Quantity::Traction, 0).unwrap();
        body.evaluate().unwrap();
        let whole = body.sum(Field::BodyForce, None).unwrap()[0];
        assert!((whole / (32.0 * STRESS) - 1.0).abs() < 1e-12, "{formulation}: {whole}");
    }
}

#[test]
fn areas_are_positive_and_one_for_each_point() {
    let bar = Bar { across: 2, along: 11, ratio: 2 };
    let mut body = bar.loaded(&bar.model("bond_based", &[]), STRESS);
    for areas in [&[1.0; 3][..], &[1.0, 1.0, 0.0, 1.0], &[1.0, f64::NAN, 1.0, 1.0]] {
        assert!(matches!(body.set_surface_areas("far", areas), Err(Error::Argument(_))));
    }
    assert!(matches!(body.set_surface_areas("nowhere", &[1.0; 4]), Err(Error::Argument(_))));
}
