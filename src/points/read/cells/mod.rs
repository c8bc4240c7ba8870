//! Cells of meshes: how many nodes they have, and what their volume and centroid are.
//!
//! A cell is the image of the unit square or cube under its shape functions; those of triangles, tetrahedra,
//! wedges and pyramids are written so that the square or cube collapses onto them. Volume and
//! centroid are integrals of polynomials there, and Gauss's rule takes them exactly, curved sides included.

use std::ops::{Add, Mul, Sub};

/// Most nodes that a cell has.
pub(super) const MOST_NODES: usize = 27;

/// Volume, over that of a cube of the cell's extent, below which it is made of rounding.
const FLAT: f64 = 1e-13;

/// A kind of cell, with its nodes in the order of VTK.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// What has a number but no extent: a mass, a spring.
    Nothing,
    /// A point.
    Vertex,
    /// A line of so many nodes.
    Line(u8),
    Triangle3,
    Triangle6,
    Quadrilateral4,
    Quadrilateral8,
    Quadrilateral9,
    Tetrahedron4,
    Tetrahedron10,
    Pyramid5,
    Wedge6,
    Hexahedron8,
    Hexahedron20,
    Hexahedron27,
}

/// Volume (in two dimensions: area) and centroid of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measure {
    pub(super) volume: f64,
    pub(super) centroid: [f64; 3],
}

impl Kind {
    pub(super) fn nodes(self) -> usize {
        match self {
            Self::Nothing => 0,
            Self::Vertex => 1,
            Self::Line(nodes) => nodes.into(),
            Self::Triangle3 => 3,
            Self::Quadrilateral4 | Self::Tetrahedron4 => 4,
            Self::Pyramid5 => 5,
            Self::Triangle6 | Self::Wedge6 => 6,
            Self::Quadrilateral8 | Self::Hexahedron8 => 8,
            Self::Quadrilateral9 => 9,
            Self::Tetrahedron10 => 10,
            Self::Hexahedron20 => 20,
            Self::Hexahedron27 => 27,
        }
    }

    pub(super) fn dimension(self) -> usize {
        match self {
            Self::Nothing | Self::Vertex => 0,
            Self::Line(_) => 1,
            Self::Triangle3
            | Self::Triangle6
            | Self::Quadrilateral4
            | Self::Quadrilateral8
            | Self::Quadrilateral9 => 2,
            Self::Tetrahedron4
            | Self::Tetrahedron10
            | Self::Pyramid5
            | Self::Wedge6
            | Self::Hexahedron8
            | Self::Hexahedron20
            | Self::Hexahedron27 => 3,
        }
    }

    /// Volume and centroid of a plane or solid cell; `None` where it is folded, turned partly inside out,
    /// without volume, or so large that numbers fail. Which way round it is does not matter.
    pub(super) fn measure(self, nodes: &[[f64; 3]]) -> Option<Measure> {
        let solid = self.dimension() == 3;
        // Relative to the first node, so that digits are not lost far from the origin.
        let origin = nodes[0];
        let mut corners = [[0.0; 3]; MOST_NODES];
        for (corner, node) in corners.iter_mut().zip(nodes) {
            *corner = [node[0] - origin[0], node[1] - origin[1], node[2] - origin[2]];
        }
        let extent = corners.iter().flatten().fold(0.0, |extent: f64, x| extent.max(x.abs()));
        let least_volume = FLAT * extent.powi(self.dimension() as i32);
        if let Some((volume, corner_count)) = match self {
            Self::Triangle3 => Some((0.5 * cross(corners[1], corners[2])[2], 3.0)),
            Self::Tetrahedron4 => Some((dot(corners[3], cross(corners[1], corners[2])) / 6.0, 4.0)),
            _ => None,
        } {
            let moment = std::array::from_fn(|axis| {
                volume * corners.iter().map(|corner| corner[axis]).sum::<f64>() / corner_count
            });
            return sound(volume, moment, origin, least_volume);
        }
        let rule = gauss(self.rule());
        let heights = if solid { rule } else { &[(0.0, 1.0)] };
        let (mut volume, mut moment, mut least, mut most) = (0.0, [0.0; 3], 0.0_f64, 0.0_f64);
        for &(u, by_u) in rule {
            for &(v, by_v) in rule {
                for &(w, by_w) in heights {
                    let (place, stretch) = self.image(&corners, [u, v, w], solid);
                    (least, most) = (least.min(stretch), most.max(stretch));
                    let weight = stretch * by_u * by_v * by_w;
                    volume += weight;
                    for axis in 0..3 {
                        moment[axis] += weight * place[axis];
                    }
                }
            }
        }
        if least < 0.0 && most > 0.0 {
            return None;
        }
        sound(volume, moment, origin, least_volume)
    }

