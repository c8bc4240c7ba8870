//! Deformation and stress on demand: exact in bodies deformed alike everywhere, those of the law, and those of a
//! rigid body.

use crate::data::{assert_close, assert_near, largest};
use perion::{FORMULATIONS, Field, Model, Points, Simulation};

const E: f64 = 2.5;
const NU: f64 = 0.25;
const SPACING: f64 = 0.1;

/// Which formulations take a material.
const WITH_LAW: [&str; 4] = [
    "correspondence",
    "correspondence_silling",
    "correspondence_wan",
    "bond_associated_quadrature",
];

fn model(formulation: &str, plane: &str, horizon: f64) -> Model {
    let mut model = Model::new(formulation).unwrap();
    // That of bond_based in its plane state.
    let ratio = if plane == "stress" { 1.0 / 3.0 } else { NU };
    for (key, value) in
        [("density", 1.0), ("horizon", horizon), ("youngs_modulus", E), ("poissons_ratio", ratio)]
    {
        model.set(key, value).unwrap();
    }
    if !plane.is_empty() {
        model.choose("plane", plane).unwrap();
    }
    if formulation == "correspondence_silling" {
        model.set("silling_coefficient", 1.0).unwrap();
    }
    model
}

fn block(dimension: usize, points: [usize; 3]) -> Points {
    let (lower, upper) = ([0.0; 3], points.map(|n| n as f64 * SPACING));
    Points::block(dimension, &lower[..dimension], &upper[..dimension], SPACING).unwrap()
}

/// x = F X + c, with F row after row.
fn deform(simulation: &mut Simulation, gradient: &[f64]) {
    let dimension = simulation.points().dimension();
    let places = simulation.points().coordinates();
    let moved: Vec<f64> = places
        .chunks(dimension)
        .flat_map(|place| {
            gradient
                .chunks(dimension)
                .map(|row| row.iter().zip(place).map(|(f, x)| f * x).sum::<f64>() + 0.3)
                .collect::<Vec<f64>>()
        })
        .collect();
    simulation.set(Field::Position, &moved).unwrap();
}

fn planes(dimension: usize) -> &'static [&'static str] {
    if dimension == 3 { &[""] } else { &["strain", "stress"] }
}

/// A deformed body of every formulation and plane state.
fn each_deformed(
    points: [usize; 3],
    gradient: impl Fn(usize) -> Vec<f64>,
    check: impl Fn(&str, usize, &str, &Simulation),
) {
    for dimension in [2, 3] {
        for entry in &FORMULATIONS {
            for plane in planes(dimension) {
                if entry.name == "madenci_oterkus" && dimension == 2 {
                    continue;
                }
                let model = model(entry.name, plane, 2.5 * SPACING);
                let mut body = Simulation::new(&block(dimension, points), &model).unwrap();
                deform(&mut body, &gradient(dimension));
                check(entry.name, dimension, plane, &body);
            }
        }
    }
}

fn affine(dimension: usize) -> Vec<f64> {
    if dimension == 3 {
        vec![1.1, 0.05, -0.02, 0.01, 0.95, 0.03, -0.04, 0.02, 1.03]
    } else {
        vec![1.1, 0.05, 0.01, 0.95]
    }
}

fn rotation(dimension: usize) -> Vec<f64> {
    let (sine, cosine) = 0.7_f64.sin_cos();
    let (s, c) = 1.9_f64.sin_cos();
    if dimension == 2 {
        return vec![cosine, -sine, sine, cosine];
    }
    // About the third axis, then about the first.
    vec![cosine, -sine, 0.0, c * sine, c * cosine, -s, s * sine, s * cosine, c]
}

fn repeated(tensor: &[f64], count: usize) -> Vec<f64> {
    tensor.repeat(count)
}

fn count(body: &Simulation) -> usize {
    body.points().count()
}

fn product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    (0..n * n)
        .map(|place| (0..n).map(|k| a[place / n * n + k] * b[k * n + place % n]).sum())
        .collect()
}

