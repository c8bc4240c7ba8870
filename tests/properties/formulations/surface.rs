//! Corrected surfaces: forces remain the slope of an energy, and by the stiffness tensor families near a surface store
//! what the material says.

use perion::{Field, Simulation};

use super::degenerate::thin_bodies;
use super::energies::{SLOPE, left_by_turns, momentum, off_slope};
use super::{Body, Form, RATIOS, Turn, bodies, body_at, energy_densities, hold, lattice};

const FORMS: [Form; 2] =
    [Form { name: "bond_based", order: 1 }, Form { name: "ordinary_state_based", order: 1 }];

const CORRECTIONS: [&str; 2] = ["energy", "stiffness_tensor"];

fn corrected(body: &Body, form: Form, correction: &str) -> Simulation {
    body.changed(form, |model| model.choose("surface_correction", correction).unwrap())
}

#[test]
fn forces_at_corrected_surfaces_are_the_slope_of_the_energy_and_keep_momentum() {
    let tolerance = |value: f64| move |form: Form| FORMS.contains(&form).then_some(value);
    for correction in CORRECTIONS {
        let ready = |form: Form, body: &Body| {
            let mut simulation = corrected(body, form, correction);
            body.scene.wound(&mut simulation);
            simulation
        };
        // As for clouds without correction; the reference's bodies are of both materials.
        hold(&format!("slope, {correction}"), &bodies(), tolerance(SLOPE), |form, body| {
            off_slope(&mut ready(form, body), body, &body.shaken())
        });
        hold(&format!("momentum, {correction}"), &bodies(), tolerance(1e-13), |form, body| {
            let mut simulation = ready(form, body);
            simulation.set(Field::Displacement, &body.shaken()).unwrap();
            momentum(&simulation).into_iter().fold(0.0, f64::max)
        });
    }
}

#[test]
fn thin_bodies_that_are_corrected_have_an_energy_and_are_free_to_turn() {
    let tolerance = |value: f64| move |form: Form| FORMS.contains(&form).then_some(value);
    let bodies: Vec<Body> =
        thin_bodies().into_iter().filter(|body| body.scene.count() > 1).collect();
    let ready = |form: Form, body: &Body| corrected(body, form, "stiffness_tensor");
    hold("thin corrected slope", &bodies, tolerance(SLOPE), |form, body| {
        let shaken = body.scene.random(11).around_zero(body.scene.components(), 0.03);
        off_slope(&mut ready(form, body), body, &shaken)
    });
    hold("thin corrected turns", &bodies, tolerance(1e-11), |form, body| {
        left_by_turns(&mut ready(form, body), body, 4).into_iter().fold(0.0, f64::max)
    });
}

type Matrix = [[f64; 3]; 3];

/// What a material of modulus E and ratio nu stores at a strain.
fn energy_of_material(modulus: f64, ratio: f64, strain: &Matrix) -> f64 {
    let lambda = modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio));
    let trace: f64 = (0..3).map(|k| strain[k][k]).sum();
    let squares: f64 = strain.iter().flatten().map(|x| x * x).sum();
    0.5 * lambda * trace * trace + 0.5 * modulus / (1.0 + ratio) * squares
}

fn ratio_of(form: Form) -> f64 {
    if form.name == "bond_based" { 0.25 } else { RATIOS[0] }
}

/// Energy of each point at a uniform strain, over that of the material.
fn shares(body: &Body, simulation: &mut Simulation, ratio: f64, strain: &Matrix) -> Vec<f64> {
    let moved: Vec<f64> = (body.scene.coordinates.chunks_exact(3))
        .flat_map(|place| strain.map(|row| (0..3).map(|k| row[k] * place[k]).sum::<f64>()))
        .collect();
    simulation.set(Field::Displacement, &moved).unwrap();
    let expected = energy_of_material(body.youngs_modulus(), ratio, strain);
    energy_densities(simulation).iter().map(|energy| energy / expected).collect()
}

