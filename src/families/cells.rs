//! The cell list: points sorted into cells, so that only those near a ball are looked at.
//!
//! Cells have half the radius as edge; points are counted into them, in O(N). The cells of a row follow each other, so
//! what lies near a box is some runs of members. Where the body leaves most of its bounding box empty, a sorted list of the
//! occupied cells is looked up instead.

use std::ops::Range;

use super::{LANES, Place};
use crate::error::Result;
use crate::kernel::simd::{Kernel, Lanes, Mask, Simd, SimdLevel};
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

/// Squares below it have lost digits.
const TINY: f64 = 1e-290;

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

/// Members near a box, copied together. Whole blocks of them are looked at; behind the last one some stand nowhere.
#[repr(align(64))]
pub(super) struct Candidates {
    places: [[f64; ROOM]; 3],
    points: [u32; ROOM],
    count: usize,
}

/// Candidates that are looked at in one go.
const ROOM: usize = 1024;

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
        let near = |axis: usize, reach: f64| {
            let from = bounds.lower[axis] - self.lower[axis];
            let to = bounds.upper[axis] - self.lower[axis];
            let first = ((from - reach) / self.edge).max(0.0) as i64;
            let last = ((to + reach) / self.edge).floor() as i64;
            first..last.saturating_add(1).min(self.counts[axis])
        };
        let (along_x, along_y, along_z) = (near(0, reach), near(1, reach), near(2, reach));
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
                let most = most - gap(1, y);
                if most >= 0.0 {
                    let along_x = near(0, if most > TINY { most.sqrt() } else { reach });
                    if !along_x.is_empty() {
                        met(self.run(along_x, y, z));
                    }
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

    /// Fills the last block up.
    #[inline(always)]
    fn end(&mut self) {
        self.places[0][self.count..self.count.next_multiple_of(LANES)].fill(f64::INFINITY);
    }

    /// How many are not farther from a place than the root of `most`.
    pub(super) fn count_within(&self, simd: SimdLevel, place: &Place, most: f64) -> u32 {
        simd.run(Count { candidates: self, place, most })
    }

    /// Those that are not farther from a place than the root of `most`, in the order in which they stand.
    pub(super) fn find_within(&self, simd: SimdLevel, place: &Place, most: f64, hits: &mut Hits) {
        simd.run(Find { candidates: self, place, most, hits });
    }
}

/// Candidates that are near enough, and the squares of their distances, with room behind them for lanes that are packed.
#[repr(align(64))]
pub(super) struct Hits {
    squares: [f64; ROOM + LANES],
    points: [u32; ROOM + LANES],
    count: usize,
}

impl Hits {
    pub(super) const fn new() -> Self {
        Self { squares: [0.0; ROOM + LANES], points: [0; ROOM + LANES], count: 0 }
    }

    /// Keeps those that `keeps` says so of, by name and square of the distance.
    pub(super) fn retain(&mut self, mut keeps: impl FnMut(u32, f64) -> bool) {
        let mut end = 0;
        for hit in 0..self.count {
            let (point, square) = (self.points[hit], self.squares[hit]);
            (self.points[end], self.squares[end]) = (point, square);
            end += usize::from(keeps(point, square));
        }
        self.count = end;
    }

    /// Takes out a point, if it is among them.
    pub(super) fn forget(&mut self, point: u32) {
        let all = 0..self.count;
        if let Some(hit) = self.points[all.clone()].iter().position(|&other| other == point) {
            self.points.copy_within(hit + 1..all.end, hit);
            self.squares.copy_within(hit + 1..all.end, hit);
            self.count -= 1;
        }
    }

    pub(super) fn points(&self) -> &[u32] {
        &self.points[..self.count]
    }

    /// 1 over how far they are, in place of the squares.
    pub(super) fn inverse_lengths(&mut self, simd: SimdLevel) -> &[f64] {
        simd.run(Invert(&mut self.squares[..self.count.next_multiple_of(LANES)]));
        &self.squares[..self.count]
    }

