//! Lattices: points on a common grid, found once in the whole undamaged body.
//!
//! Points of one volume that stand on the crossings of a grid, and whose neighbours all do, need no list of their own:
//! all have the same few vectors to their neighbours, the stencil. They are numbered by cells, row after row, with empty
//! rows between planes, as many as a stencil reaches, and computed in groups of eight cells. Between rows there are empty
//! cells where groups of neighbouring rows are to stand side by side; else steps from the ends of a row may lead into the
//! next one, and are no bonds.

#[cfg(test)]
mod tests;

use super::grid::{Crossings, Grid};
use super::search::largest_square;
use super::{LANES, Place, squared_length};
use crate::error::Result;
use crate::memory;
use crate::workers::{PerPoint, Workers};

const PURPOSE: &str = "lattices";

/// No point there.
pub(crate) const NOBODY: u32 = u32::MAX;

/// Cells a point that a lattice may have; more waste memory on emptiness.
const CELLS_PER_POINT: usize = 4;

/// Lanes that a point may have, since sweeps name those of a few points at a time: in 3D up to 12 spacings.
pub(crate) const MOST_LANES: usize = 8192;

/// A vector from a point of the lattice to a neighbour.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    /// Cells from one to the other.
    pub(crate) cells: isize,
    /// xi
    pub(crate) reference: [f64; 3],
}

/// What sweeps make of a lattice. Members need no lists: other sweeps name the lanes of a few points at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LatticeUse {
    None,
    /// They run on any part of the body that is one, group by group.
    Groups,
    /// The same, and groups that stand side by side in neighbouring rows are computed together.
    Pairs,
}

/// The lattice of a body.
#[derive(Debug)]
pub(crate) struct Lattice {
    /// Of each of its points.
    pub(crate) volume: f64,
    /// In the order of `cells`.
    pub(crate) stencil: Vec<Step>,
    /// Of each step, whether it is as long as the horizon, so that the places of both ends decide whether there is a bond.
    doubtful: Vec<bool>,
    /// The most that the square of a bond's length is.
    most: f64,
    /// Inner place of the point in each cell; points off the lattice that have neighbours on it have none.
    pub(crate) point_of: Vec<u32>,
    /// Cell of each inner place.
    cell_of: Vec<u32>,
    /// First cell of each group.
    pub(crate) groups: Vec<u32>,
    /// Inner places of the groups' points whose families are wholly on the lattice, [`LANES`] a group.
    pub(crate) members: Vec<u32>,
    /// Where each inner place stands among the members.
    pub(crate) seat_of: Vec<u32>,
    /// Number of members.
    pub(crate) count: usize,
    /// A member of each kind, where kinds are told apart: bonds of a member lead to points of its own kind alone.
    samples: Vec<u32>,
    /// Of each group, which of these its members are like; empty where there is one kind.
    kinds: Vec<u16>,
    /// First cell of the first row.
    front: usize,
    /// Cells from a row to the next.
    pub(crate) next_row: usize,
    /// Crossings that a stencil goes beyond the ends of a row, into others.
    overhang: usize,
    /// Steps that two points of neighbouring rows take to the same cells; none without pairs.
    pub(crate) shared: Vec<SharedStep>,
}

/// A step from a cell, and from the one beside it in the next row, to the same cell: cells from the first, and which step of
/// the stencil it is for each, or [`NOBODY`] where it is none.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SharedStep {
    pub(crate) cells: isize,
    pub(crate) steps: [u32; 2],
}

/// How crossings are numbered as cells.
struct Numbering {
    /// The axis along rows first.
    axes: [usize; 3],
    first: [i32; 3],
    /// Cells from one row, and from one plane, to the next.
    strides: [usize; 3],
    /// Crossings that a stencil goes beyond the ends of a row, into others.
    overhang: usize,
    /// Cells before the first.
    front: usize,
    cells: usize,
}

