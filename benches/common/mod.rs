//! What the benches share: bodies, clouds, models, and how times are taken and compared.
#![allow(dead_code)]

use std::time::Instant;

use perion::{Field, Model, Points, Quantity, Simulation, Skips};

/// Edge of a point's cell, in metres.
pub const SPACING: f64 = 1e-3;

/// Of the usual 3.015 spacings.
pub const HORIZON: f64 = 3.015 * SPACING;

pub const YOUNGS_MODULUS: f64 = 32e9;
pub const DENSITY: f64 = 2440.0;

/// A hundredth of what sound takes from point to point: every formulation is stable.
pub const TIME_STEP: f64 = 2.5e-9;

/// Poisson's ratio of a formulation.
pub fn poissons_ratio(formulation: &str) -> f64 {
    if formulation == "bond_based" { 0.25 } else { 0.2 }
}

/// Points along each axis.
#[derive(Clone, Copy)]
pub struct Body {
    pub name: &'static str,
    pub counts: [usize; 3],
}

pub const BODIES: [Body; 3] = [
    Body { name: "50", counts: [50, 50, 50] },
    Body { name: "plate", counts: [100, 100, 10] },
    Body { name: "100", counts: [100, 100, 100] },
];

/// For two threads over one, where a step is short.
pub const SMALL: Body = Body { name: "20", counts: [20, 20, 20] };

/// How the points stand: by name, and how far off a lattice at most, in spacings.
#[derive(Clone, Copy)]
pub struct Arrangement {
    pub name: &'static str,
    jitter: f64,
}

pub const ARRANGEMENTS: [Arrangement; 2] =
    [Arrangement { name: "lattice", jitter: 0.0 }, Arrangement { name: "cloud", jitter: 0.2 }];

/// Places of the points, row by row, in spacings from the corner of the body.
pub fn coordinates(body: Body, arrangement: Arrangement) -> Vec<f64> {
    let [width, depth, height] = body.counts;
    let mut random = Random(1);
    let mut places = Vec::new();
    for z in 0..height {
        for y in 0..depth {
            for x in 0..width {
                for along in [x, y, z] {
                    let off = arrangement.jitter * random.around_zero();
                    places.push((along as f64 + 0.5 + off) * SPACING);
                }
            }
        }
    }
    places
}

pub fn points(coordinates: &[f64]) -> Points {
    let volumes = vec![SPACING.powi(3); coordinates.len() / 3];
    Points::new(3, coordinates, &volumes).unwrap()
}

/// A plate of the first two coordinates of places in space.
pub fn plate(coordinates: &[f64]) -> Points {
    let places: Vec<f64> = coordinates.chunks(3).flat_map(|place| [place[0], place[1]]).collect();
    let volumes = vec![SPACING.powi(2); places.len() / 2];
    Points::new(2, &places, &volumes).unwrap()
}

/// A congruential generator: the same numbers everywhere.
struct Random(u64);

impl Random {
    /// From -1 to 1.
    fn around_zero(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

pub fn model(formulation: &str, breaks: bool) -> perion::Result<Model> {
    let mut model = Model::new(formulation)?;
    model.set("density", DENSITY)?;
    model.set("youngs_modulus", YOUNGS_MODULUS)?;
    model.set("horizon", HORIZON)?;
    if formulation != "bond_based" {
        model.set("poissons_ratio", poissons_ratio(formulation))?;
    }
    if breaks {
        // Far beyond what happens here: the test is made, and nothing breaks.
        model.set("critical_stretch", 0.1)?;
    }
    Ok(model)
}

/// Displacements without order, up to half a thousandth of the spacing.
pub fn shaken(count: usize) -> Vec<f64> {
    let mut random = Random(2);
    (0..3 * count).map(|_| 5e-4 * SPACING * random.around_zero()).collect()
}

/// A body ready to step, shaken.
pub fn simulation(
    points: &Points,
    formulation: &str,
    breaks: bool,
    threads: usize,
) -> perion::Result<Simulation> {
    let mut simulation = Simulation::new(points, &model(formulation, breaks)?)?;
    simulation.set_threads(threads)?;
    // Bonds are so far from breaking that no stretch would be looked at.
    simulation.set_skips(Skips { stretch_tests: false, ..Skips::default() })?;
    simulation.set(Field::Displacement, &shaken(points.count()))?;
    Ok(simulation)
}

/// The plate of the example `branching`, 200 x 80 x 8 points, pulled apart at its edges from a crack on; whether the crack
/// grows, and a time step that is stable for it.
pub fn branching(grows: bool, threads: usize) -> perion::Result<(Simulation, f64)> {
    let (length, height, depth, spacing) = (0.1, 0.04, 0.004, 5e-4);
    let (lower, upper) = ([0.0, -height / 2.0, 0.0], [length, height / 2.0, depth]);
    let mut points = Points::block(3, &lower, &upper, spacing)?;
    points.add_set_box("top", &[0.0, height / 2.0 - spacing, 0.0], &upper)?;
    points.add_set_box("bottom", &lower, &[length, spacing - height / 2.0, depth])?;
    let mut glass = Model::new("bond_based")?;
    glass.set("youngs_modulus", YOUNGS_MODULUS)?;
    glass.set("density", DENSITY)?;
    glass.set("horizon", 3.015 * spacing)?;
    if grows {
        glass.set("critical_energy_release_rate", 0.75)?;
    }
    let mut simulation = Simulation::new(&points, &glass)?;
    simulation.set_threads(threads)?;
    let middle = length / 2.0;
    let crack = [0.0, 0.0, 0.0, middle, 0.0, 0.0, middle, 0.0, depth, 0.0, 0.0, depth];
    simulation.break_crossing(&crack)?;
    for (set, sign) in [("top", 1.0), ("bottom", -1.0)] {
        simulation.prescribe(set, Quantity::BodyForce, 1, sign * 1e6 / spacing)?;
        if grows {
            simulation.forbid_failure(set)?;
        }
    }
    let step = 0.5 * simulation.stable_time_step()?;
    Ok((simulation, step))
}

pub fn seconds<T>(job: impl FnOnce() -> T) -> (T, f64) {
    let started = Instant::now();
    let result = job();
    (result, started.elapsed().as_secs_f64())
}

/// Seconds a step of so many.
pub fn seconds_a_step(simulation: &mut Simulation, steps: u64) -> f64 {
    seconds(|| simulation.step(TIME_STEP, steps).unwrap()).1 / steps as f64
}

/// Least and median.
pub fn least_and_median(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [values[0], values[values.len() / 2]]
}

/// Which of the names a bench is to run: those given as arguments, or all. `known` tells what names there are.
pub struct Choice(Vec<String>);

impl Choice {
    pub fn from_arguments(known: &[&[&str]]) -> Self {
        let given: Vec<String> =
            std::env::args().skip(1).filter(|name| name != "--bench").collect();
        for name in &given {
            if !known.iter().any(|names| names.contains(&name.as_str())) {
                eprintln!("unknown: '{name}'; there are {}", known.concat().join(", "));
                std::process::exit(2);
            }
        }
        Self(given)
    }

    /// Whether `name` is chosen among its kind: where none of the kind is, all are.
    pub fn has(&self, kind: &[&str], name: &str) -> bool {
        let chosen = |name: &str| self.0.iter().any(|given| given == name);
        chosen(name) || !kind.iter().any(|other| chosen(other))
    }
}

pub fn body_names() -> Vec<&'static str> {
    BODIES.iter().map(|body| body.name).collect()
}

pub fn arrangement_names() -> Vec<&'static str> {
    ARRANGEMENTS.iter().map(|arrangement| arrangement.name).collect()
}
