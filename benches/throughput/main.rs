//! Where the speed stands: `make bench` prints one table over formulations, arrangements, bodies, threads and damage, and what
//! the plain loops of `naive` do in turns with the same bodies. `make bench BENCH="bond_based cloud 50"` runs a part, `BENCH=threads` two threads against one, from bodies of 8000 points on, `BENCH=laws` all
//! material laws against Saint Venant-Kirchhoff's.
//!
//! Whole velocity Verlet steps in which nothing breaks. Stepping begins with the stable step, many evaluations of the forces:
//! where these are slow, they are timed alone and the line has a star. A body is left out where even that takes too long or
//! its memory is not there. Ratios count: on a shared machine absolute values drift.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros, clippy::unwrap_used, missing_docs)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../naive/mod.rs"]
mod naive;

use common::{ARRANGEMENTS, BODIES, Body, Choice, seconds, seconds_a_step};
use naive::Naive;
use perion::{FORMULATIONS, Field, Points, Simulation};

/// Seconds that a cell of the table is measured for, and steps at least.
const SECONDS: f64 = 0.7;
const STEPS: u64 = 3;

/// Where forces take longer on one thread, in seconds, no step is made.
const LONGEST_STEP: f64 = 0.3;

/// A body whose forces would take longer is left out.
const LONGEST_SWEEP: f64 = 2.5;

/// Rounds in which a plain loop and the library take turns.
const ROUNDS: usize = 11;

/// Formulations of which two threads are compared with one in turns.
const THREADED: [&str; 4] =
    ["bond_based", "ordinary_state_based", "correspondence", "bond_associated_quadrature"];

/// Formulations that ask material laws, one of points and one of bonds.
const LAWFUL: [&str; 2] = ["correspondence", "bond_associated_quadrature"];

const LAWS: [&str; 5] =
    ["saint_venant_kirchhoff", "neo_hookean", "small_strain", "hypoelastic", "j2_plastic"];

fn main() {
    let formulations: Vec<&str> = FORMULATIONS.iter().map(|entry| entry.name).collect();
    let arrangements = common::arrangement_names();
    let bodies = [common::body_names(), vec![common::SMALL.name]].concat();
    let kinds = ["table", "naive", "branching", "threads", "laws"];
    let choice = Choice::from_arguments(&[&formulations, &arrangements, &bodies, &kinds]);
    let chosen = |formulation: &str, arrangement: &str, body: &str| {
        choice.has(&formulations, formulation)
            && choice.has(&arrangements, arrangement)
            && choice.has(&bodies, body)
    };
    if choice.has(&kinds, "table") {
        println!(
            "Mb/s: million directed bond-steps a second, Mp/s: million point-steps a second, on 1 and 2 threads (1t, 2t); \
             with a critical stretch: dmg.\nBytes with damage. Set-up: from coordinates to families and what the \
             formulation prepares. A star: forces alone, without steps.\n"
        );
        println!(
            "{:<27}{:<8}{:>6} {:>7}{:>7}{:>7}{:>7} {:>7}{:>7} {:>8}{:>7} {:>7}{:>7}",
            "",
            "",
            "",
            "Mb/s 1t",
            "1t dmg",
            "2t",
            "2t dmg",
            "Mp/s 1t",
            "2t",
            "B/point",
            "B/bond",
            "set-up",
            "2t, s"
        );
        for formulation in &formulations {
            for arrangement in ARRANGEMENTS {
                let mut known: Option<Cell> = None;
                for body in BODIES {
                    if chosen(formulation, arrangement.name, body.name) {
                        print!("{formulation:<27}{:<8}{:>6} ", arrangement.name, body.name);
                        match measure(formulation, arrangement, body, known.as_ref()) {
                            Ok(cell) => {
                                cell.print();
                                known = Some(cell);
                            }
                            Err(reason) => println!("-  {reason}"),
                        }
                    }
                }
            }
        }
    }
    if choice.has(&kinds, "branching") {
        branching();
    }
    if choice.has(&kinds, "threads") {
        println!("\nTwo threads over one, with damage, in turns, medians of {ROUNDS} rounds");
        for formulation in THREADED {
            for arrangement in ARRANGEMENTS {
                for body in [common::SMALL, BODIES[0], BODIES[2]] {
                    if chosen(formulation, arrangement.name, body.name) {
                        two_over_one(formulation, arrangement, body);
                    }
                }
            }
        }
    }
    if choice.has(&kinds, "laws") {
        println!(
            "\nForces by the laws of {}, ms on one thread: least of {ROUNDS} rounds in turns, and over that of the first",
            LAWS.join(", ")
        );
        for formulation in LAWFUL {
            for arrangement in ARRANGEMENTS {
                for plane in [None, Some("strain"), Some("stress")] {
                    if chosen(formulation, arrangement.name, common::SMALL.name) {
                        of_laws(formulation, arrangement, plane);
                    }
                }
            }
        }
    }
    if choice.has(&kinds, "naive") {
        println!(
            "\nAgainst the plain loop (forces only, 1 thread), in turns, {ROUNDS} rounds: whole steps on 1 thread, with damage"
        );
        println!(
            "{:<27}{:<8}{:>6} {:>10}{:>9}{:>9}{:>12}{:>12}",
            "", "", "", "plain Mb/s", "Mb/s", "ratio", "ratio least", "difference"
        );
        for formulation in naive::KNOWN {
            for arrangement in ARRANGEMENTS {
                for body in BODIES {
                    if chosen(formulation, arrangement.name, body.name) {
                        against_naive(formulation, arrangement, body);
                    }
                }
            }
        }
    }
}

