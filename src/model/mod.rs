//! Model: a formulation, a material and options, as keys and choices.
//!
//! Needs the table of formulations. Gives checked values; what depends on the points (the plane
//! state, horizons) is checked when a simulation is made of both.

mod elastic;
mod influence;
mod keys;

use std::ops::ControlFlow;
use std::sync::Arc;

use crate::error::{Error, Result, argument};
use crate::families::Storage;
use crate::formulation::{self, FormulationEntry};
use crate::material::{HostLaw, MaterialBatch};
pub(crate) use elastic::GivenConstants;
pub use elastic::{Elastic, Plane};
pub use influence::Influence;
pub use keys::{KEYS, Key, Kind};

/// What families near a surface are corrected by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SurfaceCorrection {
    /// Their energy at a stretch along each axis.
    Energy,
    /// Their stiffness tensor.
    StiffnessTensor,
}

/// A formulation with its material and options.
///
/// ```
/// use perion::Model;
/// let mut glass = Model::new("bond_based")?;
/// glass.set("density", 2440.0)?;
/// glass.set("youngs_modulus", 32e9)?;
/// glass.set("critical_energy_release_rate", 0.75)?;
/// let error = glass.set("yongs_modulus", 32e9).unwrap_err();
/// assert!(error.to_string().contains("did you mean 'youngs_modulus'?"));
/// # Ok::<(), perion::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Model {
    formulation: &'static FormulationEntry,
    numbers: [Option<f64>; KEYS.len()],
    choices: [Option<usize>; KEYS.len()],
    host_law: Option<HostLaw>,
}

impl Model {
    /// A model of the named formulation, with nothing set.
    ///
    /// # Errors
    /// `Argument` for an unknown formulation; the text names a similar one.
    pub fn new(formulation: &str) -> Result<Self> {
        Ok(Self {
            formulation: formulation::find(formulation)?,
            numbers: [None; KEYS.len()],
            choices: [None; KEYS.len()],
            host_law: None,
        })
    }

    /// Sets a number.
    ///
    /// # Errors
    /// `Argument` for an unknown key, one that takes a choice, or a value out of its range;
    /// `Unsupported` for a key that the formulation does not take.
    pub fn set(&mut self, key: &str, value: f64) -> Result<()> {
        let place = self.find(key)?;
        KEYS[place].check_number(value)?;
        self.numbers[place] = Some(value);
        Ok(())
    }

    /// The number last set, or its default.
    ///
    /// # Errors
    /// `Argument` for an unknown key or one that takes a choice; `State` when it was not set and
    /// has no default.
    pub fn get(&self, key: &str) -> Result<f64> {
        let place = keys::find(key)?;
        if matches!(KEYS[place].kind, Kind::Choice(_)) {
            return argument(format!("key '{key}' holds a choice, not a number"));
        }
        self.number(key).ok_or_else(|| Error::State(format!("'{key}' was not set")))
    }

    /// Makes a choice.
    ///
    /// # Errors
    /// `Argument` for an unknown key or choice, or a key that takes a number; `Unsupported` for a
    /// key that the formulation does not take.
    pub fn choose(&mut self, key: &str, choice: &str) -> Result<()> {
        let place = self.find(key)?;
        self.choices[place] = Some(KEYS[place].check_choice(choice)?);
        Ok(())
    }

    /// Takes the host's own law in place of `material`: `function` answers batches of deformation gradients with
    /// stress and energy, and keeps `state_size` numbers at each place, which become those of the material only
    /// when a step is completed or committed. It is asked on the thread that drives the simulation, never two at
    /// a time, and must give the same for the same. In 2D gradients have 2 x 2 numbers: what lies across is the
    /// function's own. Elastic constants are still needed, for bonds' penalties and horizons of stiffness. A
    /// function that breaks off ends the call with [`Error::Interrupted`].
    ///
    /// # Errors
    /// `Unsupported` for a formulation that asks no law.
    pub fn set_material_function(
        &mut self,
        state_size: usize,
        function: impl Fn(&mut MaterialBatch<'_>) -> ControlFlow<()> + Send + Sync + 'static,
    ) -> Result<()> {
        self.find("material")?;
        self.host_law = Some(HostLaw { state_size, function: Arc::new(function) });
        Ok(())
    }

    pub(crate) fn host_law(&self) -> Option<&HostLaw> {
        self.host_law.as_ref()
    }

    fn find(&self, key: &str) -> Result<usize> {
        let place = keys::find(key)?;
        if self.formulation.refused_keys.contains(&key) {
            return Err(Error::Unsupported(format!(
                "the formulation {} takes no '{key}'",
                self.formulation.name
            )));
        }
        Ok(place)
    }

    /// A number as set or by default; `key` must be in the table.
    pub(crate) fn number(&self, key: &str) -> Option<f64> {
        let place = KEYS.iter().position(|known| known.name == key)?;
        self.numbers[place].or_else(|| KEYS[place].default.parse().ok())
    }

    fn was_set(&self, key: &str) -> bool {
        KEYS.iter()
            .position(|known| known.name == key)
            .is_some_and(|place| self.numbers[place].is_some() || self.choices[place].is_some())
    }

    fn choice(&self, key: &str) -> Option<&'static str> {
        let place = KEYS.iter().position(|known| known.name == key)?;
        let Kind::Choice(words) = KEYS[place].kind else { return None };
        match self.choices[place] {
            Some(number) => words.split('|').nth(number),
            None => words.split('|').find(|&word| word == KEYS[place].default),
        }
    }

