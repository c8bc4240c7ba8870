//! What a user does outside the source tree: install, link from C, C++ and Fortran, run the README's
//! programs and the demo; and what valgrind says of it.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

#[path = "../common/mod.rs"]
mod common;

use common::{in_crate, place, run, there_is};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The prefix that `make install` has filled.
fn prefix() -> &'static Path {
    static PREFIX: OnceLock<PathBuf> = OnceLock::new();
    PREFIX.get_or_init(|| {
        let prefix = place("user/prefix");
        let argument = format!("PREFIX={}", prefix.display());
        run(Command::new("make").args(["install", &argument]).current_dir(in_crate("")));
        prefix
    })
}

/// What pkg-config says of the installed library, or what its file would make it say.
fn pkg_config(arguments: &[&str]) -> Vec<String> {
    let path = prefix().join("lib/pkgconfig");
    let command = Command::new("pkg-config")
        .env("PKG_CONFIG_PATH", path)
        .args(arguments)
        .arg("perion")
        .output()
        .expect("pkg-config is needed for this test");
    assert!(command.status.success(), "{command:?}");
    let text = String::from_utf8(command.stdout).unwrap();
    text.split_whitespace().map(str::to_owned).collect()
}

fn rpath() -> String {
    format!("-Wl,-rpath,{}/lib", prefix().display())
}

/// The first block of a language in the README.
fn snippet(language: &str) -> String {
    let readme = fs::read_to_string(in_crate("README.md")).unwrap();
    let start = format!("```{language}\n");
    let from = readme.find(&start).expect("the README has a snippet") + start.len();
    let to = from + readme[from..].find("```").unwrap();
    readme[from..to].to_owned()
}

fn compile_c(place: &Path, name: &str, compiler: &str, extra: &[String]) -> PathBuf {
    let (source, program) = (place.join(name), place.join("program"));
    fs::write(&source, snippet("c")).unwrap();
    run(Command::new(compiler)
        .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror"])
        .arg(&source)
        .arg("-o")
        .arg(&program)
        .args(extra));
    program
}

#[test]
fn the_program_of_the_readme_runs_as_c_and_cpp_against_the_installed_library() {
    if !there_is("pkg-config") {
        return;
    }
    let mut flags = pkg_config(&["--cflags", "--libs"]);
    flags.push(rpath());
    let place = place("user/readme_c");
    let said = run(&mut Command::new(compile_c(&place, "bar.c", "gcc", &flags)));
    assert!(
        said.ends_with(" N\n") && said.trim_end_matches(" N\n").parse::<f64>().is_ok(),
        "{said}"
    );
    assert!(!said.starts_with("0.0"), "{said}");
    if there_is("g++") {
        let same = run(&mut Command::new(compile_c(&place, "bar.cpp", "g++", &flags)));
        assert_eq!(said, same);
    }
}

#[test]
fn the_static_library_links_with_what_pkg_config_says() {
    if !there_is("pkg-config") {
        return;
    }
    let place = place("user/static");
    let mut flags = pkg_config(&["--cflags"]);
    flags.push(prefix().join("lib/libperion.a").display().to_string());
    let all = pkg_config(&["--static", "--libs"]);
    flags.extend(all.into_iter().filter(|flag| flag != "-lperion"));
    let program = compile_c(&place, "bar.c", "gcc", &flags);
    let needs = run(Command::new("readelf").arg("-d").arg(&program));
    assert!(!needs.contains("libperion"), "{needs}");
    assert!(run(&mut Command::new(program)).ends_with(" N\n"));
}

#[test]
fn the_fortran_of_the_readme_runs_and_agrees_with_the_c() {
    if !there_is("pkg-config") || !there_is("gfortran") {
        return;
    }
    let place = place("user/readme_fortran");
    let source = place.join("bar.f90");
    fs::write(&source, snippet("fortran")).unwrap();
    let program = place.join("program");
    run(Command::new("gfortran")
        .args(["-std=f2018", "-Wall", "-Wextra", "-Werror", "-ffpe-trap=zero,invalid,overflow"])
        .arg("-J")
        .arg(&place)
        .args(pkg_config(&["--variable=fortran_sources"]))
        .arg(&source)
        .arg("-o")
        .arg(&program)
        .args(pkg_config(&["--libs"]))
        .arg(rpath()));
    let mut flags = pkg_config(&["--cflags", "--libs"]);
    flags.push(rpath());
    let twin = compile_c(&place, "bar.c", "gcc", &flags);
    assert_eq!(run(&mut Command::new(program)).trim(), run(&mut Command::new(twin)).trim());
}

#[test]
fn the_installed_library_is_found_by_its_soname_and_exports_the_version() {
    let library = prefix().join("lib/libperion.so");
    let target = fs::canonicalize(&library).unwrap();
    let name = target.file_name().unwrap().to_string_lossy().into_owned();
    assert_eq!(name, format!("libperion.so.{}", env!("CARGO_PKG_VERSION")));
    let dynamic = run(Command::new("readelf").arg("-d").arg(&library));
    let soname = dynamic.lines().find(|line| line.contains("SONAME")).unwrap();
    let soname = soname.split(['[', ']']).nth(1).unwrap();
    assert!(prefix().join("lib").join(soname).exists(), "{soname}");
}

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
        command.arg(prefix().join("share/perion/fortran/perion_c.f90"));
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

#[test]
fn the_library_is_built_by_cargo_alone() {
    // Neither build script nor dependencies of the library ask for more than cargo and a linker.
    let tree = run(Command::new(env!("CARGO"))
        .args(["tree", "--edges", "normal,build", "--prefix", "none", "--offline"])
        .current_dir(in_crate("")));
    for unwanted in ["cmake", "bindgen", "cc v", "pkg-config", "-sys v"] {
        assert!(!tree.contains(unwanted), "{unwanted} in\n{tree}");
    }
}
