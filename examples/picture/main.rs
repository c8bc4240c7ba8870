//! Draws what Perion and the examples write as a PNG: the points of a `.vtu` file in the x-y plane or seen
//! from aside, coloured by a field; a curve of a `.csv` file, or several on logarithmic axes; or a map of one, such as velocity over place and time.
//!
//! `cargo run --release --example picture -- plate_000100.vtu plate.png --field damage`

// The library's promise to survive exhausted memory does not extend to this tool.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

mod axes;
mod bar;
mod cells;
mod colours;
mod curve;
mod map;
mod options;
mod raster;
mod scene;
mod series;
mod sheet;
mod table;
mod text;
mod view;
mod vtu;

use std::fs;
use std::process::ExitCode;

use options::{Kind, Options, Request, USAGE};
use scene::Scene;
use table::Table;
use vtu::VtuFile;

fn main() -> ExitCode {
    let result = Request::parse(std::env::args().skip(1)).and_then(|request| match request {
        Request::Help => {
            println!("{USAGE}");
            Ok(())
        }
        Request::Draw(options) => draw(&options),
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            eprintln!("picture: {text}");
            ExitCode::FAILURE
        }
    }
}

fn draw(options: &Options) -> Result<(), String> {
    let input = options.input.as_str();
    let canvas = match options.kind {
        Kind::Points => VtuFile::read(input)
            .and_then(|file| Scene::new(&file, options))
            .map(|scene| sheet::compose(&scene, options.width)),
        Kind::Curve | Kind::Curves => {
            Table::read(input).and_then(|table| curve::compose(&table, options))
        }
        Kind::Series => fs::read_to_string(input)
            .map_err(|reason| format!("cannot be read: {reason}"))
            .and_then(|text| series::compose(&text, options)),
        Kind::Map => Table::read(input).and_then(|table| map::compose(&table, options)),
    };
    let png = canvas.map_err(|text| format!("{input}: {text}"))?.to_png()?;
    fs::write(&options.output, png)
        .map_err(|reason| format!("cannot write {}: {reason}", options.output))
}
