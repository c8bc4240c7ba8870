//! The demo in short form under valgrind, against the installed library.

use crate::common::{in_crate, place, run, there_is};
use crate::install::setting;
use crate::{prefix, rpath};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Compiles an example of the demo in one language.
fn example(place: &Path, language: &str) -> PathBuf {
    let program = place.join(format!("branching_{language}"));
    let mut command = if language == "c" {
        let mut command = Command::new("gcc");
        command.args(["-std=c11", "-g", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]);
        command.arg(in_crate("examples/branching/main.c"));
        command.arg(format!("-I{}/include", prefix().display()));
        command
    } else {
        let mut command = Command::new("gfortran");
        command.args(["-std=f2018", "-g", "-O1", "-Wall", "-Wextra", "-Werror"]);
        command.args(["-fcheck=all", "-finit-real=snan", "-ffpe-trap=zero,invalid,overflow"]);
        command.arg("-J").arg(place);
        let sources = setting("Makefile", "FORTRAN_SOURCES :=");
        let installed = prefix().join("share/perion/fortran");
        command.args(sources.split_whitespace().map(|name| installed.join(name)));
        command.arg(in_crate("examples/branching/main.f90"));
        command
    };
    run(command.arg("-o").arg(&program).arg(format!("-L{}/lib", prefix().display())).args([
        "-lperion",
        "-lm",
        &rpath(),
    ]));
    program
}

/// The demo in short form under valgrind: no error, nothing lost.
fn hold_to_valgrind(language: &str) {
    if !there_is("valgrind") || (language == "fortran" && !there_is("gfortran")) {
        return;
    }
    let place = place(&format!("user/valgrind_{language}"));
    let program = example(&place, language);
    let said = run(Command::new("valgrind")
        .args(["--quiet", "--error-exitcode=9", "--leak-check=full"])
        .args(["--show-leak-kinds=definite,possible", "--errors-for-leak-kinds=definite,possible"])
        .arg(program)
        .arg("20")
        .arg(place.join("short.pvd"))
        .env("PERION_NUM_THREADS", "2"));
    assert!(said.contains("closure error") && said.contains("hash"), "{said}");
    assert!(place.join("short.pvd").exists());
}

#[test]
fn valgrind_finds_nothing_in_the_c_demo() {
    hold_to_valgrind("c");
}

#[test]
fn valgrind_finds_nothing_in_the_fortran_demo() {
    hold_to_valgrind("fortran");
}
