//! The cell list: points sorted into cells, so that only those near a ball are looked at.
//!
//! Cells have half the radius as edge; points are counted into them, in O(N). The cells of a row follow each other, so
//! what lies near a box is some runs of members. Where the body leaves most of its bounding box empty, a sorted list of the
//! occupied cells is looked up instead.

use std::ops::Range;

use super::{Place, squared_length};
use crate::error::Result;
use crate::kernel::simd::{Kernel, Simd, SimdLevel};
use crate::memory;
use crate::sort::ByKey;
use crate::workers::{PerPoint, Workers};

/// Cells that a radius reaches over.
const REACH: f64 = 2.0;

/// Bits of a cell's number along one axis.
const AXIS_BITS: u32 = 21;

/// A table over all cells is kept where the body fills its bounding box at least this well.
const TABLE_CELLS_PER_POINT: f64 = 16.0;

/// A hair, relative to radius and edge, that keeps rounding from hiding a neighbour behind a cell.
const HAIR: f64 = 1e-9;

const PURPOSE: &str = "bonds";

/// Points sorted into cells.
pub(super) struct Cells {
    /// Largest radius of the points.
    pub(super) radius: f64,
    lower: [f64; 3],
    edge: f64,
    counts: [i64; 3],
    members: Members,
    lookup: Lookup,
}

/// Points cell after cell, one array for each coordinate. Some that stand nowhere follow at the end, so that
/// whole strides can be copied from every place.
struct Members {
    places: [Vec<f64>; 3],
    points: Vec<u32>,
}

/// How the members of a cell are found.
enum Lookup {
    /// First member of each cell of the bounding box, and the end.
    Table(Vec<u32>),
    /// Keys of the cells that have members, and the first member of each, and the end.
    Occupied(Vec<u64>, Vec<u32>),
}

/// Members near a box, copied together. Whole words of them are looked at; behind the last one some stand nowhere.
pub(super) struct Candidates {
    places: [[f64; ROOM]; 3],
    points: [u32; ROOM],
    count: usize,
}

/// Candidates that are looked at in one go.
const ROOM: usize = 1024;

/// Candidates whose bits make a word.
const WORD: usize = u64::BITS as usize;

/// Members that are copied together.
const STRIDE: usize = 8;

/// The box around some points.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) lower: [f64; 3],
    pub(super) upper: [f64; 3],
}

impl Bounds {
    pub(super) const EMPTY: Self =
        Self { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };

    /// With one more place.
    pub(super) fn with(mut self, place: &Place) -> Self {
        for (axis, x) in place[..3].iter().enumerate() {
            self.lower[axis] = self.lower[axis].min(*x);
            self.upper[axis] = self.upper[axis].max(*x);
        }
        self
    }

    pub(super) fn longest_edge(&self) -> f64 {
        (0..3).map(|axis| self.upper[axis] - self.lower[axis]).fold(0.0, f64::max)
    }
}

impl Cells {
    /// Cells of those `points` that there are, or of all places.
    pub(super) fn new(
        workers: &Workers,
        dimension: usize,
        places: &[Place],
        points: Option<&[u32]>,
        radius: f64,
    ) -> Result<Self> {
        let count = points.map_or(places.len(), <[u32]>::len);
        let point = |number: usize| points.map_or(number, |points| points[number] as usize);
        let places_of = (0..count).map(|number| &places[point(number)]);
        let Bounds { lower, upper } = places_of.fold(Bounds::EMPTY, Bounds::with);
        let extent = (0..dimension).map(|axis| upper[axis] - lower[axis]).fold(0.0, f64::max);
        let most = (1_i64 << AXIS_BITS) as f64 - 1.0;
        let edge = (radius / REACH).max(extent / most);
        let counts = [0, 1, 2].map(|axis| ((upper[axis] - lower[axis]) / edge) as i64 + 1);
        let mut cells = Self {
            radius,
            lower,
            edge,
            counts,
            members: Members::new(workers, count)?,
            lookup: Lookup::Table(Vec::new()),
        };
        let total: f64 = counts.iter().map(|&count| count as f64).product();
        // Both ways keep the points of a cell in their order.
        if total <= TABLE_CELLS_PER_POINT * count as f64 && total < f64::from(u32::MAX) {
            let mut numbers = workers.filled(0_u32, count, PURPOSE)?;
            workers.sweep(count, PerPoint(&mut numbers, 1), |range, numbers| {
                for (value, number) in numbers.0.iter_mut().zip(range) {
                    *value = cells.number(cells.cell(&places[point(number)])) as u32;
                }
            });
            let ByKey { indices, first } = ByKey::new(&numbers, total as usize, PURPOSE)?;
            cells.members.put(workers, places, |member| point(indices[member] as usize));
            cells.lookup = Lookup::Table(first);
        } else {
            let keyed =
                (0..count).map(|number| (key(cells.cell(&places[point(number)])), number as u32));
            let mut keyed = memory::collected(keyed, PURPOSE)?;
            keyed.sort_unstable();
            let (mut occupied, mut first) = (Vec::new(), Vec::new());
            for (member, &(key, _)) in keyed.iter().enumerate() {
                if occupied.last() != Some(&key) {
                    memory::push(&mut occupied, key, PURPOSE)?;
                    memory::push(&mut first, member as u32, PURPOSE)?;
                }
            }
            cells.members.put(workers, places, |member| point(keyed[member].1 as usize));
            memory::push(&mut first, count as u32, PURPOSE)?;
            cells.lookup = Lookup::Occupied(occupied, first);
        }
        Ok(cells)
    }

