//! A square of points without order is let go after a stretch: do they move as one?
//!
//! After Ganzenmueller, Hiermaier and May 2015, section 5.2.1: 444 points, each with its own horizon, the distance
//! of its twelfth neighbour; plane stress, E = 1, nu = 0.3, density 1. Both edges are stretched by 10 %, and the
//! square swings. A gradient averaged over a family says little about each bond of it, and so plain
//! correspondence falls into disorder in the first contraction. With a penalty, or at quadrature points on
//! bonds, the points keep their order.
//!
//! Disorder is measured by what is left of bonds when the gradient of their family has been taken out:
//! the root mean square of |eta - F xi| over that of the lengths of bonds.
//!
//! `cargo run --release --example patch -- [points, examples/patch/points.txt] [records, 388; 30 make a contraction]
//! [curves, patch_rust.csv] [output files, patch_rust]`, and for pictures
//! `cargo run --release --example picture -- patch_rust.csv disorder.png --curves` and
//! `cargo run --release --example picture -- patch_rust_correspondence.vtu square.png --field displacement`
//!
//! In order: points with horizons, then for each formulation: model, simulation, a state set by hand, step,
//! fields, a file. Numbers have no units. The same program stands beside this one in C and in Fortran; all three
//! print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::process::ExitCode;

use perion::{Field, Model, Points, Result, Simulation};

const MODULUS: f64 = 1.0;
const POISSONS_RATIO: f64 = 0.3;
const DENSITY: f64 = 1.0;
const STRETCH: f64 = 0.1;
const NEAREST: usize = 12;
const STEPS: u64 = 10;
const CONTRACTIONS: usize = 12;
/// What is compared.
pub const FORMS: [&str; 3] = ["correspondence", "correspondence_wan", "bond_associated_quadrature"];

