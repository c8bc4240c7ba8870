//! Forces are the slope of the energy and keep momentum; a body that is turned keeps its energy, and its
//! forces turn with it.

use perion::{Field, Simulation};

use super::{Body, Form, Turn, apart, bodies, body_at, energy_densities, hold, largest, lattice};
use crate::forces::{cross, forces, norm};

/// The slope of the whole energy along a component: central differences, extrapolated.
fn slope(simulation: &mut Simulation, at: &[f64], component: usize, reach: f64) -> f64 {
    let mut energy = |by: f64| {
        let mut moved = at.to_vec();
        moved[component] += by;
        simulation.set(Field::Displacement, &moved).unwrap();
        simulation.energy().unwrap().elastic
    };
    let near = energy(reach) - energy(-reach);
    let far = energy(2.0 * reach) - energy(-2.0 * reach);
    (8.0 * near - far) / (12.0 * reach)
}

/// How far forces at a displacement are from the slope of the energy, over the largest force.
pub fn off_slope(simulation: &mut Simulation, body: &Body, at: &[f64]) -> f64 {
    simulation.set(Field::Displacement, at).unwrap();
    let expected = forces(simulation);
    let mut random = body.scene.random(6);
    let mut worst = 0.0_f64;
    for _ in 0..5 {
        let component = random.below(at.len());
        let slope = slope(simulation, at, component, 1e-3 * body.scene.spacing);
        let off = (expected[component] + slope).abs();
        worst = if off.is_nan() { f64::INFINITY } else { worst.max(off) };
    }
    worst / largest(&expected)
}

/// The sums of forces and of torques about the origin, over the sums of their sizes.
pub fn momentum(simulation: &Simulation) -> [f64; 2] {
    let dimension = simulation.points().dimension();
    let (forces, positions) = (forces(simulation), simulation.get(Field::Position).unwrap());
    let (mut sums, mut sizes) = ([[0.0; 3]; 2], [0.0; 2]);
    for (place, force) in positions.chunks_exact(dimension).zip(forces.chunks_exact(dimension)) {
        let torque = cross(place, force);
        (0..dimension).for_each(|axis| sums[0][axis] += force[axis]);
        (0..3).for_each(|axis| sums[1][axis] += torque[axis]);
        sizes[0] += norm(force);
        sizes[1] += norm(place) * norm(force);
    }
    [0, 1].map(|k| norm(&sums[k]) / sizes[k])
}

/// With the difference formula of fourth order and 1e-3 of the spacing, what it leaves out is 1e-12 of the
/// curvature of its terms, and rounding of the energy is 1e-12 of a force; gradients of poor families are up to
/// a hundred times as steep.
pub const SLOPE: f64 = 1e-9;

#[test]
fn forces_are_the_slope_of_the_energy() {
    hold(
        "slope",
        &bodies(),
        |_| Some(SLOPE),
        |form, body| off_slope(&mut body.wounded(form), body, &body.shaken()),
    );
}

#[test]
fn forces_of_small_strain_are_the_slope_of_the_energy() {
    let bodies: Vec<Body> =
        bodies().into_iter().map(|body| body.with_law("small_strain")).collect();
    hold(
        "slope, small strain",
        &bodies,
        |form| form.has_law().then_some(SLOPE),
        |form, body| off_slope(&mut body.wounded(form), body, &body.shaken()),
    );
}

#[test]
fn forces_keep_momentum() {
    // A hundred points with a hundred bonds, each rounded to 1e-16, with random signs.
    hold(
        "momentum",
        &bodies(),
        |_| Some(1e-13),
        |form, body| {
            let mut simulation = body.wounded(form);
            simulation.set(Field::Displacement, &body.shaken()).unwrap();
            momentum(&simulation)[0]
        },
    );
}

#[test]
fn forces_keep_angular_momentum() {
    let tolerance = |form: Form| form.is_objective().then_some(1e-13);
    hold("angular momentum", &bodies(), tolerance, |form, body| {
        let mut simulation = body.wounded(form);
        simulation.set(Field::Displacement, &body.shaken()).unwrap();
        momentum(&simulation)[1]
    });
}

