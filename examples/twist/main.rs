//! A bar is set spinning about its axis and twists by more than half a turn: large rotations without drift.
//!
//! After Partmann et al. 2026, section 4.5: a bar of 0.1 x 0.1 x 1 m, held at its lower end, starts with a
//! spin about its axis that grows from 0 at the held end to 150 1/s at the free one, along a quarter of a
//! sine. That is the lowest mode of torsion. The law of Saint Venant and Kirchhoff knows rotations, so
//! nothing else is needed for them, and correspondence stays calm as long as the motion is smooth.
//!
//! The paper names neither the material nor the end. Steel would turn by two degrees; here it is a soft
//! rubber, E = 2.5 MPa, nu = 1/4, 1000 kg/m3, which turns by more than half a turn. The run ends after half
//! a period, when the bar is back. The angle in equation 4.58 is taken to go all the way round.
//!
//! The stiffness against torsion is measured on the bar itself, as the energy that it takes to twist it: a
//! gradient averaged over families that the surface cuts is that of a place further inside, and so a bar of
//! few horizons is much softer than its material.
//!
//! `cargo run --release --example twist -- [points across, 6; 30 in the paper] [curve, twist_rust.csv]
//! [output file, twist_rust.pvd]`, and for pictures
//! `cargo run --release --example picture -- twist_rust.csv curve.png --curve` and
//! `cargo run --release --example picture -- twist_rust_000010.vtu bar.png --field reference_position.x
//! --view 30 25 --right z`
//!
//! In order: points and sets, model, simulation, a state set by hand, conditions, step, results. Units are
//! m, s and kg. The same program stands beside this one in C and in Fortran; all three print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::f64::consts::PI;
use std::process::ExitCode;

use perion::{Field, Model, Points, Quantity, Result, Simulation};