impl Numbering {
    /// `reach`: how many crossings a stencil goes along each axis; `gaps`: whether rows begin with groups, so that those of
    /// neighbouring rows stand side by side.
    fn new(first: [i32; 3], counts: [usize; 3], reach: [usize; 3], gaps: bool) -> Self {
        // Rows that fill whole groups best, or without gaps the longest.
        let worth = |axis: usize| {
            let count = counts[axis] as f64;
            if gaps { count / counts[axis].next_multiple_of(LANES) as f64 } else { count }
        };
        let mut axes = [0, 1, 2];
        for other in [1, 2] {
            if worth(axes[other]) > worth(axes[0]) + 1e-9 {
                axes.swap(0, other);
            }
        }
        let (count, along) = (counts[axes[0]], reach[axes[0]]);
        // Without gaps, no two steps are to lead to the same cell; those into another row are longer than all others then.
        let (row, overhang) = if !gaps && count > 2 * along {
            (count, along)
        } else {
            ((count + along).next_multiple_of(LANES), 0)
        };
        let plane = (counts[axes[1]] + reach[axes[1]]).saturating_mul(row);
        let strides = [1, row, plane];
        let farthest = (0..3)
            .map(|k| reach[axes[k]].saturating_mul(strides[k]))
            .fold(0, usize::saturating_add);
        let front = farthest.next_multiple_of(LANES);
        let body = counts[axes[2]].saturating_mul(plane);
        let cells = body.saturating_add(2 * front + LANES);
        Self { axes, first, strides, overhang, front, cells }
    }

    fn cell(&self, numbers: &[i32; 3]) -> usize {
        let along = |k: usize| (numbers[self.axes[k]] - self.first[self.axes[k]]) as usize;
        self.front + (0..3).map(|k| along(k) * self.strides[k]).sum::<usize>()
    }

    /// Cells from a crossing to one so many further.
    fn cells(&self, numbers: &[i32; 3]) -> isize {
        (0..3).map(|k| numbers[self.axes[k]] as isize * self.strides[k] as isize).sum()
    }
}

impl Lattice {
    /// The lattice of the crossings of a body of sharp families of one radius, if it is worth it; `whole` tells of each
    /// inner place whether all its neighbours are at crossings, too, and then whether it is a member. `kinds`: of each inner place,
    /// where they are to be told apart.
    pub(super) fn of(
        workers: &Workers,
        crossings: &Crossings,
        whole: &mut [bool],
        kinds: Option<&[u16]>,
        radius: f64,
        pairs: bool,
    ) -> Result<Option<Self>> {
        let Crossings { grid, volume, of } = crossings;
        let count = of.len();
        let (mut first, mut last) = ([i32::MAX; 3], [i32::MIN; 3]);
        for numbers in of.iter().flatten() {
            for axis in 0..3 {
                first[axis] = first[axis].min(numbers[axis]);
                last[axis] = last[axis].max(numbers[axis]);
            }
        }
        if !whole.contains(&true) {
            return Ok(None);
        }
        let counts = std::array::from_fn(|axis| (last[axis] - first[axis]) as usize + 1);
        let Some(vectors) = vectors(grid, counts, radius)? else { return Ok(None) };
        let mut reach = [0; 3];
        for (vector, _) in &vectors {
            for axis in 0..3 {
                reach[axis] = reach[axis].max(vector[axis].unsigned_abs() as usize);
            }
        }
        // Or the end of a row would be in a group with the start of the next, of another kind.
        let numbering = Numbering::new(first, counts, reach, pairs || kinds.is_some());
        if numbering.cells > count.saturating_mul(CELLS_PER_POINT).min(NOBODY as usize) {
            return Ok(None);
        }
        let mut steps = memory::reserved(vectors.len(), PURPOSE)?;
        for (vector, is_doubtful) in &vectors {
            let step = Step { cells: numbering.cells(vector), reference: along(grid, vector) };
            steps.push((step, *is_doubtful));
        }
        steps.sort_unstable_by_key(|(step, _)| step.cells);
        let mut point_of = memory::filled(NOBODY, numbering.cells, PURPOSE)?;
        let mut cell_of = memory::filled(NOBODY, count, PURPOSE)?;
        for (point, numbers) in of.iter().enumerate() {
            let Some(numbers) = numbers else { continue };
            let cell = numbering.cell(numbers);
            if std::mem::replace(&mut point_of[cell], point as u32) != NOBODY {
                return Ok(None);
            }
            cell_of[point] = cell as u32;
        }
        let mut lattice = Self {
            volume: *volume,
            stencil: memory::collected(steps.iter().map(|(step, _)| *step), PURPOSE)?,
            doubtful: memory::collected(steps.iter().map(|(_, doubtful)| *doubtful), PURPOSE)?,
            most: largest_square(radius),
            point_of,
            cell_of,
            groups: Vec::new(),
            members: Vec::new(),
            seat_of: memory::filled(NOBODY, count, PURPOSE)?,
            count: 0,
            samples: Vec::new(),
            kinds: Vec::new(),
            front: numbering.front,
            next_row: numbering.strides[1],
            overhang: numbering.overhang,
            shared: if pairs { shared(&steps, numbering.strides[1] as isize)? } else { Vec::new() },
        };
        if let Some(kinds) = kinds {
            lattice.leave_to_lists_what_is_mixed(workers, kinds, whole);
        }
        lattice.seat(kinds, whole)?;
        Ok((lattice.count > 0).then_some(lattice))
    }

