//! Points from the XML files of VTK (`.vtu`): clouds of points, and cells.

mod arrays;
mod header;

use super::cells::Kind;
use super::mesh::{Members, Mesh};
use super::source::Source;
use super::{Cloud, is_coordinate, is_volume};
use crate::error::Result;
use crate::memory;
use crate::points::Points;
use arrays::Decoder;
use header::{Array, Piece, Place};

/// Array of the volumes of a cloud's points.
const VOLUME: &str = "volume";
/// Array of whole numbers that makes sets.
const BLOCK: &str = "block";

/// Array of flags of what is there a second time or hidden, and these flags.
const GHOST: &str = "vtkGhostType";
const GHOST_CELL: i64 = 1 | 32;
const GHOST_POINT: i64 = 1 | 2;

/// A type of cells of VTK's: its kind here, and its nodes in the order of that kind.
struct CellType {
    number: i64,
    kind: Kind,
    /// Empty where the order is the same.
    order: &'static [usize],
}

const fn cell_type(number: i64, kind: Kind) -> CellType {
    CellType { number, kind, order: &[] }
}

const CELL_TYPES: &[CellType] = &[
    cell_type(1, Kind::Vertex),
    cell_type(3, Kind::Line(2)),
    cell_type(5, Kind::Triangle3),
    CellType { number: 8, kind: Kind::Quadrilateral4, order: &[0, 1, 3, 2] },
    cell_type(9, Kind::Quadrilateral4),
    cell_type(10, Kind::Tetrahedron4),
    CellType { number: 11, kind: Kind::Hexahedron8, order: &[0, 1, 3, 2, 4, 5, 7, 6] },
    cell_type(12, Kind::Hexahedron8),
    cell_type(13, Kind::Wedge6),
    cell_type(14, Kind::Pyramid5),
    cell_type(21, Kind::Line(3)),
    cell_type(22, Kind::Triangle6),
    cell_type(23, Kind::Quadrilateral8),
    cell_type(24, Kind::Tetrahedron10),
    cell_type(25, Kind::Hexahedron20),
    cell_type(28, Kind::Quadrilateral9),
    cell_type(29, Kind::Hexahedron27),
];

pub(super) fn read(source: &Source) -> Result<Points> {
    let document = header::parse(source)?;
    let decoder = Decoder::new(source, &document);
    let (mut mesh, mut cloud) = (Mesh::default(), Cloud::default());
    let mut blocks = Vec::new();
    for piece in &document.pieces {
        let first = cloud.coordinates.len() as u64 / 3;
        places(source, &decoder, piece, &mut cloud)?;
        cells(source, &decoder, piece, first, &mut mesh, &mut blocks)?;
    }
    if mesh.cell_count() > 0 {
        for (number, place) in cloud.coordinates.as_chunks::<3>().0.iter().enumerate() {
            mesh.add_node(source, number as u64, 0, *place)?;
        }
        blocks.sort_unstable();
        for of_one in blocks.chunk_by(|one, other| one.0 == other.0) {
            let group = mesh.add_group(&format!("block_{}", of_one[0].0), Members::Cells)?;
            for &(_, cell) in of_one {
                mesh.put_into(group, cell as usize)?;
            }
        }
        return mesh.into_points(source);
    }
    for piece in &document.pieces {
        volumes(source, &decoder, piece, &mut cloud)?;
    }
    let flat = cloud.coordinates.as_chunks::<3>().0.iter().all(|place| place[2] == 0.0);
    cloud.into_points(source, if flat { 2 } else { 3 })
}

/// Adds the positions of a piece's points.
fn places(source: &Source, decoder: &Decoder, piece: &Piece, cloud: &mut Cloud) -> Result<()> {
    if piece.points == 0 {
        return Ok(());
    }
    let Some(array) = piece.arrays.iter().find(|array| array.place == Place::Points) else {
        return piece.flaw(source, "expected an array of Points, found none");
    };
    if array.components != 3 {
        let text = format!("expected 3 components of Points, found {}", array.components);
        return array.flaw(source, text);
    }
    let values = decoder.reals(array, piece.points.checked_mul(3))?;
    for value in values {
        if !is_coordinate(value) {
            return array.flaw(source, format_args!("expected finite coordinates, found {value}"));
        }
        memory::push(&mut cloud.coordinates, value, "coordinates")?;
    }
    Ok(())
}

