//! Fields: what each of them is, and how they go to the host and come from it.

use super::{Simulation, check_length};
use crate::error::{Error, Result, argument};
use crate::memory;
use crate::points::Points;

pub(super) const PURPOSE: &str = "a field";

/// A quantity that every point has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// Position in the reference configuration, a length, one number an axis.
    ReferencePosition,
    /// Current position, a length, one number an axis.
    Position,
    /// Displacement, a length, one number an axis.
    Displacement,
    /// Velocity, one number an axis.
    Velocity,
    /// Acceleration, one number an axis; 0 where displacement or velocity is prescribed.
    Acceleration,
    /// Internal force per reference volume, one number an axis.
    InternalForce,
    /// Body force per reference volume, one number an axis: the host's own and that of conditions.
    BodyForce,
    /// Force that holds prescribed components, one number an axis; 0 elsewhere.
    Reaction,
    /// Volume; in 2D area times thickness.
    Volume,
    /// Mass per volume.
    Density,
    /// Share of the family's volume that is lost, from 0 to 1.
    Damage,
    /// Energy of the bonds per reference volume.
    StrainEnergyDensity,
    /// Energy per reference volume of the penalty on what the material does not see.
    StabilizationEnergyDensity,
    /// Energy that broken bonds held and that plastic flow took, per reference volume.
    DissipatedEnergyDensity,
    /// Deformation gradient F, row after row: F_ij = dx_i/dX_j.
    DeformationGradient,
    /// Green-Lagrange strain (F^T F - I)/2, row after row.
    Strain,
    /// Plastic strain in the rotated frame of the law, row after row: 0 where nothing flows. Of ordinary_state_based, in
    /// the reference frame, what its plastic extensions would pull on a unit of area, over 2 mu.
    PlasticStrain,
    /// Equivalent plastic strain: its increments are sqrt(2/3) of the size of those of the plastic strain. Of
    /// ordinary_state_based: plastic work over the yield stress.
    EquivalentPlasticStrain,
    /// First Piola-Kirchhoff stress P, row after row: force in axis i on the reference area across axis j.
    FirstPiolaStress,
    /// Cauchy stress P F^T/J, row after row.
    CauchyStress,
    /// Cauchy stress across a 2D body: 0 in plane stress. 3D bodies do not have it.
    Stress33,
    /// Von Mises stress of the Cauchy stress, that across a 2D body included.
    VonMisesStress,
    /// Change of volume per volume, in 2D of area: what the formulation calls dilatation, else det F - 1.
    Dilatation,
    /// Points within the point's own horizon.
    NeighborCount,
    /// Time step by the field's usual formula [P 3.58], a time; not a bound.
    TimeStepEstimate,
    /// K = sum w xi xi^T V over the family, row after row; xi the bond in the reference configuration.
    ShapeTensor,
    /// N = sum w eta xi^T V, row after row; eta the bond as it is now. F = N K^-1.
    MixedShapeTensor,
    /// M = sum w eta eta^T V, row after row.
    DeformedShapeTensor,
}

