//! The stiffness of a body as if its bonds were springs: what preconditioners are made from.
//!
//! k_ij = V_i V_j (c_i g_i + c_j g_j)/2 along the bond as it is now, with g the formulation's weight of bonds and c
//! such that a family resists as that of bond_based does.

use crate::damage::BondState;
use crate::error::Result;
use crate::families::LANES;
use crate::memory;
use crate::plan::Plan;
use crate::solver::balance::PURPOSE;
use crate::tensor::{Tensor, Vector, dot};
use crate::workers::{PerPoint, Ragged, Workers};

use super::factor::Factor;

/// What the stiffness of a point has at least in every direction, over the mean of its directions.
const LEAST: f64 = 1e-3;

pub(super) struct BondStiffness<const D: usize> {
    /// Where points are now.
    pub(super) places: Vec<Vector<D>>,
    /// k over l^2, by lane; 0 where no bond acts.
    pub(super) springs: Vec<f64>,
    /// Other ends, by lane; the point itself where there is no bond.
    neighbors: Vec<u32>,
    /// Free directions of each point: 1, held ones 0.
    pub(super) free: Vec<Vector<D>>,
    /// Inverse of each point's own stiffness.
    pub(super) inverses: Vec<Tensor<D>>,
}

impl<const D: usize> BondStiffness<D> {
    pub(super) fn new(
        plan: &Plan,
        workers: &Workers,
        bonds: &BondState,
        displacement: &[f64],
        held: &[bool],
    ) -> Result<Self> {
        let count = plan.count();
        let mut places = memory::filled([0.0; D], count, PURPOSE)?;
        let mut free = memory::filled([1.0; D], count, PURPOSE)?;
        for (point, (place, free)) in places.iter_mut().zip(&mut free).enumerate() {
            for axis in 0..D {
                let component = point * D + axis;
                place[axis] = plan.places()[point][axis] + displacement[component];
                free[axis] = f64::from(u8::from(!held[component]));
            }
        }
        let factors = own_factors(plan, workers, displacement)?;
        let mut springs = memory::filled(0.0, plan.families.block_count() * LANES, PURPOSE)?;
        let offsets = &plan.families.offsets;
        let mut neighbors = memory::filled(0, springs.len(), PURPOSE)?;
        let outputs = (
            Ragged { values: &mut springs, offsets, width: LANES },
            Ragged { values: &mut neighbors, offsets, width: LANES },
        );
        workers.sweep(count, outputs, |range, (springs, neighbors)| {
            let start = offsets[range.start] as usize * LANES;
            for point in range {
                let blocks = plan.families.blocks(point);
                let lanes = blocks.start * LANES..blocks.end * LANES;
                let names = &mut neighbors.values[lanes.start - start..lanes.end - start];
                plan.families.name(point, lanes.start, names);
                for bond in plan.families.bonds(point) {
                    let there = bond.neighbor;
                    let weight = |end: usize, other: usize| {
                        let share = plan.families.reach.share(end, other, bond.length);
                        factors[end] * share * plan.formulation.spring_shape(end, bond.length)
                    };
                    let apart = apart(&places[point], &places[there]);
                    let squared = dot(&apart, &apart);
                    let volumes = plan.places()[point][3] * plan.places()[there][3];
                    let stiffness = 0.5 * (weight(point, there) + weight(there, point)) * volumes;
                    let spring = stiffness * bonds.integrity(bond.slot) / squared;
                    springs.values[bond.slot - start] =
                        if spring.is_finite() { spring } else { 0.0 };
                }
            }
        });
        let inverses = memory::filled([[0.0; D]; D], count, PURPOSE)?;
        let mut stiffness = Self { places, springs, neighbors, free, inverses };
        stiffness.invert(plan)?;
        Ok(stiffness)
    }

