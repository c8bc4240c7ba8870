//! What the thickness of a plate changes, and what it does not.

use crate::data::{PLATES, Reference, assert_close, assert_near, scaled};
use perion::{Field, Quantity, Simulation};

/// A thickness that scales numbers without rounding, and one that rounds: c holds 1/h and V holds h,
/// so that each term of a sum is a few roundings off.
const THICKNESSES: [(f64, f64); 2] = [(0.125, 0.0), (0.3, 1e-14)];

/// A deformed plate whose left edge is held, and which may break.
fn plate(reference: &Reference, thickness: f64) -> Simulation {
    let mut points = reference.points();
    points.add_set_box("left", &[0.0, 0.0], &[0.15, 1.0]).unwrap();
    let mut model = reference.model();
    model.set("thickness", thickness).unwrap();
    model.set("critical_energy_release_rate", 0.5).unwrap();
    let mut plate = Simulation::new(&points, &model).unwrap();
    plate.break_bonds(&reference.broken_pairs()).unwrap();
    plate.set(Field::Position, &reference.numbers("current")).unwrap();
    plate.prescribe("left", Quantity::Velocity, 0, -1.0).unwrap();
    plate.prescribe("left", Quantity::Displacement, 1, 0.0).unwrap();
    plate.prescribe("all", Quantity::BodyForce, 0, 20.0).unwrap();
    plate
}

#[test]
fn forces_and_energies_per_volume_do_not_depend_on_thickness() {
    for reference in PLATES.map(Reference::load) {
        let mut thin = plate(&reference, 1.0);
        thin.evaluate().unwrap();
        for (thickness, tolerance) in THICKNESSES {
            let mut thick = plate(&reference, thickness);
            thick.evaluate().unwrap();
            for field in [
                Field::InternalForce,
                Field::Acceleration,
                Field::StrainEnergyDensity,
                Field::Damage,
                Field::TimeStepEstimate,
            ] {
                let (found, expected) = (thick.get(field).unwrap(), thin.get(field).unwrap());
                assert_close(field.name(), &found, &expected, tolerance);
            }
            let (found, expected) = (thick.stable_time_step(), thin.stable_time_step());
            // From differences of forces: rounding over a move of 1e-6, where the thickness rounds at all.
            let tolerance = if tolerance == 0.0 { 0.0 } else { 1e-9 };
            assert_near("stable step", found.unwrap(), expected.unwrap(), tolerance);
        }
    }
}

#[test]
fn volumes_energies_and_reactions_scale_with_thickness() {
    for reference in PLATES.map(Reference::load) {
        let mut thin = plate(&reference, 1.0);
        thin.evaluate().unwrap();
        assert_eq!(thin.get(Field::Volume).unwrap(), reference.numbers("volumes"));
        for (thickness, tolerance) in THICKNESSES {
            let mut thick = plate(&reference, thickness);
            thick.evaluate().unwrap();
            for field in [Field::Volume, Field::Reaction] {
                let expected = scaled(&thin.get(field).unwrap(), thickness);
                assert_close(field.name(), &thick.get(field).unwrap(), &expected, tolerance);
            }
            let expected = thickness * thin.energy().unwrap().elastic;
            assert_near("elastic", thick.energy().unwrap().elastic, expected, tolerance);
        }
    }
}

#[test]
fn a_breaking_plate_of_any_thickness_moves_the_same_and_scales_its_energies() {
    for reference in PLATES.map(Reference::load) {
        let run = |thickness: f64| {
            let mut plate = plate(&reference, thickness);
            plate.step(5e-3, 40).unwrap();
            plate
        };
        let thin = run(1.0);
        let health = thin.health().unwrap();
        let cut = reference.broken_pairs().len() as u64;
        assert!(health.broken_bonds > cut + 20, "{}: {health:?}", reference.name());
        for (thickness, rounding) in THICKNESSES {
            let thick = run(thickness);
            // Forty steps carry the roundings of the forces on.
            let tolerance = 10.0 * rounding;
            let broken = thick.health().unwrap().broken_bonds;
            assert_eq!(broken, health.broken_bonds, "{}", reference.name());
            for field in [Field::Displacement, Field::Velocity, Field::DissipatedEnergyDensity] {
                let (found, expected) = (thick.get(field).unwrap(), thin.get(field).unwrap());
                assert_close(field.name(), &found, &expected, tolerance);
            }
            let (found, expected) = (thick.energy().unwrap(), thin.energy().unwrap());
            for (what, found, expected) in [
                ("kinetic", found.kinetic, expected.kinetic),
                ("elastic", found.elastic, expected.elastic),
                ("dissipated", found.dissipated, expected.dissipated),
                ("external work", found.external_work, expected.external_work),
            ] {
                assert!(expected.abs() > 0.0, "{what}");
                assert_near(what, found, thickness * expected, tolerance);
            }
        }
    }
}