fn main() -> ExitCode {
    let argument = |place: usize, otherwise: &str| {
        std::env::args().nth(place).unwrap_or_else(|| otherwise.into())
    };
    let cloud = argument(1, "examples/patch/points.txt");
    let records = argument(2, "388").parse().unwrap_or(0);
    let curves = argument(3, "patch_rust.csv");
    let files = argument(4, "patch_rust");
    if records < 1 {
        eprintln!("at least one record is needed");
        return ExitCode::FAILURE;
    }
    let patch = match run(&cloud, records, &files) {
        Ok(patch) => patch,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_curves(&curves, &patch) {
        eprintln!("cannot write {curves}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What a formulation does.
pub struct Swing {
    /// In the order of records.
    pub disorder: Vec<f64>,
    /// The disorder in each contraction.
    pub contractions: Vec<f64>,
    /// Largest of |E/E_0 - 1|.
    pub drift: f64,
}

/// What all of them do.
pub struct Patch {
    /// In the order of [`FORMS`].
    pub swings: Vec<Swing>,
    /// Time between records.
    pub interval: f64,
    /// A fingerprint of the last states.
    pub hash: u64,
}

/// The whole run.
pub fn run(cloud: &str, records: usize, files: &str) -> Result<Patch> {
    // The points, with their areas, and the horizon of each.
    let mut points = Points::read(cloud)?;
    let count = points.count();
    let (nearest, horizons) = find_nearest(points.coordinates());
    points.set_horizons(&horizons)?;

    // A fifth of the time that a wave takes through the smallest area; speed of a wave in a plate.
    let wave_speed = (MODULUS / (1.0 - POISSONS_RATIO * POISSONS_RATIO) / DENSITY).sqrt();
    let smallest = points.volumes().iter().copied().fold(f64::INFINITY, f64::min);
    let time_step = 0.2 * smallest.sqrt() / wave_speed;
    println!("{count} points, {} steps of {time_step:.6}", records * STEPS as usize);

    let mut hash = 0;
    let mut swings = Vec::new();
    for form in FORMS {
        let mut plate = Model::new(form)?;
        plate.choose("plane", "stress")?;
        plate.set("youngs_modulus", MODULUS)?;
        plate.set("poissons_ratio", POISSONS_RATIO)?;
        plate.set("density", DENSITY)?;
        let mut body = Simulation::new(&points, &plate)?;

        // Stretched, and let go.
        let displacement: Vec<f64> = points.coordinates().iter().map(|x| STRETCH * x).collect();
        body.set(Field::Displacement, &displacement)?;
        let given = body.energy()?.elastic;

        let mut swing = Swing { disorder: Vec::new(), contractions: Vec::new(), drift: 0.0 };
        let (mut before, mut last) = (f64::INFINITY, f64::INFINITY);
        for record in 0..records {
            body.step(time_step, STEPS)?;
            let now = body.get(Field::Position)?;
            let gradients = body.get(Field::DeformationGradient)?;
            let energy = body.energy()?;
            swing.disorder.push(disorder_of(points.coordinates(), &nearest, &now, &gradients));
            swing.drift = swing.drift.max(((energy.kinetic + energy.elastic) / given - 1.0).abs());

            // A contraction is where the square is smallest.
            let size = size_of(&now);
            if last < before && last < size && swing.contractions.len() < CONTRACTIONS {
                if swing.contractions.is_empty() && !files.is_empty() {
                    let fields = [Field::Displacement, Field::VonMisesStress];
                    body.write_vtk(format!("{files}_{form}.vtu"), &fields)?;
                }
                swing.contractions.push(swing.disorder[record - 1]);
            }
            (before, last) = (last, size);
        }
        hash = hash_values(hash, &body.get(Field::Displacement)?);
        swings.push(swing);
    }

    // Results.
    println!(
        "formulation                 contractions  disorder at the first   largest  energy drift"
    );
    for (form, swing) in FORMS.iter().zip(&swings) {
        let largest = swing.contractions.iter().copied().fold(0.0, f64::max);
        let first = swing.contractions.first().copied().unwrap_or(0.0);
        let (number, drift) = (swing.contractions.len(), swing.drift);
        println!("{form:<26} {number:13} {first:22.4} {largest:9.4} {drift:13.6}");
    }
    let interval = time_step * STEPS as f64;
    println!("time            {:10.5}", interval * records as f64);
    println!("hash            {hash:010X}");
    Ok(Patch { swings, interval, hash })
}

fn place(values: &[f64], point: usize) -> [f64; 2] {
    [values[2 * point], values[2 * point + 1]]
}

/// From one point to another.
fn between(values: &[f64], from: usize, to: usize) -> [f64; 2] {
    let (from, to) = (place(values, from), place(values, to));
    [to[0] - from[0], to[1] - from[1]]
}

/// The twelve nearest of each point, and its horizon, the distance of the last.
fn find_nearest(places: &[f64]) -> (Vec<[usize; NEAREST]>, Vec<f64>) {
    let count = places.len() / 2;
    let mut nearest = vec![[0; NEAREST]; count];
    let mut horizons = Vec::new();
    for (i, own) in nearest.iter_mut().enumerate() {
        let mut last = 0.0;
        for next in own {
            let mut least = f64::INFINITY;
            for j in 0..count {
                let [x, y] = between(places, i, j);
                let square = x * x + y * y;
                if square > last && square < least {
                    (least, *next) = (square, j);
                }
            }
            last = least;
        }
        horizons.push(last.sqrt());
    }
    (nearest, horizons)
}

/// What is left of bonds without the gradients of their families, over their length.
fn disorder_of(
    places: &[f64],
    nearest: &[[usize; NEAREST]],
    now: &[f64],
    gradients: &[f64],
) -> f64 {
    let (mut left, mut lengths) = (0.0, 0.0);
    for (i, (own, gradient)) in nearest.iter().zip(gradients.chunks_exact(4)).enumerate() {
        for &j in own {
            let ([x, y], bond) = (between(places, i, j), between(now, i, j));
            let right = bond[0] - gradient[0] * x - gradient[1] * y;
            let up = bond[1] - gradient[2] * x - gradient[3] * y;
            left += right * right + up * up;
            lengths += x * x + y * y;
        }
    }
    (left / lengths).sqrt()
}

/// Mean square distance from the middle of the square, which stays where it is.
fn size_of(now: &[f64]) -> f64 {
    let count = (now.len() / 2) as f64;
    let mut middle = [0.0; 2];
    for point in now.chunks_exact(2) {
        middle = [middle[0] + point[0] / count, middle[1] + point[1] / count];
    }
    let squares: f64 = now
        .chunks_exact(2)
        .map(|point| (point[0] - middle[0]).powi(2) + (point[1] - middle[1]).powi(2))
        .sum();
    squares / count
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// A row for each record; the first line names the formulations.
pub fn write_curves(path: &str, patch: &Patch) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let mut text = format!("time,{}\n", FORMS.join(","));
    for record in 0..patch.swings[0].disorder.len() {
        text += &format!("{:9.5}", patch.interval * (record + 1) as f64);
        for swing in &patch.swings {
            text += &format!(",{:9.5}", swing.disorder[record]);
        }
        text += "\n";
    }
    std::fs::write(path, text)
}
