//! Forces: momentum is kept, they are the slope of the energy, and rigid motions cause none.

use perion::{Field, Simulation};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use crate::random::{Random, cases};
use crate::scene::{Scene, bodies};

/// The cross product of two vectors of 2 or 3 components.
pub fn cross(a: &[f64], b: &[f64]) -> [f64; 3] {
    let pad = |v: &[f64]| [v[0], v[1], v.get(2).copied().unwrap_or(0.0)];
    let (a, b) = (pad(a), pad(b));
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// V_i b_i, point after point.
pub fn forces(simulation: &Simulation) -> Vec<f64> {
    let volumes = simulation.get(Field::Volume).unwrap();
    let dimension = simulation.points().dimension();
    let mut forces = simulation.get(Field::InternalForce).unwrap();
    for (component, force) in forces.iter_mut().enumerate() {
        *force *= volumes[component / dimension];
    }
    forces
}

/// Displacements of a rotation about `pivot`; in 2D in the plane, in 3D about `axis`.
fn rotation(scene: &Scene, axis: [f64; 3], angle: f64, pivot: &[f64]) -> Vec<f64> {
    let axis = if scene.dimension == 2 { [0.0, 0.0, 1.0] } else { axis };
    let axis = axis.map(|x| x / norm(&axis));
    let mut displacement = Vec::new();
    for place in scene.coordinates.chunks_exact(scene.dimension) {
        let from: Vec<f64> = place.iter().zip(pivot).map(|(x, p)| x - p).collect();
        let once = cross(&axis, &from);
        let twice = cross(&axis, &once);
        // Rodrigues: (R - 1) r = sin a k x r + (1 - cos a) k x (k x r).
        let share = 2.0 * (0.5 * angle).sin().powi(2);
        for axis in 0..scene.dimension {
            displacement.push(angle.sin() * once[axis] + share * twice[axis]);
        }
    }
    displacement
}

fn random_rotation(scene: &Scene, random: &mut Random) -> Vec<f64> {
    let axis = [0, 1, 2].map(|_| random.between(-1.0, 1.0));
    let angle = random.between(-3.2, 3.2);
    let pivot = random.around_zero(scene.dimension, 30.0 * scene.spacing);
    rotation(scene, axis, angle, &pivot)
}

fn momentum_is_kept(scene: &Scene, simulation: &Simulation) -> Result<(), TestCaseError> {
    let (dimension, forces) = (scene.dimension, forces(simulation));
    let positions = simulation.get(Field::Position).unwrap();
    let mut centre = [0.0; 3];
    for place in positions.chunks_exact(dimension) {
        (0..dimension).for_each(|axis| centre[axis] += place[axis] / scene.count() as f64);
    }
    let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
    let (mut force_scale, mut torque_scale) = (0.0, 0.0);
    for (place, own) in positions.chunks_exact(dimension).zip(forces.chunks_exact(dimension)) {
        let arm: Vec<f64> = place.iter().zip(&centre).map(|(x, c)| x - c).collect();
        (0..dimension).for_each(|axis| force[axis] += own[axis]);
        (0..3).for_each(|axis| torque[axis] += cross(&arm, own)[axis]);
        force_scale += norm(own);
        torque_scale += norm(&arm) * norm(own);
    }
    // Each of some 200 points adds up to 120 bonds, each rounded to 1e-16, with random signs.
    prop_assert!(norm(&force) <= 1e-13 * force_scale, "{} {force_scale}", norm(&force));
    prop_assert!(norm(&torque) <= 1e-13 * torque_scale, "{} {torque_scale}", norm(&torque));
    Ok(())
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn internal_forces_keep_linear_and_angular_momentum(recipe in bodies(), wound: bool) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(None);
        if wound {
            scene.wound(&mut simulation);
        }
        let mut random = scene.random(1);
        let shaken = random.around_zero(scene.components(), 0.05 * scene.spacing);
        simulation.set(Field::Displacement, &shaken).unwrap();
        momentum_is_kept(&scene, &simulation)?;
        let turned = random_rotation(&scene, &mut random);
        let both: Vec<f64> = turned.iter().zip(&shaken).map(|(a, b)| a + b).collect();
        simulation.set(Field::Displacement, &both).unwrap();
        momentum_is_kept(&scene, &simulation)?;
    }
}

