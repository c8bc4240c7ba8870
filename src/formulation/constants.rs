//! What formulations make of a model's elastic constants, and the critical stretch that follows from an energy
//! release rate.

use std::f64::consts::PI;

use crate::error::{Error, Result};
use crate::model::{Elastic, Model, Plane};

/// Whether a model has what a law needs.
pub(super) fn check_law(model: &Model, _: usize) -> Result<()> {
    model.elastic().map(|_| ())
}

/// The stretch at which opening a unit of crack takes the energy `rate`, by the energy that bonds hold
/// under isotropic stretch s: psi = D^2 kappa s^2 w xi^2/m, G = pi int psi xi^3 in 3D and 2 h int psi xi^2
/// in 2D; m = int w xi^2 over the family.
pub(super) fn critical_stretch(
    model: &Model,
    dimension: usize,
    horizon: f64,
    rate: f64,
) -> Result<f64> {
    let (kappa, influence) = (bulk_modulus(model, dimension)?, model.influence());
    // int_0^1 omega q^n
    let moment =
        |power: i32| integral(|q| influence.value(dimension, q * horizon, horizon) * q.powi(power));
    let per_square = if dimension == 3 {
        9.0 * kappa * horizon * PI * moment(5) / (4.0 * PI * moment(4))
    } else {
        4.0 * kappa * horizon * 2.0 * moment(4) / (2.0 * PI * moment(3))
    };
    usable((rate / per_square).sqrt(), horizon)
}

/// A critical stretch that is a number.
pub(super) fn usable(stretch: f64, horizon: f64) -> Result<f64> {
    if stretch > 0.0 && stretch.is_finite() {
        return Ok(stretch);
    }
    Err(Error::Argument(format!(
        "the elastic constants with 'horizon' {horizon} give the critical stretch {stretch}, out of the \
         range of numbers; use other units"
    )))
}

/// C_b: force per volume squared at stretch 1 of the bonds that hold what a solid does. [P 3.9]
pub(super) fn bond_constant(
    elastic: &Elastic,
    model: &Model,
    dimension: usize,
    horizon: f64,
) -> f64 {
    let thickness = model.number("thickness").unwrap_or(1.0);
    match (dimension, model.plane()) {
        (3, _) => 18.0 * elastic.bulk_modulus / (PI * horizon.powi(4)),
        (_, Plane::Stress) => 9.0 * elastic.youngs_modulus / (PI * thickness * horizon.powi(3)),
        (_, Plane::Strain) => {
            48.0 * elastic.youngs_modulus / (5.0 * PI * thickness * horizon.powi(3))
        }
    }
}

/// kappa: K in 3D, lambda + mu of the plane state in 2D.
pub(super) fn bulk_modulus(model: &Model, dimension: usize) -> Result<f64> {
    let elastic = model.elastic()?;
    Ok(if dimension == 3 {
        elastic.bulk_modulus
    } else {
        elastic.plane_lambda(model.plane()) + elastic.shear_modulus
    })
}

/// lambda/2 + mu of the plane state.
pub(super) fn half_lambda_and_mu(model: &Model, dimension: usize) -> Result<f64> {
    let elastic = model.elastic()?;
    let lambda =
        if dimension == 3 { elastic.lame_lambda } else { elastic.plane_lambda(model.plane()) };
    Ok(0.5 * lambda + elastic.shear_modulus)
}

/// The integral over [0, 1] of a function that is a polynomial on each half: by Gauss's rule of five points.
pub(super) fn integral(function: impl Fn(f64) -> f64) -> f64 {
    const RULE: [(f64, f64); 5] = [
        (0.046_910_077_030_668, 0.118_463_442_528_094_54),
        (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
        (0.5, 0.284_444_444_444_444_45),
        (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
        (0.953_089_922_969_332, 0.118_463_442_528_094_54),
    ];
    let half = |from: f64| {
        RULE.iter().map(|&(at, weight)| 0.5 * weight * function(from + 0.5 * at)).sum::<f64>()
    };
    half(0.0) + half(0.5)
}
