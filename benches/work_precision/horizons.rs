//! Errors of the bar of [P] 5.1 over horizon and resolution, as in figures 13 and 14: of the length change, in percent, signed,
//! against the one-dimensional bar.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use perion::Result;

use crate::precision::bars::TractionBar;
use crate::precision::budget;

pub const NAME: &str = "traction_bar_horizons";

/// The one whose modes cost nothing, and which takes the longest, last.
const FORMULATIONS: [&str; 4] =
    ["bond_based", "ordinary_state_based", "bond_associated_quadrature", "correspondence"];
const ACROSS: [usize; 3] = [5, 10, 20];
const RATIOS: [usize; 6] = [2, 3, 4, 5, 6, 7];

/// Writes what `picture --series` draws, a row for each bar that was solved, of these formulations and points across (of all, if
/// none are named).
pub fn run(path: &Path, chosen: &[String]) {
    let mut table =
        String::from("formulation,points across,horizon over spacing,error (%),forces\n");
    let (numbers, names): (Vec<&String>, Vec<&String>) =
        chosen.iter().partition(|one| one.parse::<usize>().is_ok());
    let is_chosen =
        |known: &[&String], name: &str| known.is_empty() || known.iter().any(|one| *one == name);
    for formulation in FORMULATIONS.into_iter().filter(|name| is_chosen(&names, name)) {
        for across in ACROSS.into_iter().filter(|across| is_chosen(&numbers, &across.to_string())) {
            for ratio in RATIOS {
                print!("{formulation:<32}{across:>4}{ratio:>3}");
                match solve(formulation, TractionBar { across, ratio }) {
                    Ok((error, forces)) => {
                        println!("{error:>11.4} %{forces:>7}");
                        writeln!(table, "{formulation},{across},{ratio},{error:.4},{forces}")
                            .unwrap();
                    }
                    Err(reason) => println!("  -  {reason}"),
                }
                fs::write(path, &table).unwrap();
            }
        }
    }
}

/// Error in percent, and forces evaluated.
fn solve(formulation: &str, scene: TractionBar) -> Result<(f64, u64)> {
    let mut bar = scene.simulation(&scene.usual_model(formulation))?;
    let forces = bar.solve(&budget())?.evaluations;
    Ok((TractionBar::error(&bar, formulation), forces))
}
