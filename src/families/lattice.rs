//! Lattices: points on a common grid, found once in the whole undamaged body.
//!
//! Points of one volume that stand on the crossings of a grid, and whose neighbours all do, need no list of their own:
//! all have the same few vectors to their neighbours, the stencil. They are numbered by cells, row after row, with empty
//! cells between rows and planes as wide as a stencil reaches, and computed in groups of eight along a row.

#[cfg(test)]
mod tests;

use super::{Families, LANES, Place};
use crate::error::Result;
use crate::memory;

const PURPOSE: &str = "lattices";

/// No point there.
pub(crate) const NOBODY: u32 = u32::MAX;

/// Volumes and places that differ by no more than this, over themselves and over the spacing, are alike.
const TOLERANCE: f64 = 1e-12;

/// Farther off its crossing no point is on the grid, however its coordinates are rounded: bonds between the lattice and
/// the rest of the body must be judged alike from both ends.
const MOST_OFF: f64 = 1e-8;

/// Cells a point that a lattice may have; more waste memory on emptiness.
const CELLS_PER_POINT: usize = 4;

/// Points whose surroundings are looked at for a spacing.
const SEEDS: usize = 8;

/// A vector from a point of the lattice to a neighbour.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    /// Cells from one to the other.
    pub(crate) cells: isize,
    /// xi
    pub(crate) reference: [f64; 3],
}

/// The lattice of a body.
#[derive(Debug)]
pub(crate) struct Lattice {
    /// Of each of its points.
    pub(crate) volume: f64,
    /// In the order of `cells`.
    pub(crate) stencil: Vec<Step>,
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
}

/// A grid: a crossing, and the distances of planes.
struct Grid {
    origin: [f64; 3],
    spacing: [f64; 3],
    tolerance: f64,
}

impl Grid {
    /// The grid that the surroundings of a point suggest.
    fn around(places: &[Place], families: &Families, point: usize) -> Option<Self> {
        let own = &places[point];
        let (mut spacing, mut longest) = ([f64::INFINITY; 3], 0.0_f64);
        for bond in families.bonds(point) {
            let xi: [f64; 3] =
                std::array::from_fn(|axis| (places[bond.neighbor][axis] - own[axis]).abs());
            longest = longest.max(bond.length);
            for axis in 0..3 {
                if xi[axis] > (1.0 - 1e-9) * bond.length {
                    spacing[axis] = spacing[axis].min(xi[axis]);
                }
            }
        }
        // Across a single layer any distance will do, if none of the family is nearer.
        let spacing = spacing.map(|distance| if distance.is_finite() { distance } else { longest });
        let origin = [own[0], own[1], own[2]];
        (longest > 0.0).then_some(Self { origin, spacing, tolerance: 1e-6 })
    }

    /// The crossing that a place is at.
    fn crossing(&self, place: &Place) -> Option<[i32; 3]> {
        let mut numbers = [0; 3];
        for axis in 0..3 {
            let along = (place[axis] - self.origin[axis]) / self.spacing[axis];
            let number = along.round();
            if !(number.abs() < 1e6 && (along - number).abs() <= self.tolerance) {
                return None;
            }
            numbers[axis] = number as i32;
        }
        Some(numbers)
    }

    /// The same grid with the distances that all points on it agree on, and what they may be off them by.
    fn refined(self, places: &[Place], farthest: f64) -> Self {
        let mut ends = [[(0, 0.0); 2]; 3];
        for place in places {
            let Some(numbers) = self.crossing(place) else { continue };
            for axis in 0..3 {
                let here = (numbers[axis], place[axis] - self.origin[axis]);
                if here.0 < ends[axis][0].0 {
                    ends[axis][0] = here;
                }
                if here.0 > ends[axis][1].0 {
                    ends[axis][1] = here;
                }
            }
        }
        let mut spacing = self.spacing;
        for (spacing, [low, high]) in spacing.iter_mut().zip(ends) {
            if high.0 > low.0 {
                *spacing = (high.1 - low.1) / f64::from(high.0 - low.0);
            }
        }
        let smallest = spacing.iter().copied().fold(f64::INFINITY, f64::min);
        let rounding = 4.0 * f64::EPSILON * farthest / smallest;
        let tolerance = (TOLERANCE + rounding).min(MOST_OFF);
        Self { spacing, tolerance, ..self }
    }
}

