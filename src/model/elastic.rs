//! Elastic constants from any two of them, and what plane states make of them.

use crate::error::{Result, argument};

/// What lies across a two-dimensional body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
    /// No strain across: a slice of a long body.
    Strain,
    /// No stress across: a thin plate.
    Stress,
}

/// The constants of an isotropic linear elastic solid, in units of stress but for Poisson's ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elastic {
    /// Young's modulus E.
    pub youngs_modulus: f64,
    /// Poisson's ratio nu.
    pub poissons_ratio: f64,
    /// Bulk modulus K (of the three-dimensional solid).
    pub bulk_modulus: f64,
    /// Shear modulus mu.
    pub shear_modulus: f64,
    /// First Lamé constant lambda.
    pub lame_lambda: f64,
}

/// The constants that a host may give, as far as it gave them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GivenConstants {
    pub(crate) youngs_modulus: Option<f64>,
    pub(crate) poissons_ratio: Option<f64>,
    pub(crate) bulk_modulus: Option<f64>,
    pub(crate) shear_modulus: Option<f64>,
    pub(crate) lame_lambda: Option<f64>,
}

impl Elastic {
    /// From Young's modulus and Poisson's ratio.
    pub fn new(youngs_modulus: f64, poissons_ratio: f64) -> Self {
        let (e, nu) = (youngs_modulus, poissons_ratio);
        let shear_modulus = e / (2.0 * (1.0 + nu));
        let bulk_modulus = e / (3.0 * (1.0 - 2.0 * nu));
        let lame_lambda = bulk_modulus - 2.0 * shear_modulus / 3.0;
        Self { youngs_modulus: e, poissons_ratio: nu, bulk_modulus, shear_modulus, lame_lambda }
    }

    fn with_moduli(bulk_modulus: f64, shear_modulus: f64) -> Self {
        let (k, g) = (bulk_modulus, shear_modulus);
        Self {
            youngs_modulus: 9.0 * k * g / (3.0 * k + g),
            poissons_ratio: (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g)),
            bulk_modulus,
            shear_modulus,
            lame_lambda: k - 2.0 * g / 3.0,
        }
    }

    /// From two constants.
    pub(crate) fn from_two(given: &GivenConstants) -> Result<Self> {
        given.check_count()?;
        if given.count() < 2 {
            return argument(
                "the model needs two elastic constants; set two of 'youngs_modulus', 'poissons_ratio', \
                 'bulk_modulus', 'shear_modulus' and 'lame_lambda'",
            );
        }
        let nu = given.poisson_ratio_of_two();
        let constants = match (given.bulk_modulus, given.shear_modulus) {
            (Some(k), Some(g)) => Self::with_moduli(k, g),
            _ => {
                let by = |scale: f64, constant: Option<f64>| constant.map(|value| value * scale);
                let youngs_modulus = given
                    .youngs_modulus
                    .or(by(3.0 * (1.0 - 2.0 * nu), given.bulk_modulus))
                    .or(by(2.0 * (1.0 + nu), given.shear_modulus))
                    .or(by((1.0 + nu) * (1.0 - 2.0 * nu) / nu, given.lame_lambda));
                Self::new(youngs_modulus.unwrap_or(f64::NAN), nu)
            }
        };
        let Self { youngs_modulus, poissons_ratio, .. } = constants;
        let sound = youngs_modulus > 0.0
            && youngs_modulus.is_finite()
            && -1.0 < poissons_ratio
            && poissons_ratio < 0.5;
        if sound {
            return Ok(constants);
        }
        argument(format!(
            "the elastic constants of the model give Young's modulus {youngs_modulus} and Poisson's ratio \
             {poissons_ratio}; they must be positive, and between -1 and 1/2"
        ))
    }

    /// From one constant and a Poisson's ratio that the formulation fixes; a second constant must
    /// agree with it.
    pub(crate) fn with_fixed_ratio(
        given: &GivenConstants,
        ratio: f64,
        reason: &str,
    ) -> Result<Self> {
        given.check_count()?;
        let nu = ratio;
        let youngs_modulus = if let Some(e) = given.youngs_modulus {
            e
        } else if let Some(k) = given.bulk_modulus {
            3.0 * k * (1.0 - 2.0 * nu)
        } else if let Some(g) = given.shear_modulus {
            2.0 * g * (1.0 + nu)
        } else if let Some(lambda) = given.lame_lambda {
            lambda * (1.0 + nu) * (1.0 - 2.0 * nu) / nu
        } else {
            return argument(
                "the model has no elastic constant; set 'youngs_modulus', 'bulk_modulus', \
                 'shear_modulus' or 'lame_lambda'",
            );
        };
        if !(youngs_modulus > 0.0 && youngs_modulus.is_finite()) {
            return argument(format!(
                "the elastic constant of the model gives Young's modulus {youngs_modulus}; it must be \
                 positive and finite ('lame_lambda' must be positive here)"
            ));
        }
        let constants = Self::new(youngs_modulus, nu);
        if given.count() == 2 {
            let stated = given.poisson_ratio_of_two();
            if (stated - nu).abs() > RATIO_TOLERANCE {
                return argument(format!(
                    "the elastic constants of the model give Poisson's ratio {stated}, but {reason}; \
                     set one constant alone, or choose a formulation with a free ratio"
                ));
            }
        }
        Ok(constants)
    }

    /// lambda of the plane state: with plane stress lambda' = 2 lambda mu / (lambda + 2 mu).
    pub fn plane_lambda(&self, plane: Plane) -> f64 {
        let (lambda, mu) = (self.lame_lambda, self.shear_modulus);
        match plane {
            Plane::Strain => lambda,
            Plane::Stress => 2.0 * lambda * mu / (lambda + 2.0 * mu),
        }
    }
}

