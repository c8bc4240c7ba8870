//! Formulations: how bonds turn displacements into forces. One file each, and one line in the table.

mod bond_based;

use crate::damage::{BondsView, Breaking};
use crate::error::{Error, Result};
use crate::families::{Families, Place, Property};
use crate::model::Model;
use crate::suggest;
use crate::workers::Workers;

/// One formulation: its name, what it takes, and how to make it ready for a body.
#[derive(Debug)]
pub struct FormulationEntry {
    /// The name, as `Model::new` takes it.
    pub name: &'static str,
    /// What it is, in a line.
    pub description: &'static str,
    /// Keys of models that it does not take.
    pub(crate) refused_keys: &'static [&'static str],
    /// Whether a model makes sense for it in a body of the given dimension.
    pub(crate) check: fn(&Model, usize) -> Result<()>,
    /// Critical stretch of a model at a horizon for an energy release rate.
    pub(crate) critical_stretch: fn(&Model, usize, horizon: f64, rate: f64) -> Result<f64>,
    /// Prepares it for a body.
    pub(crate) prepare: fn(&Materials<'_>) -> Result<Box<dyn Formulation>>,
}

/// All formulations.
pub static FORMULATIONS: [FormulationEntry; 1] = [bond_based::ENTRY];

/// A formulation by name.
pub(crate) fn find(name: &str) -> Result<&'static FormulationEntry> {
    FORMULATIONS.iter().find(|entry| entry.name == name).ok_or_else(|| {
        let known = FORMULATIONS.iter().map(|entry| entry.name);
        Error::Argument(format!("unknown formulation '{name}'{}", suggest::similar(name, known)))
    })
}

/// Which point is made of what.
pub(crate) struct Materials<'a> {
    pub(crate) dimension: usize,
    pub(crate) models: &'a [Model],
    /// Number of each point's model, by inner place; empty when there is only one.
    pub(crate) model_of: &'a [u16],
    pub(crate) horizons: &'a Property,
}

impl Materials<'_> {
    /// Something that follows from each point's model and horizon, kept once where all share it.
    pub(crate) fn property(
        &self,
        value: impl Fn(&Model, f64) -> Result<f64>,
        purpose: &'static str,
    ) -> Result<Property> {
        if let (Property::Uniform(horizon), [model]) = (self.horizons, self.models) {
            return Ok(Property::Uniform(value(model, *horizon)?));
        }
        let count = match self.horizons {
            Property::PerPoint(values) => values.len(),
            Property::Uniform(_) => self.model_of.len(),
        };
        let mut values = crate::memory::reserved(count, purpose)?;
        for point in 0..count {
            values.push(value(self.model(point), self.horizons.at(point))?);
        }
        let first = values[0];
        if values.iter().all(|&value| value == first) {
            return Ok(Property::Uniform(first));
        }
        Ok(Property::PerPoint(values))
    }

    fn model(&self, point: usize) -> &Model {
        &self.models[self.model_of.get(point).map_or(0, |&number| number as usize)]
    }
}

/// A body at a displacement: all that a sweep over bonds reads.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) dimension: usize,
    pub(crate) places: &'a [Place],
    pub(crate) families: &'a Families,
    pub(crate) bonds: BondsView<'a>,
    /// `dimension` numbers a point.
    pub(crate) displacement: &'a [f64],
    pub(crate) workers: &'a Workers,
}

/// A formulation made ready for one body.
pub(crate) trait Formulation: Send + Sync {
    /// Internal force per volume b_i of all points. With `breaking`, bonds that the rule condemns at
    /// this displacement break first. Gives the first point whose force is not finite.
    fn force(
        &self,
        scene: &Scene<'_>,
        force: &mut [f64],
        breaking: Option<Breaking<'_>>,
    ) -> Option<usize>;

    /// Strain energy per volume W_i of all points.
    fn strain_energy_density(&self, scene: &Scene<'_>, density: &mut [f64]);

    /// A bound, per point, on what the bonds still intact can add to the squared frequency of the body,
    /// times the density: (omega/2)^2 rho. It holds at any displacement.
    fn stiffness_bound(&self, scene: &Scene<'_>, bound: &mut [f64]);

    /// sum C_b V_j/L over each point's whole family, of [P 3.58].
    fn conventional_stiffness(&self, scene: &Scene<'_>, stiffness: &mut [f64]);

    /// Heap bytes held.
    fn bytes(&self) -> usize;
}