    pub(crate) fn formulation(&self) -> &'static FormulationEntry {
        self.formulation
    }

    /// The plane state of a 2D body, as chosen or by default.
    pub(crate) fn plane(&self) -> Plane {
        if self.choice("plane") == Some("stress") { Plane::Stress } else { Plane::Strain }
    }

    pub(crate) fn elastic_constants(&self) -> GivenConstants {
        GivenConstants {
            youngs_modulus: self.number("youngs_modulus"),
            poissons_ratio: self.number("poissons_ratio"),
            bulk_modulus: self.number("bulk_modulus"),
            shear_modulus: self.number("shear_modulus"),
            lame_lambda: self.number("lame_lambda"),
        }
    }

    /// The constants of the solid, from two that were given.
    pub(crate) fn elastic(&self) -> Result<Elastic> {
        Elastic::from_two(&self.elastic_constants())
    }

    pub(crate) fn influence(&self) -> Influence {
        match self.choice("influence") {
            Some("inverse") => Influence::Inverse,
            Some("conical") => Influence::Conical,
            Some("cubic_spline") => Influence::CubicSpline,
            _ => Influence::Constant,
        }
    }

    /// The name of the material law.
    pub(crate) fn material(&self) -> &'static str {
        self.choice("material").unwrap_or("saint_venant_kirchhoff")
    }

    /// 1 or 2.
    pub(crate) fn gradient_order(&self) -> usize {
        if self.number("gradient_order") == Some(2.0) { 2 } else { 1 }
    }

    pub(crate) fn surface_correction(&self) -> Option<SurfaceCorrection> {
        match self.choice("surface_correction") {
            Some("energy") => Some(SurfaceCorrection::Energy),
            Some("stiffness_tensor") => Some(SurfaceCorrection::StiffnessTensor),
            _ => None,
        }
    }

    pub(crate) fn has_partial_volume(&self) -> bool {
        self.choice("partial_volume") == Some("linear")
    }

    pub(crate) fn storage(&self) -> Storage {
        if self.choice("storage") == Some("lean") { Storage::Lean } else { Storage::Fast }
    }

    /// The first key of those that all models of a simulation share in which two differ.
    pub(crate) fn differs_from(&self, other: &Self) -> Option<&'static str> {
        const SHARED: [&str; 6] = [
            "divergence",
            "operator_bonds",
            "force_form",
            "surface_correction",
            "partial_volume",
            "storage",
        ];
        if self.gradient_order() != other.gradient_order() {
            return Some("gradient_order");
        }
        SHARED.into_iter().find(|key| self.choice(key) != other.choice(key))
    }

    pub(crate) fn is_literal(&self) -> bool {
        self.choice("force_form") == Some("literal")
    }

    /// Whether operators take deformed bonds, where it was chosen.
    pub(crate) fn has_deformed_bonds(&self) -> Option<bool> {
        self.choice("operator_bonds").map(|choice| choice == "deformed")
    }

    pub(crate) fn is_strong(&self) -> bool {
        self.choice("divergence") == Some("strong")
    }

    /// What breaks its bonds.
    pub(crate) fn damage(&self) -> Result<Damage> {
        let stretch = self.number("critical_stretch");
        let rate = self.number("critical_energy_release_rate");
        if stretch.is_some() && rate.is_some() {
            return argument(
                "the model has both 'critical_stretch' and 'critical_energy_release_rate'; one \
                 follows from the other, give one",
            );
        }
        let chosen = if self.was_set("damage") { self.choice("damage") } else { None };
        match (chosen, stretch, rate) {
            (Some("none"), _, _) | (None, None, None) => Ok(Damage::None),
            (_, Some(stretch), _) => Ok(Damage::CriticalStretch(stretch)),
            (_, _, Some(rate)) => Ok(Damage::EnergyRelease(rate)),
            _ => argument(
                "'damage' is critical_stretch, but neither 'critical_stretch' nor \
                 'critical_energy_release_rate' is set",
            ),
        }
    }

    /// Whether the model can stand alone in a body of this dimension.
    pub(crate) fn check(&self, dimension: usize, has_point_horizons: bool) -> Result<()> {
        if self.number("density").is_none() {
            return argument("the model has no 'density'; set it");
        }
        if self.number("horizon").is_none() && !has_point_horizons {
            return argument("the model has no 'horizon' and the points have none; set it");
        }
        if dimension == 3 {
            for key in ["plane", "thickness"] {
                if self.was_set(key) {
                    return argument(format!("'{key}' is set, but the points are 3D"));
                }
            }
        }
        if self.material() == "j2_plastic" && self.number("yield_stress").is_none() {
            return argument(
                "'material' is j2_plastic, but the model has no 'yield_stress'; set it",
            );
        }
        // Formulations without a law of the correspondence kind have a use of their own for what they take.
        let asks_law = !self.formulation.refused_keys.contains(&"material");
        if asks_law && self.material() != "j2_plastic" {
            for key in ["yield_stress", "hardening_modulus"] {
                if self.was_set(key) {
                    return argument(format!(
                        "'{key}' is set, but 'material' is {}; choose j2_plastic",
                        self.material()
                    ));
                }
            }
        }
        self.damage()?;
        (self.formulation.check)(self, dimension)
    }
}

/// What breaks bonds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Damage {
    /// Nothing but the host.
    None,
    /// A stretch beyond this.
    CriticalStretch(f64),
    /// The stretch at which a crack takes this energy per area.
    EnergyRelease(f64),
}
