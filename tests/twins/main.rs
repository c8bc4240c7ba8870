//! Every formulation gives the same bits in C, Fortran and Rust, for any number of threads: one small body, with
//! bonds that break, and a fingerprint of all there is after some steps. All numbers that go in are exact in binary.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../fortran_interface/compilers.rs"]
mod compilers;

use std::process::Command;

use common::{in_crate, run, there_is};
use perion::{FORMULATIONS, Field, Model, Points, Quantity, Simulation};

const COUNT: usize = 5 * 4 * 3;

fn cloud() -> Points {
    let (mut coordinates, mut volumes) = (Vec::new(), Vec::new());
    for point in 0..COUNT {
        for (axis, place) in [point % 5, point / 5 % 4, point / 20].into_iter().enumerate() {
            let jitter = ((point * 7919 + axis * 104_729) % 257) as f64 - 128.0;
            coordinates.push((1024.0 * place as f64 + jitter) / 1024.0);
        }
        volumes.push((896 + point * 31 % 256) as f64 / 1024.0);
    }
    let mut points = Points::new(3, &coordinates, &volumes).unwrap();
    points.add_set_box("left", &[-1.0; 3], &[0.5, 9.0, 9.0]).unwrap();
    points.add_set_box("right", &[3.5, -1.0, -1.0], &[9.0; 3]).unwrap();
    points
}

fn line(formulation: &str, threads: usize) -> String {
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in [
        ("density", 1.25),
        ("youngs_modulus", 1.5),
        ("poissons_ratio", 0.25),
        ("horizon", 2.25),
        ("critical_stretch", 1.0 / 128.0),
    ] {
        model.set(key, value).unwrap();
    }
    let mut simulation = Simulation::new(&cloud(), &model).unwrap();
    simulation.set_threads(threads).unwrap();
    let velocity = (0..3 * COUNT).map(|component| ((component * 13 % 64) as f64 - 32.0) / 1024.0);
    simulation.set(Field::Velocity, &velocity.collect::<Vec<f64>>()).unwrap();
    for (set, velocity) in [("left", -1.0 / 64.0), ("right", 1.0 / 64.0)] {
        simulation.prescribe(set, Quantity::Velocity, 0, velocity).unwrap();
    }
    simulation.step(1.0 / 16.0, 5).unwrap();
    let mut hash = 0;
    for field in [
        Field::Displacement,
        Field::Velocity,
        Field::InternalForce,
        Field::StrainEnergyDensity,
        Field::VonMisesStress,
        Field::Damage,
    ] {
        for bits in simulation.get(field).unwrap().into_iter().map(f64::to_bits) {
            hash = (hash * 65599 + (bits & 0xffff_ffff)) % 1_099_511_627_689;
            hash = (hash * 65599 + (bits >> 32)) % 1_099_511_627_689;
        }
    }
    let health = simulation.health().unwrap();
    assert!(health.broken_bonds > 0 && health.broken_bonds < health.bonds, "{formulation}");
    format!("{formulation} {hash:010X} {}", health.broken_bonds)
}

#[test]
fn every_formulation_has_the_same_bits_in_c_fortran_and_rust() {
    let of = |threads| -> Vec<String> {
        FORMULATIONS.iter().map(|entry| line(entry.name, threads)).collect()
    };
    let expected = of(1);
    // Formulations differ, or the fingerprint would tell nothing; correspondence is total_lagrangian.
    let mut hashes: Vec<&str> =
        expected.iter().map(|line| line.split(' ').nth(1).unwrap()).collect();
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), FORMULATIONS.len() - 1, "{expected:?}");
    for threads in [2, 4] {
        assert_eq!(of(threads), expected, "{threads} threads");
    }
    let mut programs = Vec::new();
    if there_is("cc") {
        let directory = compilers::directory("formulations_c");
        programs.push(compilers::c(&directory, "twin", &in_crate("tests/twins/main.c")));
    }
    if there_is("gfortran") {
        let directory = compilers::directory("formulations_fortran");
        let mut sources = compilers::module_sources();
        sources.push(in_crate("tests/twins/main.f90"));
        programs.push(compilers::fortran(&directory, "twin", &sources, "-O2"));
    }
    for program in programs {
        for threads in ["1", "2", "4"] {
            let printed = run(Command::new(&program).env("PERION_NUM_THREADS", threads));
            let lines: Vec<&str> = printed.lines().collect();
            assert_eq!(lines, expected, "{} on {threads} threads", program.display());
        }
    }
}
