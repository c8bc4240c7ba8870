//! A beam is bent far: which formulations keep its points in line?
//!
//! After Ganzenmueller, Hiermaier and May 2015, section 5.3: E = 100 GPa, nu = 0.3, plane stress, the law of Saint Venant
//! and Kirchhoff; a beam of 8 x 1 mm is moved at its end by up to 8 mm. Where its supports are the text doesn't say. Here it
//! is half of a beam whose middle is moved across: the supports hold one point each at 8 mm from it, on the axis, which is
//! free to slide along and to turn.
//!
//! Points are out of line by their distance from the middle of their four neighbours, a root mean square over all
//! inside, in spacings. Affine motions have none of it, and a curvature k has k/4 (in 1 over spacings). Pairs of
//! points that move together, which a gradient averaged over a family does not see, have much.
//!
//! Each equilibrium is looked for by Newton's method, and from where that finds none by relaxation.
//!
//! `cargo run --release --example beam -- [deflection in mm, 8] [points across, odd, 9] [steps, 10]
//! [law, saint_venant_kirchhoff] [curves, beam_rust.csv] [output files, beam_rust]`, and for pictures
//! `cargo run --release --example picture -- beam_rust.csv curves.png --curves --logarithmic` and
//! `cargo run --release --example picture -- beam_rust_correspondence_08.vtu beam.png --field strain.0`
//!
//! In order: points and sets, then for each formulation: model, simulation, conditions, equilibria, files. Units
//! are mm, N and MPa. The same program stands beside this one in C and in Fortran; all three print the same hash.

// The library's promise to survive exhausted memory does not extend to this program.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

use std::process::ExitCode;

use perion::{
    Error, Field, Model, Points, Quantity, RelaxOptions, Result, Simulation, SolveOptions,
};

const SPAN: f64 = 16.0; // mm
const HEIGHT: f64 = 1.0;
const MODULUS: f64 = 1e5; // MPa
const POISSONS_RATIO: f64 = 0.3;
const SMALL: f64 = 0.01; // mm, for the stiffness
/// What is compared, and the influence functions.
pub const FORMS: [(&str, &str); 4] = [
    ("correspondence", "constant"),
    ("correspondence_silling", "constant"),
    ("correspondence_wan", "constant"),
    ("bond_associated_quadrature", "cubic_spline"),
];

