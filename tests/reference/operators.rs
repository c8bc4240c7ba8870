//! Nonlocal operators on fields of the host's: against the reference, on affine fields, and what is refused.

use super::formulations::{body, load, numbers};
use crate::data::{assert_close, largest};
use perion::{Error, Field, Model, Operator, Points, Simulation};

const OPERATORS: [Operator; 4] = [
    Operator::ReferenceUndeformed,
    Operator::ReferenceDeformed,
    Operator::CurrentUndeformed,
    Operator::CurrentDeformed,
];

#[test]
fn operators_give_the_gradients_and_divergences_of_the_reference() {
    let mut cases = 0;
    for name in [
        "tlul2d_jitter_linel",
        "tlul2d_jitter_svk",
        "tlul2d_lattice_linel",
        "tlul2d_lattice_svk",
        "tlul3d_jitter_svk",
    ] {
        let file = load(name);
        for (case, expected) in file["models"].as_object().unwrap() {
            let body = body(&file, expected);
            let dimension = body.points().dimension();
            let square = dimension * dimension;
            let (updated, deformed) = (case.contains("updated"), case.contains("undeformed"));
            let [gradient, divergence] = match (updated, !deformed) {
                (false, false) => [Operator::ReferenceUndeformed; 2],
                (false, true) => [Operator::ReferenceDeformed; 2],
                (true, false) => [Operator::ReferenceUndeformed, Operator::CurrentUndeformed],
                (true, true) => [Operator::ReferenceDeformed, Operator::CurrentDeformed],
            };
            let position = body.get(Field::Position).unwrap();
            let found = body.gradient(gradient, dimension, &position).unwrap();
            let what = format!("{name}, {case}");
            assert_close(&what, &found, &numbers(&expected["gradient"]), 1e-11);
            // The strong form is rho a = Div P, or J div sigma.
            let stress =
                body.get(if updated { Field::CauchyStress } else { Field::FirstPiolaStress });
            let mut force = body.divergence(divergence, square, &stress.unwrap()).unwrap();
            if updated {
                for (force, f) in force.chunks_exact_mut(dimension).zip(found.chunks_exact(square))
                {
                    force.iter_mut().for_each(|force| *force *= determinant(f));
                }
            }
            assert_close(&what, &force, &numbers(&expected["force"]), 1e-11);
            cases += 1;
        }
    }
    assert_eq!(cases, 20);
}

fn determinant(f: &[f64]) -> f64 {
    match f {
        [a, b, c, d] => a * d - b * c,
        [a, b, c, d, e, f, g, h, i] => {
            a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
        }
        _ => panic!("{f:?}"),
    }
}

fn lattice(counts: [usize; 3]) -> Vec<f64> {
    let mut positions = Vec::new();
    for k in 0..counts[0] * counts[1] * counts[2] {
        let place = [k % counts[0], k / counts[0] % counts[1], k / counts[0] / counts[1]];
        positions.extend(place.map(|place| place as f64 + 0.1 * (place * place % 3) as f64));
    }
    positions
}

fn simulation(formulation: &str, positions: &[f64]) -> Simulation {
    let points = Points::new(3, positions, &vec![1.0; positions.len() / 3]).unwrap();
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 2.2)] {
        model.set(key, value).unwrap();
    }
    if formulation != "bond_based" {
        model.set("poissons_ratio", 0.2).unwrap();
    }
    Simulation::new(&points, &model).unwrap()
}

const F: [[f64; 3]; 3] = [[1.2, 0.1, -0.2], [0.3, 0.9, 0.05], [0.0, -0.1, 1.1]];
const SLOPE: [[f64; 3]; 2] = [[0.5, -2.0, 1.5], [3.0, 0.25, -1.0]];

fn applied(rows: &[[f64; 3]], x: &[f64]) -> Vec<f64> {
    rows.iter().map(|row| row.iter().zip(x).map(|(row, x)| row * x).sum()).collect()
}

#[test]
fn shape_tensors_of_an_affine_motion_are_those_of_the_reference_body_moved_along() {
    let positions = lattice([5, 4, 4]);
    for entry in &perion::FORMULATIONS {
        let mut body = simulation(entry.name, &positions);
        let now: Vec<f64> = positions.chunks_exact(3).flat_map(|x| applied(&F, x)).collect();
        body.set(Field::Position, &now).unwrap();
        body.break_bonds(&[[0, 1], [22, 23], [22, 27]]).unwrap();
        let [reference, mixed, deformed] =
            [Field::ShapeTensor, Field::MixedShapeTensor, Field::DeformedShapeTensor]
                .map(|field| body.get(field).unwrap());
        // N = F K and M = F K F^T = F N^T, of which columns and rows are vectors. K is symmetric.
        let transposed = |tensors: &[f64]| -> Vec<f64> {
            tensors.chunks_exact(9).flat_map(|t| (0..9).map(|n| t[n % 3 * 3 + n / 3])).collect()
        };
        let moved = |tensors: &[f64]| -> Vec<f64> {
            tensors.chunks_exact(3).flat_map(|row| applied(&F, row)).collect()
        };
        let expected = transposed(&moved(&reference));
        assert_close(&format!("N of {}", entry.name), &mixed, &expected, 1e-14);
        let expected = moved(&mixed);
        assert_close(&format!("M of {}", entry.name), &deformed, &expected, 1e-14);
    }
}

