//! Gradients and divergences of a field that the host hands in, by the operators of [B], Table 1.
//!
//! With K = sum w xi xi^T V, N = sum w eta xi^T V, M = sum w eta eta^T V all are sums over the family of the
//! field's differences times a vector h of each bond: grad g = sum w (g_j - g_i) h^T V,
//! div T = sum w (T_j - T_i) h V, where h = K^-1 xi or N^-1 eta differentiates by reference coordinates, and
//! h = N^-T xi or M^-1 eta by current ones.
//!
//! Where a family does not span the body N has no inverse. Then both reference operators take K^-1 xi and both
//! current ones M^-1 eta in the directions spanned (see `gradient`): the derivative along the sheet or string.

use super::Scene;
use super::body::{Body, Weights};
use super::gradient::Shape;
use crate::tensor::{Tensor, add_outer, applied, inverse, sum, transposed, zero};
use crate::workers::PerPoint;

/// What a field is differentiated by, and with which bonds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    /// By reference coordinates with bonds of the reference body: h = K^-1 xi.
    ReferenceUndeformed,
    /// By reference coordinates with deformed bonds: h = N^-1 eta.
    ReferenceDeformed,
    /// By current coordinates with bonds of the reference body: h = N^-T xi.
    CurrentUndeformed,
    /// By current coordinates with deformed bonds: h = M^-1 eta.
    CurrentDeformed,
}

/// A derivative of a field.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Derivative<'a> {
    pub(crate) operator: Operator,
    /// In the inner order.
    pub(crate) field: &'a [f64],
    /// Numbers a point of the field.
    pub(crate) components: usize,
    /// Sums over the field's last axis.
    pub(crate) divergence: bool,
}

/// The derivative at all points: components x D numbers a point, of a divergence components / D.
pub(crate) fn differentiate(
    scene: &Scene<'_>,
    weights: &Weights,
    derivative: &Derivative<'_>,
    result: &mut [f64],
) {
    match scene.dimension {
        3 => sweep::<3>(scene, weights, derivative, result),
        _ => sweep::<2>(scene, weights, derivative, result),
    }
}

fn sweep<const D: usize>(
    scene: &Scene<'_>,
    weights: &Weights,
    derivative: &Derivative<'_>,
    result: &mut [f64],
) {
    let (body, count) = (Body::<D>::new(scene, weights), scene.places.len());
    let width = result.len() / count;
    scene.workers.sweep(count, PerPoint(result, width), |range, result| {
        for (result, point) in result.0.chunks_exact_mut(width).zip(range) {
            at_point(&body, point, derivative, result);
        }
    });
}

fn at_point<const D: usize>(
    body: &Body<'_, D>,
    point: usize,
    derivative: &Derivative<'_>,
    result: &mut [f64],
) {
    let Moments { reference, mixed, now, .. } = Moments::new(body, point);
    let shape = Shape::new(&reference);
    let spans = shape.rank == D;
    let (matrix, deformed) = match derivative.operator {
        Operator::ReferenceDeformed if spans => (inverse(&mixed), true),
        Operator::ReferenceUndeformed | Operator::ReferenceDeformed => (shape.inverse, false),
        Operator::CurrentUndeformed if spans => (transposed(&inverse(&mixed)), false),
        Operator::CurrentDeformed if spans => (inverse(&now), true),
        Operator::CurrentUndeformed | Operator::CurrentDeformed => (Shape::new(&now).inverse, true),
    };
    let Derivative { field, components, divergence, .. } = *derivative;
    let of = |point: usize| &field[point * components..(point + 1) * components];
    let own = of(point);
    result.fill(0.0);
    for link in body.links(point) {
        let bond = if deformed { link.deformed() } else { link.reference };
        let h = applied(&matrix, &bond).map(|h| link.own * link.volume * h);
        let differences = of(link.neighbor).iter().zip(own).map(|(there, here)| there - here);
        if divergence {
            for (number, difference) in differences.enumerate() {
                result[number / D] += difference * h[number % D];
            }
        } else {
            for (result, difference) in result.chunks_exact_mut(D).zip(differences) {
                result.iter_mut().zip(&h).for_each(|(sum, h)| *sum += difference * h);
            }
        }
    }
}

/// Which tensor of a family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ShapeTensor {
    /// K
    Reference,
    /// N
    Mixed,
    /// M
    Now,
}

/// A tensor of each point's family: D x D numbers a point.
pub(crate) fn shape_tensors(
    scene: &Scene<'_>,
    weights: &Weights,
    tensor: ShapeTensor,
    result: &mut [f64],
) {
    match scene.dimension {
        3 => sweep_tensors::<3>(scene, weights, tensor, result),
        _ => sweep_tensors::<2>(scene, weights, tensor, result),
    }
}

fn sweep_tensors<const D: usize>(
    scene: &Scene<'_>,
    weights: &Weights,
    tensor: ShapeTensor,
    result: &mut [f64],
) {
    let body = Body::<D>::new(scene, weights);
    scene.workers.sweep(scene.places.len(), PerPoint(result, D * D), |range, result| {
        for (result, point) in result.0.chunks_exact_mut(D * D).zip(range) {
            let moments = Moments::new(&body, point);
            let chosen = match tensor {
                ShapeTensor::Reference => moments.reference,
                ShapeTensor::Mixed => moments.mixed,
                ShapeTensor::Now => moments.now,
            };
            result.copy_from_slice(chosen.as_flattened());
        }
    });
}

/// The tensors of a family, and what their differences are made of without cancellation.
pub(super) struct Moments<const D: usize> {
    /// K = sum w xi xi^T V
    pub(super) reference: Tensor<D>,
    /// N = sum w eta xi^T V
    pub(super) mixed: Tensor<D>,
    /// M = sum w eta eta^T V
    pub(super) now: Tensor<D>,
    /// N - K = sum w du xi^T V
    pub(super) moved: Tensor<D>,
    /// M - N^T = sum w du eta^T V
    pub(super) moved_now: Tensor<D>,
}

impl<const D: usize> Moments<D> {
    pub(super) fn new(body: &Body<'_, D>, point: usize) -> Self {
        let (mut reference, mut moved, mut moved_now) = (zero(), zero(), zero());
        for link in body.links(point) {
            let factor = link.own * link.volume;
            add_outer(&mut reference, factor, &link.reference, &link.reference);
            add_outer(&mut moved, factor, &link.moved, &link.reference);
            add_outer(&mut moved_now, factor, &link.moved, &link.deformed());
        }
        let mixed = sum(&reference, &moved);
        let now = sum(&transposed(&mixed), &moved_now);
        Self { reference, mixed, now, moved, moved_now }
    }
}
