//! What other languages see of the library: the header, the Fortran interfaces and the exported
//! symbols agree with the Rust source and are clean. `make bindings` writes the generated files.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

#[path = "../common/mod.rs"]
mod common;
mod fortran;
mod header;

use common::{in_crate, run, there_is};

use header::Header;
use perion::{FORMULATIONS, KEYS, Kind};
use std::collections::BTreeSet;
use std::ffi::{CStr, c_char};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The files of src/ffi with items for C, in the order of the header.
const SOURCES: &[&str] = &[
    "version.rs",
    "status.rs",
    "last_error.rs",
    "points.rs",
    "model.rs",
    "simulation/setup.rs",
    "simulation/bonds.rs",
    "simulation/conditions.rs",
    "simulation/fields.rs",
    "simulation/operators.rs",
    "simulation/views.rs",
    "simulation/drive.rs",
    "simulation/report.rs",
    "simulation/advance.rs",
    "simulation/statics.rs",
    "simulation/balance.rs",
    "simulation/files.rs",
];

const KEYS_PAGE: &str = "docs/keys.md";
const HEADER: &str = "include/perion.h";
const INTERFACES: &str = "bindings/fortran/perion_c.f90";

unsafe extern "C" {
    safe fn perion_abi_version() -> i32;
    safe fn perion_version_string() -> *const c_char;
}

#[test]
fn the_committed_header_is_what_cbindgen_makes_of_the_source() {
    hold_to(HEADER, &generated_header());
}

#[test]
fn the_committed_fortran_interfaces_are_what_the_header_gives() {
    hold_to(INTERFACES, &fortran::interfaces(&Header::parse(&generated_header())));
}

/// cbindgen leaves out, without a word, what it cannot read and types that nothing uses.
#[test]
fn every_item_for_c_is_in_the_header() {
    let made = generated_header();
    let names: BTreeSet<&str> = made.split(|it: char| !it.is_alphanumeric() && it != '_').collect();
    let directory = in_crate("src/ffi");
    let listed: Vec<PathBuf> = SOURCES.iter().map(|name| directory.join(name)).collect();
    for file in rust_files(&directory) {
        for line in fs::read_to_string(&file).unwrap().lines() {
            let Some(item) = name_for_c(line) else { continue };
            let place = file.display();
            assert!(
                listed.contains(&file),
                "{item}: add {place} to SOURCES in tests/bindings/main.rs"
            );
            assert!(
                names.contains(item),
                "{item} of {place} is not in the header: a constant needs a literal value, a type \
                 a function that uses it"
            );
        }
    }
}

#[test]
fn the_shared_library_exports_exactly_the_functions_of_the_header() {
    let listing =
        run(Command::new("nm").args(["-D", "--defined-only", "--format=posix"]).arg(library()));
    let exported: BTreeSet<&str> =
        listing.lines().filter_map(|line| line.split_whitespace().next()).collect();
    let header = committed_header();
    let declared: BTreeSet<&str> = header.functions.iter().map(|it| &*it.name).collect();
    let unknown: Vec<_> = exported.difference(&declared).collect();
    let missing: Vec<_> = declared.difference(&exported).collect();
    assert!(unknown.is_empty(), "exported, but not in the header: {unknown:?}");
    assert!(missing.is_empty(), "in the header, but not exported: {missing:?}");
}

#[test]
fn the_shared_library_needs_only_the_c_runtime() {
    let listing = run(Command::new("readelf").args(["--dynamic", "--wide"]).arg(library()));
    let entries = |tag: &str| -> Vec<String> {
        let lines = listing.lines().filter(|line| line.contains(tag));
        lines
            .filter_map(|line| Some(line.split_once('[')?.1.split_once(']')?.0.to_owned()))
            .collect()
    };
    for needed in entries("(NEEDED)") {
        let runtime = ["libc.so.6", "libm.so.6", "libgcc_s.so.1"].contains(&&*needed);
        assert!(runtime || needed.starts_with("ld-linux"), "the library needs {needed}");
    }
    assert_eq!(entries("(SONAME)"), [format!("libperion.so.{}", perion_abi_version())]);
}

#[test]
fn the_committed_page_of_keys_is_what_the_library_knows() {
    hold_to(KEYS_PAGE, &page_of_keys());
}

#[test]
fn the_header_is_clean_in_every_dialect() {
    let twice =
        "#include \"perion.h\"\n#include \"perion.h\"\nint main(void) { return PERION_OK; }\n";
    for (compiler, ending, dialects) in
        [("gcc", "c", &["c99", "c11", "c17"][..]), ("g++", "cpp", &["c++11", "c++17"])]
    {
        let source = scratch(&format!("header.{ending}"));
        fs::write(&source, twice).unwrap();
        for dialect in dialects {
            run(Command::new(compiler)
                .arg(format!("-std={dialect}"))
                .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-I"])
                .arg(in_crate("include"))
                .arg(&source));
        }
    }
}