    /// Clears the flags of points with neighbours of another kind.
    fn leave_to_lists_what_is_mixed(&self, workers: &Workers, kinds: &[u16], whole: &mut [bool]) {
        workers.sweep(whole.len(), PerPoint(whole, 1), |range, whole| {
            for (whole, point) in whole.0.iter_mut().zip(range).filter(|(whole, _)| **whole) {
                let cell = self.cell_of[point] as usize;
                let there = |step: &Step| self.point_of[cell.wrapping_add_signed(step.cells)];
                let mut neighbors = self.stencil.iter().map(there).filter(|&point| point != NOBODY);
                *whole = neighbors.all(|there| kinds[there as usize] == kinds[point]);
            }
        });
    }

    /// Makes groups of the points that are wholly on the lattice; those that are of another kind than most of their group become no
    /// members.
    fn seat(&mut self, kinds: Option<&[u16]>, whole: &mut [bool]) -> Result<()> {
        let kind_of = |point: u32| kinds.map_or(0, |kinds| kinds[point as usize]);
        for first in (0..self.point_of.len()).step_by(LANES) {
            let mut group = [NOBODY; LANES];
            for (member, &point) in group.iter_mut().zip(&self.point_of[first..]) {
                if point != NOBODY && whole[point as usize] {
                    *member = point;
                }
            }
            let present = || group.into_iter().filter(|&point| point != NOBODY);
            let alike = |point| present().filter(|&other| kind_of(other) == kind_of(point)).count();
            let Some(like) = present().rev().max_by_key(|&point| alike(point)) else {
                continue;
            };
            let kind = kind_of(like);
            for member in group.iter_mut().filter(|member| **member != NOBODY) {
                if kind_of(*member) != kind {
                    whole[*member as usize] = false;
                    *member = NOBODY;
                }
            }
            memory::push(&mut self.groups, first as u32, PURPOSE)?;
            for point in group {
                if point != NOBODY {
                    self.seat_of[point as usize] = self.members.len() as u32;
                    self.count += 1;
                }
                memory::push(&mut self.members, point, PURPOSE)?;
            }
            if kinds.is_some() {
                let known = self.samples.iter().position(|&sample| kind_of(sample) == kind);
                let number = known.unwrap_or(self.samples.len());
                if known.is_none() {
                    memory::push(&mut self.samples, like, PURPOSE)?;
                }
                memory::push(&mut self.kinds, number as u16, PURPOSE)?;
            }
        }
        Ok(())
    }

