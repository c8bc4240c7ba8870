//! The part of a body that is a lattice: what its cells and groups hold besides the lattice itself.
//!
//! The masks of the bonds' lists say which bonds there are; those of the groups follow them. Displacements are copied
//! to the cells and forces from the groups, so that all else of the body keeps its order.

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::bond_laws::Limits;
use super::calm::Resting;
use super::seam::Seam;
use super::{Scene, in_lanes};
use crate::damage::{BreakRule, Breaking, close_to};
use crate::error::Result;
use crate::families::LANES;
use crate::families::lattice::{Lattice, NOBODY};
use crate::kernel::lattice::{Groups, Leg, Prepare};
use crate::kernel::simd::prefetch;
use crate::memory;
use crate::workers::{Outputs, PerPoint, Workers};

const PURPOSE: &str = "lattices";

/// Numbers beyond the cells of a column: the next one does not begin at the same place of a page.
const STAGGER: usize = 168;

/// Points whose forces are asked for ahead of their turn.
const AHEAD: usize = 12;

/// Groups whose masks a thread makes in one go.
const GROUPS_A_SHARE: usize = 256;

/// What sweeps hold of a lattice, and what one writes aside; one sweep at a time.
pub(super) struct LatticeState {
    held: Mutex<Held>,
    /// Where the lattice ends, if it does.
    pub(super) seam: Option<Seam>,
}

struct Held {
    /// [`Lattice::row`] masks a group: for each step of the stencil, one bit a point: there is an intact bond.
    masks: Vec<u8>,
    /// That of the masks of the bonds' lists that these say the same as; `None` while a sweep changes them.
    edition: Option<u64>,
    /// Numbers of the cells, column by column: the displacement, and what one sweep leaves for the next.
    columns: Vec<f64>,
    legs: Vec<Leg>,
    /// Of each component eight numbers a group.
    forces: Vec<f64>,
    /// Of each seat; that of a group's first tells of bonds that have broken in the group. All false between sweeps.
    broke: Vec<bool>,
}

/// The lattice part of a body in a sweep for forces.
pub(super) struct OnLattice<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) state: &'a LatticeState,
    pub(super) limits: Limits<'a>,
    pub(super) resting: Resting<'a>,
}

/// What the sweeps over groups read and write; `N`: columns that one leaves for the next.
pub(super) struct Parts<'a, const D: usize, const N: usize> {
    pub(super) groups: Groups<'a, D>,
    /// Those of each kind, which differ by their limits.
    pub(super) legs: &'a [Leg],
    pub(super) seats: usize,
    /// The length that is 1.
    pub(super) unit: f64,
    pub(super) masks: PerPoint<'a, u8>,
    pub(super) broke: PerPoint<'a, bool>,
    /// `D` numbers a seat.
    pub(super) forces: PerPoint<'a, f64>,
    pub(super) left: Columns<'a, N>,
}

/// Columns of numbers of the cells from one on, shared out by groups.
pub(super) struct Columns<'a, const N: usize> {
    pub(super) values: [&'a mut [f64]; N],
    pub(super) first: usize,
    /// First cell of each group.
    groups: &'a [u32],
}

impl<'a, const N: usize> Columns<'a, N> {
    /// The same numbers once more.
    pub(super) fn again(&mut self) -> Columns<'_, N> {
        let values = self.values.each_mut().map(|column| &mut **column);
        Columns { values, first: self.first, groups: self.groups }
    }

    /// So many of the columns, and so many that come after them.
    pub(super) fn parted<const A: usize, const B: usize>(self) -> (Columns<'a, A>, Columns<'a, B>) {
        let Self { values, first, groups } = self;
        let mut values = values.into_iter();
        let mut next = |_| values.next().unwrap_or_default();
        let front = Columns { values: std::array::from_fn(&mut next), first, groups };
        (front, Columns { values: std::array::from_fn(&mut next), first, groups })
    }
}

impl<const N: usize> Outputs for Columns<'_, N> {
    fn split(self, _: usize, seat: usize) -> (Self, Self) {
        let Self { values, first, groups } = self;
        let middle = groups[seat / LANES] as usize;
        let (mut low, mut high) = ([(); N].map(|()| &mut [][..]), [(); N].map(|()| &mut [][..]));
        for ((low, high), values) in low.iter_mut().zip(&mut high).zip(values) {
            (*low, *high) = values.split_at_mut(middle - first);
        }
        (Self { values: low, first, groups }, Self { values: high, first: middle, groups })
    }
}