    fn cell(&self, place: &Place) -> [i64; 3] {
        [0, 1, 2].map(|axis| ((place[axis] - self.lower[axis]) / self.edge) as i64)
    }

    /// Number of a cell in the table over all of them, x fastest.
    fn number(&self, cell: [i64; 3]) -> usize {
        ((cell[2] * self.counts[1] + cell[1]) * self.counts[0] + cell[0]) as usize
    }

    /// Calls `met` with all members that are as near to a box as the radius, and others not much farther, in the order
    /// of the cells; as many at a time as there is room for.
    #[inline(always)]
    pub(super) fn visit(
        &self,
        bounds: &Bounds,
        radius: f64,
        room: &mut Candidates,
        mut met: impl FnMut(&Candidates),
    ) {
        room.count = 0;
        self.for_each_run(bounds, radius, |run| {
            let mut first = run.start;
            while first < run.end {
                if room.count > ROOM - STRIDE {
                    room.end();
                    met(room);
                    room.count = 0;
                }
                // What stands behind the run is overwritten by the next one.
                room.copy(&self.members, first);
                room.count += STRIDE.min(run.end - first);
                first += STRIDE;
            }
        });
        room.end();
        met(room);
    }

    /// Runs of members, row after row, that hold all within a radius of a box.
    #[inline(always)]
    fn for_each_run(&self, bounds: &Bounds, radius: f64, mut met: impl FnMut(Range<usize>)) {
        let reach = radius * (1.0 + HAIR);
        let near = |axis: usize| {
            let from = bounds.lower[axis] - self.lower[axis];
            let to = bounds.upper[axis] - self.lower[axis];
            let first = ((from - reach) / self.edge).max(0.0) as i64;
            let last = ((to + reach) / self.edge).floor() as i64;
            first..last.saturating_add(1).min(self.counts[axis])
        };
        let (along_x, along_y, along_z) = (near(0), near(1), near(2));
        if along_x.is_empty() || along_y.is_empty() || along_z.is_empty() {
            return;
        }
        let rows = (along_y.end - along_y.start).saturating_mul(along_z.end - along_z.start);
        let count = self.members.count();
        if rows > count as i64 {
            return met(0..count);
        }
        // Square of what lies at least between the box and a cell along an axis.
        let hair = HAIR * (radius + self.edge);
        let gap = |axis: usize, cell: i64| {
            let (start, end) = (cell as f64 * self.edge, (cell + 1) as f64 * self.edge);
            let below = start - (bounds.upper[axis] - self.lower[axis]);
            let above = (bounds.lower[axis] - self.lower[axis]) - end;
            (below.max(above) - hair).max(0.0).powi(2)
        };
        for z in along_z {
            let most = reach * reach - gap(2, z);
            for y in along_y.clone() {
                if gap(1, y) <= most {
                    met(self.run(along_x.clone(), y, z));
                }
            }
        }
    }

    /// The members of consecutive cells of a row.
    #[inline(always)]
    fn run(&self, x: Range<i64>, y: i64, z: i64) -> Range<usize> {
        match &self.lookup {
            Lookup::Table(first) => {
                let row = self.number([x.start, y, z]);
                first[row] as usize..first[row + (x.end - x.start) as usize] as usize
            }
            Lookup::Occupied(keys, first) => {
                let start = keys.partition_point(|&known| known < key([x.start, y, z]));
                let end =
                    start + keys[start..].partition_point(|&known| known < key([x.end, y, z]));
                first[start] as usize..first[end] as usize
            }
        }
    }
}

