//! What does not hold, and by how much: forms of the literature that are no slope of an energy or not objective.
//! Without these, tests of what holds might not see anything.

use std::f64::consts::PI;

use perion::Field;

use super::energies::{momentum, off_slope};
use super::{Body, Form, RATIOS, Turn, apart, bodies, largest};
use crate::forces::forces;
use crate::scene::bonds;

/// The least of a deviation over the bodies.
fn least(what: &str, bodies: &[Body], deviation: impl Fn(&Body) -> f64) -> f64 {
    let found: Vec<f64> = bodies.iter().map(deviation).collect();
    let (least, most) =
        found.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    eprintln!("{what}: {least:.1e} to {most:.1e}");
    least
}

#[test]
fn the_literal_force_of_bond_associated_is_no_slope_of_its_energy() {
    let form = Form { name: "bond_associated", order: 1 };
    let off = least("literal force", &bodies(), |body| {
        let mut simulation =
            body.changed(form, |model| model.choose("force_form", "literal").unwrap());
        body.scene.wound(&mut simulation);
        // Momentum it keeps, as any difference of force states does.
        simulation.set(Field::Displacement, &body.shaken()).unwrap();
        assert!(momentum(&simulation)[0] < 1e-13);
        off_slope(&mut simulation, body, &body.shaken())
    });
    // Measured: 3 % to 20 %; the form that is the slope is off by less than 1e-9.
    assert!(off > 1e-2, "{off:e}");
}

#[test]
fn the_forces_of_deformed_bonds_are_no_slope_of_the_energy() {
    for name in ["total_lagrangian", "updated_lagrangian"] {
        let form = Form { name, order: 1 };
        let with = |body: &Body, bonds: &str| {
            let mut simulation =
                body.changed(form, |model| model.choose("operator_bonds", bonds).unwrap());
            off_slope(&mut simulation, body, &body.shaken())
        };
        let off = least(&format!("{name}, deformed"), &bodies(), |body| with(body, "deformed"));
        // Measured: 0.3 % to 3 %.
        assert!(off > 1e-3, "{name} {off:e}");
        for body in bodies() {
            let off = with(&body, "undeformed");
            assert!(off < 1e-9, "{name} {off:e}");
        }
    }
}

/// Ordinary state-based peridynamics as [M] has it, with the factor m^.n of its equations 34, 47 and 51 or without,
/// for a body of one material.
struct Printed<'a> {
    body: &'a Body,
    /// Pairs and integrities.
    bonds: Vec<([usize; 2], f64)>,
    with_factor: bool,
    /// a, b, d and delta
    constants: [f64; 4],
}

impl<'a> Printed<'a> {
    fn new(body: &'a Body, bonds: &[([usize; 2], f64, f64)], with_factor: bool) -> Self {
        let (modulus, horizon) = (body.youngs_modulus(), body.scene.materials[0].horizon);
        let mu = 0.5 * modulus / (1.0 + RATIOS[0]);
        let bulk = modulus / (3.0 * (1.0 - 2.0 * RATIOS[0]));
        let constants = [
            0.5 * (bulk - 5.0 * mu / 3.0),
            15.0 * mu / (2.0 * PI * horizon.powi(5)),
            9.0 / (4.0 * PI * horizon.powi(4)),
            horizon,
        ];
        let bonds = bonds.iter().map(|(pair, _, integrity)| (*pair, *integrity)).collect();
        Self { body, bonds, with_factor, constants }
    }

    /// w, e, the factor, and m^ of a bond.
    fn bond(&self, [i, j]: [usize; 2], integrity: f64, moved: &[f64]) -> (f64, f64, f64, [f64; 3]) {
        let places = &self.body.scene.coordinates;
        let from: [f64; 3] =
            std::array::from_fn(|axis| places[3 * j + axis] - places[3 * i + axis]);
        let now: [f64; 3] =
            std::array::from_fn(|axis| from[axis] + moved[3 * j + axis] - moved[3 * i + axis]);
        let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (before, after) = (dot(&from, &from).sqrt(), dot(&now, &now).sqrt());
        let factor = if self.with_factor { dot(&from, &now) / (before * after) } else { 1.0 };
        let weight = integrity * self.constants[3] / before;
        (weight, after - before, factor, now.map(|x| x / after))
    }

    fn dilatations(&self, moved: &[f64]) -> Vec<f64> {
        let volumes = &self.body.scene.volumes;
        let mut dilatations = vec![0.0; volumes.len()];
        for &(pair, integrity) in &self.bonds {
            let (weight, extension, factor, _) = self.bond(pair, integrity, moved);
            for [own, other] in [pair, [pair[1], pair[0]]] {
                dilatations[own] +=
                    self.constants[2] * weight * factor * extension * volumes[other];
            }
        }
        dilatations
    }

