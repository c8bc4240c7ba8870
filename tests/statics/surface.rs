//! Tractions on both ends of a bar that is held along its axis in the middle alone, so that the one-dimensional
//! solution is exact.

use crate::bars::{PulledBar as Bar, svk_strain};
use perion::{Error, Field, Model, Quantity, Simulation, SolveOptions};

const STRESS: f64 = 1e-2;

impl Bar {
    /// Of modulus 1 and ratio 1/4.
    fn model(&self, formulation: &str, choices: &[(&str, &str)]) -> Model {
        let mut model = Model::new(formulation).unwrap();
        for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("poissons_ratio", 0.25)] {
            model.set(key, value).unwrap();
        }
        model.set("horizon", self.horizon()).unwrap();
        for (key, choice) in choices {
            model.choose(key, choice).unwrap();
        }
        model
    }

    pub fn loaded(&self, model: &Model, stress: f64) -> Simulation {
        self.simulation(model, stress).unwrap()
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
fn corrected_surfaces_bring_bonds_near_their_modulus() {
    let bar = Bar { across: 5, along: 51, ratio: 3 };
    let [energy, tensor] =
        ["energy", "stiffness_tensor"].map(|correction| ("surface_correction", correction));
    let inverse = ("influence", "inverse");
    for (formulation, choices, most) in [
        ("bond_based", &[energy][..], 6.0),
        ("ordinary_state_based", &[inverse, energy], 6.0),
        ("bond_based", &[tensor], 2.0),
        ("ordinary_state_based", &[inverse, tensor], 2.0),
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
