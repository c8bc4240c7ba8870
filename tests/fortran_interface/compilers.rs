//! What the tests need of the system: compilers, and the shared library that cargo has built.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{in_crate, place, run};

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

/// What hosts compile, in the order of the makefile.
pub fn module_sources() -> Vec<PathBuf> {
    let makefile = fs::read_to_string(in_crate("Makefile")).unwrap();
    let list = makefile.lines().find_map(|line| line.strip_prefix("FORTRAN_SOURCES := ")).unwrap();
    list.split_whitespace().map(|name| in_crate("bindings/fortran").join(name)).collect()
}

/// An empty directory of its own for each test.
pub fn directory(name: &str) -> PathBuf {
    place(&format!("fortran_interface/{name}"))
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
    compiler.args(["-std=c11", "-O2", "-I"]).arg(in_crate("include")).arg(source_file);
    linked(compiler, directory, program)
}

fn linked(mut compiler: Command, directory: &Path, program: &str) -> PathBuf {
    let program = directory.join(program);
    let library = library(directory);
    // Old tags: the path goes before LD_LIBRARY_PATH, where cargo puts directories of its own.
    let path = format!("-Wl,--disable-new-dtags,-rpath,{}", library.display());
    compiler.arg("-L").arg(&library).args(["-lperion", "-lm", &path, "-o"]).arg(&program);
    run(&mut compiler);
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
