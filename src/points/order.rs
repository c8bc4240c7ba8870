//! The inner order of the points: brick after brick, to and fro, so that neighbours in space are neighbours in
//! memory and no run of points has both ends of a row in it. Along the longest axis runs are short, since waves mostly
//! travel there. It follows from the positions alone: the host's order, threads and ranks play no part.

use crate::error::Result;
use crate::memory;
use crate::sort::ByKey;

/// Points a brick holds on average, were they spread evenly.
const POINTS_PER_BRICK: f64 = 64.0;

/// Bricks per axis at most, in bodies of next to no width.
const MOST_BRICKS: f64 = 2_097_151.0;

const PURPOSE: &str = "the order of the points";

/// The inner order, both ways, and the body's centre.
#[derive(Debug)]
pub(crate) struct Order {
    /// Middle of the bounding box: inner coordinates are relative to it.
    pub(crate) centre: [f64; 3],
    /// Largest magnitude of the host's coordinates: their own rounding is relative to it.
    pub(crate) farthest: f64,
    /// Host index of the point at each inner place.
    pub(crate) host: Vec<u32>,
    /// Inner place of each host index; `None` when the orders are the same.
    pub(crate) place: Option<Vec<u32>>,
}

/// Host indices of two points in one place, the lower first.
#[derive(Debug)]
pub(super) struct Coincident(pub(super) usize, pub(super) usize);

impl Order {
    /// The order of points, each in a place of its own.
    pub(super) fn new(
        dimension: usize,
        coordinates: &[f64],
    ) -> Result<std::result::Result<Self, Coincident>> {
        let count = coordinates.len() / dimension;
        let (centre, extent) = bounding_box(dimension, coordinates);
        let edge = brick_edge(&extent, count);
        let axes = slowest_first(&extent);
        let centred = |point: usize| {
            let mut place = [0.0; 3];
            for axis in 0..dimension {
                // Adding zero makes one of the two zeros, which the sort would tell apart.
                place[axis] = coordinates[point * dimension + axis] - centre[axis] + 0.0;
            }
            place
        };
        // One more than there are, should rounding carry the last point over an edge.
        let bricks = extent.map(|length| (length / edge).min(MOST_BRICKS) as usize + 2);
        let brick = |place: &[f64; 3]| {
            axes.into_iter().fold(0, |number, axis| {
                let along = ((place[axis] + 0.5 * extent[axis]) / edge) as usize;
                let along = along.min(bricks[axis] - 1);
                // Every other row and plane goes back.
                let turned = if number % 2 == 0 { along } else { bricks[axis] - 1 - along };
                number * bricks[axis] + turned
            })
        };
        let numbers = (0..count).map(|point| brick(&centred(point)) as u32);
        let numbers = memory::collected(numbers, PURPOSE)?;
        let ByKey { indices: mut host, first } =
            ByKey::new(&numbers, bricks.iter().product(), PURPOSE)?;
        let largest = first.windows(2).map(|ends| ends[1] - ends[0]).max().unwrap_or(0);
        let mut members: Vec<([f64; 3], u32)> = memory::reserved(largest as usize, PURPOSE)?;
        for ends in first.windows(2).filter(|ends| ends[0] < ends[1]) {
            let brick = &mut host[ends[0] as usize..ends[1] as usize];
            members.clear();
            members.extend(brick.iter().map(|&point| (centred(point as usize), point)));
            members.sort_unstable_by(|(a, _), (b, _)| {
                let along = |axis: usize| a[axis].total_cmp(&b[axis]);
                along(2).then_with(|| along(1)).then_with(|| along(0))
            });
            if let Some(pair) = members.windows(2).find(|pair| pair[0].0 == pair[1].0) {
                let (first, second) = (pair[0].1 as usize, pair[1].1 as usize);
                return Ok(Err(Coincident(first.min(second), first.max(second))));
            }
            brick.iter_mut().zip(&members).for_each(|(point, member)| *point = member.1);
        }
        let place = if host.iter().enumerate().all(|(place, &point)| place == point as usize) {
            None
        } else {
            let mut places = memory::filled(0, count, PURPOSE)?;
            for (place, &point) in host.iter().enumerate() {
                places[point as usize] = place as u32;
            }
            Some(places)
        };
        let farthest = coordinates.iter().fold(0.0_f64, |farthest, x| farthest.max(x.abs()));
        Ok(Ok(Self { centre, farthest, host, place }))
    }

    /// Inner place of a host index.
    pub(crate) fn place(&self, point: usize) -> usize {
        self.place.as_ref().map_or(point, |places| places[point] as usize)
    }

    pub(super) fn try_clone(&self) -> Result<Self> {
        let place = match &self.place {
            Some(places) => Some(memory::copied(places, PURPOSE)?),
            None => None,
        };
        Ok(Self {
            centre: self.centre,
            farthest: self.farthest,
            host: memory::copied(&self.host, PURPOSE)?,
            place,
        })
    }