impl Members {
    /// Room for so many.
    fn new(workers: &Workers, count: usize) -> Result<Self> {
        let nowhere = || workers.filled(f64::INFINITY, count + STRIDE, PURPOSE);
        Ok(Self {
            places: [nowhere()?, nowhere()?, nowhere()?],
            points: workers.filled(0, count + STRIDE, PURPOSE)?,
        })
    }

    fn count(&self) -> usize {
        self.points.len() - STRIDE
    }

    /// Takes the points in their places.
    fn put(&mut self, workers: &Workers, places: &[Place], point: impl Fn(usize) -> usize + Sync) {
        let count = self.count();
        let [x, y, z] = self.places.each_mut().map(|along| PerPoint(&mut along[..], 1));
        let outputs = ((x, y, z), PerPoint(&mut self.points, 1));
        workers.sweep(count, outputs, |range, ((x, y, z), points)| {
            for (slot, member) in range.enumerate() {
                let point = point(member);
                points.0[slot] = point as u32;
                [x.0[slot], y.0[slot], z.0[slot], _] = places[point];
            }
        });
    }
}

impl Candidates {
    pub(super) const fn new() -> Self {
        Self { places: [[0.0; ROOM]; 3], points: [0; ROOM], count: 0 }
    }

    /// Appends the members from `first` on, without counting them.
    #[inline(always)]
    fn copy(&mut self, members: &Members, first: usize) {
        let (from, to) = (first..first + STRIDE, self.count..self.count + STRIDE);
        for (to_places, places) in self.places.iter_mut().zip(&members.places) {
            to_places[to.clone()].copy_from_slice(&places[from.clone()]);
        }
        self.points[to].copy_from_slice(&members.points[from]);
    }

    /// Fills the last word up.
    #[inline(always)]
    fn end(&mut self) {
        self.places[0][self.count..self.count.next_multiple_of(WORD)].fill(f64::INFINITY);
    }

    /// How many are not farther from a place than the root of `most`.
    pub(super) fn count_within(&self, simd: SimdLevel, place: &Place, most: f64) -> u64 {
        simd.run(Count { candidates: self, place, most })
    }

    /// Calls `found` with those that are not farther from a place than the root of `most` and the squares of their
    /// distances.
    #[inline(always)]
    pub(super) fn for_each_within(
        &self,
        simd: SimdLevel,
        place: &Place,
        most: f64,
        found: impl FnMut(u32, f64),
    ) {
        simd.run(Visit { candidates: self, place, most, found });
    }
}

/// Loops that compilers turn into vectors of the level; all levels give the same bits.
struct Count<'a> {
    candidates: &'a Candidates,
    place: &'a Place,
    most: f64,
}

impl Kernel for Count<'_> {
    type Output = u64;
    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> u64 {
        let Self { candidates: Candidates { places, count, .. }, place, most } = self;
        let [x, y, z] = places.each_ref().map(|along| &along[..*count]);
        let mut within = 0;
        for ((x, y), z) in x.iter().zip(y).zip(z) {
            within += u64::from(squared(place, [*x, *y, *z]) <= most);
        }
        within
    }
}

struct Visit<'a, F> {
    candidates: &'a Candidates,
    place: &'a Place,
    most: f64,
    found: F,
}

impl<F: FnMut(u32, f64)> Kernel for Visit<'_, F> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(mut self, _: S) {
        let Candidates { places, points, count } = self.candidates;
        for first in (0..*count).step_by(WORD) {
            let word = first..first + WORD;
            let [x, y, z] = places.each_ref().map(|along| &along[word.clone()]);
            let mut squares = [0.0; WORD];
            let mut bits = 0;
            for lane in 0..WORD {
                squares[lane] = squared(self.place, [x[lane], y[lane], z[lane]]);
                bits |= if squares[lane] <= self.most { EACH[lane] } else { 0 };
            }
            while bits != 0 {
                let candidate = bits.trailing_zeros() as usize;
                (self.found)(points[first + candidate], squares[candidate]);
                bits &= bits - 1;
            }
        }
    }
}

/// The square of a distance; the same bits from both ends.
#[inline(always)]
fn squared(from: &Place, [x, y, z]: [f64; 3]) -> f64 {
    squared_length(from, &[x, y, z, 0.0])
}

/// Bit by bit, a word of its own.
const EACH: [u64; WORD] = {
    let mut each = [1; WORD];
    let mut bit = 1;
    while bit < WORD {
        each[bit] = 1 << bit;
        bit += 1;
    }
    each
};

/// A cell's number along each axis in one word, x fastest.
fn key(cell: [i64; 3]) -> u64 {
    (((cell[2] as u64) << AXIS_BITS | cell[1] as u64) << AXIS_BITS) + cell[0] as u64
}
