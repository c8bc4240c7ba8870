//! Pre-cracks: which bonds cross a planar polygon (3D) or a segment (2D).

use super::{Families, Place};
use crate::error::{Result, argument};
use crate::memory;

/// Products of four lengths below this stay finite.
const LARGEST_COORDINATE: f64 = 1e75;

/// A crack surface: a polygon in a plane of 3D space, or a segment in 2D.
#[derive(Debug)]
pub(crate) struct Crack {
    origin: [f64; 3],
    normal: [f64; 3],
    /// Two directions in the crack's plane; in 2D the first runs along the segment.
    along: [[f64; 3]; 2],
    /// The rim in these directions, closed: each vertex and the next.
    rim: Vec<[f64; 2]>,
}

impl Crack {
    /// From vertices in the host's coordinates, `dimension` numbers each.
    pub(crate) fn new(dimension: usize, vertices: &[f64]) -> Result<Self> {
        let count = vertices.len() / dimension;
        if dimension == 2 && count != 2 {
            return argument(format!("'vertex_count' is {count}; a crack in 2D is a segment of 2"));
        }
        if dimension == 3 && count < 3 {
            return argument(format!("'vertex_count' is {count}; a polygon has at least 3"));
        }
        for (number, &x) in vertices.iter().enumerate() {
            if !x.is_finite() || x.abs() > LARGEST_COORDINATE {
                return argument(format!(
                    "'vertices': vertex {}, axis {}, is {x}; it must be finite and at most \
                     {LARGEST_COORDINATE:e}",
                    number / dimension,
                    number % dimension
                ));
            }
        }
        let vertex = |number: usize| {
            let mut place = [0.0; 3];
            let start = (number % count) * dimension;
            place[..dimension].copy_from_slice(&vertices[start..start + dimension]);
            place
        };
        let origin = vertex(0);
        let size = (1..count).map(|k| length(&subtract(&vertex(k), &origin))).fold(0.0, f64::max);
        let direction = if dimension == 2 {
            let segment = subtract(&vertex(1), &origin);
            [-segment[1], segment[0], 0.0]
        } else {
            (0..count).fold([0.0; 3], |sum, k| {
                let from = subtract(&vertex(k), &origin);
                add(&sum, &cross(&from, &subtract(&vertex(k + 1), &origin)))
            })
        };
        let measure = length(&direction);
        if measure <= 1e-12 * size.powi(dimension as i32 - 1) {
            return argument(
                "'vertices': the crack has no extent; its vertices fall together or on a line",
            );
        }
        let normal = scale(&direction, 1.0 / measure);
        let across = if dimension == 2 { [0.0, 0.0, 1.0] } else { farthest_axis(&normal) };
        let first = unit(&cross(&across, &normal));
        let along = [first, cross(&normal, &first)];
        let mut rim = memory::reserved(count + 1, "a crack")?;
        for number in 0..=count {
            let from = subtract(&vertex(number), &origin);
            let height = dot(&from, &normal);
            if height.abs() > 1e-6 * size {
                return argument(format!(
                    "'vertices': vertex {number} lies {height} off the plane of the others; a crack \
                     polygon must be planar"
                ));
            }
            rim.push([dot(&from, &along[0]), dot(&from, &along[1])]);
        }
        Ok(Self { origin, normal, along, rim })
    }

    /// Calls `cut` with point, neighbour and slot of every bond that crosses the crack, from both ends.
    /// Points closer to its plane than the tolerance belong to its positive side, and crossings as
    /// close to the rim are on the crack.
    pub(crate) fn for_each_crossing(
        &self,
        families: &Families,
        places: &[Place],
        centre: &[f64; 3],
        tolerance: f64,
        mut cut: impl FnMut(usize, usize, usize),
    ) {
        let origin = subtract(&self.origin, centre);
        let from_origin =
            |place: &Place| [place[0] - origin[0], place[1] - origin[1], place[2] - origin[2]];
        for (point, place) in places.iter().enumerate() {
            let own = from_origin(place);
            let height = dot(&own, &self.normal);
            let side = height >= -tolerance;
            for bond in families.bonds(point) {
                if height.abs() > bond.length + tolerance {
                    continue;
                }
                let other = from_origin(&places[bond.neighbor]);
                let other_height = dot(&other, &self.normal);
                if (other_height >= -tolerance) == side {
                    continue;
                }
                let share = (height / (height - other_height)).clamp(0.0, 1.0);
                let crossing = add(&own, &scale(&subtract(&other, &own), share));
                let flat = [dot(&crossing, &self.along[0]), dot(&crossing, &self.along[1])];
                if self.holds(&flat, tolerance) {
                    cut(point, bond.neighbor, bond.slot);
                }
            }
        }
    }

    /// Whether a spot of the crack's plane lies within its rim or on it.
    fn holds(&self, spot: &[f64; 2], tolerance: f64) -> bool {
        let mut inside = false;
        for edge in self.rim.windows(2) {
            let [from, to] = [edge[0], edge[1]];
            if distance_to_segment(spot, &from, &to) <= tolerance {
                return true;
            }
            if (from[1] > spot[1]) != (to[1] > spot[1]) {
                let share = (spot[1] - from[1]) / (to[1] - from[1]);
                inside ^= spot[0] < from[0] + share * (to[0] - from[0]);
            }
        }
        inside
    }
}

fn distance_to_segment(spot: &[f64; 2], from: &[f64; 2], to: &[f64; 2]) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let away = [spot[0] - from[0], spot[1] - from[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 {
        ((away[0] * along[0] + away[1] * along[1]) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (away[0] - share * along[0]).hypot(away[1] - share * along[1])
}

/// The axis that a unit normal is farthest from.
fn farthest_axis(normal: &[f64; 3]) -> [f64; 3] {
    let mut axis = 0;
    for other in 1..3 {
        if normal[other].abs() < normal[axis].abs() {
            axis = other;
        }
    }
    let mut direction = [0.0; 3];
    direction[axis] = 1.0;
    direction
}

fn subtract(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn add(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn scale(a: &[f64; 3], factor: f64) -> [f64; 3] {
    a.map(|x| x * factor)
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: &[f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: &[f64; 3]) -> [f64; 3] {
    scale(a, 1.0 / length(a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_notched_polygon_holds_its_inside_and_its_rim() {
        // An L in the plane z = 2, given in either sense.
        let mut outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        for _ in 0..2 {
            let vertices: Vec<f64> = outline.iter().flat_map(|v| [v[0], v[1], 2.0]).collect();
            let crack = Crack::new(3, &vertices).unwrap();
            let flat = |x: f64, y: f64| {
                let from = subtract(&[x, y, 2.0], &crack.origin);
                [dot(&from, &crack.along[0]), dot(&from, &crack.along[1])]
            };
            for (x, y, held) in [
                (0.5, 0.5, true),
                (1.5, 1.5, false),
                (1.5, 0.5, true),
                (1.0, 1.5, true),
                (2.0, 1.0, true),
                (-0.1, 1.0, false),
            ] {
                assert_eq!(crack.holds(&flat(x, y), 1e-12), held, "{x} {y}");
            }
            outline.reverse();
        }
    }

    #[test]
    fn cracks_without_extent_or_plane_are_refused() {
        let line = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
        assert!(Crack::new(3, &line).is_err());
        let warped = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.5];
        assert!(Crack::new(3, &warped).is_err());
        assert!(Crack::new(2, &[1.0, 1.0, 1.0, 1.0]).is_err());
        assert!(Crack::new(2, &[1.0, 1.0, f64::NAN, 1.0]).is_err());
    }
}
