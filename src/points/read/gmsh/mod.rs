//! Meshes of Gmsh, MSH 4.1 and 2.2, as text or binary; physical groups become sets.

mod numbers;
mod version2;
mod version4;

use std::collections::BTreeMap;

use super::cells::{Kind, MOST_NODES};
use super::mesh::{GroupPlace, Members, Mesh};
use super::source::{Source, shown, words};
use crate::error::Result;
use numbers::Reader;

/// Kinds of cells by Gmsh's numbers.
const KINDS: &[(i64, Kind)] = &[
    (1, Kind::Line(2)),
    (2, Kind::Triangle3),
    (3, Kind::Quadrilateral4),
    (4, Kind::Tetrahedron4),
    (5, Kind::Hexahedron8),
    (6, Kind::Wedge6),
    (7, Kind::Pyramid5),
    (8, Kind::Line(3)),
    (9, Kind::Triangle6),
    (10, Kind::Quadrilateral9),
    (11, Kind::Tetrahedron10),
    (12, Kind::Hexahedron27),
    (15, Kind::Vertex),
    (16, Kind::Quadrilateral8),
    (17, Kind::Hexahedron20),
    (26, Kind::Line(4)),
    (27, Kind::Line(5)),
    (28, Kind::Line(6)),
];

/// Names of groups that have none, by their dimension.
const UNNAMED: [&str; 4] = ["point", "curve", "surface", "volume"];

