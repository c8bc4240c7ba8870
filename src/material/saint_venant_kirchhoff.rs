//! Saint Venant-Kirchhoff: E = (F^T F - I)/2, W = lambda/2 tr(E)^2 + mu E:E, P = F (lambda tr(E) I + 2 mu E).

use super::{Answer, Deformation, Law};
use crate::tensor::{contracted, product, scaled, sum, trace};

#[inline(always)]
pub(super) fn answer<const D: usize>(law: &Law, deformation: &Deformation<D>) -> Answer<D> {
    let (lambda, mu) = law.constants(deformation.rank);
    let strain = scaled(&deformation.twice_strain(), 0.5);
    let volume_change = trace(&strain);
    let energy = 0.5 * lambda * volume_change * volume_change + mu * contracted(&strain, &strain);
    let second =
        sum(&scaled(&deformation.span, lambda * volume_change), &scaled(&strain, 2.0 * mu));
    Answer { energy, stress: product(&deformation.full(), &second) }
}
