//! What a user does outside the source tree: install, link from C, C++ and Fortran by pkg-config, CMake and fpm,
//! run the README's programs and the demo; and what valgrind says of it.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

mod cmake;
#[path = "../common/mod.rs"]
mod common;
mod documentation;
mod fpm;
mod install;
mod pkg_config;
mod readme;
mod valgrind;

use common::{in_crate, place, run};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Runs make in the source tree: a target and settings such as PREFIX.
fn make(target: &str, settings: &[(&str, &Path)]) -> String {
    let settings = settings.iter().map(|(name, path)| format!("{name}={}", path.display()));
    run(Command::new("make").arg(target).args(settings).current_dir(in_crate("")))
}

/// The prefix that `make install` has filled.
fn prefix() -> &'static Path {
    static PREFIX: OnceLock<PathBuf> = OnceLock::new();
    PREFIX.get_or_init(|| {
        let prefix = place("user/prefix");
        make("install", &[("PREFIX", &prefix)]);
        prefix
    })
}

fn rpath() -> String {
    format!("-Wl,-rpath,{}/lib", prefix().display())
}

/// All blocks of a language in the README.
fn snippets(language: &str) -> Vec<String> {
    let readme = fs::read_to_string(in_crate("README.md")).unwrap();
    let start = format!("```{language}\n");
    let blocks = readme.split(&start).skip(1);
    blocks.map(|block| block.split("```").next().unwrap().to_owned()).collect()
}

/// The first block of a language in the README.
fn snippet(language: &str) -> String {
    snippets(language).into_iter().next().expect("the README has a snippet")
}

/// A new place with an outside project of tests/user/outside and the README's programs as its sources.
fn project(name: &str, at: &str) -> PathBuf {
    let place = place(at);
    copy(&in_crate("tests/user/outside").join(name), &place);
    fs::write(place.join("bar.c"), snippet("c")).unwrap();
    fs::write(place.join("bar.f90"), snippet("fortran")).unwrap();
    fs::copy(in_crate("tests/user/outside/bar.cpp"), place.join("bar.cpp")).unwrap();
    place
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let (path, name) = entry.map(|entry| (entry.path(), entry.file_name())).unwrap();
        if path.is_dir() {
            copy(&path, &to.join(name));
        } else {
            fs::copy(path, to.join(name)).unwrap();
        }
    }
}

/// Compiles the README's C program (as C++ where the compiler is one).
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

/// What the bar of the README prints: a force.
fn force() -> &'static str {
    static FORCE: OnceLock<String> = OnceLock::new();
    FORCE.get_or_init(|| {
        let paths = ["-I", "-L"].map(|flag| {
            let part = if flag == "-I" { "include" } else { "lib" };
            format!("{flag}{}", prefix().join(part).display())
        });
        let flags: Vec<String> = paths.into_iter().chain(["-lperion".into(), rpath()]).collect();
        let said = run(&mut Command::new(compile_c(&place("user/force"), "bar.c", "gcc", &flags)));
        let number = said.strip_suffix(" N\n").and_then(|number| number.parse::<f64>().ok());
        assert!(number.is_some_and(|force| force > 1.0), "{said}");
        said
    })
}

/// Runs programs that must all say what the bar of the README says.
fn agree(programs: impl IntoIterator<Item = PathBuf>) {
    for program in programs {
        let said = run(&mut Command::new(&program));
        assert_eq!(said.trim(), force().trim(), "{}", program.display());
    }
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
