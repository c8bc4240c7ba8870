//! Sweeps in lanes for formulations of a deformation gradient. What makes the gradient of a point follows from its
//! bonds alone: it is kept here with the bond masks it belongs to, and made anew only where a bond of the family has
//! changed, or its integrity. So what is kept is right whatever a call does with what it finds, be it a look or a step that fails.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::body::Weights;
use super::calm::Resting;
use super::gradient::{Gradient, width};
use super::in_lanes::{HowTheyBreak, Which};
use super::{Scene, in_lanes};
use crate::damage::Breaking;
use crate::error::Result;
use crate::kernel::collocation::Collocation;
use crate::kernel::family::{Family, Omega, Record, Table};
use crate::kernel::gradient::{
    BEFORE_ROWS, GradientSweep, Kept, Kind, Moments, NOTHING_KEPT, kept_width,
};
use crate::kernel::gradient_pull::{GradientPull, PenaltyPull};
use crate::memory;
use crate::tensor::{Tensor, Vector};
use crate::workers::{Outputs, PerPoint, PointByPoint, Ragged};

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
    /// The name of the integrities that it belongs to.
    grades: u64,
}

/// How gradients are made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order {
    pub(super) order: usize,
    /// sum V is asked for.
    pub(super) counts_volumes: bool,
}

/// What is kept of a point.
#[derive(Clone, Copy)]
pub(super) struct Point<'a, const D: usize, const SIZE: usize>(&'a [f64]);

impl<'a, const D: usize, const SIZE: usize> Point<'a, D, SIZE> {
    /// 1/sum w V, 0 without a family.
    pub(super) fn inverse_weight(&self) -> f64 {
        self.0[1]
    }

    /// sum V, where the order counts volumes.
    pub(super) fn volume(&self) -> f64 {
        self.0[2]
    }

    /// Whether the family is known not to span the body. Nothing is known of points that have always rested.
    fn is_odd(&self) -> bool {
        self.0[0] == Kind::Odd.number()
    }

    /// Whether the family spans the body.
    pub(super) fn spans(&self) -> bool {
        Kind::of(self.0) != Kind::Odd
    }

    /// Rows of the gradient.
    #[inline(always)]
    pub(super) fn rows(&self) -> &'a [[f64; SIZE]] {
        self.0[BEFORE_ROWS..BEFORE_ROWS + D * SIZE].as_chunks().0
    }

    /// sum w q V
    fn sums(&self) -> &'a [f64] {
        &self.0[BEFORE_ROWS + D * SIZE..]
    }
}

/// What a sweep reads.
#[derive(Clone, Copy)]
pub(super) struct Sweep<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) omega: Omega<'a>,
    pub(super) records: &'a [Record],
    /// What sweeps for forces leave out, and how many come after that of the gradients.
    pub(super) resting: Resting<'a>,
    pub(super) after: u8,
    pub(super) which: Which,
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
    pub(super) fn omega<'a>(&self, scene: &Scene<'a>, weights: &'a Weights) -> Option<Omega<'a>> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.numbers.is_empty() { None } else { in_lanes::omega(scene, weights) }
    }

    pub(super) fn bytes(&self) -> usize {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        memory::bytes(&kept.numbers) + memory::bytes(&kept.masks)
    }

    /// Gives the gradient of the displacement at all points that are wanted and whose families span the body to `finish`,
    /// with the part of the outputs that is theirs.
    pub(super) fn sweep<'a, const D: usize, const SIZE: usize, O: Outputs>(
        &'a self,
        order: Order,
        sweep: Sweep<'_>,
        breaking: &mut Option<Breaking<'_>>,
        outputs: O,
        wanted: impl Fn(usize) -> bool + Sync,
        finish: impl Fn(usize, Point<'_, D, SIZE>, &Tensor<D>, O) + Sync,
    ) -> Points<'a> {
        let mut guard = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let Store { numbers, masks: kept_masks, grades } = &mut *guard;
        let Sweep { scene, omega, resting, after, which, .. } = sweep;
        let (horizons, each) = (omega.horizons, kept_width(D, SIZE));
        if std::mem::replace(grades, scene.bonds.grades) != scene.bonds.grades {
            numbers.iter_mut().step_by(each).for_each(|kind| *kind = NOTHING_KEPT);
        }
        let family = sweep.family();
        let parts = order.counts_volumes && !scene.families.reach.is_sharp_and_uniform();
        let keep = |point: usize, masks: &[u8], moments: &Moments, kept: &mut [f64]| {
            keep::<D, SIZE>(order, horizons.at(point), moments, kept);
            if parts {
                kept[2] = volume_of(scene, point, masks);
            }
        };
        let any_odd = AtomicBool::new(false);
        let (masks, how) = HowTheyBreak::if_any(scene, breaking, resting);
        let offsets = &scene.families.offsets;
        let kept_masks = Ragged { values: kept_masks, offsets, width: 1 };
        let kept = (PerPoint(&mut numbers[..], each), kept_masks);
        in_lanes::sweep(
            scene,
            family,
            which,
            (outputs, masks, kept),
            |family, range, (outputs, masks, (numbers, kept_masks))| {
                let breaking = masks.zip(how).and_then(|(masks, how)| how.here(range.start, masks));
                if resting.block(range.start, after) {
                    return;
                }
                let mut outputs = PointByPoint::new(outputs, range.start);
                let kept = Kept { numbers: numbers.0, masks: kept_masks.values };
                let mut finish = |point: usize, kept: &[f64], gradient: &Tensor<D>| {
                    outputs.give(point, |own| finish(point, Point(kept), gradient, own));
                };
                let sweep = GradientSweep::<D, SIZE> {
                    family,
                    horizons,
                    range,
                    breaking,
                    kept,
                    wanted: &wanted,
                    keep: &keep,
                    finish: &mut finish,
                };
                if scene.simd.run(sweep) {
                    any_odd.store(true, Ordering::Relaxed);
                }
            },
        );
        Points { guard, any_odd: any_odd.into_inner(), which }
    }
}