/// What is known of a formulation in a body.
struct Cell {
    points: f64,
    /// Directed bonds.
    bonds: f64,
    /// Seconds a step on 1 and 2 threads, without and with damage.
    step: [[f64; 2]; 2],
    /// Whole steps were timed, not forces alone.
    stepped: bool,
    bytes: f64,
    bond_bytes: f64,
    /// On 1 and on 2 threads.
    set_up: [f64; 2],
}

impl Cell {
    fn print(&self) {
        let Self { points, bonds, step: [[one, two], [one_damage, two_damage]], .. } = self;
        for time in [one, one_damage, two, two_damage] {
            if time.is_finite() {
                print!("{:>7.0}", 1e-6 * bonds / time);
            } else {
                print!("{:>7}", "-");
            }
        }
        print!(" {:>7.2}{:>7.2}", 1e-6 * points / one, 1e-6 * points / two);
        print!(" {:>8.0}{:>7.1}", self.bytes / points, self.bond_bytes / bonds);
        let star = if self.stepped { "" } else { " *" };
        println!(" {:>7.2}{:>7.2}{star}", self.set_up[0], self.set_up[1]);
    }
}

/// Measures a formulation in a body, unless what is `known` of a smaller one tells that it takes too long.
fn measure(
    formulation: &str,
    arrangement: common::Arrangement,
    body: Body,
    known: Option<&Cell>,
) -> Result<Cell, String> {
    let count = body.counts.iter().product::<usize>() as f64;
    if let Some(known) = known {
        let step = known.step[0][0] * count / known.points;
        if step > LONGEST_SWEEP {
            return Err(format!("its forces would take about {step:.1} s"));
        }
        let (bytes, free) = (known.bytes * count / known.points, free_bytes());
        if bytes > 0.7 * free {
            return Err(format!("needs about {:.1} GB, {:.1} are free", 1e-9 * bytes, 1e-9 * free));
        }
    }
    let coordinates = common::coordinates(body, arrangement);
    let mut cell = Cell {
        points: count,
        bonds: 0.0,
        step: [[0.0; 2]; 2],
        stepped: false,
        bytes: 0.0,
        bond_bytes: 0.0,
        set_up: [0.0; 2],
    };
    for (breaks, threads) in [(false, 1), (true, 2)] {
        let (made, time) = seconds(|| {
            let points = common::points(&coordinates);
            let simulation = common::simulation(&points, formulation, breaks, threads)?;
            // What asks for the families first builds them.
            simulation.bond_count()?;
            Ok(simulation)
        });
        let mut simulation: Simulation = made.map_err(|error: perion::Error| error.to_string())?;
        let (bonds, counting) = seconds(|| simulation.bond_count());
        cell.bonds = 2.0 * bonds.map_err(|error| error.to_string())? as f64;
        cell.set_up[threads - 1] = time - counting;
        simulation.set_threads(1).map_err(|error| error.to_string())?;
        let alone = sweep_seconds(&mut simulation) > LONGEST_STEP;
        if !alone {
            // The stable step is found by both threads.
            simulation.set_threads(2).map_err(|error| error.to_string())?;
            seconds_a_step(&mut simulation, 1);
        }
        cell.stepped = !alone;
        for threads in [1, 2] {
            simulation.set_threads(threads).map_err(|error| error.to_string())?;
            let time = if alone && breaks {
                f64::NAN
            } else if alone {
                median(|_| sweep_seconds(&mut simulation))
            } else {
                median(|steps| seconds_a_step(&mut simulation, steps))
            };
            cell.step[usize::from(breaks)][threads - 1] = time;
        }
        let memory = simulation.memory();
        (cell.bytes, cell.bond_bytes) = (memory.total() as f64, memory.bonds as f64);
    }
    Ok(cell)
}