#[test]
fn energy_and_forces_turn_with_the_body() {
    // Displacements of ten spacings are rounded to 1e-15 spacings, a strain of 1e-15 beside one of 0.05: 1e-13
    // of the energy and of forces.
    for part in [0, 1] {
        let what = ["energy turned", "forces turned"][part];
        let tolerance = |form: Form| form.is_objective().then_some(1e-12);
        hold(what, &bodies(), tolerance, |form, body| {
            let (scene, moved) = (&body.scene, body.shaken());
            let mut simulation = body.wounded(form);
            simulation.set(Field::Displacement, &moved).unwrap();
            let (energy, before) = (simulation.energy().unwrap().elastic, forces(&simulation));
            let mut worst = 0.0_f64;
            for number in 0..3 {
                let turn = Turn::random(scene.dimension, &mut scene.random(30 + number));
                simulation.set(Field::Displacement, &turn.displacement(scene, &moved)).unwrap();
                let now = simulation.energy().unwrap().elastic;
                let expected = turn.turned(scene.dimension, &before);
                let off = [
                    (now / energy - 1.0).abs(),
                    apart(&forces(&simulation), &expected) / largest(&before),
                ];
                worst = worst.max(off[part]);
            }
            worst
        });
    }
}

/// The largest W over E, and the largest b over K/delta, of turns of a body.
pub fn left_by_turns(simulation: &mut Simulation, body: &Body, turns: u64) -> [f64; 2] {
    let scene = &body.scene;
    let still = vec![0.0; scene.components()];
    let mut worst = [0.0_f64; 2];
    let force = scene.bulk_modulus() / scene.largest_horizon();
    for number in 0..turns {
        let turn = Turn::random(scene.dimension, &mut scene.random(40 + number));
        simulation.set(Field::Displacement, &turn.displacement(scene, &still)).unwrap();
        let energy = largest(&energy_densities(simulation)) / body.youngs_modulus();
        let force = largest(&simulation.get(Field::InternalForce).unwrap()) / force;
        for (worst, found) in worst.iter_mut().zip([energy, force]) {
            *worst = if found.is_nan() { f64::INFINITY } else { worst.max(found) };
        }
    }
    worst
}

#[test]
fn rigid_motion_stores_nothing_and_pulls_on_nothing() {
    // Energy goes with the square of what is rounded in a strain, 1e-14; forces with itself.
    for (part, tolerance) in [(0, 1e-12), (1, 1e-11)] {
        let what = ["rigid energy", "rigid force"][part];
        hold(
            what,
            &bodies(),
            |_| Some(tolerance),
            |form, body| left_by_turns(&mut body.wounded(form), body, 3)[part],
        );
    }
}

#[test]
fn collocation_keeps_no_momentum() {
    let form = Form { name: "correspondence", order: 1 };
    for body in bodies() {
        let mut simulation =
            body.changed(form, |model| model.choose("divergence", "strong").unwrap());
        simulation.set(Field::Displacement, &body.shaken()).unwrap();
        // Eleven orders above what the weak form leaves: what was lost is no rounding.
        assert!(momentum(&simulation)[0] > 1e-2);
    }
}

#[test]
fn wan_turns_with_an_even_lattice() {
    // Families inside have C1 = c I, which no turn changes; what is not asked of clouds holds here.
    let form = Form { name: "correspondence_wan", order: 1 };
    let body = body_at(2, lattice(2, [13, 13, 1]), 2.015);
    let middle = 6 * 13 + 6;
    let mut moved = vec![0.0; body.scene.components()];
    moved[2 * middle] = 0.05;
    let mut simulation = body.simulation(form);
    simulation.set(Field::Displacement, &moved).unwrap();
    let (energy, turn) =
        (simulation.energy().unwrap().elastic, Turn { axis: [0.0, 0.0, 1.0], angle: 1.0 });
    simulation.set(Field::Displacement, &turn.displacement(&body.scene, &moved)).unwrap();
    assert!((simulation.energy().unwrap().elastic / energy - 1.0).abs() < 1e-12);
}

#[test]
fn models_of_one_body_share_order_and_divergence() {
    let body = bodies().into_iter().find(|body| !body.scene.second.is_empty()).unwrap();
    let form = Form { name: "correspondence", order: 1 };
    let mut simulation = body.simulation(form);
    let second = body.model(Form { order: 2, ..form }, 1);
    let error = simulation.assign_model("second", &second).unwrap_err();
    assert!(matches!(error, perion::Error::Unsupported(_)), "{error}");
    assert!(error.to_string().contains("gradient_order"), "{error}");
}
