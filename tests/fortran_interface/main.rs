//! The Fortran interfaces as a Fortran program uses them: compiles and runs `tests/fortran` and the
//! example, which must print the same in C, Fortran and Rust.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

#[path = "../../examples/branching/main.rs"]
#[allow(dead_code)]
mod branching;
#[path = "../common/mod.rs"]
mod common;
mod compilers;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{in_crate, run, there_is};
use compilers::{directory, fortran};

const INTERFACES: &str = "bindings/fortran/perion_c.f90";

#[test]
fn the_fortran_tests_pass_with_all_traps_set() {
    if !there_is("gfortran") {
        return;
    }
    let directory = directory("traps");
    let printed = run(Command::new(fortran_tests(&directory)).arg(&directory));
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines.first().map(|line| line.trim()), Some("traps on"), "{printed}");
    assert!(lines.last().is_some_and(|line| line.ends_with(" passed, 0 failed")), "{printed}");
}

#[test]
fn the_fortran_tests_leave_no_memory_behind() {
    if !(there_is("gfortran") && there_is("valgrind")) {
        return;
    }
    let directory = directory("valgrind");
    let mut valgrind = Command::new("valgrind");
    valgrind
        .args(["-q", "--error-exitcode=9", "--leak-check=full"])
        .args(["--errors-for-leak-kinds=definite,possible", "--show-leak-kinds=definite,possible"])
        .arg(fortran_tests(&directory))
        .arg(&directory);
    run(&mut valgrind);
}

#[test]
fn every_interface_is_called_from_a_fortran_test() {
    let interfaces = fs::read_to_string(in_crate(INTERFACES)).unwrap();
    let names: Vec<&str> = interfaces
        .split("bind(c, name=\"")
        .skip(1)
        .filter_map(|rest| rest.split_once('"').map(|(name, _)| name))
        .collect();
    assert!(names.len() > 50, "the interfaces are not read: {names:?}");

    let mut tests = String::new();
    for file in test_sources() {
        let text = fs::read_to_string(file).unwrap();
        tests.extend(text.lines().filter(|line| !line.trim_start().starts_with('!')));
    }
    let uncalled: Vec<&str> =
        names.into_iter().filter(|name| !tests.contains(&format!("{name}("))).collect();
    assert!(uncalled.is_empty(), "no Fortran test calls {uncalled:?}");
}

#[test]
fn the_example_prints_the_same_in_c_fortran_and_rust() {
    const SIDE: &str = "PERION_TEST_RUST_TWIN";
    const POINTS_ALONG: u32 = 40;
    if std::env::var_os(SIDE).is_some() {
        println!();
        branching::run(POINTS_ALONG, "").unwrap();
        return;
    }
    if !(there_is("gfortran") && there_is("cc")) {
        return;
    }
    let directory = directory("twins");
    let sources = [in_crate(INTERFACES), in_crate("examples/branching/main.f90")];
    let in_fortran = fortran(&directory, "fortran", &sources, "-O2");
    let in_c = compilers::c(&directory, "c", &in_crate("examples/branching/main.c"));

    let mut twins = Vec::new();
    for threads in ["1", "2", "3", "4"] {
        for program in [&in_c, &in_fortran] {
            let mut twin = Command::new(program);
            twin.args([&POINTS_ALONG.to_string(), ""]).env("PERION_NUM_THREADS", threads);
            twins.push(results(&run(&mut twin)));
        }
        // A process of its own: the number of threads is read from its environment.
        let mut twin = Command::new(std::env::current_exe().unwrap());
        twin.args(["the_example_prints_the_same_in_c_fortran_and_rust", "--exact", "--nocapture"]);
        twins.push(results(&run(twin.env(SIDE, "1").env("PERION_NUM_THREADS", threads))));
    }
    assert!(twins[0].len() > 20 && twins[0].last().unwrap().starts_with("hash "), "{twins:?}");
    for twin in &twins {
        assert_eq!(twin, &twins[0]);
    }
}

/// What an example prints, but for the times that the run may still take.
fn results(printed: &str) -> Vec<String> {
    let mut lines = Vec::new();
    for line in printed.lines().skip_while(|line| !line.contains(" points, ")) {
        lines.push(line.split(" us, ").next().unwrap().to_owned());
        if line.starts_with("hash ") {
            break;
        }
    }
    lines
}

fn fortran_tests(directory: &Path) -> PathBuf {
    let mut sources = vec![in_crate(INTERFACES)];
    sources.extend(test_sources());
    fortran(directory, "tests", &sources, "-O0")
}

/// All files of the tests: first what they share, last the program.
fn test_sources() -> Vec<PathBuf> {
    let entries = fs::read_dir(in_crate("tests/fortran")).unwrap();
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "f90"))
        .collect();
    let turn = |path: &Path| match path.file_stem().and_then(|stem| stem.to_str()) {
        Some("testing") => 0,
        Some("scenes") => 1,
        Some("main") => 3,
        _ => 2,
    };
    files.sort_by(|one, other| turn(one).cmp(&turn(other)).then_with(|| one.cmp(other)));
    files
}
