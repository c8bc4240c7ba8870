//! The part of a body that is a lattice, in bond_based: what its cells and groups hold besides the lattice itself.
//!
//! The masks of the bonds' lists say which bonds there are; those of the groups follow them. Displacements are copied
//! to the cells and forces from the groups, so that all else of the body keeps its order.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::Scene;
use super::bond_laws::Limits;
use crate::error::Result;
use crate::families::lattice::{Lattice, NOBODY};
use crate::families::{Families, LANES};
use crate::kernel::lattice::{GroupSweep, Groups};
use crate::memory;
use crate::workers::{PerPoint, Ragged, Workers};

const PURPOSE: &str = "lattices";

/// Numbers beyond the cells of an axis: one more axis does not begin at the same place of a page.
const STAGGER: usize = 168;

/// Numbers that let the first cell begin a line of the cache.
const SLACK: usize = 7;

/// What a sweep writes aside; one sweep at a time.
pub(super) struct LatticeState(Mutex<Held>);

struct Held {
    /// [`Lattice::row`] masks a group: for each step of the stencil, one bit a point: there is an intact bond.
    masks: Vec<u8>,
    /// The masks of the bonds' lists that these belong to.
    followed: Vec<u8>,
    shifts: Vec<f64>,
    /// Over the bond constant, of each component eight numbers a group.
    forces: Vec<f64>,
    /// Of each seat; that of a group's first tells of bonds that have broken in the group.
    broke: Vec<bool>,
}

/// The lattice part of a sweep for forces.
pub(super) struct OnLattice<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) state: &'a LatticeState,
    pub(super) bond_constant: f64,
    /// (l/L)^2 - 1 of bonds that come close to their limit.
    pub(super) threshold: f64,
    pub(super) limits: Limits<'a>,
}

impl LatticeState {
    pub(super) fn new(scene: &Scene<'_>, lattice: &Lattice) -> Result<Self> {
        let (seats, workers) = (lattice.members.len(), scene.workers);
        let mut held = Held {
            masks: workers.filled(0, lattice.groups.len() * lattice.row(), PURPOSE)?,
            followed: workers.filled(0, scene.families.block_count(), PURPOSE)?,
            shifts: workers.filled(0.0, scene.dimension * stride(lattice) + SLACK, PURPOSE)?,
            forces: workers.filled(0.0, seats * scene.dimension, PURPOSE)?,
            broke: workers.filled(false, seats, PURPOSE)?,
        };
        held.follow(lattice, scene.families, scene.bonds.intact);
        Ok(Self(Mutex::new(held)))
    }

    pub(super) fn bytes(&self) -> usize {
        let held = self.0.lock().unwrap_or_else(|poison| poison.into_inner());
        memory::bytes(&held.masks)
            + memory::bytes(&held.followed)
            + memory::bytes(&held.shifts)
            + memory::bytes(&held.forces)
            + memory::bytes(&held.broke)
    }
}

/// Numbers from one axis of the cells to the next.
fn stride(lattice: &Lattice) -> usize {
    lattice.point_of.len().next_multiple_of(512) + STAGGER
}

impl Held {
    /// Has the masks of groups say what those of the lists say.
    fn follow(&mut self, lattice: &Lattice, families: &Families, intact: &[u8]) {
        let of_member = |point: usize| &intact[families.blocks(point)];
        for (group, masks) in self.masks.chunks_exact_mut(lattice.row()).enumerate() {
            let mut members = lattice.members[group * LANES..][..LANES].iter();
            let changed = |&point: &u32| {
                let blocks = families.blocks(point as usize);
                self.followed[blocks.clone()] != intact[blocks]
            };
            if members.any(|point| *point != NOBODY && changed(point)) {
                lattice.turn(group, of_member, masks);
            }
        }
        self.followed.copy_from_slice(intact);
    }
}

/// Copies displacements to the cells, and gives those of each axis.
fn place<'a, const D: usize>(
    workers: &Workers,
    lattice: &Lattice,
    displacement: &[f64],
    cells: &'a mut [f64],
) -> [&'a [f64]; D] {
    let (count, stride) = (lattice.point_of.len(), stride(lattice));
    let ahead = cells.as_ptr().align_offset(64).min(SLACK);
    let cells = &mut cells[ahead..];
    let (shifts, _) = displacement.as_chunks::<D>();
    let mut axes = cells.chunks_mut(stride).map(|axis| &mut axis[..count]);
    let mut next = || PerPoint(axes.next().unwrap_or_default(), 1);
    let outputs = (next(), next(), (D == 3).then(next));
    workers.sweep(count, outputs, |range, (x, y, z)| {
        let points = &lattice.point_of[range];
        let mut axes = [Some(x.0), Some(y.0), z.map(|z| z.0)];
        for (axis, values) in axes.iter_mut().flatten().enumerate() {
            for (value, &point) in values.iter_mut().zip(points) {
                if point != NOBODY {
                    *value = shifts[point as usize][axis];
                }
            }
        }
    });
    let cells = &*cells;
    std::array::from_fn(|axis| &cells[axis * stride..][..count])
}

