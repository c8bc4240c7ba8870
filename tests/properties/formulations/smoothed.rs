//! Smoothed particle hydrodynamics with corrected kernel gradients is correspondence with the influence
//! function -W'(L)/L. [G 4.1-4.3]

use std::f64::consts::PI;

use perion::Field;

use super::{Body, Form, apart, bodies, largest};
use crate::scene::bonds;

type Matrix = [[f64; 3]; 3];

/// W'(L) of a kernel with a support.
type Slope = fn(f64, f64) -> f64;

/// Kernels, with the influence function that each stands for.
const KERNELS: [(&str, Slope); 4] = [
    // W = c (support^2 - L^2)/2, c = 1
    ("constant", |length, _| -length),
    // W = support (support - L)
    ("inverse", |_, support| -support),
    // W' as that of the quadratic kernel, pressed down towards the rim.
    ("conical", |length, support| -length * (1.0 - length / support)),
    ("cubic_spline", |length, support| {
        let q = length / support;
        let shape =
            if q < 0.5 { 1.0 - 6.0 * q * q + 6.0 * q * q * q } else { 2.0 * (1.0 - q).powi(3) };
        -length * 8.0 * shape / (PI * support.powi(3))
    }),
];

fn outer_sum(sum: &mut Matrix, factor: f64, a: &[f64; 3], b: &[f64; 3]) {
    for (row, a) in sum.iter_mut().zip(a) {
        row.iter_mut().zip(b).for_each(|(sum, b)| *sum += factor * a * b);
    }
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| (0..3).map(|k| a[row][k] * b[k][column]).sum())
    })
}

fn applied(a: &Matrix, v: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|row| (0..3).map(|k| a[row][k] * v[k]).sum())
}

fn inverse(a: &Matrix) -> Matrix {
    let minor = |row: usize, column: usize| {
        let at = |k: usize, l: usize| a[(row + k) % 3][(column + l) % 3];
        at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
    };
    let determinant: f64 = (0..3).map(|k| a[0][k] * minor(0, k)).sum();
    std::array::from_fn(|row| std::array::from_fn(|column| minor(column, row) / determinant))
}

/// P of Saint Venant-Kirchhoff.
fn stress(f: &Matrix, lambda: f64, mu: f64) -> Matrix {
    let unit = |row: usize, column: usize| if row == column { 1.0 } else { 0.0 };
    let strain: Matrix = std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            0.5 * ((0..3).map(|k| f[k][row] * f[k][column]).sum::<f64>() - unit(row, column))
        })
    });
    let trace: f64 = (0..3).map(|k| strain[k][k]).sum();
    let second = std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            lambda * trace * unit(row, column) + 2.0 * mu * strain[row][column]
        })
    });
    product(f, &second)
}

/// F and the force per volume of all particles, by the formulas of corrected total-Lagrangian SPH [G 15, 17, 21].
fn smoothed(
    body: &Body,
    neighbors: &[Vec<usize>],
    slope: Slope,
    moved: &[f64],
    [lambda, mu]: [f64; 2],
) -> [Vec<f64>; 2] {
    let (scene, support) = (&body.scene, body.scene.materials[0].horizon);
    let apart = |of: &[f64], i: usize, j: usize| -> [f64; 3] {
        std::array::from_fn(|axis| of[3 * j + axis] - of[3 * i + axis])
    };
    let kernel_gradient = |i: usize, j: usize| -> [f64; 3] {
        let from = apart(&scene.coordinates, i, j);
        let length = from.iter().map(|x| x * x).sum::<f64>().sqrt();
        from.map(|x| slope(length, support) * x / length)
    };
    let (mut gradients, mut pulls) = (Vec::new(), Vec::new());
    for (i, others) in neighbors.iter().enumerate() {
        let (mut correction, mut gradient): (Matrix, Matrix) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for &j in others {
            let from = apart(&scene.coordinates, i, j);
            outer_sum(&mut correction, scene.volumes[j], &kernel_gradient(i, j), &from);
        }
        let correction = inverse(&correction);
        for &j in others {
            let corrected = applied(&correction, &kernel_gradient(i, j));
            outer_sum(&mut gradient, scene.volumes[j], &apart(moved, i, j), &corrected);
        }
        (0..3).for_each(|k| gradient[k][k] += 1.0);
        pulls.push(product(&stress(&gradient, lambda, mu), &correction));
        gradients.extend_from_slice(gradient.as_flattened());
    }
    let mut forces = Vec::new();
    for (i, others) in neighbors.iter().enumerate() {
        let mut force = [0.0; 3];
        for &j in others {
            let own = applied(&pulls[i], &kernel_gradient(i, j));
            let other = applied(&pulls[j], &kernel_gradient(j, i));
            (0..3).for_each(|k| force[k] += scene.volumes[j] * (own[k] - other[k]));
        }
        forces.extend(force);
    }
    [gradients, forces]
}

#[test]
fn correspondence_is_smoothed_particles_with_a_kernel_of_its_own() {
    let form = Form { name: "correspondence", order: 1 };
    let mut count = 0;
    let clouds = bodies().into_iter().filter(|body| {
        // One kernel for all particles, or SPH keeps no momentum.
        body.scene.dimension == 3 && body.scene.horizons.is_none() && body.scene.second.is_empty()
    });
    for cloud in clouds {
        assert!(cloud.scene.volumes.iter().any(|volume| *volume != cloud.scene.volumes[0]));
        for (influence, slope) in KERNELS {
            let mut body = cloud.clone().with_law("saint_venant_kirchhoff");
            body.influences = [influence; 2];
            let mut random = body.scene.random(81);
            let mut simulation = body.simulation(form);
            let all = bonds(&simulation).into_iter().map(|(pair, _, _)| pair);
            let (broken, left): (Vec<_>, Vec<_>) = all.partition(|_| random.chance(0.15));
            assert!(!broken.is_empty());
            simulation.break_bonds(&broken).unwrap();
            let mut neighbors = vec![Vec::new(); body.scene.count()];
            for [i, j] in left {
                neighbors[i].push(j);
                neighbors[j].push(i);
            }
            // Strains and turns of a third, with what is different at every point on top.
            let (f, spacing) = (random.around_zero(9, 0.3), body.scene.spacing);
            let mut moved = random.around_zero(body.scene.components(), 0.1 * spacing);
            for (moved, place) in moved.chunks_exact_mut(3).zip(body.scene.coordinates.chunks(3)) {
                for (row, moved) in moved.iter_mut().enumerate() {
                    *moved += (0..3)
                        .map(|k| f[3 * row + k] * (place[k] - body.scene.coordinates[k]))
                        .sum::<f64>();
                }
            }
            simulation.set(Field::Displacement, &moved).unwrap();
            let (modulus, ratio) = (body.youngs_modulus(), super::RATIOS[0]);
            let lame = [
                modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio)),
                0.5 * modulus / (1.0 + ratio),
            ];
            let expected = smoothed(&body, &neighbors, slope, &moved, lame);
            for (field, expected) in
                [Field::DeformationGradient, Field::InternalForce].into_iter().zip(&expected)
            {
                let off = apart(&simulation.get(field).unwrap(), expected) / largest(expected);
                eprintln!("SPH, {influence}, {field:?}: {off:.1e}");
                // Sums of some fifty terms, rounded to 1e-16 each, through an inverse.
                assert!(off < 1e-12, "{influence} {field:?}: {off:e}");
            }
            count += 1;
        }
    }
    assert!(count >= 4, "{count}");
}
