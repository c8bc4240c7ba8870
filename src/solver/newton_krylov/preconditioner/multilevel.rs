//! The global preconditioner: a symmetric cycle over the springs of a body and groups of its points that move as rigid
//! bodies.
//!
//! Weighted families average over all that is shorter than a horizon, so that one division by the points' own
//! stiffness wipes out short waves; groups a third of a horizon around a point take the long ones.

use super::aggregates::{Aggregates, modes};
use super::bond_stiffness::{BondStiffness, apart};
use super::coarse::{Level, Matrix, RowMaker};
use crate::error::Result;
use crate::memory;
use crate::plan::Plan;
use crate::solver::balance::PURPOSE;
use crate::tensor::{Vector, dot};
use crate::workers::Workers;

/// Reach of a group around its root, over the horizon; its shortest bonds always belong to it.
const GROUP: f64 = 0.35;
const SHORTEST: f64 = 1.05;

pub(super) struct Multilevel<const D: usize, const B: usize> {
    stiffness: BondStiffness<D>,
    groups: Aggregates<D>,
    scale: f64,
    below: Level<D, B>,
    left: Vec<f64>,
    coarse: [Vec<[f64; B]>; 2],
}

impl<const D: usize, const B: usize> Multilevel<D, B> {
    pub(super) fn new(plan: &Plan, workers: &Workers, stiffness: BondStiffness<D>) -> Result<Self> {
        let horizons = &plan.formulation.weights().horizons;
        let scale =
            (0..plan.count()).map(|point| horizons.at(point)).sum::<f64>() / plan.count() as f64;
        let near = |root: usize, take: &mut dyn FnMut(usize)| {
            let reach = (GROUP * horizons.at(root)).max(SHORTEST * shortest(plan, root));
            for bond in plan.families.bonds(root) {
                if bond.length <= reach && stiffness.springs[bond.slot] > 0.0 {
                    take(bond.neighbor);
                }
            }
        };
        let groups = Aggregates::new(&stiffness.places, near)?;
        let matrix = assembled(plan, &stiffness, &groups, scale)?;
        let centres = memory::copied(&groups.centres, PURPOSE)?;
        let below = Level::new(workers, matrix, centres, 3.0 * GROUP * scale, scale)?;
        let zeros = || memory::filled([0.0; B], groups.count(), PURPOSE);
        let coarse = [zeros()?, zeros()?];
        let left = memory::filled(0.0, plan.count() * D, PURPOSE)?;
        Ok(Self { stiffness, groups, scale, below, left, coarse })
    }

    /// z close to K^-1 r.
    pub(super) fn apply(&mut self, plan: &Plan, workers: &Workers, r: &[f64], z: &mut [f64]) {
        let Self { stiffness, groups, scale, below, left, coarse } = self;
        stiffness.divide(workers, 1.0, r, z);
        stiffness.residual(plan, workers, r, z, left);
        let [right, solution] = coarse;
        let mode = |point: usize| -> [Vector<D>; B] {
            let group = groups.of[point] as usize;
            let modes = modes(&apart(&groups.centres[group], &stiffness.places[point]), *scale);
            modes.map(|mode: Vector<D>| {
                std::array::from_fn(|axis| mode[axis] * stiffness.free[point][axis])
            })
        };
        right.iter_mut().for_each(|value| *value = [0.0; B]);
        for (point, left) in left.as_chunks::<D>().0.iter().enumerate() {
            let sums = &mut right[groups.of[point] as usize];
            for (sum, mode) in sums.iter_mut().zip(&mode(point)) {
                *sum += dot(mode, left);
            }
        }
        below.cycle(workers, right, solution);
        for (point, z) in z.as_chunks_mut::<D>().0.iter_mut().enumerate() {
            let factors = &solution[groups.of[point] as usize];
            for (factor, mode) in factors.iter().zip(&mode(point)) {
                for axis in 0..D {
                    z[axis] += factor * mode[axis];
                }
            }
        }
        stiffness.residual(plan, workers, r, z, left);
        stiffness.add_divided(workers, 1.0, left, z);
    }
}

/// Length of a point's shortest bond.
fn shortest(plan: &Plan, point: usize) -> f64 {
    plan.families.bonds(point).map(|bond| bond.length).fold(f64::INFINITY, f64::min)
}

/// P^T K P
fn assembled<const D: usize, const B: usize>(
    plan: &Plan,
    stiffness: &BondStiffness<D>,
    groups: &Aggregates<D>,
    scale: f64,
) -> Result<Matrix<B>> {
    let mut matrix = Matrix::new(groups.count())?;
    let mut maker = RowMaker::new(groups.count())?;
    // What a bond is stretched by the modes of the group at one of its ends.
    let stretched = |point: usize, along: &Vector<D>| -> [f64; B] {
        let centre = &groups.centres[groups.of[point] as usize];
        let modes: [Vector<D>; B] = modes(&apart(centre, &stiffness.places[point]), scale);
        let free = &stiffness.free[point];
        modes.map(|mode| (0..D).map(|axis| mode[axis] * free[axis] * along[axis]).sum())
    };
    for group in 0..groups.count() {
        for point in groups.members(group).iter().map(|&point| point as usize) {
            for bond in plan.families.bonds(point) {
                let spring = stiffness.springs[bond.slot];
                if spring == 0.0 {
                    continue;
                }
                let along = apart(&stiffness.places[point], &stiffness.places[bond.neighbor]);
                let own = stretched(point, &along);
                let there = stretched(bond.neighbor, &along);
                let other = groups.of[bond.neighbor] as usize;
                for (column, sign, with) in [(group, 1.0, &own), (other, -1.0, &there)] {
                    let block = maker.block(&mut matrix, column)?;
                    for (row, own) in block.iter_mut().zip(&own) {
                        for (entry, with) in row.iter_mut().zip(with) {
                            *entry += sign * spring * own * with;
                        }
                    }
                }
            }
        }
        maker.end_row(&mut matrix);
    }
    Ok(matrix)
}
