//! A chain whose points are shifted to and fro in turn, which the deformation gradient of a family does not
//! see. [P 4.36-4.43]
//!
//! A horizon of two spacings of 1, volumes of 1 and influence 1: each family has bonds of 1, 1, 2 and 2. The shift a
//! makes the bonds of 1 longer or shorter by 2a, one of each kind, and does nothing to those of 2.

use std::f64::consts::PI;

use perion::{Field, Model, Points, Simulation};

/// A power of two: all of these sums are exact.
const SHIFT: f64 = 1.0 / 64.0;
const COUNT: usize = 13;
const YOUNG: f64 = 1.5;
const RATIO: f64 = 0.25;

fn chain(formulation: &str) -> Simulation {
    let places: Vec<f64> = (0..COUNT).flat_map(|point| [point as f64, 0.0, 0.0]).collect();
    let points = Points::new(3, &places, &[1.0; COUNT]).unwrap();
    let mut model = Model::new(formulation).unwrap();
    for (key, value) in [("density", 1.0), ("horizon", 2.0), ("youngs_modulus", YOUNG)] {
        model.set(key, value).unwrap();
    }
    if formulation != "bond_based" {
        model.set("poissons_ratio", RATIO).unwrap();
    }
    let mut chain = Simulation::new(&points, &model).unwrap();
    let moved: Vec<f64> = (0..COUNT)
        .flat_map(|point| [if point % 2 == 0 { SHIFT } else { -SHIFT }, 0.0, 0.0])
        .collect();
    chain.set(Field::Displacement, &moved).unwrap();
    chain
}

/// Points whose families, and those of so many layers of neighbours, are whole.
fn whole(layers: usize) -> std::ops::Range<usize> {
    let rim = 2 * (layers + 1);
    rim..COUNT - rim
}

/// In uniaxial stress: E/2 of the Green strain squared.
fn string_energy(stretch: f64) -> f64 {
    let strain = stretch + 0.5 * stretch * stretch;
    0.5 * YOUNG * strain * strain
}

#[test]
fn the_gradient_of_a_family_does_not_see_a_zigzag() {
    for formulation in
        ["correspondence", "correspondence_silling", "correspondence_wan", "total_lagrangian"]
    {
        let chain = chain(formulation);
        let gradients = chain.get(Field::DeformationGradient).unwrap();
        let energies = chain.get(Field::StrainEnergyDensity).unwrap();
        for point in whole(0) {
            let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
            assert_eq!(gradients[9 * point..][..9], identity, "{formulation}");
            assert_eq!(energies[point], 0.0, "{formulation}");
        }
        // At the end the bond of 1 has no counterpart: sum xi du = -2a over K = 1 + 4.
        let end = string_energy(-2.0 * SHIFT / 5.0);
        assert!((energies[0] / end - 1.0).abs() < 1e-13, "{formulation}");
        let forces = chain.get(Field::InternalForce).unwrap();
        let penalised = formulation.starts_with("correspondence_");
        for point in whole(1) {
            assert_eq!(forces[3 * point] != 0.0, penalised, "{formulation}");
        }
    }
}

#[test]
fn what_looks_at_bonds_stores_the_energy_of_a_zigzag() {
    let (square, bulk) = (SHIFT * SHIFT, YOUNG / (3.0 * (1.0 - 2.0 * RATIO)));
    let shear = YOUNG / (2.0 * (1.0 + RATIO));
    // The bonds of 2 each bring h = 2a/5 of sum xi du over K = 1 + 4, the part of the family that is near their end.
    let near = 2.0 * SHIFT / 5.0;
    for (formulation, expected) in [
        // 1/4 c s^2 L for two bonds of stretch 2a, c = 18K/(pi 2^4)
        ("bond_based", 2.0 * 18.0 * bulk / (PI * 16.0) * square),
        // theta = 0, m = 10: 15 G/(2 m) (2a)^2 twice
        ("ordinary_state_based", 6.0 * shear * square),
        // theta = 0: b w (2a)^2 twice, b = 15 G/(2 pi 2^5), w = 2
        ("madenci_oterkus", 16.0 * 15.0 * shear / (64.0 * PI) * square),
        // Two bonds of four, each of weight 1/4.
        (
            "bond_associated_quadrature",
            0.25 * (string_energy(2.0 * SHIFT) + string_energy(-2.0 * SHIFT)),
        ),
        // Families of 3, 3, 2 and 2 points; the first two see nothing.
        ("bond_associated", 0.2 * (string_energy(near) + string_energy(-near))),
    ] {
        let chain = chain(formulation);
        let energies = chain.get(Field::StrainEnergyDensity).unwrap();
        for point in whole(1) {
            let off = (energies[point] / expected - 1.0).abs();
            // Some ten roundings of 1e-16.
            assert!(
                off < 1e-14,
                "{formulation}, point {point}: {}, not {expected}",
                energies[point]
            );
        }
    }
}

#[test]
fn penalties_store_the_energy_of_a_zigzag_apart() {
    let (square, bulk) = (SHIFT * SHIFT, YOUNG / (3.0 * (1.0 - 2.0 * RATIO)));
    for (formulation, expected) in [
        // 1/2 beta (2a)^2 twice, beta = 18K/(pi 2^5)
        ("correspondence_silling", 4.0 * 18.0 * bulk / (PI * 32.0) * square),
        // As Silling's, with lambda tr(K^-1) + 2 mu K^-1 along the chain and K = 10.
        ("correspondence_wan", 4.0 * square * wan() / 10.0),
    ] {
        let energies = chain(formulation).get(Field::StabilizationEnergyDensity).unwrap();
        for point in whole(0) {
            let off = (energies[point] / expected - 1.0).abs();
            assert!(
                off < 1e-14,
                "{formulation}, point {point}: {}, not {expected}",
                energies[point]
            );
        }
    }
}

/// lambda + 2 mu
fn wan() -> f64 {
    YOUNG * (1.0 - RATIO) / ((1.0 + RATIO) * (1.0 - 2.0 * RATIO))
}