#[test]
fn affine_fields_have_their_slope_in_every_formulation_and_form() {
    let positions = lattice([5, 4, 4]);
    for entry in &perion::FORMULATIONS {
        let mut body = simulation(entry.name, &positions);
        let now: Vec<f64> = positions.chunks_exact(3).flat_map(|x| applied(&F, x)).collect();
        body.set(Field::Position, &now).unwrap();
        body.break_bonds(&[[0, 1], [22, 23], [22, 27]]).unwrap();
        for operator in OPERATORS {
            let by_reference =
                matches!(operator, Operator::ReferenceUndeformed | Operator::ReferenceDeformed);
            let at = if by_reference { &positions } else { &now };
            let field: Vec<f64> = at.chunks_exact(3).flat_map(|x| applied(&SLOPE, x)).collect();
            let gradient = body.gradient(operator, 2, &field).unwrap();
            let expected = SLOPE.concat().repeat(positions.len() / 3);
            assert_close(&format!("{} {operator:?}", entry.name), &gradient, &expected, 1e-12);
            // Rows of a tensor that is affine: T_ab = b-th slope of x_a, so that the divergence is known.
            let tensor: Vec<f64> = at
                .chunks_exact(3)
                .flat_map(|x| (0..6).map(|n| SLOPE[n / 3][n % 3] * x[n % 3]))
                .collect();
            let divergence = body.divergence(operator, 6, &tensor).unwrap();
            let sums: Vec<f64> = SLOPE.iter().map(|row| row.iter().sum()).collect();
            let expected = sums.repeat(positions.len() / 3);
            assert_close(&format!("{} {operator:?}", entry.name), &divergence, &expected, 1e-12);
        }
    }
}

#[test]
fn where_a_family_is_a_sheet_derivatives_are_those_along_it() {
    let positions: Vec<f64> =
        lattice([5, 4, 1]).chunks_exact(3).flat_map(|x| [x[0], x[1], 0.0]).collect();
    let mut body = simulation("correspondence", &positions);
    // Turned by a right angle about x: what lay in y lies in z.
    let now: Vec<f64> = positions.chunks_exact(3).flat_map(|x| [x[0], 0.0, x[1]]).collect();
    body.set(Field::Position, &now).unwrap();
    let field: Vec<f64> = positions.chunks_exact(3).map(|x| 2.0 * x[0] - x[1]).collect();
    for operator in OPERATORS {
        let by_reference =
            matches!(operator, Operator::ReferenceUndeformed | Operator::ReferenceDeformed);
        let expected = if by_reference { [2.0, -1.0, 0.0] } else { [2.0, 0.0, -1.0] };
        let gradient = body.gradient(operator, 1, &field).unwrap();
        assert_close(&format!("{operator:?}"), &gradient, &expected.repeat(20), 1e-12);
    }
    let alone = simulation("bond_based", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 9.0, 0.0, 0.0]);
    for operator in OPERATORS {
        let gradient = alone.gradient(operator, 1, &[1.0, 3.0, 7.0]).unwrap();
        assert_eq!(gradient, [2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}

#[test]
fn what_cannot_be_differentiated_is_refused() {
    let positions = lattice([4, 3, 3]);
    let mut body = simulation("ordinary_state_based", &positions);
    let operator = Operator::ReferenceDeformed;
    let text = |result: perion::Result<Vec<f64>>| match result {
        Err(Error::Argument(text) | Error::Numeric(text)) => text,
        other => panic!("{other:?}"),
    };
    let mut field = vec![1.0; 36];
    assert!(text(body.gradient(operator, 2, &field)).contains("'field' has 36 numbers"));
    assert!(text(body.gradient(operator, 0, &[])).contains("'components' 0"));
    assert!(text(body.gradient(operator, usize::MAX, &field)).contains("'components'"));
    assert!(text(body.divergence(operator, 1, &field)).contains("multiple of the dimension, 3"));
    assert!(text(body.divergence(operator, 0, &[])).contains("'components' 0"));
    field[7] = f64::NAN;
    assert!(text(body.gradient(operator, 1, &field)).contains("point 7, component 0, is NaN"));
    field[7] = 1.0;
    // Crushed to one place: deformed bonds have no length, those of the reference body do not mind.
    body.set(Field::Position, &vec![1.0; 108]).unwrap();
    field[7] = 2.0;
    assert!(text(body.gradient(operator, 1, &field)).contains("is not finite"));
    let found = body.gradient(Operator::ReferenceUndeformed, 1, &field).unwrap();
    assert!(largest(&found) > 0.1);
}
