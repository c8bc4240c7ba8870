//! Every key that a model knows: its meaning, its limits, its default, and who takes it.

use crate::error::{Error, Result, argument};
use crate::suggest;

/// What values a key takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A finite number between these limits, which are themselves excluded.
    Number {
        /// Lower limit.
        above: f64,
        /// Upper limit.
        below: f64,
    },
    /// A finite number, 0 or more.
    NotNegative,
    /// A whole number between these limits, which are themselves allowed.
    Whole {
        /// The least.
        least: u32,
        /// The greatest.
        most: u32,
    },
    /// One of these words, which a bar separates.
    Choice(&'static str),
}

/// One key of a model.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// The name, as `Model::set` and `Model::choose` take it.
    pub name: &'static str,
    /// Meaning, unit kind, and the reason for the default.
    pub description: &'static str,
    /// The default as text; empty where there is none.
    pub default: &'static str,
    /// The values allowed.
    pub kind: Kind,
}

const POSITIVE: Kind = Kind::Number { above: 0.0, below: f64::INFINITY };

const fn number(name: &'static str, default: &'static str, description: &'static str) -> Key {
    Key { name, description, default, kind: POSITIVE }
}

/// The list of all keys.
pub const KEYS: [Key; 25] = [
    number("density", "", "mass per volume; must be given"),
    number(
        "horizon",
        "",
        "length up to which points pull on each other; must be given unless the points have their \
         own. Usual is 3.015 spacings: three shells of neighbours, the last one safely inside",
    ),
    number("youngs_modulus", "", "Young's modulus E, a stress"),
    Key {
        name: "poissons_ratio",
        description: "Poisson's ratio nu, without unit; bond_based has 1/4 in 3D and plane strain \
                      and 1/3 in plane stress, and takes no other",
        default: "",
        kind: Kind::Number { above: -1.0, below: 0.5 },
    },
    number("bulk_modulus", "", "bulk modulus K, a stress"),
    number("shear_modulus", "", "shear modulus mu, a stress"),
    Key {
        name: "lame_lambda",
        description: "first Lame constant lambda, a stress",
        default: "",
        kind: Kind::Number { above: f64::NEG_INFINITY, below: f64::INFINITY },
    },
    number(
        "critical_energy_release_rate",
        "",
        "G_c, energy per crack area; gives the critical stretch and turns damage on",
    ),
    number("critical_stretch", "", "stretch at which a bond breaks; turns damage on"),
    number(
        "thickness",
        "1",
        "of a 2D body, a length; 1 because forces per unit thickness are what 2D tables give",
    ),
    Key {
        name: "influence",
        description: "how much a bond counts by its length L within the horizon d: constant 1, \
                      inverse d/L, conical 1 - L/d, or the cubic B-spline; constant, because every bond \
                      then tells as much of the gradient as it can. bond_based and madenci_oterkus \
                      take none",
        default: "constant",
        kind: Kind::Choice("constant|inverse|conical|cubic_spline"),
    },
    Key {
        name: "material",
        description: "law of the correspondence kind: Saint Venant-Kirchhoff, neo-Hooke, small strain, \
                      hypoelastic (a rate of stress in the rotated frame of Flanagan and Taylor), or j2_plastic \
                      (von Mises plasticity in it, with yield_stress); \
                      the first, because it is linear in the strain and knows rotations",
        default: "saint_venant_kirchhoff",
        kind: Kind::Choice(
            "saint_venant_kirchhoff|neo_hookean|small_strain|hypoelastic|j2_plastic",
        ),
    },
    number(
        "yield_stress",
        "",
        "of j2_plastic, and of ordinary_state_based in 3D (perfect plasticity, on by this key), the stress in uniaxial \
         tension at which it begins to flow",
    ),
    Key {
        name: "hardening_modulus",
        description: "of j2_plastic, stress by which the yield stress grows per equivalent plastic strain, 0 or \
                      more; 0, perfect plasticity, because it is the least that one can claim",
        default: "0",
        kind: Kind::NotNegative,
    },
    Key {
        name: "silling_coefficient",
        description: "C_s of correspondence_silling, without unit; 1, because the penalty is then as stiff \
                      as the bonds of the material and costs little of the time step",
        default: "1",
        kind: POSITIVE,
    },
    Key {
        name: "gradient_order",
        description: "order of the polynomials that the gradient takes exactly, 1 or 2; 1, because 2 needs \
                      larger families",
        default: "1",
        kind: Kind::Whole { least: 1, most: 2 },
    },
    number(
        "bond_horizon",
        "",
        "length around the other end of a bond in which bond_associated looks; the horizon, if it is not \
         given: smaller ones are stiffer against modes without energy",
    ),
    Key {
        name: "surface_correction",
        description: "of bond_based and ordinary_state_based: none; energy: bonds near a surface are made \
                      stiffer until a stretch along each axis stores what the material says; \
                      stiffness_tensor: bonds are weighted by their direction until each family has the \
                      stiffness tensor of the material, nearest for surfaces along the axes; none, because \
                      weighted bonds take more time and memory",
        default: "none",
        kind: Kind::Choice("none|energy|stiffness_tensor"),
    },
    Key {
        name: "partial_volume",
        description: "how much of a neighbour at the rim of the horizon counts: none, all of it or nothing; or \
                      linear: with h the mean edge of both points' cells, the part (horizon + h/2 - L)/h of \
                      its volume, and families reach h/2 farther; none, because it costs bonds and 3.015 \
                      spacings leave no point at the rim of a lattice",
        default: "none",
        kind: Kind::Choice("none|linear"),
    },
    Key {
        name: "force_form",
        description: "of bond_associated: energy, the slope of its energy, or literal, as its source \
                      prints it; energy, because it conserves energy",
        default: "energy",
        kind: Kind::Choice("energy|literal"),
    },
    Key {
        name: "operator_bonds",
        description: "bonds in the operators of total_lagrangian (undeformed, where it is not chosen: forces \
                      are then the slope of the energy) and updated_lagrangian (deformed)",
        default: "",
        kind: Kind::Choice("undeformed|deformed"),
    },
    Key {
        name: "divergence",
        description: "weak: forces are the slope of the energy; strong: the divergence of the stress by \
                      collocation, which conserves no momentum. weak, because it does",
        default: "weak",
        kind: Kind::Choice("weak|strong"),
    },
    Key {
        name: "plane",
        description: "what lies across a 2D body; strain, because it holds for any thick body and \
                      keeps the constants of the solid",
        default: "strain",
        kind: Kind::Choice("strain|stress"),
    },
    Key {
        name: "damage",
        description: "when bonds break: none, or at critical_stretch; none, unless a critical \
                      value is given",
        default: "none",
        kind: Kind::Choice("none|critical_stretch"),
    },
    Key {
        name: "storage",
        description: "fast: the lengths of bonds of a cloud are kept; lean: they are computed whenever they are \
                      needed, which takes 4 bytes and a bit or two at each end of a bond instead of 12; \
                      fast, because it is",
        default: "fast",
        kind: Kind::Choice("fast|lean"),
    },
];

