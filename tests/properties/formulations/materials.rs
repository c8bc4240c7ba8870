//! Bodies of two materials that share nothing: moduli, influence functions, laws and horizons.

use perion::{Field, Simulation};

use super::energies::{momentum, off_slope};
use super::{Body, Form, RATIOS, body_at, hold, largest, lattice};
use crate::scene::{Horizons, Recipe, bonds};

const LAWS: [&str; 2] = ["neo_hookean", "saint_venant_kirchhoff"];

/// Clouds in 3D, plane strain and plane stress, with horizons alike, by material and by point.
fn mixtures() -> Vec<Body> {
    let mut mixtures = Vec::new();
    for state in 0..3 {
        for horizons in [Horizons::Uniform, Horizons::PerMaterial, Horizons::PerPoint] {
            let number = mixtures.len();
            let recipe = Recipe {
                dimension: if state == 0 { 3 } else { 2 },
                counts: if state == 0 { [5, 4, 4] } else { [8, 7, 1] },
                jitter: 0.25,
                horizons,
                materials: 2,
                plane_stress: state == 2,
                units: [0, 3, 0],
                seed: 2000 + number as u64,
            };
            mixtures.push(Body {
                scene: recipe.scene(),
                influences: [["inverse", "conical"], ["cubic_spline", "constant"]][number % 2],
                law: LAWS[0],
                partial_volume: false,
            });
        }
    }
    mixtures
}

/// With a law for each material, and a tenth of the bonds broken and a fifth weakened.
fn mixed(body: &Body, form: Form) -> Simulation {
    let models = [0, 1].map(|number| {
        let mut model = body.model(form, number);
        if form.has_law() {
            model.choose("material", LAWS[number]).unwrap();
        }
        model
    });
    let mut simulation = Simulation::new(&body.scene.points(), &models[0]).unwrap();
    simulation.set_threads(1).unwrap();
    simulation.assign_model("second", &models[1]).unwrap();
    body.scene.wound(&mut simulation);
    simulation
}

#[test]
fn forces_between_two_materials_are_the_slope_of_the_energy() {
    // As for clouds of one law: see SLOPE in `energies`.
    let tolerance = |_| Some(super::energies::SLOPE);
    hold("slope, mixed", &mixtures(), tolerance, |form, body| {
        off_slope(&mut mixed(body, form), body, &body.shaken())
    });
}

#[test]
fn forces_between_two_materials_keep_momentum() {
    for part in [0, 1] {
        let what = ["momentum, mixed", "angular momentum, mixed"][part];
        let tolerance = |form: Form| (part == 0 || form.is_objective()).then_some(1e-13);
        // As for clouds: rounding of sums.
        hold(what, &mixtures(), tolerance, |form, body| {
            let mut simulation = mixed(body, form);
            simulation.set(Field::Displacement, &body.shaken()).unwrap();
            momentum(&simulation)[part]
        });
    }
}

const BAQP: Form = Form { name: "bond_associated_quadrature", order: 1 };

#[test]
fn a_quadrature_point_between_two_materials_has_the_mean_of_their_laws() {
    // A string of two points a length of 1.5 apart, in uniaxial stress: w/omega0 = 1/V_j, so that both have the mean
    // W, and V b = (V_1 + V_2) W'/L.
    let mut pair = body_at(3, vec![0.0, 0.0, 0.0, 1.5, 0.0, 0.0], 2.0);
    pair.scene.volumes = vec![0.5, 0.75];
    pair.scene.second = vec![1];
    let mut other = pair.scene.materials[0];
    other.youngs_modulus = 5.0;
    pair.scene.materials.push(other);
    let mut models = [0, 1].map(|number| pair.model(BAQP, number));
    models[0].choose("material", "small_strain").unwrap();
    models[1].choose("material", "saint_venant_kirchhoff").unwrap();
    let mut two = Simulation::new(&pair.scene.points(), &models[0]).unwrap();
    two.assign_model("second", &models[1]).unwrap();
    let strain = 0.125;
    two.set(Field::Displacement, &[0.0, 0.0, 0.0, 1.5 * strain, 0.0, 0.0]).unwrap();
    let green = strain + 0.5 * strain * strain;
    let [soft, hard] = [1.7, 5.0];
    let energy = 0.5 * (0.5 * soft * strain * strain + 0.5 * hard * green * green);
    let slope = 0.5 * (soft * strain + hard * green * (1.0 + strain));
    // Some ten roundings of 1e-16.
    for found in two.get(Field::StrainEnergyDensity).unwrap() {
        assert!((found / energy - 1.0).abs() < 1e-14, "{found}, not {energy}");
    }
    let force = two.get(Field::InternalForce).unwrap();
    for (place, volume, sign) in [(0, 0.5, 1.0), (3, 0.75, -1.0)] {
        let expected = sign * 1.25 * slope / 1.5 / volume;
        assert!((force[place] / expected - 1.0).abs() < 1e-14, "{force:?}, not {expected}");
    }
}

#[test]
fn points_of_a_swollen_mixture_have_the_mean_energy_of_their_bonds() {
    // Swollen evenly, every quadrature point has K/2 (3 s)^2 of small strain, with the mean K of its ends.
    let mut body = body_at(3, lattice(3, [5, 4, 4]), 2.1).with_law("small_strain");
    let count = body.scene.count();
    body.scene.second = (0..count).filter(|point| point % 3 == 0).collect();
    let mut other = body.scene.materials[0];
    other.youngs_modulus = 5.0;
    body.scene.materials.push(other);
    let mut simulation = body.simulation(BAQP);
    let stretch = 0.03125;
    let moved: Vec<f64> = body.scene.coordinates.iter().map(|x| stretch * x).collect();
    simulation.set(Field::Displacement, &moved).unwrap();
    let bulk = |point: usize| {
        let number = usize::from(point.is_multiple_of(3));
        body.scene.materials[number].youngs_modulus / (3.0 * (1.0 - 2.0 * RATIOS[number]))
    };
    let (mut sums, mut neighbors) = (vec![0.0; count], vec![0.0; count]);
    for ([i, j], ..) in bonds(&simulation) {
        for point in [i, j] {
            sums[point] += 0.25 * (bulk(i) + bulk(j)) * (3.0 * stretch) * (3.0 * stretch);
            neighbors[point] += 1.0;
        }
    }
    let energies = simulation.get(Field::StrainEnergyDensity).unwrap();
    let off = energies.iter().zip(sums.iter().zip(&neighbors));
    let off =
        largest(&off.map(|(energy, (sum, n))| energy / (sum / n) - 1.0).collect::<Vec<f64>>());
    // F of places rounded to 1e-16 over a strain of 0.03, squared.
    assert!(off < 1e-13, "{off:e}");
}