#[test]
fn the_fortran_interfaces_are_clean() {
    if !there_is("gfortran") {
        return;
    }
    run(Command::new("gfortran")
        .args(["-std=f2018", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-J"])
        .arg(scratch(""))
        .arg(in_crate(INTERFACES)));
}

#[test]
fn versions_agree() {
    let header = committed_header();
    let part = |name: &str| header.constant(name).unwrap_or_else(|| panic!("no {name}")).to_owned();
    let [major, minor, patch] =
        ["MAJOR", "MINOR", "PATCH"].map(|name| part(&format!("PERION_VERSION_{name}")));
    assert_eq!(format!("{major}.{minor}.{patch}"), env!("CARGO_PKG_VERSION"), "Cargo.toml, header");
    // SAFETY: the library returns text of its own that ends with NUL and is never freed.
    let text = unsafe { CStr::from_ptr(perion_version_string()) };
    assert_eq!(text.to_str().unwrap(), env!("CARGO_PKG_VERSION"), "perion_version_string");
    assert_eq!(part("PERION_ABI_VERSION"), perion_abi_version().to_string(), "perion_abi_version");
    if let Some(soname) = option_env!("PERION_ABI_VERSION") {
        assert_eq!(part("PERION_ABI_VERSION"), soname, "build.rs");
    }
    if let Ok(package) = fs::read_to_string(in_crate("bindings/pkgconfig/perion.pc.in")) {
        assert!(package.contains("Version: @VERSION@"), "perion.pc.in has a version of its own");
    }
}

#[test]
fn every_handle_can_be_destroyed() {
    let header = committed_header();
    assert!(!header.handles.is_empty());
    for handle in &header.handles {
        let name = format!("{handle}_destroy");
        let destroy = header.functions.iter().find(|it| it.name == name);
        let destroy = destroy.unwrap_or_else(|| panic!("there is no {name}"));
        let [address] = &destroy.parameters[..] else {
            panic!("{name} takes the handle's address")
        };
        assert_eq!((&address.ctype.base, address.ctype.pointers), (handle, 2), "{name}");
    }
}

#[test]
fn every_struct_begins_with_its_size() {
    for it in committed_header().structs {
        let first = &it.fields[0];
        assert_eq!((&*first.name, &*first.ctype.base), ("struct_size", "int64_t"), "{}", it.name);
    }
}

/// What `perion_formulation_name`, `perion_key_name` and their kin give, as a page.
fn page_of_keys() -> String {
    let mut page = String::from(
        "# Formulations and keys of models\n\nWritten by `make bindings`; a test holds it to the library. In a program \
         `perion_formulation_name`, `perion_key_name` and what stands beside them give the same. Numbers are \
         set by `perion_model_set`, choices by `perion_model_choose`; units are the host's own, consistent ones.\n\n\
         | formulation | what it is |\n| --- | --- |\n",
    );
    for entry in &FORMULATIONS {
        page += &format!("| `{}` | {} |\n", entry.name, entry.description);
    }
    page += "\n| key | takes | default | meaning |\n| --- | --- | --- | --- |\n";
    for key in &KEYS {
        let takes = match key.kind {
            Kind::Choice(choices) => format!("`{}`", choices.replace('|', "`, `")),
            Kind::NotNegative => "a number, 0 or more".to_owned(),
            Kind::Whole { least, most } => format!("a whole number from {least} to {most}"),
            Kind::Number { above, below } if below.is_infinite() && above.is_infinite() => {
                "a number".into()
            }
            Kind::Number { above, below } if below.is_infinite() => {
                format!("a number above {above}")
            }
            Kind::Number { above, below } => format!("a number above {above} and below {below}"),
        };
        let default = if key.default.is_empty() { "" } else { &format!("`{}`", key.default) };
        page += &format!("| `{}` | {takes} | {default} | {} |\n", key.name, key.description);
    }
    page
}

fn generated_header() -> String {
    let config = cbindgen::Config::from_file(in_crate("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for name in SOURCES {
        builder = builder.with_src(in_crate("src/ffi").join(name));
    }
    let mut text = Vec::new();
    builder.generate().unwrap_or_else(|error| panic!("cbindgen: {error}")).write(&mut text);
    String::from_utf8(text).unwrap()
}

fn committed_header() -> Header {
    let text = fs::read_to_string(in_crate(HEADER));
    Header::parse(&text.unwrap_or_else(|error| panic!("{HEADER}: {error}; run make bindings")))
}

/// Compares a committed file with what it should be, or writes it when `make bindings` asks.
fn hold_to(path: &str, wanted: &str) {
    let file = in_crate(path);
    if std::env::var_os("PERION_BLESS").is_some_and(|it| it == "1") {
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, wanted).unwrap();
        return;
    }
    let committed = fs::read_to_string(file).unwrap_or_default();
    if committed == wanted {
        return;
    }
    let same =
        committed.lines().zip(wanted.lines()).take_while(|(left, right)| left == right).count();
    let line = |text: &str| text.lines().nth(same).unwrap_or("(the end)").to_owned();
    panic!(
        "{path} is stale: run make bindings\nline {}\n  committed: {}\n  wanted:    {}",
        same + 1,
        line(&committed),
        line(wanted)
    );
}

/// The name of the item that a line of src/ffi gives to C. Such items stand at the first column.
fn name_for_c(line: &str) -> Option<&str> {
    let starts =
        ["pub const PERION_", "pub type perion_", "pub struct perion_", "pub enum perion_"];
    let functions = ["pub extern \"C\" fn perion_", "pub unsafe extern \"C\" fn perion_"];
    let start = starts.iter().chain(&functions).find(|&&start| line.starts_with(start))?;
    let name = &line[start.len() - "perion_".len()..];
    name.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next()
}

fn rust_files(directory: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|it| it == "rs") {
            files.push(path);
        }
    }
    files
}

/// The shared library beside this test: cargo builds it with the test, and copies it to
/// target/PROFILE only on `cargo build`, so that the copy may be an old one.
fn library() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let file = test.with_file_name("libperion.so");
    assert!(file.exists(), "there is no {}", file.display());
    file
}

fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}