    /// The square of the least distance; infinite without any.
    pub(super) fn least_square(&mut self, simd: SimdLevel) -> f64 {
        let whole = self.count.next_multiple_of(LANES);
        self.squares[self.count..whole].fill(f64::INFINITY);
        simd.run(Least(&self.squares[..whole]))
    }
}

/// Squares of the distances of candidates from a place; all levels give the same bits.
struct Squares<'a, F> {
    places: [&'a [f64]; 3],
    from: [F; 3],
    /// The least number above those that are small enough.
    limit: F,
}

impl<'a, F: Lanes> Squares<'a, F> {
    #[inline(always)]
    fn new<S: Simd<Lanes = F>>(
        simd: S,
        candidates: &'a Candidates,
        place: &Place,
        most: f64,
    ) -> Self {
        let [x, y, z] = &candidates.places;
        Self {
            places: [x, y, z],
            from: [simd.splat(place[0]), simd.splat(place[1]), simd.splat(place[2])],
            limit: simd.splat(most.next_up()),
        }
    }

    /// Those of candidates from `first` on, and which of them are small enough.
    #[inline(always)]
    fn at<S: Simd<Lanes = F>>(&self, simd: S, first: usize) -> (F, u8) {
        let x = simd.load(&self.places[0][first..]) - self.from[0];
        let y = simd.load(&self.places[1][first..]) - self.from[1];
        let z = simd.load(&self.places[2][first..]) - self.from[2];
        let squared = x * x + y * y + z * z;
        (squared, self.limit.above(squared).bits())
    }
}

/// How many are near enough.
struct Count<'a> {
    candidates: &'a Candidates,
    place: &'a Place,
    most: f64,
}

impl Kernel for Count<'_> {
    type Output = u32;
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u32 {
        let squares = Squares::new(simd, self.candidates, self.place, self.most);
        let mut within = 0;
        for first in (0..self.candidates.count).step_by(LANES) {
            let mut byte = 0;
            for part in (0..LANES).step_by(S::WIDTH) {
                byte |= squares.at(simd, first + part).1 << part;
            }
            within += byte.count_ones();
        }
        within
    }
}

/// Packs those that are near enough.
struct Find<'a> {
    candidates: &'a Candidates,
    place: &'a Place,
    most: f64,
    hits: &'a mut Hits,
}

impl Kernel for Find<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { candidates, place, most, hits } = self;
        let squares = Squares::new(simd, candidates, place, most);
        let mut end = 0;
        for first in (0..candidates.count).step_by(S::WIDTH) {
            let (squared, bits) = squares.at(simd, first);
            let points = &candidates.points[first..];
            simd.pack(bits, squared, points, &mut hits.squares[end..], &mut hits.points[end..]);
            end += bits.count_ones() as usize;
        }
        hits.count = end;
    }
}

/// Makes 1/L of L^2.
struct Invert<'a>(&'a mut [f64]);

impl Kernel for Invert<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for values in self.0.chunks_exact_mut(S::WIDTH) {
            (simd.splat(1.0) / simd.load(values).sqrt()).store(values);
        }
    }
}

/// The least of some numbers.
struct Least<'a>(&'a [f64]);

impl Kernel for Least<'_> {
    type Output = f64;
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        let zero = simd.splat(0.0);
        let mut nearest = simd.splat(f64::NEG_INFINITY);
        for values in self.0.chunks_exact(S::WIDTH) {
            nearest = nearest.max(zero - simd.load(values));
        }
        let mut each = [f64::NEG_INFINITY; LANES];
        nearest.store(&mut each);
        -each.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A cell's number along each axis in one word, x fastest.
fn key(cell: [i64; 3]) -> u64 {
    (((cell[2] as u64) << AXIS_BITS | cell[1] as u64) << AXIS_BITS) + cell[0] as u64
}
