//! What Perion writes, as vtk and meshio read it: every field of every point, bit by bit.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::{in_crate, place, run};
use crate::independent::python;
use perion::{Field, Model, Points, Quantity, Simulation};

/// A bar on its way to being torn, in two or three dimensions.
fn torn(dimension: usize) -> Simulation {
    let (lower, upper) = ([0.0; 3], [1.0, 0.3, 0.3]);
    let points = Points::block(dimension, &lower[..dimension], &upper[..dimension], 0.1).unwrap();
    let mut model = Model::new("bond_based").unwrap();
    for (key, value) in [
        ("density", 1.0),
        ("youngs_modulus", 1.0),
        ("horizon", 0.3015),
        ("critical_stretch", 0.05),
        ("thickness", 0.7),
    ] {
        if key != "thickness" || dimension == 2 {
            model.set(key, value).unwrap();
        }
    }
    let mut simulation = Simulation::new(&points, &model).unwrap();
    let velocity: Vec<f64> = points
        .coordinates()
        .chunks(dimension)
        .flat_map(|place| {
            let pull = [0.4 * (place[0] - 0.5), 0.01 * place[1], 0.0];
            pull.into_iter().take(dimension)
        })
        .collect();
    simulation.set(Field::Velocity, &velocity).unwrap();
    simulation.prescribe("all", Quantity::BodyForce, 1, 0.1).unwrap();
    simulation
}

#[test]
fn vtk_and_meshio_read_what_was_written_bit_by_bit() {
    let Some(python) = python() else { return };
    for dimension in [2, 3] {
        let place = place(&format!("readers/written_{dimension}"));
        let mut simulation = torn(dimension);
        let time_step = simulation.stable_time_step().unwrap();
        let mut states = Vec::new();
        let fields = fields(dimension);
        for _ in 0..3 {
            simulation.step(time_step, 4).unwrap();
            simulation.write_series(place.join("bar.pvd"), &fields).unwrap();
            states.push((simulation.time(), state(&simulation)));
        }
        simulation.write_vtk(place.join("last.vtu"), &fields).unwrap();
        assert!(simulation.health().unwrap().broken_bonds > 0);
        run(Command::new(&python).arg(in_crate("tests/readers/read_back.py")).arg(&place));
        for (reader, (number, (time, state))) in ["vtk", "meshio"]
            .into_iter()
            .flat_map(|it| std::iter::repeat(it).zip(states.iter().enumerate()))
        {
            let read = place.join(format!("{reader}_{number}"));
            assert_eq!(numbers(&read, "time"), [time.to_bits()], "{reader}");
            for (name, values) in state {
                let found = numbers(&read, name);
                assert!(found == *values, "{reader}, file {number}, {name}");
            }
        }
        // The single file is the last of the series.
        let (_, last) = states.last().unwrap();
        for (name, values) in last {
            assert!(numbers(&place.join("vtk_last"), name) == *values, "last.vtu, {name}");
        }
    }
}

fn fields(dimension: usize) -> Vec<Field> {
    Field::ALL.into_iter().filter(|field| field.is_defined(dimension)).collect()
}

/// All that a file holds as bits: positions and fields, vectors of three components and tensors of nine.
fn state(simulation: &Simulation) -> Vec<(&'static str, Vec<u64>)> {
    let dimension = simulation.points().dimension();
    let mut state: Vec<(&str, Vec<u64>)> = Vec::new();
    for field in fields(dimension) {
        let values = simulation.get(field).unwrap();
        let width = field.components(dimension);
        let padded = values.chunks(width).flat_map(|of_point| {
            let rows = if width > dimension { 3 } else { 1 };
            let columns = if width > 1 { 3 } else { 1 };
            let held = if width > 1 { dimension } else { 1 };
            (0..rows * columns).map(move |place| {
                let (row, column) = (place / columns, place % columns);
                if row < held && column < held { of_point[row * held + column] } else { 0.0 }
            })
        });
        state.push((field.name(), padded.map(f64::to_bits).collect::<Vec<u64>>()));
    }
    let positions = state.iter().find(|(name, _)| *name == "position").unwrap().1.clone();
    state.push(("points", positions));
    state
}

fn numbers(place: &Path, name: &str) -> Vec<u64> {
    let path = place.join(name);
    let bytes = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    bytes.as_chunks().0.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect()
}