    /// Points of Gauss's rule along each axis that volume and centroid need.
    fn rule(self) -> usize {
        match self {
            Self::Tetrahedron10 | Self::Hexahedron20 | Self::Hexahedron27 => 4,
            Self::Triangle6 | Self::Quadrilateral8 | Self::Quadrilateral9 => 3,
            _ => 2,
        }
    }

    /// Where a place of the unit cube comes to lie, and how much volume is stretched there.
    fn image(
        self,
        corners: &[[f64; 3]; MOST_NODES],
        [u, v, w]: [f64; 3],
        solid: bool,
    ) -> ([f64; 3], f64) {
        let shapes = self.shapes([Slope::along(u, 0), Slope::along(v, 1), Slope::along(w, 2)]);
        let mut place = [0.0; 3];
        let mut slopes = [[0.0; 3]; 3];
        for (shape, corner) in shapes.iter().zip(corners).take(self.nodes()) {
            for axis in 0..3 {
                place[axis] += shape.value * corner[axis];
                for (slope, along) in slopes[axis].iter_mut().zip(shape.slope) {
                    *slope += along * corner[axis];
                }
            }
        }
        let [x, y, z] = slopes;
        let stretch = if solid { dot(x, cross(y, z)) } else { x[0] * y[1] - x[1] * y[0] };
        (place, stretch)
    }

    /// The shape functions at a place of the unit square or cube.
    fn shapes(self, [u, v, w]: [Slope; 3]) -> [Slope; MOST_NODES] {
        let one = Slope::constant(1.0);
        let four = Slope::constant(4.0);
        let zero = Slope::constant(0.0);
        let mut shapes = [zero; MOST_NODES];
        // Barycentric coordinates: the square collapses onto a triangle, the cube onto a tetrahedron.
        let triangle = [(one - u) * (one - v), u, (one - u) * v];
        let tetrahedron =
            [(one - u) * (one - v) * (one - w), u, (one - u) * v, (one - u) * (one - v) * w];
        // Bilinear ones: corners counter-clockwise.
        let square = [(one - u) * (one - v), u * (one - v), u * v, (one - u) * v];
        match self {
            // The first two have no extent to speak of, the others are taken without shape functions.
            Self::Nothing | Self::Vertex | Self::Line(_) | Self::Triangle3 | Self::Tetrahedron4 => {
            }
            Self::Triangle6 => {
                quadratic(&triangle, &[[0, 1], [1, 2], [2, 0]], &mut shapes);
            }
            Self::Quadrilateral4 => shapes[..4].copy_from_slice(&square),
            Self::Quadrilateral8 => {
                let sides = [
                    four * u * (one - u) * (one - v),
                    four * v * (one - v) * u,
                    four * u * (one - u) * v,
                    four * v * (one - v) * (one - u),
                ];
                for corner in 0..4 {
                    let beside = sides[corner] + sides[(corner + 3) % 4];
                    shapes[corner] = square[corner] - Slope::constant(0.5) * beside;
                    shapes[4 + corner] = sides[corner];
                }
            }
            Self::Quadrilateral9 => {
                let (x, y) = (lagrange(u), lagrange(v));
                for (shape, [column, row, _]) in shapes.iter_mut().zip(PLACES_OF_9) {
                    *shape = x[column] * y[row];
                }
            }
            Self::Hexahedron20 => {
                // Middles of edges first; each takes half of itself from the corners at its ends.
                for (shape, place) in shapes.iter_mut().zip(PLACES_OF_27).take(20).skip(8) {
                    *shape = [u, v, w].into_iter().zip(place).fold(one, |product, (t, place)| {
                        product * [one - t, t, four * t * (one - t)][place]
                    });
                }
                for corner in 0..8 {
                    let at = PLACES_OF_27[corner];
                    let mut shape = [u, v, w]
                        .into_iter()
                        .zip(at)
                        .fold(one, |product, (t, place)| product * [one - t, t][place]);
                    for edge in 8..20 {
                        let ends = PLACES_OF_27[edge].into_iter().zip(at);
                        if ends.into_iter().all(|(edge, corner)| edge == 2 || edge == corner) {
                            shape = shape - Slope::constant(0.5) * shapes[edge];
                        }
                    }
                    shapes[corner] = shape;
                }
            }
            Self::Hexahedron27 => {
                let (x, y, z) = (lagrange(u), lagrange(v), lagrange(w));
                for (shape, [column, row, layer]) in shapes.iter_mut().zip(PLACES_OF_27) {
                    *shape = x[column] * y[row] * z[layer];
                }
            }
            Self::Tetrahedron10 => {
                let edges = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
                quadratic(&tetrahedron, &edges, &mut shapes);
            }
            Self::Pyramid5 => {
                shapes[..4].copy_from_slice(&square.map(|shape| shape * (one - w)));
                shapes[4] = w;
            }
            Self::Wedge6 => {
                shapes[..3].copy_from_slice(&triangle.map(|shape| shape * (one - w)));
                shapes[3..6].copy_from_slice(&triangle.map(|shape| shape * w));
            }
            Self::Hexahedron8 => {
                shapes[..4].copy_from_slice(&square.map(|shape| shape * (one - w)));
                shapes[4..8].copy_from_slice(&square.map(|shape| shape * w));
            }
        }
        shapes
    }
}

