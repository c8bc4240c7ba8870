//! Materials: what energy a deformation costs, and what stress it makes. One file a law.
//!
//! A law is asked in the directions that a family spans. Where these are fewer than the body has (a
//! plate one point thick, a chain, a family thinned by broken bonds), and across a plate in plane stress,
//! the material is free to thicken or thin: it has no stress there. Across plane strain it is held. So a
//! rigid motion costs nothing whatever a family spans, and the stress is the slope of the energy.

mod across;
mod completion;
mod host;
mod hypoelastic;
mod hypoelastic_lanes;
mod neo_hookean;
mod remember;
mod saint_venant_kirchhoff;
mod small_strain;
#[cfg(test)]
mod tests;

pub(crate) use across::Across;
pub(crate) use completion::completed;
pub use host::MaterialBatch;
pub(crate) use host::{HostLaw, Room};
pub(crate) use hypoelastic_lanes::Settle;
pub(crate) use remember::Record;

use crate::error::Result;
use crate::kernel::elastic::{ElasticLaw, Elasticity};
use crate::model::{Elastic, Model, Plane};
use crate::tensor::Tensor;
use hypoelastic::Plastic;

/// How a material answers a deformation.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    SaintVenantKirchhoff,
    NeoHookean,
    SmallStrain,
    /// It remembers: see [`Law::remember`].
    Hypoelastic(Option<Plastic>),
    /// The host's own function, asked in batches.
    Host,
}

/// A law with its constants.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Law {
    kind: Kind,
    shear_modulus: f64,
    /// lambda of the solid.
    lambda: f64,
    /// lambda with the free directions condensed, by the number of directions that a family spans.
    condensed: [f64; 4],
    /// Directions across that are free of stress, by the number of directions that a family spans.
    free: [u8; 4],
    /// Whether the body is in plane strain.
    is_held_across: bool,
}

/// A deformation in the directions that a family spans.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deformation<const D: usize> {
    /// Gradient of the displacement, 0 in the directions that the family does not span.
    pub(crate) gradient: Tensor<D>,
    /// Projector onto what the family spans.
    pub(crate) span: Tensor<D>,
    /// Number of directions that the family spans.
    pub(crate) rank: usize,
}

/// What a law answers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer<const D: usize> {
    /// Energy per reference volume.
    pub(crate) energy: f64,
    /// First Piola-Kirchhoff stress, 0 in the directions that the family does not span.
    pub(crate) stress: Tensor<D>,
}

/// Numbers of a record, with the size of a host's state: what a law with memory has answered at a site, and what it
/// remembers there. The stress P as of a solid in space, the energies, and the memory. A multiple of four.
pub(crate) const fn record_width(host: Option<usize>) -> usize {
    let memory = match host {
        Some(state) if 9 + state > hypoelastic::NUMBERS => 9 + state,
        _ => hypoelastic::NUMBERS,
    };
    (MEMORY + memory).next_multiple_of(4)
}

/// Where a record has the energy.
const ENERGY: usize = 9;
const DISSIPATED: usize = 10;
/// Where a record says that a function of the host's is still to be asked.
const PENDING: usize = 11;
pub(crate) const MEMORY: usize = 12;

impl Law {
    /// The law of a model in a body of so many dimensions.
    pub(crate) fn new(model: &Model, dimension: usize) -> Result<Self> {
        Ok(Self::with(&model.elastic()?, model, dimension))
    }

    /// The law of a model whose constants are known.
    pub(crate) fn with(elastic: &Elastic, model: &Model, dimension: usize) -> Self {
        let (lambda, mu) = (elastic.lame_lambda, elastic.shear_modulus);
        // sigma = 0 across: lambda (tr + e) + 2 mu e = 0.
        let condense = |lambda: f64| 2.0 * lambda * mu / (lambda + 2.0 * mu);
        let is_held_across = dimension == 2 && model.plane() == Plane::Strain;
        let full = if is_held_across { 2 } else { 3 };
        let (mut condensed, mut free) = ([lambda; 4], [0; 4]);
        for rank in (0..full).rev() {
            condensed[rank] = condense(condensed[rank + 1]);
            free[rank] = free[rank + 1] + 1;
        }
        let kind = match model.material() {
            _ if model.host_law().is_some() => Kind::Host,
            "neo_hookean" => Kind::NeoHookean,
            "small_strain" => Kind::SmallStrain,
            "hypoelastic" => Kind::Hypoelastic(None),
            "j2_plastic" => Kind::Hypoelastic(Some(Plastic {
                yield_stress: model.number("yield_stress").unwrap_or(f64::NAN),
                hardening: model.number("hardening_modulus").unwrap_or(0.0),
            })),
            _ => Kind::SaintVenantKirchhoff,
        };
        Self { kind, shear_modulus: mu, lambda, condensed, free, is_held_across }
    }

