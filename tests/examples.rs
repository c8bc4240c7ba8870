//! The examples `specimen`, `wave` and `own_material` give what mechanics says, and the same in C, Fortran and Rust.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

mod common;
#[path = "fortran_interface/compilers.rs"]
#[allow(dead_code)]
mod compilers;
#[path = "../examples/own_material/main.rs"]
#[allow(dead_code)]
mod own_material;
#[path = "../examples/specimen/main.rs"]
#[allow(dead_code)]
mod specimen;
#[path = "../examples/wave/main.rs"]
#[allow(dead_code)]
mod wave;

use std::f64::consts::PI;
use std::fs;
use std::process::Command;
use std::sync::OnceLock;

use common::{in_crate, run, there_is};
use perion::Field;

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

fn tensile_test() -> &'static specimen::Outcome {
    static TEST: OnceLock<specimen::Outcome> = OnceLock::new();
    TEST.get_or_init(|| specimen::run(&mesh("msh"), "").unwrap())
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
    let (msh, inp) = (tensile_test(), specimen::run(&mesh("inp"), "").unwrap());
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
fn the_front_runs_at_the_speed_of_a_bar_less_what_its_lateral_inertia_costs() {
    for rise in [40.0, 60.0] {
        let wave = wave::run(120, rise).unwrap();
        let deviation = wave.speed / wave.expected - 1.0;
        assert!(deviation.abs() < 0.03, "{deviation}");
        // Love: omega = c k (1 - (nu r k)^2/2), with r^2 = width^2/6 for a square. That takes a share of
        // (nu r)^2/2 v'''/v' off the speed of a place in a front, -8/rise^2 in the middle of this one. Love has
        // one mode, and the first station is two widths from the blow.
        let inertia = -0.5 * 0.25_f64.powi(2) * (20.0 * 20.0 / 6.0) * 8.0 / (rise * rise);
        assert!((deviation - inertia).abs() < 0.005, "{deviation}, Love {inertia}");

        // The free end doubles the velocity; lateral inertia lets it swing about that.
        let last = &wave.velocities[wave.velocities.len() - 1];
        assert!((last[119] - 2.0).abs() < 0.2, "{}", last[119]);
        let energy = wave.bar.energy().unwrap();
        // Nothing breaks: what is left is the swing of velocity Verlet.
        let closure = energy.closure_error / energy.external_work;
        assert!(closure.abs() < 1e-3, "{closure}");
    }
}

#[test]
fn the_force_of_a_bar_with_a_law_of_its_own_relaxes_as_its_closed_form() {
    let bar = own_material::run(20).unwrap();
    // The pull, of u in T, ends with an acceleration of 4 u/T^2 taken off at once: the bar swings by up to twice the
    // force of its inertia, rho A L 2 u/T^2, about E A u/L.
    let (density, length, ramp) = (1.2e-3, 17.0, 0.5_f64);
    let swing = 4.0 * density * length * length / (1000.0 * ramp * ramp);
    assert!(swing < 0.006 && bar.worst < swing, "{}, swing {swing}", bar.worst);
    // (1 + c)/(1 + c exp(-3)), c = ((1 - exp(-1/2))/(1/2))^2.
    let relaxed = bar.forces[60] / bar.forces[240];
    let left = (2.0 * (1.0 - (-0.5_f64).exp())).powi(2);
    let closed = (1.0 + left) / (1.0 + left * (-3.0_f64).exp());
    assert!((relaxed / closed - 1.0).abs() < swing, "{relaxed}, closed form {closed}");
    // Between the innermost points of the grips, 17 mm apart; families of grips reach beyond them.
    let elastic = 1000.0 * 16.0 * 0.16 / length;
    assert!((bar.bearing / elastic - 1.0).abs() < 0.02, "{} N, {elastic}", bar.bearing);
    // Held for three tau, Q keeps exp(-6) of its energy, and the motion less: what was put in and is neither in the
    // elastic springs, E A u^2/2L, nor given back is in the dashpots.
    let energy = &bar.energy;
    let springs = 0.5 * bar.bearing * 0.16;
    assert!((energy.elastic / springs - 1.0).abs() < 0.01, "{} mJ, {springs}", energy.elastic);
    let taken = energy.external_work - energy.elastic;
    assert!((-energy.closure_error / taken - 1.0).abs() < 1e-3, "{energy:?}");
}

#[test]
fn the_own_material_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "the_own_material_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let outcome = own_material::run(10).unwrap();
        own_material::write_curve(&format!("{directory}/rust.csv"), &outcome).unwrap();
        return;
    }
    compare_twins(name, "own_material", &["10"]);
}

#[test]
fn the_specimen_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let (name, file) = (
        "the_specimen_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads",
        mesh("msh"),
    );
    if let Some(directory) = rust_side() {
        specimen::run(&file, "")
            .map(|test| specimen::write_curve(&format!("{directory}/rust.csv"), &test.records))
            .unwrap()
            .unwrap();
        return;
    }
    compare_twins(name, "specimen", &[&file]);
}

#[test]
fn the_wave_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "the_wave_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let wave = wave::run(50, 40.0).unwrap();
        wave::write_matrix(&format!("{directory}/rust.csv"), &wave).unwrap();
        return;
    }
    compare_twins(name, "wave", &["50"]);
}

const SIDE: &str = "PERION_TEST_RUST_TWIN";

/// Where the twin in Rust, a process of its own whose number of threads its environment tells, leaves
/// its file; `None` in the test itself.
fn rust_side() -> Option<String> {
    std::env::var(SIDE).ok().inspect(|_| println!())
}

/// Runs an example in C, in Fortran and, as the test `name`, in Rust: what they print and write must be
/// the same.
fn compare_twins(name: &str, example: &str, arguments: &[&str]) {
    if !(there_is("cc") && there_is("gfortran")) {
        return;
    }
    let directory = common::place(&format!("examples/{example}"));
    let source = |ending| in_crate(&format!("examples/{example}/main.{ending}"));
    let in_c = compilers::c(&directory, &format!("{example}_c"), &source("c"));
    let mut sources = compilers::module_sources();
    sources.push(source("f90"));
    let in_fortran = compilers::fortran(&directory, example, &sources, "-O2");
    let mut twins = Vec::new();
    for threads in ["1", "2"] {
        let [mut c, mut fortran] = [&in_c, &in_fortran].map(Command::new);
        c.args(arguments).arg(directory.join("c.csv")).arg("");
        fortran.args(arguments).arg(directory.join("fortran.csv")).arg("");
        let mut rust = Command::new(std::env::current_exe().unwrap());
        rust.args([name, "--exact", "--nocapture"]).env(SIDE, &directory);
        for (mut twin, file) in [(c, "c.csv"), (fortran, "fortran.csv"), (rust, "rust.csv")] {
            let printed = run(twin.env("PERION_NUM_THREADS", threads));
            let table = fs::read_to_string(directory.join(file)).unwrap();
            twins.push((results(&printed), table));
        }
    }
    assert!(twins[0].0.len() > 5 && twins[0].1.lines().count() > 200, "{twins:?}");
    for twin in &twins {
        assert_eq!(twin, &twins[0]);
    }
}

/// What an example prints, without what the test runner does.
fn results(printed: &str) -> Vec<String> {
    let lines = printed.lines().skip_while(|line| !line.contains(" points, "));
    let mut results = Vec::new();
    for line in lines {
        results.push(line.to_owned());
        if line.starts_with("hash ") {
            return results;
        }
    }
    panic!("there is no hash in {printed}");
}