fn transposed(a: &[f64], n: usize) -> Vec<f64> {
    (0..n * n).map(|place| a[place % n * n + place / n]).collect()
}

fn trace(a: &[f64], n: usize) -> f64 {
    (0..n).map(|axis| a[axis * n + axis]).sum()
}

fn strain(gradient: &[f64], n: usize) -> Vec<f64> {
    let mut strain = product(&transposed(gradient, n), gradient, n);
    (0..n).for_each(|axis| strain[axis * n + axis] -= 1.0);
    strain.iter().map(|value| 0.5 * value).collect()
}

fn determinant(a: &[f64], n: usize) -> f64 {
    if n == 2 {
        return a[0] * a[3] - a[1] * a[2];
    }
    a[0] * (a[4] * a[8] - a[5] * a[7]) - a[1] * (a[3] * a[8] - a[5] * a[6])
        + a[2] * (a[3] * a[7] - a[4] * a[6])
}

/// lambda and mu of a model above.
fn lame(plane: &str) -> (f64, f64) {
    let nu = if plane == "stress" { 1.0 / 3.0 } else { NU };
    (E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu)))
}

/// Sums of a hundred bonds, each of its own rounding.
const ROUNDING: f64 = 1e-13;

#[test]
fn gradient_strain_and_change_of_volume_of_an_affine_patch_are_exact_up_to_the_surface() {
    each_deformed([6, 5, 4], affine, |name, dimension, plane, body| {
        let (given, count) = (affine(dimension), count(body));
        let what = |field: &str| format!("{name} {dimension}D {plane}: {field}");
        let found = body.get(Field::DeformationGradient).unwrap();
        assert_close(&what("F"), &found, &repeated(&given, count), ROUNDING);
        let found = body.get(Field::Strain).unwrap();
        let expected = repeated(&strain(&given, dimension), count);
        assert_close(&what("E"), &found, &expected, 1e-12);
        if !["ordinary_state_based", "madenci_oterkus"].contains(&name) {
            let expected = vec![determinant(&given, dimension) - 1.0; count];
            assert_close(&what("J - 1"), &body.get(Field::Dilatation).unwrap(), &expected, 1e-12);
        }
    });
}

#[test]
fn stresses_of_an_affine_patch_are_those_of_saint_venant_and_kirchhoff() {
    each_deformed([6, 5, 4], affine, |name, n, plane, body| {
        if !WITH_LAW.contains(&name) {
            return;
        }
        let (gradient, count) = (affine(n), count(body));
        let (strain, (lambda, mu)) = (strain(&gradient, n), lame(plane));
        let change = trace(&strain, n);
        let in_plane =
            if plane == "stress" { 2.0 * lambda * mu / (lambda + 2.0 * mu) } else { lambda };
        let mut second: Vec<f64> = strain.iter().map(|e| 2.0 * mu * e).collect();
        (0..n).for_each(|axis| second[axis * n + axis] += in_plane * change);
        let first = product(&gradient, &second, n);
        let thickness = match plane {
            "stress" => (1.0 - 2.0 * lambda / (lambda + 2.0 * mu) * change).sqrt(),
            _ => 1.0,
        };
        let jacobian = thickness * determinant(&gradient, n);
        let cauchy: Vec<f64> = product(&first, &transposed(&gradient, n), n)
            .iter()
            .map(|value| value / jacobian)
            .collect();
        let what = |field: &str| format!("{name} {n}D {plane}: {field}");
        let found = body.get(Field::FirstPiolaStress).unwrap();
        assert_close(&what("P"), &found, &repeated(&first, count), 1e-12);
        let found = body.get(Field::CauchyStress).unwrap();
        assert_close(&what("sigma"), &found, &repeated(&cauchy, count), 1e-12);
        for sigma in found.chunks(n * n) {
            let apart = sigma.iter().zip(transposed(sigma, n)).map(|(a, b)| a - b);
            assert!(largest(&apart.collect::<Vec<f64>>()) <= 1e-12 * largest(sigma));
        }
        let across = if plane == "strain" { lambda * change / jacobian } else { 0.0 };
        if n == 2 {
            let found = body.get(Field::Stress33).unwrap();
            assert_close(&what("sigma_33"), &found, &vec![across; count], 1e-12);
        }
        let at = |row: usize, column: usize| match (row, column) {
            (2, 2) if n == 2 => across,
            _ if row < n && column < n => cauchy[row * n + column],
            _ => 0.0,
        };
        let pressure = (at(0, 0) + at(1, 1) + at(2, 2)) / 3.0;
        let squares: f64 = (0..9)
            .map(|place| at(place / 3, place % 3) - if place % 4 == 0 { pressure } else { 0.0 })
            .map(|value| value * value)
            .sum();
        let found = body.get(Field::VonMisesStress).unwrap();
        assert_close(&what("von Mises"), &found, &vec![(1.5 * squares).sqrt(); count], 1e-12);
    });
}

