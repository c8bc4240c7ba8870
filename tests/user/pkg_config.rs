//! Hosts that ask pkg-config.

use crate::common::{place, run, there_is};
use crate::{agree, compile_c, make, prefix, project, rpath, snippet};
use std::fs;
use std::process::Command;

/// What pkg-config says of the installed library.
fn pkg_config(arguments: &[&str]) -> Vec<String> {
    let text = run(Command::new("pkg-config")
        .env("PKG_CONFIG_PATH", prefix().join("lib/pkgconfig"))
        .args(arguments)
        .arg("perion"));
    text.split_whitespace().map(str::to_owned).collect()
}

#[test]
fn a_makefile_builds_in_all_languages_from_a_prefix_with_a_blank() {
    if !(there_is("pkg-config") && there_is("gfortran") && there_is("g++")) {
        return;
    }
    let prefix = place("user/pkg config");
    make("install", &[("PREFIX", &prefix), ("LIBDIR", &prefix.join("lib64"))]);
    let project = project("pkg_config", "user/makefile");
    run(Command::new("make")
        .current_dir(&project)
        .env("PKG_CONFIG_PATH", prefix.join("lib64/pkgconfig")));
    agree(["bar_c", "bar_cpp", "bar_static", "bar_fortran"].map(|name| project.join(name)));
}

#[test]
fn the_program_of_the_readme_is_cpp_too() {
    if !(there_is("pkg-config") && there_is("g++")) {
        return;
    }
    let mut flags = pkg_config(&["--cflags", "--libs"]);
    flags.push(rpath());
    agree([compile_c(&place("user/readme_cpp"), "bar.cpp", "g++", &flags)]);
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
    agree([program]);
}

#[test]
fn the_fortran_of_the_readme_is_standard_and_free_of_warnings() {
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
    agree([program]);
}
