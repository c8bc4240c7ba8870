//! The bar that is bent until its ends nearly touch, against the elastica: a thin rod that resists bending
//! alone, with the arc and the edges of this bar.

#[path = "../../examples/bend/main.rs"]
#[allow(dead_code)]
mod example;

use std::f64::consts::PI;
use std::sync::OnceLock;

use example::{LENGTH, RADIUS, Record, WIDTH};

use crate::twins::{compare_twins, rust_side};

const ACROSS: usize = 3;
const SPACING: f64 = WIDTH / ACROSS as f64;

fn bent() -> &'static example::Bend {
    static BEND: OnceLock<example::Bend> = OnceLock::new();
    BEND.get_or_init(|| example::run(ACROSS, 0.02, "").unwrap())
}

/// Half of the rod, from its middle to one edge. Force and energies are those of a stiffness of 1.
#[derive(Clone, Copy)]
struct Elastica {
    force: f64,
    /// Of the middle over the edges.
    height: f64,
}

/// Where the edge of an elastica comes to lie, from below the middle and at the height of the edges, and the
/// energy of the whole rod.
struct Edge {
    along: f64,
    up: f64,
    energy: f64,
}

impl Elastica {
    /// By the method of Runge and Kutta from the middle: the slope of the rod grows by its curvature, which
    /// is that of the arc and what the force makes of the height.
    fn edge(self) -> Edge {
        const PARTS: usize = 200;
        let part = 0.5 * (LENGTH - SPACING) / PARTS as f64;
        let rate = |[angle, _, height, _]: [f64; 4]| {
            let moment = self.force * height;
            [-1.0 / RADIUS - moment, angle.cos(), angle.sin(), moment * moment]
        };
        let after = |state: [f64; 4], rate: [f64; 4], length: f64| -> [f64; 4] {
            std::array::from_fn(|k| state[k] + length * rate[k])
        };
        let mut state = [0.0, 0.0, self.height, 0.0];
        for _ in 0..PARTS {
            let first = rate(state);
            let second = rate(after(state, first, 0.5 * part));
            let third = rate(after(state, second, 0.5 * part));
            let last = rate(after(state, third, part));
            let mean = std::array::from_fn(|k| {
                (first[k] + 2.0 * second[k] + 2.0 * third[k] + last[k]) / 6.0
            });
            state = after(state, mean, part);
        }
        let [angle, along, up, energy] = state;
        // The points that are moved lie below the axis, square to it.
        let depth = 0.5 * (WIDTH - SPACING);
        Edge { along: along + depth * angle.sin(), up: up - depth * angle.cos(), energy }
    }

    /// The rod whose edges have come together by this length, from one that is near to it, by Newton's
    /// method.
    fn shortened(mut self, shortening: f64) -> Self {
        let straight = Self { force: 0.0, height: 0.0 }.edge().along;
        for _ in 0..50 {
            let off = |rod: Self| {
                let edge = rod.edge();
                [edge.along - (straight - 0.5 * shortening), edge.up]
            };
            let [a, b] = off(self);
            if a.abs() + b.abs() < 1e-12 {
                return self;
            }
            let (force_step, height_step) = (1e-5 * self.force.max(1.0), 1e-8);
            let by_force = off(Self { force: self.force + force_step, ..self });
            let by_height = off(Self { height: self.height + height_step, ..self });
            let [fa, fb] = [(by_force[0] - a) / force_step, (by_force[1] - b) / force_step];
            let [ha, hb] = [(by_height[0] - a) / height_step, (by_height[1] - b) / height_step];
            let determinant = fa * hb - ha * fb;
            self.force -= (hb * a - ha * b) / determinant;
            self.height -= (fa * b - fb * a) / determinant;
        }
        panic!("no elastica is shorter by {shortening}");
    }
}

