//! What preconditioners save.

use perion::{Field, Model, Points, Preconditioning, Quantity, Simulation, SolveOptions};

/// Coordinates, volumes and horizons.
type Cloud = (Vec<f64>, Vec<f64>, Vec<f64>);

/// Points of a bar in layers, whose spacing grows from 1 to 10, and horizons with it: volumes are as 1 to 1000.
fn graded() -> Cloud {
    let layers = 60;
    let growth = 10_f64.powf(1.0 / (layers - 1) as f64);
    let (mut coordinates, mut volumes, mut horizons) = (Vec::new(), Vec::new(), Vec::new());
    let (mut left, mut size) = (0.0, 1.0);
    for _ in 0..layers {
        for point in 0..ACROSS * ACROSS {
            let [y, z] = [point / ACROSS, point % ACROSS].map(|row| row as f64 - 2.5);
            coordinates.extend([left + 0.5 * size, y * size, z * size]);
            volumes.push(size * size * size);
            horizons.push(2.51 * size);
        }
        left += size;
        size *= growth;
    }
    (coordinates, volumes, horizons)
}

/// Points of a lattice whose volumes are without order between 1 and 1000.
fn without_order() -> Cloud {
    let (mut coordinates, mut volumes) = (Vec::new(), Vec::new());
    for layer in 0..40 {
        for point in 0..ACROSS * ACROSS {
            coordinates.extend([layer, point / ACROSS, point % ACROSS].map(|at| at as f64));
            let random = (volumes.len() as f64 * 0.618_033_988_75).fract();
            volumes.push(1000_f64.powf(random));
        }
    }
    let horizons = vec![2.51; volumes.len()];
    (coordinates, volumes, horizons)
}

const ACROSS: usize = 6;

/// Held at its end, pulled at its beginning.
fn pulled((coordinates, volumes, horizons): Cloud) -> Simulation {
    let mut points = Points::new(3, &coordinates, &volumes).unwrap();
    points.set_horizons(&horizons).unwrap();
    let (layer, count) = (ACROSS * ACROSS, points.count());
    points.add_set("clamp", &(count - 3 * layer..count).collect::<Vec<_>>()).unwrap();
    points.add_set("end", &(0..layer).collect::<Vec<_>>()).unwrap();
    let mut model = Model::new("ordinary_state_based").unwrap();
    for (key, value) in [("density", 1.0), ("youngs_modulus", 1.0), ("poissons_ratio", 0.25)] {
        model.set(key, value).unwrap();
    }
    let mut body = Simulation::new(&points, &model).unwrap();
    for axis in 0..3 {
        body.prescribe("clamp", Quantity::Displacement, axis, 0.0).unwrap();
    }
    body.prescribe("end", Quantity::BodyForce, 0, -1e-4).unwrap();
    body
}

/// Forces that it takes without preconditioner, with blocks, with a cycle.
fn forces(scene: fn() -> Cloud) -> [f64; 3] {
    [Preconditioning::None, Preconditioning::BlockDiagonal, Preconditioning::Global].map(|by| {
        let mut body = pulled(scene());
        let options = SolveOptions { preconditioning: by, ..SolveOptions::default() };
        let report = body.solve(&options).unwrap();
        let end = body.sum(Field::Displacement, Some("end")).unwrap()[0];
        println!("{by:?}: {} forces, end {end}", report.evaluations);
        report.evaluations as f64
    })
}

#[test]
fn preconditioning_saves_forces_where_volumes_are_as_one_to_a_thousand() {
    let [plain, blocks, global] = forces(without_order);
    assert!(plain > 3.0 * blocks, "{plain} without, {blocks} with blocks");
    assert!(plain > 3.0 * global, "{plain} without, {global} with a cycle");
    // Where sizes change slowly, the stiffness of points does so too: blocks win little.
    let [plain, _, global] = forces(graded);
    assert!(plain > 3.0 * global, "{plain} without, {global} with a cycle");
}