impl LatticeState {
    /// With room for so many columns that sweeps leave.
    pub(super) fn new(scene: &Scene<'_>, lattice: &Lattice, left: usize) -> Result<Self> {
        let (seats, workers) = (lattice.members.len(), scene.workers);
        let numbers = (scene.dimension + left) * stride(lattice) + in_lanes::SLACK;
        let mut held = Held {
            masks: workers.filled(0, lattice.groups.len() * lattice.row(), PURPOSE)?,
            edition: None,
            columns: workers.filled(0.0, numbers, PURPOSE)?,
            legs: memory::filled(Leg::default(), lattice.stencil.len() * lattice.kinds(), PURPOSE)?,
            forces: workers.filled(0.0, seats * scene.dimension, PURPOSE)?,
            broke: workers.filled(false, seats, PURPOSE)?,
        };
        held.follow(scene, lattice);
        Ok(Self { held: Mutex::new(held), seam: Seam::new(scene, lattice)? })
    }

    pub(super) fn bytes(&self) -> usize {
        let held = self.held.lock().unwrap_or_else(|poison| poison.into_inner());
        memory::bytes(&held.masks)
            + memory::bytes(&held.columns)
            + memory::bytes(&held.legs)
            + memory::bytes(&held.forces)
            + memory::bytes(&held.broke)
            + self.seam.as_ref().map_or(0, Seam::bytes)
    }
}

/// Numbers from one column of the cells to the next.
fn stride(lattice: &Lattice) -> usize {
    lattice.point_of.len().next_multiple_of(512) + STAGGER
}

/// A power of two near the lengths of the stencil.
pub(super) fn unit_of(lattice: &Lattice) -> f64 {
    let components = lattice.stencil.iter().flat_map(|step| step.reference);
    let longest = components.map(f64::abs).fold(0.0, f64::max);
    longest.log2().floor().exp2()
}

impl Held {
    /// Has the masks of groups say what those of the lists say.
    fn follow(&mut self, scene: &Scene<'_>, lattice: &Lattice) {
        let (families, intact) = (scene.families, scene.bonds.intact);
        let of_member = |point: usize| &intact[families.blocks(point)];
        let row = lattice.row();
        scene.workers.share(&mut self.masks, GROUPS_A_SHARE * row, |first, masks| {
            for (group, masks) in masks.chunks_exact_mut(row).enumerate() {
                lattice.turn(first / row + group, of_member, masks);
            }
        });
        self.broke.fill(false);
        self.edition = Some(scene.bonds.edition);
    }
}

/// Calls `part` for runs of groups that are in the same state: with their seats, and the part of the outputs that is theirs.
pub(super) fn by_state<O: Outputs, S: PartialEq>(
    seats: Range<usize>,
    outputs: O,
    state: impl Fn(usize) -> S,
    mut part: impl FnMut(Range<usize>, O, S),
) {
    let (mut first, mut outputs) = (seats.start, outputs);
    let mut now = state(first / LANES);
    for seat in seats.clone().step_by(LANES).skip(1) {
        let next = state(seat / LANES);
        if next != now {
            let (own, others) = outputs.split(first, seat);
            part(first..seat, own, std::mem::replace(&mut now, next));
            (first, outputs) = (seat, others);
        }
    }
    part(first..seats.end, outputs, now);
}

/// Copies displacements, over a unit, to the cells.
fn place<const D: usize>(
    workers: &Workers,
    lattice: &Lattice,
    displacement: &[f64],
    unit: f64,
    [x, y, z]: [Option<&mut [f64]>; 3],
) {
    let (shifts, _) = displacement.as_chunks::<D>();
    let scale = unit.recip();
    let column = |values| PerPoint(values, 1);
    let outputs = (x.map(column), y.map(column), z.map(column));
    workers.sweep(lattice.point_of.len(), outputs, |range, (x, y, z)| {
        let points = &lattice.point_of[range];
        let axes = [x, y, z].map(|axis| axis.map_or(&mut [][..], |axis| axis.0));
        for (place, &point) in points.iter().enumerate() {
            if point != NOBODY {
                for (axis, shift) in shifts[point as usize].iter().enumerate() {
                    axes[axis][place] = scale * shift;
                }
            }
        }
    });
}