/// The measure, if it is one.
fn sound(volume: f64, moment: [f64; 3], origin: [f64; 3], least_volume: f64) -> Option<Measure> {
    let centroid: [f64; 3] = std::array::from_fn(|axis| origin[axis] + moment[axis] / volume);
    let sound =
        volume.abs() > least_volume && volume.is_finite() && centroid.iter().all(|x| x.is_finite());
    sound.then_some(Measure { volume: volume.abs(), centroid })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Where the nodes of cells stand along each axis: 0 at its beginning, 1 at its end, 2 in its middle.
const PLACES_OF_9: [[usize; 3]; 9] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [2, 0, 0],
    [1, 2, 0],
    [2, 1, 0],
    [0, 2, 0],
    [2, 2, 0],
];
const PLACES_OF_27: [[usize; 3]; 27] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [1, 1, 1],
    [0, 1, 1],
    [2, 0, 0],
    [1, 2, 0],
    [2, 1, 0],
    [0, 2, 0],
    [2, 0, 1],
    [1, 2, 1],
    [2, 1, 1],
    [0, 2, 1],
    [0, 0, 2],
    [1, 0, 2],
    [1, 1, 2],
    [0, 1, 2],
    [0, 2, 2],
    [1, 2, 2],
    [2, 0, 2],
    [2, 1, 2],
    [2, 2, 0],
    [2, 2, 1],
    [2, 2, 2],
];

/// Quadratic shape functions of an axis: at its beginning, its end and its middle.
fn lagrange(t: Slope) -> [Slope; 3] {
    let (one, two, four) = (Slope::constant(1.0), Slope::constant(2.0), Slope::constant(4.0));
    [(one - t) * (one - two * t), t * (two * t - one), four * t * (one - t)]
}

/// Shape functions of a simplex with a node in the middle of each edge.
fn quadratic(barycentric: &[Slope], edges: &[[usize; 2]], shapes: &mut [Slope; MOST_NODES]) {
    let (one, two, four) = (Slope::constant(1.0), Slope::constant(2.0), Slope::constant(4.0));
    for (shape, &at) in shapes.iter_mut().zip(barycentric) {
        *shape = at * (two * at - one);
    }
    for (shape, &[from, to]) in shapes[barycentric.len()..].iter_mut().zip(edges) {
        *shape = four * barycentric[from] * barycentric[to];
    }
}

/// Places and weights of Gauss's rule on the unit interval.
fn gauss(points: usize) -> &'static [(f64, f64)] {
    match points {
        2 => &[(0.211_324_865_405_187_1, 0.5), (0.788_675_134_594_812_9, 0.5)],
        3 => &[
            (0.112_701_665_379_258_31, 5.0 / 18.0),
            (0.5, 4.0 / 9.0),
            (0.887_298_334_620_741_7, 5.0 / 18.0),
        ],
        _ => &[
            (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
            (0.330_009_478_207_571_9, 0.326_072_577_431_273_07),
            (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
            (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
        ],
    }
}

/// A number and its slope along the three axes of the unit cube.
#[derive(Debug, Clone, Copy)]
struct Slope {
    value: f64,
    slope: [f64; 3],
}

impl Slope {
    fn constant(value: f64) -> Self {
        Self { value, slope: [0.0; 3] }
    }

    /// The coordinate along an axis.
    fn along(value: f64, axis: usize) -> Self {
        let mut slope = [0.0; 3];
        slope[axis] = 1.0;
        Self { value, slope }
    }
}

impl Add for Slope {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let slope = std::array::from_fn(|k| self.slope[k] + other.slope[k]);
        Self { value: self.value + other.value, slope }
    }
}

impl Sub for Slope {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        let slope = std::array::from_fn(|k| self.slope[k] - other.slope[k]);
        Self { value: self.value - other.value, slope }
    }
}

impl Mul for Slope {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl)] // the product rule
    fn mul(self, other: Self) -> Self {
        let slope =
            std::array::from_fn(|k| self.value * other.slope[k] + other.value * self.slope[k]);
        Self { value: self.value * other.value, slope }
    }
}

#[cfg(test)]
mod tests;
