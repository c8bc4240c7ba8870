//! A bar is bent until its ends nearly touch: large displacements and rotations, as an elastica has them.
//!
//! After Partmann et al. 2026, section 4.5: a bar of 0.2 x 0.01 x 0.01 m, E = 2.3 GPa, nu = 1/4, 1600 kg/m3,
//! with a slight curvature, here an arc of radius 2 m, so that it bends and is not just pressed. The inner
//! edges of its two ends are moved towards each other, and the bar is free to rotate about them. The horizon
//! is 0.64 widths as in the paper, 5.15 spacings with 8 points across.
//!
//! The paper takes 0.2 s for it. The lowest mode of bending swings in 15 ms, and a pull that starts gently
//! leaves it nearly at rest in 0.03 s: the height of a bent bar grows as the square root of the way of its
//! ends, so the way begins as the fourth power of time.
//!
//! The stiffness against bending is that of the best of some displacements made by hand, which the bar itself
//! undercuts. It lies far below E I: a gradient averaged over families that the surface cuts is that of a
//! place further inside. The shape of an elastica is the same for any stiffness.
//!
//! `cargo run --release --example bend -- [points across, 4; 8 in the paper] [time in s, 0.03; 0.2 in the
//! paper] [curve, bend_rust.csv] [output file, bend_rust.pvd]`, and for pictures
//! `cargo run --release --example picture -- bend_rust.csv curve.png --curve` and
//! `cargo run --release --example picture -- bend_rust_000019.vtu bar.png --field von_mises_stress
//! --view 20 30`
//!
//! In order: points and sets, model, simulation, a state set by hand, conditions, step, results. Units are
//! m, s and kg. The same program stands beside this one in C and in Fortran; all three print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::process::ExitCode;

use perion::{Field, Model, Points, Quantity, Result, Simulation};

/// m
pub const LENGTH: f64 = 0.2;
/// m
pub const WIDTH: f64 = 0.01;
/// Of the arc, m.
pub const RADIUS: f64 = 2.0;
/// Between the edges at the end, m.
const GAP: f64 = 0.01;
/// Pa
const MODULUS: f64 = 2.3e9;