    /// Energy and stress of a deformation. Where the law does not bear it, such as one turned inside out,
    /// they are not numbers.
    pub(crate) fn answer<const D: usize>(&self, deformation: &Deformation<D>) -> Answer<D> {
        if deformation.rank == 0 {
            return Answer { energy: 0.0, stress: crate::tensor::zero() };
        }
        match self.kind {
            Kind::SaintVenantKirchhoff => saint_venant_kirchhoff::answer(self, deformation),
            Kind::NeoHookean => neo_hookean::answer(self, deformation),
            Kind::SmallStrain => small_strain::answer(self, deformation),
            // Asked by `remember`.
            Kind::Hypoelastic(_) | Kind::Host => {
                Answer { energy: 0.0, stress: crate::tensor::zero() }
            }
        }
    }

    /// The law for lanes, of families that span the body, if it is an elastic one.
    pub(crate) fn in_lanes(&self, dimension: usize) -> Option<ElasticLaw> {
        let is_free = self.free[dimension] > 0;
        let (elasticity, (lambda, mu)) = match self.kind {
            Kind::SaintVenantKirchhoff => (Elasticity::SaintVenantKirchhoff, self.plane(dimension)),
            Kind::SmallStrain => (Elasticity::SmallStrain, self.plane(dimension)),
            Kind::NeoHookean if is_free => (Elasticity::NeoHookeanPlate, self.solid()),
            Kind::NeoHookean => (Elasticity::NeoHookean, self.solid()),
            Kind::Hypoelastic(_) | Kind::Host => return None,
        };
        Some(ElasticLaw { elasticity, lambda, mu })
    }

    /// Whether it is asked by [`Law::remember`].
    pub(crate) fn has_memory(&self) -> bool {
        matches!(self.kind, Kind::Hypoelastic(_) | Kind::Host)
    }

    /// Whether it remembers what lies across, and what has flowed; a law of the host's does not say.
    pub(crate) fn knows_across(&self) -> bool {
        matches!(self.kind, Kind::Hypoelastic(_))
    }

    /// lambda and mu for a family that spans so many directions.
    fn constants(&self, rank: usize) -> (f64, f64) {
        (self.condensed[rank], self.shear_modulus)
    }

    /// lambda and mu for a family that spans the body.
    pub(crate) fn plane(&self, dimension: usize) -> (f64, f64) {
        self.constants(dimension)
    }

    /// lambda and mu of the solid.
    pub(crate) fn solid(&self) -> (f64, f64) {
        (self.lambda, self.shear_modulus)
    }
}

impl<const D: usize> Deformation<D> {
    /// Of a family that spans the body.
    #[inline(always)]
    pub(crate) fn whole(gradient: &Tensor<D>) -> Self {
        Self { gradient: *gradient, span: crate::tensor::identity(), rank: D }
    }

    /// The deformation gradient, 0 in the directions that the family does not span.
    pub(crate) fn full(&self) -> Tensor<D> {
        crate::tensor::sum(&self.span, &self.gradient)
    }

    /// 2 E = C - I in the directions spanned; exactly 0 at rest.
    pub(crate) fn twice_strain(&self) -> Tensor<D> {
        let mut strain = crate::tensor::product(&self.span, &self.gradient);
        strain = crate::tensor::sum(&strain, &crate::tensor::transposed(&strain));
        for row in &self.gradient {
            crate::tensor::add_outer(&mut strain, 1.0, row, row);
        }
        strain
    }
}
