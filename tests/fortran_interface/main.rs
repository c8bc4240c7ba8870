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
use compilers::{directory, fortran, module_sources};

#[test]
fn the_fortran_tests_pass_with_all_traps_set() {
    if !there_is("gfortran") {
        return;
    }
    for optimisation in ["-O0", "-O2"] {
        let directory = directory(&format!("traps{optimisation}"));
        let tests = fortran_tests(&directory, optimisation);
        let printed = run(Command::new(tests).arg(&directory));
        let lines: Vec<&str> = printed.lines().collect();
        assert_eq!(lines.first().map(|line| line.trim()), Some("traps on"), "{printed}");
        assert!(lines.last().is_some_and(|line| line.ends_with(" passed, 0 failed")), "{printed}");
    }
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
        .arg(fortran_tests(&directory, "-O0"))
        .arg(&directory);
    run(&mut valgrind);
}

#[test]
fn what_must_not_go_on_ends_the_program_with_a_text() {
    if !there_is("gfortran") {
        return;
    }
    let directory = directory("stops");
    let mut sources = module_sources();
    sources.push(in_crate("tests/fortran/stops/main.f90"));
    let program = fortran(&directory, "stops", &sources, "-O2");
    run(Command::new(&program).arg("nothing"));
    for (which, words) in [
        ("points", "perion_points cannot be assigned, since handles do not copy; pass the object"),
        ("model", "perion_model cannot be assigned"),
        (
            "an empty model",
            "perion_model cannot be assigned, since handles do not copy; call destroy",
        ),
        ("simulation", "perion_simulation cannot be assigned"),
        ("array of points", "perion_points cannot be assigned"),
        ("array of models", "perion_model cannot be assigned"),
        ("array of simulations", "perion_simulation cannot be assigned"),
        ("points for an array", "perion_points cannot be assigned"),
        ("part of a type", "perion_model cannot be assigned"),
        ("part of an array of a type", "perion_model cannot be assigned"),
        ("array in a type", "perion_model cannot be assigned"),
        (
            "an object that was not created",
            "perion_simulation_step: the perion_simulation has not been created",
        ),
        ("failure without error", "perion_model_set: 'density' is -1"),
    ] {
        let output = Command::new(&program).arg(which).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{which}: {said}");
        assert!(said.contains(&format!("ERROR STOP {words}")), "{which}: {said}");
    }
}

#[test]
fn many_points_need_no_more_stack_than_few() {
    if !there_is("gfortran") {
        return;
    }
    let directory = directory("stack");
    let mut sources = module_sources();
    sources.push(in_crate("tests/fortran/stack/main.f90"));
    let program = fortran(&directory, "stack", &sources, "-Ofast");
    // In KiB: a list of its 90000 points has 352 with the shortest integers.
    let mut shell = Command::new("sh");
    let printed = run(shell.args(["-c", "ulimit -s 256; exec \"$0\""]).arg(program));
    assert_eq!(printed.trim(), "done");
}

#[test]
fn threads_of_the_host_have_objects_of_their_own() {
    if !there_is("gfortran") {
        return;
    }
    let directory = directory("threads");
    let mut sources = module_sources();
    sources.push(in_crate("tests/fortran/threads/main.f90"));
    let program = fortran(&directory, "threads", &sources, "-fopenmp");
    assert_eq!(run(&mut Command::new(program)).trim(), "T");
}

#[test]
fn module_and_examples_compile_where_integers_and_reals_are_of_64_bits() {
    if !there_is("gfortran") {
        return;
    }
    for (name, options) in [
        ("wide_integers", vec!["-fdefault-integer-8"]),
        ("wide_reals", vec!["-fdefault-real-8", "-fdefault-double-8"]),
    ] {
        let directory = directory(name);
        let compile = |sources: &[PathBuf]| {
            let mut compiler = Command::new("gfortran");
            compiler.current_dir(&directory).args(["-std=f2018", "-Wall", "-Werror", "-c"]);
            run(compiler.args(&options).args(sources));
        };
        compile(&module_sources());
        compile(&[in_crate("tests/fortran/stops/main.f90")]);
        for example in [
            "beam",
            "branching",
            "hyperelastic_bar",
            "own_material",
            "patch",
            "specimen",
            "traction_bar",
            "wave",
        ] {
            compile(&[in_crate(&format!("examples/{example}/main.f90"))]);
        }
    }
}

