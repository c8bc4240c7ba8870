//! Sweeps in lanes for formulations of a deformation gradient. What makes the gradient of a point follows from its
//! bonds alone: it is kept here with the bond masks it belongs to, and made anew only where a bond of the family has
//! changed. So what is kept is right whatever a call does with what it finds, be it a look or a step that fails.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::body::Weights;
use super::gradient::{Gradient, width};
use super::{Scene, in_lanes};
use crate::damage::Breaking;
use crate::error::Result;
use crate::kernel::family::{Family, Omega, Record, Table};
use crate::kernel::gradient::{GradientSweep, Kept, Kind, Moments, kept_width};
use crate::kernel::gradient_pull::GradientPull;
use crate::memory;
use crate::tensor::{Tensor, Vector};
use crate::workers::{PerPoint, Ragged};

const PURPOSE: &str = "gradients of points";

/// Rows of all points, where they are worth keeping.
#[derive(Default)]
pub(super) struct KeptRows {
    kept: Mutex<Store>,
}

#[derive(Default)]
struct Store {
    numbers: Vec<f64>,
    masks: Vec<u8>,
}

/// How gradients are made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order {
    pub(super) order: usize,
    /// Gradients whose rounding is worth it are made in two steps.
    pub(super) looks_twice: bool,
}

/// What is kept of a point.
#[derive(Clone, Copy)]
pub(super) struct Point<'a, const D: usize, const SIZE: usize>(&'a [f64]);

impl<'a, const D: usize, const SIZE: usize> Point<'a, D, SIZE> {
    /// 1/sum w V, 0 without a family.
    pub(super) fn inverse_weight(&self) -> f64 {
        self.0[1]
    }

    /// Whether the family spans the body.
    pub(super) fn spans(&self) -> bool {
        Kind::of(self.0) != Kind::Odd
    }

    /// A row of the gradient.
    pub(super) fn row(&self, axis: usize) -> &'a [f64] {
        &self.0[2 + axis * SIZE..2 + (axis + 1) * SIZE]
    }

    /// sum w q V
    fn sums(&self) -> &'a [f64] {
        &self.0[2 + D * SIZE..]
    }
}

/// A sweep's scene and tables.
pub(super) struct Sweep<'a, const D: usize, const C: usize> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) omega: Omega,
    pub(super) records: &'a [Record],
    pub(super) force: &'a mut [f64],
    pub(super) left: &'a mut [[f64; C]],
}

impl KeptRows {
    /// Makes room, if bodies as a scene is are swept in lanes.
    pub(super) fn refer_to(
        &mut self,
        scene: &Scene<'_>,
        weights: &Weights,
        order: usize,
    ) -> Result<()> {
        let kept = self.kept.get_mut().unwrap_or_else(PoisonError::into_inner);
        if in_lanes::omega(scene, weights).is_none() {
            return Ok(());
        }
        let each = kept_width(scene.dimension, width(order, scene.dimension));
        kept.numbers = scene.workers.filled(0.0, scene.places.len() * each, PURPOSE)?;
        kept.masks = scene.workers.filled(0, scene.families.block_count(), PURPOSE)?;
        Ok(())
    }

    /// The influence of a scene that can be swept in lanes.
    pub(super) fn omega(&self, scene: &Scene<'_>, weights: &Weights) -> Option<Omega> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.numbers.is_empty() { None } else { in_lanes::omega(scene, weights) }
    }

    pub(super) fn bytes(&self) -> usize {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        memory::bytes(&kept.numbers) + memory::bytes(&kept.masks)
    }