/// Adds a piece's cells that have an extent, and the blocks they are in.
fn cells(
    source: &Source,
    decoder: &Decoder,
    piece: &Piece,
    first: u64,
    mesh: &mut Mesh,
    blocks: &mut Vec<(i64, u32)>,
) -> Result<()> {
    if piece.cells == 0 {
        return Ok(());
    }
    let array = |name: &str| {
        let found = piece.named(Place::Cells, name);
        found.map_or_else(
            || piece.flaw(source, format_args!("expected an array '{name}' of Cells, found none")),
            Ok,
        )
    };
    let (ends, types) = (array("offsets")?, array("types")?);
    let connectivity = array("connectivity")?;
    let corners = decoder.integers(connectivity, None)?;
    let block = piece.named(Place::CellData, BLOCK).filter(|array| array.is_whole());
    let block = block.map(|array| decoder.integers(array, Some(piece.cells))).transpose()?;
    let ghosts = flags(decoder, piece, Place::CellData, piece.cells)?;
    let mut start = 0;
    let spans = decoder.integers(ends, Some(piece.cells))?;
    let types = decoder.integers(types, Some(piece.cells))?;
    for (place, (&end, &number)) in spans.iter().zip(&types).enumerate() {
        let span = usize::try_from(end).ok().and_then(|end| corners.get(start..end));
        let Some(span) = span else {
            return ends.flaw(
                source,
                format_args!(
                    "expected offsets from {start} to {}, found {end} of cell {place}",
                    corners.len()
                ),
            );
        };
        start += span.len();
        // Points and rows of points, which have no extent, are there in clouds, too.
        if matches!(number, 1..=4 | 21) || is_set(&ghosts, place, GHOST_CELL) {
            continue;
        }
        let number = match (number, span.len()) {
            (7, 3) => 5,
            (7, 4) => 9,
            _ => number,
        };
        let Some(known) = CELL_TYPES.iter().find(|known| known.number == number) else {
            return piece.unsupported(
                source,
                format_args!(
                    "cells of type {number} are not read; known are triangles, quadrilaterals, \
                     tetrahedra and hexahedra of first and second order, wedges and pyramids of \
                     first order"
                ),
            );
        };
        if span.len() != known.kind.nodes() {
            return ends.flaw(
                source,
                format_args!(
                    "expected {} points of cell {place} of type {number}, found {}",
                    known.kind.nodes(),
                    span.len()
                ),
            );
        }
        if let Some(block) = &block {
            memory::push(blocks, (block[place], mesh.cell_count() as u32), "blocks")?;
        }
        mesh.begin_cell(mesh.cell_count() as u64, 0, known.kind)?;
        for turn in 0..span.len() {
            let corner = span[known.order.get(turn).copied().unwrap_or(turn)];
            let within = u64::try_from(corner).ok().filter(|&corner| corner < piece.points);
            let Some(corner) = within else {
                return connectivity.flaw(
                    source,
                    format_args!(
                        "expected points from 0 to {}, found {corner} in cell {place}",
                        piece.points.saturating_sub(1)
                    ),
                );
            };
            mesh.add_corner(first + corner)?;
        }
    }
    Ok(())
}

/// Adds the volumes and blocks of a cloud's points.
fn volumes(source: &Source, decoder: &Decoder, piece: &Piece, cloud: &mut Cloud) -> Result<()> {
    if piece.points == 0 {
        return Ok(());
    }
    let Some(array) = piece.named(Place::PointData, VOLUME) else {
        return piece.flaw(
            source,
            "expected cells, or points with an array 'volume' of PointData, found neither",
        );
    };
    let scalar = |array: &Array| match array.components {
        1 => Ok(()),
        found => array.flaw(source, format_args!("expected 1 component, found {found}")),
    };
    scalar(array)?;
    let ghosts = flags(decoder, piece, Place::PointData, piece.points)?;
    let block = piece.named(Place::PointData, BLOCK).filter(|array| array.is_whole());
    let blocks = block.map(|array| {
        scalar(array)?;
        decoder.integers(array, Some(piece.points))
    });
    let blocks = blocks.transpose()?;
    for (place, volume) in decoder.reals(array, Some(piece.points))?.into_iter().enumerate() {
        if is_set(&ghosts, place, GHOST_POINT) {
            let ghost = 3 * cloud.volumes.len();
            cloud.coordinates.drain(ghost..ghost + 3);
            continue;
        }
        let point = cloud.volumes.len();
        if !is_volume(volume) {
            return array.flaw(
                source,
                format_args!("expected positive volumes, found {volume} of point {point}"),
            );
        }
        memory::push(&mut cloud.volumes, volume, "volumes")?;
        if let Some(blocks) = &blocks {
            cloud.put_into_block(blocks[place], point)?;
        }
    }
    Ok(())
}

/// Flags of a piece's points or cells, if it has some.
fn flags(decoder: &Decoder, piece: &Piece, of: Place, count: u64) -> Result<Option<Vec<i64>>> {
    let array = piece.named(of, GHOST).filter(|array| array.is_whole());
    array.map(|array| decoder.integers(array, Some(count))).transpose()
}

fn is_set(flags: &Option<Vec<i64>>, place: usize, bits: i64) -> bool {
    flags.as_ref().is_some_and(|flags| flags[place] & bits != 0)
}
