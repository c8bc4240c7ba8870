//! The inner order of the points: brick after brick, so that neighbours in space are neighbours in
//! memory. It follows from the positions alone: the host's order, threads and ranks play no part.

use crate::error::Result;
use crate::memory;

/// Points a brick holds on average, were they spread evenly.
const POINTS_PER_BRICK: f64 = 64.0;

/// Bricks per axis, a bound that lets three brick numbers share one word.
const MOST_BRICKS: f64 = 2_097_151.0;

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
        let centred = |point: usize| {
            let mut place = [0.0; 3];
            for axis in 0..dimension {
                // Adding zero makes one of the two zeros, which the sort would tell apart.
                place[axis] = coordinates[point * dimension + axis] - centre[axis] + 0.0;
            }
            place
        };
        let brick = |place: &[f64; 3]| {
            (0..3).rev().fold(0_u64, |key, axis| {
                let number = ((place[axis] + 0.5 * extent[axis]) / edge).floor();
                key << 21 | number.clamp(0.0, MOST_BRICKS) as u64
            })
        };
        let mut keyed = memory::collected(
            (0..count).map(|point| (brick(&centred(point)), point as u32)),
            "the order of the points",
        )?;
        keyed.sort_unstable_by(|first, second| {
            let (a, b) = (centred(first.1 as usize), centred(second.1 as usize));
            let along = |axis: usize| a[axis].total_cmp(&b[axis]);
            (first.0.cmp(&second.0))
                .then_with(|| along(2).then_with(|| along(1)).then_with(|| along(0)))
        });
        for pair in keyed.windows(2) {
            let (first, second) = (pair[0].1 as usize, pair[1].1 as usize);
            if centred(first) == centred(second) {
                return Ok(Err(Coincident(first.min(second), first.max(second))));
            }
        }
        let host = memory::collected(keyed.iter().map(|entry| entry.1), "the order of the points")?;
        let place = if host.iter().enumerate().all(|(place, &point)| place == point as usize) {
            None
        } else {
            let mut places = memory::filled(0, count, "the order of the points")?;
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
            Some(places) => Some(memory::copied(places, "the order of the points")?),
            None => None,
        };
        Ok(Self {
            centre: self.centre,
            farthest: self.farthest,
            host: memory::copied(&self.host, "the order of the points")?,
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
