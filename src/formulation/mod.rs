//! Formulations: how bonds turn displacements into forces. One file each, and one line in the table.

mod body;
mod bond_associated;
mod bond_associated_quadrature;
mod bond_associated_quadrature_lanes;
mod bond_associated_quadrature_lattice;
mod bond_based;
mod bond_forces;
mod bond_laws;
mod breaking;
mod calm;
mod cholesky;
mod constants;
mod correspondence;
mod correspondence_lanes;
mod correspondence_lattice;
mod extension_lanes;
mod gradient;
mod in_lanes;
mod kept_rows;
mod kinematics;
mod lagrangian;
mod lagrangian_lanes;
mod lattice_rows;
mod laws;
mod madenci_oterkus;
mod on_lattice;
mod operators;
mod ordinary_lattice;
mod ordinary_plastic;
mod ordinary_plastic_lanes;
mod ordinary_state_based;
mod passes;
mod seam;
mod state_based;
mod surface;
mod surface_stiffness;

pub(crate) use body::Weights;
pub use calm::Skips;
pub(crate) use kinematics::Kinematics;
pub use operators::Operator;
pub(crate) use operators::{Derivative, ShapeTensor, differentiate, shape_tensors};

use crate::damage::{BondsView, Breaking};
use crate::error::{Error, Result};
use crate::families::lattice::{Lattice, LatticeUse};
use crate::families::{Families, Place, Property};
use crate::kernel::simd::SimdLevel;
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
pub static FORMULATIONS: [FormulationEntry; 10] = [
    bond_based::ENTRY,
    ordinary_state_based::ENTRY,
    madenci_oterkus::ENTRY,
    correspondence::ENTRY,
    correspondence::SILLING,
    correspondence::WAN,
    bond_associated::ENTRY,
    bond_associated_quadrature::ENTRY,
    lagrangian::TOTAL,
    lagrangian::UPDATED,
];

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

/// What the stretches follow from at which bonds break.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LimitsFollow {
    /// All share one.
    Nothing,
    /// The models of both ends, where horizons are alike.
    Models,
    /// Each has its own.
    Bonds,
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
    /// Whether materials may flow; else they answer with their elastic stiffness.
    pub(crate) flows: bool,
    pub(crate) simd: SimdLevel,
    /// What may be left out where it changes nothing.
    pub(crate) skips: Skips,
    /// Whether bonds are computed several at a time where there is a sweep for it.
    pub(crate) lanes: bool,
    /// Answers of laws with memory at this displacement, once they have been asked.
    pub(crate) asked: Option<Asked<'a>>,
}

impl<'a> Scene<'a> {
    /// The lattice, where sweeps over its groups can do: they know nothing of the integrity of bonds.
    pub(crate) fn lattice(&self) -> Option<&'a Lattice> {
        self.families.lattice.as_ref().filter(|_| self.bonds.integrity.is_none())
    }
}

/// What laws with memory have answered.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    /// A record a site.
    pub(crate) records: &'a [f64],
    /// The energy wanted is what is not given back.
    pub(crate) dissipated: bool,
}

/// A part of the elastic energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EnergyPart {
    /// Of the material.
    Strain,
    /// Of the penalty on what the material does not see.
    Stabilization,
    /// What the material has dissipated.
    Plastic,
}

/// Makes numbers of the deformation and stress of a point.
pub(crate) type Read<'a> = dyn Fn(&Kinematics, &mut [f64]) + Sync + 'a;

/// A formulation made ready for one body.
pub(crate) trait Formulation: Send + Sync {
    /// What its sweeps make of points that stand on a lattice.
    fn use_of_a_lattice(&self) -> LatticeUse {
        LatticeUse::None
    }

    /// Takes note of whether bonds will break, and of what it follows from when, so that sweeps that break none run as
    /// those that do.
    fn know_limits(&mut self, _any: bool, _follow: LimitsFollow) {}

    /// Whether sweeps over lattices take groups of one model each.
    fn tells_models_apart(&self) -> bool {
        false
    }

    /// Takes the body as it is before the first step, its pre-cracks included, for what it refers to.
    fn refer_to(&mut self, _scene: &Scene<'_>) -> Result<()> {
        Ok(())
    }

    /// Numbers that a sweep for forces or energies writes aside; `breaks`: bonds may break in one.
    fn scratch(&self, _points: usize, _blocks: usize, _dimension: usize, _breaks: bool) -> usize {
        0
    }

    /// Numbers that a sweep for forces writes aside where all of the body is a lattice, with the energies that breaking needs:
    /// groups have room of their own.
    fn scratch_on_lattice(&self, _points: usize, _dimension: usize, _breaks: bool) -> usize {
        0
    }

    /// Numbers of records that its laws keep: the first ones of the scratch after a sweep for forces.
    fn records(&self, _points: usize, _blocks: usize) -> usize {
        0
    }

    /// Whether a law of the host's has asked to stop since this was last asked.
    fn was_stopped(&self) -> bool {
        false
    }

    /// Internal force per volume b_i of all points. With `breaking`, bonds that the rule condemns at
    /// this displacement break first. Gives the first point whose force is not finite.
    fn force(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        force: &mut [f64],
        breaking: Option<Breaking<'_>>,
    ) -> Option<usize>;

    /// A part of the energy per volume of all points.
    fn energy_density(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        density: &mut [f64],
        part: EnergyPart,
    );

    /// Deformation and stress of all points: `read` makes of each the numbers that `values` has a point.
    fn kinematics(
        &self,
        scene: &Scene<'_>,
        scratch: &mut [f64],
        values: &mut [f64],
        read: &Read<'_>,
    );

    /// How much bonds count in a family.
    fn weights(&self) -> &Weights;

    /// How stiff a bond of this length is among those of its point, to a factor: for preconditioners.
    fn spring_shape(&self, point: usize, length: f64) -> f64 {
        self.weights().value(point, length)
    }

    /// Whether forces are the slope of an energy.
    fn has_potential(&self) -> bool;

    /// Whether the bonds that are left can become stiffer as others break.
    fn stiffens_by_damage(&self) -> bool {
        true
    }

    /// Marks points whose families do not span the body, or do not bear the order of gradient asked for, by 1.
    fn degenerate(&self, _scene: &Scene<'_>, marks: &mut [f64]) {
        marks.fill(0.0);
    }

    /// sum C_b V_j/L over each point's whole family, of [P 3.58].
    fn conventional_stiffness(&self, scene: &Scene<'_>, stiffness: &mut [f64]);

    /// Heap bytes held.
    fn bytes(&self) -> usize;
}