/// What is kept of all points, as long as nobody changes it.
pub(super) struct Points<'a> {
    guard: MutexGuard<'a, Store>,
    any_odd: bool,
    which: Which,
}

impl Points<'_> {
    /// Whether the sweep has come upon points whose families do not span the body.
    pub(super) fn any_odd(&self) -> bool {
        self.any_odd
    }

    pub(super) fn at<const D: usize, const SIZE: usize>(&self, point: usize) -> Point<'_, D, SIZE> {
        let each = kept_width(D, SIZE);
        Point(&self.guard.numbers[point * each..(point + 1) * each])
    }

    /// Calls `finish` for the points whose families do not span the body, if the sweep has come upon any.
    pub(super) fn odd<const D: usize, const SIZE: usize, O: Outputs>(
        &self,
        scene: &Scene<'_>,
        outputs: O,
        finish: impl Fn(usize, Point<'_, D, SIZE>, O) + Sync,
    ) {
        if !self.any_odd {
            return;
        }
        scene.workers.sweep(scene.places.len(), outputs, |range, outputs| {
            let mut outputs = PointByPoint::new(outputs, range.start);
            for point in range {
                let kept = self.at::<D, SIZE>(point);
                let swept = self.which == Which::All || scene.families.is_listed(point);
                if swept && kept.is_odd() {
                    outputs.give(point, |own| finish(point, kept, own));
                }
            }
        });
    }
}

/// sum V of the parts of volumes in a point's own family, of bonds in the masks of its blocks.
fn volume_of(scene: &Scene<'_>, point: usize, masks: &[u8]) -> f64 {
    let (families, places) = (scene.families, scene.places);
    let first = families.blocks(point).start;
    let bonds = families.bonds_in(point, |block| masks[block - first]);
    bonds.map(|bond| families.share(point, bond) * places[bond.neighbor][3]).sum()
}

/// Makes what is kept of a point.
pub(super) fn keep<const D: usize, const SIZE: usize>(
    order: Order,
    horizon: f64,
    moments: &Moments,
    kept: &mut [f64],
) {
    let gradient = Gradient::<D>::new(order.order, &moments.products, horizon);
    let kind = match gradient.shape.rank {
        rank if rank < D => Kind::Odd,
        _ if gradient.steep => Kind::Steep,
        _ => Kind::Even,
    };
    kept[0] = kind.number();
    kept[1] = if moments.weight > 0.0 { 1.0 / moments.weight } else { 0.0 };
    kept[2] = moments.volume;
    let (rows, sums) = kept[BEFORE_ROWS..].split_at_mut(D * SIZE);
    for (kept, row) in rows.chunks_exact_mut(SIZE).zip(&gradient.rows) {
        kept.copy_from_slice(&row[..SIZE]);
    }
    sums.copy_from_slice(&moments.sums[..SIZE]);
}

