//! A plane wave: a hump that runs along a bar whose points move along it alone, at the speed of a solid.

use perion::{Field, Points, Quantity, Result, Simulation};

use super::{Answer, Method, Problem, Resolution, relative_difference};

pub const PLANE_WAVE: Problem = Problem {
    name: "plane_wave",
    title: "plane wave after 2.5 widths of the bar",
    error_of: "displacement, root mean square over the bar; exact: the hump at the speed of pressure waves",
    across: &[4, 6, 9, 13, 19, 28],
    run,
};

/// The bar is one wide.
const LENGTH: usize = 8;
/// Where the hump is at first, how far it runs, and how wide it is.
const START: f64 = 2.75;
const WAY: f64 = 2.5;
const WIDTH: f64 = 0.7;
/// So small that all is linear.
const HEIGHT: f64 = 1e-6;

const MODULUS: f64 = 1.0;
const RATIO: f64 = 0.25;

fn run(method: Method, Resolution { across, ratio }: Resolution) -> Result<Answer> {
    let spacing = 1.0 / across as f64;
    let upper = [LENGTH as f64, 1.0, 1.0];
    let mut points = Points::block(3, &[0.0; 3], &upper, spacing)?;
    points.add_set_box("bar", &[0.0; 3], &upper)?;
    let model = method.model(&[
        ("density", 1.0),
        ("youngs_modulus", MODULUS),
        ("poissons_ratio", RATIO),
        ("horizon", 1.005 * ratio as f64 * spacing),
    ])?;
    let mut bar = Simulation::new(&points, &model)?;
    bar.set_threads(1)?;
    for axis in [1, 2] {
        bar.prescribe("bar", Quantity::Displacement, axis, 0.0)?;
    }
    let speed = (MODULUS * (1.0 - RATIO) / ((1.0 + RATIO) * (1.0 - 2.0 * RATIO))).sqrt();
    let along: Vec<f64> = points.coordinates().iter().step_by(3).copied().collect();
    let axial = |value: &dyn Fn(f64) -> f64| -> Vec<f64> {
        along.iter().flat_map(|x| [value(x - START), 0.0, 0.0]).collect()
    };
    bar.set(Field::Displacement, &axial(&hump))?;
    bar.set(Field::Velocity, &axial(&|x| 2.0 * speed * x / (WIDTH * WIDTH) * hump(x)))?;
    let until = WAY / speed;
    let steps = (until / (0.5 * bar.stable_time_step()?)).ceil();
    bar.step(until / steps, steps as u64)?;
    let found = bar.get(Field::Displacement)?;
    let both =
        found.iter().step_by(3).zip(&along).map(|(found, x)| [*found, hump(x - START - WAY)]);
    Ok(Answer { error: relative_difference(both), evaluations: steps as u64 + 1, body: bar })
}

fn hump(x: f64) -> f64 {
    HEIGHT * (-(x / WIDTH) * (x / WIDTH)).exp()
}