/// Two constants given in decimal agree with a ratio to about this.
const RATIO_TOLERANCE: f64 = 1e-6;

impl GivenConstants {
    fn count(&self) -> usize {
        self.list().iter().flatten().count()
    }

    fn list(&self) -> [Option<f64>; 5] {
        [
            self.youngs_modulus,
            self.poissons_ratio,
            self.bulk_modulus,
            self.shear_modulus,
            self.lame_lambda,
        ]
    }

    fn check_count(&self) -> Result<()> {
        if self.count() <= 2 {
            return Ok(());
        }
        argument(format!(
            "the model has {} elastic constants; two determine an isotropic solid, give no more",
            self.count()
        ))
    }

    /// Poisson's ratio that two given constants imply.
    fn poisson_ratio_of_two(&self) -> f64 {
        if let Some(nu) = self.poissons_ratio {
            return nu;
        }
        match (self.youngs_modulus, self.bulk_modulus, self.shear_modulus, self.lame_lambda) {
            (Some(e), Some(k), _, _) => 0.5 - e / (6.0 * k),
            (Some(e), _, Some(g), _) => e / (2.0 * g) - 1.0,
            (Some(e), _, _, Some(l)) => {
                2.0 * l / (e + l + (e * e + 9.0 * l * l + 2.0 * e * l).sqrt())
            }
            (_, Some(k), Some(g), _) => Elastic::with_moduli(k, g).poissons_ratio,
            (_, Some(k), _, Some(l)) => l / (3.0 * k - l),
            (_, _, Some(g), Some(l)) => l / (2.0 * (l + g)),
            _ => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_constants_gives_the_same_ratio() {
        let steel = Elastic::new(210.0, 0.3);
        let all = [
            steel.youngs_modulus,
            steel.poissons_ratio,
            steel.bulk_modulus,
            steel.shear_modulus,
            steel.lame_lambda,
        ];
        for first in 0..5 {
            for second in first + 1..5 {
                let pick = |k: usize| (k == first || k == second).then_some(all[k]);
                let given = GivenConstants {
                    youngs_modulus: pick(0),
                    poissons_ratio: pick(1),
                    bulk_modulus: pick(2),
                    shear_modulus: pick(3),
                    lame_lambda: pick(4),
                };
                let ratio = given.poisson_ratio_of_two();
                assert!((ratio - 0.3).abs() < 1e-14, "{first} {second}: {ratio}");
            }
        }
    }

    #[test]
    fn another_ratio_than_the_fixed_one_is_refused() {
        let given = GivenConstants {
            youngs_modulus: Some(1.0),
            poissons_ratio: Some(0.3),
            ..Default::default()
        };
        let error = Elastic::with_fixed_ratio(&given, 0.25, "bond_based has 1/4").unwrap_err();
        assert!(error.to_string().contains("0.3"), "{error}");
    }

    #[test]
    fn plane_stress_softens_lambda() {
        let elastic = Elastic::new(1.0, 1.0 / 3.0);
        let plane = elastic.plane_lambda(Plane::Stress);
        // E nu / (1 - nu^2)
        assert!((plane - 0.375).abs() < 1e-15, "{plane}");
        assert_eq!(elastic.plane_lambda(Plane::Strain), elastic.lame_lambda);
    }
}