/// How far the energy of a point inside a cube, in a face, at an edge and at a corner is from that of the material at
/// strains without order, at the last two without shear: bonds in one quadrant couple it to stretch.
fn off_the_material(form: Form, correction: &str) -> [f64; 4] {
    const SIDE: usize = 9;
    let at = |[x, y, z]: [usize; 3]| x + SIDE * (y + SIDE * z);
    let body = body_at(3, lattice(3, [SIDE; 3]), 3.015);
    let mut random = body.scene.random(21);
    let mut simulation = corrected(&body, form, correction);
    let mut worst = [0.0_f64; 4];
    for number in 0..12 {
        let is_sheared = number % 2 == 0;
        let [x, y, z] = [(); 3].map(|()| random.between(-1e-6, 1e-6));
        let [yz, xz, xy] =
            [(); 3].map(|()| if is_sheared { random.between(-1e-6, 1e-6) } else { 0.0 });
        let strain = [[x, xy, xz], [xy, y, yz], [xz, yz, z]];
        let shares = shares(&body, &mut simulation, ratio_of(form), &strain);
        let points = [[4, 4, 4], [8, 4, 4], [8, 8, 4], [8, 8, 8]].map(at);
        for (place, (worst, point)) in worst.iter_mut().zip(points).enumerate() {
            if place < 2 || !is_sheared {
                *worst = worst.max((shares[point] - 1.0).abs());
            }
        }
    }
    println!("{form:?} {correction}: {worst:.4?}");
    worst
}

#[test]
fn families_have_the_stiffness_of_their_material() {
    for form in FORMS {
        let [none, energy] =
            ["none", "energy"].map(|correction| off_the_material(form, correction));
        // Inside, where only the lattice is uneven.
        assert!(none[0] > 0.1 && energy[0] > 0.1, "{form:?}: {none:?}, {energy:?}");
        // What the tensors cost inside and in faces; what edges and corners cannot have.
        let most = [6e-3, 6e-3, 0.1, 0.15];
        let worst = off_the_material(form, "stiffness_tensor");
        assert!(worst.iter().zip(most).all(|(worst, most)| *worst < most), "{form:?}: {worst:?}");
    }
}

#[test]
fn bars_that_are_turned_store_what_their_material_does() {
    let turns = [
        None,
        Some(Turn { axis: [1.0, 0.0, 0.0], angle: std::f64::consts::FRAC_PI_6 }),
        Some(Turn { axis: [1.0, 0.0, 0.0], angle: std::f64::consts::FRAC_PI_4 }),
        Some(Turn { axis: [0.7, 0.5, -0.4], angle: 0.95 }),
    ];
    for form in FORMS {
        let ratio = ratio_of(form);
        for correction in CORRECTIONS {
            let mut all = Vec::new();
            for turn in turns {
                let places = lattice(3, [31, 5, 5]);
                let places = turn.map_or(places.clone(), |turn| turn.turned(3, &places));
                let body = body_at(3, places, 3.015);
                let axis =
                    turn.map_or(vec![1.0, 0.0, 0.0], |turn| turn.turned(3, &[1.0, 0.0, 0.0]));
                let strain: Matrix = std::array::from_fn(|row| {
                    std::array::from_fn(|column| {
                        let along = (1.0 + ratio) * axis[row] * axis[column];
                        1e-6 * if row == column { along - ratio } else { along }
                    })
                });
                let shares = shares(&body, &mut corrected(&body, form, correction), ratio, &strain);
                all.push(shares.iter().sum::<f64>() / shares.len() as f64);
            }
            println!("{form:?} {correction}: {all:.4?}");
            if correction == "stiffness_tensor" {
                assert!(all.iter().all(|share| (share - 1.0).abs() < 0.07), "{form:?}: {all:?}");
            }
        }
    }
}

#[test]
fn the_stress_of_a_corrected_body_does_the_work_that_it_stores() {
    let body = body_at(3, lattice(3, [7, 6, 5]), 3.015);
    let strain = [[1e-6, 4e-7, -2e-7], [4e-7, -5e-7, 3e-7], [-2e-7, 3e-7, 2e-7]];
    for (form, correction) in FORMS.into_iter().flat_map(|form| {
        ["none", "energy", "stiffness_tensor"].map(|correction| (form, correction))
    }) {
        let mut simulation = corrected(&body, form, correction);
        let shares = shares(&body, &mut simulation, ratio_of(form), &strain);
        let stored = energy_of_material(body.youngs_modulus(), ratio_of(form), &strain)
            * shares.iter().sum::<f64>();
        let stress = simulation.get(Field::FirstPiolaStress).unwrap();
        let work: f64 = (stress.chunks_exact(9))
            .map(|stress| stress.iter().zip(strain.as_flattened()).map(|(p, e)| p * e).sum::<f64>())
            .sum();
        assert!((0.5 * work / stored - 1.0).abs() < 1e-5, "{form:?} {correction}: {work} {stored}");
    }
}