    fn invert(&mut self, plan: &Plan) -> Result<()> {
        for point in 0..plan.count() {
            let mut own = [[0.0; D]; D];
            for bond in plan.families.bonds(point) {
                let spring = self.springs[bond.slot];
                let apart = apart(&self.places[point], &self.places[bond.neighbor]);
                crate::tensor::add_outer(&mut own, spring, &apart, &apart);
            }
            let mean = crate::tensor::trace(&own) / D as f64;
            let free = &self.free[point];
            for (axis, row) in own.iter_mut().enumerate() {
                row[axis] += LEAST * mean;
                for (entry, other) in row.iter_mut().zip(free) {
                    *entry *= free[axis] * other;
                }
            }
            let matrix = memory::copied(own.as_flattened(), PURPOSE)?;
            Factor::new(matrix, D)?.inverse(self.inverses[point].as_flattened_mut());
        }
        Ok(())
    }

    /// z = factor D^-1 r, point by point.
    pub(super) fn divide(&self, workers: &Workers, factor: f64, r: &[f64], z: &mut [f64]) {
        z.fill(0.0);
        self.add_divided(workers, factor, r, z);
    }

    /// z += factor D^-1 r
    pub(super) fn add_divided(&self, workers: &Workers, factor: f64, r: &[f64], z: &mut [f64]) {
        let (r, _) = r.as_chunks::<D>();
        workers.sweep(self.places.len(), PerPoint(z, D), |range, z| {
            for (z, point) in z.0.as_chunks_mut::<D>().0.iter_mut().zip(range) {
                let moved = crate::tensor::applied(&self.inverses[point], &r[point]);
                z.iter_mut().zip(moved).for_each(|(z, moved)| *z += factor * moved);
            }
        });
    }

    /// left = r - K x
    pub(super) fn residual(
        &self,
        plan: &Plan,
        workers: &Workers,
        r: &[f64],
        x: &[f64],
        left: &mut [f64],
    ) {
        let ((r, _), (x, _)) = (r.as_chunks::<D>(), x.as_chunks::<D>());
        workers.sweep(plan.count(), PerPoint(left, D), |range, left| {
            let (left, _) = left.0.as_chunks_mut::<D>();
            for (left, point) in left.iter_mut().zip(range) {
                let blocks = plan.families.blocks(point);
                let lanes = blocks.start * LANES..blocks.end * LANES;
                let (place, own) = (&self.places[point], &x[point]);
                let mut sum = [0.0; D];
                let springs = &self.springs[lanes.clone()];
                for (spring, &there) in springs.iter().zip(&self.neighbors[lanes]) {
                    let there = there as usize;
                    let (apart, moved) = (apart(place, &self.places[there]), apart(own, &x[there]));
                    let pull = spring * dot(&apart, &moved);
                    for axis in 0..D {
                        sum[axis] += pull * apart[axis];
                    }
                }
                for axis in 0..D {
                    left[axis] = self.free[point][axis] * (r[point][axis] + sum[axis]);
                }
            }
        });
    }
}

/// c: what a weight of bonds is to be multiplied with, so that the family resists as springs of c/L do.
fn own_factors(plan: &Plan, workers: &Workers, displacement: &[f64]) -> Result<Vec<f64>> {
    let mut factors = memory::filled(0.0, plan.count(), PURPOSE)?;
    let intact = BondState::new(workers, &plan.families, plan.records())?;
    let scene = plan.scene(workers, &intact, displacement);
    plan.formulation.conventional_stiffness(&scene, &mut factors);
    workers.sweep(plan.count(), PerPoint(&mut factors, 1), |range, factors| {
        for (factor, point) in factors.0.iter_mut().zip(range) {
            let (mut inverse, mut lengths, mut weights) = (0.0, 0.0, 0.0);
            for bond in plan.families.bonds(point) {
                let volume = plan.families.share(point, bond) * plan.places()[bond.neighbor][3];
                inverse += volume / bond.length;
                lengths += volume * bond.length;
                let shape = plan.formulation.spring_shape(point, bond.length);
                weights += volume * shape * bond.length * bond.length;
            }
            *factor *= lengths / (inverse * weights);
            if !factor.is_finite() {
                *factor = 0.0;
            }
        }
    });
    Ok(factors)
}

#[inline(always)]
pub(super) fn apart<const D: usize>(from: &Vector<D>, to: &Vector<D>) -> Vector<D> {
    std::array::from_fn(|axis| to[axis] - from[axis])
}