fn main() -> ExitCode {
    let across = std::env::args().nth(1).unwrap_or_else(|| "6".into()).parse().unwrap_or(0);
    let curve = std::env::args().nth(2).unwrap_or_else(|| "twist_rust.csv".into());
    let series = std::env::args().nth(3).unwrap_or_else(|| "twist_rust.pvd".into());
    if across < 4 {
        eprintln!("at least 4 points across are needed");
        return ExitCode::FAILURE;
    }
    let twist = match run(across, 150.0, &series) {
        Ok(twist) => twist,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_curve(&curve, &twist.records) {
        eprintln!("cannot write {curve}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What is recorded 200 times.
pub struct Record {
    /// s
    pub time: f64,
    /// By which the free end has turned, rad.
    pub angle: f64,
    /// Kinetic and elastic energy over what the bar was given, less 1.
    pub drift: f64,
    /// Least determinant of the deformation gradient.
    pub determinant: f64,
}

/// What the bar does.
pub struct Twist {
    /// In the order of time.
    pub records: Vec<Record>,
    /// Greatest angle, rad, and its time, s.
    pub turn: (f64, f64),
    /// The same of linear torsion.
    pub linear: (f64, f64),
    /// Against torsion, of the bar and of its material, N m2.
    pub stiffness: (f64, f64),
    /// By which share the bar is shorter when it is turned most.
    pub shortening: f64,
    /// As the run leaves it.
    pub bar: Simulation,
    /// A fingerprint of the last state.
    pub hash: u64,
}

/// The whole run, with a spin of the free end in rad/s.
pub fn run(across: usize, spin: f64, series: &str) -> Result<Twist> {
    let (width, length) = (0.1, 1.0); // m
    let (modulus, density) = (2.5e6, 1000.0); // Pa, kg/m3
    let records: usize = 200;

    // The points: a block, its axis the z axis. Its ends are named, three layers to hold, one to watch.
    let spacing = width / across as f64;
    let (half, end) = (0.5 * width, 0.5 * length);
    let (lower, upper) = ([-half, -half, -end], [half, half, end]);
    let mut points = Points::block(3, &lower, &upper, spacing)?;
    points.add_set_box("held", &lower, &[half, half, 3.0 * spacing - end])?;
    points.add_set_box("free", &[-half, -half, end - spacing], &upper)?;
    points.add_set_box("middle", &[-half, -half, 0.0], &[half, half, spacing])?;
    let watched = points.set("free")?;

    // The material: a soft rubber, of Saint Venant and Kirchhoff, the default.
    let mut rubber = Model::new("correspondence")?;
    rubber.set("youngs_modulus", modulus)?;
    rubber.set("poissons_ratio", 0.25)?;
    rubber.set("density", density)?;
    rubber.set("horizon", 3.015 * spacing)?;

    let mut bar = Simulation::new(&points, &rubber)?;

    // The stiffness against torsion, from a small twist with the warping of a square,
    // c x y (x^2 - y^2): the energy of the layer in the middle is least for the c that the bar takes.
    let (twisting, warping) = (1e-4, 1.0 / (half * half)); // rad/m, 1/m2
    let mut energy_of = |warping: f64| -> Result<f64> {
        let mut displacement = points.coordinates().to_vec();
        for place in displacement.chunks_exact_mut(3) {
            let [x, y, z] = [place[0], place[1], place[2]];
            let warped = warping * x * y * (x * x - y * y);
            place.copy_from_slice(&[-twisting * y * z, twisting * x * z, twisting * warped]);
        }
        bar.set(Field::Displacement, &displacement)?;
        Ok(bar.sum(Field::StrainEnergyDensity, Some("middle"))?[0] * spacing * spacing)
    };
    let (less, plain, more) = (energy_of(-warping)?, energy_of(0.0)?, energy_of(warping)?);
    let (slope, curvature) = (0.5 * (more - less), 0.5 * (more + less) - plain);
    let stiffness = 2.0 * (plain - slope * slope / (4.0 * curvature)) / (twisting * twisting);
    bar.set(Field::Displacement, &vec![0.0; 3 * points.count()])?;

    // The spin, counted from just above the held layers [P 4.58, 4.59].
    let mut velocity = points.coordinates().to_vec();
    for place in velocity.chunks_exact_mut(3) {
        let [x, y, z] = [place[0], place[1], place[2]];
        let rate = spin * (PI / (2.0 * length) * (z + end - 3.01 * spacing)).sin();
        place.copy_from_slice(&[-rate * y, rate * x, 0.0]);
    }
    bar.set(Field::Velocity, &velocity)?;
    for axis in 0..3 {
        bar.prescribe("held", Quantity::Velocity, axis, 0.0)?;
    }

    // Linear torsion of what is free: waves of it run at sqrt(stiffness/inertia), and a quarter of a period
    // takes them once along the bar. The material alone would make it 0.1406 mu width^4 stiff.
    let shear_modulus = modulus / 2.5;
    let section = width * width;
    let material_stiffness = 0.1406 * shear_modulus * (section * section);
    let inertia = density * (section * section) / 6.0 * (1.0 - 1.0 / (across * across) as f64);
    let quarter = (length - 3.0 * spacing) / (stiffness / inertia).sqrt();
    let linear = (spin * quarter / (0.5 * PI), quarter);

    // Stepping, through half a period, with a look at the bar 200 times. Shear makes this law stiffer: a
    // tenth of the step that is stable now is kept back.
    let interval = 2.0 * quarter / records as f64;
    let steps = (interval / (0.9 * bar.stable_time_step()?)).ceil();
    let count = points.count();
    println!(
        "{count} points, {} steps of {:.4} ms",
        steps as usize * records,
        1e3 * interval / steps
    );
    println!("   time ms  angle deg  kinetic J  elastic J  least det F");
    let given = bar.energy()?.kinetic;
    let mut positions = vec![0.0; 3 * count];
    let mut gradients = vec![0.0; 9 * count];
    let (mut turn, mut shortening, mut angle) = ((0.0, 0.0), 0.0, 0.0);
    let mut curve = Vec::new();
    for number in 1..=records {
        bar.step(interval / steps, steps as u64)?;
        bar.get_into(Field::Position, &mut positions)?;
        bar.get_into(Field::DeformationGradient, &mut gradients)?;

        // The angle of the free end: that of the rotation in its plane that fits its points best.
        let (mut cosines, mut sines, mut height) = (0.0, 0.0, 0.0);
        for &point in &watched {
            let [x, y] = [points.coordinates()[3 * point], points.coordinates()[3 * point + 1]];
            let now = &positions[3 * point..3 * point + 3];
            cosines += x * now[0] + y * now[1];
            sines += x * now[1] - y * now[0];
            height += now[2];
        }
        // Between two looks it turns by less than half a turn.
        let turned = sines.atan2(cosines) - angle;
        angle += turned - 2.0 * PI * (turned / (2.0 * PI)).round();

        let energy = bar.energy()?;
        let record = Record {
            time: bar.time(),
            angle,
            drift: (energy.kinetic + energy.elastic) / given - 1.0,
            determinant: gradients.chunks_exact(9).map(determinant).fold(f64::INFINITY, f64::min),
        };
        if angle > turn.0 {
            turn = (angle, record.time);
            let height = height / watched.len() as f64;
            shortening = 1.0 - (height + end) / (length - 0.5 * spacing);
        }
        if number % 10 == 0 {
            println!(
                "{:10.3} {:10.3} {:10.4} {:10.4} {:12.6}",
                1e3 * record.time,
                angle.to_degrees(),
                energy.kinetic,
                energy.elastic,
                record.determinant
            );
            write(&bar, series)?;
        }
        curve.push(record);
    }

    // Results.
    let drift = curve.iter().map(|record| record.drift.abs()).fold(0.0, f64::max);
    let least = curve.iter().map(|record| record.determinant).fold(f64::INFINITY, f64::min);
    println!("stiffness       {stiffness:10.4} N m2");
    println!("  material      {material_stiffness:10.4} N m2");
    println!("greatest angle  {:10.3} degrees", turn.0.to_degrees());
    println!("  linear        {:10.3} degrees", linear.0.to_degrees());
    println!("  its time      {:10.4} ms", 1e3 * turn.1);
    println!("  linear        {:10.4} ms", 1e3 * linear.1);
    println!("  bar shorter by{:10.4} %", 100.0 * shortening);
    println!("energy given    {given:10.4} J");
    println!("largest drift   {:10.4} %", 100.0 * drift);
    println!("least det F     {least:10.6}");
    let mut hash = 0;
    for field in [Field::Displacement, Field::Velocity] {
        hash = hash_values(hash, &bar.get(field)?);
    }
    println!("hash            {hash:010X}");
    let stiffness = (stiffness, material_stiffness);
    Ok(Twist { records: curve, turn, linear, stiffness, shortening, bar, hash })
}

fn determinant(matrix: &[f64]) -> f64 {
    matrix[0] * (matrix[4] * matrix[8] - matrix[5] * matrix[7])
        - matrix[1] * (matrix[3] * matrix[8] - matrix[5] * matrix[6])
        + matrix[2] * (matrix[3] * matrix[7] - matrix[4] * matrix[6])
}

fn write(bar: &Simulation, series: &str) -> Result<()> {
    if series.is_empty() {
        return Ok(());
    }
    let fields = [Field::ReferencePosition, Field::Displacement, Field::VonMisesStress];
    bar.write_series(series, &fields)
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// The curve of the angle over time, with the names of its axes in the first line.
pub fn write_curve(path: &str, records: &[Record]) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let mut text = format!("time (ms),angle (degrees)\n{:10.4},{:12.5}\n", 0.0, 0.0);
    for record in records {
        text += &format!("{:10.4},{:12.5}\n", 1e3 * record.time, record.angle.to_degrees());
    }
    std::fs::write(path, text)
}
