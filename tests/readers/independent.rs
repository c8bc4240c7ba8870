//! Meshes that gmsh, meshio, vtk and numpy have written.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{in_crate, place, run, tool};
use perion::Points;
use serde_json::Value;

#[test]
fn the_meshes_that_are_kept_are_read_right() {
    assert!(hold(&in_crate("tests/data/meshes")) >= 15);
}

#[test]
fn the_meshes_that_gmsh_meshio_vtk_and_numpy_write_are_read_right() {
    let Some(python) = python() else { return };
    let place = place("readers/independent");
    run(Command::new(python)
        .arg(in_crate("tests/readers/write_meshes.py"))
        .args([place.as_os_str(), "0.3".as_ref()]));
    assert!(hold(&place) > 120);
}

/// The Python that has the independent readers and writers.
pub fn python() -> Option<PathBuf> {
    let python = tool("python")?;
    let mut packages = Command::new(&python);
    let there = packages.args(["-c", "import gmsh, meshio, vtk"]).output().unwrap();
    if there.status.success() {
        return Some(python);
    }
    eprintln!("skipped: gmsh, meshio and vtk for python are not installed");
    None
}

/// Reads each file that expected.json names, and compares; gives their number.
fn hold(place: &Path) -> usize {
    let expected = fs::read_to_string(place.join("expected.json")).unwrap();
    let expected: BTreeMap<String, Value> = serde_json::from_str(&expected).unwrap();
    for (name, expected) in &expected {
        compare(name, &place.join(name), expected);
    }
    expected.len()
}

fn compare(name: &str, path: &Path, expected: &Value) {
    let points = Points::read(path).unwrap_or_else(|error| panic!("{error}"));
    let dimension = expected["dimension"].as_u64().unwrap() as usize;
    assert_eq!(points.dimension(), dimension, "{name}");

    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|it| it.as_f64().unwrap()).collect()
    };
    // 1e-12 unless the file itself has fewer digits.
    let tolerance = expected["tolerance"].as_f64().unwrap();
    let close = |found: f64, wanted: f64, scale: f64| (found - wanted).abs() <= tolerance * scale;
    let volumes = numbers(&expected["volumes"]);
    assert_eq!(points.count(), volumes.len(), "{name}");
    for (point, (&found, &wanted)) in points.volumes().iter().zip(&volumes).enumerate() {
        assert!(close(found, wanted, wanted), "{name}: volume {found} of {point}, not {wanted}");
    }
    let places = points.coordinates().chunks(dimension);
    for (found, wanted) in places.zip(expected["centroids"].as_array().unwrap()) {
        for (&found, wanted) in found.iter().zip(numbers(wanted)) {
            assert!(close(found, wanted, 1.0), "{name}: {found}, not {wanted}");
        }
    }
    if let Some(total) = expected["total"].as_f64() {
        let sum: f64 = points.volumes().iter().sum();
        assert!(close(sum, total, total), "{name}: {sum} in all, not {total}");
    }
    let sets = expected["sets"].as_object().unwrap();
    for (set, members) in sets {
        let members: Vec<usize> =
            members.as_array().unwrap().iter().map(|it| it.as_u64().unwrap() as usize).collect();
        let found = points.set(set).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(found, members, "{name}: {set}");
    }
    // In .inp files gmsh names the parts of the geometry, too.
    if !name.ends_with(".inp") {
        let names: Vec<&str> = points.set_names().collect();
        assert_eq!(names.len(), sets.len(), "{name}: {names:?}");
    }
}
