//! The hyperelastic bar of [B], example II: lambda = 200, mu = 20, weak total and updated Lagrangian forms. A traction of
//! 0.590575 stretches it by 0.01, one of 14 by 0.1857.

use crate::bars::PulledBar as Bar;
use crate::bars::svk_strain;
use perion::{Model, SolveOptions};

const LAMBDA: f64 = 200.0;
const MU: f64 = 20.0;

fn grown(formulation: &str, traction: f64) -> f64 {
    let bar = Bar { across: 5, along: 43, ratio: 2 };
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in
        [("density", 1.4), ("lame_lambda", LAMBDA), ("shear_modulus", MU), ("horizon", 2.01)]
    {
        model.set(key, value).unwrap();
    }
    model.choose("material", "saint_venant_kirchhoff").unwrap();
    let mut body = bar.loaded(&model, traction);
    let report = body.solve(&SolveOptions::default()).unwrap();
    println!("{formulation} {traction}: {} steps, {} forces", report.steps, report.evaluations);
    bar.strain(&body)
}

#[test]
fn weak_forms_are_stretched_as_the_one_dimensional_bar_is() {
    let modulus = MU * (3.0 * LAMBDA + 2.0 * MU) / (LAMBDA + MU);
    assert!((svk_strain(0.590_575, modulus) - 0.01).abs() < 1e-7);
    for formulation in ["total_lagrangian", "updated_lagrangian"] {
        let little = grown(formulation, 0.590_575);
        assert!((0.0099..=0.0101).contains(&little), "{formulation}: {little}");
        let much = grown(formulation, 14.0);
        assert!((much / 0.1857 - 1.0).abs() < 0.01, "{formulation}: {much}");
    }
}
