//! Neighbour search by a cell list.
//!
//! Cells have half the horizon as edge; points are counted into them, in O(N). The
//! cells of a row follow each other, so a point looks at 5 x 5 runs of cells (in 2D at 5). Where the
//! body leaves most of its bounding box empty, a sorted list of the occupied cells is looked up instead.
//! Points whose horizons differ by more than a factor of two have cells of their own, so that a few
//! large horizons do not make all points look far.

use std::ops::Range;

use super::{Families, LANES, Place, Property, Reach, Rim, squared_length};
use crate::error::{Result, argument};
use crate::memory;
use crate::workers::{PerPoint, Ragged, Workers};

/// Cells that a horizon reaches over.
const REACH: f64 = 2.0;

/// Bits of a cell's number along one axis.
const AXIS_BITS: u32 = 21;

/// A table over all cells is kept where the body fills its bounding box at least this well.
const TABLE_CELLS_PER_POINT: f64 = 16.0;

const PURPOSE: &str = "bonds";

/// The families of all points for their horizons, and with the rim if they have one; `farthest` is the
/// largest magnitude of the coordinates that the host gave.
pub(crate) fn find(
    workers: &Workers,
    dimension: usize,
    places: &[Place],
    horizons: &Property,
    rim: Option<Rim>,
    farthest: f64,
) -> Result<Families> {
    let farthest_of = radii(horizons, rim.as_ref(), farthest)?;
    let reach = Reach { radii: radii(horizons, None, farthest)?, rim };
    let search = Search::new(dimension, places, &farthest_of, &reach)?;
    let count = places.len();
    let mut sizes = memory::filled(0_u32, count, PURPOSE)?;
    workers.sweep(count, PerPoint(&mut sizes, 1), |range, sizes| {
        for (size, point) in sizes.0.iter_mut().zip(range) {
            search.visit(point, |_, _| *size += 1);
        }
    });
    let mut offsets = memory::reserved(count + 1, PURPOSE)?;
    let mut blocks = 0_u64;
    offsets.push(blocks);
    for &size in &sizes {
        blocks += (size as usize).div_ceil(LANES) as u64;
        offsets.push(blocks);
    }
    let lanes = usize::try_from(blocks).ok().and_then(|blocks| blocks.checked_mul(LANES));
    let lanes = lanes.unwrap_or(usize::MAX);
    let mut neighbors = memory::filled(0_u32, lanes, PURPOSE)?;
    let mut inverse_lengths = memory::filled(1.0_f64, lanes, PURPOSE)?;
    let outputs = (
        Ragged { values: &mut neighbors, offsets: &offsets, width: LANES },
        Ragged { values: &mut inverse_lengths, offsets: &offsets, width: LANES },
    );
    workers.sweep(count, outputs, |range, (neighbors, inverses)| {
        let start = offsets[range.start] as usize * LANES;
        for point in range {
            let mut slot = offsets[point] as usize * LANES - start;
            search.visit(point, |neighbor, length| {
                neighbors.values[slot] = neighbor;
                inverses.values[slot] = length.recip();
                slot += 1;
            });
            let end = offsets[point + 1] as usize * LANES - start;
            neighbors.values[slot..end].fill(point as u32);
        }
    });
    if count > 1 && lanes == 0 {
        return argument(no_neighbors(places, horizons));
    }
    Ok(Families { offsets, neighbors, inverse_lengths, reach, lattice: None })
}

/// Horizons with the tolerance that lets `horizon = k * spacing` reach the k-th shell, and with the most that
/// a rim adds.
fn radii(horizons: &Property, rim: Option<&Rim>, farthest: f64) -> Result<Property> {
    let largest = match rim.map(|rim| &rim.edges) {
        Some(Property::PerPoint(edges)) => edges.iter().copied().fold(0.0, f64::max),
        Some(Property::Uniform(edge)) => *edge,
        None => 0.0,
    };
    let radius = |horizon: f64, point: usize| {
        let width = rim.map_or(0.0, |rim| 0.5 * (rim.edges.at(point) + largest));
        let tolerance = (8.0 * f64::EPSILON * farthest / horizon).max(1e-10);
        horizon * (1.0 + tolerance) + 0.5 * width
    };
    Ok(match (horizons, rim.map(|rim| &rim.edges)) {
        (Property::Uniform(horizon), None | Some(Property::Uniform(_))) => {
            Property::Uniform(radius(*horizon, 0))
        }
        (Property::PerPoint(each), _) | (_, Some(Property::PerPoint(each))) => {
            let radii = (0..each.len()).map(|point| radius(horizons.at(point), point));
            Property::PerPoint(memory::collected(radii, "horizons")?)
        }
    })
}

