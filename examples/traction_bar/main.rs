//! A bar under a tension: by how much each formulation errs in its length, for horizons of 2 to 7 spacings.
//!
//! After Partmann et al. 2026, section 5.1: a bar of 100 x 10 x 10 mm, E = 210 GPa, nu = 1/4, bears 200 kN.
//! Points near a surface lack bonds, and so bond_based and ordinary_state_based make a bar too soft or too
//! stiff; the bond-associated quadrature does not. Bonds and the linear solid are compared with F L/(E A), the
//! laws of Saint Venant and Kirchhoff with the stretch l of l (l^2 - 1) = 2 F/(E A).
//!
//! The load is a body force on the last layer, and a horizon of layers outside the length is clamped, as in the
//! paper; or it is a traction on both ends of a bar of twice the length, which is held along its axis in the
//! middle alone, so that the solution is exact. Its length is then that from the middle to the last layer.
//!
//! `cargo run --release --example traction_bar -- [points across, 5] [smallest horizon in spacings, 2]
//! [largest, 3] [formulation, all] [load: body_force or traction, body_force] [curves, traction_bar_rust.csv]`,
//! and for a picture
//! `cargo run --release --example picture -- traction_bar_rust.csv errors.png --curves --logarithmic`
//!
//! In order, for each formulation and horizon: points and sets, model, simulation, conditions, equilibrium,
//! results. Units are m, s and kg. The same program stands beside this one in C and in Fortran; all three
//! print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::ops::RangeInclusive;
use std::process::ExitCode;

use perion::{Field, Model, Points, Quantity, Result, Simulation, SolveOptions};

const LENGTH: f64 = 0.1; // m
const WIDTH: f64 = 0.01;
const MODULUS: f64 = 210e9; // Pa
const FORCE: f64 = 2e5; // N

/// A formulation, its influence function, and whether it is compared with linear elasticity.
pub const FORMS: [(&str, &str, bool); 4] = [
    ("bond_based", "", true),
    ("ordinary_state_based", "inverse", true),
    ("correspondence", "inverse", false),
    ("bond_associated_quadrature", "cubic_spline", false),
];

