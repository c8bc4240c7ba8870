//! A material of the host's own: a viscoelastic bar is stretched and held, and its force relaxes.
//!
//! The law is a standard linear solid. Beside Saint Venant and Kirchhoff's stress S(E) a second one, Q,
//! grows with it and fades: dQ/dt = g dS/dt - Q/tau. Q is what the material remembers: 6 numbers at each
//! point. All of its stress fades alike, so that equilibrium stays where it is while the bar is held, and
//! the force follows exp(-t/tau) whatever the shape of the body.
//!
//! `cargo run --release --example own_material -- [points along the bar, 20]
//! [output file, own_material_rust.csv]`, and for a picture
//! `cargo run --release --example picture -- own_material_rust.csv curve.png --curve`
//!
//! A law is told deformations, not the time between them: the host, which chooses the time step, tells it
//! that. While it only looks, no time passes. Units are mm, ms and g, and so MPa, N and mJ. The same
//! program stands beside this one in C and in Fortran; all three print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use perion::{Energy, Field, MaterialBatch, Model, Points, Quantity, Result, Simulation};

const RECORDS: usize = 240;
const STATE: usize = 6;

fn main() -> ExitCode {
    let along = std::env::args().nth(1).unwrap_or_else(|| "20".into()).parse().unwrap_or(0);
    let curve = std::env::args().nth(2).unwrap_or_else(|| "own_material_rust.csv".into());
    if along < 10 {
        eprintln!("at least 10 points along the bar are needed");
        return ExitCode::FAILURE;
    }
    let outcome = match run(along) {
        Ok(outcome) => outcome,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_curve(&curve, &outcome) {
        eprintln!("cannot write {curve}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What the bar gives.
pub struct Outcome {
    /// Time between records, ms.
    pub interval: f64,
    /// On the right grip, N, record after record.
    pub forces: Vec<f64>,
    /// The closed form, once the bar is held, N.
    pub expected: Vec<f64>,
    /// Force of the elastic bar, N.
    pub bearing: f64,
    /// Largest deviation from the closed form, as a share of that.
    pub worst: f64,
    /// As the hold leaves it, mJ.
    pub energy: Energy,
    /// A fingerprint of the last state.
    pub hash: u64,
}

/// The law: stiffness when all has faded, how much more there is at first, and how long it takes.
struct Solid {
    /// MPa.
    lambda: f64,
    mu: f64,
    /// g.
    share: f64,
    /// tau, ms.
    relaxation_time: f64,
    /// Bits of the time, ms, from the last completed step to the one asked about; 0: none.
    time_step: AtomicU64,
}

/// Where a symmetric tensor has its components: 11, 22, 33, 23, 13, 12.
const PLACES: [(usize, usize); STATE] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

impl Solid {
    fn set_time_step(&self, time_step: f64) {
        self.time_step.store(time_step.to_bits(), Ordering::Relaxed);
    }

    /// Energy and second Piola-Kirchhoff stress of Saint Venant and Kirchhoff.
    fn elastic(&self, f: &[f64]) -> (f64, [f64; STATE]) {
        let mut strain = [0.0; STATE];
        let mut squares = 0.0;
        for (c, (row, column)) in PLACES.into_iter().enumerate() {
            let mut product = 0.0;
            for k in 0..3 {
                product += f[3 * k + row] * f[3 * k + column];
            }
            strain[c] = 0.5 * (product - if c < 3 { 1.0 } else { 0.0 });
            squares += if c < 3 { 1.0 } else { 2.0 } * strain[c] * strain[c];
        }
        let trace = strain[0] + strain[1] + strain[2];
        let mut stress = [0.0; STATE];
        for (c, stress) in stress.iter_mut().enumerate() {
            *stress = 2.0 * self.mu * strain[c] + if c < 3 { self.lambda * trace } else { 0.0 };
        }
        (0.5 * self.lambda * trace * trace + self.mu * squares, stress)
    }

    /// The energy in the springs of Q: half of Q on the strain that C makes of it, over g.
    fn fading_energy(&self, q: &[f64]) -> f64 {
        let trace = q[0] + q[1] + q[2];
        let mut squares = 0.0;
        for (c, q) in q.iter().enumerate() {
            squares += if c < 3 { 1.0 } else { 2.0 } * q * q;
        }
        (squares - self.lambda / (3.0 * self.lambda + 2.0 * self.mu) * trace * trace)
            / (4.0 * self.mu * self.share)
    }

    /// Answers deformation gradients: by the trapezoidal rule over a step.
    fn answer(&self, batch: &mut MaterialBatch<'_>) {
        let time_step = f64::from_bits(self.time_step.load(Ordering::Relaxed));
        let half = 0.5 * time_step / self.relaxation_time;
        for place in 0..batch.count {
            let (tensor, own) = (9 * place..9 * place + 9, STATE * place..STATE * (place + 1));
            let f = &batch.now[tensor.clone()];
            let (old, q) = (&batch.state_before[own.clone()], &mut batch.state[own]);
            let (_, before) = self.elastic(&batch.before[tensor.clone()]);
            let (energy, stress) = self.elastic(f);
            let mut whole = [0.0; 9];
            for (c, (row, column)) in PLACES.into_iter().enumerate() {
                q[c] =
                    ((1.0 - half) * old[c] + self.share * (stress[c] - before[c])) / (1.0 + half);
                whole[3 * row + column] = stress[c] + q[c];
                whole[3 * column + row] = stress[c] + q[c];
            }
            batch.energy[place] = energy + self.fading_energy(q);
            let first_piola = &mut batch.stress[tensor];
            for i in 0..3 {
                for j in 0..3 {
                    let mut sum = 0.0;
                    for k in 0..3 {
                        sum += f[3 * i + k] * whole[3 * k + j];
                    }
                    first_piola[3 * i + j] = sum;
                }
            }
        }
    }
}

/// The whole run.
pub fn run(along: usize) -> Result<Outcome> {
    let (density, modulus, ratio) = (1.2e-3, 1000.0, 0.3); // g/mm3, MPa
    let (share, relaxation_time) = (1.0, 0.5); // ms
    let (ramp, end_time) = (0.5, 2.0); // ms
    let (across, grip, strain) = (4.0, 2.0, 0.01); // mm, mm

    // The points: a block with a grip at each end.
    let length = along as f64;
    let (lower, upper) = ([0.0; 3], [length, across, across]);
    let mut points = Points::block(3, &lower, &upper, 1.0)?;
    points.add_set_box("left", &lower, &[grip, across, across])?;
    points.add_set_box("right", &[length - grip, 0.0, 0.0], &upper)?;

    // The material: a formulation that asks a law at its points, and the law. The library itself needs the
    // constants, too.
    let mu = modulus / (2.0 * (1.0 + ratio));
    let lambda = 2.0 * mu * ratio / (1.0 - 2.0 * ratio);
    let own = Arc::new(Solid { lambda, mu, share, relaxation_time, time_step: AtomicU64::new(0) });
    let asked = Arc::clone(&own);
    let mut model = Model::new("correspondence")?;
    model.set("density", density)?;
    model.set("youngs_modulus", modulus)?;
    model.set("poissons_ratio", ratio)?;
    model.set("horizon", 2.1)?;
    model.set_material_function(STATE, move |batch: &mut MaterialBatch<'_>| {
        asked.answer(batch);
        ControlFlow::Continue(())
    })?;
    let mut bar = Simulation::new(&points, &model)?;

    // The right grip starts and stops smoothly: its velocity is a triangle over time.
    let pull = strain * (length - 2.0 * grip);
    let (times, speeds) = ([0.0, 0.5 * ramp, ramp], [0.0, 2.0 * pull / ramp, 0.0]);
    bar.prescribe("left", Quantity::Displacement, 0, 0.0)?;
    bar.prescribe_table("right", Quantity::Velocity, 0, &times, &speeds)?;

    // No time has passed yet: the law is at its stiffest. From then on it knows the step.
    let interval = end_time / RECORDS as f64;
    let steps = (interval / (0.9 * bar.stable_time_step()?)).ceil();
    println!(
        "{} points, {} steps of {:.4} us",
        points.count(),
        steps as usize * RECORDS,
        1e3 * interval / steps
    );
    own.set_time_step(interval / steps);
    let mut forces = vec![0.0];
    for _ in 0..RECORDS {
        bar.step(interval / steps, steps as u64)?;
        forces.push(bar.sum(Field::Reaction, Some("right"))?[0]);
    }
    own.set_time_step(0.0);

    // Results: while the bar is held, its force is that of the elastic bar times 1 + g c exp(-t/tau), where
    // c is what the pull has left of Q. The last record says what the elastic bar bears.
    let x = 0.5 * ramp / relaxation_time;
    let left_over = share * ((1.0 - (-x).exp()) / x).powi(2);
    let faded = 1.0 + left_over * ((ramp - end_time) / relaxation_time).exp();
    let bearing = forces[RECORDS] / faded;
    let held = (ramp / interval + 0.5) as usize;
    let mut expected = forces.clone();
    let mut worst = 0.0_f64;
    for (record, expected) in expected.iter_mut().enumerate().skip(held) {
        let since = interval * record as f64 - ramp;
        *expected = bearing * (1.0 + left_over * (-since / relaxation_time).exp());
        worst = worst.max((forces[record] - *expected).abs() / bearing);
    }
    let energy = bar.energy()?;
    println!("force at first  {:10.4} N", forces[held]);
    println!("force at last   {:10.4} N", forces[RECORDS]);
    println!("E A strain      {:10.4} N", modulus * across * across * strain);
    println!("off exp(-t/tau) {:10.4} %", 100.0 * worst);
    println!("work            {:10.4} mJ", energy.external_work);
    println!("stored          {:10.4} mJ", energy.elastic);
    // What the dashpots took is not known to the library: to it that is energy that went missing.
    println!("in the dashpots {:10.4} mJ", -energy.closure_error);
    let mut hash = 0;
    for field in [Field::Displacement, Field::Velocity] {
        hash = hash_values(hash, &bar.get(field)?);
    }
    println!("hash            {hash:010X}");
    Ok(Outcome { interval, forces, expected, bearing, worst, energy, hash })
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// Time, force and closed form of each record.
pub fn write_curve(path: &str, outcome: &Outcome) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let mut text = String::from("time (ms),force (N),closed form (N)\n");
    for (record, (force, expected)) in outcome.forces.iter().zip(&outcome.expected).enumerate() {
        let time = outcome.interval * record as f64;
        text += &format!("{time:8.4},{force:9.4},{expected:9.4}\n");
    }
    std::fs::write(path, text)
}
