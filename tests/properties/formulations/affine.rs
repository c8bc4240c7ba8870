//! Affine deformations: the energy is that of the material, whatever bonds are left, and inside a lattice nothing
//! pulls.

use perion::{Field, Simulation};

use super::{Body, Form, RATIOS, bodies, body_at, hold, largest, lattice};
use crate::random::Random;
use crate::scene::bonds;

type Matrix = [[f64; 3]; 3];

/// lambda and mu of a material of a body.
fn lame(body: &Body, material: usize) -> (f64, f64) {
    let (modulus, ratio) = (body.scene.materials[material].youngs_modulus, RATIOS[material]);
    (modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio)), 0.5 * modulus / (1.0 + ratio))
}

fn determinant(f: &Matrix) -> f64 {
    let minor = |a: usize, b: usize| f[1][a] * f[2][b] - f[1][b] * f[2][a];
    f[0][0] * minor(1, 2) - f[0][1] * minor(0, 2) + f[0][2] * minor(0, 1)
}

/// W(F) by its definition; in plane stress with the F33 that leaves no stress across.
fn energy(body: &Body, f: &Matrix) -> f64 {
    let (lambda, mu) = lame(body, 0);
    let mut f = *f;
    let strain = |f: &Matrix| -> Matrix {
        std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let unit = if row == column { 1.0 } else { 0.0 };
                if body.law == "small_strain" {
                    return 0.5 * (f[row][column] + f[column][row]) - unit;
                }
                0.5 * ((0..3).map(|k| f[k][row] * f[k][column]).sum::<f64>() - unit)
            })
        })
    };
    if body.scene.dimension == 2 && body.scene.plane_stress {
        let plane = strain(&f);
        let across = -lambda / (lambda + 2.0 * mu) * (plane[0][0] + plane[1][1]);
        f[2][2] = match body.law {
            "small_strain" => 1.0 + across,
            "neo_hookean" => {
                // P33 = 0 grows with F33: by halves.
                let (mut low, mut high, area) = (0.1, 10.0, determinant(&f));
                for _ in 0..200 {
                    let t = 0.5 * (low + high);
                    let pull = mu * (t * t - 1.0) + lambda * (area * t).ln();
                    (low, high) = if pull > 0.0 { (low, t) } else { (t, high) };
                }
                low
            }
            _ => (1.0 + 2.0 * across).sqrt(),
        };
    }
    if body.law == "neo_hookean" {
        let squares: f64 = f.iter().flatten().map(|x| x * x).sum();
        let volume = determinant(&f).ln();
        return 0.5 * mu * (squares - 3.0) - mu * volume + 0.5 * lambda * volume * volume;
    }
    let strain = strain(&f);
    let trace: f64 = (0..3).map(|k| strain[k][k]).sum();
    let squares: f64 = strain.iter().flatten().map(|x| x * x).sum();
    0.5 * lambda * trace * trace + mu * squares
}

/// A deformation gradient without order, of strains of a tenth.
fn gradient(dimension: usize, random: &mut Random) -> Matrix {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let unit = if row == column { 1.0 } else { 0.0 };
            let inside = row < dimension && column < dimension;
            if inside { unit + random.between(-0.1, 0.1) } else { unit }
        })
    })
}

/// (F - 1) (X - X_0)
fn displacement(body: &Body, f: &Matrix) -> Vec<f64> {
    let (dimension, places) = (body.scene.dimension, &body.scene.coordinates);
    let mut displacement = Vec::new();
    for place in places.chunks_exact(dimension) {
        for (row, f) in f.iter().enumerate().take(dimension) {
            let terms = (0..dimension).map(|column| {
                let unit = if row == column { 1.0 } else { 0.0 };
                (f[column] - unit) * (place[column] - places[column])
            });
            displacement.push(terms.sum());
        }
    }
    displacement
}

