//! Precision does not depend on where the origin is, nor on how small strains are.

use perion::{Field, Simulation};

use super::{Body, apart, body_at, forms, largest, lattice};
use crate::random::Random;

fn force(simulation: &mut Simulation, displacement: &[f64]) -> Vec<f64> {
    simulation.set(Field::Displacement, displacement).unwrap();
    simulation.evaluate().unwrap();
    simulation.get(Field::InternalForce).unwrap()
}

/// A lattice and a cloud of 8 x 4 x 4, or in the plane 8 x 8, spacing 1.
fn lattice_and_cloud(dimension: usize) -> [Body; 2] {
    let counts = if dimension == 3 { [8, 4, 4] } else { [8, 8, 1] };
    let places = lattice(dimension, counts);
    let moved = Random(3).around_zero(places.len(), 0.2);
    let cloud = places.iter().zip(&moved).map(|(x, moved)| x + moved).collect();
    [body_at(dimension, places, 3.015), body_at(dimension, cloud, 3.015)]
}

fn shifted(body: &Body, shift: f64) -> Body {
    let mut body = body.clone();
    let axes = [1.0, -0.75, 0.5];
    let dimension = body.scene.dimension;
    for (place, x) in body.scene.coordinates.iter_mut().enumerate() {
        *x += axes[place % dimension] * shift;
    }
    body
}

#[test]
fn a_body_far_from_the_origin_has_the_forces_of_one_at_it() {
    for dimension in [2, 3] {
        let [block, cloud] = lattice_and_cloud(dimension);
        let displacement = Random(4).around_zero(block.scene.components(), 1e-3);
        // A million lengths away: a lattice has coordinates without rounding there, a cloud has not.
        let far = f64::from(8 << 20);
        for form in forms(dimension) {
            let forces = |body: &Body| force(&mut body.simulation(form), &displacement);
            assert_eq!(forces(&block), forces(&shifted(&block, far)), "{form:?}");
            let here = forces(&cloud);
            let off = apart(&here, &forces(&shifted(&cloud, far))) / largest(&here);
            let bound = 1e-9 + 8.0 * f64::EPSILON * far;
            eprintln!("{} {} {dimension}D: {off:.1e} of {bound:.1e}", form.name, form.order);
            assert!(off < bound, "{form:?} {off:e}");
        }
    }
}

#[test]
fn a_body_at_rest_or_carried_along_has_no_force() {
    for dimension in [2, 3] {
        for body in lattice_and_cloud(dimension) {
            for form in forms(dimension) {
                let mut simulation = body.simulation(form);
                let rest = vec![0.0; body.scene.components()];
                assert!(force(&mut simulation, &rest).iter().all(|&b| b == 0.0), "{form:?}");
                let carried = vec![12.34; body.scene.components()];
                assert!(force(&mut simulation, &carried).iter().all(|&b| b == 0.0), "{form:?}");
            }
        }
    }
}

/// At a strain of 1e-6 the forces are those that strains of 1e-3 tell by Richardson's extrapolation, to 1e-8.
#[test]
fn forces_at_small_strain_keep_their_digits() {
    for dimension in [2, 3] {
        for body in lattice_and_cloud(dimension) {
            let direction = Random(5).around_zero(body.scene.components(), 1.0);
            for form in forms(dimension) {
                let mut simulation = body.simulation(form);
                // The odd part of the force over the size: its slope, and terms of the square of the size.
                let mut slope = |size: f64| -> Vec<f64> {
                    let mut at = |size: f64| {
                        let moved: Vec<f64> = direction.iter().map(|d| size * d).collect();
                        force(&mut simulation, &moved)
                    };
                    let (forth, back) = (at(size), at(-size));
                    forth.iter().zip(&back).map(|(a, b)| (a - b) / (2.0 * size)).collect()
                };
                let (coarse, fine, small) = (slope(1e-3), slope(5e-4), slope(1e-6));
                let told: Vec<f64> = fine
                    .iter()
                    .zip(&coarse)
                    .map(|(fine, coarse)| (4.0 * fine - coarse) / 3.0)
                    .collect();
                let off = apart(&small, &told) / largest(&told);
                eprintln!("{} {} {dimension}D: {off:.1e}", form.name, form.order);
                assert!(off < 1e-8, "{form:?} {off:e}");
            }
        }
    }
}