/// How crossings are numbered as cells.
struct Numbering {
    /// The axis along rows first.
    axes: [usize; 3],
    first: [i32; 3],
    /// Cells from one row, and from one plane, to the next.
    strides: [usize; 3],
    /// Cells before the first.
    front: usize,
    cells: usize,
}

impl Numbering {
    /// `reach`: how many crossings a stencil goes along each axis.
    fn new(first: [i32; 3], counts: [usize; 3], reach: [usize; 3]) -> Self {
        // Rows that fill whole groups best.
        let filled =
            |axis: usize| counts[axis] as f64 / counts[axis].next_multiple_of(LANES) as f64;
        let mut axes = [0, 1, 2];
        for other in [1, 2] {
            if filled(axes[other]) > filled(axes[0]) + 1e-9 {
                axes.swap(0, other);
            }
        }
        let row = (counts[axes[0]] + reach[axes[0]]).next_multiple_of(LANES);
        let plane = (counts[axes[1]] + reach[axes[1]]).saturating_mul(row);
        let strides = [1, row, plane];
        let farthest = (0..3)
            .map(|k| reach[axes[k]].saturating_mul(strides[k]))
            .fold(0, usize::saturating_add);
        let front = farthest.next_multiple_of(LANES);
        let body = counts[axes[2]].saturating_mul(plane);
        Self { axes, first, strides, front, cells: body.saturating_add(2 * front + LANES) }
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
    /// The lattice of a body of sharp families of one horizon, if it has one that is worth it.
    pub(crate) fn find(
        places: &[Place],
        families: &Families,
        farthest: f64,
    ) -> Result<Option<Self>> {
        let count = places.len();
        let on = |grid: &Grid, volume: f64, place: &Place| {
            let alike = (place[3] - volume).abs() <= TOLERANCE * volume;
            if alike { grid.crossing(place) } else { None }
        };
        let mut best: Option<(usize, Grid, f64)> = None;
        for seed in (0..SEEDS).map(|k| (2 * k + 1) * count / (2 * SEEDS)) {
            let Some(grid) = Grid::around(places, families, seed) else { continue };
            let grid = grid.refined(places, farthest);
            let volume = places[seed][3];
            let met = places.iter().filter(|place| on(&grid, volume, place).is_some()).count();
            if best.as_ref().is_none_or(|best| met > best.0) {
                best = Some((met, grid, volume));
            }
            if met == count {
                break;
            }
        }
        let Some((_, grid, volume)) = best else { return Ok(None) };
        let each = places.iter().map(|place| on(&grid, volume, place));
        let crossings: Vec<Option<[i32; 3]>> = memory::collected(each, PURPOSE)?;
        Self::of(&crossings, families, &grid, volume)
    }

    fn of(
        crossings: &[Option<[i32; 3]>],
        families: &Families,
        grid: &Grid,
        volume: f64,
    ) -> Result<Option<Self>> {
        let count = crossings.len();
        let whole = |point: usize| {
            let mut bonds = families.bonds(point);
            crossings[point].is_some() && bonds.all(|bond| crossings[bond.neighbor].is_some())
        };
        let (mut first, mut last) = ([i32::MAX; 3], [i32::MIN; 3]);
        for numbers in crossings.iter().flatten() {
            for axis in 0..3 {
                first[axis] = first[axis].min(numbers[axis]);
                last[axis] = last[axis].max(numbers[axis]);
            }
        }
        // Vectors to neighbours, as they come: each is looked for among the few that are known.
        let mut vectors: Vec<[i32; 3]> = Vec::new();
        let mut members = 0;
        let mut known = memory::filled(false, (2 * REACH + 1).pow(3), PURPOSE)?;
        for point in (0..count).filter(|&point| whole(point)) {
            let Some(own) = crossings[point] else { continue };
            members += 1;
            for bond in families.bonds(point) {
                let Some(other) = crossings[bond.neighbor] else { continue };
                let vector = [other[0] - own[0], other[1] - own[1], other[2] - own[2]];
                let Some(number) = number_of(&vector) else { return Ok(None) };
                if !std::mem::replace(&mut known[number], true) {
                    memory::push(&mut vectors, vector, PURPOSE)?;
                }
            }
        }
        if members == 0 {
            return Ok(None);
        }
        let mut reach = [0; 3];
        for vector in &vectors {
            for axis in 0..3 {
                reach[axis] = reach[axis].max(vector[axis].unsigned_abs() as usize);
            }
        }
        let counts = std::array::from_fn(|axis| (last[axis] - first[axis]) as usize + 1);
        let numbering = Numbering::new(first, counts, reach);
        if numbering.cells > count.saturating_mul(CELLS_PER_POINT).min(NOBODY as usize) {
            return Ok(None);
        }
        let mut stencil = memory::reserved(vectors.len(), PURPOSE)?;
        for vector in &vectors {
            let reference: [f64; 3] =
                std::array::from_fn(|axis| f64::from(vector[axis]) * grid.spacing[axis]);
            stencil.push(Step { cells: numbering.cells(vector), reference });
        }
        stencil.sort_unstable_by_key(|step| step.cells);
        let mut point_of = memory::filled(NOBODY, numbering.cells, PURPOSE)?;
        let mut cell_of = memory::filled(NOBODY, count, PURPOSE)?;
        for (point, numbers) in crossings.iter().enumerate() {
            let Some(numbers) = numbers else { continue };
            let cell = numbering.cell(numbers);
            if std::mem::replace(&mut point_of[cell], point as u32) != NOBODY {
                return Ok(None);
            }
            cell_of[point] = cell as u32;
        }
        let mut lattice = Self {
            volume,
            stencil,
            point_of,
            cell_of,
            groups: Vec::new(),
            members: Vec::new(),
            seat_of: memory::filled(NOBODY, count, PURPOSE)?,
            count: members,
        };
        lattice.seat(whole)?;
        Ok(Some(lattice))
    }

    /// Makes groups of the points that are wholly on the lattice.
    fn seat(&mut self, whole: impl Fn(usize) -> bool) -> Result<()> {
        for first in (0..self.point_of.len()).step_by(LANES) {
            let mut group = [NOBODY; LANES];
            for (member, &point) in group.iter_mut().zip(&self.point_of[first..]) {
                if point != NOBODY && whole(point as usize) {
                    *member = point;
                }
            }
            if group == [NOBODY; LANES] {
                continue;
            }
            memory::push(&mut self.groups, first as u32, PURPOSE)?;
            for point in group {
                if point != NOBODY {
                    self.seat_of[point as usize] = self.members.len() as u32;
                }
                memory::push(&mut self.members, point, PURPOSE)?;
            }
        }
        Ok(())
    }

    /// Masks of a group: one for each step of the stencil, and some that fill up eights.
    pub(crate) fn row(&self) -> usize {
        self.stencil.len().next_multiple_of(LANES)
    }

    /// Cell of a member.
    pub(crate) fn cell(&self, seat: usize) -> usize {
        self.groups[seat / LANES] as usize + seat % LANES
    }

    /// Cell of a point, if it is on the lattice.
    pub(crate) fn cell_of(&self, point: usize) -> Option<usize> {
        let cell = self.cell_of[point];
        (cell != NOBODY).then_some(cell as usize)
    }

    /// Number of the step in the stencil that leads so many cells on.
    pub(crate) fn step(&self, cells: isize) -> Option<usize> {
        self.stencil.binary_search_by_key(&cells, |step| step.cells).ok()
    }

    pub(crate) fn bytes(&self) -> usize {
        memory::bytes(&self.stencil)
            + memory::bytes(&self.point_of)
            + memory::bytes(&self.cell_of)
            + memory::bytes(&self.groups)
            + memory::bytes(&self.members)
            + memory::bytes(&self.seat_of)
    }
}

/// Crossings along an axis that a stencil may reach.
const REACH: usize = 16;

/// A number of its own for each vector that a stencil may have.
fn number_of(vector: &[i32; 3]) -> Option<usize> {
    let mut number = 0;
    for along in vector {
        let shifted = usize::try_from(along + REACH as i32).ok()?;
        if shifted > 2 * REACH {
            return None;
        }
        number = number * (2 * REACH + 1) + shifted;
    }
    Some(number)
}