/// Breaks three of ten bonds.
fn thin(simulation: &mut Simulation, random: &mut Random) {
    let all = bonds(simulation).into_iter().map(|(pair, _, _)| pair);
    let broken: Vec<[usize; 2]> = all.filter(|_| random.chance(0.3)).collect();
    simulation.break_bonds(&broken).unwrap();
}

/// Points that have bonds left in all directions, with `each_bond` also in the part of the family near the other end of
/// each: det K above a thousandth of that of a ball.
fn spanned(simulation: &Simulation, body: &Body, each_bond: bool) -> Vec<bool> {
    let (scene, dimension) = (&body.scene, body.scene.dimension);
    let mut families = vec![Vec::new(); scene.count()];
    let horizon =
        |point: usize| scene.horizons.as_ref().map_or(scene.materials[0].horizon, |own| own[point]);
    let length = |bond: &[f64; 3]| bond.iter().map(|x| x * x).sum::<f64>().sqrt();
    for (pair, _, integrity) in bonds(simulation) {
        for [from, to] in [pair, [pair[1], pair[0]]] {
            let at = |point: usize, axis: usize| scene.coordinates[point * dimension + axis];
            let bond = std::array::from_fn(|axis| {
                if axis < dimension { at(to, axis) - at(from, axis) } else { 0.0 }
            });
            if integrity > 0.0 && length(&bond) <= horizon(from) {
                families[from].push(bond);
            }
        }
    }
    let is_round = |family: &mut dyn Iterator<Item = &[f64; 3]>| {
        let mut moments: Matrix = [[0.0; 3]; 3];
        for bond in family {
            for (row, moments) in moments.iter_mut().enumerate() {
                (0..3).for_each(|column| moments[column] += bond[row] * bond[column]);
            }
        }
        let mean = (0..dimension).map(|k| moments[k][k]).sum::<f64>() / dimension as f64;
        if dimension == 2 {
            moments[2][2] = 1.0;
        }
        determinant(&moments) > 1e-3 * mean.powi(dimension as i32)
    };
    let apart = |a: &[f64; 3], b: &[f64; 3]| length(&std::array::from_fn(|axis| a[axis] - b[axis]));
    let bears = |(point, family): (usize, &Vec<[f64; 3]>)| {
        let reach = horizon(point) * (1.0 + 1e-10);
        is_round(&mut family.iter())
            && (!each_bond
                || family.iter().all(|end| {
                    is_round(&mut family.iter().filter(|bond| apart(bond, end) <= reach))
                }))
    };
    families.iter().enumerate().map(bears).collect()
}

/// The bodies of one material, with each law.
fn of_one_material() -> Vec<Body> {
    let alone = |body: &Body| body.scene.second.is_empty();
    let laws = ["saint_venant_kirchhoff", "neo_hookean", "small_strain"];
    let bodies = bodies().into_iter().filter(alone);
    bodies.flat_map(|body| laws.map(|law| body.clone().with_law(law))).collect()
}

#[test]
fn affine_deformation_has_the_energy_of_the_material_whatever_bonds_are_left() {
    // A strain of 0.1 over displacements of one spacing: rounded to 1e-15; gradients of thinned families take ten
    // times that, and of second order a hundred times.
    let tolerance = |form: Form| form.has_law().then_some(1e-12);
    hold("affine", &of_one_material(), tolerance, |form, body| {
        let scene = &body.scene;
        let mut simulation = body.simulation(form);
        thin(&mut simulation, &mut scene.random(8));
        let f = gradient(scene.dimension, &mut scene.random(9));
        simulation.set(Field::Displacement, &displacement(body, &f)).unwrap();
        let expected = energy(body, &f);
        let each_bond = form.name == "bond_associated";
        let spanned = spanned(&simulation, body, each_bond);
        let share =
            spanned.iter().filter(|&&spanned| spanned).count() as f64 / scene.count() as f64;
        let least = if each_bond { 0.25 } else { 0.8 };
        assert!(share > least, "{form:?} {share}");
        let energies = simulation.get(Field::StrainEnergyDensity).unwrap();
        let penalty = largest(&simulation.get(Field::StabilizationEnergyDensity).unwrap());
        // The penalty is a square of rounding.
        assert!(penalty < 1e-20 * body.youngs_modulus(), "{penalty:e}");
        let off = energies.iter().zip(&spanned).filter(|(_, spanned)| **spanned);
        largest(&off.map(|(energy, _)| energy / expected - 1.0).collect::<Vec<f64>>())
    });
}