impl<'a> OnLattice<'a> {
    /// Of a sweep in which bonds may break by a rule that is the same for all of a kind.
    pub(super) fn breaking(
        scene: &'a Scene<'a>,
        (lattice, state): (&'a Lattice, &'a LatticeState),
        rule: Option<&'a BreakRule>,
        resting: Resting<'a>,
    ) -> Self {
        Self { lattice, state, limits: Limits { scene, rule }, resting }
    }

    /// (l/L)^2 - 1 of bonds of a kind that come close to their limit.
    fn threshold(&self, kind: usize) -> f64 {
        let critical = self.limits.rule.and_then(|rule| rule.among(self.lattice.sample(kind)));
        close_to(critical.unwrap_or(f64::INFINITY))
    }

    /// Groups of a kind, with its legs of those of all kinds.
    pub(super) fn of_kind<'b, const D: usize>(
        &self,
        groups: Groups<'b, D>,
        legs: &'b [Leg],
        kind: usize,
    ) -> Groups<'b, D> {
        let steps = self.lattice.stencil.len();
        groups.with_legs(&legs[kind * steps..(kind + 1) * steps])
    }

    fn members(&self, group: usize) -> &[u32] {
        &self.lattice.members[group * LANES..][..LANES]
    }

    /// Whether a sweep with so many sweeps after it has nothing to do for a group.
    pub(super) fn rests(&self, group: usize, sweeps: u8) -> bool {
        self.resting.group(self.members(group), sweeps)
    }

    /// The last sweep: `pull` completes the forces of a run of groups by their masks, but for those that rest.
    pub(super) fn pull(
        &self,
        scene: &Scene<'_>,
        seats: usize,
        outputs: (PerPoint<'_, f64>, PerPoint<'_, u8>),
        pull: impl Fn(Range<usize>, &mut [f64], &[u8]) + Sync,
    ) {
        scene.workers.sweep(seats, outputs, |range, outputs| {
            let part = |range: Range<usize>,
                        (force, masks): (PerPoint<'_, f64>, PerPoint<'_, u8>),
                        rest| {
                if rest {
                    return force.0.fill(0.0);
                }
                pull(range.start / LANES..range.end / LANES, force.0, masks.0);
            };
            by_state(range, outputs, |group| self.rests(group, 0), part);
        });
    }

    /// Whether bonds of a group may have come to their limit.
    pub(super) fn may_break(&self, group: usize) -> bool {
        let threshold = self.threshold(self.lattice.kind(group));
        threshold.is_finite() && !self.resting.group_is_short(self.members(group), threshold)
    }

    /// Forces per volume on the points of the lattice: `first` breaks bonds, and may make what `second` needs, which
    /// completes the forces of seats in a scene of the bonds that are left, and gives what they are to be multiplied
    /// with; forces of other points are its to write. `influence`: w of a length.
    /// Gives the first point whose force is not finite, or a number beyond all points.
    pub(super) fn sweep<const D: usize, const N: usize>(
        &self,
        scene: &Scene<'_>,
        influence: impl Fn(f64) -> f64,
        first: impl FnOnce(&mut Parts<'_, D, N>),
        second: impl FnOnce(Parts<'_, D, N>, &Scene<'_>, &mut [f64]) -> f64,
        force: &mut [f64],
        breaking: &mut Option<Breaking<'_>>,
    ) -> usize {
        let (lattice, workers) = (self.lattice, scene.workers);
        let mut held = self.state.held.lock().unwrap_or_else(|poison| poison.into_inner());
        let held = &mut *held;
        if held.edition != Some(scene.bonds.edition) {
            held.follow(scene, lattice);
        }
        held.edition = None;
        let (unit, stencil) = (unit_of(lattice), &lattice.stencil[..]);
        for (kind, legs) in held.legs.chunks_exact_mut(stencil.len()).enumerate() {
            let (threshold, influence) = (self.threshold(kind), &influence);
            scene.simd.run(Prepare { stencil, unit, threshold, influence, legs });
        }
        let (legs, _) = held.legs.split_at(stencil.len());
        let (cells, stride) = (lattice.point_of.len(), stride(lattice));
        let columns = in_lanes::from_a_line(&mut held.columns);
        let (shifts, left) = columns.split_at_mut(D * stride);
        let mut axes = shifts.chunks_mut(stride).map(|column| &mut column[..cells]);
        let axes = [axes.next(), axes.next(), axes.next()];
        place::<D>(workers, lattice, scene.displacement, unit, axes);
        let shifts = &*shifts;
        let shifts = std::array::from_fn(|axis| &shifts[axis * stride..][..cells]);
        let mut left = left.chunks_mut(stride).map(|column| &mut column[..cells]);
        let mut parts = Parts {
            groups: Groups::<D>::new(lattice, legs, shifts, scene.skips.without_bonds),
            legs: &held.legs,
            seats: lattice.members.len(),
            unit,
            masks: PerPoint(&mut held.masks, lattice.row() / LANES),
            broke: PerPoint(&mut held.broke, 1),
            forces: PerPoint(&mut held.forces, D),
            left: Columns {
                values: std::array::from_fn(|_| left.next().unwrap_or_default()),
                first: 0,
                groups: &lattice.groups,
            },
        };
        first(&mut parts);
        if let Some(breaking) = breaking
            && parts.broke.0.contains(&true)
        {
            self.hand_out_breaks(scene, (parts.broke.0, parts.masks.0), breaking);
            parts.broke.0.fill(false);
        }
        let left = in_lanes::remaining(scene, breaking);
        held.edition = Some(left.bonds.edition);
        let factor = second(parts, &left, force);
        self.hand_out::<D>(scene, &held.forces, factor, force)
    }

    /// Has bonds' lists say what broke in the groups.
    fn hand_out_breaks(
        &self,
        scene: &Scene<'_>,
        (broke, masks): (&[bool], &[u8]),
        breaking: &mut Breaking<'_>,
    ) {
        breaking.broke.store(true, Ordering::Relaxed);
        let row = self.lattice.row();
        // Few groups break at once.
        let groups = broke.iter().step_by(LANES).zip(masks.chunks_exact(row)).enumerate();
        for (group, (_, masks)) in groups.filter(|(_, (broke, _))| **broke) {
            for (lane, &point) in self.members(group).iter().enumerate() {
                if point == NOBODY {
                    continue;
                }
                let remaining = &mut breaking.intact[scene.families.blocks(point as usize)];
                for (mask, steps) in remaining.iter_mut().zip(masks.chunks(LANES)) {
                    for (bit, of_step) in steps.iter().enumerate() {
                        *mask &= !((!of_step >> lane & 1) << bit);
                    }
                }
            }
        }
    }

    /// Has points take the forces of their seats.
    fn hand_out<const D: usize>(
        &self,
        scene: &Scene<'_>,
        forces: &[f64],
        factor: f64,
        force: &mut [f64],
    ) -> usize {
        let (forces, _) = forces.as_chunks::<LANES>();
        let bad = AtomicUsize::new(usize::MAX);
        scene.workers.sweep(scene.places.len(), PerPoint(force, D), |range, force| {
            let (force, _) = force.0.as_chunks_mut::<D>();
            // A group with others that do not rest was swept by what sweeps before may have left out.
            let rest = self.resting.block(range.start, 0);
            for (force, point) in force.iter_mut().zip(range) {
                let seats = &self.lattice.seat_of;
                if let Some(&ahead) = seats.get(point + AHEAD) {
                    (0..D).for_each(|axis| prefetch(forces, ahead as usize / LANES * D + axis));
                }
                let seat = seats[point];
                if seat == NOBODY {
                    continue;
                }
                if rest {
                    force.fill(0.0);
                    continue;
                }
                let (group, lane) = (seat as usize / LANES, seat as usize % LANES);
                let forces = &forces[group * D..(group + 1) * D];
                for (force, forces) in force.iter_mut().zip(forces) {
                    *force = factor * forces[lane];
                }
                if !force.iter().all(|component| component.is_finite()) {
                    bad.fetch_min(point, Ordering::Relaxed);
                }
            }
        });
        bad.into_inner()
    }
}
