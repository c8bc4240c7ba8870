//! The same scenes by other codes, in turns with the library's own steps: `make bench-peers`, or a part of it by
//! `make bench-peers BENCH="cloud pmb"`. Needs Debian's package `lammps`.
//!
//! Horizon 3.015 spacings, free surfaces, damage looked for and none found, no list built anew in what is timed, one rank
//! or thread to one thread and two to two. The bonds are counted on both sides.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros, clippy::unwrap_used, missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod lammps;

use common::{ARRANGEMENTS, BODIES, Body, Choice};

/// Rounds in which both take turns.
const ROUNDS: usize = 5;

/// Steps that LAMMPS is timed for in a round.
const STEPS: u64 = 6;

fn main() {
    if !lammps::is_installed() {
        println!("skipped: lammps is not installed (Debian: apt-get install lammps)");
        return;
    }
    let found = lammps::STYLES.into_iter().filter(|style| !style.omp || lammps::has_omp());
    let found: Vec<lammps::Style> = found.collect();
    let styles = lammps::STYLES.map(|style| style.name);
    if found.len() < styles.len() {
        println!("This LAMMPS has no package OPENMP: ranks of MPI alone.");
    }
    let (arrangements, bodies) = (common::arrangement_names(), common::body_names());
    let choice = Choice::from_arguments(&[&styles, &arrangements, &bodies]);
    // One body is enough to compare, unless others are asked for.
    let asked = bodies.iter().any(|body| std::env::args().any(|argument| argument == *body));
    println!(
        "{:<9}{:<8}{:>6}{:>8} {:>12} {:>12}{:>9}{:>8}{:>12}",
        "peri/", "", "", "threads", "bonds", "LAMMPS Mb/s", "Mb/s", "ratio", "ratio least"
    );
    for arrangement in ARRANGEMENTS {
        for body in BODIES {
            let chosen = if asked { choice.has(&bodies, body.name) } else { body.name == "50" };
            if chosen && choice.has(&arrangements, arrangement.name) {
                let chosen = found.iter().filter(|style| choice.has(&styles, style.name));
                compare(arrangement, body, chosen);
            }
        }
    }
}

fn compare<'a>(
    arrangement: common::Arrangement,
    body: Body,
    styles: impl Iterator<Item = &'a lammps::Style>,
) {
    let folder = std::env::temp_dir().join(format!("perion-peers-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let coordinates = common::coordinates(body, arrangement);
    let data = lammps::write_points(&folder, &coordinates);
    let points = common::points(&coordinates);
    for style in styles {
        let mut simulation = common::simulation(&points, style.formulation, true, 2).unwrap();
        common::seconds_a_step(&mut simulation, 1);
        let bonds = 2 * simulation.bond_count().unwrap();
        for threads in [1, 2] {
            simulation.set_threads(threads).unwrap();
            let label =
                format!("{:<9}{:<8}{:>6}{threads:>8}", style.name, arrangement.name, body.name);
            let steps = (0.3 / common::seconds_a_step(&mut simulation, 1)).clamp(2.0, 50.0) as u64;
            let (mut own, mut peer) = (Vec::new(), Vec::new());
            let mut failure = None;
            for _ in 0..ROUNDS {
                match lammps::run(&folder, &data, *style, threads, STEPS) {
                    Ok(run) if run.bonds == bonds => peer.push(run.seconds_a_step),
                    Ok(run) => {
                        failure = Some(format!("LAMMPS has {} bonds, not {bonds}", run.bonds))
                    }
                    Err(text) => failure = Some(text),
                }
                if failure.is_some() {
                    break;
                }
                own.push(common::seconds_a_step(&mut simulation, steps));
            }
            if let Some(text) = failure {
                println!("{label} -  {text}");
                continue;
            }
            let ([least, median], [peer_least, peer_median]) =
                (common::least_and_median(own), common::least_and_median(peer));
            println!(
                "{label} {bonds:>12} {:>12.0}{:>9.0}{:>8.2}{:>12.2}",
                1e-6 * bonds as f64 / peer_median,
                1e-6 * bonds as f64 / median,
                peer_median / median,
                peer_least / least
            );
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
