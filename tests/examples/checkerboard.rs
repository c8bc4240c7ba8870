//! The checkerboard of displacements, against sums over one family of the lattice.

#[path = "../../examples/checkerboard/main.rs"]
#[allow(dead_code)]
mod example;

use std::f64::consts::PI;
use std::sync::OnceLock;

use example::{AMPLITUDE, Cost, FORMS, HORIZON, SPACING};

use crate::twins::{compare_twins, rust_side};

const YOUNGS_MODULUS: f64 = 210e9;
const LAME_LAMBDA: f64 = YOUNGS_MODULUS / 2.5; // nu = 1/4
const SHEAR_MODULUS: f64 = LAME_LAMBDA;
const BULK_MODULUS: f64 = YOUNGS_MODULUS / 1.5;
const VOLUME: f64 = SPACING * SPACING * SPACING;

/// Of the formulation with this influence function.
fn cost(formulation: &str, influence: &str) -> &'static Cost {
    static BOARD: OnceLock<example::Board> = OnceLock::new();
    let board = BOARD.get_or_init(|| example::run(4, "").unwrap());
    &board.costs[FORMS.iter().position(|form| *form == (formulation, influence)).unwrap()]
}

/// The bonds of a full family, and by how much the displacement at their far ends is different.
fn family() -> impl Iterator<Item = ([f64; 3], [f64; 3], f64)> {
    let offsets = |reach: i32| -reach..=reach;
    let all = offsets(3)
        .flat_map(move |i| offsets(3).flat_map(move |j| offsets(3).map(move |k| [i, j, k])));
    all.filter(|&place| place != [0; 3]).filter_map(|place| {
        let [x, y, z] = place.map(|k| if k % 2 == 0 { 1.0 } else { -1.0 });
        let bond = place.map(|k| f64::from(k) * SPACING);
        let length = bond.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart = [y * z, x * z, x * y].map(|sign: f64| AMPLITUDE * (sign - 1.0));
        (length <= HORIZON).then_some((bond, apart, length))
    })
}

fn influence(name: &str, length: f64) -> f64 {
    let ratio = length / HORIZON;
    match name {
        "constant" => 1.0,
        "inverse" => 1.0 / ratio,
        _ if ratio <= 0.5 => 1.0 - 6.0 * ratio.powi(2) + 6.0 * ratio.powi(3),
        _ => 2.0 * (1.0 - ratio).powi(3),
    }
}

/// Of Saint Venant and Kirchhoff, at the deformation gradient I + `gradient`.
fn strain_energy(gradient: [[f64; 3]; 3]) -> f64 {
    let (mut trace, mut square) = (0.0, 0.0);
    for i in 0..3 {
        for j in 0..3 {
            let product: f64 = gradient.iter().map(|row| row[i] * row[j]).sum();
            let strain = 0.5 * (gradient[i][j] + gradient[j][i] + product);
            trace += if i == j { strain } else { 0.0 };
            square += strain * strain;
        }
    }
    0.5 * LAME_LAMBDA * trace * trace + SHEAR_MODULUS * square
}

/// All figures are sums of a hundred like terms; displacements are a thousandth of the spacing, which
/// leaves thirteen digits of a strain.
const TOLERANCE: f64 = 1e-11;

#[test]
fn quadrature_at_the_bonds_sees_the_checkerboard() {
    for (name, figure) in
        [("constant", 1.037664e5), ("inverse", 1.324901e5), ("cubic_spline", 2.510877e5)]
    {
        // The gradient of every family is I, and that of a bond differs from it along the bond alone.
        let (mut sum, mut weights) = (0.0, 0.0);
        for (bond, apart, length) in family() {
            let weight = influence(name, length);
            let gradient = apart.map(|u| bond.map(|x| u * x / (length * length)));
            sum += weight * strain_energy(gradient);
            weights += weight;
        }
        let cost = cost("bond_associated_quadrature", name);
        assert!((cost.middle / (sum / weights) - 1.0).abs() < TOLERANCE, "{}", cost.middle);
        // Of an implementation of its own, as it was printed: seven digits.
        assert!((cost.middle / figure - 1.0).abs() < 5e-7, "{}, not {figure}", cost.middle);
    }
}

#[test]
fn bonds_see_the_checkerboard() {
    let constant = 18.0 * BULK_MODULUS / (PI * HORIZON.powi(4));
    let energy: f64 = family()
        .map(|(bond, apart, length)| {
            let deformed: f64 = (0..3).map(|axis| (bond[axis] + apart[axis]).powi(2)).sum();
            let stretch = deformed.sqrt() / length - 1.0;
            0.25 * constant * stretch * stretch * length * VOLUME
        })
        .sum();
    let cost = cost("bond_based", "");
    assert!((cost.middle / energy - 1.0).abs() < TOLERANCE, "{}, not {energy}", cost.middle);
    assert!((cost.middle / 2.664566e5 - 1.0).abs() < 5e-7, "{}", cost.middle);
}

#[test]
fn correspondence_does_not_see_the_checkerboard_and_penalties_do() {
    let squares: f64 = family().flat_map(|(_, apart, _)| apart).map(|u| u * u * VOLUME).sum();
    let shape: f64 = family().map(|(bond, _, _)| bond[0] * bond[0] * VOLUME).sum();
    // [P 4.11] with C_s = 1, and [P 4.13] with a shape tensor that is a multiple of I.
    let silling = 18.0 * BULK_MODULUS / (PI * HORIZON.powi(5));
    let wan = (3.0 * LAME_LAMBDA + 2.0 * SHEAR_MODULUS) / shape;
    for (formulation, stiffness) in
        [("correspondence", 0.0), ("correspondence_silling", silling), ("correspondence_wan", wan)]
    {
        let cost = cost(formulation, "constant");
        // The square of what rounding leaves of a strain.
        assert!(cost.greatest < 1e-12 * 1.037664e5, "{formulation}: {}", cost.greatest);
        let penalty = 0.5 * stiffness * squares;
        let apart = (cost.penalty - penalty).abs();
        assert!(apart <= TOLERANCE * penalty, "{formulation}: {}, not {penalty}", cost.penalty);
        // At the faces families are cut, and gradients see it.
        assert!(cost.profile[0] > 1e4, "{formulation}: {}", cost.profile[0]);
    }
}

#[test]
fn every_point_of_the_window_is_two_horizons_inside() {
    for (formulation, influence) in FORMS {
        let cost = cost(formulation, influence);
        let spread = (cost.greatest - cost.least) / cost.middle.max(1.0);
        assert!(spread < TOLERANCE, "{formulation} {influence}: {spread}");
    }
}

#[test]
fn the_checkerboard_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "checkerboard::the_checkerboard_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let board = example::run(4, "").unwrap();
        example::write_profile(&format!("{directory}/rust.csv"), &board).unwrap();
        return;
    }
    compare_twins(name, "checkerboard", &["4"], 16);
}