/// The records from a quarter of the length on, where the bar has come to rest about its balance, each with
/// its elastica.
fn compared() -> Vec<(&'static Record, Elastica)> {
    let mut rod = Elastica { force: 0.0, height: -Elastica { force: 0.0, height: 0.0 }.edge().up };
    let mut pairs = Vec::new();
    for record in &bent().records {
        rod = rod.shortened(record.shortening);
        if record.shortening > 0.25 * LENGTH {
            pairs.push((record, rod));
        }
    }
    assert!(pairs.len() > 50, "{}", pairs.len());
    pairs
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn an_elastica_that_begins_to_bend_bears_the_load_of_euler() {
    // This is a test of the yardstick: moved by the edges and from an arc, the force lags behind that load,
    // and reaches it while the slope of the ends grows to 45 degrees.
    let mut rod = Elastica { force: 0.0, height: -Elastica { force: 0.0, height: 0.0 }.edge().up };
    let mut last = 0.0;
    for step in 1..=60 {
        rod = rod.shortened(1e-3 * f64::from(step));
        assert!(rod.force > last);
        last = rod.force;
    }
    let euler = (PI / LENGTH).powi(2);
    assert!((1.0..1.2).contains(&(last / euler)), "{}", last / euler);
}

#[test]
fn the_bar_bends_into_an_elastica() {
    let ratios = compared().into_iter().map(|(record, rod)| record.height / rod.height);
    let ratios: Vec<f64> = ratios.collect();
    // The start of the pull has left the bar swinging about its balance.
    for ratio in &ratios {
        assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    }
    // A dozen swings have a mean of nearly nothing.
    let mean = mean(ratios.iter().copied());
    assert!((mean - 1.0).abs() < 0.003, "{mean}");

    let end = &bent().records[bent().records.len() - 1];
    assert!(end.shortening > 0.93 * LENGTH, "{}", end.shortening);
    assert!(end.kinetic_share < 0.002, "{}", end.kinetic_share);
    let energy = bent().bar.energy().unwrap();
    // Nothing breaks: what is left is the swing of velocity Verlet, in modes that hold little energy.
    let closure = energy.closure_error / energy.external_work;
    assert!(closure.abs() < 1e-5, "{closure}");
}

#[test]
fn the_bar_holds_the_energy_of_an_elastica_and_needs_its_force() {
    let pairs = compared();
    let energies: Vec<f64> = pairs.iter().map(|(_, rod)| rod.edge().energy).collect();
    let stiffnesses = || pairs.iter().zip(&energies).map(|((bar, _), energy)| bar.elastic / energy);
    let stiffness = mean(stiffnesses());
    // One stiffness for the whole way: strains of 15 % at the surface, where the bar is curved most, make the
    // law softer by their square, averaged over the bar; and swings add to the energy at first.
    for one in stiffnesses() {
        assert!((one / stiffness - 1.0).abs() < 0.02, "{one} {stiffness}");
    }
    // Below that of displacements made by hand, which lies below that of the material.
    let (bound, material) = bent().stiffness;
    assert!(stiffness < bound && bound < material, "{stiffness} {bound} {material}");

    // The work of the force, and what the motion gives back, over what an elastica of this stiffness takes.
    // The force swings by a fifth, twelve times, and is known at 100 places.
    let mut work = 0.0;
    for window in pairs.windows(2) {
        let [(before, _), (after, _)] = [window[0], window[1]];
        work += 0.5 * (before.force + after.force) * (after.shortening - before.shortening);
    }
    let kinetic = |bar: &Record| bar.kinetic_share * bar.elastic;
    let (first, last) = (pairs[0], pairs[pairs.len() - 1]);
    let returned = kinetic(first.0) - kinetic(last.0);
    let needed = stiffness * (energies[energies.len() - 1] - energies[0]);
    let ratio = (work + returned) / needed;
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}

#[test]
fn the_bend_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "bend::the_bend_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let bend = example::run(ACROSS, 0.002, "").unwrap();
        example::write_curve(&format!("{directory}/rust.csv"), &bend.records).unwrap();
        return;
    }
    compare_twins(name, "bend", &["3", "0.002"], 200);
}
