//! The C interface as C programs see it: those of tests/c are compiled with gcc against the shared
//! library that cargo has built for this test, and run. Each says how many of its expectations held.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

#[path = "../common/mod.rs"]
mod common;

use common::{in_crate, there_is};
use perion as _;
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// What every program is linked with.
const COMMON: &[&str] = &["harness.c", "scene.c", "calls.c"];

/// The parts of the programs that have some.
const PARTS: &[(&str, &[&str])] = &[(
    "t900_bad_input",
    &[
        "bad_points.c",
        "bad_sets.c",
        "bad_model.c",
        "bad_setup.c",
        "bad_conditions.c",
        "bad_fields.c",
        "bad_drive.c",
        "bad_statics.c",
        "bad_views.c",
    ],
)];

macro_rules! programs {
    ($($(#[$doc:meta])* $name:ident, $program:literal;)+) => {
        /// The programs that the tests run.
        const PROGRAMS: &[&str] = &[$($program),+];
        $($(#[$doc])* #[test] fn $name() { hold(run(Command::new(compiled($program)), $program)); })+
    };
}

programs! {
    the_library_says_what_it_is, "t100_version";
    points_and_their_sets_come_out_as_they_went_in, "t200_points";
    points_are_read_from_files, "t210_reading";
    models_are_made_from_their_lists, "t300_model";
    laws_of_the_hosts_own_are_asked_and_kept_as_told, "t350_material_function";
    set_up_decides_what_breaks_and_threads_change_nothing, "t400_setup";
    conditions_hold_their_sets, "t500_conditions";
    fields_and_views_are_copies_and_the_memory_itself, "t600_fields";
    steps_are_made_told_of_and_accounted_for, "t700_drive";
    bodies_come_to_rest_under_loads, "t720_statics";
    files_are_written_as_a_whole_or_not_at_all, "t800_files";
    every_bad_input_is_refused_and_changes_nothing, "t900_bad_input";
    callbacks_that_misbehave_do_no_harm, "t910_callbacks";
    a_log_callback_that_looks_at_its_simulation_does_not_hang, "t915_log_callback";
    two_threads_on_one_handle_get_results_or_refusals, "t920_threads";
    the_hosts_floating_point_environment_does_not_matter_and_comes_back, "t930_host_floats";
    want_of_memory_is_a_status, "t940_memory";
    a_short_life_leaves_no_thread_behind, "t950_life_cycle";
}

#[test]
fn a_short_life_leaks_nothing_and_reads_nothing_it_should_not() {
    if !there_is("valgrind") {
        return;
    }
    let program = "t950_life_cycle";
    let mut command = Command::new("valgrind");
    command
        .args(["--leak-check=full", "--errors-for-leak-kinds=definite,possible"])
        .args(["--error-exitcode=9", "-q"])
        .arg(compiled(program));
    hold(run(command, "valgrind"));
}

#[test]
fn every_c_program_is_run() {
    let run: BTreeSet<String> = PROGRAMS.iter().map(|&name| name.to_owned()).collect();
    let parts = PARTS.iter().flat_map(|(_, parts)| parts.iter());
    let known: BTreeSet<&str> = COMMON.iter().chain(parts).copied().collect();
    for (file, _) in sources() {
        let program = file.strip_suffix(".c").is_some_and(|name| run.contains(name));
        let header = file.ends_with(".h");
        assert!(program || header || known.contains(&*file), "tests/c/{file} is never run");
    }
}

#[test]
fn every_function_of_the_header_is_called() {
    let header = without_comments(&fs::read_to_string(in_crate("include/perion.h")).unwrap());
    let calls: String = sources().into_iter().map(|(_, text)| without_comments(&text)).collect();
    let missing: Vec<&str> = functions(&header)
        .into_iter()
        .filter(|name| !calls.contains(&format!("{name}(")))
        .collect();
    assert!(missing.is_empty(), "no program of tests/c calls {missing:?}");
}

/// Checks that a program has said nothing but that all its expectations hold: what the library prints
/// would stand there, too.
fn hold(output: Output) {
    let (said, wrong) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let counted = said.strip_suffix(" passed, 0 failed\n").map(str::parse::<u32>);
    let fine = output.status.success() && wrong.is_empty() && matches!(counted, Some(Ok(1..)));
    assert!(fine, "{}\n{said}{wrong}", output.status);
}

/// Runs a program in a new directory of its own, which is its argument.
fn run(mut command: Command, name: &str) -> Output {
    let directory = common::place(&format!("c_interface/run-{name}"));
    command.current_dir(&directory).arg(&directory);
    for variable in ["PERION_NUM_THREADS", "OMP_NUM_THREADS", "PERION_SIMD"] {
        command.env_remove(variable);
    }
    command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"))
}

/// Compiles a program of tests/c and gives its path.
fn compiled(program: &str) -> PathBuf {
    let parts = PARTS.iter().find(|(name, _)| *name == program).map_or(&[][..], |(_, parts)| parts);
    let directory = scratch("programs");
    fs::create_dir_all(&directory).unwrap();
    // One file for each test that runs it: tests run at once.
    let thread = std::thread::current();
    let target = directory.join(format!("{program}-{}", thread.name().unwrap_or("test")));
    let mut gcc = Command::new("gcc");
    gcc.args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-g"])
        .arg("-I")
        .arg(in_crate("include"))
        .arg(in_crate(&format!("tests/c/{program}.c")))
        .args(COMMON.iter().chain(parts).map(|part| in_crate(&format!("tests/c/{part}"))))
        .arg(library().join(soname()))
        // Old tags: the path goes before LD_LIBRARY_PATH, where cargo puts directories of its own.
        .arg(format!("-Wl,--disable-new-dtags,-rpath,{}", library().display()))
        .args(["-lm", "-pthread", "-o"])
        .arg(&target);
    common::run(&mut gcc);
    target
}

/// A directory with the shared library under the name that programs ask for. Cargo builds it beside
/// this test, and copies it to target/PROFILE only on `cargo build`: that copy may be an old one.
fn library() -> &'static Path {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| {
        let test = std::env::current_exe().unwrap();
        let file = test.with_file_name("libperion.so");
        assert!(file.exists(), "there is no {}", file.display());
        let directory = scratch("library");
        fs::create_dir_all(&directory).unwrap();
        let link = directory.join(soname());
        let _ = fs::remove_file(&link);
        symlink(file, link).unwrap();
        directory
    })
}

fn soname() -> String {
    unsafe extern "C" {
        safe fn perion_abi_version() -> i32;
    }
    format!("libperion.so.{}", perion_abi_version())
}

/// The files of tests/c by name.
fn sources() -> Vec<(String, String)> {
    fs::read_dir(in_crate("tests/c"))
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, fs::read_to_string(path).unwrap())
        })
        .collect()
}

/// The functions that a header declares.
fn functions(header: &str) -> Vec<&str> {
    let words = header.split(|it: char| !it.is_alphanumeric() && it != '_' && it != '(');
    words.filter_map(|word| word.split_once('(')).map(|(name, _)| name).filter(is_ours).collect()
}

fn is_ours(name: &&str) -> bool {
    name.starts_with("perion_")
}

fn without_comments(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some((before, comment)) = rest.split_once("/*") {
        code.push_str(before);
        rest = comment.split_once("*/").map_or("", |(_, after)| after);
    }
    code + rest
}

fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("c_interface").join(name)
}
