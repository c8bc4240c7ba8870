//! The seam of a body that is part lattice and part cloud: what a first sweep leaves at points of one side goes to the other side
//! before the second reads it.

use super::kept_rows::Sweep;
use super::on_lattice::Columns;
use super::{Scene, in_lanes};
use crate::error::Result;
use crate::families::lattice::{Lattice, NOBODY};
use crate::kernel::family::Record;
use crate::memory;
use crate::workers::{BLOCK, PerBlock, PerPoint, block_count};

const PURPOSE: &str = "lattices";

/// A point, and its cell of the lattice.
#[derive(Debug, Clone, Copy)]
struct Place {
    point: u32,
    cell: u32,
}

/// Points near the other side.
#[derive(Debug)]
pub(super) struct Seam {
    /// Those without a seat on crossings.
    beyond: Vec<Place>,
    /// Members that points without a seat may have bonds with, in ascending order.
    edge: Vec<Place>,
    /// Of each block of points, whether any has no seat or is of the edge.
    blocks: Vec<bool>,
}

impl Seam {
    /// `None` where all points are members.
    pub(super) fn new(scene: &Scene<'_>, lattice: &Lattice) -> Result<Option<Self>> {
        let (workers, count) = (scene.workers, scene.places.len());
        if lattice.count == count {
            return Ok(None);
        }
        let is_apart = |point: u32| point != NOBODY && lattice.seat_of[point as usize] == NOBODY;
        let on_edge = |cell: usize| {
            let mut steps = lattice.stencil.iter();
            steps.any(|step| is_apart(lattice.point_of[cell.wrapping_add_signed(step.cells)]))
        };
        // The cell of those that are of the edge.
        let mut cells = workers.filled(NOBODY, count, PURPOSE)?;
        let mut blocks = memory::filled(false, block_count(count), PURPOSE)?;
        let outputs = (PerPoint(&mut cells[..], 1), PerBlock(&mut blocks[..]));
        workers.sweep(count, outputs, |range, (cells, block)| {
            for (value, point) in cells.0.iter_mut().zip(range) {
                let seat = lattice.seat_of[point];
                if seat == NOBODY {
                    block.0[0] = true;
                    continue;
                }
                let cell = lattice.cell(seat as usize);
                if on_edge(cell) {
                    (*value, block.0[0]) = (cell as u32, true);
                }
            }
        });
        let place = |(number, other): (usize, u32)| (number as u32, other);
        let edge = cells.iter().copied().enumerate().map(place).filter(|(_, cell)| *cell != NOBODY);
        let edge = edge.map(|(point, cell)| Place { point, cell });
        let beyond = lattice.point_of.iter().copied().enumerate().map(place);
        let beyond = beyond.filter(|(_, point)| is_apart(*point));
        let beyond = beyond.map(|(cell, point)| Place { point, cell });
        Ok(Some(Self { beyond: listed(beyond)?, edge: listed(edge)?, blocks }))
    }

    pub(super) fn bytes(&self) -> usize {
        memory::bytes(&self.beyond) + memory::bytes(&self.edge) + memory::bytes(&self.blocks)
    }

    /// Records of points without a seat and of those that they have bonds with, from the front of the scratch, and the rest
    /// of it.
    pub(super) fn record<'a, const D: usize>(
        &self,
        scene: &Scene<'_>,
        scratch: &'a mut [f64],
    ) -> (&'a [Record], &'a mut [f64]) {
        in_lanes::record_some::<D>(scene, scratch, |first| self.is_near(first))
    }

    /// Whether the block that begins with a point has any that has no seat, or has bonds with such.
    pub(super) fn is_near(&self, first: usize) -> bool {
        self.blocks[first / BLOCK]
    }

    /// Gives what a first sweep has left in rows of points without a seat to their cells, and what it has left in cells of members to
    /// their rows.
    pub(super) fn exchange<const N: usize, const C: usize>(
        &self,
        scene: &Scene<'_>,
        cells: &mut Columns<'_, N>,
        rows: &mut [[f64; C]],
        to_cell: impl Fn(&[f64; C]) -> [f64; N],
        to_row: impl Fn(usize, [f64; N]) -> [f64; C] + Sync,
    ) {
        for place in &self.beyond {
            let numbers = to_cell(&rows[place.point as usize]);
            for (column, number) in cells.values.iter_mut().zip(numbers) {
                column[place.cell as usize] = number;
            }
        }
        let columns = cells.values.each_ref().map(|column| &**column);
        scene.workers.sweep(rows.len(), PerPoint(rows, 1), |range, rows| {
            let before = |end: usize| self.edge.partition_point(|own| (own.point as usize) < end);
            for place in &self.edge[before(range.start)..before(range.end)] {
                let (point, cell) = (place.point as usize, place.cell as usize);
                rows.0[point - range.start] = to_row(point, columns.map(|column| column[cell]));
            }
        });
    }

    /// The same of tensors that gradients pull with, behind places in rows: those of cells are times the volume of a point and the
    /// square of the unit.
    pub(super) fn exchange_tensors<const D: usize, const N: usize, const C: usize>(
        &self,
        sweep: Sweep<'_>,
        unit: f64,
        cells: &mut Columns<'_, N>,
        rows: &mut [[f64; C]],
    ) {
        let square = unit * unit;
        let place = |number: usize| 4 + 4 * (number % D) + number / D;
        let to_cell = |row: &[f64; C]| std::array::from_fn(|k| square * row[place(k)]);
        let to_row = |point: usize, tensor: [f64; N]| {
            let mut row = [0.0; C];
            row[..3].copy_from_slice(&sweep.records[point][..3]);
            for (number, value) in tensor.iter().enumerate() {
                row[place(number)] = value / square;
            }
            row
        };
        self.exchange(sweep.scene, cells, rows, to_cell, to_row);
    }
}

fn listed(places: impl Iterator<Item = Place> + Clone) -> Result<Vec<Place>> {
    let mut list = memory::reserved(places.clone().count(), PURPOSE)?;
    list.extend(places);
    Ok(list)
}
