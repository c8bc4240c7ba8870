//! What the tests need of the system: compilers, and the shared library that cargo has built.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Warnings are errors; what is read before it is set is a signalling number and traps.
const FORTRAN: [&str; 9] = [
    "-std=f2018",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-fcheck=all",
    "-finit-real=snan",
    "-ffpe-trap=zero,invalid,overflow",
    // No fused operations: the tests compute some results again, to the last bit.
    "-ffp-contract=off",
    "-g",
];

/// A path within the repository.
pub fn source(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// An empty directory of its own for each test.
pub fn directory(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fortran_interface").join(name);
    let _ = fs::remove_dir_all(&directory);
    fs::create_dir_all(&directory).unwrap();
    directory
}

/// Whether a program is there to be run; says so when it is not.
pub fn installed(program: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok();
    if !there {
        // Past the capture of the test runner, so that the closing line can count it.
        let _ = std::io::Write::write_all(
            &mut std::io::stderr(),
            format!("skipped: {program} is not installed\n").as_bytes(),
        );
    }
    there
}

/// Compiles Fortran sources, each after those it needs, and links them with the library.
pub fn fortran(
    directory: &Path,
    program: &str,
    sources: &[PathBuf],
    optimisation: &str,
) -> PathBuf {
    let mut compiler = Command::new("gfortran");
    compiler.args(FORTRAN).arg(optimisation).arg("-J").arg(directory).args(sources);
    linked(compiler, directory, program)
}

/// Compiles a program in C and links it with the library.
pub fn c(directory: &Path, program: &str, source_file: &Path) -> PathBuf {
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "-O2", "-I"]).arg(source("include")).arg(source_file);
    linked(compiler, directory, program)
}

fn linked(mut compiler: Command, directory: &Path, program: &str) -> PathBuf {
    let program = directory.join(program);
    let library = library(directory);
    // Old tags: the path goes before LD_LIBRARY_PATH, where cargo puts directories of its own.
    let path = format!("-Wl,--disable-new-dtags,-rpath,{}", library.display());
    compiler.arg("-L").arg(&library).args(["-lperion", "-lm", &path, "-o"]).arg(&program);
    output_of(&mut compiler);
    program
}

/// A directory where linker and loader find the library under the names that they look for.
fn library(directory: &Path) -> PathBuf {
    let built = std::env::current_exe().unwrap().with_file_name("libperion.so");
    let directory = directory.join("lib");
    fs::create_dir_all(&directory).unwrap();
    for name in ["libperion.so", "libperion.so.0"] {
        let link = directory.join(name);
        let _ = fs::remove_file(&link);
        std::os::unix::fs::symlink(&built, link).unwrap();
    }
    directory
}

/// Runs a command that must succeed; gives what it prints.
pub fn output_of(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|reason| panic!("{command:?}: {reason}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (printed, complaints) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}\n{printed}{complaints}", output.status);
    printed
}