fn no_neighbors(places: &[Place], horizons: &Property) -> String {
    let nearest = places[1..]
        .iter()
        .map(|place| squared_length(&places[0], place))
        .fold(f64::INFINITY, f64::min)
        .sqrt();
    format!(
        "'horizon' {} reaches no neighbour of any point (one of the points has its nearest at \
         {nearest}); it must exceed the spacing, 3.015 spacings are usual",
        horizons.at(0)
    )
}

/// All points in cells, those of like radii together.
struct Search<'a> {
    places: &'a [Place],
    /// Beyond these a point has nobody in its own family.
    radii: &'a Property,
    reach: &'a Reach,
    classes: Vec<Cells>,
}

/// Classes of radii, each up to twice those of the one before; the last holds all larger ones.
const MOST_CLASSES: usize = 32;

impl<'a> Search<'a> {
    fn new(
        dimension: usize,
        places: &'a [Place],
        radii: &'a Property,
        reach: &'a Reach,
    ) -> Result<Self> {
        let mut classes = memory::reserved(MOST_CLASSES, PURPOSE)?;
        match radii {
            Property::Uniform(radius) => {
                let all = memory::collected(0..places.len() as u32, PURPOSE)?;
                classes.push(Cells::new(dimension, places, &all, *radius)?);
            }
            Property::PerPoint(values) => {
                let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
                let class_of =
                    |radius: f64| ((radius / smallest).log2() as usize).min(MOST_CLASSES - 1);
                let last = values.iter().copied().map(class_of).max().unwrap_or(0);
                for class in 0..=last {
                    let mut points = Vec::new();
                    let mut largest: f64 = 0.0;
                    for (point, &radius) in values.iter().enumerate() {
                        if class_of(radius) == class {
                            memory::push(&mut points, point as u32, PURPOSE)?;
                            largest = largest.max(radius);
                        }
                    }
                    if !points.is_empty() {
                        classes.push(Cells::new(dimension, places, &points, largest)?);
                    }
                }
            }
        }
        Ok(Self { places, radii, reach, classes })
    }

    /// Calls `found` with each neighbour of a point and its distance: in the family of either.
    #[inline(always)]
    fn visit(&self, point: usize, mut found: impl FnMut(u32, f64)) {
        let place = &self.places[point];
        let own_radius = self.radii.at(point);
        for cells in &self.classes {
            cells.visit(place, own_radius.max(cells.radius), |other, other_place| {
                let [x, y, z] = *other_place;
                let squared = squared_length(place, &[x, y, z, 0.0]);
                let radius = match self.radii {
                    Property::Uniform(radius) => *radius,
                    Property::PerPoint(values) => own_radius.max(values[other as usize]),
                };
                // The square root decides; the squares, with room for rounding, sort out most.
                if squared <= radius * radius * (1.0 + 1e-14) && other as usize != point {
                    let length = squared.sqrt();
                    let belongs = |from: usize, to: usize| self.reach.share(from, to, length) > 0.0;
                    if length <= radius
                        && (belongs(point, other as usize) || belongs(other as usize, point))
                    {
                        found(other, length);
                    }
                }
            });
        }
    }
}

/// Points sorted into cells.
struct Cells {
    /// Largest radius of the points.
    radius: f64,
    lower: [f64; 3],
    edge: f64,
    counts: [i64; 3],
    /// Points, cell after cell.
    members: Vec<Member>,
    lookup: Lookup,
}

