//! What `make install` puts where, and what the lists say that packages are made from.

use crate::common::{in_crate, place, run};
use crate::{make, prefix};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// All files and links below a directory, in terms of it.
fn files(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(directory).unwrap() {
        let entry = entry.unwrap();
        let name = PathBuf::from(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            found.extend(files(&entry.path()).into_iter().map(|below| name.join(below)));
        } else {
            found.push(name);
        }
    }
    found.sort();
    found
}

/// The value of a line `beginning value` in a file of the source tree.
pub fn setting(file: &str, beginning: &str) -> String {
    let text = fs::read_to_string(in_crate(file)).unwrap();
    let value = text.lines().find_map(|line| line.strip_prefix(beginning));
    value.unwrap_or_else(|| panic!("no '{beginning}' in {file}")).trim().to_owned()
}

fn abi() -> String {
    setting("build.rs", "const ABI_VERSION: &str = ").trim_matches(['"', ';']).to_owned()
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
    assert_eq!(soname, format!("libperion.so.{}", abi()));
}

#[test]
fn files_go_where_the_settings_say_below_destdir_and_are_all_taken_away_again() {
    let stage = place("user/stage");
    let settings: [(&str, &Path); 4] = [
        ("DESTDIR", &stage),
        ("PREFIX", Path::new("/opt/perion")),
        ("LIBDIR", Path::new("/opt/perion/lib/some-machine")),
        ("INCLUDEDIR", Path::new("/opt/include")),
    ];
    make("install", &settings);
    let there = files(&stage);
    for expected in [
        "opt/include/perion.h",
        "opt/perion/lib/some-machine/cmake/perion/perionConfig.cmake",
        "opt/perion/lib/some-machine/libperion.a",
        "opt/perion/lib/some-machine/libperion.so",
        "opt/perion/lib/some-machine/pkgconfig/perion.pc",
        "opt/perion/share/perion/fortran/perion_c.f90",
    ] {
        assert!(there.contains(&PathBuf::from(expected)), "{expected} is not in {there:?}");
    }
    let modules = there.iter().find(|path| path.extension().is_some_and(|end| end == "mod"));
    assert_eq!(modules, None);
    let pc = stage.join("opt/perion/lib/some-machine/pkgconfig/perion.pc");
    let pc = fs::read_to_string(pc).unwrap();
    assert!(pc.contains("libdir=${prefix}/lib/some-machine\nincludedir=/opt/include\n"), "{pc}");

    make("uninstall", &settings);
    assert_eq!(files(&stage), Vec::<PathBuf>::new());
    assert!(!stage.join("opt/perion/share/perion").exists());
}

#[test]
fn what_is_installed_knows_nothing_of_where_it_was_built() {
    let stage = place("user/anonymous");
    make("install", &[("DESTDIR", &stage), ("PREFIX", Path::new("/usr"))]);
    let built_in = in_crate("").display().to_string();
    let built_in = built_in.trim_end_matches('/').as_bytes();
    for file in files(&stage) {
        let bytes = fs::read(stage.join(&file)).unwrap();
        assert!(!bytes.windows(built_in.len()).any(|part| part == built_in), "{}", file.display());
    }
}

#[test]
fn an_older_version_with_the_same_interface_is_replaced() {
    let stage = place("user/replaced");
    let lib = stage.join("usr/lib");
    fs::create_dir_all(&lib).unwrap();
    let other = format!("libperion.so.{}", abi() + "7");
    for name in ["libperion.so.0.0.9", "libperion.so.9.9.9"] {
        fs::write(lib.join(name), "").unwrap();
    }
    symlink("libperion.so.0.0.9", lib.join(format!("libperion.so.{}", abi()))).unwrap();
    symlink("libperion.so.9.9.9", lib.join(&other)).unwrap();
    make("install", &[("DESTDIR", &stage), ("PREFIX", Path::new("/usr"))]);
    assert!(!lib.join("libperion.so.0.0.9").exists());
    assert!(lib.join(other).exists(), "that of another interface stays");
}

