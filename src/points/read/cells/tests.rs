use super::*;

const KINDS: [Kind; 12] = [
    Kind::Triangle3,
    Kind::Triangle6,
    Kind::Quadrilateral4,
    Kind::Quadrilateral8,
    Kind::Quadrilateral9,
    Kind::Tetrahedron4,
    Kind::Tetrahedron10,
    Kind::Pyramid5,
    Kind::Wedge6,
    Kind::Hexahedron8,
    Kind::Hexahedron20,
    Kind::Hexahedron27,
];

/// Corners of the reference cell, and its volume.
fn corners(kind: Kind) -> (Vec<[f64; 3]>, f64) {
    let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let triangle = [square[0], square[1], square[3]];
    let lifted = |base: &[[f64; 3]]| {
        let top = base.iter().map(|&[x, y, _]| [x, y, 1.0]);
        base.iter().copied().chain(top).collect::<Vec<_>>()
    };
    let tip = [0.0, 0.0, 1.0];
    match kind {
        Kind::Triangle3 | Kind::Triangle6 => (triangle.to_vec(), 0.5),
        Kind::Tetrahedron4 | Kind::Tetrahedron10 => ([&triangle[..], &[tip]].concat(), 1.0 / 6.0),
        Kind::Pyramid5 => ([&square[..], &[tip]].concat(), 1.0 / 3.0),
        Kind::Wedge6 => (lifted(&triangle), 0.5),
        Kind::Hexahedron8 | Kind::Hexahedron20 | Kind::Hexahedron27 => (lifted(&square), 1.0),
        _ => (square.to_vec(), 1.0),
    }
}

/// Corners around the middles of edges, faces and all of a hexahedron.
const HEXAHEDRON: [&[usize]; 19] = [
    &[0, 1],
    &[1, 2],
    &[2, 3],
    &[3, 0],
    &[4, 5],
    &[5, 6],
    &[6, 7],
    &[7, 4],
    &[0, 4],
    &[1, 5],
    &[2, 6],
    &[3, 7],
    &[0, 3, 4, 7],
    &[1, 2, 5, 6],
    &[0, 1, 4, 5],
    &[2, 3, 6, 7],
    &[0, 1, 2, 3],
    &[4, 5, 6, 7],
    &[0, 1, 2, 3, 4, 5, 6, 7],
];

/// All nodes of the reference cell: the corners, and the middles of edges and of the whole.
fn nodes(kind: Kind) -> Vec<[f64; 3]> {
    let (mut nodes, _) = corners(kind);
    let middle = |nodes: &[[f64; 3]], of: &[usize]| {
        [0, 1, 2].map(|k| of.iter().map(|&i| nodes[i][k]).sum::<f64>() / of.len() as f64)
    };
    let middles: &[&[usize]] = match kind {
        Kind::Triangle6 => &[&[0, 1], &[1, 2], &[2, 0]],
        Kind::Quadrilateral8 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
        Kind::Quadrilateral9 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0], &[0, 1, 2, 3]],
        Kind::Tetrahedron10 => &[&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 3], &[2, 3]],
        Kind::Hexahedron20 => &HEXAHEDRON[..12],
        Kind::Hexahedron27 => &HEXAHEDRON,
        _ => &[],
    };
    for of in middles {
        nodes.push(middle(&nodes, of));
    }
    assert_eq!(nodes.len(), kind.nodes());
    nodes
}

fn moved(kind: Kind, motion: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
    nodes(kind).into_iter().map(motion).collect()
}

#[test]
fn an_affine_cell_has_the_volume_and_centroid_of_its_corners() {
    let affine = |[x, y, z]: [f64; 3]| {
        [1e3 + 2.0 * x + 0.3 * y + 0.1 * z, -5.0 - 0.4 * x + y + 0.2 * z, 7.0 + 3.0 * z]
    };
    for kind in KINDS {
        let (corners, reference) = corners(kind);
        let solid = kind.dimension() == 3;
        let stretch = (2.0 + 0.4 * 0.3) * if solid { 3.0 } else { 1.0 };
        // The centroid of a pyramid is a quarter up from its base, all others' in the mean of the corners.
        let mean: [f64; 3] = [0, 1, 2].map(|k| {
            let sum = |of: &[[f64; 3]]| of.iter().map(|x| x[k]).sum::<f64>() / of.len() as f64;
            match kind {
                Kind::Pyramid5 => 0.75 * sum(&corners[..4]) + 0.25 * corners[4][k],
                _ => sum(&corners),
            }
        });
        let measure = kind.measure(&moved(kind, affine)).unwrap();
        // Coordinates of 1e3 carry 1e-13, volumes of sides of 1 the same.
        assert!((measure.volume / (reference * stretch) - 1.0).abs() < 1e-12, "{kind:?}");
        for (found, wanted) in measure.centroid.iter().zip(affine(mean)) {
            assert!((found - wanted).abs() < 1e-12 * 1e3, "{kind:?}: {measure:?}");
        }
    }
}