/// Leaves for the second sweep what bonds pull that the gradient of a point is taken of: its place, 1 over its horizon and V S
/// times its rows. Gives what they pull at the point itself.
#[inline(always)]
pub(super) fn leave<const D: usize, const SIZE: usize, const C: usize>(
    record: &Record,
    stress: &Tensor<D>,
    rows: &[[f64; SIZE]],
    (horizon, kept): (f64, Point<'_, D, SIZE>),
    left: &mut [f64; C],
) -> Vector<D> {
    *left = [0.0; C];
    left[..3].copy_from_slice(&record[..3]);
    left[3] = 1.0 / horizon;
    let (mut own, sums) = ([0.0; D], kept.sums());
    for axis in 0..D {
        for column in 0..SIZE {
            // A loop, since sums of iterators may not be compiled in.
            let mut pull = stress[axis][0] * rows[0][column];
            for inner in 1..D {
                pull += stress[axis][inner] * rows[inner][column];
            }
            own[axis] += pull * sums[column];
            left[4 + 4 * column + axis] = record[3] * pull;
        }
    }
    own
}

/// The same with the tensor that multiplies xi, P K^-1 - C H, and C, that of du.
#[inline(always)]
pub(super) fn leave_penalty<const D: usize, const SIZE: usize, const C: usize>(
    record: &Record,
    operator: &Tensor<D>,
    penalty: &Tensor<D>,
    kept: Point<'_, D, SIZE>,
    left: &mut [f64; C],
) -> Vector<D> {
    *left = [0.0; C];
    left[..8].copy_from_slice(record);
    let (mut own, sums) = ([0.0; D], kept.sums());
    for axis in 0..D {
        for column in 0..D {
            own[axis] += operator[axis][column] * sums[column];
            left[8 + 4 * column + axis] = operator[axis][column];
            left[8 + 4 * (D + column) + axis] = penalty[axis][column];
        }
    }
    own
}

/// Adds what the other ends of bonds pull, from what points have left; `sweep`: of the bonds that remain. Gives the
/// first point whose force is not finite.
pub(super) fn pull<const D: usize, const C: usize>(
    sweep: Sweep<'_>,
    left: &[[f64; C]],
    force: &mut [f64],
) -> Option<usize> {
    let family = sweep.family();
    let table = Table::new(&family, left);
    sweep.gather::<D>(force, |family, range, force| {
        sweep.scene.simd.run(GradientPull::<D, C> { family, table, range, force })
    })
}

/// The same, and what both ends pull by the penalty.
pub(super) fn pull_with_penalty<const D: usize, const C: usize>(
    sweep: Sweep<'_>,
    left: &[[f64; C]],
    force: &mut [f64],
) -> Option<usize> {
    let family = sweep.family();
    let table = Table::new(&family, left);
    sweep.gather::<D>(force, |family, range, force| {
        sweep.scene.simd.run(PenaltyPull::<D, C> { family, table, range, force })
    })
}

/// The divergence of tensors that rows have from `first` on, by operators on monomials and on du.
pub(super) fn collocate<const D: usize, const SIZE: usize, const C: usize>(
    sweep: Sweep<'_>,
    rows: &[[f64; C]],
    first: usize,
    operators: impl Fn(usize) -> ([[f64; SIZE]; D], Tensor<D>) + Sync,
    force: &mut [f64],
) -> Option<usize> {
    let (family, horizons) = (sweep.family(), sweep.omega.horizons);
    let (table, operators) = (Table::new(&family, rows), &operators);
    sweep.gather::<D>(force, |family, range, force| {
        let collocation = Collocation { family, table, first, horizons, operators, range, force };
        sweep.scene.simd.run(collocation)
    })
}

impl<'a> Sweep<'a> {
    pub(super) fn new(scene: &'a Scene<'a>, omega: Omega<'a>, records: &'a [Record]) -> Self {
        Self { scene, omega, records, resting: Resting::NEVER, after: 0, which: Which::All }
    }

    /// That leaves out what rests, with so many sweeps after that of the gradients.
    pub(super) fn resting(self, resting: Resting<'a>, after: u8) -> Self {
        Self { resting, after, ..self }
    }

    pub(super) fn family(&self) -> Family<'a> {
        in_lanes::family(self.scene, self.records, self.omega)
    }

    /// Gives the first point that a part of a sweep over forces has found, of points that are no members of a lattice.
    fn gather<const D: usize>(
        &self,
        force: &mut [f64],
        part: impl Fn(Family<'_>, Range<usize>, &mut [f64]) -> Option<usize> + Sync,
    ) -> Option<usize> {
        let bad = AtomicUsize::new(usize::MAX);
        let (scene, force) = (self.scene, PerPoint(force, D));
        in_lanes::sweep(scene, self.family(), Which::Listed, force, |family, range, force| {
            if self.resting.block(range.start, 0) {
                return force.0.fill(0.0);
            }
            if let Some(point) = part(family, range, force.0) {
                bad.fetch_min(point, Ordering::Relaxed);
            }
        });
        in_lanes::first(bad)
    }
}