impl Field {
    /// All fields.
    pub const ALL: [Self; 28] = [
        Self::ReferencePosition,
        Self::Position,
        Self::Displacement,
        Self::Velocity,
        Self::Acceleration,
        Self::InternalForce,
        Self::BodyForce,
        Self::Reaction,
        Self::Volume,
        Self::Density,
        Self::Damage,
        Self::StrainEnergyDensity,
        Self::StabilizationEnergyDensity,
        Self::DissipatedEnergyDensity,
        Self::DeformationGradient,
        Self::Strain,
        Self::PlasticStrain,
        Self::EquivalentPlasticStrain,
        Self::FirstPiolaStress,
        Self::CauchyStress,
        Self::Stress33,
        Self::VonMisesStress,
        Self::Dilatation,
        Self::NeighborCount,
        Self::TimeStepEstimate,
        Self::ShapeTensor,
        Self::MixedShapeTensor,
        Self::DeformedShapeTensor,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ReferencePosition => "reference_position",
            Self::Position => "position",
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::InternalForce => "internal_force",
            Self::BodyForce => "body_force",
            Self::Reaction => "reaction",
            Self::Volume => "volume",
            Self::Density => "density",
            Self::Damage => "damage",
            Self::StrainEnergyDensity => "strain_energy_density",
            Self::StabilizationEnergyDensity => "stabilization_energy_density",
            Self::DissipatedEnergyDensity => "dissipated_energy_density",
            Self::DeformationGradient => "deformation_gradient",
            Self::Strain => "strain",
            Self::PlasticStrain => "plastic_strain",
            Self::EquivalentPlasticStrain => "equivalent_plastic_strain",
            Self::FirstPiolaStress => "first_piola_stress",
            Self::CauchyStress => "cauchy_stress",
            Self::Stress33 => "stress_33",
            Self::VonMisesStress => "von_mises_stress",
            Self::Dilatation => "dilatation",
            Self::NeighborCount => "neighbor_count",
            Self::TimeStepEstimate => "time_step_estimate",
            Self::ShapeTensor => "shape_tensor",
            Self::MixedShapeTensor => "mixed_shape_tensor",
            Self::DeformedShapeTensor => "deformed_shape_tensor",
        }
    }

    /// Refuses fields that the host cannot write.
    pub(crate) fn check_settable(self) -> Result<()> {
        match self {
            Self::Displacement | Self::Position | Self::Velocity | Self::BodyForce => Ok(()),
            _ => Err(Error::Unsupported(format!(
                "'field' {} cannot be set; displacement, position, velocity and body_force can",
                self.name()
            ))),
        }
    }

    /// Refuses a stride in which the numbers of a point have no room.
    pub(crate) fn check_stride(self, stride: usize, dimension: usize) -> Result<()> {
        let components = self.components(dimension);
        if stride >= components {
            return Ok(());
        }
        argument(format!(
            "'stride' is {stride}, but a point has {components} numbers of this field"
        ))
    }

    /// Numbers a point has of it in a body of this dimension.
    pub fn components(self, dimension: usize) -> usize {
        match self {
            Self::ReferencePosition
            | Self::Position
            | Self::Displacement
            | Self::Velocity
            | Self::Acceleration
            | Self::InternalForce
            | Self::BodyForce
            | Self::Reaction => dimension,
            Self::DeformationGradient
            | Self::Strain
            | Self::PlasticStrain
            | Self::FirstPiolaStress
            | Self::CauchyStress
            | Self::ShapeTensor
            | Self::MixedShapeTensor
            | Self::DeformedShapeTensor => dimension * dimension,
            _ => 1,
        }
    }

    /// Whether a body of this dimension has it.
    pub fn is_defined(self, dimension: usize) -> bool {
        self != Self::Stress33 || dimension == 2
    }
}

impl Simulation {
    /// A field of all points in the host's order, point after point.
    ///
    /// # Errors
    /// `State` for `Acceleration`, `BodyForce` and `Reaction` while loads or forces have changed and
    /// were not evaluated; `Numeric` for a force, a deformation or a stress that is not finite;
    /// `Unsupported` for `Stress33` in 3D; `Memory`.
    pub fn get(&self, field: Field) -> Result<Vec<f64>> {
        let components = field.components(self.points.dimension());
        let mut values = memory::filled(0.0, self.points.count() * components, PURPOSE)?;
        self.get_into(field, &mut values)?;
        Ok(values)
    }

    /// As [`Simulation::get`], into the host's own memory.
    ///
    /// # Errors
    /// As [`Simulation::get`]; `Argument` when the length is not that of the field.
    pub fn get_into(&self, field: Field, values: &mut [f64]) -> Result<()> {
        let components = field.components(self.points.dimension());
        check_length(values.len(), self.points.count(), components)?;
        self.get_strided(None, field, values, components)
    }

    /// The field on a set, in the set's order, or on all points, with `stride` numbers from one point
    /// to the next; what lies between is not touched.
    ///
    /// # Errors
    /// As [`Simulation::get`]; `Argument` for an unknown set or values that are too few.
    pub fn get_strided(
        &self,
        set: Option<&str>,
        field: Field,
        values: &mut [f64],
        stride: usize,
    ) -> Result<()> {
        let components = field.components(self.points.dimension());
        self.check_strided(set, field, values.len(), stride)?;
        let mut start = 0;
        self.for_each_value(set, field, |value| {
            values[start..start + components].copy_from_slice(value);
            start += stride;
        })
    }

