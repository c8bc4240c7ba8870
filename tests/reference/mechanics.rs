//! Forces, energies, families and damage of deformed bodies.

use crate::data::{PLATES, Reference, SOLIDS, assert_close, assert_near, largest, pair};
use perion::{Field, Model, Simulation};

/// Positions of 1 are rounded to 1e-16, by the reference, by its file and by the displacements made of
/// them; over the 1e-2 by which bonds change their length that is 1e-14 each, and sums even it out.
const TOLERANCE: f64 = 1e-13;

fn bodies() -> impl Iterator<Item = Reference> {
    SOLIDS.into_iter().chain(PLATES).map(Reference::load)
}

#[test]
fn forces_are_those_of_the_reference() {
    for reference in bodies() {
        let mut lean = reference.model();
        lean.choose("storage", "lean").unwrap();
        for model in [reference.model(), lean] {
            let force = reference.body_of(&model).get(Field::InternalForce).unwrap();
            let expected = reference.numbers("bond_based/force");
            assert_close(reference.name(), &force, &expected, TOLERANCE);
        }
    }
}

#[test]
fn an_evaluation_gives_the_forces_that_a_look_at_them_gives() {
    for reference in bodies() {
        let mut body = reference.body();
        let looked_at = body.get(Field::InternalForce).unwrap();
        body.evaluate().unwrap();
        assert_eq!(body.get(Field::InternalForce).unwrap(), looked_at, "{}", reference.name());
        // The density is 1, and nothing else acts.
        assert_eq!(body.get(Field::Acceleration).unwrap(), looked_at, "{}", reference.name());
    }
}

#[test]
fn strain_energies_are_those_of_the_reference() {
    for reference in bodies() {
        let body = reference.body();
        let density = body.get(Field::StrainEnergyDensity).unwrap();
        let expected = reference.numbers("bond_based/strain_energy_density");
        assert_close(reference.name(), &density, &expected, TOLERANCE);
        let expected = reference.number("bond_based/strain_energy");
        assert_near(reference.name(), body.energy().unwrap().elastic, expected, TOLERANCE);
    }
}

/// Bonds whose integrity is kept one by one take another path through the code than those that are
/// whole or broken.
#[test]
fn bonds_with_an_integrity_of_their_own_give_the_same_forces_and_energies() {
    for reference in bodies().filter(|reference| !reference.broken_pairs().is_empty()) {
        let pairs = reference.broken_pairs();
        let mut graded = Simulation::new(&reference.points(), &reference.model()).unwrap();
        graded.set_bond_integrity(&pairs[..1], &[0.5]).unwrap();
        graded.set_bond_integrity(&pairs, &vec![0.0; pairs.len()]).unwrap();
        graded.set(Field::Position, &reference.numbers("current")).unwrap();
        for (field, key) in [
            (Field::InternalForce, "bond_based/force"),
            (Field::StrainEnergyDensity, "bond_based/strain_energy_density"),
            (Field::Damage, "damage"),
        ] {
            let expected = reference.numbers(key);
            assert_close(reference.name(), &graded.get(field).unwrap(), &expected, TOLERANCE);
        }
    }
}

#[test]
fn every_family_has_as_many_neighbours_as_in_the_reference() {
    for reference in bodies() {
        let body = reference.body();
        let expected = reference.numbers("neighbor_count");
        let name = reference.name();
        assert_eq!(body.get(Field::NeighborCount).unwrap(), expected, "{name}");
        let ends: f64 = expected.iter().sum();
        assert_eq!(2 * body.bond_count().unwrap(), ends as u64, "{name}");
        let health = body.health().unwrap();
        assert_eq!(health.broken_bonds, reference.broken_pairs().len() as u64, "{name}");
    }
}

#[test]
fn damage_is_the_share_of_the_family_that_broken_bonds_held() {
    for reference in bodies() {
        let damage = reference.body().get(Field::Damage).unwrap();
        // A quotient of two sums of positive volumes: a rounding or two for each of 47 of them.
        for (found, expected) in damage.iter().zip(reference.numbers("damage")) {
            assert!((found - expected).abs() <= 1e-14, "{}: {found}", reference.name());
        }
    }
}

#[test]
fn the_bond_constant_is_that_of_the_reference() {
    for reference in bodies() {
        let length = 0.5 * reference.number("horizon");
        let dimension = reference.dimension();
        let mut two = Simulation::new(&pair(dimension, length), &reference.model()).unwrap();
        let mut shift = vec![0.0; 2 * dimension];
        shift[dimension] = 1e-3 * length;
        two.set(Field::Displacement, &shift).unwrap();
        let force = two.get(Field::InternalForce).unwrap();
        let expected = 1e-3 * reference.number("bond_based/bond_constant");
        // Nothing is summed: what is left are a dozen roundings of 1e-16, on either side.
        assert_near(reference.name(), force[0], expected, 4e-15);
        assert_near(reference.name(), -force[dimension], expected, 4e-15);
    }
}

#[test]
fn a_rigid_motion_leaves_neither_force_nor_energy() {
    let reference = Reference::load("rigid3d");
    let mut model = Model::new("bond_based").unwrap();
    model.set("density", 1.0).unwrap();
    model.set("horizon", reference.number("horizon")).unwrap();
    model.set("youngs_modulus", reference.number("youngs_modulus")).unwrap();
    let mut body = Simulation::new(&reference.points(), &model).unwrap();
    let current = reference.numbers("current");
    body.set(Field::Position, &current).unwrap();
    let mut shortest = f64::INFINITY;
    let positions = reference.numbers("positions");
    for (one, place) in positions.chunks(3).enumerate() {
        for other in positions.chunks(3).skip(one + 1) {
            let squared: f64 = place.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum();
            shortest = squared.sqrt().min(shortest);
        }
    }
    // The current positions are rounded, and displacements are rounded again: a bond's vector is off
    // by a few units in the last place of the largest coordinate.
    let stretch = 4.0 * f64::EPSILON * largest(&current) / shortest;
    let horizon = reference.number("horizon");
    let bulk_modulus = reference.number("youngs_modulus") / 1.5;
    let constant = 18.0 * bulk_modulus / (std::f64::consts::PI * horizon.powi(4));
    let neighbours = largest(&body.get(Field::NeighborCount).unwrap());
    let family = neighbours * largest(&reference.numbers("volumes"));
    let force = largest(&body.get(Field::InternalForce).unwrap());
    assert!(force <= constant * stretch * family, "{force:e}");
    let density = largest(&body.get(Field::StrainEnergyDensity).unwrap());
    assert!(density <= 0.25 * constant * stretch.powi(2) * horizon * family, "{density:e}");
}
