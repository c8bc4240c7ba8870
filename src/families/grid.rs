//! Grids: which points of the undamaged body stand on the crossings of a common one, from their places alone.

use super::search::largest_square;
use super::{Place, squared_length};
use crate::error::Result;
use crate::memory;
use crate::workers::{PerBlock, PerPoint, Workers, block_count};

const PURPOSE: &str = "lattices";

/// Volumes and places that differ by no more than this, over themselves and over the spacing, are alike.
const TOLERANCE: f64 = 1e-12;

/// Farther off its crossing no point is on the grid, however its coordinates are rounded: bonds between the lattice and
/// the rest of the body must be judged alike from both ends.
const MOST_OFF: f64 = 1e-8;

/// Points whose surroundings are looked at for a spacing.
const SEEDS: usize = 8;

/// The golden ratio, of which no multiple comes near a whole number.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Points that are asked for a grid that suits the body, and the part of them that must be on it.
const SAMPLE: usize = 4096;
const LEAST_PART: usize = 32;

/// A grid: a crossing, and the distances of planes.
pub(super) struct Grid {
    origin: [f64; 3],
    pub(super) spacing: [f64; 3],
    /// How far points on it may be off their crossings, over the spacing.
    pub(super) tolerance: f64,
}

/// The first and the last plane that points stand on along each axis, and where these stand.
type Ends = [[(i32, f64); 2]; 3];

impl Grid {
    /// The grid that what lies within a radius around a point suggests.
    fn around(places: &[Place], point: usize, radius: f64) -> Option<Self> {
        let (own, most) = (&places[point], largest_square(radius));
        let (mut spacing, mut longest) = ([f64::INFINITY; 3], 0.0_f64);
        for (other, place) in places.iter().enumerate() {
            let squared = squared_length(own, place);
            if squared > most || other == point {
                continue;
            }
            if squared < f64::MIN_POSITIVE {
                return None;
            }
            longest = longest.max(squared);
            for axis in 0..3 {
                let xi = (place[axis] - own[axis]).abs();
                if xi > (1.0 - 1e-9) * squared.sqrt() {
                    spacing[axis] = spacing[axis].min(xi);
                }
            }
        }
        // Across a single layer any distance will do, if none of the family is nearer.
        let longest = longest.sqrt();
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
    fn refined(self, workers: &Workers, places: &[Place], farthest: f64) -> Result<Self> {
        let none: Ends = [[(0, 0.0); 2]; 3];
        let mut parts = memory::filled(none, block_count(places.len()), PURPOSE)?;
        workers.sweep(places.len(), PerBlock(&mut parts[..]), |range, PerBlock(ends)| {
            for place in &places[range] {
                let Some(numbers) = self.crossing(place) else { continue };
                for axis in 0..3 {
                    let here = (numbers[axis], place[axis] - self.origin[axis]);
                    widen(&mut ends[0][axis], [here; 2]);
                }
            }
        });
        let mut ends = none;
        for part in parts {
            for axis in 0..3 {
                widen(&mut ends[axis], part[axis]);
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
        Ok(Self { spacing, tolerance, ..self })
    }
}

fn widen(ends: &mut [(i32, f64); 2], by: [(i32, f64); 2]) {
    if by[0].0 < ends[0].0 {
        ends[0] = by[0];
    }
    if by[1].0 > ends[1].0 {
        ends[1] = by[1];
    }
}

/// The points of a body that stand on a grid and have the volume of most there.
pub(super) struct Crossings {
    pub(super) grid: Grid,
    pub(super) volume: f64,
    /// Crossing of each inner place that is on the grid.
    pub(super) of: Vec<Option<[i32; 3]>>,
}

impl Crossings {
    /// Those of a body whose points pull on each other up to a radius, if it is worth it; `farthest` is the largest
    /// magnitude of coordinates.
    pub(super) fn find(
        workers: &Workers,
        places: &[Place],
        radius: f64,
        farthest: f64,
    ) -> Result<Option<Self>> {
        let count = places.len();
        let on = |grid: &Grid, volume: f64, place: &Place| {
            let alike = (place[3] - volume).abs() <= TOLERANCE * volume;
            if alike { grid.crossing(place) } else { None }
        };
        let sample = || places.iter().step_by(count.div_ceil(SAMPLE));
        let whole = sample().count();
        let mut best: Option<(usize, Grid, f64)> = None;
        // At even distances seeds could all stand in the same part of each row of the inner order.
        let seeds = (1..=SEEDS).map(|k| (count as f64 * (k as f64 * GOLDEN).fract()) as usize);
        for seed in seeds {
            let Some(grid) = Grid::around(places, seed, radius) else { continue };
            let volume = places[seed][3];
            let met = sample().filter(|place| on(&grid, volume, place).is_some()).count();
            if best.as_ref().is_none_or(|best| met > best.0) {
                best = Some((met, grid, volume));
            }
            if met == whole {
                break;
            }
        }
        let Some((met, grid, volume)) = best else { return Ok(None) };
        if met * LEAST_PART < whole {
            return Ok(None);
        }
        let grid = grid.refined(workers, places, farthest)?;
        let mut of = workers.filled(None, count, PURPOSE)?;
        workers.sweep(count, PerPoint(&mut of, 1), |range, of| {
            for (crossing, place) in of.0.iter_mut().zip(&places[range]) {
                *crossing = on(&grid, volume, place);
            }
        });
        Ok(Some(Self { grid, volume, of }))
    }
}
