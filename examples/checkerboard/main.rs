//! A checkerboard of displacements: which formulations see it, and what it costs in each.
//!
//! Points of a cube of steel are displaced so that the sign changes from point to point, by a thousandth
//! of their spacing: Partmann et al. 2026, section 4.4. A gradient averaged over a family does not see such
//! a mode, and the correspondence formulations store no energy in it, not even where a penalty resists it.
//! The bond-associated quadrature and bonds themselves do see it. The window in the middle, 40 points
//! along an edge in the paper, is two horizons from every face: all families that count there are full.
//!
//! `cargo run --release --example checkerboard -- [points along the window, 16]
//! [profile, checkerboard_rust.csv] [output files, checkerboard_rust]`, and for a picture
//! `cargo run --release --example picture -- checkerboard_rust_correspondence_constant.vtu cut.png
//! --field strain_energy_density --slice 0`
//!
//! In order: points, then for each formulation: model, simulation, a state set by hand, its fields, a
//! file. Nothing moves. Units are m, s and kg. The same program stands beside this one in C and in
//! Fortran; all three print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::f64::consts::PI;
use std::process::ExitCode;

use perion::{Field, Model, Points, Result, Simulation};

/// m
pub const SPACING: f64 = 0.025;
/// m
pub const HORIZON: f64 = 3.015 * SPACING;
/// m
pub const AMPLITUDE: f64 = 1e-3 * SPACING;
/// Layers of points around the window: families reach three, and those of neighbours three more.
pub const BUFFER: usize = 6;
/// Formulations and their influence functions.
pub const FORMS: [(&str, &str); 7] = [
    ("correspondence", "constant"),
    ("correspondence_silling", "constant"),
    ("correspondence_wan", "constant"),
    ("bond_associated_quadrature", "constant"),
    ("bond_associated_quadrature", "inverse"),
    ("bond_associated_quadrature", "cubic_spline"),
    ("bond_based", ""),
];

fn main() -> ExitCode {
    let window = std::env::args().nth(1).unwrap_or_else(|| "16".into()).parse().unwrap_or(0);
    let profile = std::env::args().nth(2).unwrap_or_else(|| "checkerboard_rust.csv".into());
    let files = std::env::args().nth(3).unwrap_or_else(|| "checkerboard_rust".into());
    if window < 2 {
        eprintln!("at least 2 points along the window are needed");
        return ExitCode::FAILURE;
    }
    let board = match run(window, &files) {
        Ok(board) => board,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_profile(&profile, &board) {
        eprintln!("cannot write {profile}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What one formulation makes of the checkerboard, in J/m3.
pub struct Cost {
    /// Strain energy density at the point in the middle.
    pub middle: f64,
    /// Its least value in the window.
    pub least: f64,
    /// Its greatest value in the window.
    pub greatest: f64,
    /// What the penalty stores at the point in the middle.
    pub penalty: f64,
    /// Strain energy density on the line through the middle, from face to face.
    pub profile: Vec<f64>,
}

/// What the checkerboard gives.
pub struct Board {
    /// In the order of `FORMS`.
    pub costs: Vec<Cost>,
    /// A fingerprint of all energies.
    pub hash: u64,
}

/// The whole comparison; files are named after `files`, and not written if it is empty.
pub fn run(window: usize, files: &str) -> Result<Board> {
    let size = window + 2 * BUFFER;
    let half = size / 2;

    // The points: a block that is shifted by half a spacing, so that coordinates are whole spacings.
    let face = -(half as f64 + 0.5) * SPACING;
    let edge = size as f64 * SPACING;
    let points = Points::block(3, &[face; 3], &[face + edge; 3], SPACING)?;
    println!("{} points, {window} along the window", points.count());

    // The displacement: each component alternates along the other two axes.
    let wave = |x: f64| (PI * x / SPACING).cos();
    let displacement: Vec<f64> = points
        .coordinates()
        .chunks_exact(3)
        .flat_map(|place| {
            let [x, y, z] = [wave(place[0]), wave(place[1]), wave(place[2])];
            [AMPLITUDE * y * z, AMPLITUDE * x * z, AMPLITUDE * x * y]
        })
        .collect();

    println!("strain energy density in the window (kJ/m3)                     penalty");
    println!("                                          middle     least  greatest    middle");
    let (mut costs, mut hash) = (Vec::new(), 0);
    for (formulation, influence) in FORMS {
        let mut steel = Model::new(formulation)?;
        steel.set("youngs_modulus", 210e9)?; // Pa
        steel.set("density", 8000.0)?; // kg/m3
        steel.set("horizon", HORIZON)?;
        // Bonds alone have Poisson's ratio 1/4, and no influence function.
        if !influence.is_empty() {
            steel.set("poissons_ratio", 0.25)?;
            steel.choose("influence", influence)?;
        }

        let mut body = Simulation::new(&points, &steel)?;
        body.set(Field::Displacement, &displacement)?;
        let energy = body.get(Field::StrainEnergyDensity)?;
        let penalty = body.get(Field::StabilizationEnergyDensity)?;
        if !files.is_empty() {
            let joint = if influence.is_empty() { "" } else { "_" };
            let path = format!("{files}_{formulation}{joint}{influence}.vtu");
            let fields = [
                Field::StrainEnergyDensity,
                Field::StabilizationEnergyDensity,
                Field::Displacement,
            ];
            body.write_vtk(&path, &fields)?;
        }

        // x runs fastest in a block of points, then y.
        let at = |x: usize, y: usize, z: usize| x + size * (y + size * z);
        let inside = || BUFFER..BUFFER + window;
        let (mut least, mut greatest) = (f64::INFINITY, 0.0_f64);
        for z in inside() {
            for y in inside() {
                for x in inside() {
                    least = least.min(energy[at(x, y, z)]);
                    greatest = greatest.max(energy[at(x, y, z)]);
                }
            }
        }
        let cost = Cost {
            middle: energy[at(half, half, half)],
            least,
            greatest,
            penalty: penalty[at(half, half, half)],
            profile: (0..size).map(|x| energy[at(x, half, half)]).collect(),
        };
        println!(
            "{formulation:<26} {influence:<12}{:9.4} {:9.4} {:9.4} {:9.4}",
            1e-3 * cost.middle,
            1e-3 * cost.least,
            1e-3 * cost.greatest,
            1e-3 * cost.penalty
        );
        costs.push(cost);
        hash = hash_values(hash, &energy);
        hash = hash_values(hash, &penalty);
    }
    println!("hash            {hash:010X}");
    Ok(Board { costs, hash })
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// A row for each point on the line through the middle and a column for each formulation; the first line
/// names them.
pub fn write_profile(path: &str, board: &Board) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let mut text = String::from("x (m)");
    for (formulation, influence) in FORMS {
        text += &format!(",{formulation} {influence} (kJ/m3)");
    }
    text += "\n";
    let size = board.costs[0].profile.len();
    for point in 0..size {
        let x = (point as f64 - (size / 2) as f64) * SPACING;
        text += &format!("{x:8.4}");
        for cost in &board.costs {
            text += &format!(",{:11.5}", 1e-3 * cost.profile[point]);
        }
        text += "\n";
    }
    std::fs::write(path, text)
}
