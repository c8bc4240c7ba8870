//! The nonlocal operators approach the local ones with the square of the horizon: example I of Bergel and
//! Li.
//!
//! A plane lattice under x_1 = X_1^4, x_2 = X_2, of a linear elastic solid with lambda = 100 and mu = 50 (the source
//! does not say which; here P = lambda tr(eps) I + 2 mu eps), in plane strain. Nothing depends on X_2, so that a strip
//! does, as wide as its middle row sees. Fields and operators are both nonlocal: P is that of the nonlocal F.

use crate::data::largest;
use perion::{Field, Model, Operator, Points, Simulation};

const LAMBDA: f64 = 100.0;
const MU: f64 = 50.0;

/// Largest errors on the middle row for X_1 from 1/4 to 3/4: of F_11, of Div P, and how far J div sigma is from
/// Div P, over the largest Div P.
struct Errors {
    gradient: f64,
    divergence: f64,
    apart: f64,
}

/// With `cells` spacings on a unit of length and a horizon of `reach` spacings.
fn errors(cells: usize, reach: usize, bonds: &str) -> Errors {
    // The middle row sees P of `reach` rows on either side, and each of these F of as many more.
    let rows = 4 * reach + 1;
    let spacing = 1.0 / cells as f64;
    let places: Vec<[f64; 2]> = (0..rows)
        .flat_map(|row| (0..=cells).map(move |cell| [cell, row].map(|k| k as f64 * spacing)))
        .collect();
    let points =
        Points::new(2, places.as_flattened(), &vec![spacing * spacing; places.len()]).unwrap();
    let mut model = Model::new("total_lagrangian").unwrap();
    model.set("density", 1.0).unwrap();
    model.set("horizon", reach as f64 * spacing).unwrap();
    model.set("lame_lambda", LAMBDA).unwrap();
    model.set("shear_modulus", MU).unwrap();
    model.choose("material", "small_strain").unwrap();
    model.choose("operator_bonds", bonds).unwrap();
    let mut body = Simulation::new(&points, &model).unwrap();
    let now: Vec<f64> = places.iter().flat_map(|x| [x[0].powi(4), x[1]]).collect();
    body.set(Field::Position, &now).unwrap();

    let [reference, current] = match bonds {
        "undeformed" => [Operator::ReferenceUndeformed, Operator::CurrentUndeformed],
        _ => [Operator::ReferenceDeformed, Operator::CurrentDeformed],
    };
    let gradient = body.get(Field::DeformationGradient).unwrap();
    let of = |field, operator| body.divergence(operator, 4, &body.get(field).unwrap()).unwrap();
    let (total, updated) =
        (of(Field::FirstPiolaStress, reference), of(Field::CauchyStress, current));
    let mut errors = Errors { gradient: 0.0, divergence: 0.0, apart: 0.0 };
    let middle = rows / 2 * (cells + 1);
    let mut sizes = Vec::new();
    for point in middle + cells / 4..=middle + 3 * cells / 4 {
        let (x, f) = (places[point][0], &gradient[4 * point..][..4]);
        errors.gradient = errors.gradient.max((f[0] - 4.0 * x.powi(3)).abs());
        let expected = (LAMBDA + 2.0 * MU) * 12.0 * x * x;
        errors.divergence = errors.divergence.max((total[2 * point] - expected).abs());
        let ratio = f[0] * f[3] - f[1] * f[2];
        for component in 2 * point..2 * point + 2 {
            errors.apart = errors.apart.max((ratio * updated[component] - total[component]).abs());
        }
        sizes.push(expected);
        // Across the strip nothing happens, but for rounding of places of 1/160 to 1e-16.
        assert!((f[3] - 1.0).abs() < 1e-13 && f[1].abs() < 1e-13 && f[2].abs() < 1e-13, "{f:?}");
    }
    errors.apart /= largest(&sizes);
    errors
}

#[test]
fn errors_fall_with_the_square_of_the_horizon() {
    for bonds in ["undeformed", "deformed"] {
        let mut finest = Vec::new();
        for reach in [1, 2] {
            let runs = [40, 80, 160].map(|cells| errors(cells, reach, bonds));
            for pair in runs.windows(2) {
                for (what, coarse, fine) in [
                    ("F", pair[0].gradient, pair[1].gradient),
                    ("Div P", pair[0].divergence, pair[1].divergence),
                ] {
                    let slope = (coarse / fine).log2();
                    eprintln!("{bonds}, {reach} spacings, {what}: {fine:.3e}, slope {slope:.4}");
                    assert!((1.95..2.05).contains(&slope), "{bonds} {reach} {what}: {slope}");
                }
            }
            for run in &runs {
                // In this motion both are the same numbers: J N^-T = K^-1 and J M^-1 = N^-1 along X_1.
                eprintln!("{bonds}, {reach}: J div sigma off by {:.1e}", run.apart);
                assert!(run.apart < 1e-8, "{bonds} {reach}: {:e}", run.apart);
            }
            finest.push([runs[2].gradient, runs[2].divergence]);
        }
        // sum xi_1^4 over sum xi_1^2: 2/2 for four neighbours a spacing away, 38/14 for the twelve within two.
        for (what, of) in ["F", "Div P"].iter().zip([0, 1]) {
            let ratio = finest[1][of] / finest[0][of];
            eprintln!("{bonds}, {what}: ratio {ratio:.4}");
            assert!((ratio - 2.71).abs() < 0.05, "{bonds} {what}: {ratio}");
        }
    }
}
