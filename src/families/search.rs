//! Neighbour search: who lies within whose horizon.
//!
//! Points whose horizons differ by more than a factor of two have cell lists of their own, so that a few
//! large horizons do not make all points look far. Bonds are found twice: once to count them, and once to write
//! them where they belong.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use super::cells::{Bounds, Candidates, Cells, Hits};
use super::grid::Crossings;
use super::lattice::{Lattice, LatticeUse, MOST_LANES, NOBODY};
use super::{
    Families, LANES, Place, Property, Reach, Rim, Storage, Unit, inverse_length, squared_length,
};
use crate::error::{Result, argument};
use crate::kernel::simd::SimdLevel;
use crate::memory;
use crate::workers::{BLOCK, PerPoint, Ragged, Workers};

const PURPOSE: &str = "bonds";

/// A body whose families are looked for.
pub(crate) struct Wanted<'a> {
    pub(crate) workers: &'a Workers,
    pub(crate) simd: SimdLevel,
    pub(crate) dimension: usize,
    pub(crate) places: Vec<Place>,
    pub(crate) horizons: &'a Property,
    pub(crate) rim: Option<Rim>,
    /// Largest magnitude of the coordinates that the host gave.
    pub(crate) farthest: f64,
    pub(crate) storage: Storage,
    /// What is made of points on a common grid.
    pub(crate) lattice: LatticeUse,
    /// Kinds of the points, where those of a lattice are to be told apart.
    pub(crate) kinds: Option<&'a [u16]>,
    /// Names of the points to the host.
    pub(crate) host: &'a [u32],
}

/// The families of all points for their horizons, and with the rim if they have one.
pub(crate) fn find(wanted: Wanted<'_>) -> Result<Families> {
    let Wanted { workers, simd, dimension, places, horizons, rim, farthest, .. } = wanted;
    let Wanted { storage, lattice: lattice_use, kinds, host, .. } = wanted;
    let farthest_of = radii(horizons, rim.as_ref(), farthest)?;
    let reach = Reach { radii: radii(horizons, None, farthest)?, rim };
    let unit = Unit::near(farthest_of.largest());
    let count = places.len();
    let new = || Search::new(workers, simd, dimension, &places, &farthest_of, &reach);
    let (mut search, mut lattice) = (None, None);
    if let (true, None, Property::Uniform(radius)) =
        (lattice_use != LatticeUse::None, &reach.rim, &reach.radii)
        && let Some(crossings) = Crossings::find(workers, &places, *radius, farthest)?
    {
        let mut whole = memory::collected(crossings.of.iter().map(Option::is_some), PURPOSE)?;
        if whole.contains(&false) {
            let search = search.insert(new()?);
            search.left_out = memory::copied(&whole, PURPOSE)?;
            search.clear_neighbors(workers, &mut whole)?;
        }
        let pairs = lattice_use == LatticeUse::Pairs;
        lattice = Lattice::of(workers, &crossings, &mut whole, kinds, *radius, pairs)?
            .filter(|lattice| lattice.row() <= MOST_LANES);
        if lattice.as_ref().is_some_and(|lattice| lattice.count < count) {
            let all = search.take().map_or_else(new, Ok)?;
            search = Some(Search { left_out: whole, ..all });
        }
    }
    let members = lattice.as_ref().map_or(0, |lattice| lattice.count);
    let mut sizes = workers.filled(0_u32, count, PURPOSE)?;
    let search = if members < count {
        let mut search = search.map_or_else(new, Ok)?;
        if lattice.is_none() {
            search.left_out = Vec::new();
        }
        workers.sweep(count, PerPoint(&mut sizes, 1), |range, sizes| search.count(range, sizes.0));
        Some(search)
    } else {
        None
    };
    let listed = |point: usize| u64::from(sizes[point].div_ceil(LANES as u32));
    let steps = |lattice: &Lattice| (lattice.row() / LANES) as u64;
    let list_offsets = match lattice {
        Some(_) => offsets_of(count, listed)?,
        None => Vec::new(),
    };
    let offsets = offsets_of(count, |point| match &lattice {
        Some(lattice) if lattice.seat_of[point] != NOBODY => steps(lattice),
        _ => listed(point),
    })?;
    let lists = if list_offsets.is_empty() { &offsets } else { &list_offsets };
    let lanes = usize::try_from(lists[count]).ok().and_then(|blocks| blocks.checked_mul(LANES));
    let lanes = lanes.unwrap_or(usize::MAX);
    let mut neighbors = workers.filled(0_u32, lanes, PURPOSE)?;
    let mut inverse_lengths = match storage {
        Storage::Fast => Some(workers.filled(0.0_f64, lanes, PURPOSE)?),
        Storage::Lean => None,
    };
    // The first block of points with a squared distance of 0, and the least of these; bits are ordered as the numbers.
    let touching = AtomicUsize::new(usize::MAX);
    let least = AtomicU64::new(f64::INFINITY.to_bits());
    if let Some(search) = search {
        let inverses = inverse_lengths.as_mut().map(|values| lists_of(&mut values[..], lists));
        let outputs = (lists_of(&mut neighbors[..], lists), inverses);
        workers.sweep(count, outputs, |range, (neighbors, inverses)| {
            let (start, neighbors) = (range.start, neighbors.values);
            let inverses = inverses.map(|inverses| inverses.values);
            let nearest = search.fill(range, lists, neighbors, inverses);
            if nearest == 0.0 {
                touching.fetch_min(start, Ordering::Relaxed);
            }
            least.fetch_min(nearest.to_bits(), Ordering::Relaxed);
        });
    }
    if count > 1 && offsets[count] == 0 {
        return argument(no_neighbors(&places, horizons));
    }
    // Where all points are members, no list is ever looked up.
    let list_offsets = if members < count { list_offsets } else { Vec::new() };
    let families = Families {
        offsets,
        list_offsets,
        neighbors,
        inverse_lengths,
        shortest: inverse_length(f64::from_bits(least.into_inner())).recip(),
        places,
        unit,
        reach,
        lattice,
    };
    refuse_bonds_without_length(&families, touching.into_inner(), host)?;
    Ok(families)
}