    /// A point that the members of a kind are like.
    pub(crate) fn sample(&self, kind: usize) -> usize {
        self.samples.get(kind).map_or(0, |&sample| sample as usize)
    }

    /// Number of kinds.
    pub(crate) fn kinds(&self) -> usize {
        self.samples.len().max(1)
    }

    /// Kind of the members of a group.
    pub(crate) fn kind(&self, group: usize) -> usize {
        self.kinds.get(group).map_or(0, |&kind| kind as usize)
    }

    /// Masks of a group: one for each step of the stencil, and some that fill up eights.
    pub(crate) fn row(&self) -> usize {
        self.stencil.len().next_multiple_of(LANES)
    }

    /// Cell of a member.
    pub(crate) fn cell(&self, seat: usize) -> usize {
        self.groups[seat / LANES] as usize + seat % LANES
    }

    /// Cell of a point whose family is wholly on the lattice.
    pub(super) fn member(&self, point: usize) -> Option<usize> {
        (self.seat_of[point] != NOBODY).then(|| self.cell_of[point] as usize)
    }

    /// The neighbour of the member in a cell along a step of the stencil, and the square of its distance.
    #[inline(always)]
    pub(super) fn neighbor(
        &self,
        places: &[Place],
        cell: usize,
        step: usize,
    ) -> Option<(usize, f64)> {
        let there = cell.wrapping_add_signed(self.stencil.get(step)?.cells);
        let neighbor = self.point_of[there] as usize;
        if neighbor == NOBODY as usize {
            return None;
        }
        let squared = squared_length(&places[self.point_of[cell] as usize], &places[neighbor]);
        (squared <= self.most).then_some((neighbor, squared))
    }

    /// The points that the lanes of the member in a cell lead to from a step on, and the member itself where there is none; a
    /// mask tells of those that are no bonds.
    pub(super) fn name(&self, cell: usize, first: usize, names: &mut [u32]) {
        let own = self.point_of[cell];
        let steps = self.stencil.get(first..).unwrap_or_default();
        let (near, rest) = names.split_at_mut(names.len().min(steps.len()));
        for (name, step) in near.iter_mut().zip(steps) {
            let there = self.point_of[cell.wrapping_add_signed(step.cells)];
            *name = if there == NOBODY { own } else { there };
        }
        rest.fill(own);
    }

    /// Writes the masks of the member in a cell, one for eight steps.
    pub(super) fn mark_bonds(&self, places: &[Place], cell: usize, masks: &mut [u8]) {
        for (mask, steps) in masks.iter_mut().zip(self.stencil.chunks(LANES)) {
            *mask = 0;
            for (bit, step) in steps.iter().enumerate() {
                let there = self.point_of[cell.wrapping_add_signed(step.cells)];
                *mask |= u8::from(there != NOBODY) << bit;
            }
        }
        let column = (cell - self.front) % self.next_row;
        let is_inside = column >= self.overhang && column + self.overhang < self.next_row;
        for step in (0..self.stencil.len()).filter(|&step| self.doubtful[step] || !is_inside) {
            if self.neighbor(places, cell, step).is_none() {
                masks[step / LANES] &= !(1 << (step % LANES));
            }
        }
    }

    /// Number of the step from the member in a cell to that of a point, if it is one of the stencil.
    pub(super) fn step_to(&self, cell: usize, point: usize) -> Option<usize> {
        let there = self.cell_of[point];
        if there == NOBODY {
            return None;
        }
        let cells = there as isize - cell as isize;
        self.stencil.binary_search_by_key(&cells, |step| step.cells).ok()
    }