/// Steps on two threads and on one take turns with the same body.
fn two_over_one(formulation: &str, arrangement: common::Arrangement, body: Body) {
    let points = common::points(&common::coordinates(body, arrangement));
    let mut simulation = common::simulation(&points, formulation, true, 2).unwrap();
    // The stable step is found first.
    let step = seconds_a_step(&mut simulation, 1).min(seconds_a_step(&mut simulation, 1));
    let steps = (0.05 / step).clamp(1.0, 200.0) as u64;
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..ROUNDS {
        for threads in [1, 2] {
            simulation.set_threads(threads).unwrap();
            times[threads - 1].push(seconds_a_step(&mut simulation, steps));
        }
    }
    let [one, two] = times.map(|times| common::least_and_median(times)[1]);
    println!(
        "{formulation:<27}{:<8}{:>6} {:>10.3}{:>10.3} ms {:>6.2}",
        arrangement.name,
        body.name,
        1e3 * one,
        1e3 * two,
        one / two
    );
}

/// The laws take turns with the same body: 20^3 points of a solid, or 90^2 of a plate.
fn of_laws(formulation: &str, arrangement: common::Arrangement, plane: Option<&str>) {
    let counts = if plane.is_some() { [90, 90, 1] } else { common::SMALL.counts };
    let body = Body { name: "", counts };
    let points = match plane {
        Some(_) => common::plate(&common::coordinates(body, arrangement)),
        None => common::points(&common::coordinates(body, arrangement)),
    };
    let mut bodies = LAWS.map(|law| {
        let mut model = common::model(formulation, false).unwrap();
        model.choose("material", law).unwrap();
        plane.into_iter().for_each(|plane| model.choose("plane", plane).unwrap());
        if law == "j2_plastic" {
            model.set("yield_stress", 5e-4 * common::YOUNGS_MODULUS).unwrap();
        }
        let mut simulation = Simulation::new(&points, &model).unwrap();
        simulation.set_threads(1).unwrap();
        let moved = &common::shaken(points.count())[..points.dimension() * points.count()];
        simulation.set(Field::Displacement, moved).unwrap();
        sweep_seconds(&mut simulation);
        simulation
    });
    let mut times = LAWS.map(|_| Vec::new());
    for _ in 0..ROUNDS {
        for (times, body) in times.iter_mut().zip(&mut bodies) {
            times.push(sweep_seconds(body));
        }
    }
    let least = times.map(|times| common::least_and_median(times)[0]);
    print!("{formulation:<27}{:<8}{:<7}", arrangement.name, plane.unwrap_or("solid"));
    least.iter().for_each(|least| print!("{:>9.2}", 1e3 * least));
    least[1..].iter().for_each(|other| print!("{:>7.1}", other / least[0]));
    println!();
}

