//! What formulations of a deformation gradient share on the part of a body that is a lattice: what makes the gradients of seats, kept
//! as `kept_rows` keeps it of points, and the sweeps that make them and pull by them.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::Scene;
use super::bond_laws::Limits;
use super::kept_rows::{Order, keep};
use super::on_lattice::{Columns, LatticeState, OnLattice, Parts, by_state};
use crate::error::Result;
use crate::families::LANES;
use crate::families::lattice::{Lattice, NOBODY};
use crate::kernel::gradient::{Kept, Moments, kept_width};
use crate::kernel::lattice::{
    Breaks, GroupGradients, Groups, KeptSeat, PullSweep, TakeGradients, is_odd,
};
use crate::kernel::simd::SimdLevel;
use crate::memory;
use crate::tensor::{Tensor, Vector, applied};
use crate::workers::PerPoint;

const PURPOSE: &str = "gradients on lattices";

/// What is held of a lattice.
pub(super) struct LatticeRows {
    pub(super) state: LatticeState,
    kept: Mutex<Store>,
}

/// What is kept of groups, eight of each number, in the unit of the lattice and with a volume of 1, and the masks that it
/// belongs to.
struct Store {
    numbers: Vec<f64>,
    masks: Vec<u8>,
}

/// Forces, columns, masks, whether any has broken, and what is kept.
type Outputs<'a, const N: usize> = (
    (PerPoint<'a, f64>, Columns<'a, N>),
    PerPoint<'a, u8>,
    PerPoint<'a, bool>,
    (PerPoint<'a, f64>, PerPoint<'a, u8>),
);

/// What is kept of all groups, as long as nobody changes it.
pub(super) struct KeptGroups<'a>(MutexGuard<'a, Store>);

/// Gradients of the groups of a part of a sweep, to be made.
pub(super) struct Gradients<'a, const D: usize> {
    simd: SimdLevel,
    groups: Groups<'a, D>,
    range: Range<usize>,
    kept: Kept<'a>,
    order: Order,
    horizon: f64,
    breaks: Breaks<'a, Limits<'a>>,
    first: usize,
    any_odd: &'a AtomicBool,
}

/// A seat that is somebody's, and what a part of a sweep writes of it.
pub(super) struct Seat<'a, 'b, const D: usize, const N: usize> {
    pub(super) point: usize,
    lane: usize,
    /// Of its group.
    kept: &'a [f64],
    forces: &'a mut [f64],
    left: &'a mut Columns<'b, N>,
    cell: usize,
}

impl<const D: usize> Gradients<'_, D> {
    /// Breaks bonds, and gives gradients to `take`.
    pub(super) fn give(self, take: &mut impl TakeGradients<D>) {
        let Self { simd, groups, range, kept, order, horizon, breaks, first, any_odd } = self;
        let keep = |moments: &Moments, kept: &mut [f64]| {
            keep::<D, D>(order, horizon, moments, kept);
        };
        if simd.run(GroupGradients { groups, range, kept, keep, breaks, first, take }) {
            any_odd.store(true, Ordering::Relaxed);
        }
    }
}

impl<const D: usize, const N: usize> Seat<'_, '_, D, N> {
    /// Whether its gradient is to be made otherwise.
    pub(super) fn is_odd(&self) -> bool {
        is_odd(self.kept, self.point as u32, self.lane)
    }

    pub(super) fn kept(&self) -> KeptSeat<D> {
        KeptSeat::of(self.kept, self.lane)
    }

    pub(super) fn has_force(&self) -> bool {
        (0..D).all(|axis| self.forces[axis * LANES + self.lane].is_finite())
    }

    /// Leaves a number in a column.
    pub(super) fn leave(&mut self, column: usize, value: f64) {
        self.left.values[column][self.cell] = value;
    }

    /// Leaves the tensor that its gradient pulls with in columns, and has the force be what it pulls itself and `straight`.
    pub(super) fn pull(&mut self, tensor: &Tensor<D>, straight: &Vector<D>) {
        let own = applied(tensor, &self.kept().sums);
        for (axis, row) in tensor.iter().enumerate() {
            self.forces[axis * LANES + self.lane] = straight[axis] + own[axis];
            for (column, value) in row.iter().enumerate() {
                self.leave(axis * D + column, *value);
            }
        }
    }
}

