//! Linear elasticity of small strains: eps = sym F - I, W = lambda/2 tr(eps)^2 + mu eps:eps,
//! P = lambda tr(eps) I + 2 mu eps. It takes a rotation for a strain.

use super::{Answer, Deformation, Law};
use crate::tensor::{contracted, product, scaled, sum, symmetric, trace};

pub(super) fn answer<const D: usize>(law: &Law, deformation: &Deformation<D>) -> Answer<D> {
    let (lambda, mu) = law.constants(deformation.rank);
    let strain = symmetric(&product(&deformation.span, &deformation.gradient));
    let volume_change = trace(&strain);
    let energy = 0.5 * lambda * volume_change * volume_change + mu * contracted(&strain, &strain);
    let stress =
        sum(&scaled(&deformation.span, lambda * volume_change), &scaled(&strain, 2.0 * mu));
    Answer { energy, stress }
}