/// The slope of the total energy along a component, by central differences of each point's energy.
fn energy_slope(simulation: &mut Simulation, at: &[f64], component: usize, reach: f64) -> f64 {
    let volumes = simulation.get(Field::Volume).unwrap();
    let mut densities = [1.0, -1.0].map(|sign| {
        let mut moved = at.to_vec();
        moved[component] += sign * reach;
        simulation.set(Field::Displacement, &moved).unwrap();
        (moved[component], simulation.get(Field::StrainEnergyDensity).unwrap())
    });
    let [(ahead, forward), (behind, backward)] = &mut densities;
    let change: f64 = (0..volumes.len()).map(|i| volumes[i] * (forward[i] - backward[i])).sum();
    change / (*ahead - *behind)
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn force_is_minus_the_slope_of_the_energy(
        recipe in bodies(), wound: bool, strain in 0.005..0.08,
    ) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(None);
        if wound {
            scene.wound(&mut simulation);
        }
        let mut random = scene.random(2);
        let at = random.around_zero(scene.components(), strain * scene.spacing);
        simulation.set(Field::Displacement, &at).unwrap();
        let forces = forces(&simulation);
        let scale = forces.iter().copied().map(f64::abs).fold(0.0, f64::max);
        for _ in 0..12 {
            let component = random.below(scene.components());
            // Truncation: (reach/length)^2 over the strain, 1e-9; rounding: 1e-16 length/reach.
            let slope = energy_slope(&mut simulation, &at, component, 3e-6 * scene.spacing);
            let error = (forces[component] + slope).abs() / scale;
            prop_assert!(error < 1e-8, "component {component}: {error:e} of the largest force");
        }
    }

    #[test]
    fn a_translation_stores_exactly_nothing(recipe in bodies(), wound: bool, size in -8..8_i32) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(Some(1e-6));
        if wound {
            scene.wound(&mut simulation);
        }
        let mut random = scene.random(3);
        let shift = random.around_zero(scene.dimension, scene.spacing * 10_f64.powi(size));
        let displacement = shift.repeat(scene.count());
        let before = simulation.health().unwrap().broken_bonds;
        simulation.set(Field::Displacement, &displacement).unwrap();
        simulation.evaluate().unwrap();
        simulation.commit(0.0).unwrap();
        for field in [Field::StrainEnergyDensity, Field::InternalForce, Field::Acceleration] {
            simulation.evaluate().unwrap();
            let values = simulation.get(field).unwrap();
            prop_assert!(values.iter().all(|&value| value == 0.0), "{}", field.name());
        }
        let energy = simulation.energy().unwrap();
        prop_assert_eq!((energy.elastic, energy.kinetic, energy.closure_error), (0.0, 0.0, 0.0));
        prop_assert_eq!(simulation.health().unwrap().broken_bonds, before);
    }

    #[test]
    fn a_rotation_stores_nothing_but_rounding(recipe in bodies(), wound: bool) {
        let scene = recipe.scene();
        let mut simulation = scene.simulation(None);
        if wound {
            scene.wound(&mut simulation);
        }
        let mut random = scene.random(4);
        let turned = random_rotation(&scene, &mut random);
        simulation.set(Field::Displacement, &turned).unwrap();
        let densities = simulation.get(Field::StrainEnergyDensity).unwrap();
        let largest = densities.iter().copied().fold(0.0, f64::max);
        let moved = turned.iter().copied().map(f64::abs).fold(0.0, f64::max);
        // A displacement of |u| is rounded by 1e-16 |u|, bonds stretch by some 1e-15 |u|/horizon.
        let scale = scene.bulk_modulus() * (1.0 + moved / scene.largest_horizon()).powi(2);
        prop_assert!(largest < 1e-26 * scale, "{:e}", largest / scale);
    }
}