impl OnLattice<'_> {
    /// Forces per volume on the points of the lattice; with `remaining`, which holds the masks as they are, bonds that
    /// break leave it first. Gives the first point whose force is not finite, or a number beyond all points.
    pub(super) fn sweep<const D: usize>(
        &self,
        scene: &Scene<'_>,
        force: &mut [f64],
        remaining: Option<&mut [u8]>,
    ) -> usize {
        let (lattice, workers, families) = (self.lattice, scene.workers, scene.families);
        let mut held = self.state.0.lock().unwrap_or_else(|poison| poison.into_inner());
        let held = &mut *held;
        let (intact, count) = (scene.bonds.intact, scene.places.len());
        if is_changed(scene, &held.followed) {
            held.follow(lattice, families, intact);
        }
        let shifts = place::<D>(workers, lattice, scene.displacement, &mut held.shifts);
        let groups = Groups::<D>::new(lattice, shifts);
        let (seats, limits) = (lattice.members.len(), self.limits);
        held.broke.fill(false);
        let outputs = (
            PerPoint(&mut held.forces, D),
            PerPoint(&mut held.masks, lattice.row() / LANES),
            PerPoint(&mut held.broke, 1),
        );
        workers.sweep(seats, outputs, |range, (force, masks, broke)| {
            scene.simd.run(GroupSweep {
                groups,
                range: range.start / LANES..range.end / LANES,
                force: force.0,
                masks: masks.0,
                broke: broke.0,
                threshold: self.threshold,
                judge: limits,
            });
        });
        let (forces, _) = held.forces.as_chunks::<LANES>();
        let (broke, offsets) = (&held.broke, &families.offsets);
        let bad = AtomicUsize::new(usize::MAX);
        let remaining = remaining.map(|values| Ragged { values, offsets, width: 1 });
        let followed = Ragged { values: &mut held.followed[..], offsets, width: 1 };
        let outputs = (PerPoint(force, D), remaining, followed);
        workers.sweep(count, outputs, |range, (force, mut remaining, followed)| {
            let first = offsets[range.start] as usize;
            let (force, _) = force.0.as_chunks_mut::<D>();
            for (force, point) in force.iter_mut().zip(range) {
                let seat = lattice.seat_of[point];
                if seat == NOBODY {
                    continue;
                }
                let (group, lane) = (seat as usize / LANES, seat as usize % LANES);
                for (axis, force) in force.iter_mut().enumerate() {
                    *force = self.bond_constant * forces[group * D + axis][lane];
                }
                if !force.iter().all(|component| component.is_finite()) {
                    bad.fetch_min(point, Ordering::Relaxed);
                }
                if let (true, Some(remaining)) = (broke[group * LANES], &mut remaining) {
                    for bond in families.bonds(point) {
                        if limits.breaks_bond(point, bond) {
                            let bit = 1 << (bond.slot % LANES);
                            remaining.values[bond.slot / LANES - first] &= !bit;
                        }
                    }
                    // As the group's masks. Should the step fail, they will be found to differ.
                    let blocks = families.blocks(point);
                    let blocks = blocks.start - first..blocks.end - first;
                    followed.values[blocks.clone()].copy_from_slice(&remaining.values[blocks]);
                }
            }
        });
        bad.into_inner()
    }
}

/// Whether the masks of bonds are others than these.
fn is_changed(scene: &Scene<'_>, followed: &[u8]) -> bool {
    let (intact, offsets) = (scene.bonds.intact, &scene.families.offsets);
    let changed = AtomicBool::new(false);
    scene.workers.sweep(scene.places.len(), None::<PerPoint<'_, u8>>, |range, _| {
        let blocks = offsets[range.start] as usize..offsets[range.end] as usize;
        if intact[blocks.clone()] != followed[blocks] {
            changed.store(true, Ordering::Relaxed);
        }
    });
    changed.into_inner()
}
