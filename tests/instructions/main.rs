//! How many instructions a commit costs, forces and the search for what breaks, on the levels that valgrind knows, held
//! against what they were: a loop that has become slower by 3 % fails, on any machine, however busy it is.
//!
//! `tests/data/instructions.json` holds instructions a directed bond and commit, by the compiler's version; of another
//! compiler nothing is known, and the test says so. `PERION_BLESS=1` writes what is counted.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros, clippy::unwrap_used, clippy::panic)]

#[path = "../common/mod.rs"]
mod common;

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::process::Command;

use common::{in_crate, place, there_is};
use perion::{Field, Model, Points, Simulation};

const FORMULATIONS: [&str; 4] =
    ["bond_based", "ordinary_state_based", "correspondence", "bond_associated_quadrature"];
const LEVELS: [&str; 2] = ["baseline", "avx2"];
/// What may be more than it was.
const MORE: f64 = 1.03;

/// A cloud of 12^3 points, one thread, in which bonds may break and none does.
fn body(formulation: &str) -> Simulation {
    let block = Points::block(3, &[0.0; 3], &[12.0; 3], 1.0).unwrap();
    let jitter = |(k, x): (usize, &f64)| x + 0.3 * ((k as f64 * 0.5698402909).fract() - 0.5);
    let places: Vec<f64> = block.coordinates().iter().enumerate().map(jitter).collect();
    let points = Points::new(3, &places, block.volumes()).unwrap();
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in
        [("density", 1.0), ("youngs_modulus", 1.0), ("horizon", 3.015), ("critical_stretch", 0.5)]
    {
        model.set(key, value).unwrap();
    }
    if formulation != "bond_based" {
        model.set("poissons_ratio", 0.25).unwrap();
    }
    let mut simulation = Simulation::new(&points, &model).unwrap();
    simulation.set_threads(1).unwrap();
    simulation
}

/// Commits that the test below has counted: it runs this program with them. Steps would begin with the stable step.
#[test]
#[ignore = "run by the other test"]
fn commits_to_be_counted() {
    let formulation = env::var("PERION_COUNTED").unwrap();
    let commits = env::var("PERION_COMMITS").unwrap().parse().unwrap();
    let mut simulation = body(&formulation);
    let count = simulation.points().count();
    let displacement: Vec<f64> = (0..3 * count).map(|k| 1e-6 * (k as f64 * 0.37).sin()).collect();
    for _ in 0..commits {
        simulation.set(Field::Displacement, &displacement).unwrap();
        simulation.commit(0.1).unwrap();
    }
}

fn instructions(formulation: &str, level: &str, commits: u32) -> f64 {
    let out = place("instructions").join(format!("{formulation}-{level}-{commits}"));
    let told = Command::new("valgrind")
        .args(["--tool=callgrind", &format!("--callgrind-out-file={}", out.display())])
        .arg(env::current_exe().unwrap())
        .args(["--exact", "commits_to_be_counted", "--ignored", "--test-threads=1"])
        .env("PERION_COUNTED", formulation)
        .env("PERION_COMMITS", commits.to_string())
        .env("PERION_SIMD", level)
        .output()
        .unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let text = fs::read_to_string(&out).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("summary: ")).unwrap();
    line.split(' ').next().unwrap().parse().unwrap()
}

fn compiler() -> String {
    let told = Command::new("rustc").arg("--version").output().unwrap();
    String::from_utf8(told.stdout).unwrap().split(' ').nth(1).unwrap().to_owned()
}

#[test]
fn commits_cost_no_more_instructions_than_they_did() {
    if !there_is("valgrind") {
        eprintln!("skipped: instructions are counted by valgrind");
        return;
    }
    let path = in_crate("tests/data/instructions.json");
    let mut known: BTreeMap<String, BTreeMap<String, f64>> =
        serde_json::from_str(&fs::read_to_string(&path).unwrap_or("{}".into())).unwrap();
    let (compiler, blesses) = (compiler(), env::var_os("PERION_BLESS").is_some());
    if !blesses && !known.contains_key(&compiler) {
        eprintln!("skipped: nobody has counted the instructions of rustc {compiler} yet");
        return;
    }
    let mut counted = BTreeMap::new();
    for formulation in FORMULATIONS {
        let ends = 2.0 * body(formulation).bond_count().unwrap() as f64;
        for level in LEVELS {
            // Families, and what is kept from the first sweep on, are in both.
            let [few, many] = [2, 6].map(|commits| instructions(formulation, level, commits));
            let each = (many - few) / 4.0 / ends;
            eprintln!("{formulation}, {level}: {each:.2} instructions a bond and commit");
            counted.insert(format!("{formulation} {level}"), (100.0 * each).round() / 100.0);
        }
    }
    if blesses {
        known.insert(compiler, counted);
        fs::write(&path, serde_json::to_string_pretty(&known).unwrap() + "\n").unwrap();
        return;
    }
    for (what, now) in &counted {
        let before = known[&compiler][what];
        assert!(
            *now <= MORE * before,
            "{what}: {now} instructions a bond and commit, not {before}"
        );
    }
}