#[derive(Clone, Copy)]
struct Member {
    place: [f64; 3],
    point: u32,
}

/// How the members of a cell are found.
enum Lookup {
    /// First member of each cell of the bounding box, and the end.
    Table(Vec<u32>),
    /// Keys of the cells that have members, and the first member of each, and the end.
    Occupied(Vec<u64>, Vec<u32>),
}

impl Cells {
    fn new(dimension: usize, places: &[Place], points: &[u32], radius: f64) -> Result<Self> {
        let (mut lower, mut upper) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &point in points {
            for axis in 0..3 {
                lower[axis] = lower[axis].min(places[point as usize][axis]);
                upper[axis] = upper[axis].max(places[point as usize][axis]);
            }
        }
        let extent = (0..dimension).map(|axis| upper[axis] - lower[axis]).fold(0.0, f64::max);
        let most = (1_i64 << AXIS_BITS) as f64 - 1.0;
        let edge = (radius / REACH).max(extent / most);
        let counts = [0, 1, 2].map(|axis| ((upper[axis] - lower[axis]) / edge) as i64 + 1);
        let mut cells = Self {
            radius,
            lower,
            edge,
            counts,
            members: memory::reserved(points.len(), PURPOSE)?,
            lookup: Lookup::Table(Vec::new()),
        };
        let total: f64 = counts.iter().map(|&count| count as f64).product();
        if total <= TABLE_CELLS_PER_POINT * points.len() as f64 {
            cells.fill_table(places, points, total as usize)?;
        } else {
            cells.fill_occupied(places, points)?;
        }
        Ok(cells)
    }

    fn cell(&self, place: &[f64]) -> [i64; 3] {
        [0, 1, 2].map(|axis| ((place[axis] - self.lower[axis]) / self.edge) as i64)
    }

    /// Number of a cell in the table over all of them, x fastest.
    fn number(&self, cell: [i64; 3]) -> usize {
        ((cell[2] * self.counts[1] + cell[1]) * self.counts[0] + cell[0]) as usize
    }

    fn fill_table(&mut self, places: &[Place], points: &[u32], total: usize) -> Result<()> {
        let mut first = memory::filled(0_u32, total + 1, PURPOSE)?;
        for &point in points {
            first[self.number(self.cell(&places[point as usize])) + 1] += 1;
        }
        for number in 0..total {
            first[number + 1] += first[number];
        }
        self.members = memory::filled(Member { place: [0.0; 3], point: 0 }, points.len(), PURPOSE)?;
        for &point in points {
            let place = &places[point as usize];
            let number = self.number(self.cell(place));
            self.members[first[number] as usize] = Member::new(place, point);
            first[number] += 1;
        }
        // Each entry has moved on to where its cell ends, which is where the next one begins.
        first.rotate_right(1);
        first[0] = 0;
        self.lookup = Lookup::Table(first);
        Ok(())
    }

    fn fill_occupied(&mut self, places: &[Place], points: &[u32]) -> Result<()> {
        let keyed = points.iter().map(|&point| (key(self.cell(&places[point as usize])), point));
        let mut keyed = memory::collected(keyed, PURPOSE)?;
        keyed.sort_unstable();
        let (mut occupied, mut first) = (Vec::new(), Vec::new());
        for (place, &(key, point)) in keyed.iter().enumerate() {
            if occupied.last() != Some(&key) {
                memory::push(&mut occupied, key, PURPOSE)?;
                memory::push(&mut first, place as u32, PURPOSE)?;
            }
            self.members.push(Member::new(&places[point as usize], point));
        }
        memory::push(&mut first, points.len() as u32, PURPOSE)?;
        self.lookup = Lookup::Occupied(occupied, first);
        Ok(())
    }