/// What growing cracks cost: the same plate with and without damage, in turns, from the start until the crack has branched.
fn branching() {
    const STEPS: u64 = 400;
    const TURN: u64 = 20;
    println!("\nbranching, 200 x 80 x 8 points, {STEPS} steps with and without damage, in turns");
    for threads in [1, 2] {
        let (mut growing, step) = common::branching(true, threads).unwrap();
        let (mut whole, _) = common::branching(false, threads).unwrap();
        let mut times = [0.0; 2];
        for _ in 0..STEPS / TURN {
            times[0] += seconds(|| growing.step(step, TURN).unwrap()).1;
            times[1] += seconds(|| whole.step(step, TURN).unwrap()).1;
        }
        let [with, without] = times;
        println!(
            "{threads} threads: {with:.2} s and {without:.2} s, {:.1} % more; {} bonds broken",
            100.0 * (with / without - 1.0),
            growing.health().unwrap().broken_bonds
        );
    }
}

/// Median of seconds a step, as often as the time allows; `time` is told how many steps to take in a row.
fn median(mut time: impl FnMut(u64) -> f64) -> f64 {
    let first = time(1);
    let steps = ((SECONDS / first) as u64).max(STEPS);
    let (samples, each) = (steps.clamp(STEPS, 9), (steps / 9).max(1));
    common::least_and_median((0..samples).map(|_| time(each)).collect())[1]
}

/// Seconds that the forces take alone.
fn sweep_seconds(simulation: &mut Simulation) -> f64 {
    let displacement = simulation.get(Field::Displacement).unwrap();
    simulation.set(Field::Displacement, &displacement).unwrap();
    seconds(|| simulation.evaluate().unwrap()).1
}

/// Bytes of memory that the system could give; infinite where it does not say.
fn free_bytes() -> f64 {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("MemAvailable:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
    kilobytes.map_or(f64::INFINITY, |kilobytes| 1024.0 * kilobytes)
}

/// The library and the plain loop take turns with the same body.
fn against_naive(formulation: &str, arrangement: common::Arrangement, body: Body) {
    let points: Points = common::points(&common::coordinates(body, arrangement));
    let displacement = common::shaken(points.count());
    let mut model = common::model(formulation, true).unwrap();
    if formulation == "correspondence" {
        model.choose("influence", "constant").unwrap();
        model.choose("material", "saint_venant_kirchhoff").unwrap();
    }
    let mut simulation = Simulation::new(&points, &model).unwrap();
    simulation.set_threads(1).unwrap();
    simulation.set(Field::Displacement, &displacement).unwrap();
    simulation.evaluate().unwrap();
    let mut naive = Naive::new(&points, &displacement, &simulation);
    naive.sweep(formulation);
    let difference = naive.difference(&simulation.get(Field::InternalForce).unwrap());
    let steps = (0.1 / seconds_a_step(&mut simulation, 1)).clamp(1.0, 20.0) as u64;
    let (mut own, mut plain) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        plain.push(seconds(|| naive.sweep(formulation)).1);
        own.push(seconds_a_step(&mut simulation, steps));
    }
    let bonds = naive.bond_count() as f64;
    let ([least, median], [plain_least, plain_median]) =
        (common::least_and_median(own), common::least_and_median(plain));
    println!(
        "{formulation:<27}{:<8}{:>6} {:>10.0}{:>9.0}{:>9.2}{:>12.2}{difference:>12.1e}",
        arrangement.name,
        body.name,
        1e-6 * bonds / plain_median,
        1e-6 * bonds / median,
        plain_median / median,
        plain_least / least
    );
}
