//! A plate of glass cracks and branches: the boundary tension test of Partmann et al. 2026, section 5.3.
//!
//! A plate of 100 x 40 x 4 mm has a crack from its left edge to its centre. At time 0 a tension of
//! 1 MPa is put on its upper and lower edge and held. The crack starts to run and splits in two.
//!
//! `cargo run --release --example branching -- [points along the plate, 200] [output file,
//! branching_rust.pvd]`
//!
//! What a host program does with Perion, in order: points, sets, model, simulation, conditions, step,
//! results. The same program stands beside this one in C and in Fortran; all three print the same
//! hash, because the results are the same to the last bit.

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Instant;

use perion::{Field, Model, Points, Progress, Quantity, Result, Simulation};

fn main() -> ExitCode {
    let along = std::env::args().nth(1).unwrap_or_else(|| "200".into()).parse().unwrap_or(0);
    let series = std::env::args().nth(2).unwrap_or_else(|| "branching_rust.pvd".into());
    if along < 10 {
        eprintln!("at least 10 points along the plate are needed");
        return ExitCode::FAILURE;
    }
    match run(along, &series) {
        Ok(()) => ExitCode::SUCCESS,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// The whole test; an empty name writes no files.
pub fn run(along: u32, series: &str) -> Result<()> {
    let (length, height, depth) = (0.1, 0.04, 0.004); // metres
    let end_time = 50e-6; // seconds
    let traction = 1e6; // pascals

    // The points: a block, its lower left corner in the middle of the left edge. One layer of points
    // along the upper edge and one along the lower are named, to pull on them.
    let spacing = length / f64::from(along);
    let (lower, upper) = ([0.0, -height / 2.0, 0.0], [length, height / 2.0, depth]);
    let mut points = Points::block(3, &lower, &upper, spacing)?;
    points.add_set_box("top", &[0.0, height / 2.0 - spacing, 0.0], &upper)?;
    points.add_set_box("bottom", &lower, &[length, spacing - height / 2.0, depth])?;

    // The material: soda-lime glass. Bond-based peridynamics takes one elastic constant, since its
    // Poisson's ratio is 1/4. The energy release rate tells when bonds break.
    let mut glass = Model::new("bond_based")?;
    glass.set("youngs_modulus", 32e9)?;
    glass.set("density", 2440.0)?;
    glass.set("horizon", 3.015 * spacing)?;
    glass.set("critical_energy_release_rate", 0.75)?;

    let mut simulation = Simulation::new(&points, &glass)?;

    // The crack that is there from the start: a rectangle across which all bonds are broken.
    let middle = length / 2.0;
    let crack = [0.0, 0.0, 0.0, middle, 0.0, 0.0, middle, 0.0, depth, 0.0, 0.0, depth];
    simulation.break_crossing(&crack)?;

    // The tension, as a body force along the y axis on the named layers, whose bonds may not break.
    let body_force = traction / spacing;
    simulation.prescribe("top", Quantity::BodyForce, 1, body_force)?;
    simulation.prescribe("bottom", Quantity::BodyForce, 1, -body_force)?;
    simulation.forbid_failure("top")?;
    simulation.forbid_failure("bottom")?;

    // Stepping: the library knows a step that is stable, and half of it where cracks stretch bonds. It calls the
    // closure after each step, which may look at the simulation and write files, and can stop the run.
    let stable = simulation.stable_time_step()?;
    let steps = (end_time / (0.5 * stable)).ceil() as u64;
    let time_step = end_time / steps as f64;
    println!(
        "{} points, {steps} steps of {:6.4} us",
        points.count(),
        1e6 * end_time / steps as f64
    );
    let (start, mut shown, mut written) = (Instant::now(), 0, Ok(()));
    let ran = simulation.step_watched(time_step, steps, |simulation, made| {
        let twentieth = 20 * made.done / made.total;
        if twentieth != shown {
            shown = twentieth;
            written = write(simulation, series);
            if written.is_err() {
                return ControlFlow::Break(());
            }
            show(made, start);
        }
        ControlFlow::Continue(())
    });
    written?;
    ran?;

    // Results.
    let (energy, health) = (simulation.energy()?, simulation.health()?);
    println!("broken bonds    {} of {}", health.broken_bonds, health.bonds);
    println!("external work   {:10.6} mJ", 1e3 * energy.external_work);
    println!("kinetic energy  {:10.6} mJ", 1e3 * energy.kinetic);
    println!("elastic energy  {:10.6} mJ", 1e3 * energy.elastic);
    println!("dissipated      {:10.6} mJ", 1e3 * energy.dissipated);
    let closure_error = 1e2 * energy.closure_error / energy.external_work;
    println!("closure error   {closure_error:10.6} % of the work");
    let mut hash = 0;
    for field in [Field::Displacement, Field::Velocity, Field::Damage] {
        hash = hash_values(hash, &simulation.get(field)?);
    }
    println!("hash            {hash:010X}");
    Ok(())
}

fn write(simulation: &Simulation, series: &str) -> Result<()> {
    if series.is_empty() {
        return Ok(());
    }
    let fields = [Field::Damage, Field::Displacement, Field::Velocity, Field::StrainEnergyDensity];
    simulation.write_series(series, &fields)
}

fn show(Progress { done, total, time }: Progress, start: Instant) {
    let left = start.elapsed().as_secs_f64() * (total - done) as f64 / done as f64;
    println!("step {done:5} of {total}, {:5.1} us, {left:6.1} s left", 1e6 * time);
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}