impl KeptGroups<'_> {
    pub(super) fn numbers(&self) -> &[f64] {
        &self.0.numbers
    }

    fn group<const D: usize>(&self, group: usize) -> &[f64] {
        let width = LANES * kept_width(D, D);
        &self.0.numbers[group * width..][..width]
    }

    pub(super) fn at<const D: usize>(&self, seat: usize) -> KeptSeat<D> {
        KeptSeat::of(self.group::<D>(seat / LANES), seat % LANES)
    }

    /// Calls `take` for all seats that are somebody's.
    pub(super) fn each_seat<const D: usize, const N: usize>(
        &self,
        scene: &Scene<'_>,
        lattice: &Lattice,
        (forces, left): (PerPoint<'_, f64>, Columns<'_, N>),
        take: impl Fn(Seat<'_, '_, D, N>) + Sync,
    ) {
        scene.workers.sweep(lattice.members.len(), (forces, left), |range, (forces, mut left)| {
            for (number, seat) in range.enumerate() {
                let (group, lane) = (seat / LANES, seat % LANES);
                let point = lattice.members[seat];
                if point == NOBODY {
                    continue;
                }
                take(Seat {
                    point: point as usize,
                    lane,
                    kept: self.group::<D>(group),
                    forces: &mut forces.0[number / LANES * D * LANES..][..D * LANES],
                    cell: lattice.cell(seat) - left.first,
                    left: &mut left,
                });
            }
        });
    }
}

impl LatticeRows {
    /// With room for so many columns that sweeps leave.
    pub(super) fn new(scene: &Scene<'_>, lattice: &Lattice, left: usize) -> Result<Self> {
        let dimension = scene.dimension;
        let (seats, each) = (lattice.members.len(), kept_width(dimension, dimension));
        let numbers = scene.workers.filled(0.0, seats * each, PURPOSE)?;
        let masks = scene.workers.filled(0, lattice.groups.len() * lattice.row(), PURPOSE)?;
        let state = LatticeState::new(scene, lattice, left)?;
        Ok(Self { state, kept: Mutex::new(Store { numbers, masks }) })
    }

    pub(super) fn bytes(&self) -> usize {
        let kept = self.kept().0;
        self.state.bytes() + memory::bytes(&kept.numbers) + memory::bytes(&kept.masks)
    }

    pub(super) fn kept(&self) -> KeptGroups<'_> {
        KeptGroups(self.kept.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Calls `take` for parts of the groups, but for those that rest, if so many sweeps come after: with their forces, their columns, and the gradients that are to be made.
    /// Whether there are seats whose gradients are to be made otherwise.
    pub(super) fn sweep<const D: usize, const N: usize>(
        &self,
        on: &OnLattice<'_>,
        scene: &Scene<'_>,
        (order, horizon): (Order, f64),
        parts: &mut Parts<'_, D, N>,
        sweeps: u8,
        take: impl Fn(&mut [f64], Columns<'_, N>, Gradients<'_, D>) + Sync,
    ) -> bool {
        let any_odd = &AtomicBool::new(false);
        let mut kept = self.kept();
        let Store { numbers, masks } = &mut *kept.0;
        let row = on.lattice.row() / LANES;
        let kept = (PerPoint(&mut numbers[..], kept_width(D, D)), PerPoint(&mut masks[..], row));
        let (groups, legs, judge) = (parts.groups, parts.legs, on.limits);
        let (simd, horizon) = (scene.simd, horizon / parts.unit);
        let outputs = (parts.forces.again(), parts.left.again());
        let outputs = (outputs, parts.masks.again(), parts.broke.again(), kept);
        scene.workers.sweep(parts.seats, outputs, |range, outputs| {
            let part = |range: Range<usize>,
                        ((force, left), masks, broke, (numbers, kept_masks)): Outputs<'_, N>,
                        (rest, look, kind)| {
                if rest {
                    return;
                }
                let gradients = Gradients {
                    simd,
                    groups: on.of_kind(groups, legs, kind),
                    range: range.start / LANES..range.end / LANES,
                    kept: Kept { numbers: numbers.0, masks: kept_masks.0 },
                    order,
                    horizon,
                    breaks: Breaks { masks: masks.0, broke: broke.0, judge, look },
                    first: left.first,
                    any_odd,
                };
                take(force.0, left, gradients);
            };
            let kind = |group| on.lattice.kind(group);
            let state = |group| (on.rests(group, sweeps), on.may_break(group), kind(group));
            by_state(range, outputs, state, part);
        });
        any_odd.load(Ordering::Relaxed)
    }
}

/// Adds what the gradients of other ends pull by the tensors that all points have left, but of groups that rest.
pub(super) fn pull<const D: usize, const N: usize>(
    (on, scene): (&OnLattice<'_>, &Scene<'_>),
    groups: Groups<'_, D>,
    outputs: (PerPoint<'_, f64>, PerPoint<'_, u8>),
    left: Columns<'_, N>,
) {
    let left = left.values.map(|column| &*column);
    on.pull(scene, on.lattice.members.len(), outputs, |range, force, masks| {
        scene.simd.run(PullSweep { groups, left, range, masks, force });
    });
}