fn main() -> ExitCode {
    let argument = |number, default: &str| std::env::args().nth(number).unwrap_or(default.into());
    let across = argument(1, "4").parse().unwrap_or(0);
    let duration = argument(2, "0.03").parse().unwrap_or(0.0);
    let curve = argument(3, "bend_rust.csv");
    let series = argument(4, "bend_rust.pvd");
    if across < 3 || !(duration > 0.0 && duration <= 1.0) {
        eprintln!("at least 3 points across and a time of at most 1 s are needed");
        return ExitCode::FAILURE;
    }
    let bend = match run(across, duration, &series) {
        Ok(bend) => bend,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_curve(&curve, &bend.records) {
        eprintln!("cannot write {curve}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What is recorded 200 times.
pub struct Record {
    /// By which the edges have come together, m.
    pub shortening: f64,
    /// Of the axis of the bar in its middle, over the edges, m.
    pub height: f64,
    /// On one edge, towards the other, N.
    pub force: f64,
    /// J
    pub elastic: f64,
    /// Kinetic over elastic energy.
    pub kinetic_share: f64,
}

/// What the bar does.
pub struct Bend {
    /// In the order of time.
    pub records: Vec<Record>,
    /// Against bending, of the bar at most, and of its material, N m2.
    pub stiffness: (f64, f64),
    /// As the run leaves it.
    pub bar: Simulation,
    /// A fingerprint of the last state.
    pub hash: u64,
}

/// The whole run, in so many seconds.
pub fn run(across: usize, duration: f64, series: &str) -> Result<Bend> {
    let records: usize = 200;
    let spacing = WIDTH / across as f64;
    let points = arc(across)?;
    let coordinates = points.coordinates();
    let count = points.count();

    // The material: a polymer, of Saint Venant and Kirchhoff, the default.
    let mut polymer = Model::new("correspondence")?;
    polymer.set("youngs_modulus", MODULUS)?;
    polymer.set("poissons_ratio", 0.25)?;
    polymer.set("density", 1600.0)?; // kg/m3
    polymer.set("horizon", 5.15 / 8.0 * WIDTH)?;

    let mut bar = Simulation::new(&points, &polymer)?;

    // The stiffness against bending, from a small curvature: the energy of the section in the middle is
    // least for the contraction across that the bar takes, which in a thick bar is Poisson's ratio.
    let curvature = 1e-3; // 1/m
    let mut energy_of = |contraction: f64| -> Result<f64> {
        let mut displacement = coordinates.to_vec();
        for place in displacement.chunks_exact_mut(3) {
            let [x, y, z] = [place[0], place[1], place[2]];
            place.copy_from_slice(&[
                -curvature * x * y,
                0.5 * curvature * (x * x + contraction * (y * y - z * z)),
                curvature * contraction * y * z,
            ]);
        }
        bar.set(Field::Displacement, &displacement)?;
        Ok(bar.sum(Field::StrainEnergyDensity, Some("middle"))?[0] * spacing * spacing)
    };
    let (less, plain, more) = (energy_of(0.0)?, energy_of(0.25)?, energy_of(0.5)?);
    let (slope, bow) = (0.5 * (more - less), 0.5 * (more + less) - plain);
    let stiffness = 2.0 * (plain - slope * slope / (4.0 * bow)) / (curvature * curvature);
    let section = WIDTH * WIDTH;
    let material_stiffness = MODULUS * (section * section) / 12.0;
    bar.set(Field::Displacement, &vec![0.0; 3 * count])?;

    // The edges move along x alone, by a table of times and velocities: a cubic start, then a steady pull.
    let (left, middle) = (points.set("left")?, points.set("middle")?);
    let start = coordinates[3 * left[0]];
    let speed = (-start - 0.5 * GAP) / (0.60625 * duration);
    let times = [0.0, 0.1, 0.2, 0.3, 0.4, 0.8, 1.0].map(|share| share * duration);
    let shares = [0.0, 0.015625, 0.125, 0.421875, 1.0, 1.0, 0.0];
    for (edge, speed) in [("left", speed), ("right", -speed)] {
        let speeds = shares.map(|share| share * speed);
        bar.prescribe_table(edge, Quantity::Velocity, 0, &times, &speeds)?;
        bar.prescribe(edge, Quantity::Velocity, 1, 0.0)?;
    }

    // Stepping, with a look at the bar 200 times. A tenth of the step that is stable now is kept back, since
    // bonds on the outer side become stiffer.
    let interval = duration / records as f64;
    let steps = (interval / (0.9 * bar.stable_time_step()?)).ceil();
    println!(
        "{count} points, {} steps of {:.4} us",
        steps as usize * records,
        1e6 * interval / steps
    );
    println!("   time ms  shortening mm  height mm    force N  elastic J");
    let mut position = vec![0.0; 3 * count];
    let mut curve = Vec::new();
    for number in 1..=records {
        bar.step(interval / steps, steps as u64)?;
        bar.get_into(Field::Position, &mut position)?;
        let mean = |set: &[usize], axis: usize| {
            let sum: f64 = set.iter().map(|point| position[3 * point + axis]).sum();
            sum / set.len() as f64
        };
        let energy = bar.energy()?;
        let record = Record {
            shortening: 2.0 * (mean(&left, 0) - start),
            height: mean(&middle, 1) - mean(&left, 1),
            force: bar.sum(Field::Reaction, Some("left"))?[0],
            elastic: energy.elastic,
            kinetic_share: energy.kinetic / energy.elastic,
        };
        if number % 10 == 0 {
            println!(
                "{:10.3} {:14.4} {:10.4} {:10.3} {:10.5}",
                1e3 * bar.time(),
                1e3 * record.shortening,
                1e3 * record.height,
                record.force,
                record.elastic
            );
            write(&bar, series)?;
        }
        curve.push(record);
    }

    // Results.
    let end = &curve[records - 1];
    let (energy, health) = (bar.energy()?, bar.health()?);
    println!("stiffness below {stiffness:10.4} N m2");
    println!("  material      {material_stiffness:10.4} N m2");
    println!("shortening      {:10.4} mm", 1e3 * end.shortening);
    println!("height          {:10.4} mm", 1e3 * end.height);
    println!("force           {:10.3} N", end.force);
    println!("least stretch   {:10.5}", health.smallest_stretch);
    println!("kinetic energy  {:10.4} % of the elastic energy", 100.0 * end.kinetic_share);
    println!(
        "closure error   {:10.4} % of the work",
        100.0 * energy.closure_error / energy.external_work
    );
    let mut hash = 0;
    for field in [Field::Displacement, Field::Velocity] {
        hash = hash_values(hash, &bar.get(field)?);
    }
    println!("hash            {hash:010X}");
    Ok(Bend { records: curve, stiffness: (stiffness, material_stiffness), bar, hash })
}

/// The points: a lattice laid along an arc, one row after the other, with its middle uppermost. The lower
/// edges of its ends are named, and its section in the middle.
fn arc(across: usize) -> Result<Points> {
    let along = 20 * across;
    let spacing = WIDTH / across as f64;
    let (mut coordinates, mut volumes) = (Vec::new(), Vec::new());
    let (mut left, mut right, mut middle) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..across {
        for j in 0..across {
            let y = (j as f64 + 0.5) * spacing - 0.5 * WIDTH;
            let z = (k as f64 + 0.5) * spacing - 0.5 * WIDTH;
            let row = volumes.len();
            if j == 0 {
                left.push(row);
                right.push(row + along - 1);
            }
            middle.push(row + along / 2);
            for i in 0..along {
                let angle = ((i as f64 + 0.5) * spacing - 0.5 * LENGTH) / RADIUS;
                let radius = RADIUS + y;
                coordinates.extend([radius * angle.sin(), radius * angle.cos() - RADIUS, z]);
                volumes.push(spacing * spacing * spacing * (radius / RADIUS));
            }
        }
    }
    let mut points = Points::new(3, &coordinates, &volumes)?;
    points.add_set("left", &left)?;
    points.add_set("right", &right)?;
    points.add_set("middle", &middle)?;
    Ok(points)
}

fn write(bar: &Simulation, series: &str) -> Result<()> {
    if series.is_empty() {
        return Ok(());
    }
    let fields = [Field::Displacement, Field::VonMisesStress, Field::StrainEnergyDensity];
    bar.write_series(series, &fields)
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// The curve of the height over the shortening, then the force, with the names of its columns in the first
/// line.
pub fn write_curve(path: &str, records: &[Record]) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let mut text = String::from("shortening (mm),height (mm),force (N)\n");
    for record in records {
        text += &format!(
            "{:10.4},{:10.4},{:11.3}\n",
            1e3 * record.shortening,
            1e3 * record.height,
            record.force
        );
    }
    std::fs::write(path, text)
}
