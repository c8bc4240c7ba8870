//! Families that do not span the body: plates, chains, pairs, points, and blocks of which little is left.

use perion::Field;

use super::energies::{left_by_turns, momentum, off_slope};
use super::{Body, Form, RATIOS, Turn, body_at, energy_densities, forms, hold, largest, lattice};
use crate::forces::forces;
use crate::random::Random;
use crate::scene::bonds;

/// Turns of the reference body: none, and about axes that no face knows.
fn turns() -> [Option<Turn>; 4] {
    let turn = |axis, angle| Some(Turn { axis, angle });
    [
        None,
        turn([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_6),
        turn([1.0, 0.0, 0.0], 1.2),
        turn([0.3, -0.5, 0.8], 2.0),
    ]
}

/// Places of bodies that are flat, thin or few.
fn shapes() -> Vec<(usize, Vec<f64>)> {
    vec![
        (3, lattice(3, [5, 5, 1])),
        (3, lattice(3, [6, 1, 1])),
        (3, lattice(3, [2, 1, 1])),
        (3, vec![0.3, -0.2, 0.5]),
        // A triangle and a tetrahedron: fewer neighbours than unknowns.
        (3, vec![0.0, 0.0, 0.0, 1.1, 0.1, 0.2, 0.3, 0.9, -0.4]),
        (3, vec![0.0, 0.0, 0.0, 1.1, 0.1, 0.2, 0.3, 0.9, -0.4, 0.2, 0.3, 1.3]),
        (2, lattice(2, [6, 1, 1])),
        (2, lattice(2, [2, 1, 1])),
        (2, vec![0.0, 0.0, 1.2, 0.1, 0.3, 0.9]),
    ]
}

/// All shapes in all turns, with laws and influence functions in turn.
pub fn thin_bodies() -> Vec<Body> {
    let mut bodies = Vec::new();
    for (dimension, places) in shapes() {
        for turn in turns() {
            let turn = turn.map(|turn| match dimension {
                2 => Turn { axis: [0.0, 0.0, 1.0], ..turn },
                _ => turn,
            });
            let places = turn.map_or(places.clone(), |turn| turn.turned(dimension, &places));
            for law in ["saint_venant_kirchhoff", "neo_hookean"] {
                let mut body = body_at(dimension, places.clone(), 2.3).with_law(law);
                let count = body.scene.count();
                body.scene.volumes =
                    (0..count).map(|point| 0.7 + 0.1 * (point % 5) as f64).collect();
                body.influences = [super::INFLUENCES[bodies.len() % 4]; 2];
                body.scene.plane_stress = bodies.len() % 3 == 0;
                bodies.push(body);
            }
        }
    }
    bodies
}

#[test]
fn thin_bodies_store_nothing_when_they_are_moved() {
    // What is rounded in a strain is 1e-15, and energy goes with its square; forces with itself.
    for (part, tolerance) in [(0, 1e-12), (1, 1e-11)] {
        let what = ["thin rigid energy", "thin rigid force"][part];
        hold(
            what,
            &thin_bodies(),
            |_| Some(tolerance),
            |form, body| left_by_turns(&mut body.simulation(form), body, 4)[part],
        );
    }
}

/// Displacements of 0.03, in all directions.
fn shaken(body: &Body) -> Vec<f64> {
    body.scene.random(11).around_zero(body.scene.components(), 0.03)
}

#[test]
fn deformed_thin_bodies_keep_momentum() {
    for part in [0, 1] {
        let what = ["thin momentum", "thin angular momentum"][part];
        let tolerance = |form: Form| (part == 0 || form.is_objective()).then_some(1e-13);
        // As for clouds: rounding of sums.
        hold(what, &thin_bodies(), tolerance, |form, body| {
            let mut simulation = body.simulation(form);
            simulation.set(Field::Displacement, &shaken(body)).unwrap();
            if largest(&forces(&simulation)) == 0.0 {
                assert_eq!(body.scene.count(), 1);
                return 0.0;
            }
            momentum(&simulation)[part]
        });
    }
}

#[test]
fn forces_of_thin_bodies_are_the_slope_of_their_energy() {
    // The flat plate and the chain are shaken out of their plane too, as far as it goes at this displacement. As for
    // clouds, 1e-12 from differences and from rounding each; triangles and pairs are the least stiff.
    hold(
        "thin slope",
        &thin_bodies(),
        |_| Some(1e-9),
        |form, body| {
            if body.scene.count() == 1 {
                return 0.0;
            }
            off_slope(&mut body.simulation(form), body, &shaken(body))
        },
    );
}

#[test]
fn blocks_of_which_little_is_left_store_nothing_when_they_are_moved() {
    let mut bodies = Vec::new();
    for (number, dimension) in [3, 2, 3, 2].into_iter().enumerate() {
        let mut random = Random(90 + number as u64);
        let counts = if dimension == 3 { [4, 4, 4] } else { [7, 7, 1] };
        let mut places = lattice(dimension, counts);
        // Two lattices, whose thinned families are often flat, and two clouds.
        if number > 1 {
            places.iter_mut().for_each(|x| *x += random.between(-0.2, 0.2));
        }
        bodies.push(
            body_at(dimension, places, 2.015)
                .with_law(["neo_hookean", "saint_venant_kirchhoff"][number % 2]),
        );
    }
    for share in [0.7, 0.9, 0.97] {
        let thinned = |form: Form, body: &Body| {
            let mut simulation = body.simulation(form);
            let mut random = body.scene.random(12);
            let all = bonds(&simulation).into_iter().map(|(pair, _, _)| pair);
            let broken: Vec<[usize; 2]> = all.filter(|_| random.chance(share)).collect();
            simulation.break_bonds(&broken).unwrap();
            simulation
        };
        // Displacements of up to ten spacings are rounded to 1e-15 of one, and families that are only just told from
        // flat ones are 1e4 times as stiff across: what is left of a force is what the displacements leave open.
        for (part, tolerance) in [(0, 1e-12), (1, 1e-11)] {
            let what = format!("{share} gone, rigid {}", ["energy", "force"][part]);
            hold(
                &what,
                &bodies,
                |_| Some(tolerance),
                |form, body| left_by_turns(&mut thinned(form, body), body, 3)[part],
            );
        }
        let what = format!("{share} gone, momentum");
        hold(
            &what,
            &bodies,
            |_| Some(1e-13),
            |form, body| {
                let mut simulation = thinned(form, body);
                let mut random = body.scene.random(13);
                let moved = random.around_zero(body.scene.components(), 0.02);
                simulation.set(Field::Displacement, &moved).unwrap();
                assert!(largest(&forces(&simulation)).is_finite());
                momentum(&simulation)[0]
            },
        );
    }
}

#[test]
fn a_plate_one_point_thick_has_the_energy_of_plane_stress() {
    // Deformed in its plane, by the same amounts as a body in 2D: the same numbers but for rounding.
    let flat = lattice(2, [5, 6, 1]);
    let mut random = Random(14);
    let moved = random.around_zero(flat.len(), 0.05);
    let raised = |flat: &[f64]| -> Vec<f64> {
        flat.chunks_exact(2).flat_map(|pair| [pair[0], pair[1], 0.0]).collect()
    };
    for law in ["saint_venant_kirchhoff", "neo_hookean", "small_strain"] {
        for form in forms(2).filter(|form| form.has_law() && form.order == 1) {
            let mut body = body_at(2, flat.clone(), 2.3).with_law(law);
            body.scene.plane_stress = true;
            let mut simulation = body.simulation(form);
            simulation.set(Field::Displacement, &moved).unwrap();
            let expected = simulation.get(Field::StrainEnergyDensity).unwrap();
            for turn in turns().into_iter().flatten().filter(|_| law != "small_strain") {
                let places = turn.turned(3, &raised(&flat));
                let plate = body_at(3, places, 2.3).with_law(law);
                let mut simulation = plate.simulation(form);
                let moved = turn.turned(3, &raised(&moved));
                simulation.set(Field::Displacement, &moved).unwrap();
                let energies = simulation.get(Field::StrainEnergyDensity).unwrap();
                // A strain of 0.05 from places rounded to 1e-15.
                let off = super::apart(&energies, &expected) / largest(&expected);
                assert!(off < 1e-12, "{form:?} {law} {off:e}");
            }
            let plate = body_at(3, raised(&flat), 2.3).with_law(law);
            let mut simulation = plate.simulation(form);
            simulation.set(Field::Displacement, &raised(&moved)).unwrap();
            let energies = simulation.get(Field::StrainEnergyDensity).unwrap();
            let off = super::apart(&energies, &expected) / largest(&expected);
            assert!(off < 1e-12, "{form:?} {law} {off:e}");
        }
    }
}

#[test]
fn a_stretched_chain_has_the_energy_of_uniaxial_stress() {
    let strain = 0.08;
    for dimension in [2, 3] {
        for form in forms(dimension).filter(|form| form.has_law()) {
            for turn in turns().into_iter().flatten() {
                let turn =
                    if dimension == 2 { Turn { axis: [0.0, 0.0, 1.0], ..turn } } else { turn };
                let places = turn.turned(dimension, &lattice(dimension, [6, 1, 1]));
                let mut body = body_at(dimension, places, 2.3);
                body.scene.plane_stress = true;
                let moved: Vec<f64> = body.scene.coordinates.iter().map(|x| strain * x).collect();
                let mut simulation = body.simulation(form);
                simulation.set(Field::Displacement, &moved).unwrap();
                let green: f64 = strain + 0.5 * strain * strain;
                let expected = 0.5 * body.youngs_modulus() * green * green;
                for energy in energy_densities(&simulation) {
                    // As above.
                    let off = (energy / expected - 1.0).abs();
                    assert!(off < 1e-12, "{form:?} {dimension}D {off:e}");
                }
            }
        }
    }
}

#[test]
fn a_chain_in_plane_strain_is_held_across() {
    // One direction is free, the other held: E/(1 - nu^2).
    for form in forms(2).filter(|form| form.has_law()) {
        let body = body_at(2, lattice(2, [6, 1, 1]), 2.3);
        let moved: Vec<f64> = body.scene.coordinates.iter().map(|x| 0.08 * x).collect();
        let mut simulation = body.simulation(form);
        simulation.set(Field::Displacement, &moved).unwrap();
        let green: f64 = 0.08 + 0.5 * 0.08 * 0.08;
        let modulus = body.youngs_modulus() / (1.0 - RATIOS[0] * RATIOS[0]);
        for energy in energy_densities(&simulation) {
            assert!((energy / (0.5 * modulus * green * green) - 1.0).abs() < 1e-12, "{form:?}");
        }
    }
}
