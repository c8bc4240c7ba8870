//! The same example in C, in Fortran and in Rust.

use std::fs;
use std::process::Command;

use crate::common::{self, in_crate, run, there_is};
use crate::compilers;

const SIDE: &str = "PERION_TEST_RUST_TWIN";

/// Where the twin in Rust, a process of its own whose number of threads its environment tells, leaves
/// its file; `None` in the test itself.
pub fn rust_side() -> Option<String> {
    std::env::var(SIDE).ok().inspect(|_| println!())
}

/// Runs an example in C, in Fortran and, as the test `name`, in Rust: what they print and write must be
/// the same. The file has at least so many rows.
pub fn compare_twins(name: &str, example: &str, arguments: &[&str], rows: usize) {
    if !(there_is("cc") && there_is("gfortran")) {
        return;
    }
    let directory = common::place(&format!("examples/{example}"));
    let source = |ending| in_crate(&format!("examples/{example}/main.{ending}"));
    let in_c = compilers::c(&directory, &format!("{example}_c"), &source("c"));
    let mut sources = compilers::module_sources();
    sources.push(source("f90"));
    let in_fortran = compilers::fortran(&directory, example, &sources, "-O2");
    let mut twins = Vec::new();
    for threads in ["1", "2"] {
        let [mut c, mut fortran] = [&in_c, &in_fortran].map(Command::new);
        c.args(arguments).arg(directory.join("c.csv")).arg("");
        fortran.args(arguments).arg(directory.join("fortran.csv")).arg("");
        let mut rust = Command::new(std::env::current_exe().unwrap());
        rust.args([name, "--exact", "--nocapture"]).env(SIDE, &directory);
        for (mut twin, file) in [(c, "c.csv"), (fortran, "fortran.csv"), (rust, "rust.csv")] {
            let printed = run(twin.env("PERION_NUM_THREADS", threads));
            let table = fs::read_to_string(directory.join(file)).unwrap();
            twins.push((results(&printed), table));
        }
    }
    assert!(twins[0].0.len() > 5 && twins[0].1.lines().count() > rows, "{twins:?}");
    for twin in &twins {
        assert_eq!(twin, &twins[0]);
    }
}

/// What an example prints, without what the test runner does.
fn results(printed: &str) -> Vec<String> {
    let lines = printed.lines().skip_while(|line| !line.contains(" points, "));
    let mut results = Vec::new();
    for line in lines {
        results.push(line.to_owned());
        if line.starts_with("hash ") {
            return results;
        }
    }
    panic!("there is no hash in {printed}");
}
