//! What the fields of deformation and stress are made of.
//!
//! Bonds without a law have a deformation gradient all the same, that of their family's shape tensor, and a stress
//! averaged over the family, P_i = 1/2 sum (t_ij - t_ji) (x) xi V_j: the virial or areal stress. In a body strained
//! alike everywhere it is the force that bonds send through a unit of area; near a surface or a crack, where the
//! family is cut, it is less.

use super::body::{Body, Link};
use super::correspondence::gradient_at;
use super::gradient::Shape;
use crate::kernel::fields::BondSums;
use crate::material::{Across, Deformation, Law, completed};
use crate::tensor::{
    Tensor, add_outer, contracted, determinant, difference, identity, product, resized, scaled,
    sum, symmetric, trace, transposed, zero,
};

/// Deformation and stress of a point, as of a solid in space: a 2D body has them across itself too.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kinematics {
    /// F - I, exactly 0 at rest.
    pub(crate) displacement_gradient: Tensor<3>,
    /// First Piola-Kirchhoff stress.
    pub(crate) first_piola_stress: Tensor<3>,
    /// Change of volume per volume, in 2D of area.
    pub(crate) dilatation: f64,
    /// Plastic strain in the rotated frame, and its equivalent.
    pub(crate) plastic_strain: Tensor<3>,
    pub(crate) equivalent_plastic_strain: f64,
}

/// The mean of several with their weights; at rest where there is none.
pub(super) struct Mean {
    of: Kinematics,
    whole: f64,
}

impl Mean {
    pub(super) fn new() -> Self {
        let of = Kinematics {
            displacement_gradient: zero(),
            first_piola_stress: zero(),
            dilatation: 0.0,
            plastic_strain: zero(),
            equivalent_plastic_strain: 0.0,
        };
        Self { of, whole: 0.0 }
    }

    pub(super) fn add(&mut self, weight: f64, part: &Kinematics) {
        self.whole += weight;
        // A running mean, which is exact where all are alike.
        let share = if self.whole > 0.0 { weight / self.whole } else { 0.0 };
        let towards = |mean: &mut Tensor<3>, part: &Tensor<3>| {
            *mean = sum(mean, &scaled(&difference(part, mean), share));
        };
        let mean = &mut self.of;
        towards(&mut mean.displacement_gradient, &part.displacement_gradient);
        towards(&mut mean.first_piola_stress, &part.first_piola_stress);
        mean.dilatation += share * (part.dilatation - mean.dilatation);
        towards(&mut mean.plastic_strain, &part.plastic_strain);
        mean.equivalent_plastic_strain +=
            share * (part.equivalent_plastic_strain - mean.equivalent_plastic_strain);
    }

    pub(super) fn made(self) -> Kinematics {
        self.of
    }
}

impl Kinematics {
    /// Of a deformation that is completed here, and the stress in it; the dilatation is det F - 1.
    pub(super) fn new<const D: usize>(
        deformation: &Deformation<D>,
        stress: &Tensor<D>,
        across: Across,
    ) -> Self {
        let gradient = completed(deformation, across.stretch);
        let mut made = Self {
            displacement_gradient: resized(&gradient),
            first_piola_stress: resized(stress),
            dilatation: 0.0,
            plastic_strain: zero(),
            equivalent_plastic_strain: 0.0,
        };
        // Before the plate has thinned.
        made.dilatation = volume_change(&made.displacement_gradient);
        if D == 2 {
            made.displacement_gradient[2][2] = across.thickness - 1.0;
            made.first_piola_stress[2][2] = across.held;
        }
        made
    }

    pub(super) fn with_plastic(self, (strain, equivalent): (Tensor<3>, f64)) -> Self {
        Self { plastic_strain: strain, equivalent_plastic_strain: equivalent, ..self }
    }

    /// Of bonds that pull; `tension`: |t_ij| + |t_ji| and the deformed length of a bond.
    pub(super) fn of_bonds<const D: usize>(
        body: &Body<'_, D>,
        point: usize,
        law: &Law,
        tension: impl Fn(&Link<D>) -> (f64, f64),
    ) -> Self {
        let (operator, gradient, ..) = gradient_at(body, point, 1);
        let shape = operator.shape;
        let deformation = Deformation { gradient, span: shape.span, rank: shape.rank };
        let mut stress = zero();
        for link in body.links(point) {
            let (tension, now) = tension(&link);
            if now > 0.0 {
                let factor = 0.5 * tension * link.volume / now;
                add_outer(&mut stress, factor, &link.deformed(), &link.reference);
            }
        }
        let stress = product(&stress, &shape.span);
        Self::of_pulls(&deformation, &stress, law)
    }

    /// The same from sums over the bonds; `None` where the family does not span all directions alike.
    pub(super) fn of_sums<const D: usize>(sums: &BondSums<f64, D>, law: &Law) -> Option<Self> {
        let shape = Shape::new(&sums.shape);
        if !shape.is_round() {
            return None;
        }
        let deformation = Deformation::whole(&product(&sums.moved, &shape.inverse));
        Some(Self::of_pulls(&deformation, &scaled(&sums.pulled, 0.5), law))
    }

    fn of_pulls<const D: usize>(
        deformation: &Deformation<D>,
        stress: &Tensor<D>,
        law: &Law,
    ) -> Self {
        let across = law.across_bonds(deformation, contracted(stress, &deformation.full()));
        Self::new(deformation, stress, across)
    }

    /// F
    pub(crate) fn deformation_gradient(&self) -> Tensor<3> {
        sum(&identity(), &self.displacement_gradient)
    }

    /// Green-Lagrange strain.
    pub(crate) fn strain(&self) -> Tensor<3> {
        let gradient = &self.displacement_gradient;
        let squares = product(&transposed(gradient), gradient);
        sum(&symmetric(gradient), &scaled(&squares, 0.5))
    }

    /// P F^T/J
    pub(crate) fn cauchy_stress(&self) -> Tensor<3> {
        let gradient = self.deformation_gradient();
        let stress = product(&self.first_piola_stress, &transposed(&gradient));
        let jacobian = determinant(&gradient);
        stress.map(|row| row.map(|value| value / jacobian))
    }

    /// Of the symmetric part of the Cauchy stress.
    pub(crate) fn von_mises_stress(&self) -> f64 {
        let stress = symmetric(&self.cauchy_stress());
        let pressure = scaled(&identity(), -trace(&stress) / 3.0);
        let deviator = sum(&stress, &pressure);
        (1.5 * contracted(&deviator, &deviator)).sqrt()
    }
}

/// det (I + H) - 1, without the cancellation.
fn volume_change(gradient: &Tensor<3>) -> f64 {
    let first = trace(gradient);
    let second = 0.5 * (first * first - trace(&product(gradient, gradient)));
    first + second + determinant(gradient)
}