    /// Gives the gradient of the displacement at all points to `finish`, with the force and the row of the table that
    /// it writes; then calls `odd` with a scene of the bonds that remain where families do not span the body.
    pub(super) fn sweep<'a, const D: usize, const SIZE: usize, const C: usize>(
        &'a self,
        order: Order,
        sweep: &mut Sweep<'_, D, C>,
        breaking: &mut Option<Breaking<'_>>,
        finish: impl Fn(usize, Point<'_, D, SIZE>, &Tensor<D>, &mut Vector<D>, &mut [f64; C]) + Sync,
        odd: impl Fn(&Scene<'_>, usize, Point<'_, D, SIZE>, &mut Vector<D>, &mut [f64; C]) + Sync,
    ) -> Points<'a> {
        let mut guard = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let Store { numbers, masks: kept_masks } = &mut *guard;
        let Sweep { scene, omega, records, force, left } = sweep;
        let (scene, count, horizon) = (*scene, scene.places.len(), omega.horizon);
        let (family, each) = (in_lanes::family(scene, records, *omega), kept_width(D, SIZE));
        let keep = |moments: &Moments, kept: &mut [f64]| {
            keep::<D, SIZE>(order, horizon, moments, kept);
        };
        let any_odd = AtomicBool::new(false);
        let (masks, limits) = in_lanes::masks(scene, breaking);
        let offsets = &scene.families.offsets;
        let kept_masks = Ragged { values: kept_masks, offsets, width: 1 };
        let kept = (PerPoint(&mut numbers[..], each), kept_masks);
        let outputs = (PerPoint(force, D), PerPoint(left, 1), masks, kept);
        scene.workers.sweep(
            count,
            outputs,
            |range, (force, left, masks, (numbers, kept_masks))| {
                let breaking = masks
                    .zip(limits)
                    .map(|(masks, limits)| in_lanes::break_here(scene, range.start, masks, limits));
                let (forces, _) = force.0.as_chunks_mut::<D>();
                let first = range.start;
                let kept = Kept { numbers: numbers.0, masks: kept_masks.values };
                let finish = |point: usize, kept: &[f64], gradient: &Tensor<D>| {
                    let place = point - first;
                    finish(point, Point(kept), gradient, &mut forces[place], &mut left.0[place]);
                };
                let sweep = GradientSweep::<_, _, D, SIZE> {
                    family,
                    horizon,
                    range,
                    breaking,
                    kept,
                    keep,
                    finish,
                };
                if scene.simd.run(sweep) {
                    any_odd.store(true, Ordering::Relaxed);
                }
            },
        );
        if !any_odd.into_inner() {
            return Points(guard);
        }
        let remaining = in_lanes::remaining(scene, breaking);
        let outputs = (PerPoint(force, D), PerPoint(left, 1));
        scene.workers.sweep(count, outputs, |range, (force, left)| {
            let (forces, _) = force.0.as_chunks_mut::<D>();
            for ((force, left), point) in forces.iter_mut().zip(left.0).zip(range) {
                let kept = Point(&numbers[point * each..(point + 1) * each]);
                if !kept.spans() {
                    odd(&remaining, point, kept, force, left);
                }
            }
        });
        Points(guard)
    }
}

/// What is kept of all points, as long as nobody changes it.
pub(super) struct Points<'a>(MutexGuard<'a, Store>);

impl Points<'_> {
    pub(super) fn at<const D: usize, const SIZE: usize>(&self, point: usize) -> Point<'_, D, SIZE> {
        let each = kept_width(D, SIZE);
        Point(&self.0.numbers[point * each..(point + 1) * each])
    }
}

fn keep<const D: usize, const SIZE: usize>(
    order: Order,
    horizon: f64,
    moments: &Moments,
    kept: &mut [f64],
) {
    let gradient = Gradient::<D>::new(order.order, &moments.products, horizon);
    let kind = match gradient.shape.rank {
        rank if rank < D => Kind::Odd,
        _ if gradient.steep && order.looks_twice => Kind::Steep,
        _ => Kind::Even,
    };
    kept[0] = kind.number();
    kept[1] = if moments.weight > 0.0 { 1.0 / moments.weight } else { 0.0 };
    for (axis, row) in gradient.rows.iter().enumerate() {
        kept[2 + axis * SIZE..2 + (axis + 1) * SIZE].copy_from_slice(&row[..SIZE]);
    }
    kept[2 + D * SIZE..].copy_from_slice(&moments.sums[..SIZE]);
}

/// Leaves for the second sweep what bonds pull that the gradient of a point is taken of: its place and V S times its
/// rows. Gives what they pull at the point itself.
#[inline(always)]
pub(super) fn leave<'a, const D: usize, const SIZE: usize, const C: usize>(
    record: &Record,
    stress: &Tensor<D>,
    row: impl Fn(usize) -> &'a [f64],
    kept: Point<'_, D, SIZE>,
    left: &mut [f64; C],
) -> Vector<D> {
    *left = [0.0; C];
    left[..3].copy_from_slice(&record[..3]);
    let (mut own, sums) = ([0.0; D], kept.sums());
    for axis in 0..D {
        for column in 0..SIZE {
            let pull = (0..D).map(|inner| stress[axis][inner] * row(inner)[column]).sum::<f64>();
            own[axis] += pull * sums[column];
            left[4 + 4 * column + axis] = record[3] * pull;
        }
    }
    own
}

/// Adds what the other ends of bonds pull, from what points have left. Gives the first point whose force is not
/// finite.
pub(super) fn pull<const D: usize, const C: usize>(
    sweep: Sweep<'_, D, C>,
    breaking: &Option<Breaking<'_>>,
) -> Option<usize> {
    let Sweep { scene, omega, records, force, left } = sweep;
    let scene = &in_lanes::remaining(scene, breaking);
    let family = Family::new(scene.families, records, scene.bonds.intact, omega);
    let (table, horizon) = (Table::new(&family, left), omega.horizon);
    let bad = AtomicUsize::new(usize::MAX);
    scene.workers.sweep(scene.places.len(), PerPoint(force, D), |range, force| {
        let pull = GradientPull::<D, C> { family, table, horizon, range, force: force.0 };
        if let Some(point) = scene.simd.run(pull) {
            bad.fetch_min(point, Ordering::Relaxed);
        }
    });
    in_lanes::first(bad)
}
