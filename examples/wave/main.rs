//! A wave in a bar: one end of a steel bar is struck, and the front runs at the speed of theory.
//!
//! The bar has 20 x 20 points across, 1 mm apart. Its end is brought to 1 m/s and kept at it. A front
//! that is long against the width of the bar runs at sqrt(E/rho). This E is measured on the bar itself,
//! as the energy that it takes to stretch it: points near the surface lack bonds, which makes a thin
//! bar softer than its material.
//!
//! `cargo run --release --example wave -- [points along the bar, 200] [output file, wave_rust.csv]`,
//! and for a picture `cargo run --release --example picture -- wave_rust.csv wave.png --map --range 0 2`
//!
//! In order: points and sets, model, simulation, a state set by hand, conditions, step, results. Units
//! are mm, ms and g, and so m/s, MPa and mJ. The same program stands beside this one in C and in
//! Fortran; all three print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::process::ExitCode;

use perion::{Field, Model, Points, Quantity, Result, Simulation};

fn main() -> ExitCode {
    let along = std::env::args().nth(1).unwrap_or_else(|| "200".into()).parse().unwrap_or(0);
    let matrix = std::env::args().nth(2).unwrap_or_else(|| "wave_rust.csv".into());
    if along < 50 {
        eprintln!("at least 50 points along the bar are needed");
        return ExitCode::FAILURE;
    }
    let wave = match run(along, 40.0) {
        Ok(wave) => wave,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_matrix(&matrix, &wave) {
        eprintln!("cannot write {matrix}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What the wave gives.
pub struct Wave {
    /// Time between records, ms.
    pub interval: f64,
    /// The mean axial velocity of each cross-section, record after record, mm/ms.
    pub velocities: Vec<Vec<f64>>,
    /// Of the front, mm/ms.
    pub speed: f64,
    /// sqrt(E/rho) with the modulus of this bar, mm/ms.
    pub expected: f64,
    /// As the wave leaves it.
    pub bar: Simulation,
    /// A fingerprint of the last state.
    pub hash: u64,
}

/// The whole run, with a front that is `rise` mm long.
pub fn run(along: usize, rise: f64) -> Result<Wave> {
    let (spacing, across) = (1.0, 20.0); // mm
    let (density, modulus) = (7.8e-3, 210e3); // g/mm3, MPa
    let speed = 1.0; // mm/ms
    let records: usize = 200;

    // The points: a block, its axis the x axis. Its first layers are named, to strike them.
    let length = along as f64 * spacing;
    let (lower, upper) =
        ([0.0, -across / 2.0, -across / 2.0], [length, across / 2.0, across / 2.0]);
    let mut points = Points::block(3, &lower, &upper, spacing)?;
    points.add_set_box("struck", &lower, &[3.0 * spacing, across / 2.0, across / 2.0])?;
    let count = points.count();

    // The material: steel that does not break.
    let mut steel = Model::new("bond_based")?;
    steel.set("youngs_modulus", modulus)?;
    steel.set("density", density)?;
    steel.set("horizon", 3.015 * spacing)?;

    let mut bar = Simulation::new(&points, &steel)?;

    // The modulus of the bar: it is stretched by hand, and narrows by Poisson's ratio 1/4 of that. Its
    // energy is 1/2 E stretch^2 volume. Then it is let go.
    let stretch = 1e-5;
    let strain = [stretch, -0.25 * stretch, -0.25 * stretch];
    let mut displacement = points.coordinates().to_vec();
    for point in displacement.chunks_exact_mut(3) {
        for (component, strain) in point.iter_mut().zip(strain) {
            *component *= strain;
        }
    }
    bar.set(Field::Displacement, &displacement)?;
    let volume = bar.sum(Field::Volume, None)?[0];
    let bar_modulus = 2.0 * bar.energy()?.elastic / (stretch * stretch * volume);
    bar.set(Field::Displacement, &vec![0.0; 3 * count])?;
    let expected = (bar_modulus / density).sqrt();

    // The blow: the velocity of the first layers grows smoothly, by a table of times and velocities.
    let ramp = rise / expected;
    let times = [0.0, 0.25 * ramp, 0.5 * ramp, 0.75 * ramp, ramp];
    let speeds = [0.0, 0.15625 * speed, 0.5 * speed, 0.84375 * speed, speed];
    bar.prescribe_table("struck", Quantity::Velocity, 0, &times, &speeds)?;

    // Stepping, until the front has been reflected at the far end. 200 times on the way the mean axial
    // velocity of each cross-section is taken: x runs fastest in a block of points.
    let end_time = (1.5 * length + rise) / expected;
    let interval = end_time / records as f64;
    let steps = (interval / (0.5 * bar.stable_time_step()?)).ceil();
    println!(
        "{count} points, {} steps of {:.4} us",
        steps as usize * records,
        1e3 * interval / steps
    );
    let mut velocity = vec![0.0; 3 * count];
    let mut velocities = vec![vec![0.0; along]];
    for _ in 0..records {
        bar.step(interval / steps, steps as u64)?;
        bar.get_into(Field::Velocity, &mut velocity)?;
        let mut means = vec![0.0; along];
        for row in velocity.chunks_exact(3 * along) {
            for (mean, point) in means.iter_mut().zip(row.chunks_exact(3)) {
                *mean += point[0] / (across * across);
            }
        }
        velocities.push(means);
    }

    // Results: the front is where half the speed of the blow is first reached.
    let passing = |column: usize| {
        let after =
            velocities.iter().position(|means| means[column] >= 0.5 * speed).unwrap_or(records);
        let (early, late) = (velocities[after - 1][column], velocities[after][column]);
        interval * (after as f64 - (late - 0.5 * speed) / (late - early))
    };
    let stations = [3 * along / 10, 7 * along / 10];
    let [near, far] = stations.map(passing);
    let measured = (stations[1] - stations[0]) as f64 * spacing / (far - near);
    let energy = bar.energy()?;
    let closure_error = energy.closure_error / energy.external_work;
    println!("modulus         {:10.4} GPa", 1e-3 * bar_modulus);
    println!("sqrt(E/rho)     {expected:10.2} m/s");
    println!("front passes    {:10.4} us at {} mm", 1e3 * near, stations[0]);
    println!("                {:10.4} us at {} mm", 1e3 * far, stations[1]);
    println!("its speed       {measured:10.2} m/s");
    println!("deviation       {:10.2} %", 100.0 * (measured / expected - 1.0));
    println!("closure error   {:10.4} % of the work", 100.0 * closure_error);
    let mut hash = 0;
    for field in [Field::Displacement, Field::Velocity] {
        hash = hash_values(hash, &bar.get(field)?);
    }
    println!("hash            {hash:010X}");
    Ok(Wave { interval, velocities, speed: measured, expected, bar, hash })
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// A row for each record and a column for each cross-section; the first line tells what they are.
pub fn write_matrix(path: &str, wave: &Wave) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let last_place = wave.velocities[0].len() as f64 - 0.5;
    let last_time = 1e3 * wave.interval * (wave.velocities.len() - 1) as f64;
    let mut text = format!(
        "x (mm),{:8.1},{last_place:8.1},t (us),{:8.4},{last_time:8.4},axial velocity (m/s)\n",
        0.5, 0.0
    );
    for means in &wave.velocities {
        let row: Vec<String> = means.iter().map(|mean| format!("{mean:8.4}")).collect();
        text += &(row.join(",") + "\n");
    }
    std::fs::write(path, text)
}