/// Place of a key in [`KEYS`].
pub(crate) fn find(name: &str) -> Result<usize> {
    KEYS.iter().position(|key| key.name == name).ok_or_else(|| {
        let known = KEYS.iter().map(|key| key.name);
        Error::Argument(format!("unknown key '{name}'{}", suggest::similar(name, known)))
    })
}

impl Key {
    pub(crate) fn check_number(&self, value: f64) -> Result<()> {
        let (above, below) = match self.kind {
            Kind::Number { above, below } => (above, below),
            Kind::NotNegative => {
                if value >= 0.0 && value.is_finite() {
                    return Ok(());
                }
                return argument(format!(
                    "'{}' is {value}; it must be finite and not negative",
                    self.name
                ));
            }
            Kind::Whole { least, most } => {
                if value.fract() == 0.0 && (f64::from(least)..=f64::from(most)).contains(&value) {
                    return Ok(());
                }
                return argument(format!(
                    "'{}' is {value}; it must be a whole number from {least} to {most}",
                    self.name
                ));
            }
            Kind::Choice(_) => {
                return argument(format!(
                    "key '{}' takes a choice, not a number; use choose",
                    self.name
                ));
            }
        };
        if above < value && value < below && value.is_finite() {
            return Ok(());
        }
        let lower =
            if above == f64::NEG_INFINITY { String::new() } else { format!(", above {above}") };
        let upper = if below == f64::INFINITY { String::new() } else { format!(", below {below}") };
        argument(format!("'{}' is {value}; it must be finite{lower}{upper}", self.name))
    }

    /// Place of a choice among those of this key.
    pub(crate) fn check_choice(&self, choice: &str) -> Result<usize> {
        let Kind::Choice(choices) = self.kind else {
            return argument(format!("key '{}' takes a number, not a choice; use set", self.name));
        };
        choices.split('|').position(|known| known == choice).ok_or_else(|| {
            let near = suggest::similar(choice, choices.split('|'));
            Error::Argument(format!("key '{}' has no choice '{choice}'{near}", self.name))
        })
    }
}
