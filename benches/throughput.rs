//! Where the speed stands: million directed bond-steps per second of bond-based steps on a block of
//! 50 x 50 x 50 points, as a lattice and as a cloud that is jittered by a fifth of the spacing, horizon 3.015 spacings,
//! against the plain loop over a list of bonds that one would write first. All are timed in turns in one run; the
//! medians count.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros, clippy::unwrap_used)]

use std::time::Instant;

use perion::{Field, Model, Points, Simulation};

const ROUNDS: usize = 11;
const STEPS: u64 = 4;

/// A bond as the plain loop stores it: 24 bytes.
struct NaiveBond {
    neighbor: usize,
    length: f64,
    volume: f64,
}

/// The plain loop: positions, bonds one after the other, a square root and two divisions each.
struct Naive {
    offsets: Vec<usize>,
    bonds: Vec<NaiveBond>,
    position: Vec<[f64; 3]>,
    force: Vec<[f64; 3]>,
}

impl Naive {
    fn new(points: &Points, simulation: &Simulation) -> Self {
        let count = points.count();
        let (position, _) = points.coordinates().as_chunks::<3>();
        let mut lists = vec![Vec::new(); count];
        let keep = |[i, j]: [usize; 2], _, _| {
            lists[i].push(j);
            lists[j].push(i);
        };
        simulation.for_each_bond(keep).unwrap();
        let mut offsets = vec![0];
        let mut bonds = Vec::new();
        for (i, list) in lists.iter().enumerate() {
            for &j in list {
                let squared: f64 = (0..3).map(|k| (position[j][k] - position[i][k]).powi(2)).sum();
                let volume = points.volumes()[j];
                bonds.push(NaiveBond { neighbor: j, length: squared.sqrt(), volume });
            }
            offsets.push(bonds.len());
        }
        Self { offsets, bonds, position: position.to_vec(), force: vec![[0.0; 3]; count] }
    }

    fn sweep(&mut self, constant: f64) {
        for (i, force) in self.force.iter_mut().enumerate() {
            let mut sum = [0.0; 3];
            let own = self.position[i];
            for bond in &self.bonds[self.offsets[i]..self.offsets[i + 1]] {
                let other = self.position[bond.neighbor];
                let y = [other[0] - own[0], other[1] - own[1], other[2] - own[2]];
                let now = (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]).sqrt();
                let stretch = (now - bond.length) / bond.length;
                let factor = constant * stretch * bond.volume / now;
                for axis in 0..3 {
                    sum[axis] += factor * y[axis];
                }
            }
            *force = sum;
        }
    }
}

fn body(points: &Points, spacing: f64, breaks: bool, threads: usize) -> Simulation {
    let mut model = Model::new("bond_based").unwrap();
    model.set("density", 2440.0).unwrap();
    model.set("youngs_modulus", 32e9).unwrap();
    model.set("horizon", 3.015 * spacing).unwrap();
    if breaks {
        model.set("critical_stretch", 0.1).unwrap();
    }
    let mut simulation = Simulation::new(points, &model).unwrap();
    simulation.set_threads(threads).unwrap();
    let random = (0..3 * points.count()).map(|k| ((k as f64 * 0.7548776662).fract() - 0.5) * 1e-3);
    let displacement: Vec<f64> = random.map(|value| value * spacing).collect();
    simulation.set(Field::Displacement, &displacement).unwrap();
    simulation
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The block (of another edge than 50 points, if the environment has N) as it is, or with each coordinate moved at random by up to a fifth of the spacing.
fn block(spacing: f64, jitter: f64) -> Points {
    let edge = std::env::var("N").map_or(50.0, |n| n.parse().unwrap()) * spacing;
    let block = Points::block(3, &[0.0; 3], &[edge; 3], spacing).unwrap();
    let moved = |(k, x): (usize, &f64)| {
        x + 2.0 * jitter * spacing * ((k as f64 * 0.5698402909).fract() - 0.5)
    };
    let coordinates: Vec<f64> = block.coordinates().iter().enumerate().map(moved).collect();
    Points::new(3, &coordinates, block.volumes()).unwrap()
}

fn main() {
    let spacing = 1e-3;
    for (name, jitter) in [("lattice", 0.0), ("cloud", 0.2)] {
        compare(name, &block(spacing, jitter), spacing);
    }
}

fn compare(shape: &str, points: &Points, spacing: f64) {
    let mut runs: Vec<(String, Simulation, Vec<f64>)> = Vec::new();
    for threads in [1, 2] {
        for breaks in [false, true] {
            let damage = if breaks { "damage" } else { "no damage" };
            let name = format!("perion, {threads} thread(s), {damage}");
            runs.push((name, body(points, spacing, breaks, threads), Vec::new()));
        }
    }
    let started = Instant::now();
    let mut naive = Naive::new(points, &runs[0].1);
    println!("set-up with the list for the plain loop: {:.2} s", started.elapsed().as_secs_f64());
    let bonds = naive.bonds.len() as f64;
    let mut naive_times = Vec::new();
    let time_step = runs[0].1.stable_time_step().unwrap();
    for (_, simulation, _) in &mut runs {
        simulation.step(time_step, 1).unwrap();
    }
    for _ in 0..ROUNDS {
        let started = Instant::now();
        for _ in 0..STEPS {
            naive.sweep(1e20);
        }
        naive_times.push(started.elapsed().as_secs_f64() / STEPS as f64);
        for (_, simulation, times) in &mut runs {
            let started = Instant::now();
            simulation.step(time_step, STEPS).unwrap();
            times.push(started.elapsed().as_secs_f64() / STEPS as f64);
        }
    }
    assert!(naive.force.iter().flatten().all(|force| force.is_finite()));
    let plain = median(naive_times);
    println!("{shape}: {} points, {bonds} directed bonds", points.count());
    println!("{:<34} {:>10} {:>9}", "", "Mb-steps/s", "x plain");
    let rate = 1e-6 * bonds / plain;
    println!("{:<34} {rate:>10.0} {:>9.2}", "plain loop, forces only, 1 thread", 1.0);
    for (name, _, times) in runs {
        let time = median(times);
        println!("{name:<34} {:>10.0} {:>9.2}", 1e-6 * bonds / time, plain / time);
    }
}
