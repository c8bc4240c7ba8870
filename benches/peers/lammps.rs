//! LAMMPS with its package PERI: scenes written as data, runs, and what its log tells.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{DENSITY, HORIZON, SPACING, TIME_STEP, YOUNGS_MODULUS, poissons_ratio};

const DECK: &str = include_str!("peri.in");

/// A pair style, with the suffix that its threads need, and the formulation that it is.
#[derive(Clone, Copy)]
pub struct Style {
    pub name: &'static str,
    pub formulation: &'static str,
    style: &'static str,
    /// Threads of OpenMP instead of ranks of MPI.
    pub omp: bool,
}

pub const STYLES: [Style; 4] = [
    Style { name: "pmb", formulation: "bond_based", style: "pmb", omp: false },
    Style { name: "pmb/omp", formulation: "bond_based", style: "pmb", omp: true },
    Style { name: "lps", formulation: "ordinary_state_based", style: "lps", omp: false },
    Style { name: "lps/omp", formulation: "ordinary_state_based", style: "lps", omp: true },
];

/// What a run has told.
pub struct Run {
    pub seconds_a_step: f64,
    /// As LAMMPS counts them, each at both its ends.
    pub bonds: u64,
}

/// Whether LAMMPS and what starts its ranks are installed.
pub fn is_installed() -> bool {
    let runs = |program: &str, argument: &str| Command::new(program).arg(argument).output().is_ok();
    runs("lmp", "-help") && runs("mpirun", "--version")
}

/// Whether it was built with threads of OpenMP.
pub fn has_omp() -> bool {
    let help = Command::new("lmp").arg("-help").output().map(|output| output.stdout);
    let help = String::from_utf8(help.unwrap_or_default()).unwrap_or_default();
    help.split_whitespace().any(|word| word == "OPENMP")
}

/// Points as LAMMPS reads them, in a file in `folder`.
pub fn write_points(folder: &Path, coordinates: &[f64]) -> PathBuf {
    let count = coordinates.len() / 3;
    let mut text = format!("points of a block\n\n{count} atoms\n1 atom types\n\n");
    let extent = |axis: usize| {
        coordinates.iter().skip(axis).step_by(3).fold(0.0_f64, |most, x| most.max(*x))
    };
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (lower, upper) = (-2.0 * SPACING, extent(axis) + 2.0 * SPACING);
        text += &format!("{lower:.17e} {upper:.17e} {name}lo {name}hi\n");
    }
    text += "\nAtoms # peri\n\n";
    let volume = SPACING.powi(3);
    for (point, place) in coordinates.chunks(3).enumerate() {
        let [x, y, z] = [place[0], place[1], place[2]];
        text += &format!("{} 1 {volume:.17e} {DENSITY} {x:.17e} {y:.17e} {z:.17e}\n", point + 1);
    }
    let path = folder.join("points.data");
    fs::write(&path, text).unwrap();
    path
}

/// One run: some steps to warm up and `steps` that are timed. The text of the log where it failed.
pub fn run(
    folder: &Path,
    points: &Path,
    style: Style,
    threads: usize,
    steps: u64,
) -> Result<Run, String> {
    let deck = folder.join("peri.in");
    fs::write(&deck, DECK).unwrap();
    let ratio = poissons_ratio(style.formulation);
    let bulk = YOUNGS_MODULUS / (3.0 * (1.0 - 2.0 * ratio));
    let shear = YOUNGS_MODULUS / (2.0 * (1.0 + ratio));
    let critical = "0.1 0.0";
    let coefficients = if style.style == "pmb" {
        let constant = 18.0 * bulk / (std::f64::consts::PI * HORIZON.powi(4));
        format!("{constant:e} {HORIZON:e} {critical}")
    } else {
        format!("{bulk:e} {shear:e} {HORIZON:e} {critical}")
    };
    let mut command = if style.omp {
        let mut command = Command::new("lmp");
        command.args(["-sf", "omp", "-pk", "omp", &threads.to_string()]);
        command
    } else {
        let mut command = Command::new("mpirun");
        command.args([
            "--allow-run-as-root",
            "--oversubscribe",
            "-np",
            &threads.to_string(),
            "lmp",
        ]);
        command
    };
    command.env("OMP_NUM_THREADS", if style.omp { threads.to_string() } else { "1".to_owned() });
    command.current_dir(folder).args(["-screen", "none", "-log", "log.peri", "-in", "peri.in"]);
    let variables = [
        ("style", style.style.to_owned()),
        ("coefficients", coefficients),
        ("points", points.display().to_string()),
        ("horizon", format!("{HORIZON:e}")),
        ("reach", format!("{:e}", 1.1 * HORIZON + SPACING)),
        ("skin", format!("{:e}", 0.1 * SPACING)),
        ("step", format!("{TIME_STEP:e}")),
        ("warm", "1".to_owned()),
        ("steps", steps.to_string()),
    ];
    for (name, value) in &variables {
        command.args(["-var", name, value]);
    }
    let output = command.output().map_err(|error| error.to_string())?;
    let log = fs::read_to_string(folder.join("log.peri")).unwrap_or_default();
    let failed = || {
        let text = log.lines().rev().take(3).collect::<Vec<_>>().join(" | ");
        format!("{text} {}", String::from_utf8_lossy(&output.stderr))
    };
    let after = |start: &str, place: usize| {
        let line = log.lines().rev().find(|line| line.trim_start().starts_with(start))?;
        line.split_whitespace().nth(place)?.parse::<f64>().ok()
    };
    let seconds = after("Loop time of", 3).ok_or_else(failed)?;
    let bonds = after("total # of bonds", 5).ok_or_else(failed)?;
    Ok(Run { seconds_a_step: seconds / steps as f64, bonds: bonds as u64 })
}
