//! Draws a `.vtu` file that Perion wrote as a PNG: the points in the x-y plane, coloured by a field.
//!
//! `cargo run --release --example picture -- plate_000100.vtu plate.png --field damage`

// The library's promise to survive exhausted memory does not extend to this tool.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

mod colours;
mod options;
mod raster;
mod scene;
mod sheet;
mod text;
mod vtu;

use std::fs;
use std::process::ExitCode;

use options::{Options, Request, USAGE};
use scene::Scene;
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
    let scene = VtuFile::read(&options.input)
        .and_then(|file| Scene::new(&file, options))
        .map_err(|text| format!("{}: {text}", options.input))?;
    let png = sheet::compose(&scene, options.width).to_png()?;
    fs::write(&options.output, png)
        .map_err(|reason| format!("cannot write {}: {reason}", options.output))
}
