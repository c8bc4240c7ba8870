//! How much error a second buys: `make work-precision` runs problems with known answers by each formulation, at several
//! resolutions and horizons, on one thread, and writes what they gave into one table, `accuracy.csv`, and for each problem
//! into one that `examples/picture` draws. `make work-precision PROBLEMS="plane_wave traction_bar"` runs a part.
//!
//! `PROBLEMS=traction_bar_horizons` draws errors over the horizon instead, which takes an hour; names of formulations and
//! numbers of points across after it choose some.
//!
//! A formulation goes on to finer bodies as long as the next is not expected to take too long.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros, clippy::unwrap_used, missing_docs)]

mod horizons;
#[path = "../precision/mod.rs"]
mod precision;

use std::fmt::Write;
use std::fs;
use std::path::Path;

use precision::{METHODS, Method, Outcome, PROBLEMS, Problem, Resolution};

/// Of the horizon over the spacing.
const RATIOS: [usize; 3] = [2, 3, 4];

/// A run that is expected to take longer is left out, in seconds.
const LONGEST: f64 = 1.0;

/// Errors that a user may want.
const WANTED: [f64; 3] = [0.1, 0.01, 0.001];

const COLUMNS: &str =
    "problem,formulation,points_across,horizon_ratio,error,seconds,evaluations,bytes";

/// A run and what it gave.
struct Run {
    method: Method,
    resolution: Resolution,
    outcome: Outcome,
}

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let place = arguments.next().unwrap_or_else(|| "target/work_precision".into());
    fs::create_dir_all(&place).unwrap();
    let names: Vec<String> = arguments.collect();
    if names.first().is_some_and(|name| name == horizons::NAME) {
        horizons::run(&Path::new(&place).join(format!("{}.csv", horizons::NAME)), &names[1..]);
        return;
    }
    if let Some(name) = names.iter().find(|name| PROBLEMS.iter().all(|known| known.name != **name))
    {
        let known = PROBLEMS.map(|problem| problem.name).join(", ");
        eprintln!("unknown: '{name}'; there are {known}, and first of all {}", horizons::NAME);
        std::process::exit(2);
    }
    let mut table = format!("{COLUMNS}\n");
    for problem in PROBLEMS {
        if names.is_empty() || names.iter().any(|name| name == problem.name) {
            let runs = run_all(&problem);
            append(&mut table, &problem, &runs);
            write_curves(&Path::new(&place).join(format!("{}.csv", problem.name)), &runs);
            print_prices(&runs);
        }
    }
    fs::write(Path::new(&place).join("accuracy.csv"), table).unwrap();
}

fn run_all(problem: &Problem) -> Vec<Run> {
    println!("\n{}: {}\nerror of {}", problem.name, problem.title, problem.error_of);
    let mut runs = Vec::new();
    for method in METHODS {
        // Of the coarsest body with the last ratio.
        let mut coarse: Option<(Resolution, f64)> = None;
        for ratio in RATIOS {
            let mut last = coarse;
            for &across in problem.across {
                let resolution = Resolution { across, ratio };
                if last.is_some_and(|last| expected(last, resolution) > LONGEST) {
                    break;
                }
                match problem.run(method, resolution) {
                    Ok(outcome) => {
                        last = Some((resolution, outcome.seconds));
                        if across == problem.across[0] {
                            coarse = last;
                        }
                        let Outcome { error, seconds, evaluations, bytes } = outcome;
                        println!(
                            "{:<32}{across:>4}{ratio:>3}{:>11.4} %{seconds:>10.3} s{evaluations:>7}{:>9.2} MB",
                            method.name(),
                            100.0 * error,
                            1e-6 * bytes as f64
                        );
                        runs.push(Run { method, resolution, outcome });
                    }
                    Err(reason) => {
                        println!("{:<32}{across:>4}{ratio:>3}  -  {reason}", method.name());
                        break;
                    }
                }
            }
        }
    }
    runs
}

/// Seconds that a run may take by what another took: as the points, the bonds of each, and the steps.
fn expected((known, seconds): (Resolution, f64), next: Resolution) -> f64 {
    let [finer, larger] =
        [(next.across, known.across), (next.ratio, known.ratio)].map(|(a, b)| a as f64 / b as f64);
    seconds * finer.powi(4) * larger.powi(3)
}

fn append(table: &mut String, problem: &Problem, runs: &[Run]) {
    for Run { method, resolution: Resolution { across, ratio }, outcome } in runs {
        let Outcome { error, seconds, evaluations, bytes } = outcome;
        writeln!(
            table,
            "{},{},{across},{ratio},{error:.4e},{seconds:.4},{evaluations},{bytes}",
            problem.name,
            method.name()
        )
        .unwrap();
    }
}

/// What `picture --series` draws.
fn write_curves(path: &Path, runs: &[Run]) {
    let mut text = String::from("formulation,horizon over spacing,seconds,relative error\n");
    for Run { method, resolution, outcome } in runs {
        let (error, seconds) = (outcome.error.max(1e-7), outcome.seconds.max(1e-4));
        writeln!(text, "{},{},{seconds},{error}", method.name(), resolution.ratio).unwrap();
    }
    fs::write(path, text).unwrap();
}

/// The cheapest runs that were good enough, as a table of Markdown.
fn print_prices(runs: &[Run]) {
    println!(
        "\n| formulation | 10 % | 1 % | 0.1 % | least error |\n| --- | --- | --- | --- | --- |"
    );
    for method in METHODS {
        let of_method = || runs.iter().filter(move |run| run.method == method);
        let told = |Run { resolution: Resolution { across, ratio }, outcome, .. }: &Run| {
            format!("{:.2} s ({across}, {ratio})", outcome.seconds)
        };
        let cheapest = |wanted: f64| {
            of_method()
                .filter(|run| run.outcome.error <= wanted)
                .min_by(|a, b| a.outcome.seconds.total_cmp(&b.outcome.seconds))
                .map_or("-".into(), told)
        };
        let best = of_method().min_by(|a, b| a.outcome.error.total_cmp(&b.outcome.error));
        if let Some(best) = best {
            let prices = WANTED.map(cheapest).join(" | ");
            let least = 100.0 * best.outcome.error;
            println!("| {} | {prices} | {least:.2} %, {} |", method.name(), told(best));
        }
    }
}