/// A body pulled along the first axis alone by what leaves its other sides free.
#[test]
fn von_mises_stress_of_uniaxial_tension_is_that_tension() {
    let stretch = 1.02_f64;
    // SVK: lateral strain -nu E_11.
    let along = 0.5 * (stretch * stretch - 1.0);
    for (plane, nu) in [("", NU), ("stress", 1.0 / 3.0)] {
        let lateral = (1.0 - 2.0 * nu * along).sqrt();
        let dimension = if plane.is_empty() { 3 } else { 2 };
        let mut gradient = vec![0.0; dimension * dimension];
        gradient[0] = stretch;
        (1..dimension).for_each(|axis| gradient[axis * dimension + axis] = lateral);
        let tension = E * along * stretch / (lateral * lateral);
        for name in WITH_LAW {
            let model = model(name, plane, 2.5 * SPACING);
            let mut body = Simulation::new(&block(dimension, [5, 4, 4]), &model).unwrap();
            deform(&mut body, &gradient);
            let expected = vec![tension; count(&body)];
            assert_close(name, &body.get(Field::VonMisesStress).unwrap(), &expected, 1e-11);
            let sigma = body.get(Field::CauchyStress).unwrap();
            assert_near(name, sigma[0], tension, 1e-11);
        }
    }
}

/// Also sheets and lines of points, whose families do not span the body: the sheet's normal turns with it.
#[test]
fn a_rigid_rotation_gives_that_rotation_and_no_stress() {
    for points in [[5, 4, 3], [6, 5, 1], [7, 1, 1]] {
        each_deformed(points, rotation, |name, dimension, plane, body| {
            let what = format!("{name} {dimension}D {plane}, {points:?}");
            let (given, count) = (rotation(dimension), count(body));
            let is_string = dimension == 3 && points == [7, 1, 1];
            for found in body.get(Field::DeformationGradient).unwrap().chunks(dimension * dimension)
            {
                if is_string {
                    // The twist is not known: a rotation that turns the string.
                    let first = [found[0], found[3], found[6]];
                    assert_close(&what, &first, &[given[0], given[3], given[6]], ROUNDING);
                    assert_near(&what, determinant(found, 3), 1.0, ROUNDING);
                } else {
                    assert_close(&what, found, &given, ROUNDING);
                }
            }
            for field in [Field::Strain, Field::FirstPiolaStress, Field::CauchyStress] {
                let found = body.get(field).unwrap();
                let size = largest(&found);
                assert!(size < 1e-13 * E, "{what}: {field:?} {size:e}, {count} points");
            }
        });
    }
}

