//! The specimen that is pulled apart.

#[path = "../../examples/specimen/main.rs"]
#[allow(dead_code)]
mod example;

use std::f64::consts::PI;
use std::sync::OnceLock;

use perion::Field;

use crate::common::in_crate;
use crate::twins::{compare_twins, rust_side};

// The specimen: lengths in mm, stresses in MPa.
const THICKNESS: f64 = 3.0;
const NARROW: f64 = 12.0;
const HOLE: f64 = 4.0;
const YOUNGS_MODULUS: f64 = 3200.0;
const ENERGY_RELEASE_RATE: f64 = 0.5;
const NET_SECTION: f64 = THICKNESS * (NARROW - HOLE);
/// Of linear finite elements for the same outline and held ends, in the limit of small elements.
const FINITE_ELEMENTS: f64 = 1559.5;
/// Greatest stress at the hole over the mean stress beside it, of the same finite elements.
const CONCENTRATION: f64 = 2.35;

fn mesh(ending: &str) -> String {
    format!("{}/specimen.{ending}", in_crate("examples/specimen").display())
}

fn tensile_test() -> &'static example::Outcome {
    static TEST: OnceLock<example::Outcome> = OnceLock::new();
    TEST.get_or_init(|| example::run(&mesh("msh"), "").unwrap())
}

fn horizon() -> f64 {
    let points = tensile_test().specimen.points();
    3.0 * (points.volumes().iter().sum::<f64>() / points.count() as f64).sqrt()
}

#[test]
fn the_specimen_is_as_stiff_as_finite_elements_say_less_what_its_free_edges_cost() {
    // Along a free edge in uniaxial stress the energy that missing bonds leave out is that of a strip
    // 0.122 horizons wide, and the narrow part has two edges. The rim of the hole adds to it, and the
    // strain that moves to where it costs less.
    let edges = 2.0 * 0.122 * horizon() / NARROW;
    assert!((0.03..0.04).contains(&edges), "{edges}");
    let short = 1.0 - tensile_test().stiffness / FINITE_ELEMENTS;
    assert!(edges < short && short < 2.0 * edges, "{short}, edges alone {edges}");
}

#[test]
fn the_specimen_is_in_balance_until_it_breaks() {
    let test = tensile_test();
    let breaking = test.records[test.intact].force;
    for record in &test.records[test.intact / 2..=test.intact] {
        // What is left is the lowest mode, which the start of the pull has set swinging.
        let apart = (record.force + record.left_force) / breaking;
        assert!(apart.abs() < 0.03, "{apart} at {} mm", record.displacement);
    }
    // By the speed of the pull, which the elastic energy outgrows.
    assert!(test.records[test.intact].kinetic_share < 0.02);
}

#[test]
fn the_first_bond_breaks_when_the_stress_at_the_hole_is_that_of_the_critical_stretch() {
    let test = tensile_test();
    let critical_stretch =
        (4.0 * PI * ENERGY_RELEASE_RATE / (9.0 * YOUNGS_MODULUS * horizon())).sqrt();
    let strength = YOUNGS_MODULUS * critical_stretch;
    let at_hole = CONCENTRATION * test.records[test.intact].force / NET_SECTION;
    // Bonds average over a horizon, here 0.9 radii of the hole, and edges are soft: opposite in sign.
    assert!((at_hole / strength - 1.0).abs() < 0.1, "{at_hole} MPa, strength {strength} MPa");
    // A crack from the hole runs through: hardly more force is needed than for its first bond.
    let more = test.records[test.peak].force / test.records[test.intact].force;
    assert!((1.0..1.1).contains(&more), "{more}");
}

#[test]
fn the_specimen_breaks_in_two_beside_the_hole_at_the_cost_of_the_new_surface() {
    let test = tensile_test();
    let damage = test.specimen.get(Field::Damage).unwrap();
    let displacement = test.specimen.get(Field::Displacement).unwrap();
    let coordinates = test.specimen.points().coordinates();
    let (mut left, mut right) = (f64::NEG_INFINITY, f64::INFINITY);
    for (point, &damage) in damage.iter().enumerate() {
        let (x, u) = (coordinates[2 * point], displacement[2 * point]);
        assert!(damage < 0.1 || x.abs() < HOLE, "damage {damage} at {x} mm");
        if (HOLE..2.0 * HOLE).contains(&-x) {
            left = left.max(u);
        } else if (HOLE..2.0 * HOLE).contains(&x) {
            right = right.min(u);
        }
    }
    let pulled = test.records[test.records.len() - 1].displacement;
    // The halves have sprung back beyond where they come to rest.
    assert!(right - left > pulled, "halves at {left} and {right} mm, the grip at {pulled} mm");

    // A straight crack through full families costs G_c; it ends at free edges, and is not straight.
    let energy = test.specimen.energy().unwrap();
    let surface = ENERGY_RELEASE_RATE * NET_SECTION;
    assert!((energy.dissipated / surface - 1.0).abs() < 0.1, "{} of {surface}", energy.dissipated);
    // Bonds break between two evaluations of their force: see the ledger of energy in ARCHITECTURE.
    let closure = energy.closure_error / energy.external_work;
    assert!(closure.abs() < 0.003, "{closure}");
}

#[test]
fn the_specimen_is_the_same_from_gmsh_and_from_abaqus() {
    let (msh, inp) = (tensile_test(), example::run(&mesh("inp"), "").unwrap());
    // Coordinates have 16 digits in the one file and 14 in the other.
    let stiffness = inp.stiffness / msh.stiffness - 1.0;
    assert!(stiffness.abs() < 1e-9, "{stiffness}");
    assert_eq!((inp.intact, inp.peak), (msh.intact, msh.peak));
    for (one, other) in inp.records.iter().zip(&msh.records) {
        let force = (one.force - other.force) / msh.records[msh.peak].force;
        assert!(force.abs() < 1e-9, "{force} at {} mm", one.displacement);
    }
}

#[test]
fn the_specimen_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let (name, file) = (
        "specimen::the_specimen_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads",
        mesh("msh"),
    );
    if let Some(directory) = rust_side() {
        example::run(&file, "")
            .map(|test| example::write_curve(&format!("{directory}/rust.csv"), &test.records))
            .unwrap()
            .unwrap();
        return;
    }
    compare_twins(name, "specimen", &[&file], 200);
}