/// What the script of the makefile says, with a library that was built long ago.
fn install_with_an_old_library(cargo: &str, prefix: &str) -> (bool, String) {
    let place = place("user/old_library");
    for name in ["libperion.so", "libperion.a"] {
        fs::write(place.join(name), "").unwrap();
        run(Command::new("touch").args(["-d", "2001-01-01"]).arg(place.join(name)));
    }
    let output = Command::new("sh")
        .args(["scripts/install.sh", "install"])
        .current_dir(in_crate(""))
        .envs([("MAKE", "echo builds"), ("CARGO", cargo), ("VERSION", "0.1.0"), ("ABI", "0")])
        .envs([("FORTRAN_SOURCES", ""), ("NATIVE_LIBRARIES", ""), ("PREFIX", prefix)])
        .env("LIB", &place)
        .env("LIBDIR", format!("{prefix}/lib"))
        .env("INCLUDEDIR", format!("{prefix}/include"))
        .env("DESTDIR", place.join("stage"))
        .output()
        .unwrap();
    (output.status.success(), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn a_library_older_than_its_sources_is_built_anew_or_not_installed() {
    let (done, said) = install_with_an_old_library("true", "/usr");
    assert!(done && said.starts_with("builds library\n"), "{said}");
    let (done, said) = install_with_an_old_library("no-such-cargo", "/usr");
    assert!(!done && said.contains("older than its sources: run make first"), "{said}");
}

#[test]
fn a_prefix_that_shells_would_read_otherwise_is_refused() {
    for prefix in ["/a#b", "/it's", "/a(b)", "/a;b", "/a$b", "/a\"b"] {
        let (done, said) = install_with_an_old_library("true", prefix);
        assert!(!done && said.contains("may have letters, digits"), "{prefix}: {said}");
    }
}

#[test]
fn a_relative_prefix_is_refused_with_a_line_that_says_so() {
    let output = Command::new("make")
        .args(["install", "PREFIX=here"])
        .current_dir(in_crate(""))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(!output.status.success());
    assert!(said.contains("PREFIX must be an absolute path, not 'here'"), "{said}");
    assert!(!in_crate("here").exists());
}

#[test]
fn the_static_library_needs_what_rustc_says_it_needs() {
    // Unoptimised, for the list is the same: it comes from the standard library.
    let output = Command::new(env!("CARGO"))
        .args(["rustc", "--quiet", "--lib", "--crate-type", "staticlib", "--target-dir"])
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("user/native"))
        .args(["--", "--print", "native-static-libs"])
        .current_dir(in_crate(""))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    let beginning = "note: native-static-libs: ";
    let needs = said.lines().find_map(|line| line.strip_prefix(beginning));
    assert_eq!(needs.map(str::trim), Some(&*setting("Makefile", "NATIVE_LIBRARIES :=")), "{said}");
}

#[test]
fn every_fortran_source_is_installed() {
    // fpm compiles what is in the directory; the makefile's list has the order for all others.
    let list = setting("Makefile", "FORTRAN_SOURCES :=");
    let mut list: Vec<PathBuf> = list.split_whitespace().map(PathBuf::from).collect();
    list.sort();
    assert_eq!(list, files(&in_crate("bindings/fortran")));
    assert_eq!(list, files(&prefix().join("share/perion/fortran")));
}

#[test]
fn the_numbers_in_the_packages_are_those_of_the_crate() {
    let version = format!("\"{}\"", env!("CARGO_PKG_VERSION"));
    assert_eq!(setting("fpm.toml", "version = "), version);
    let manifest = fs::read_to_string(in_crate("Cargo.toml")).unwrap();
    let library = manifest.split("[package.metadata.capi.library]").nth(1).unwrap();
    assert!(library.trim_start().starts_with(&format!("version = \"{}.", abi())), "{library}");
}