#[test]
fn all_is_exactly_zero_at_rest() {
    for points in [[5, 4, 3], [6, 5, 1], [7, 1, 1], [1, 1, 1]] {
        for dimension in [2, 3] {
            for entry in &FORMULATIONS {
                for plane in planes(dimension) {
                    if entry.name == "madenci_oterkus" && dimension == 2 {
                        continue;
                    }
                    let model = model(entry.name, plane, 2.5 * SPACING);
                    let body = Simulation::new(&block(dimension, points), &model).unwrap();
                    for field in [
                        Field::Strain,
                        Field::FirstPiolaStress,
                        Field::CauchyStress,
                        Field::VonMisesStress,
                        Field::Dilatation,
                        Field::Stress33,
                    ] {
                        if field.is_defined(dimension) {
                            let found = body.get(field).unwrap();
                            let is_zero = found.iter().all(|&value| value == 0.0);
                            assert!(is_zero, "{} {dimension}D {plane} {field:?}", entry.name);
                        }
                    }
                    let found = body.get(Field::DeformationGradient).unwrap();
                    let one =
                        |place: usize| f64::from(u8::from(place.is_multiple_of(dimension + 1)));
                    let square = dimension * dimension;
                    let is_one = |(place, &value): (usize, &f64)| value == one(place % square);
                    assert!(found.iter().enumerate().all(is_one), "{} {dimension}D", entry.name);
                }
            }
        }
    }
}

/// A plate one point thick in 3D is one in plane stress: the normal thins as that does.
#[test]
fn a_sheet_in_space_has_the_stress_of_a_plate_in_plane_stress() {
    let mut model = model("correspondence", "", 2.5 * SPACING);
    let mut flat = self::model("correspondence", "stress", 2.5 * SPACING);
    flat.set("poissons_ratio", NU).unwrap();
    for material in ["saint_venant_kirchhoff", "neo_hookean", "small_strain"] {
        model.choose("material", material).unwrap();
        flat.choose("material", material).unwrap();
        let mut sheet = Simulation::new(&block(3, [6, 5, 1]), &model).unwrap();
        let mut plate = Simulation::new(&block(2, [6, 5, 1]), &flat).unwrap();
        deform(&mut plate, &[1.1, 0.05, 0.01, 0.95]);
        deform(&mut sheet, &[1.1, 0.05, 0.0, 0.01, 0.95, 0.0, 0.0, 0.0, 1.0]);
        let plate_stress = plate.get(Field::CauchyStress).unwrap();
        let sheet_stress = sheet.get(Field::CauchyStress).unwrap();
        for (flat, space) in plate_stress.chunks(4).zip(sheet_stress.chunks(9)) {
            assert_close(material, &[space[0], space[1], space[3], space[4]], flat, 1e-12);
            assert!([2, 5, 6, 7, 8].iter().all(|&place| space[place].abs() < 1e-13), "{material}");
        }
        let mises = plate.get(Field::VonMisesStress).unwrap();
        assert_close(material, &sheet.get(Field::VonMisesStress).unwrap(), &mises, 1e-12);
    }
}

/// Bonds without a law, inside a lattice: a horizon of four spacings sums its ball to 7 %. What does not depend on
/// that: the work of the stress is twice the energy, and of LPS the mean stress is the elastic one.
#[test]
fn the_virial_stress_inside_a_lattice_is_the_elastic_stress() {
    for name in ["bond_based", "ordinary_state_based", "madenci_oterkus"] {
        for dimension in [2, 3] {
            if name == "madenci_oterkus" && dimension == 2 {
                continue;
            }
            for plane in planes(dimension) {
                for strain in [[1e-6; 3], [1e-6, 0.0, 0.0], [1e-6, -2e-6, 0.5e-6]] {
                    compare_virial_stress(name, dimension, plane, &strain);
                }
            }
        }
    }
}