#[test]
fn curved_cells_are_measured_exactly() {
    // y -> y + c x (1 - x) is quadratic, keeps volumes, and lifts the centroid of square and cube by c / 6.
    let c = 0.3;
    let bent = |[x, y, z]: [f64; 3]| [x, y + c * x * (1.0 - x), z];
    for kind in [Kind::Quadrilateral8, Kind::Quadrilateral9, Kind::Hexahedron20, Kind::Hexahedron27]
    {
        let measure = kind.measure(&moved(kind, bent)).unwrap();
        assert!((measure.volume - 1.0).abs() < 1e-14, "{kind:?}: {measure:?}");
        assert!((measure.centroid[1] - (0.5 + c / 6.0)).abs() < 1e-14, "{measure:?}");
    }
    // Over the triangle and the tetrahedron the means of x(1-x) are 1/6 and 3/20.
    for (kind, volume, height, mean) in
        [(Kind::Triangle6, 0.5, 1.0 / 3.0, 1.0 / 6.0), (Kind::Tetrahedron10, 1.0 / 6.0, 0.25, 0.15)]
    {
        let measure = kind.measure(&moved(kind, bent)).unwrap();
        assert!((measure.volume - volume).abs() < 1e-15, "{kind:?}: {measure:?}");
        assert!((measure.centroid[1] - (height + c * mean)).abs() < 1e-15, "{measure:?}");
    }
}

#[test]
fn trilinear_cells_are_measured_exactly() {
    // Linear in each coordinate: the top is shrunk by a half towards z = 1, the sides are twisted. The
    // section at z has sides 1 - z/2: volume 7/12, height of the centroid (1/2 - 1/3 + 1/16)/(7/12).
    let tapered = |[x, y, z]: [f64; 3]| [x * (1.0 - 0.5 * z), y * (1.0 - 0.5 * z), z];
    for (kind, share) in [(Kind::Hexahedron8, 1.0), (Kind::Wedge6, 0.5)] {
        let measure = kind.measure(&moved(kind, tapered)).unwrap();
        assert!((measure.volume - share * 7.0 / 12.0).abs() < 1e-15, "{kind:?}: {measure:?}");
        let height = (0.5 - 1.0 / 3.0 + 1.0 / 16.0) * 12.0 / 7.0;
        assert!((measure.centroid[2] - height).abs() < 1e-15, "{kind:?}: {measure:?}");
    }
}

#[test]
fn a_cell_may_be_mirrored_but_not_folded_or_flat() {
    for kind in KINDS {
        let mirrored = kind.measure(&moved(kind, |[x, y, z]| [-x, y, z])).unwrap();
        assert!((mirrored.volume - kind.measure(&nodes(kind)).unwrap().volume).abs() < 1e-15);
        assert_eq!(kind.measure(&moved(kind, |[x, _, z]| [x, 0.0, z])), None, "{kind:?}");
        assert_eq!(kind.measure(&moved(kind, |_| [3.0; 3])), None, "{kind:?}");
    }
    // Two corners swapped: a bow tie.
    for (kind, [one, other]) in [(Kind::Quadrilateral4, [2, 3]), (Kind::Hexahedron8, [0, 1])] {
        let mut bow = nodes(kind);
        bow.swap(one, other);
        assert_eq!(kind.measure(&bow), None, "{kind:?}");
    }
    let huge = moved(Kind::Hexahedron8, |place| place.map(|x| 1e150 * x));
    assert_eq!(Kind::Hexahedron8.measure(&huge), None);
}
