//! The bar that twists, against linear torsion with the stiffness of the bar itself.

#[path = "../../examples/twist/main.rs"]
#[allow(dead_code)]
mod example;

use std::f64::consts::PI;
use std::sync::OnceLock;

use perion::Field;

use crate::twins::{compare_twins, rust_side};

const ACROSS: usize = 6;
const WIDTH: f64 = 0.1;
const SPACING: f64 = WIDTH / ACROSS as f64;
const FREE: f64 = 1.0 - 3.0 * SPACING;
const SPIN: f64 = 150.0;

fn large() -> &'static example::Twist {
    static TWIST: OnceLock<example::Twist> = OnceLock::new();
    TWIST.get_or_init(|| example::run(ACROSS, SPIN, "").unwrap())
}

#[test]
fn a_small_twist_is_that_of_linear_torsion() {
    // A hundredth of the turn: strains stay below 1 %.
    let small = example::run(ACROSS, 0.01 * SPIN, "").unwrap();
    let (angle, time) = (small.turn.0 / small.linear.0, small.turn.1 / small.linear.1);
    // Near both ends gradients are averaged over families that the end cuts, or that reach into what is
    // held: the bar is longer than what is free by a share of a horizon, and the start is not quite the
    // lowest mode of it. Records are a hundredth of the time apart.
    let ends = 3.015 * SPACING / FREE;
    assert!((0.0..ends).contains(&(time - 1.0)), "{time}, a horizon makes {ends}");
    assert!((angle - 1.0).abs() < ends, "{angle}, a horizon makes {ends}");
    // One mode alone turns by 2/pi of what the spin at the start would give in its quarter of a period.
    let mode = small.turn.0 / (0.01 * SPIN * small.turn.1) * PI / 2.0;
    assert!((mode - 1.0).abs() < ends, "{mode}");
}

#[test]
fn a_bar_of_few_horizons_is_softer_than_its_material() {
    // At the surface a family averages over what lies inside it, where torsion strains less.
    let thin = example::run(4, 0.01 * SPIN, "").unwrap().stiffness;
    let thick = large().stiffness;
    assert!(thin.0 < thick.0 && thick.0 < thick.1, "{thin:?} {thick:?}");
}

#[test]
fn the_bar_turns_by_more_than_half_a_turn_and_its_energy_stays() {
    let twist = large();
    assert!(twist.turn.0 > PI, "{}", twist.turn.0);
    // In angle the stiffening of the law and the softening by shorter bars nearly cancel.
    assert!(
        (twist.turn.0 / twist.linear.0 - 1.0).abs() < 0.05,
        "{}",
        twist.turn.0 / twist.linear.0
    );
    // Velocity Verlet keeps the energy less dt^2/8 of sum m a^2, taken here at the end: what swings is the
    // many high modes that the clamp has set off, and their sum hardly changes.
    let bar = &twist.bar;
    let mass = 1000.0 * SPACING.powi(3);
    let squares: f64 = bar.get(Field::Acceleration).unwrap().iter().map(|a| a * a * mass).sum();
    let time_step = bar.time() / bar.step_count() as f64;
    let energy = bar.energy().unwrap();
    let swing = time_step * time_step / 8.0 * squares / (energy.kinetic + energy.elastic);
    let records = &twist.records;
    let largest = records.iter().map(|record| record.drift.abs()).fold(0.0, f64::max);
    assert!(largest < 2.0 * swing && swing < 0.002, "{largest}, swing {swing}");
    // No matter turns inside out.
    assert!(records.iter().all(|record| (0.9..1.01).contains(&record.determinant)));
}

#[test]
fn the_bar_gets_shorter_as_it_twists() {
    // Fibres at r from the axis are longer by (r Theta')^2/2; if their mean kept its length, the bar would
    // be shorter by width^2/12 of the mean of Theta'^2, along a quarter of a sine. It also gets thicker, and gradients
    // see but a part of r.
    let most = WIDTH * WIDTH / 12.0 * (PI * large().turn.0).powi(2) / 8.0;
    let shorter = large().shortening;
    assert!(0.25 * most < shorter && shorter < most, "{shorter} of {most}");
}

#[test]
fn the_twist_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads() {
    let name = "twist::the_twist_prints_the_same_in_c_fortran_and_rust_for_any_number_of_threads";
    if let Some(directory) = rust_side() {
        let twist = example::run(4, SPIN, "").unwrap();
        example::write_curve(&format!("{directory}/rust.csv"), &twist.records).unwrap();
        return;
    }
    compare_twins(name, "twist", &["4"], 200);
}
