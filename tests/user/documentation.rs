//! The programs of docs/embedding.md: each compiles without a warning and prints the same energy, but the one
//! marked as callbacks, whose scene is another.

use crate::common::{in_crate, place, run, there_is};
use crate::install::setting;
use crate::{prefix, rpath};
use perion::{Field, Model, Points, Quantity, Simulation};
use std::fs;
use std::process::Command;

/// The code blocks of a page with their languages.
fn blocks(page: &str) -> Vec<(String, String)> {
    let text = fs::read_to_string(in_crate(page)).unwrap();
    let mut blocks = Vec::new();
    for block in text.split("\n```").skip(1).step_by(2) {
        let (language, code) = block.split_once('\n').unwrap();
        blocks.push((language.to_owned(), code.to_owned()));
    }
    blocks
}

#[test]
fn the_programs_of_the_page_on_embedding_print_the_same_energy() {
    let place = place("user/embedding");
    let sources = prefix().join("share/perion/fortran");
    let (mut energies, mut called_back) = (Vec::new(), false);
    for (number, (language, code)) in blocks("docs/embedding.md").into_iter().enumerate() {
        // ```fortran callbacks
        let (language, scene) = language.split_once(' ').unwrap_or((&language, "bar"));
        let (compiler, flags, ending) = match language {
            "c" => ("gcc", &["-std=c99", "-O1"][..], "c"),
            "cpp" => ("g++", &["-std=c++11", "-O1"][..], "cpp"),
            "fortran" => (
                "gfortran",
                &[
                    "-std=f2018",
                    "-O1",
                    "-fcheck=all",
                    "-finit-real=snan",
                    "-ffpe-trap=zero,invalid,overflow",
                ][..],
                "f90",
            ),
            other => panic!("a block in {other}, which nothing compiles"),
        };
        if !there_is(compiler) {
            continue;
        }
        let (source, program) =
            (place.join(format!("{number}.{ending}")), place.join(number.to_string()));
        fs::write(&source, code).unwrap();
        let mut command = Command::new(compiler);
        command.args(flags).args(["-Wall", "-Wextra", "-Wpedantic", "-Werror"]);
        if language == "fortran" {
            command.arg("-J").arg(&place);
            command.args(
                setting("Makefile", "FORTRAN_SOURCES :=")
                    .split_whitespace()
                    .map(|name| sources.join(name)),
            );
        } else {
            command.arg("-I").arg(prefix().join("include"));
        }
        command.arg(&source).arg("-o").arg(&program);
        command.arg("-L").arg(prefix().join("lib")).args(["-lperion", "-lm", &rpath()]);
        run(&mut command);
        let said = run(&mut Command::new(&program));
        let energy = said.trim_end().lines().last().and_then(|line| {
            line.strip_prefix("elastic energy ")?.strip_suffix(" J")?.parse::<f64>().ok()
        });
        let energy = energy.unwrap_or_else(|| panic!("{said}"));
        if scene == "callbacks" {
            assert!(energy.is_finite() && energy > 0.1, "{said}");
            for words in ["1 of 1 pairs", "300 of 300 steps"] {
                assert!(said.contains(words), "{said}");
            }
            called_back = true;
        } else {
            energies.push((language.to_owned(), energy));
        }
    }
    assert!(
        (energies.len(), called_back) == (5, true) || !there_is("g++") || !there_is("gfortran")
    );
    // Nine decimals are printed of some joules; host and library round differently.
    let (_, first) = &energies[0];
    assert!(*first > 0.1, "{energies:?}");
    for (language, energy) in &energies {
        assert!((energy - first).abs() <= 1e-9 * (1.0 + first), "{language}: {energies:?}");
    }
}

#[test]
fn the_page_on_errors_has_every_status_with_its_number() {
    let page = fs::read_to_string(in_crate("docs/errors.md")).unwrap();
    let header = fs::read_to_string(in_crate("include/perion.h")).unwrap();
    let mut found = 0;
    for line in header.lines() {
        let mut words = line.split_whitespace();
        let (Some("#define"), Some(name), Some(number)) =
            (words.next(), words.next(), words.next())
        else {
            continue;
        };
        if name == "PERION_OK" || name.starts_with("PERION_ERROR_") {
            found += 1;
            assert!(page.contains(&format!("| `{name}` | {number} |")), "{name} {number}");
        }
    }
    assert_eq!(found, 13);
}

#[test]
fn the_page_on_errors_quotes_what_the_library_says() {
    let page = fs::read_to_string(in_crate("docs/errors.md")).unwrap();
    let mut model = Model::new("bond_based").unwrap();
    let misspelt = model.set("yongs_modulus", 1.0).unwrap_err();
    for (key, value) in [("youngs_modulus", 1.0), ("density", 1.0), ("horizon", 0.5)] {
        model.set(key, value).unwrap();
    }
    let row = Points::new(2, &[0.0, 0.0, 1.0, 0.0], &[1.0; 2]).unwrap();
    let mut bar = |horizon| {
        model.set("horizon", horizon).unwrap();
        Simulation::new(&row, &model).unwrap()
    };
    let lonely = bar(0.5).evaluate().unwrap_err();
    let mut pair = bar(1.5);
    let too_long = pair.step(1e3, 1).unwrap_err();
    pair.prescribe("all", Quantity::Velocity, 0, 0.0).unwrap();
    let stale = pair.get(Field::Reaction).unwrap_err();
    let double = Points::new(2, &[0.0; 4], &[1.0; 2]).unwrap_err();
    for (error, words) in [
        (misspelt, "unknown key 'yongs_modulus'; did you mean 'youngs_modulus'?"),
        (lonely, "reaches no neighbour of any point"),
        (too_long, "times the stable step"),
        (stale, "evaluate or step first"),
        (double, "stand in one place"),
    ] {
        assert!(error.to_string().contains(words), "{error}");
        assert!(page.contains(&format!("| `{words}` |")), "{words}");
    }
    // Of the C interface, whose own tests provoke them.
    for words in ["is in use by another call", "let perion_energy_init set it"] {
        assert!(page.contains(&format!("| `{words}` |")), "{words}");
    }
}