#[test]
fn the_module_has_no_names_but_its_own() {
    if !there_is("gfortran") {
        return;
    }
    let page = fs::read_to_string(in_crate("bindings/fortran/perion.f90")).unwrap();
    let public: Vec<&str> = page
        .lines()
        .filter_map(|line| line.trim_start().strip_prefix("public :: "))
        .flat_map(|names| names.split(", "))
        .collect();
    let mut host = String::from("program host\n  use perion\n  implicit none\n");
    for name in interface_names().iter().filter(|name| !public.contains(&name.as_str())) {
        host.push_str(&format!("  integer :: {name}\n"));
    }
    for name in
        ["c_ptr", "c_double", "raw_view", "function_holder", "material_holder", "ok", "check"]
    {
        host.push_str(&format!("  integer :: {name}\n"));
    }
    host.push_str("end program host\n");
    let directory = directory("names");
    let source = directory.join("host.f90");
    fs::write(&source, host).unwrap();
    let mut sources = module_sources();
    sources.push(source);
    let mut compiler = Command::new("gfortran");
    run(compiler.current_dir(&directory).args(["-std=f2018", "-c"]).args(sources));
}

#[test]
fn every_interface_is_called_by_the_module() {
    let names = interface_names();
    assert!(names.len() > 50, "the interfaces are not read: {names:?}");
    let mut page = String::new();
    let mut bodies = String::new();
    for file in module_sources() {
        match file.file_name().unwrap().to_str().unwrap() {
            "perion_c.f90" => {}
            "perion.f90" => page = code(&file),
            _ => bodies.push_str(&code(&file)),
        }
    }
    // What needs no other form in Fortran goes on under its name.
    let passed_on = page.split("use perion_support").next().unwrap();
    let uncalled: Vec<&String> = names
        .iter()
        .filter(|name| {
            let renamed = bodies.lines().find_map(|line| {
                let (before, _) = line.split_once(&format!(" => {name}"))?;
                before.rsplit([' ', ',']).next().map(str::to_owned)
            });
            let called = renamed.unwrap_or_else(|| (*name).clone());
            !bodies.contains(&format!("{called}(")) && !passed_on.contains(&format!("{name},"))
        })
        .collect();
    assert!(uncalled.is_empty(), "the module does not call {uncalled:?}");
    let constants = fs::read_to_string(in_crate("bindings/fortran/perion_c.f90")).unwrap();
    for line in constants.lines().filter(|line| line.contains(", parameter :: PERION_")) {
        let name = line.split(" :: ").nth(1).unwrap().split(' ').next().unwrap();
        assert!(page.matches(name).count() > 1, "{name} is not passed on");
    }
}

#[test]
fn every_procedure_of_the_module_is_called_from_a_fortran_test() {
    let page = code(&in_crate("bindings/fortran/perion.f90"));
    let tests: String = test_sources().iter().map(|file| code(file)).collect();
    let mut uncalled = Vec::new();
    let mut procedures = 0;
    for text in page.split("  type :: perion_").skip(1) {
        let (object, rest) = text.split_once('\n').unwrap();
        let bound = rest.split("end type").next().unwrap();
        for line in bound.lines().map(str::trim) {
            let declared =
                line.strip_prefix("generic :: ").or_else(|| line.strip_prefix("procedure :: "));
            let Some((name, _)) = declared.and_then(|it| it.split_once(" => ")) else { continue };
            procedures += 1;
            if name != "assignment(=)" && !tests.contains(&format!("{object}%{name}(")) {
                uncalled.push(format!("{object}%{name}"));
            }
        }
    }
    assert!(procedures > 50, "the types are not read");
    let functions = page.lines().filter_map(|line| line.strip_prefix("  interface perion_"));
    for name in functions.map(|name| format!("perion_{name}")) {
        if !tests.contains(&format!("{name}(")) {
            uncalled.push(name);
        }
    }
    assert!(uncalled.is_empty(), "no Fortran test calls {uncalled:?}");
}

/// The names of all functions in perion_c.
fn interface_names() -> Vec<String> {
    let interfaces = fs::read_to_string(in_crate("bindings/fortran/perion_c.f90")).unwrap();
    let parts = interfaces.split("bind(c, name=\"").skip(1);
    parts.map(|part| part.split('"').next().unwrap().to_owned()).collect()
}

/// A Fortran file without its comments.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    let lines = text.lines().filter(|line| !line.trim_start().starts_with('!'));
    lines.map(|line| format!("{line}\n")).collect()
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
    let mut sources = module_sources();
    sources.push(in_crate("examples/branching/main.f90"));
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

fn fortran_tests(directory: &Path, optimisation: &str) -> PathBuf {
    let mut sources = module_sources();
    sources.extend(test_sources());
    fortran(directory, "tests", &sources, optimisation)
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
