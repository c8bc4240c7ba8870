//! Correspondence on a body that is a lattice: gradients and pulls of eight points at once, laws asked between.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use super::body::Body;
use super::correspondence::Correspondence;
use super::kept_rows::keep;
use super::on_lattice::{LatticeState, OnLattice, Parts, masks_as_they_are};
use super::passes::ForceSweep;
use super::{Scene, in_lanes};
use crate::error::Result;
use crate::families::LANES;
use crate::families::lattice::Lattice;
use crate::kernel::gradient::{Kept, Moments, kept_width};
use crate::kernel::lattice::{Breaks, PullSweep, StressSweep, is_odd, kept_sums};
use crate::kernel::quadrature::Stress;
use crate::material::{Answer, Deformation};
use crate::memory;
use crate::tensor::{Tensor, applied, product, scaled};
use crate::workers::PerPoint;

const PURPOSE: &str = "gradients on lattices";

/// What is held of a lattice.
pub(super) struct LatticeRows {
    state: LatticeState,
    kept: Mutex<Store>,
}

/// What is kept of groups, eight of each number, in the unit of the lattice and with a volume of 1, and the masks that it
/// belongs to.
struct Store {
    numbers: Vec<f64>,
    masks: Vec<u8>,
}

impl LatticeRows {
    pub(super) fn new(scene: &Scene<'_>, lattice: &Lattice) -> Result<Self> {
        let dimension = scene.dimension;
        let (seats, each) = (lattice.members.len(), kept_width(dimension, dimension));
        let numbers = scene.workers.filled(0.0, seats * each, PURPOSE)?;
        let masks = scene.workers.filled(0, lattice.groups.len() * lattice.row(), PURPOSE)?;
        let state = LatticeState::new(scene, lattice, dimension * dimension, true)?;
        Ok(Self { state, kept: Mutex::new(Store { numbers, masks }) })
    }

    pub(super) fn bytes(&self) -> usize {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        self.state.bytes() + memory::bytes(&kept.numbers) + memory::bytes(&kept.masks)
    }
}

impl Correspondence {
    /// Whether its sweeps are faster on a lattice.
    pub(super) fn fits_lattice(&self) -> bool {
        let elastic = !(self.laws.remember() || self.is_stabilised());
        !self.strong && elastic && self.order == 1 && self.weights.are_shared()
    }

    pub(super) fn forces_on_lattice<const D: usize, const N: usize>(
        &self,
        (lattice, rows): (&Lattice, &LatticeRows),
        sweep: ForceSweep<'_, '_>,
    ) -> Option<usize> {
        let ForceSweep { scene, force, breaking, .. } = sweep;
        let omega = self.kept.omega(scene, &self.weights)?;
        let on = OnLattice::breaking(scene, (lattice, &rows.state), breaking.as_ref());
        let each = kept_width(D, D);
        let (any_odd, bad) = (AtomicBool::new(false), AtomicUsize::new(usize::MAX));
        let noted = |point: usize, answer: Answer<D>| {
            if !answer.energy.is_finite() {
                bad.fetch_min(point, Ordering::Relaxed);
            }
            answer.stress
        };
        let stress = |point: usize, deformation: &Deformation<D>| {
            noted(point, self.laws.at(point).answer(deformation))
        };
        let law = self.laws.only().and_then(|law| law.saint_venant_kirchhoff(D));
        let law = law.map(|(lambda, mu)| Stress { lambda, mu });
        let first = |parts: &mut Parts<'_, D, N>| {
            let mut kept = rows.kept.lock().unwrap_or_else(PoisonError::into_inner);
            let Store { numbers, masks } = &mut *kept;
            let kept =
                (PerPoint(&mut numbers[..], each), PerPoint(&mut masks[..], lattice.row() / LANES));
            let (groups, look, judge) = (parts.groups, parts.look, on.limits);
            let horizon = omega.horizon / parts.unit;
            let outputs = (parts.forces.again(), parts.left.again());
            let outputs = (outputs, parts.masks.again(), parts.broke.again(), kept);
            scene.workers.sweep(
                parts.seats,
                outputs,
                |range, ((force, left), masks, broke, (numbers, kept_masks))| {
                    let sweep = StressSweep {
                        groups,
                        range: range.start / LANES..range.end / LANES,
                        kept: Kept { numbers: numbers.0, masks: kept_masks.0 },
                        keep: |moments: &Moments, kept: &mut [f64]| {
                            keep::<D, D>(self.order(), horizon, moments, kept);
                        },
                        law,
                        ask: |seat: usize, gradient: &Tensor<D>| {
                            stress(lattice.members[seat] as usize, &Deformation::whole(gradient))
                        },
                        force: force.0,
                        left: left.values,
                        first: left.first,
                        breaks: Breaks { masks: masks.0, broke: broke.0, judge, look },
                    };
                    let (odd, found) = scene.simd.run(sweep);
                    if odd {
                        any_odd.store(true, Ordering::Relaxed);
                    }
                    bad.fetch_min(found.unwrap_or(usize::MAX), Ordering::Relaxed);
                },
            );
        };
        let second = |mut parts: Parts<'_, D, N>, scene: &Scene<'_>| {
            let unit = parts.unit;
            if any_odd.load(Ordering::Relaxed) {
                let kept = rows.kept.lock().unwrap_or_else(PoisonError::into_inner);
                let body = &Body::<D>::new(scene, &self.weights);
                let outputs = (parts.forces.again(), parts.left.again());
                scene.workers.sweep(parts.seats, outputs, |range, (force, left)| {
                    for (number, seat) in range.enumerate() {
                        let (group, lane) = (seat / LANES, seat % LANES);
                        let kept = &kept.numbers[group * LANES * each..][..LANES * each];
                        let point = lattice.members[seat];
                        if !is_odd(kept, point, lane) {
                            continue;
                        }
                        let own = self.own(body, point as usize);
                        let stress = noted(point as usize, own.answer);
                        let rows = &own.gradient.rows;
                        let rows: Tensor<D> = rows.map(|row| std::array::from_fn(|k| row[k]));
                        let tensor = scaled(&product(&stress, &rows), lattice.volume * unit * unit);
                        let pull = applied(&tensor, &kept_sums(kept, lane));
                        let cell = lattice.cell(seat) - left.first;
                        for (axis, (row, pull)) in tensor.iter().zip(pull).enumerate() {
                            force.0[(number / LANES * D + axis) * LANES + lane] = pull;
                            for (column, value) in row.iter().enumerate() {
                                left.values[axis * D + column][cell] = *value;
                            }
                        }
                    }
                });
            }
            let Parts { groups, seats, masks, forces, left, .. } = parts;
            let left = left.values.map(|column| &*column);
            scene.workers.sweep(seats, (forces, masks), |range, (force, masks)| {
                let range = range.start / LANES..range.end / LANES;
                let (force, masks) = (force.0, &*masks.0);
                scene.simd.run(PullSweep { groups, left, range, masks, force });
            });
            unit.recip()
        };
        let influence = |length: f64| omega.at(length);
        let remaining = masks_as_they_are(scene, breaking);
        let found = on.sweep(scene, influence, first, second, force, remaining);
        // The point whose material has failed is to be named, and not one that it pulls on.
        in_lanes::first(bad).or_else(|| (found != usize::MAX).then_some(found))
    }
}
