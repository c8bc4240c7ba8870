//! Pre-cracks: exactly the bonds that cross are broken. Everything stands on whole numbers, so that
//! the test's own geometry is exact.

use std::collections::BTreeSet;

use perion::{Field, Model, Points, Simulation};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use crate::random::cases;
use crate::scene::bonds;

type Spot = [i128; 3];

fn minus(a: Spot, b: Spot) -> Spot {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Spot, b: Spot) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Spot, b: Spot) -> Spot {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A lattice of even whole numbers, and where it lies in space.
struct Lattice {
    dimension: usize,
    spots: Vec<Spot>,
    unit: f64,
    offset: f64,
}

impl Lattice {
    fn new(counts: &[usize], unit: f64, offset: f64) -> Self {
        let count = |axis: usize| counts.get(axis).copied().unwrap_or(1);
        let mut spots = Vec::new();
        for cell in 0..count(0) * count(1) * count(2) {
            let index = [cell % count(0), cell / count(0) % count(1), cell / count(0) / count(1)];
            spots.push(index.map(|number| 2 * number as i128));
        }
        Self { dimension: counts.len(), spots, unit, offset }
    }

    fn place(&self, spot: &Spot) -> Vec<f64> {
        spot[..self.dimension].iter().map(|&x| self.offset + self.unit * x as f64).collect()
    }

    fn simulation(&self, horizon: f64) -> Simulation {
        let coordinates: Vec<f64> = self.spots.iter().flat_map(|spot| self.place(spot)).collect();
        let volumes = vec![1.0; self.spots.len()];
        let points = Points::new(self.dimension, &coordinates, &volumes).unwrap();
        let mut model = Model::new("bond_based").unwrap();
        model.set("density", 1.0).unwrap();
        model.set("youngs_modulus", 1.0).unwrap();
        model.set("horizon", horizon * 2.0 * self.unit).unwrap();
        Simulation::new(&points, &model).unwrap()
    }

    /// Checks that the bonds broken are those that `cut` names.
    fn compare(
        &self,
        simulation: &Simulation,
        cut: impl Fn(Spot, Spot) -> bool,
    ) -> Result<(), TestCaseError> {
        let (mut expected, mut found) = (BTreeSet::new(), BTreeSet::new());
        for ([i, j], _, integrity) in bonds(simulation) {
            let pair = [self.spots[i], self.spots[j]];
            let crosses = cut(pair[0], pair[1]);
            prop_assert_eq!(crosses, cut(pair[1], pair[0]));
            if crosses {
                expected.insert(pair);
            }
            if integrity != 1.0 {
                prop_assert_eq!(integrity, 0.0);
                found.insert(pair);
            }
        }
        let differing: Vec<_> = expected.symmetric_difference(&found).collect();
        prop_assert!(differing.is_empty(), "{} {differing:?}", expected.len());
        let broken = simulation.health().unwrap().broken_bonds;
        prop_assert_eq!(broken, expected.len() as u64);
        // Damage is there from the start, and dissipates nothing.
        let damaged = simulation.get(Field::Damage).unwrap().iter().any(|&damage| damage > 0.0);
        prop_assert_eq!(damaged, broken > 0);
        prop_assert_eq!(simulation.energy().unwrap().dissipated, 0.0);
        Ok(())
    }
}

/// Whether the bond from `p` to `q` crosses the segment from `a` to `b`, whose left is positive.
fn crosses_segment(a: Spot, b: Spot, p: Spot, q: Spot) -> bool {
    let along = minus(b, a);
    let height = |spot: Spot| cross(along, minus(spot, a))[2];
    let (from, to) = (height(p), height(q));
    if (from >= 0) == (to >= 0) {
        return false;
    }
    // The crossing is p + from/(from - to) (q - p).
    let whole = from - to;
    let parts = dot(minus(p, a), along) * whole + from * dot(minus(q, p), along);
    let (parts, whole) = if whole < 0 { (-parts, -whole) } else { (parts, whole) };
    0 <= parts && parts <= whole * dot(along, along)
}

/// A polygon in the plane through `origin` along `s` and `t`, corners in whole steps of both.
#[derive(Debug, Clone)]
struct Polygon {
    origin: Spot,
    along: [Spot; 2],
    corners: Vec<[i128; 2]>,
}

impl Polygon {
    fn corner(&self, number: usize) -> Spot {
        let [s, t] = self.corners[number];
        [0, 1, 2].map(|axis| self.origin[axis] + s * self.along[0][axis] + t * self.along[1][axis])
    }

    /// Twice the area in steps; below 0 when the corners run the other way around.
    fn area(&self) -> i128 {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
    }

    fn crosses(&self, p: Spot, q: Spot) -> bool {
        let [s, t] = self.along;
        let normal = cross(s, t);
        let sense = self.area().signum();
        let height = |spot: Spot| sense * dot(normal, minus(spot, self.origin));
        let (from, to) = (height(p), height(q));
        if (from >= 0) == (to >= 0) {
            return false;
        }
        let whole = from - to;
        let start = minus(p, self.origin);
        let crossing: Spot = [0, 1, 2].map(|k| start[k] * whole + from * (q[k] - p[k]));
        // Steps along s and t, times `whole` and the determinant of the metric.
        let (ss, st, tt) = (dot(s, s), dot(s, t), dot(t, t));
        let (cs, ct) = (dot(crossing, s), dot(crossing, t));
        self.holds([cs * tt - ct * st, ct * ss - cs * st], whole * (ss * tt - st * st))
    }

    /// Whether a spot, in steps times `scale`, lies within or on the rim.
    fn holds(&self, spot: [i128; 2], scale: i128) -> bool {
        let mut inside = false;
        for (number, &a) in self.corners.iter().enumerate() {
            let b = self.corners[(number + 1) % self.corners.len()];
            let (a, b) = (a.map(|x| x * scale), b.map(|x| x * scale));
            let turn = (b[0] - a[0]) * (spot[1] - a[1]) - (b[1] - a[1]) * (spot[0] - a[0]);
            let within = |k: usize| a[k].min(b[k]) <= spot[k] && spot[k] <= a[k].max(b[k]);
            if turn == 0 && within(0) && within(1) {
                return true;
            }
            if (a[1] > spot[1]) != (b[1] > spot[1]) {
                // To the left of an edge that goes up, or to the right of one that goes down.
                inside ^= (turn > 0) == (b[1] > a[1]);
            }
        }
        inside
    }
}

fn polygons() -> impl Strategy<Value = Polygon> {
    let shapes: [&[[i128; 2]]; 6] = [
        &[[0, 0], [4, 0], [0, 4]],
        &[[0, 0], [3, 0], [3, 2], [0, 2]],
        &[[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]],
        &[[0, 0], [6, 0], [6, 4], [4, 4], [4, 2], [2, 2], [2, 4], [0, 4]],
        &[[0, -3], [1, -1], [3, 0], [1, 1], [0, 3], [-1, 1], [-3, 0], [-1, -1]],
        &[[-40, -40], [40, -40], [40, 40], [-40, 40]],
    ];
    let vector = || prop::array::uniform3(-2..3_i128);
    let origin = prop::array::uniform3(-1..12_i128);
    (0..6_usize, origin, vector(), vector(), any::<bool>(), 0..8_usize)
        .prop_filter("the plane's directions differ", |(_, _, s, t, ..)| cross(*s, *t) != [0; 3])
        .prop_map(move |(shape, origin, s, t, reverse, first)| {
            let mut corners = shapes[shape].to_vec();
            let first = first % corners.len();
            corners.rotate_left(first);
            if reverse {
                corners.reverse();
            }
            Polygon { origin, along: [s, t], corners }
        })
}

proptest! {
    #![proptest_config(cases(128))]

    #[test]
    fn a_segment_breaks_exactly_the_bonds_that_cross_it(
        counts in prop::array::uniform2(3..14_usize),
        corners in prop::array::uniform4(-2..28_i128),
        horizon in prop_oneof![Just(1.0), Just(2.0), Just(3.0), 1.5..3.5_f64],
        place in (-4.0..3.0_f64, -50.0..50.0_f64),
        late: bool,
    ) {
        let [x, y, x1, y1] = corners;
        prop_assume!((x, y) != (x1, y1));
        let (a, b): (Spot, Spot) = ([x, y, 0], [x1, y1, 0]);
        let unit = 10_f64.powf(place.0);
        let lattice = Lattice::new(&counts, unit, unit * place.1);
        let mut simulation = lattice.simulation(horizon);
        if late {
            simulation.evaluate().unwrap();
        }
        let vertices = [lattice.place(&a), lattice.place(&b)].concat();
        simulation.break_crossing(&vertices).unwrap();
        lattice.compare(&simulation, |p, q| crosses_segment(a, b, p, q))?;
    }

    #[test]
    fn a_polygon_breaks_exactly_the_bonds_that_cross_it(
        counts in prop::array::uniform3(2..7_usize),
        polygon in polygons(),
        horizon in prop_oneof![Just(1.0), Just(2.0), 1.5..2.5_f64],
        place in (-4.0..3.0_f64, -50.0..50.0_f64),
    ) {
        let unit = 10_f64.powf(place.0);
        let lattice = Lattice::new(&counts, unit, unit * place.1);
        let mut simulation = lattice.simulation(horizon);
        let corners = 0..polygon.corners.len();
        let vertices: Vec<f64> =
            corners.flat_map(|number| lattice.place(&polygon.corner(number))).collect();
        simulation.break_crossing(&vertices).unwrap();
        lattice.compare(&simulation, |p, q| polygon.crosses(p, q))?;
    }
}