/// First block of each point, and the end, from the blocks that each has.
fn offsets_of(count: usize, blocks: impl Fn(usize) -> u64) -> Result<Vec<u64>> {
    let mut offsets = memory::reserved(count + 1, PURPOSE)?;
    let mut end = 0;
    offsets.push(end);
    for point in 0..count {
        end += blocks(point);
        offsets.push(end);
    }
    Ok(offsets)
}

/// Values of the lanes of lists.
fn lists_of<'a, T>(values: &'a mut [T], offsets: &'a [u64]) -> Ragged<'a, T> {
    Ragged { values, offsets, width: LANES }
}

/// Points can be so close that the square of their distance is no longer a number above zero: some from `first` on.
fn refuse_bonds_without_length(families: &Families, first: usize, host: &[u32]) -> Result<()> {
    for point in first..host.len() {
        if let Some(bond) = families.bonds(point).find(|bond| bond.length == 0.0) {
            return argument(format!(
                "points {} and {} are too close to tell their distance; use other units",
                host[point], host[bond.neighbor]
            ));
        }
    }
    Ok(())
}

/// Horizons with the tolerance that lets `horizon = k * spacing` reach the k-th shell, and with the most that
/// a rim adds.
fn radii(horizons: &Property, rim: Option<&Rim>, farthest: f64) -> Result<Property> {
    let largest = rim.map_or(0.0, |rim| rim.edges.largest());
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
    simd: SimdLevel,
    places: &'a [Place],
    /// Beyond these a point has nobody in its own family.
    radii: &'a Property,
    reach: &'a Reach,
    classes: Vec<Cells>,
    /// Points that do not look for neighbours; empty where all do.
    left_out: Vec<bool>,
}

/// Classes of radii, each up to twice those of the one before; the last holds all larger ones.
const MOST_CLASSES: usize = 32;

/// Points that look for their neighbours together, at most.
const MOST_TOGETHER: usize = 16;

/// Edge of the box around them in radii, at most.
const CLOSE: f64 = 1.4;