fn main() -> ExitCode {
    let argument = |place: usize, otherwise: &str| {
        std::env::args().nth(place).unwrap_or_else(|| otherwise.into())
    };
    let deflection: f64 = argument(1, "8").parse().unwrap_or(0.0);
    let across = argument(2, "9").parse().unwrap_or(0);
    let steps = argument(3, "20").parse().unwrap_or(0);
    let law = argument(4, "saint_venant_kirchhoff");
    let curves = argument(5, "beam_rust.csv");
    let files = argument(6, "beam_rust");
    let is_odd = across % 2 == 1;
    if deflection.is_nan()
        || deflection <= 0.0
        || across < 5
        || !is_odd
        || !(2..=99).contains(&steps)
    {
        eprintln!(
            "a deflection above 0, an odd number of points across from 5 on and 2 to 99 steps are needed"
        );
        return ExitCode::FAILURE;
    }
    let beams = match run(deflection, across, steps, &law, &files) {
        Ok(beams) => beams,
        // The text says what went wrong and what to do.
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Err(reason) = write_curves(&curves, &beams) {
        eprintln!("cannot write {curves}: {reason}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What a formulation makes of the beam.
#[derive(Default)]
pub struct Beam {
    /// Of a small deflection, over that of Timoshenko's beam.
    pub stiffness: f64,
    /// How far Newton's method came, in mm.
    pub solved_to: f64,
    /// What holds the middle at the end, in N.
    pub force: f64,
    /// In the order of deflections, in spacings.
    pub out_of_line: Vec<f64>,
}

/// What all of them do.
pub struct Beams {
    /// In mm.
    pub deflections: Vec<f64>,
    /// In the order of [`FORMS`].
    pub beams: Vec<Beam>,
    /// A fingerprint of the displacements at the end.
    pub hash: u64,
}

/// All beams.
pub fn run(deflection: f64, across: usize, steps: usize, law: &str, files: &str) -> Result<Beams> {
    let spacing = HEIGHT / across as f64;
    let points = lattice(spacing)?;
    println!("{} points, {deflection:.3} mm in {steps} steps", points.count());
    let deflections: Vec<f64> = (1..=steps).map(|k| deflection * k as f64 / steps as f64).collect();
    // Files are written here, and at the end.
    let late = 4 * steps / 5;

    let mut hash = 0;
    let mut beams = Vec::new();
    for (form, influence) in FORMS {
        let mut steel = Model::new(form)?;
        steel.choose("plane", "stress")?;
        steel.choose("material", law)?;
        steel.choose("influence", influence)?;
        steel.set("youngs_modulus", MODULUS)?;
        steel.set("poissons_ratio", POISSONS_RATIO)?;
        steel.set("density", 7.85e-9)?; // t/mm3
        steel.set("horizon", 3.015 * spacing)?;
        let mut body = Simulation::new(&points, &steel)?;
        body.prescribe("left", Quantity::Displacement, 1, 0.0)?;
        body.prescribe("right", Quantity::Displacement, 1, 0.0)?;
        body.prescribe("axis", Quantity::Displacement, 0, 0.0)?;

        let mut beam = Beam::default();
        bend(&mut body, SMALL, &mut beam)?;
        let bent = mean_across(&body, "middle")?
            - 0.5 * (mean_across(&body, "start")? + mean_across(&body, "end")?);
        beam.stiffness = force_on(&body)? / bent / timoshenko();
        for (k, &deflection) in (1..).zip(&deflections) {
            bend(&mut body, deflection, &mut beam)?;
            let moved = body.get(Field::Displacement)?;
            beam.out_of_line.push(out_of_line(&moved, across) / spacing);
            if !files.is_empty() && (k == late || k == steps) {
                let fields = [Field::Displacement, Field::Strain];
                body.write_vtk(format!("{files}_{form}_{k:02}.vtu"), &fields)?;
            }
        }
        beam.force = force_on(&body)?;
        hash = hash_values(hash, &body.get(Field::Displacement)?);
        beams.push(beam);
    }

    // Results.
    println!("formulation                 stiffness  solved to    force  out of line  at the end");
    for ((form, _), Beam { stiffness, solved_to, force, out_of_line }) in FORMS.iter().zip(&beams) {
        let (before, last) = (out_of_line[late - 1], out_of_line[steps - 1]);
        println!(
            "{form:<26} {stiffness:10.4} {solved_to:10.3} {force:8.0} {before:12.4} {last:11.4}"
        );
    }
    println!("out of line at  {:10.3}", deflections[late - 1]);
    println!("hash            {hash:010X}");
    Ok(Beams { deflections, beams, hash })
}

/// The points: a block that has points at the supports and in the middle.
fn lattice(spacing: f64) -> Result<Points> {
    let (half, end) = (0.5 * spacing, 0.5 * SPAN + 0.5 * spacing);
    let low = -0.5 * HEIGHT;
    let mut points = Points::block(2, &[-end, low], &[end, -low], spacing)?;
    points.add_set_box("middle", &[-half, low], &[half, -low])?;
    points.add_set_box("axis", &[-half, -half], &[half, half])?;
    points.add_set_box("start", &[-end, low], &[spacing - end, -low])?;
    points.add_set_box("end", &[end - spacing, low], &[end, -low])?;
    points.add_set_box("left", &[-end, -half], &[spacing - end, half])?;
    points.add_set_box("right", &[end - spacing, -half], &[end, half])?;
    Ok(points)
}

/// Moves the middle, by Newton's method or, where that has ended before, by relaxation.
fn bend(body: &mut Simulation, deflection: f64, beam: &mut Beam) -> Result<()> {
    let before = mean_across(body, "middle")?;
    body.prescribe("middle", Quantity::Displacement, 1, deflection)?;
    if beam.solved_to == before {
        let options = SolveOptions {
            tolerance: 1e-6,
            smallest_load_step: 0.25,
            products: 500,
            ..SolveOptions::default()
        };
        let found = body.solve(&options);
        beam.solved_to = mean_across(body, "middle")?;
        match found {
            Err(Error::Convergence(_)) => {}
            other => return other.map(|_| ()),
        }
    }
    body.relax(&RelaxOptions::default())?;
    Ok(())
}

/// Force over deflection of a beam that bends and shears, its shear factor that of a rectangle.
fn timoshenko() -> f64 {
    let inertia = HEIGHT * HEIGHT * HEIGHT / 12.0;
    let shear_factor = 10.0 * (1.0 + POISSONS_RATIO) / (12.0 + 11.0 * POISSONS_RATIO);
    let shear_modulus = 0.5 * MODULUS / (1.0 + POISSONS_RATIO);
    1.0 / (SPAN * SPAN * SPAN / (48.0 * MODULUS * inertia)
        + SPAN / (4.0 * shear_factor * shear_modulus * HEIGHT))
}

/// The mean displacement of a set across the beam.
fn mean_across(body: &Simulation, set: &str) -> Result<f64> {
    Ok(body.sum(Field::Displacement, Some(set))?[1] / body.points().set_size(set)? as f64)
}

/// What holds the middle.
fn force_on(body: &Simulation) -> Result<f64> {
    Ok(body.sum(Field::Reaction, Some("middle"))?[1])
}

/// How far points inside are from the middle of their four neighbours, a root mean square; x is fastest.
fn out_of_line(moved: &[f64], across: usize) -> f64 {
    let along = moved.len() / 2 / across;
    let (mut squares, mut count) = (0.0, 0);
    for row in 1..across - 1 {
        for column in 1..along - 1 {
            let point = row * along + column;
            for axis in 0..2 {
                let at = |point: usize| moved[2 * point + axis];
                let middle =
                    0.25 * (at(point - 1) + at(point + 1) + at(point - along) + at(point + along));
                squares += (at(point) - middle) * (at(point) - middle);
            }
            count += 1;
        }
    }
    (squares / f64::from(count)).sqrt()
}

/// A fingerprint of the bits of a field.
fn hash_values(hash: u64, values: &[f64]) -> u64 {
    values.iter().map(|value| value.to_bits()).fold(hash, |hash, bits| {
        let hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
        (hash * 65599 + (bits >> 32)) % 1_099_511_627_689
    })
}

/// A row for each deflection; the first line names the formulations.
pub fn write_curves(path: &str, beams: &Beams) -> std::io::Result<()> {
    if path.is_empty() {
        return Ok(());
    }
    let names = FORMS.map(|(form, _)| form).join(",");
    let mut text = format!("deflection (mm),{names}\n");
    for (k, deflection) in beams.deflections.iter().enumerate() {
        text += &format!("{deflection:8.4}");
        for beam in &beams.beams {
            text += &format!(",{:10.5}", beam.out_of_line[k]);
        }
        text += "\n";
    }
    std::fs::write(path, text)
}
