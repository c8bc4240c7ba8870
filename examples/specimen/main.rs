//! A tensile test: a flat specimen of PMMA with a hole in its middle is pulled until it breaks.
//!
//! The specimen is 120 mm long, 3 mm thick and 12 mm wide where it is narrow; its mesh was written by
//! Gmsh. One grip is held and the other is pulled at 0.5 m/s, slowly enough for the specimen to stay in
//! balance until it breaks beside the hole.
//!
//! `cargo run --release --example specimen -- [mesh, examples/specimen/specimen.msh]
//! [curve, specimen_rust.csv] [output file, specimen_rust.pvd]`, and for a picture
//! `cargo run --release --example picture -- specimen_rust.csv curve.png --curve`
//!
//! In order: points and sets from the mesh, model, simulation, conditions, step, results. Perion takes
//! any units that fit together: here mm, ms and g, and so m/s, N, MPa and mJ. The same program stands
//! beside this one in C and in Fortran; all three print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::process::ExitCode;

use perion::{Field, Model, Points, Quantity, Result, Simulation};

fn main() -> ExitCode {
    let argument = |number, default: &str| std::env::args().nth(number).unwrap_or(default.into());
    let mesh = argument(1, "examples/specimen/specimen.msh");
    let curve = argument(2, "specimen_rust.csv");
    let series = argument(3, "specimen_rust.pvd");
    let test = match run(&mesh, &series) {
        Ok(test) => test,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_curve(&curve, &test.records) {
        eprintln!("cannot write {curve}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What is recorded 200 times in the test.
pub struct Record {
    /// How far the right grip has come, mm.
    pub displacement: f64,
    /// On the right grip, N.
    pub force: f64,
    /// On the left grip, N: the same backwards, as long as the specimen is in balance.
    pub left_force: f64,
    /// Kinetic over elastic energy: small, as long as the specimen is in balance.
    pub kinetic_share: f64,
    /// Spent on broken bonds, mJ.
    pub dissipated: f64,
}

/// What the test gives.
pub struct Outcome {
    /// In the order of time.
    pub records: Vec<Record>,
    /// The last record before the first bond breaks.
    pub intact: usize,
    /// The record of the greatest force.
    pub peak: usize,
    /// N/mm.
    pub stiffness: f64,
    /// As the test leaves it.
    pub specimen: Simulation,
    /// A fingerprint of the last state.
    pub hash: u64,
}

/// The whole test; an empty name writes no files.
pub fn run(mesh: &str, series: &str) -> Result<Outcome> {
    let thickness = 3.0; // mm
    let (speed, ramp, end_time) = (0.5, 0.3, 0.72); // mm/ms, ms, ms
    let records: u64 = 200;

    // The points: one for each element of the mesh, with its area, at its centroid. The mesh names the
    // elements in the grips; the sets of their points have these names.
    let points = Points::read(mesh)?;
    let area: f64 = points.volumes().iter().sum();
    let spacing = (area / points.count() as f64).sqrt();

    // The material: PMMA, which breaks without yielding. In plane stress bond-based peridynamics has a
    // Poisson's ratio of 1/3, which is near to that of PMMA.
    let mut pmma = Model::new("bond_based")?;
    pmma.choose("plane", "stress")?;
    pmma.set("thickness", thickness)?;
    pmma.set("youngs_modulus", 3200.0)?; // MPa
    pmma.set("density", 1.18e-3)?; // g/mm3
    pmma.set("horizon", 3.0 * spacing)?;
    pmma.set("critical_energy_release_rate", 0.5)?; // N/mm

    let mut simulation = Simulation::new(&points, &pmma)?;

    // The left grip is held, the right one is pulled. Its speed grows smoothly, so that the specimen
    // is not struck: a table of times and velocities.
    let times = [0.0, 0.25 * ramp, 0.5 * ramp, 0.75 * ramp, ramp];
    let speeds = [0.0, 0.15625 * speed, 0.5 * speed, 0.84375 * speed, speed];
    simulation.prescribe("left_grip", Quantity::Velocity, 0, 0.0)?;
    simulation.prescribe("left_grip", Quantity::Velocity, 1, 0.0)?;
    simulation.prescribe_table("right_grip", Quantity::Velocity, 0, &times, &speeds)?;
    simulation.prescribe("right_grip", Quantity::Velocity, 1, 0.0)?;
    simulation.forbid_failure("left_grip")?;
    simulation.forbid_failure("right_grip")?;

    // Stepping, with a look at the specimen 200 times: how far its right grip has come, and the force
    // on it, which is the sum of what holds its points.
    let interval = end_time / records as f64;
    let steps = (interval / (0.5 * simulation.stable_time_step()?)).ceil();
    let time_step = interval / steps;
    println!("{} points, {spacing:.4} mm apart", points.count());
    println!("{} steps of {:.4} us", records * steps as u64, 1e3 * time_step);
    println!("   time us  displacement mm    force N");
    let grip_points = points.set_size("right_grip")? as f64;
    let mut curve = Vec::new();
    for number in 1..=records {
        simulation.step(time_step, steps as u64)?;
        let sum = |field, set| simulation.sum(field, Some(set)).map(|components| components[0]);
        let energy = simulation.energy()?;
        let record = Record {
            displacement: sum(Field::Displacement, "right_grip")? / grip_points,
            force: sum(Field::Reaction, "right_grip")?,
            left_force: sum(Field::Reaction, "left_grip")?,
            kinetic_share: energy.kinetic / energy.elastic,
            dissipated: energy.dissipated,
        };
        if number % 10 == 0 {
            let time = 1e3 * simulation.time();
            println!("{time:10.1} {:16.4} {:10.2}", record.displacement, record.force);
            write(&simulation, series)?;
        }
        curve.push(record);
    }

    // Results. The stiffness is the slope of the line through the origin that fits the first half of
    // the way to the greatest force.
    let (mut intact, mut peak, mut products, mut squares) = (0, 0, 0.0, 0.0);
    for (number, record) in curve.iter().enumerate() {
        if record.dissipated == 0.0 {
            intact = number;
        }
        if record.force > curve[peak].force {
            peak = number;
        }
    }
    for record in &curve {
        if record.displacement < 0.5 * curve[peak].displacement {
            products += record.force * record.displacement;
            squares += record.displacement * record.displacement;
        }
    }
    let stiffness = products / squares;
    let (energy, health) = (simulation.energy()?, simulation.health()?);
    let closure_error = energy.closure_error / energy.external_work;
    println!("stiffness       {stiffness:10.2} N/mm");
    println!("intact up to    {:10.4} mm", curve[intact].displacement);
    println!("  force         {:10.2} N", curve[intact].force);
    println!("  left grip     {:10.2} N", curve[intact].left_force);
    println!(
        "  kinetic       {:10.4} % of the elastic energy",
        100.0 * curve[intact].kinetic_share
    );
    println!("greatest force  {:10.2} N", curve[peak].force);
    println!("  displacement  {:10.4} mm", curve[peak].displacement);
    println!("broken bonds    {:10} of {}", health.broken_bonds, health.bonds);
    println!("external work   {:10.4} mJ", energy.external_work);
    println!("kinetic energy  {:10.4} mJ", energy.kinetic);
    println!("elastic energy  {:10.4} mJ", energy.elastic);
    println!("dissipated      {:10.4} mJ", energy.dissipated);
    println!("closure error   {:10.4} % of the work", 100.0 * closure_error);
    let mut hash = 0;
    for field in [Field::Displacement, Field::Velocity, Field::Damage] {
        hash = hash_values(hash, &simulation.get(field)?);
    }
    println!("hash            {hash:010X}");
    Ok(Outcome { records: curve, intact, peak, stiffness, specimen: simulation, hash })
}

fn write(simulation: &Simulation, series: &str) -> Result<()> {
    if series.is_empty() {
        return Ok(());
    }
    simulation
        .write_series(series, &[Field::Damage, Field::Displacement, Field::StrainEnergyDensity])
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// The curve of force over displacement, with the names of its axes in the first line.
pub fn write_curve(path: &str, records: &[Record]) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let mut text = format!("displacement (mm),force (N)\n{:10.6},{:12.4}\n", 0.0, 0.0);
    for record in records {
        text += &format!("{:10.6},{:12.4}\n", record.displacement, record.force);
    }
    std::fs::write(path, text)
}