fn main() -> ExitCode {
    let argument = |place: usize, otherwise: &str| {
        std::env::args().nth(place).unwrap_or_else(|| otherwise.into())
    };
    let number = |place, otherwise| argument(place, otherwise).parse().unwrap_or(0);
    let (across, first, last) = (number(1, "5"), number(2, "2"), number(3, "3"));
    let formulation = argument(4, "all");
    let is_traction = argument(5, "body_force") == "traction";
    let curves = argument(6, "traction_bar_rust.csv");
    let known = formulation == "all" || FORMS.iter().any(|form| form.0 == formulation);
    if across < 2 || first < 1 || last < first || last > 16 || !known {
        eprintln!("at least 2 points across, horizons from 1 to 16 spacings and one of");
        FORMS.iter().for_each(|form| eprintln!("  {}", form.0));
        return ExitCode::FAILURE;
    }
    let bars = match run(across, first..=last, &formulation, is_traction) {
        Ok(bars) => bars,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_curves(&curves, &bars) {
        eprintln!("cannot write {curves}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What the bars give.
pub struct Bars {
    /// Formulations solved.
    pub formulations: Vec<&'static str>,
    /// Horizon in spacings, and the error of each formulation in percent.
    pub errors: Vec<(usize, Vec<f64>)>,
    /// A fingerprint of the displacements of all bars.
    pub hash: u64,
}

/// All bars.
pub fn run(
    across: usize,
    ratios: RangeInclusive<usize>,
    formulation: &str,
    is_traction: bool,
) -> Result<Bars> {
    let chosen = |form: &&(&str, &str, bool)| formulation == "all" || form.0 == formulation;
    let load = if is_traction { "a traction" } else { "a body force on the last layer" };
    println!("{across} points, that is so many across, under {load}");
    println!("horizon    points  formulation                    error %    forces");
    let mut hash = 0;
    let mut errors = Vec::new();
    for ratio in ratios {
        let mut row = Vec::new();
        for form in FORMS.iter().filter(chosen) {
            row.push(solve(*form, across, ratio, is_traction, &mut hash)?);
        }
        errors.push((ratio, row));
    }
    println!("hash            {hash:010X}");
    let formulations = FORMS.iter().filter(chosen).map(|form| form.0).collect();
    Ok(Bars { formulations, errors, hash })
}

/// The points: a block, its axis the x axis. What is loaded and what is held are named.
fn bar_of(across: usize, ratio: usize, is_traction: bool) -> Result<Points> {
    let h = WIDTH / across as f64;
    if is_traction {
        let end = LENGTH + 0.5 * h;
        let (lower, upper) = ([-end, 0.0, 0.0], [end, WIDTH, WIDTH]);
        let middle = [-0.5 * h, 0.0, 0.0];
        let mut points = Points::block(3, &lower, &upper, h)?;
        points.add_set_box("start", &lower, &[h - end, WIDTH, WIDTH])?;
        points.add_set_box("end", &[end - h, 0.0, 0.0], &upper)?;
        points.add_set_box("held", &middle, &[0.5 * h, WIDTH, WIDTH])?;
        points.add_set_box("pin", &middle, &[0.5 * h, h, h])?;
        points.add_set_box("guide", &[-0.5 * h, WIDTH - h, 0.0], &[0.5 * h, WIDTH, h])?;
        return Ok(points);
    }
    let (lower, upper) = ([-(ratio as f64) * h, 0.0, 0.0], [LENGTH, WIDTH, WIDTH]);
    let mut points = Points::block(3, &lower, &upper, h)?;
    points.add_set_box("held", &lower, &[0.0, WIDTH, WIDTH])?;
    points.add_set_box("end", &[LENGTH - h, 0.0, 0.0], &upper)?;
    Ok(points)
}

/// The conditions.
fn load(bar: &mut Simulation, across: usize, is_traction: bool) -> Result<()> {
    let (stress, depth) = (FORCE / (WIDTH * WIDTH), WIDTH / across as f64);
    bar.prescribe("held", Quantity::Displacement, 0, 0.0)?;
    if is_traction {
        bar.prescribe("start", Quantity::Traction, 0, -stress)?;
        bar.prescribe("end", Quantity::Traction, 0, stress)?;
        // Against rigid motion.
        bar.prescribe("pin", Quantity::Displacement, 1, 0.0)?;
        bar.prescribe("pin", Quantity::Displacement, 2, 0.0)?;
        bar.prescribe("guide", Quantity::Displacement, 2, 0.0)
    } else {
        bar.prescribe("held", Quantity::Displacement, 1, 0.0)?;
        bar.prescribe("held", Quantity::Displacement, 2, 0.0)?;
        bar.prescribe("end", Quantity::BodyForce, 0, stress / depth)
    }
}

/// The length change of a bar in tension, exactly.
fn exact(is_linear: bool) -> f64 {
    let strain = FORCE / (WIDTH * WIDTH) / MODULUS;
    if is_linear {
        return LENGTH * strain;
    }
    let mut stretch = 1.0;
    for _ in 0..20 {
        stretch -=
            (stretch * (stretch * stretch - 1.0) - 2.0 * strain) / (3.0 * stretch * stretch - 1.0);
    }
    LENGTH * (stretch - 1.0)
}

/// Solves one bar: its error in percent.
fn solve(
    (formulation, influence, is_linear): (&str, &str, bool),
    across: usize,
    ratio: usize,
    is_traction: bool,
    hash: &mut u64,
) -> Result<f64> {
    let points = bar_of(across, ratio, is_traction)?;

    let mut steel = Model::new(formulation)?;
    steel.set("youngs_modulus", MODULUS)?;
    steel.set("poissons_ratio", 0.25)?;
    steel.set("density", 7850.0)?; // kg/m3
    steel.set("horizon", 1.005 * ratio as f64 * (WIDTH / across as f64))?;
    if !influence.is_empty() {
        steel.choose("influence", influence)?;
    }
    let mut bar = Simulation::new(&points, &steel)?;
    load(&mut bar, across, is_traction)?;

    // Equilibrium, by Newton's method.
    let report = bar.solve(&SolveOptions::default())?;

    let moved = bar.sum(Field::Displacement, Some("end"))?[0] / points.set_size("end")? as f64;
    let error = 100.0 * (moved / exact(is_linear) - 1.0);
    let (count, forces) = (points.count(), report.evaluations);
    println!("{ratio:7} {count:9}  {formulation:<27}{error:11.4} {forces:9}");
    *hash = hash_values(*hash, &bar.get(Field::Displacement)?);
    Ok(error)
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// A row for each horizon, a column for each formulation; the first line names them.
pub fn write_curves(path: &str, bars: &Bars) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let mut text = String::from("horizon (spacings)");
    for formulation in &bars.formulations {
        text += &format!(",{formulation} (%)");
    }
    for (ratio, errors) in &bars.errors {
        text += &format!("\n{ratio:2}");
        for error in errors {
            text += &format!(",{error:11.4}");
        }
    }
    std::fs::write(path, text + "\n")
}
