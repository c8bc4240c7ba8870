//! Nonlocal derivatives of a field that the host hands in.

use super::Simulation;
use super::setup::Built;
use crate::error::{Error, Result, argument};
use crate::formulation::{Derivative, Operator, differentiate};
use crate::memory;

const PURPOSE: &str = "operators";

impl Simulation {
    /// The gradient of a field with `components` numbers a point, in the host's order: at each point
    /// components x dimension numbers, those of one component together. The families are those of the
    /// simulation with its influence function, broken bonds left out, at the current displacement (Bergel and
    /// Li, Table 1). Affine fields are differentiated exactly by the operator that fits the coordinates they
    /// are affine in. A point without bonds has 0; where the bonds of a point do not span the body, the
    /// derivative is that along what they span.
    ///
    /// # Errors
    /// `Argument` when the field is not `components` finite numbers a point; `Numeric` when a derivative is not
    /// finite; what building the families can fail with.
    pub fn gradient(
        &self,
        operator: Operator,
        components: usize,
        field: &[f64],
    ) -> Result<Vec<f64>> {
        let dimension = self.points.dimension();
        if components.checked_mul(dimension).is_none() {
            return argument(format!("'components' is {components}: too many"));
        }
        self.derivative(operator, components, field, false)
    }

    /// The divergence of a field of vectors or, row after row, tensors: over the last axis, as Div P is. At
    /// each point components / dimension numbers. Otherwise as [`Simulation::gradient`].
    ///
    /// # Errors
    /// As [`Simulation::gradient`]; `Argument` also when `components` is no multiple of the dimension.
    pub fn divergence(
        &self,
        operator: Operator,
        components: usize,
        field: &[f64],
    ) -> Result<Vec<f64>> {
        let dimension = self.points.dimension();
        if !components.is_multiple_of(dimension) {
            return argument(format!(
                "'components' is {components}; a divergence needs a multiple of the dimension, {dimension}"
            ));
        }
        self.derivative(operator, components, field, true)
    }

    fn derivative(
        &self,
        operator: Operator,
        components: usize,
        field: &[f64],
        divergence: bool,
    ) -> Result<Vec<f64>> {
        let (count, dimension) = (self.points.count(), self.points.dimension());
        if components == 0 || count.checked_mul(components) != Some(field.len()) {
            return argument(format!(
                "'field' has {} numbers; 'components' {components} and {count} points need \
                 components x points, and at least one component",
                field.len()
            ));
        }
        if let Some(place) = field.iter().position(|value| !value.is_finite()) {
            return argument(format!(
                "'field' of point {}, component {}, is {}; it must be finite",
                place / components,
                place % components,
                field[place]
            ));
        }
        let Built { workers, plan, bonds, .. } = self.built()?;
        let order = self.points.order();
        let mut inner = memory::reserved(field.len(), PURPOSE)?;
        for &point in &order.host {
            let from = point as usize * components;
            inner.extend_from_slice(&field[from..from + components]);
        }
        let width = if divergence { components / dimension } else { components * dimension };
        let total = count.saturating_mul(width);
        let mut result = memory::filled(0.0, total, PURPOSE)?;
        let scene = plan.scene(workers, bonds, &self.state.current.displacement);
        let derivative = Derivative { operator, field: &inner, components, divergence };
        differentiate(&scene, plan.formulation.weights(), &derivative, &mut result);
        if let Some(place) = result.iter().position(|value| !value.is_finite()) {
            return Err(Error::Numeric(format!(
                "the derivative at point {} is not finite: the body is crushed to nothing there, or the field \
                 is beyond the range of numbers",
                order.host[place / width]
            )));
        }
        let mut values = memory::filled(0.0, total, PURPOSE)?;
        for (from, &point) in result.chunks_exact(width).zip(&order.host) {
            let to = point as usize * width;
            values[to..to + width].copy_from_slice(from);
        }
        Ok(values)
    }
}
