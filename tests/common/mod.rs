//! What the tests share that compile and run programs of other languages.
#![allow(dead_code)] // each test crate uses its share

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A path within the repository.
pub fn in_crate(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A new directory of its own for a test, among cargo's own files.
pub fn place(name: &str) -> PathBuf {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&place);
    fs::create_dir_all(&place).unwrap();
    place
}

/// Whether a program is there to be run; says so when it is not.
pub fn there_is(program: &str) -> bool {
    found(program, runs(Path::new(program)))
}

/// A program of tests/requirements.txt (or the Python that has its packages): as scripts/tools.sh has
/// installed it, or as the machine has it. Says so when it is not there.
pub fn tool(program: &str) -> Option<PathBuf> {
    let installed = std::env::var_os("PERION_TOOLS").map(PathBuf::from);
    let path = [installed, Some(in_crate("target/tools/bin"))]
        .into_iter()
        .flatten()
        .map(|place| place.join(program))
        .find(|path| path.is_file())
        .unwrap_or_else(|| PathBuf::from(program));
    found(program, runs(&path)).then_some(path)
}

fn runs(program: &Path) -> bool {
    Command::new(program).arg("--version").output().is_ok()
}

fn found(program: &str, there: bool) -> bool {
    if !there {
        // Past the capture of the test runner, so that the closing line can count it.
        let _ = writeln!(std::io::stderr(), "skipped: {program} is not installed");
    }
    there
}

/// Runs a command that must succeed; gives what it prints.
pub fn run(command: &mut Command) -> String {
    // What cargo puts there is not what a user has.
    command.env_remove("LD_LIBRARY_PATH");
    let Output { status, stdout, stderr } =
        command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let (out, err) = (String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    assert!(status.success(), "{command:?}: {status}\n{out}{err}");
    out.into_owned()
}