impl<'a> Search<'a> {
    fn new(
        workers: &Workers,
        simd: SimdLevel,
        dimension: usize,
        places: &'a [Place],
        radii: &'a Property,
        reach: &'a Reach,
    ) -> Result<Self> {
        let mut classes = memory::reserved(MOST_CLASSES, PURPOSE)?;
        match radii {
            Property::Uniform(radius) => {
                classes.push(Cells::new(workers, dimension, places, None, *radius)?);
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
                        let points = Some(&points[..]);
                        classes.push(Cells::new(workers, dimension, places, points, largest)?);
                    }
                }
            }
        }
        Ok(Self { simd, places, radii, reach, classes, left_out: Vec::new() })
    }

    /// Number of neighbours of each point of a range: of those in the family of either.
    fn count(&self, range: Range<usize>, sizes: &mut [u32]) {
        let uniform = self.reach.is_sharp_and_uniform();
        let start = range.start;
        let mut hits = Hits::new();
        self.visit(range, |point, place, candidates, most| {
            let size = &mut sizes[point - start];
            if uniform {
                *size += candidates.count_within(self.simd, place, most);
                return;
            }
            candidates.find_within(self.simd, place, most, &mut hits);
            self.keep_bonds(point, &mut hits);
            *size += hits.points().len() as u32;
        });
        if uniform {
            // Each has met itself.
            sizes.iter_mut().for_each(|size| *size = size.saturating_sub(1));
        }
    }

    /// Writes the neighbours of each point of a range and, where there is room, 1 over how far they are, and fills last
    /// blocks up. Gives the square of the least distance.
    fn fill(
        &self,
        range: Range<usize>,
        offsets: &[u64],
        neighbors: &mut [u32],
        mut inverse_lengths: Option<&mut [f64]>,
    ) -> f64 {
        let (start, mut hits) = (range.start, Hits::new());
        let lanes_before = |point: usize| (offsets[point] - offsets[start]) as usize * LANES;
        let mut ends = [0; BLOCK];
        for (end, point) in ends.iter_mut().zip(range.clone()) {
            *end = lanes_before(point);
        }
        let mut least = f64::INFINITY;
        self.visit(range.clone(), |point, place, candidates, most| {
            candidates.find_within(self.simd, place, most, &mut hits);
            self.keep_bonds(point, &mut hits);
            least = least.min(hits.least_square(self.simd));
            let end = &mut ends[point - start];
            let lanes = *end..*end + hits.points().len();
            *end = lanes.end;
            neighbors[lanes.clone()].copy_from_slice(hits.points());
            if let Some(inverse_lengths) = &mut inverse_lengths {
                inverse_lengths[lanes].copy_from_slice(hits.inverse_lengths(self.simd));
            }
        });
        for (end, point) in ends.into_iter().zip(range) {
            let empty = end..lanes_before(point + 1);
            neighbors[empty.clone()].fill(point as u32);
            if let Some(inverse_lengths) = &mut inverse_lengths {
                inverse_lengths[empty].fill(1.0);
            }
        }
        least
    }

    /// Of points near another those that it has bonds with.
    fn keep_bonds(&self, point: usize, hits: &mut Hits) {
        if self.reach.is_sharp_and_uniform() {
            hits.forget(point as u32);
        } else {
            hits.retain(|other, squared| self.are_bonded(point, other as usize, squared));
        }
    }

    /// Clears the flags of all neighbours of points that are not left out.
    fn clear_neighbors(&self, workers: &Workers, flags: &mut [bool]) -> Result<()> {
        let none = (0..flags.len()).map(|_| AtomicBool::new(false));
        let met = memory::collected(none, PURPOSE)?;
        workers.sweep(flags.len(), (), |range, ()| {
            let mut hits = Hits::new();
            self.visit(range, |_, place, candidates, most| {
                candidates.find_within(self.simd, place, most, &mut hits);
                for &other in hits.points() {
                    met[other as usize].store(true, Ordering::Relaxed);
                }
            });
        });
        for (flag, met) in flags.iter_mut().zip(met) {
            *flag &= !met.into_inner();
        }
        Ok(())
    }

    /// Whether one is in the family of the other.
    fn are_bonded(&self, point: usize, other: usize, squared: f64) -> bool {
        let length = squared.sqrt();
        let belongs = |from: usize, to: usize| self.reach.share(from, to, length) > 0.0;
        point != other
            && length <= self.radii.at(point).max(self.radii.at(other))
            && (belongs(point, other) || belongs(other, point))
    }

    /// Calls `met` with each point of a range and its place, with candidates of each class, and with the square of the
    /// distance up to which these count.
    #[inline(always)]
    fn visit(&self, range: Range<usize>, mut met: impl FnMut(usize, &Place, &Candidates, f64)) {
        let mut room = Candidates::new();
        let mut rest = range;
        let looks = |point: usize| self.left_out.get(point).is_none_or(|left_out| !left_out);
        while !rest.is_empty() {
            if !looks(rest.start) {
                rest.start += 1;
                continue;
            }
            let (group, bounds, radius) = self.group(&rest);
            rest.start = group.end;
            for cells in &self.classes {
                let radius = radius.max(cells.radius);
                let most = largest_square(radius);
                cells.visit(&bounds, radius, &mut room, |candidates| {
                    for point in group.clone().filter(|&point| looks(point)) {
                        met(point, &self.places[point], candidates, most);
                    }
                });
            }
        }
    }

    /// The first points of a range that look for their neighbours together: they stand close to each other and have much
    /// the same radius. Gives them, the box around them and the largest radius.
    fn group(&self, range: &Range<usize>) -> (Range<usize>, Bounds, f64) {
        let first = range.start;
        let mut radius = self.radii.at(first);
        let mut bounds = Bounds::EMPTY.with(&self.places[first]);
        let mut end = first + 1;
        while end < range.end.min(first + MOST_TOGETHER) {
            let (wider, own) = (bounds.with(&self.places[end]), self.radii.at(end));
            if wider.longest_edge() > CLOSE * radius || own > 2.0 * radius || 2.0 * own < radius {
                break;
            }
            (bounds, radius) = (wider, own.max(radius));
            end += 1;
        }
        (first..end, bounds, radius)
    }
}