    /// Calls `met` with every member in the cells that a ball touches, and its place.
    #[inline(always)]
    fn visit(&self, place: &Place, radius: f64, mut met: impl FnMut(u32, &[f64; 3])) {
        // A hair more than the radius, so that rounding never hides a neighbour behind a cell.
        let reach = radius * (1.0 + 1e-9);
        let near = |axis: usize| {
            let from = place[axis] - self.lower[axis];
            let first = ((from - reach) / self.edge).floor() as i64;
            let last = ((from + reach) / self.edge).floor() as i64;
            first.max(0)..last.saturating_add(1).min(self.counts[axis])
        };
        let (along_x, along_y, along_z) = (near(0), near(1), near(2));
        if along_x.is_empty() || along_y.is_empty() || along_z.is_empty() {
            return;
        }
        let rows = (along_y.end - along_y.start).saturating_mul(along_z.end - along_z.start);
        if rows > self.members.len() as i64 {
            return self.members.iter().for_each(|member| met(member.point, &member.place));
        }
        for z in along_z {
            for y in along_y.clone() {
                for member in &self.members[self.run(along_x.clone(), y, z)] {
                    met(member.point, &member.place);
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

impl Member {
    fn new(place: &Place, point: u32) -> Self {
        Self { place: [place[0], place[1], place[2]], point }
    }
}

/// A cell's number along each axis in one word, x fastest.
fn key(cell: [i64; 3]) -> u64 {
    (((cell[2] as u64) << AXIS_BITS | cell[1] as u64) << AXIS_BITS) + cell[0] as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(count: usize, spread: f64) -> Vec<Place> {
        let spot = |k: f64, step: f64| ((k * step).fract() - 0.5) * spread;
        (0..count)
            .map(|k| k as f64)
            .map(|k| [spot(k, 0.7548776662), spot(k, 0.5698402909), spot(k, 0.4301597090), 1.0])
            .collect()
    }

    fn sorted(families: &Families, point: usize) -> Vec<usize> {
        let mut neighbors: Vec<_> = families.bonds(point).map(|bond| bond.neighbor).collect();
        neighbors.sort_unstable();
        neighbors
    }

    fn check_against_all_pairs(places: &[Place], horizons: &Property) {
        let families = find(&Workers::new(2).unwrap(), 3, places, horizons, None, 1.0).unwrap();
        for i in 0..places.len() {
            let expected: Vec<_> = (0..places.len())
                .filter(|&j| {
                    let reach = families.reach.radii.at(i).max(families.reach.radii.at(j));
                    i != j && squared_length(&places[i], &places[j]).sqrt() <= reach
                })
                .collect();
            assert_eq!(sorted(&families, i), expected, "point {i}");
        }
    }

    #[test]
    fn every_pair_within_the_horizon_is_found_and_no_other() {
        check_against_all_pairs(&cloud(700, 1.0), &Property::Uniform(0.21));
        check_against_all_pairs(&cloud(100, 1.0), &Property::Uniform(5.0));
    }

    #[test]
    fn a_sparse_body_is_searched_without_a_table() {
        let mut places = cloud(300, 1.0);
        places[299] = [1e6, -1e6, 3e5, 1.0];
        places[298] = [1e6, -1e6, 3e5 + 0.1, 1.0];
        check_against_all_pairs(&places, &Property::Uniform(0.3));
    }

    #[test]
    fn unequal_horizons_give_each_bond_to_both_ends() {
        let horizons = (0..400).map(|k| 0.1 + 0.03 * (k % 7) as f64).collect();
        check_against_all_pairs(&cloud(400, 1.0), &Property::PerPoint(horizons));
        let few_large = (0..400).map(|k| if k % 57 == 3 { 1.3 } else { 0.02 }).collect();
        check_against_all_pairs(&cloud(400, 1.0), &Property::PerPoint(few_large));
        let many_sizes = (0..400).map(|k| 1e-3 * 1.03_f64.powi(k)).collect();
        check_against_all_pairs(&cloud(400, 1.0), &Property::PerPoint(many_sizes));
    }

    #[test]
    fn a_horizon_of_whole_spacings_reaches_its_shell() {
        let row: Vec<Place> = (0..10).map(|k| [0.1 * k as f64, 0.0, 0.0, 1.0]).collect();
        let families =
            find(&Workers::new(1).unwrap(), 3, &row, &Property::Uniform(0.3), None, 0.9).unwrap();
        assert_eq!(families.bonds(5).count(), 6);
    }
}
