//! Points from files: text, and the meshes of Abaqus (.inp), Gmsh (.msh) and VTK (.vtu).
//!
//! Each reader turns bytes into points, or into nodes, cells and groups, of which [`mesh`] makes
//! points: one in the centroid of each cell, with its volume. A reader takes nothing on trust: what it
//! reads is checked where it stands, and no memory is asked for that the file is too short to fill.

mod abaqus;
mod cells;
mod gmsh;
mod mesh;
mod source;
mod text;
mod vtu;

use std::collections::BTreeMap;
use std::path::Path;

use super::order::Coincident;
use super::sets::SetNames;
use super::{LARGEST_COORDINATE, Points};
use crate::error::Result;
use crate::memory;
use source::Source;

/// Endings of files that are no text of points.
const NOT_READ: [&str; 24] = [
    "bdf", "cdb", "dxf", "e", "exo", "fem", "h5", "iges", "igs", "k", "mesh", "nas", "obj", "ply",
    "pvd", "pvtu", "step", "stl", "stp", "unv", "vtk", "vtp", "xdmf", "zip",
];

impl Points {
    /// Reads points from a file, whose name tells what it is: `.inp` (Abaqus), `.msh` (Gmsh 4.1 or
    /// 2.2), `.vtu` (VTK), anything else text.
    ///
    /// Text has a point a line: `x y z volume`, `x y z block volume`, or `x y area` in two dimensions,
    /// with blanks or commas between the numbers; `#`, `!` and `%` begin comments. A first line may name the
    /// columns, in any order and with others beside them. Blocks become sets `block_1` and so on.
    ///
    /// Of a mesh, each cell of the highest dimension becomes a point in its centroid with its volume (plane
    /// cells: its area), in the file's order. Groups of such cells become sets. A group of nodes, or of
    /// cells of lower dimension such as the faces of a boundary, becomes the set of the points whose
    /// cells have one of its nodes. A name that other points have already gets `_2`; a group without
    /// points is left out.
    ///
    /// A `.vtu` file without cells, or with vertices only, is a cloud of points with a point array `volume`,
    /// in two dimensions if z is 0 everywhere. An integer array `block` gives sets.
    ///
    /// # Errors
    /// `Io` when the file cannot be read, `Format` when it is not what it should be, with its line, what was
    /// expected and what was found; `Unsupported` for what the formats can say and points cannot;
    /// `Memory`.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let source = Source::load(path)?;
        let ending = path.extension().and_then(|it| it.to_str()).unwrap_or("");
        match ending.to_ascii_lowercase().as_str() {
            "inp" => abaqus::read(&source)?.into_points(&source),
            "msh" => gmsh::read(&source)?.into_points(&source),
            "vtu" => vtu::read(&source),
            other if NOT_READ.contains(&other) => source.unsupported(
                0,
                format_args!(
                    "files that end in .{other} are not read; known are .inp, .msh, .vtu, and others as text"
                ),
            ),
            _ => text::read(&source),
        }
    }
}

/// Points in the order of a file.
#[derive(Default)]
struct Cloud {
    /// Three numbers a point.
    coordinates: Vec<f64>,
    volumes: Vec<f64>,
    /// Lines of the points; empty where the file has none.
    lines: Vec<u32>,
    blocks: BTreeMap<i64, Vec<u32>>,
}

impl Cloud {
    /// Puts a point into the set of a block.
    fn put_into_block(&mut self, block: i64, point: usize) -> Result<()> {
        memory::push(self.blocks.entry(block).or_default(), point as u32, "a set")
    }

    /// The points, in two dimensions without their third coordinate.
    fn into_points(mut self, source: &Source, dimension: usize) -> Result<Points> {
        let count = self.volumes.len();
        if count == 0 {
            return source.flaw_of_all("expected points, found none");
        }
        if count >= u32::MAX as usize {
            return source.flaw_of_all(format_args!("{count} points are more than fit"));
        }
        if dimension == 2 {
            for point in 0..count {
                self.coordinates.copy_within(3 * point..3 * point + 2, 2 * point);
            }
            self.coordinates.truncate(2 * count);
        }
        let made = Points::try_assemble(dimension, self.coordinates, self.volumes)?;
        let mut points = match made {
            Ok(points) => points,
            Err(Coincident(first, second)) => {
                let line = |point: usize| self.lines.get(point).filter(|&&line| line > 0);
                return match (line(first), line(second)) {
                    (Some(first), Some(second)) => source.flaw(
                        (*second).max(*first) as usize,
                        format_args!(
                            "expected a place of its own for each point, found the one of line {}",
                            first.min(second)
                        ),
                    ),
                    _ => source.flaw_of_all(format_args!(
                        "points {first} and {second} stand in one place"
                    )),
                };
            }
        };
        let mut names = SetNames::default();
        for (block, members) in self.blocks {
            points.add_new_set(&format!("block_{block}"), members, &mut names);
        }
        Ok(points)
    }
}

/// Whether a number can be a coordinate.
fn is_coordinate(value: f64) -> bool {
    value.is_finite() && value.abs() <= LARGEST_COORDINATE
}

/// Whether a number can be a volume.
fn is_volume(value: f64) -> bool {
    value.is_finite() && value > 0.0
}
