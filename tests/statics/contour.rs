//! Rice's J on a box around the tip of a crack, from the fields of a plane body whose points are a lattice.

use perion::{Field, Simulation};

/// J = int W n_x - (P n) . du/dx ds along a box, an energy per area of crack; W, P, du/dx and normals of the reference.
///
/// The crack runs along x and leaves the box through its left side, between two layers of points. `lower` and `upper` are
/// points of the lattice, and so are all places at which fields are taken: a layer of points stands for a spacing of the
/// side that it lies on, the corners for half of one. Faces of the crack bear nothing and add nothing.
///
/// Sides need a horizon of undamaged points around them, but for where the crack passes: within a horizon of a surface
/// the gradient at a point is that further in.
pub fn j_integral(body: &Simulation, spacing: f64, lower: [f64; 2], upper: [f64; 2]) -> f64 {
    let [places, gradients, stresses, energies] = [
        Field::ReferencePosition,
        Field::DeformationGradient,
        Field::FirstPiolaStress,
        Field::StrainEnergyDensity,
    ]
    .map(|field| body.get(field).unwrap());
    let same = |one: f64, other: f64| (one - other).abs() < 0.25 * spacing;
    let mut sum = 0.0;
    for (point, place) in places.chunks_exact(2).enumerate() {
        let [f, p] = [&gradients, &stresses].map(|tensors| &tensors[4 * point..4 * point + 4]);
        let slope = [f[0] - 1.0, f[2]];
        for (across, along) in [(0, 1), (1, 0)] {
            let beyond = |low: f64, high: f64| low - 0.25 * spacing > high;
            if beyond(lower[along], place[along]) || beyond(place[along], upper[along]) {
                continue;
            }
            let is_corner = same(place[along], lower[along]) || same(place[along], upper[along]);
            let length = if is_corner { 0.5 * spacing } else { spacing };
            for (side, normal) in [(lower[across], -1.0), (upper[across], 1.0)] {
                if same(place[across], side) {
                    let pull = p[across] * slope[0] + p[2 + across] * slope[1];
                    let energy = if across == 0 { energies[point] } else { 0.0 };
                    sum += normal * length * (energy - pull);
                }
            }
        }
    }
    sum
}