/// The largest number whose square root is not above the radius: whether squares are below it tells the same as
/// whether their roots are below the radius.
pub(super) fn largest_square(radius: f64) -> f64 {
    let mut square = (radius * radius).min(f64::MAX);
    while square.sqrt() > radius {
        square = square.next_down();
    }
    while square < f64::MAX && square.next_up().sqrt() <= radius {
        square = square.next_up();
    }
    square
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

    fn found(threads: usize, places: &[Place], horizons: &Property) -> Families {
        found_by(SimdLevel::Baseline, threads, places, horizons)
    }

    fn found_by(
        simd: SimdLevel,
        threads: usize,
        places: &[Place],
        horizons: &Property,
    ) -> Families {
        let host: Vec<u32> = (0..places.len() as u32).collect();
        let coordinates = places.iter().flat_map(|place| &place[..3]);
        find(Wanted {
            workers: &Workers::new(threads).unwrap(),
            simd,
            dimension: 3,
            places: places.to_vec(),
            horizons,
            rim: None,
            farthest: coordinates.fold(0.0, |farthest, x| x.abs().max(farthest)),
            storage: Storage::Fast,
            lattice: LatticeUse::None,
            kinds: None,
            host: &host,
        })
        .unwrap()
    }

    fn sorted(families: &Families, point: usize) -> Vec<usize> {
        let mut neighbors: Vec<_> = families.bonds(point).map(|bond| bond.neighbor).collect();
        neighbors.sort_unstable();
        neighbors
    }

    fn check_against_all_pairs(places: &[Place], horizons: &Property) {
        let families = found(2, places, horizons);
        for i in 0..places.len() {
            let expected: Vec<_> = (0..places.len())
                .filter(|&j| {
                    let reach = families.reach.radii.at(i).max(families.reach.radii.at(j));
                    i != j && squared_length(&places[i], &places[j]).sqrt() <= reach
                })
                .collect();
            assert_eq!(sorted(&families, i), expected, "point {i}");
            assert_eq!(families.bond_count(i), expected.len(), "point {i}");
            assert_eq!(families.is_alone(i), expected.is_empty(), "point {i}");
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
    fn squares_up_to_the_largest_have_roots_up_to_the_radius() {
        let usual = (1..200).map(|k| 0.37 * f64::from(k));
        for radius in usual.chain([1e-200, 1e-160, 3.7e-155, 1e153, 1e154, 1e200]) {
            let most = largest_square(radius);
            assert!(most.sqrt() <= radius, "{radius}");
            assert!(most == f64::MAX || most.next_up().sqrt() > radius, "{radius}");
        }
    }

    #[test]
    fn the_bits_of_families_do_not_depend_on_threads() {
        let places = cloud(3000, 1.0);
        let of = |threads: usize| found(threads, &places, &Property::Uniform(0.13));
        let one = of(1);
        for threads in [2, 4] {
            let more = of(threads);
            assert_eq!(
                (&one.neighbors, &one.inverse_lengths),
                (&more.neighbors, &more.inverse_lengths)
            );
        }
    }

    #[test]
    fn the_bits_of_families_do_not_depend_on_the_level() {
        let places = cloud(3000, 1.0);
        let of = |simd| found_by(simd, 1, &places, &Property::Uniform(0.13));
        let lowest = of(SimdLevel::Baseline);
        for level in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
            let other = of(level);
            assert_eq!(lowest.neighbors, other.neighbors);
            assert_eq!(lowest.inverse_lengths, other.inverse_lengths);
            assert_eq!(lowest.shortest, other.shortest);
        }
        let lengths = (0..3000).flat_map(|point| lowest.bonds(point)).map(|bond| bond.length);
        assert_eq!(lowest.shortest, lengths.fold(f64::INFINITY, f64::min));
    }

    #[test]
    fn bodies_of_any_size_are_searched() {
        // Squares of the shortest lengths have lost digits.
        for spread in [1e-160, 1e-144, 1e-100, 1e100, 1e150] {
            check_against_all_pairs(&cloud(300, spread), &Property::Uniform(0.21 * spread));
        }
    }

    #[test]
    fn a_horizon_of_whole_spacings_reaches_its_shell() {
        let row: Vec<Place> = (0..10).map(|k| [0.1 * k as f64, 0.0, 0.0, 1.0]).collect();
        let families = found(1, &row, &Property::Uniform(0.3));
        assert_eq!(families.bonds(5).count(), 6);
    }
}