    /// The whole energy.
    fn energy(&self, moved: &[f64]) -> f64 {
        let ([a, b, ..], volumes) = (self.constants, &self.body.scene.volumes);
        let swelling = self.dilatations(moved);
        let mut energy: f64 = swelling.iter().zip(volumes).map(|(t, v)| a * t * t * v).sum();
        for &(pair, integrity) in &self.bonds {
            let (weight, extension, ..) = self.bond(pair, integrity, moved);
            energy +=
                2.0 * b * weight * extension * extension * volumes[pair[0]] * volumes[pair[1]];
        }
        energy
    }

    /// V b of all points.
    fn forces(&self, moved: &[f64]) -> Vec<f64> {
        let ([a, b, d, _], volumes) = (self.constants, &self.body.scene.volumes);
        let swelling = self.dilatations(moved);
        let mut forces = vec![0.0; moved.len()];
        for &([i, j], integrity) in &self.bonds {
            let (weight, extension, factor, direction) = self.bond([i, j], integrity, moved);
            let tension = 2.0
                * weight
                * (a * d * factor * (swelling[i] + swelling[j]) + 2.0 * b * extension)
                * volumes[i]
                * volumes[j];
            for (axis, direction) in direction.iter().enumerate() {
                forces[3 * i + axis] += tension * direction;
                forces[3 * j + axis] -= tension * direction;
            }
        }
        forces
    }

    /// How far the forces are from the slope of the energy, by central differences of fourth order.
    fn off_slope(&self, moved: &[f64]) -> f64 {
        let (forces, reach) = (self.forces(moved), 1e-3 * self.body.scene.spacing);
        let mut random = self.body.scene.random(6);
        let mut worst = 0.0_f64;
        for _ in 0..10 {
            let component = random.below(moved.len());
            let energy = |by: f64| {
                let mut moved = moved.to_vec();
                moved[component] += by;
                self.energy(&moved)
            };
            let near = energy(reach) - energy(-reach);
            let far = energy(2.0 * reach) - energy(-2.0 * reach);
            worst = worst.max((forces[component] + (8.0 * near - far) / (12.0 * reach)).abs());
        }
        worst / largest(&forces)
    }
}

#[test]
fn the_factor_that_madenci_oterkus_goes_without_takes_objectivity_and_energy() {
    let form = Form { name: "madenci_oterkus", order: 1 };
    let clouds: Vec<Body> = bodies()
        .into_iter()
        .filter(|body| {
            let scene = &body.scene;
            scene.dimension == 3 && scene.second.is_empty() && scene.horizons.is_none()
        })
        .collect();
    assert!(!clouds.is_empty());
    for body in &clouds {
        let scene = &body.scene;
        let mut simulation = body.wounded(form);
        let all = bonds(&simulation);
        // Displacements of up to a fifth of the spacing turn bonds by as much.
        let moved = scene.random(82).around_zero(scene.components(), 0.2 * scene.spacing);
        let turn = Turn::random(3, &mut scene.random(83));
        let turned = turn.displacement(scene, &moved);
        for with_factor in [false, true] {
            let printed = Printed::new(body, &all, with_factor);
            simulation.set(Field::Displacement, &turned).unwrap();
            let [expected, now] = [&moved, &turned].map(|moved| printed.forces(moved));
            let [before, after] = [&moved, &turned].map(|moved| printed.energy(moved));
            let found = [
                apart(&forces(&simulation), &now) / largest(&expected),
                (simulation.energy().unwrap().elastic / after - 1.0).abs(),
                (after / before - 1.0).abs(),
                apart(&now, &turn.turned(3, &expected)) / largest(&expected),
                printed.off_slope(&turned),
            ];
            eprintln!("Madenci-Oterkus, factor {with_factor}: {found:?}");
            if with_factor {
                // Measured: 1.2 % to 4 %, and 8e-4 of the slope, to which only the swelling contributes.
                assert!(found[..4].iter().all(|off| *off > 1e-2), "{found:?}");
                assert!(found[4] > 1e-4, "{found:?}");
            } else {
                // A sum of a hundred bonds, and the tolerance of a slope from differences.
                assert!(found[..4].iter().all(|off| *off < 1e-12), "{found:?}");
                assert!(found[4] < 1e-9, "{found:?}");
            }
        }
    }
}
