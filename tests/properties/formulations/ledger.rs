//! The account of energy while bonds break.

use perion::Field;

use super::{Body, Form, bodies, forms};

/// The largest deviation of kinetic + elastic + dissipated energy from what was there, over the largest of the three,
/// as a cloud is blown apart; and the share of its bonds that broke.
fn deviation(body: &Body, form: Form, refinement: u64) -> (f64, f64) {
    let mut simulation = body.changed(form, |model| model.set("critical_stretch", 0.1).unwrap());
    let scene = &body.scene;
    let speed = (body.youngs_modulus() / scene.materials[0].density).sqrt();
    let mut random = scene.random(17);
    let extent = scene.coordinates.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let blow = scene.coordinates.iter().map(|x| 0.6 * speed * x / extent);
    let velocity: Vec<f64> = blow.map(|v| v + random.between(-0.05, 0.05) * speed).collect();
    simulation.set(Field::Velocity, &velocity).unwrap();
    let step = 0.4 * simulation.stable_time_step().unwrap() / refinement as f64;
    let start = simulation.energy().unwrap().kinetic;
    let mut worst = 0.0_f64;
    for _ in 0..20 {
        if simulation.step(step, refinement).is_err() {
            break;
        }
        let energy = simulation.energy().unwrap();
        let largest = start.max(energy.kinetic).max(energy.elastic).max(energy.dissipated.abs());
        worst = worst.max(energy.closure_error.abs() / largest);
    }
    let health = simulation.health().unwrap();
    (worst, health.broken_bonds as f64 / health.bonds as f64)
}

#[test]
fn what_breaking_bonds_lose_is_booked() {
    for form in forms(3) {
        let body = &bodies()[0];
        let [(coarse, broken), (fine, _)] = [1, 4].map(|parts| deviation(body, form, parts));
        let name = format!("{} {}", form.name, form.order);
        eprintln!("{name}: {coarse:.1e}, in quarters of the step {fine:.1e}; {broken:.2} broken");
        // Stabilised forms break a hundredth, Madenci and Oterkus' a third.
        assert!(broken > 0.005, "{name}: {broken}");
        // At 0.4 of the stable step velocity Verlet alone lets the energy swing by (0.8)^2/8 of what swings in the
        // stiffest mode; and so does what breaks in a step, by the square of the step.
        assert!(coarse < 4e-3 && fine < coarse / 10.0, "{name}: {coarse} {fine}");
    }
}