pub(super) fn read(source: &Source) -> Result<Mesh> {
    let mut reader = Reader::new(source);
    let mut meshed = Meshed::default();
    let version = header(&mut reader)?;
    while let Some(section) = reader.section()? {
        match section {
            b"PhysicalNames" => names(&mut reader, &mut meshed)?,
            b"ParametricNodes" => {
                return reader.unsupported(
                    "nodes with parameters are not read from version 2.2; save it as 4.1",
                );
            }
            b"PartitionedEntities" => {
                return reader.unsupported("partitioned meshes are not read; save it as a whole");
            }
            b"Entities" if version == Version::Four => {
                version4::entities(&mut reader, &mut meshed)?
            }
            b"Nodes" if version == Version::Four => version4::nodes(&mut reader, &mut meshed)?,
            b"Elements" if version == Version::Four => {
                version4::elements(&mut reader, &mut meshed)?
            }
            b"Nodes" => version2::nodes(&mut reader, &mut meshed)?,
            b"Elements" => version2::elements(&mut reader, &mut meshed)?,
            other => {
                reader.skip_section(other)?;
                continue;
            }
        }
        reader.end_section(section)?;
    }
    if version == Version::Two {
        meshed.mesh.merge_twins();
    }
    // Names may stand behind the elements.
    for (&key, &group) in &meshed.groups {
        let unnamed = || format!("physical_{}_{}", UNNAMED[key.0.min(3)], key.1);
        let name = meshed.names.get(&key).cloned().unwrap_or_else(unnamed);
        meshed.mesh.name_group(group, name);
    }
    Ok(meshed.mesh)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// What has been read.
#[derive(Default)]
struct Meshed {
    mesh: Mesh,
    /// Names of physical groups, by dimension and number.
    names: BTreeMap<(usize, i64), String>,
    groups: BTreeMap<(usize, i64), GroupPlace>,
    /// Physical groups of the entities of the geometry, by dimension and number.
    entities: BTreeMap<(usize, i64), Vec<i64>>,
}

impl Meshed {
    /// Puts the cell begun last into a physical group.
    fn put_last_cell_into(&mut self, dimension: usize, physical: i64) -> Result<()> {
        // Where the sign is negative the cell is turned round, which is nothing to points.
        let key = (dimension, physical.saturating_abs());
        let group = match self.groups.get(&key) {
            Some(&group) => group,
            None => {
                let group = self.mesh.add_group("", Members::Cells)?;
                self.groups.insert(key, group);
                group
            }
        };
        self.mesh.put_into(group, self.mesh.cell_count() - 1)
    }
}

/// The first section; says what follows.
fn header(reader: &mut Reader) -> Result<Version> {
    if reader.section()? != Some(b"MeshFormat") {
        return reader.flaw("expected $MeshFormat at the beginning, found none");
    }
    let line = reader.rest_of_line();
    let mut fields = words(line);
    let version = fields.next().unwrap_or(b"");
    let (binary, bytes) = (fields.next().unwrap_or(b""), fields.next().unwrap_or(b""));
    let version = match version {
        b"2.2" | b"2" | b"2.1" => Version::Two,
        b"4.1" => Version::Four,
        _ => {
            let text =
                format!("expected version 4.1 or 2.2, found {}; save it as 4.1", shown(line));
            return reader.unsupported(text);
        }
    };
    match (binary, bytes) {
        (b"0", _) => {}
        (b"1", b"8") => {
            reader.read_binary();
            let one = reader.int("the number 1")?;
            if one != 1 {
                return reader.unsupported(format_args!(
                    "expected the number 1, found {one}: the file comes from a machine of another \
                     byte order; save it as text"
                ));
            }
        }
        _ => return reader.flaw(format_args!("expected 0 8 or 1 8, found {}", shown(line))),
    }
    reader.end_section(b"MeshFormat")?;
    Ok(version)
}

/// `dimension number "name"`, a line each, in binary files too.
fn names(reader: &mut Reader, meshed: &mut Meshed) -> Result<()> {
    let line = reader.rest_of_line();
    let Some(count) = words(line).next().and_then(super::source::integer) else {
        return reader.flaw(format_args!("expected the number of names, found {}", shown(line)));
    };
    for _ in 0..count {
        let line = reader.rest_of_line();
        let mut fields = words(line);
        let mut number = || fields.next().and_then(super::source::integer);
        let (dimension, tag) = (number(), number());
        let first = line.iter().position(|&byte| byte == b'"');
        let last = line.iter().rposition(|&byte| byte == b'"');
        match (dimension, tag, first, last) {
            (Some(dimension @ 0..=3), Some(tag), Some(first), Some(last)) if first < last => {
                let name = String::from_utf8_lossy(&line[first + 1..last]).into_owned();
                meshed.names.insert((dimension as usize, tag), name);
            }
            _ => {
                return reader.flaw(format_args!(
                    "expected a dimension, a number and a name in quotes, found {}",
                    shown(line)
                ));
            }
        }
    }
    Ok(())
}

/// The kind of cell behind a number of Gmsh's.
fn kind(reader: &Reader, number: i64) -> Result<Kind> {
    match KINDS.iter().find(|(known, _)| *known == number) {
        Some((_, kind)) => Ok(*kind),
        None => reader.unsupported(format_args!(
            "elements of type {number} are not read; known are triangles, quadrilaterals and \
             tetrahedra and hexahedra of first and second order, prisms and pyramids of first order"
        )),
    }
}

/// Adds a cell whose nodes come next.
fn cell(reader: &mut Reader, mesh: &mut Mesh, number: u64, kind: Kind, wide: bool) -> Result<()> {
    mesh.begin_cell(number, reader.line(), kind)?;
    for _ in 0..kind.nodes() {
        let node = if wide { reader.size("a node")? } else { reader.tag("a node")? };
        mesh.add_corner(node)?;
    }
    // Gmsh has its own order of the middles of edges and faces.
    let order: &[usize] = match kind {
        Kind::Tetrahedron10 => &[9, 8],
        Kind::Hexahedron20 => &[8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
        Kind::Hexahedron27 => {
            &[8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26]
        }
        _ => &[],
    };
    let corners = mesh.last_corners();
    let before: [u64; MOST_NODES] =
        std::array::from_fn(|place| corners.get(place).copied().unwrap_or(0));
    let from = corners.len() - order.len();
    for (corner, &place) in corners[from..].iter_mut().zip(order) {
        *corner = before[place];
    }
    Ok(())
}

/// Three coordinates.
fn place(reader: &mut Reader) -> Result<[f64; 3]> {
    let mut place = [0.0; 3];
    for value in &mut place {
        *value = reader.real("a coordinate")?;
    }
    Ok(place)
}