    pub(super) fn bytes(&self) -> usize {
        memory::bytes(&self.host) + self.place.as_ref().map_or(0, memory::bytes)
    }
}

/// Middle and edge lengths of the smallest box around all points; unused axes are zero.
fn bounding_box(dimension: usize, coordinates: &[f64]) -> ([f64; 3], [f64; 3]) {
    let (mut lower, mut upper) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for place in coordinates.chunks_exact(dimension) {
        for axis in 0..dimension {
            lower[axis] = lower[axis].min(place[axis]);
            upper[axis] = upper[axis].max(place[axis]);
        }
    }
    let (mut centre, mut extent) = ([0.0; 3], [0.0; 3]);
    for axis in 0..dimension {
        centre[axis] = 0.5 * (lower[axis] + upper[axis]);
        extent[axis] = upper[axis] - lower[axis];
    }
    (centre, extent)
}

/// The axes, the longest first; the others, and those that are as long but for rounding, from the last to the first.
fn slowest_first(extent: &[f64; 3]) -> [usize; 3] {
    let mut axes = [2, 1, 0];
    let mut longest = 0;
    for other in [1, 2] {
        if extent[axes[other]] > (1.0 + 1e-9) * extent[axes[longest]] {
            longest = other;
        }
    }
    axes[..=longest].rotate_right(1);
    axes
}

/// Edge of the bricks; axes along which the body has next to no extent do not count.
fn brick_edge(extent: &[f64; 3], count: usize) -> f64 {
    let longest = extent.iter().copied().fold(0.0, f64::max);
    if longest == 0.0 {
        return 1.0;
    }
    let bricks = (count as f64 / POINTS_PER_BRICK).max(1.0);
    let mut edge = longest / bricks;
    for wide in [2, 3] {
        let mut sorted = *extent;
        sorted.sort_unstable_by(|a, b| b.total_cmp(a));
        let scaled: f64 = sorted[..wide].iter().map(|length| length / longest).product();
        let candidate = longest * (scaled / bricks).powf(1.0 / wide as f64);
        if sorted[wide - 1] > edge && candidate > 0.0 {
            edge = candidate;
        }
    }
    edge.max(longest / MOST_BRICKS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_follows_from_the_positions_alone() {
        let cloud: Vec<[f64; 3]> = (0..500)
            .map(|k| {
                let k = k as f64;
                [(k * 0.7548776662).fract(), (k * 0.5698402909).fract(), (k * 0.4301597090).fract()]
            })
            .collect();
        let straight = Order::new(3, cloud.as_flattened()).unwrap().unwrap();
        let mut turned = cloud.clone();
        turned.reverse();
        let reversed = Order::new(3, turned.as_flattened()).unwrap().unwrap();
        for place in 0..500 {
            let (a, b) = (straight.host[place] as usize, reversed.host[place] as usize);
            assert_eq!(cloud[a], turned[b]);
            assert_eq!(straight.place(a), place);
        }
    }

    #[test]
    fn runs_of_points_stay_together() {
        for upper in [[40, 9, 9], [9, 9, 40], [20, 21, 12], [60, 50, 1]] {
            let [x, y, z] = upper.map(|count| 0..count);
            let planes = z.flat_map(|z| y.clone().map(move |y| (y, z)));
            let cloud = planes.flat_map(|(y, z)| x.clone().map(move |x| [x, y, z].map(f64::from)));
            let cloud: Vec<[f64; 3]> = cloud.collect();
            let order = Order::new(3, cloud.as_flattened()).unwrap().unwrap();
            let edge = brick_edge(&upper.map(|count| f64::from(count - 1)), cloud.len());
            for pair in order.host.windows(2) {
                let [from, to] = [pair[0], pair[1]].map(|point| cloud[point as usize]);
                let apart = (0..3).map(|axis| (to[axis] - from[axis]).abs()).fold(0.0, f64::max);
                // From anywhere in a brick to anywhere in the next, or the next but one where one is empty.
                assert!(apart <= 3.0 * edge, "{from:?} to {to:?}, bricks of {edge}");
            }
        }
    }

    #[test]
    fn points_in_one_place_are_found_wherever_they_stand_in_the_list() {
        let pair = Order::new(2, &[0.0, 1.0, 3.0, 2.0, -0.0, 1.0]).unwrap().unwrap_err();
        assert!(matches!(pair, Coincident(0, 2)), "{pair:?}");
        let row = [1.0, -0.0, 2.0, -0.0, 0.0, 0.0, 1.0, 0.0];
        let pair = Order::new(2, &row).unwrap().unwrap_err();
        assert!(matches!(pair, Coincident(0, 3)), "{pair:?}");
    }

    #[test]
    fn clouds_without_extent_along_some_axes_have_an_order() {
        for cloud in [&[1.0, 2.0, 3.0][..], &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0], &[1e300_f64.sqrt(); 3]]
        {
            let order = Order::new(3, cloud).unwrap().unwrap();
            assert_eq!(order.host.len(), cloud.len() / 3);
        }
    }
}
