//! Fields of deformation and stress, computed when asked for.

use super::drive::stopped_by_law;
use super::fields::PURPOSE;
use super::setup::Built;
use super::{Field, Simulation};
use crate::error::{Error, Result};
use crate::formulation::{Kinematics, ShapeTensor, shape_tensors};
use crate::memory;
use crate::tensor::Tensor;

impl Simulation {
    /// One of these fields in the inner order.
    pub(super) fn kinematics(&self, field: Field) -> Result<Vec<f64>> {
        self.kinematics_of(&[field])
    }

    /// Several of them, one point after the other, by one sweep over the bonds. Shape tensors stand alone.
    pub(super) fn kinematics_of(&self, fields: &[Field]) -> Result<Vec<f64>> {
        let dimension = self.points.dimension();
        for &field in fields {
            self.check_shown(field)?;
        }
        let Built { workers, plan, bonds, .. } = self.built()?;
        let scene = plan.scene(workers, bonds, &self.state.current.displacement);
        let width = fields.iter().map(|field| field.components(dimension)).sum::<usize>();
        let mut values = memory::filled(0.0, self.points.count() * width, PURPOSE)?;
        if let [field] = fields
            && let Some(tensor) = shape_tensor(*field)
        {
            shape_tensors(&scene, plan.formulation.weights(), tensor, &mut values);
        } else {
            let mut scratch = memory::filled(0.0, plan.scratch_of_energies(), PURPOSE)?;
            plan.formulation.kinematics(&scene, &mut scratch, &mut values, &|at, values| {
                let mut rest = values;
                for &field in fields {
                    let (own, others) = rest.split_at_mut(field.components(dimension));
                    read(field, dimension, at, own);
                    rest = others;
                }
            });
        }
        if let Some(error) = stopped_by_law(plan) {
            return Err(error);
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(place) => Err(Error::Numeric(format!(
                "{} of point {} is not finite: the body is crushed to nothing there, or the material \
                 does not bear the deformation",
                field_at(fields, dimension, place % width),
                self.points.order().host[place / width]
            ))),
            None => Ok(values),
        }
    }

    /// Refuses fields that the body does not have.
    fn check_shown(&self, field: Field) -> Result<()> {
        let dimension = self.points.dimension();
        if !field.is_defined(dimension) {
            return Err(Error::Unsupported(format!(
                "{} is the stress across a 2D body; in 3D get cauchy_stress",
                field.name()
            )));
        }
        if dimension == 2
            && matches!(field, Field::Stress33 | Field::VonMisesStress)
            && self.models.iter().any(|model| model.host_law().is_some())
        {
            return Err(Error::Unsupported(format!(
                "{} needs the stress across the body, which a material function does not give",
                field.name()
            )));
        }
        Ok(())
    }
}

/// Whether a field is read of the deformation and stress of points.
pub(super) fn is_read(field: Field) -> bool {
    matches!(
        field,
        Field::DeformationGradient
            | Field::Strain
            | Field::PlasticStrain
            | Field::EquivalentPlasticStrain
            | Field::FirstPiolaStress
            | Field::CauchyStress
            | Field::Stress33
            | Field::VonMisesStress
            | Field::Dilatation
    )
}

/// Name of the field that a number of a point belongs to.
fn field_at(fields: &[Field], dimension: usize, number: usize) -> &'static str {
    let mut end = 0;
    let of = fields.iter().find(|field| {
        end += field.components(dimension);
        number < end
    });
    of.map_or("a field", |field| field.name())
}

/// The tensor of the families that a field is.
fn shape_tensor(field: Field) -> Option<ShapeTensor> {
    match field {
        Field::ShapeTensor => Some(ShapeTensor::Reference),
        Field::MixedShapeTensor => Some(ShapeTensor::Mixed),
        Field::DeformedShapeTensor => Some(ShapeTensor::Now),
        _ => None,
    }
}

/// What a field has of a point.
fn read(field: Field, dimension: usize, at: &Kinematics, values: &mut [f64]) {
    let mut tensor = |whole: Tensor<3>| {
        for (values, row) in values.chunks_exact_mut(dimension).zip(&whole) {
            values.copy_from_slice(&row[..dimension]);
        }
    };
    match field {
        Field::DeformationGradient => tensor(at.deformation_gradient()),
        Field::Strain => tensor(at.strain()),
        Field::PlasticStrain => tensor(at.plastic_strain),
        Field::EquivalentPlasticStrain => values[0] = at.equivalent_plastic_strain,
        Field::FirstPiolaStress => tensor(at.first_piola_stress),
        Field::CauchyStress => tensor(at.cauchy_stress()),
        Field::Stress33 => values[0] = at.cauchy_stress()[2][2],
        Field::VonMisesStress => values[0] = at.von_mises_stress(),
        _ => values[0] = at.dilatation,
    }
}