fn compare_virial_stress(name: &str, dimension: usize, plane: &str, strain: &[f64; 3]) {
    let (side, square) = (17, dimension * dimension);
    let model = model(name, plane, 4.0 * SPACING);
    let mut body = Simulation::new(&block(dimension, [side; 3]), &model).unwrap();
    let diagonal = |value: &dyn Fn(usize) -> f64| {
        let at = |place: usize| {
            if place.is_multiple_of(dimension + 1) { value(place / dimension) } else { 0.0 }
        };
        (0..square).map(at).collect::<Vec<f64>>()
    };
    deform(&mut body, &diagonal(&|axis| 1.0 + strain[axis]));
    let middle = (0..dimension).fold(0, |place, _| place * side + side / 2);
    let sigma = body.get(Field::CauchyStress).unwrap();
    let sigma = &sigma[middle * square..(middle + 1) * square];
    let ((lambda, mu), is_stress) = (lame(plane), plane == "stress");
    let in_plane = if is_stress { 2.0 * lambda * mu / (lambda + 2.0 * mu) } else { lambda };
    let change: f64 = strain[..dimension].iter().sum();
    let expected = diagonal(&|axis| in_plane * change + 2.0 * mu * strain[axis]);
    let what = format!("{name} {dimension}D {plane} {strain:?}");
    assert_close(&what, sigma, &expected, 0.08);
    // The strain squared is left out.
    let work: f64 = (0..dimension).map(|axis| sigma[axis * (dimension + 1)] * strain[axis]).sum();
    let energy = body.get(Field::StrainEnergyDensity).unwrap()[middle];
    assert_near(&what, work, 2.0 * energy, 1e-5);
    if name == "ordinary_state_based" {
        assert_near(&what, trace(sigma, dimension), trace(&expected, dimension), 1e-5);
    }
    if dimension == 2 {
        let across = body.get(Field::Stress33).unwrap()[middle];
        let held = if is_stress { 0.0 } else { NU * trace(sigma, 2) };
        assert!((across - held).abs() <= 1e-5 * held.abs(), "{what}: {across} for {held}");
    }
}

#[test]
fn the_stress_across_a_solid_is_refused_with_the_reason() {
    let body = Simulation::new(&block(3, [3, 3, 3]), &model("correspondence", "", 0.25)).unwrap();
    let error = body.get(Field::Stress33).unwrap_err();
    assert!(matches!(error, perion::Error::Unsupported(_)));
    assert!(error.to_string().contains("stress_33 is the stress across a 2D body"), "{error}");
}

/// A point without a family costs nothing, whatever the law, and is where it is.
#[test]
fn a_point_alone_has_the_identity_and_no_stress() {
    // Two that hold each other, and one far from both.
    let places = [0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 5.0, 5.0, 5.0];
    let points = Points::new(3, &places, &[1.0; 3]).unwrap();
    let last = |body: &Simulation, field: Field| {
        let values = body.get(field).unwrap();
        values[values.len() / 3 * 2..].to_vec()
    };
    for material in ["saint_venant_kirchhoff", "neo_hookean", "small_strain"] {
        let mut model = model("correspondence", "", 0.25);
        model.choose("material", material).unwrap();
        let mut body = Simulation::new(&points, &model).unwrap();
        deform(&mut body, &rotation(3));
        let found = last(&body, Field::DeformationGradient);
        assert_eq!(found, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        for field in [Field::CauchyStress, Field::StrainEnergyDensity, Field::InternalForce] {
            assert!(last(&body, field).iter().all(|&value| value == 0.0), "{material}");
        }
    }
}

/// A body drawn to nothing: the error names it, and no field shows what is not a number.
#[test]
fn a_stress_that_is_not_finite_is_an_error_that_names_the_point() {
    let mut body =
        Simulation::new(&block(3, [4, 3, 3]), &model("correspondence", "", 0.25)).unwrap();
    deform(&mut body, &[0.0; 9]);
    let error = body.get(Field::CauchyStress).unwrap_err();
    assert!(matches!(error, perion::Error::Numeric(_)));
    assert!(error.to_string().contains("cauchy_stress of point"), "{error}");
    assert!(body.get(Field::DeformationGradient).is_ok());
}
