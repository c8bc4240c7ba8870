//! The section "Install and link" of the README, run as it is written by a user with a home of their own.

use crate::common::{in_crate, place, run, there_is, tool};
use crate::{agree, force, prefix, snippet, snippets};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The block of shell commands with a word in it.
fn commands(word: &str) -> String {
    let block = snippets("sh").into_iter().find(|block| block.contains(word));
    block.unwrap_or_else(|| panic!("the README does not say how to use {word}"))
}

/// Runs shell commands in a directory as the user, who has a tool in the path; gives what they print.
fn shell(commands: &str, directory: &Path, tool: Option<&Path>) -> String {
    let mut path: Vec<PathBuf> =
        tool.and_then(Path::parent).map(Path::to_owned).into_iter().collect();
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap()));
    run(Command::new("sh")
        .args(["-euc", commands])
        .current_dir(directory)
        .env("PATH", std::env::join_paths(path).unwrap())
        .env("HOME", home()))
}

/// The user's home, in which the library is installed as the README says.
fn home() -> &'static Path {
    static HOME: OnceLock<PathBuf> = OnceLock::new();
    HOME.get_or_init(|| {
        // Builds, where need be, with the home that Rust is installed in.
        prefix();
        let home = place("user/home");
        run(Command::new("sh")
            .args(["-euc", &commands("make install")])
            .current_dir(in_crate(""))
            .env("HOME", &home));
        home
    })
}

/// A directory with the README's programs.
fn programs(name: &str) -> PathBuf {
    let place = place(name);
    fs::write(place.join("bar.c"), snippet("c")).unwrap();
    fs::write(place.join("bar.f90"), snippet("fortran")).unwrap();
    place
}

#[test]
fn its_lines_for_pkg_config_and_by_hand_work() {
    if !(there_is("pkg-config") && there_is("gfortran")) {
        return;
    }
    let place = programs("user/readme_pkg_config");
    let all = commands("pkg-config");
    let (settings, compilations): (Vec<&str>, Vec<&str>) =
        all.lines().partition(|line| line.starts_with("export"));
    assert_eq!(compilations.len(), 4);
    for line in compilations {
        shell(&format!("{}\n{line}", settings.join("\n")), &place, None);
        agree([place.join("bar")]);
    }
}

fn with_fortran(name: &str) -> Option<PathBuf> {
    there_is("gfortran").then(|| tool(name)).flatten()
}

#[test]
fn its_project_for_cmake_works() {
    let Some(cmake) = with_fortran("cmake") else { return };
    let place = programs("user/readme_cmake");
    fs::write(place.join("CMakeLists.txt"), snippet("cmake")).unwrap();
    let said = shell(&commands("cmake"), &place, Some(&cmake));
    assert_eq!(said.lines().last().map(str::trim), Some(force().trim()), "{said}");
}

#[test]
fn its_project_for_fpm_works() {
    let Some(fpm) = with_fortran("fpm") else { return };
    let place = programs("user/readme_fpm/bar");
    fs::write(place.join("fpm.toml"), format!("name = \"bar\"\n{}", snippet("toml"))).unwrap();
    fs::create_dir(place.join("app")).unwrap();
    fs::rename(place.join("bar.f90"), place.join("app/main.f90")).unwrap();
    let sources = place.join("../perion");
    let _ = fs::remove_file(&sources);
    std::os::unix::fs::symlink(in_crate(""), sources).unwrap();
    let said = shell(&commands("fpm run"), &place, Some(&fpm));
    assert_eq!(said.lines().last().map(str::trim), Some(force().trim()), "{said}");
}
