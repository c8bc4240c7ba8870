//! Hosts that use CMake: an installed library found, or the source tree as a part of the host's.

use crate::common::{in_crate, place, run, there_is, tool};
use crate::{agree, make, prefix, project};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// CMake's command line for a project, to be built in `build` below it.
fn configure(cmake: &Path, project: &Path, settings: &[(&str, &Path)]) -> Command {
    let mut command = Command::new(cmake);
    command.arg("-S").arg(project).arg("-B").arg(project.join("build"));
    for (name, value) in settings {
        let mut setting = OsString::from(format!("-D{name}="));
        setting.push(value);
        command.arg(setting);
    }
    command
}

fn build(cmake: &Path, project: &Path, settings: &[(&str, &Path)]) {
    run(&mut configure(cmake, project, settings));
    run(Command::new(cmake).arg("--build").arg(project.join("build")));
}

fn programs<const N: usize>(project: &Path, names: [&str; N]) -> [PathBuf; N] {
    names.map(|name| project.join("build").join(name))
}

/// CMake and the compilers of the outside projects.
fn there_are_all() -> Option<PathBuf> {
    let compilers = there_is("gfortran") && there_is("g++");
    compilers.then(|| tool("cmake")).flatten()
}

#[test]
fn a_project_in_three_languages_finds_a_package_that_has_moved() {
    let Some(cmake) = there_are_all() else { return };
    let stage = place("user/moving");
    let prefix = Path::new("/opt/perion");
    make("install", &[("DESTDIR", &stage), ("PREFIX", prefix), ("LIBDIR", &prefix.join("lib64"))]);
    let moved = stage.join("moved and renamed");
    std::fs::rename(stage.join("opt/perion"), &moved).unwrap();

    let project = project("cmake", "user/cmake");
    build(&cmake, &project, &[("perion_DIR", &moved.join("lib64/cmake/perion"))]);
    agree(programs(&project, ["bar_c", "bar_cpp", "bar_static", "bar_fortran"]));
}

#[test]
fn what_the_package_cannot_give_is_refused_with_the_reason() {
    let Some(cmake) = tool("cmake") else { return };
    for (version, components, reason) in [
        ("0.1", "Cobol", "there is no component Cobol"),
        ("0.1", "Fortran", "needs Fortran among the languages"),
        ("0.2", "C", "requested version \"0.2\""),
        ("0.0", "C", "requested version \"0.0\""),
        ("1.0", "C", "requested version \"1.0\""),
    ] {
        let project = project("cmake_refused", "user/cmake_refused");
        let version = ("VERSION", Path::new(version));
        let asked =
            [version, ("COMPONENTS", Path::new(components)), ("CMAKE_PREFIX_PATH", prefix())];
        let output = configure(&cmake, &project, &asked).output().unwrap();
        // CMake breaks its lines where it likes.
        let said = String::from_utf8_lossy(&output.stderr);
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(!output.status.success() && said.contains(reason), "{said}");
    }
}

#[test]
fn the_source_tree_is_a_part_of_the_hosts_build() {
    let Some(cmake) = there_are_all() else { return };
    let project = project("subdirectory", "user/subdirectory");
    let here = in_crate("");
    // Where cargo has built it already for these tests.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    build(&cmake, &project, &[("PERION_SOURCE", &here), ("PERION_CARGO_TARGET_DIR", target)]);
    agree(programs(&project, ["bar_c", "bar_static", "bar_fortran"]));
}

#[test]
fn the_source_tree_without_cargo_says_what_to_install() {
    let Some(cmake) = tool("cmake") else { return };
    let settings = [("CARGO", Path::new(""))];
    let project = place("user/no_cargo");
    let mut command = configure(&cmake, &in_crate(""), &settings);
    let output = command.arg("-B").arg(&project).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && said.contains("Install Rust"), "{said}");
}