#[test]
fn ordinary_bonds_have_the_energy_of_swelling_whatever_is_left() {
    let form = Form { name: "ordinary_state_based", order: 1 };
    hold(
        "swelling",
        &of_one_material(),
        |each| (each == form).then_some(1e-13),
        |form, body| {
            let scene = &body.scene;
            let mut simulation = body.simulation(form);
            thin(&mut simulation, &mut scene.random(8));
            let stretch = 0.07;
            let f = std::array::from_fn(|row| {
                std::array::from_fn(|column| if row == column { 1.0 + stretch } else { 0.0 })
            });
            simulation.set(Field::Displacement, &displacement(body, &f)).unwrap();
            // theta = D s and no more, as long as there is a bond.
            let (lambda, mu) = lame(body, 0);
            let kappa = match (scene.dimension, scene.plane_stress) {
                (3, _) => lambda + 2.0 * mu / 3.0,
                (_, true) => 2.0 * lambda * mu / (lambda + 2.0 * mu) + mu,
                _ => lambda + mu,
            };
            let expected = 0.5 * kappa * (scene.dimension as f64 * stretch).powi(2);
            let energies = simulation.get(Field::StrainEnergyDensity).unwrap();
            largest(&energies.iter().map(|energy| energy / expected - 1.0).collect::<Vec<f64>>())
        },
    );
}

#[test]
fn nothing_pulls_inside_a_lattice_that_is_deformed_evenly() {
    let mut lattices = Vec::new();
    for (dimension, side, horizon) in [(3, 15, 2.015), (2, 25, 3.015), (2, 25, 3.015)] {
        let counts = [side, side, if dimension == 3 { side } else { 1 }];
        let mut body = body_at(dimension, lattice(dimension, counts), horizon);
        body.scene.plane_stress = lattices.len() == 2;
        body.influences = [["cubic_spline", "constant", "inverse"][lattices.len()]; 2];
        body.law = ["neo_hookean", "saint_venant_kirchhoff", "neo_hookean"][lattices.len()];
        lattices.push(body);
    }
    // A hundred bonds pull with a tenth of E each and cancel, rounded to 1e-16 each; points that have no edge within
    // three horizons: BAQP reaches that far.
    hold(
        "inside",
        &lattices,
        |_| Some(1e-13),
        |form, body| {
            let (scene, reach) = (&body.scene, 3.0 * body.scene.materials[0].horizon.floor());
            let mut simulation = body.simulation(form);
            simulation.set_threads(2).unwrap();
            let f = gradient(scene.dimension, &mut scene.random(10));
            simulation.set(Field::Displacement, &displacement(body, &f)).unwrap();
            let side = (scene.count() as f64).powf(1.0 / scene.dimension as f64).round() - 1.0;
            let deep = |x: &f64| *x >= reach && *x <= side - reach;
            let forces = simulation.get(Field::InternalForce).unwrap();
            let points = scene.coordinates.chunks_exact(scene.dimension);
            let inside: Vec<f64> = points
                .zip(forces.chunks_exact(scene.dimension))
                .filter(|(place, _)| place.iter().all(deep))
                .flat_map(|(_, force)| force.to_vec())
                .collect();
            assert!(inside.len() >= 27, "{}", inside.len());
            largest(&inside) / largest(&forces)
        },
    );
}
