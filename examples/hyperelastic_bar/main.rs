//! A bar of a hyperelastic material is drawn out: the total and the updated Lagrangian form against the exact answer.
//!
//! After Bergel and Li 2016, example II: a bar of 0.1 x 0.1 x 1 with lambda = 200 and mu = 20 of Saint Venant
//! and Kirchhoff, held along its axis at the bottom, under a traction at the top. A stretch of 1 + s needs
//! the traction E s (1 + s)(1 + s/2): the displacement of 0.01 that the paper compares with belongs to 0.590575. The
//! traction of 14 that it names belongs to 0.1857.
//!
//! The weak forms are solved: the strong ones leave no surface free of traction. The layer that is held lies
//! outside the length, so that it and the last layer are a length apart.
//!
//! `cargo run --release --example hyperelastic_bar -- [traction, 0.590575] [points across, 5] [loads on the way, 4]
//! [curves, hyperelastic_bar_rust.csv] [output files, hyperelastic_bar_rust]`, and for pictures
//! `cargo run --release --example picture -- hyperelastic_bar_rust.csv curves.png --curves`
//!
//! In order: points and sets, then for each formulation: model, simulation, conditions, equilibria, a file.
//! Numbers have no units. The same program stands beside this one in C and in Fortran; all three print the same
//! hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::process::ExitCode;

use perion::{Field, Model, Points, Quantity, Result, Simulation, SolveOptions};

const LAMBDA: f64 = 200.0;
const MU: f64 = 20.0;
const DENSITY: f64 = 1.4;
const WIDTH: f64 = 0.1;
const LENGTH: f64 = 1.0;
const FORMS: [&str; 2] = ["total_lagrangian", "updated_lagrangian"];

fn main() -> ExitCode {
    let argument = |place: usize, otherwise: &str| {
        std::env::args().nth(place).unwrap_or_else(|| otherwise.into())
    };
    let traction: f64 = argument(1, "0.590575").parse().unwrap_or(0.0);
    let across = argument(2, "5").parse().unwrap_or(0);
    let loads = argument(3, "4").parse().unwrap_or(0);
    let curves = argument(4, "hyperelastic_bar_rust.csv");
    let files = argument(5, "hyperelastic_bar_rust");
    if traction.is_nan() || traction <= 0.0 || across < 3 || !(1..=100).contains(&loads) {
        eprintln!("a traction above 0, at least 3 points across and 1 to 100 loads are needed");
        return ExitCode::FAILURE;
    }
    let bars = match run(traction, across, loads, &files) {
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

/// What is known at one load.
pub struct Load {
    /// On the top.
    pub traction: f64,
    /// Displacement of the top, in both forms.
    pub tops: [f64; 2],
    /// The same of the law.
    pub exact: f64,
}

/// What the bars do.
pub struct Bars {
    /// The first one without a load.
    pub loads: Vec<Load>,
    /// A fingerprint of the displacements at the end.
    pub hash: u64,
}

/// Both bars.
pub fn run(traction: f64, across: usize, loads: usize, files: &str) -> Result<Bars> {
    let modulus = MU * (3.0 * LAMBDA + 2.0 * MU) / (LAMBDA + MU);
    let points = column(across)?;
    println!("{} points, a traction of {traction:9.6}", points.count());
    let mut records: Vec<Load> = (0..=loads)
        .map(|k| traction * k as f64 / loads as f64)
        .map(|traction| Load { traction, tops: [0.0; 2], exact: exact(modulus, traction) })
        .collect();

    let mut hash = 0;
    for (form, name) in FORMS.into_iter().enumerate() {
        let mut rubber = Model::new(name)?;
        rubber.set("youngs_modulus", modulus)?;
        rubber.set("poissons_ratio", LAMBDA / (2.0 * (LAMBDA + MU)))?;
        rubber.set("density", DENSITY)?;
        rubber.set("horizon", 2.015 * (WIDTH / across as f64))?;
        let mut bar = Simulation::new(&points, &rubber)?;

        // The bottom is free to narrow; single points keep the bar from moving as a whole.
        bar.prescribe("bottom", Quantity::Displacement, 2, 0.0)?;
        bar.prescribe("pin", Quantity::Displacement, 0, 0.0)?;
        bar.prescribe("pin", Quantity::Displacement, 1, 0.0)?;
        bar.prescribe("guide", Quantity::Displacement, 1, 0.0)?;

        // Equilibria under growing loads.
        let options = SolveOptions { tolerance: 1e-6, ..SolveOptions::default() };
        let mut forces = 0;
        for record in records.iter_mut().skip(1) {
            bar.prescribe("top", Quantity::Traction, 2, record.traction)?;
            forces += bar.solve(&options)?.evaluations;
            let moved = bar.sum(Field::Displacement, Some("top"))?[2];
            record.tops[form] = moved / points.set_size("top")? as f64;
        }
        let end = &records[loads];
        let error = 100.0 * (end.tops[form] / end.exact - 1.0);
        println!("{name:<19} {:10.6} {error:10.4} % {forces:6} forces", end.tops[form]);
        hash = hash_values(hash, &bar.get(Field::Displacement)?);
        if !files.is_empty() {
            let fields = [Field::Displacement, Field::CauchyStress];
            bar.write_vtk(format!("{files}_{name}.vtu"), &fields)?;
        }
    }
    println!("exact               {:10.6}", records[loads].exact);
    println!("  linear            {:10.6}", LENGTH * traction / modulus);
    println!("Young's modulus     {modulus:10.6}");
    println!("hash            {hash:010X}");
    Ok(Bars { loads: records, hash })
}

/// The points: a block, its axis the z axis.
fn column(across: usize) -> Result<Points> {
    let h = WIDTH / across as f64;
    let (lower, upper) = ([0.0, 0.0, -h], [WIDTH, WIDTH, LENGTH]);
    let mut points = Points::block(3, &lower, &upper, h)?;
    points.add_set_box("bottom", &lower, &[WIDTH, WIDTH, 0.0])?;
    points.add_set_box("top", &[0.0, 0.0, LENGTH - h], &upper)?;
    points.add_set_box("pin", &lower, &[h, h, 0.0])?;
    points.add_set_box("guide", &[WIDTH - h, 0.0, -h], &[WIDTH, h, 0.0])?;
    Ok(points)
}

/// The displacement of the top, exactly.
fn exact(modulus: f64, traction: f64) -> f64 {
    let mut s = 0.0;
    for _ in 0..50 {
        s -= (modulus * s * (1.0 + s) * (1.0 + 0.5 * s) - traction)
            / (modulus * (1.0 + 3.0 * s + 1.5 * s * s));
    }
    LENGTH * s
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// A row for each load; the first line names the columns.
pub fn write_curves(path: &str, bars: &Bars) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let mut text = String::from("traction,total Lagrangian,updated Lagrangian,exact\n");
    for Load { traction, tops: [total, updated], exact } in &bars.loads {
        text += &format!("{traction:10.6},{total:11.7},{updated:11.7},{exact:11.7}\n");
    }
    std::fs::write(path, text)
}