    /// Calls `visit` with the components of a field for each point of a set, in the set's order.
    pub(crate) fn for_each_value(
        &self,
        set: Option<&str>,
        field: Field,
        mut visit: impl FnMut(&[f64]),
    ) -> Result<()> {
        let components = field.components(self.points.dimension());
        let inner = self.inner(field)?;
        let order = self.points.order();
        self.points.for_each_in_set(set.unwrap_or(crate::points::ALL), |point| {
            let from = order.place(point) * components;
            visit(&inner[from..from + components]);
        })
    }

    /// Writes a field of all points: displacement, position, velocity or the host's body force.
    ///
    /// # Errors
    /// `Argument` for a length that is not that of the field or a value that is not finite;
    /// `Unsupported` for any other field; `Memory`.
    pub fn set(&mut self, field: Field, values: &[f64]) -> Result<()> {
        field.check_settable()?;
        let dimension = self.points.dimension();
        check_length(values.len(), self.points.count(), dimension)?;
        self.set_strided(None, field, values, dimension)
    }

    /// As [`Simulation::set`], on a set in its order or on all points, with a stride.
    ///
    /// # Errors
    /// As [`Simulation::set`]; also for an unknown set.
    pub fn set_strided(
        &mut self,
        set: Option<&str>,
        field: Field,
        values: &[f64],
        stride: usize,
    ) -> Result<()> {
        field.check_settable()?;
        let set = self.check_strided(set, field, values.len(), stride)?;
        self.check_values(set, field, values, stride)?;
        match field {
            Field::Velocity => self.give_kinetic(|simulation| {
                let target = &mut simulation.state.current.velocity;
                scatter(&simulation.points, set, values, stride, target, false);
            })?,
            Field::BodyForce => {
                let target = self.state.host_load_mut()?;
                scatter(&self.points, set, values, stride, target, false);
                self.state.loads_fresh = false;
            }
            _ => {
                self.close_ledger()?;
                let target = self.state.displacement_mut();
                scatter(&self.points, set, values, stride, target, field == Field::Position);
            }
        }
        Ok(())
    }

    fn check_strided<'a>(
        &self,
        set: Option<&'a str>,
        field: Field,
        length: usize,
        stride: usize,
    ) -> Result<&'a str> {
        let set = set.unwrap_or(crate::points::ALL);
        let size = self.points.set_size(set)?;
        field.check_stride(stride, self.points.dimension())?;
        let components = field.components(self.points.dimension());
        let needed = (size - 1).checked_mul(stride).and_then(|n| n.checked_add(components));
        if needed.is_none_or(|needed| length < needed) {
            return argument(format!(
                "'values' has {length} numbers, too few for {size} points of stride {stride}"
            ));
        }
        Ok(set)
    }

    fn check_values(&self, set: &str, field: Field, values: &[f64], stride: usize) -> Result<()> {
        let dimension = self.points.dimension();
        let mut bad = None;
        let mut start = 0;
        self.points.for_each_in_set(set, |point| {
            for (axis, &value) in values[start..start + dimension].iter().enumerate() {
                if !value.is_finite() && bad.is_none() {
                    bad = Some((point, axis, value));
                }
            }
            start += stride;
        })?;
        match bad {
            Some((point, axis, value)) => argument(format!(
                "'values': {} of point {point}, axis {axis}, is {value}; it must be finite",
                field.name()
            )),
            None => Ok(()),
        }
    }
}

/// Copies checked values of a checked set into the inner order; `positions` become displacements.
fn scatter(
    points: &Points,
    set: &str,
    values: &[f64],
    stride: usize,
    target: &mut [f64],
    positions: bool,
) {
    let dimension = points.dimension();
    let mut start = 0;
    // The set is known to exist.
    let _ = points.for_each_in_set(set, |point| {
        let to = points.order().place(point) * dimension;
        for axis in 0..dimension {
            let reference =
                if positions { points.coordinates()[point * dimension + axis] } else { 0.0 };
            target[to + axis] = values[start + axis] - reference;
        }
        start += stride;
    });
}