    /// Writes the masks of a group, one a step of the stencil, from those of its members, one for eight steps each.
    pub(crate) fn turn<'a>(
        &self,
        group: usize,
        of_member: impl Fn(usize) -> &'a [u8],
        masks: &mut [u8],
    ) {
        let seats = &self.members[group * LANES..(group + 1) * LANES];
        let rows: [&[u8]; LANES] = std::array::from_fn(|lane| match seats[lane] {
            NOBODY => &[][..],
            member => of_member(member as usize),
        });
        for (eight, masks) in masks.chunks_exact_mut(LANES).enumerate() {
            let of_lane = rows.map(|row| row.get(eight).copied().unwrap_or(0));
            masks.copy_from_slice(&transposed(of_lane));
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        memory::bytes(&self.stencil)
            + memory::bytes(&self.shared)
            + memory::bytes(&self.doubtful)
            + memory::bytes(&self.point_of)
            + memory::bytes(&self.cell_of)
            + memory::bytes(&self.groups)
            + memory::bytes(&self.members)
            + memory::bytes(&self.seat_of)
            + memory::bytes(&self.samples)
            + memory::bytes(&self.kinds)
    }
}

/// Steps of two points that are so many cells apart, by the cells they lead to.
fn shared(steps: &[(Step, bool)], apart: isize) -> Result<Vec<SharedStep>> {
    let mut shared = memory::reserved(2 * steps.len(), PURPOSE)?;
    let (mut first, mut second) = (0, 0);
    while first < steps.len() || second < steps.len() {
        let cells = |step: usize, from: isize| steps.get(step).map(|(step, _)| step.cells + from);
        let [low, high] = [cells(first, 0), cells(second, apart)];
        let nearest = low.into_iter().chain(high).fold(isize::MAX, isize::min);
        let mut both = [NOBODY; 2];
        if low == Some(nearest) {
            both[0] = first as u32;
            first += 1;
        }
        if high == Some(nearest) {
            both[1] = second as u32;
            second += 1;
        }
        shared.push(SharedStep { cells: nearest, steps: both });
    }
    Ok(shared)
}

/// Crossings along an axis that a stencil may reach.
const REACH: usize = 16;

/// Crossings from one to another, and whether the places of both ends decide about a bond.
type Vectors = Vec<([i32; 3], bool)>;

/// The vectors from a crossing to those within a radius, of bodies of so many crossings, and whether they are as long
/// as the radius but for what points are off; `None` where they reach too far.
fn vectors(grid: &Grid, counts: [usize; 3], radius: f64) -> Result<Option<Vectors>> {
    let widest = grid.spacing.iter().copied().fold(0.0, f64::max);
    // Both ends may be off along all axes.
    let margin = 4.0 * grid.tolerance * widest;
    let most =
        |axis: usize| ((radius + margin) / grid.spacing[axis]).min((counts[axis] - 1) as f64);
    let reach = [most(0), most(1), most(2)];
    if reach.iter().any(|reach| *reach >= (REACH + 1) as f64) {
        return Ok(None);
    }
    let [x, y, z] = reach.map(|reach| reach as i32);
    let mut vectors = Vec::new();
    for z in -z..=z {
        for y in -y..=y {
            for x in -x..=x {
                let (vector, length) = ([x, y, z], length(&along(grid, &[x, y, z])));
                if vector != [0; 3] && length <= radius + margin {
                    memory::push(&mut vectors, (vector, length > radius - margin), PURPOSE)?;
                }
            }
        }
    }
    Ok((!vectors.is_empty()).then_some(vectors))
}

fn along(grid: &Grid, vector: &[i32; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| f64::from(vector[axis]) * grid.spacing[axis])
}

fn length([x, y, z]: &[f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// Bit `k` of byte `n` becomes bit `n` of byte `k`.
fn transposed(bytes: [u8; LANES]) -> [u8; LANES] {
    let mut bits = u64::from_le_bytes(bytes);
    // Pairs of bits, of squares of four and of sixteen, change places across the diagonal.
    for (mask, shift) in
        [(0x00aa_00aa_00aa_00aa, 7), (0x0000_cccc_0000_cccc, 14), (0x0000_0000_f0f0_f0f0, 28)]
    {
        let moved = (bits ^ (bits >> shift)) & mask;
        bits ^= moved ^ (moved << shift);
    }
    bits.to_le_bytes()
}
