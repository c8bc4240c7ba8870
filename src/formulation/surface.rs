//! Surface corrections, and that by energy: bonds near a surface are made stiffer until a stretch along each axis
//! stores what the material says. (Le and Bobaru; Madenci and Oterkus)
//!
//! For each axis a the body is stretched by 1.001: m_a = (lambda/2 + mu) (0.001)^2/W_i;
//! beta_ij = [sum_a (n_a/mbar_a)^2]^-1/2 with the mean mbar_a of both ends.

use super::{EnergyPart, Formulation, Scene};
use crate::error::Result;
use crate::families::LANES;
use crate::memory;
use crate::model::SurfaceCorrection;
use crate::workers::Ragged;

/// How a surface is to be corrected, and lambda/2 + mu of each point.
pub(super) struct Surface<T> {
    pub(super) correction: SurfaceCorrection,
    pub(super) moduli: T,
}

/// What the bond in each lane counts more in the family of its own end, and in that of the other; the latter is empty
/// where both are alike.
pub(super) struct Correction {
    pub(super) own: Vec<f64>,
    pub(super) other: Vec<f64>,
}

impl Correction {
    #[inline(always)]
    pub(super) fn at(&self, slot: usize) -> [f64; 2] {
        let own = self.own[slot];
        [own, if self.is_shared() { own } else { self.other[slot] }]
    }

    /// Whether both ends give a bond the same factor.
    #[inline(always)]
    pub(super) fn is_shared(&self) -> bool {
        self.other.is_empty()
    }

    pub(super) fn bytes(&self) -> usize {
        memory::bytes(&self.own) + memory::bytes(&self.other)
    }
}

/// What each axis is stretched by.
const STRETCH: f64 = 0.001;

const PURPOSE: &str = "surface factors";

/// beta of each lane, from the energies of a formulation that has no correction yet; `modulus`: lambda/2 + mu of a point.
pub(super) fn factors(
    scene: &Scene<'_>,
    formulation: &impl Formulation,
    modulus: impl Fn(usize) -> f64,
) -> Result<Correction> {
    let (dimension, count) = (scene.dimension, scene.places.len());
    let mut displacement = memory::filled(0.0, count * dimension, PURPOSE)?;
    let mut density = memory::filled(0.0, count, PURPOSE)?;
    let room = formulation.scratch(count, scene.families.block_count(), dimension, false);
    let mut scratch = memory::filled(0.0, room, PURPOSE)?;
    let mut measures = memory::filled([1.0; 3], count, PURPOSE)?;
    for axis in 0..dimension {
        displacement.fill(0.0);
        for (point, place) in scene.places.iter().enumerate() {
            displacement[point * dimension + axis] = STRETCH * place[axis];
        }
        let stretched = Scene { displacement: &displacement, ..*scene };
        formulation.energy_density(&stretched, &mut scratch, &mut density, EnergyPart::Strain);
        for (point, measure) in measures.iter_mut().enumerate() {
            // A point without a bond has nothing to be corrected.
            if density[point] > 0.0 {
                measure[axis] = modulus(point) * STRETCH * STRETCH / density[point];
            }
        }
    }
    let families = scene.families;
    let mut factors = memory::filled(1.0, families.block_count() * LANES, PURPOSE)?;
    let values = Ragged { values: &mut factors[..], offsets: &families.offsets, width: LANES };
    scene.workers.sweep(count, values, |range, values| {
        let first = families.offsets[range.start] as usize * LANES;
        for point in range {
            for bond in families.bonds(point) {
                let (from, to) = (&scene.places[point], &scene.places[bond.neighbor]);
                let mut sum = 0.0;
                for axis in 0..dimension {
                    let direction = (to[axis] - from[axis]) / bond.length;
                    let mean = 0.5 * (measures[point][axis] + measures[bond.neighbor][axis]);
                    sum += (direction / mean).powi(2);
                }
                values.values[bond.slot - first] = sum.powf(-0.5);
            }
        }
    });
    Ok(Correction { own: factors, other: Vec::new() })
}
