//! Laws with memory: asked with what they remember of the last committed state, in the directions a family spans.
//!
//! The law is one of a solid in space. Directions that the family leaves out turn with the others (`completion`); they,
//! and the direction across a plate in plane stress, are stretched until they have no stress.

use super::completion::{completed, turned};
use super::hypoelastic::{Memory, NUMBERS};
use super::{Across, Answer, DISSIPATED, Deformation, ENERGY, Kind, Law, MEMORY, PENDING};
use crate::tensor::{
    Tensor, contracted, difference, identity, product, read, resized, scaled, sum,
};

/// Tries at the stretch of free directions.
pub(super) const TRIES: usize = 60;

/// What a law has answered at a site, and what it remembers.
#[derive(Clone, Copy)]
pub(crate) struct Record<'a>(&'a [f64]);

impl<'a> Record<'a> {
    pub(crate) fn at(records: &'a [f64], width: usize, site: usize) -> Self {
        Self(&records[site * width..(site + 1) * width])
    }

    /// Which of its numbers is the energy: what is stored, or what was not given back.
    pub(crate) fn energy_at(dissipated: bool) -> usize {
        if dissipated { DISSIPATED } else { ENERGY }
    }

    /// The answer; with `dissipated` the energy is what was not given back.
    pub(crate) fn answer<const D: usize>(&self, span: &Tensor<D>, dissipated: bool) -> Answer<D> {
        let stress: Tensor<3> = read(self.0);
        let energy = self.0[Self::energy_at(dissipated)];
        Answer { energy, stress: product(&resized(&stress), span) }
    }

    /// Stretch of free directions, and across a plate its thickness and P_33.
    pub(crate) fn across<const D: usize>(&self, deformation: &Deformation<D>) -> Across {
        let memory = Memory::read(&self.0[MEMORY..]);
        let plate = D == 2;
        let thickness = if plate { 1.0 + memory.gradient[2][2] } else { 1.0 };
        let turned = turned(deformation);
        let stretch =
            if deformation.rank < D { last_stretch(&memory, &turned, false) } else { 1.0 };
        Across { stretch, thickness, held: if plate { self.0[8] } else { 0.0 } }
    }

    pub(crate) fn plastic_strain(&self) -> (Tensor<3>, f64) {
        let memory = Memory::read(&self.0[MEMORY..]);
        (memory.plastic_strain, memory.equivalent)
    }
}

impl Law {
    /// Answers a deformation after the record `old` of the last committed state, into the record `new`; with its
    /// elastic stiffness alone unless it `flows`.
    pub(crate) fn remember<const D: usize>(
        &self,
        deformation: &Deformation<D>,
        old: &[f64],
        new: &mut [f64],
        flows: bool,
    ) {
        if deformation.rank == 0 {
            // Nothing is known of it: it stays as it was, and does not pull.
            new.copy_from_slice(old);
            new[..9].fill(0.0);
            return;
        }
        if self.kind == Kind::Host {
            let gradient = completed(deformation, 1.0);
            new[MEMORY..MEMORY + D * D].copy_from_slice(gradient.as_flattened());
            new[PENDING] = 1.0;
            return;
        }
        let Kind::Hypoelastic(plastic) = self.kind else {
            // It remembers nothing.
            let Answer { energy, stress } = self.answer(deformation);
            let stress: Tensor<3> = resized(&stress);
            new[..9].copy_from_slice(stress.as_flattened());
            (new[ENERGY], new[DISSIPATED]) = (energy, 0.0);
            return;
        };
        let plastic = plastic.filter(|_| flows);
        let before = Memory::read(&old[MEMORY..]);
        let turned = turned(deformation);
        let missing = difference(&identity(), &deformation.span);
        let base = difference(&deformation.gradient, &missing);
        let free = f64::from(self.free[deformation.rank]);
        let plate = D == 2 && !self.is_held_across;
        let moved = |stretch: f64| {
            let mut gradient: Tensor<3> = resized(&sum(&base, &scaled(&turned, stretch)));
            if plate {
                gradient[2][2] = stretch - 1.0;
            }
            before.moved(self, plastic, &gradient)
        };
        // Stress in the free directions, as the slope of the energy by their stretch.
        let slope = |memory: &Memory| {
            let stress = memory.first_piola_stress();
            contracted(&resized(&stress), &turned) + if plate { stress[2][2] } else { 0.0 }
        };
        let mut stretch = if free > 0.0 { last_stretch(&before, &turned, plate) } else { 1.0 };
        let mut memory = moved(stretch);
        if free > 0.0 {
            let (lambda, mu) = self.solid();
            let stiffness = free * (free * lambda + 2.0 * mu);
            let mut now = slope(&memory);
            let mut step = -now / stiffness;
            for _ in 0..TRIES {
                if now == 0.0 || step.abs() <= 1e-16 || step.is_nan() {
                    break;
                }
                let (last, at) = (now, stretch);
                stretch += step;
                memory = moved(stretch);
                now = slope(&memory);
                // The secant; back to the elastic slope where it is none.
                let secant = (now - last) / (stretch - at);
                let rigid = if secant > 1e-3 * stiffness { secant } else { stiffness };
                step = -now / rigid;
            }
        }
        let stress = memory.first_piola_stress();
        new[..9].copy_from_slice(stress.as_flattened());
        new[ENERGY] = memory.elastic();
        new[DISSIPATED] = memory.dissipated;
        memory.write(&mut new[MEMORY..MEMORY + NUMBERS]);
    }
}

/// Stretch of the free directions in the committed state.
fn last_stretch<const D: usize>(before: &Memory, turned: &Tensor<D>, plate: bool) -> f64 {
    if plate {
        return 1.0 + before.gradient[2][2];
    }
    let plane: Tensor<D> = resized(&before.gradient);
    let size = contracted(turned, turned);
    if size > 0.0 { contracted(&sum(&identity(), &plane), turned) / size } else { 1.0 }
}
