//! A coarse level: a sparse matrix of blocks over groups of points, and the levels below it.

use super::aggregates::{Aggregates, modes};
use super::factor::Factor;
use crate::error::Result;
use crate::memory;
use crate::solver::balance::PURPOSE;
use crate::tensor::Vector;
use crate::workers::Workers;

pub(super) type Block<const B: usize> = [[f64; B]; B];

/// Groups up to which a level is solved as a whole.
const WHOLE: usize = 120;

/// Cycles that a level gets: groups that move rigidly take too little of a long wave in one.
const CYCLES: usize = 2;

/// Rows that a thread takes at a time.
const ROWS: usize = 32;

/// Sweeps before and after the coarser level.
const SWEEPS: usize = 1;

/// A symmetric matrix of blocks, row after row.
pub(super) struct Matrix<const B: usize> {
    pub(super) starts: Vec<usize>,
    pub(super) columns: Vec<u32>,
    pub(super) blocks: Vec<Block<B>>,
}

impl<const B: usize> Matrix<B> {
    pub(super) fn new(rows: usize) -> Result<Self> {
        let mut starts = memory::reserved(rows + 1, PURPOSE)?;
        starts.push(0);
        Ok(Self { starts, columns: Vec::new(), blocks: Vec::new() })
    }

    fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    fn row(&self, row: usize) -> impl Iterator<Item = (usize, &Block<B>)> {
        let own = self.starts[row]..self.starts[row + 1];
        self.columns[own.clone()].iter().map(|&c| c as usize).zip(&self.blocks[own])
    }

    /// left = r - A x
    fn residual(&self, workers: &Workers, r: &[[f64; B]], x: &[[f64; B]], left: &mut [[f64; B]]) {
        workers.share(left, ROWS, |first, left| {
            for (row, left) in (first..).zip(left) {
                let mut sum = r[row];
                for (column, block) in self.row(row) {
                    let x = &x[column];
                    for (value, entries) in sum.iter_mut().zip(block) {
                        *value -= entries.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
                    }
                }
                *left = sum;
            }
        });
    }
}

/// Collects the blocks of one row after the other.
pub(super) struct RowMaker {
    /// Where in its row a column stands, while that row is made.
    place: Vec<u32>,
}

impl RowMaker {
    pub(super) fn new(columns: usize) -> Result<Self> {
        Ok(Self { place: memory::filled(u32::MAX, columns, PURPOSE)? })
    }

    /// The block of a column in the row that is being made.
    pub(super) fn block<'a, const B: usize>(
        &mut self,
        matrix: &'a mut Matrix<B>,
        column: usize,
    ) -> Result<&'a mut Block<B>> {
        let start = matrix.starts[matrix.rows()];
        if self.place[column] == u32::MAX {
            self.place[column] = (matrix.columns.len() - start) as u32;
            memory::push(&mut matrix.columns, column as u32, PURPOSE)?;
            memory::push(&mut matrix.blocks, [[0.0; B]; B], PURPOSE)?;
        }
        Ok(&mut matrix.blocks[start + self.place[column] as usize])
    }

    pub(super) fn end_row<const B: usize>(&mut self, matrix: &mut Matrix<B>) {
        let start = matrix.starts[matrix.rows()];
        for &column in &matrix.columns[start..] {
            self.place[column as usize] = u32::MAX;
        }
        matrix.starts.push(matrix.columns.len());
    }
}

pub(super) enum Level<const D: usize, const B: usize> {
    Whole(Factor),
    Grouped(Box<Grouped<D, B>>),
}

pub(super) struct Grouped<const D: usize, const B: usize> {
    matrix: Matrix<B>,
    inverses: Vec<Block<B>>,
    damping: f64,
    groups: Aggregates<D>,
    places: Vec<Vector<D>>,
    scale: f64,
    /// `None` where groups would be no fewer.
    below: Option<Level<D, B>>,
    left: Vec<[f64; B]>,
    coarse: [Vec<[f64; B]>; 2],
}

impl<const D: usize, const B: usize> Level<D, B> {
    /// Groups reach as far as `reach`, of the length of what was grouped to make this level; turns are scaled by
    /// `scale`.
    pub(super) fn new(
        workers: &Workers,
        matrix: Matrix<B>,
        places: Vec<Vector<D>>,
        reach: f64,
        scale: f64,
    ) -> Result<Self> {
        let near = |root: usize, take: &mut dyn FnMut(usize)| {
            for (other, _) in matrix.row(root) {
                let apart = super::bond_stiffness::apart(&places[root], &places[other]);
                if crate::tensor::dot(&apart, &apart) <= reach * reach {
                    take(other);
                }
            }
        };
        let groups = Aggregates::new(&places, near)?;
        if places.len() <= WHOLE {
            return Ok(Self::Whole(whole(&matrix)?));
        }
        let below = if 2 * groups.count() <= places.len() {
            let coarser = coarsened(&matrix, &groups, &places, scale)?;
            let centres = memory::copied(&groups.centres, PURPOSE)?;
            Some(Self::new(workers, coarser, centres, 3.0 * reach, scale)?)
        } else {
            None
        };
        let inverses = inverses(&matrix)?;
        let zeros = |count| memory::filled([0.0; B], count, PURPOSE);
        let (left, coarse) =
            (zeros(places.len())?, [zeros(groups.count())?, zeros(groups.count())?]);
        let mut level =
            Grouped { matrix, inverses, damping: 1.0, groups, places, scale, below, left, coarse };
        level.damping = level.find_damping(workers)?;
        Ok(Self::Grouped(Box::new(level)))
    }

    /// x close to A^-1 r, by symmetric cycles.
    pub(super) fn cycle(&mut self, workers: &Workers, r: &[[f64; B]], x: &mut [[f64; B]]) {
        match self {
            Self::Whole(factor) => {
                x.copy_from_slice(r);
                factor.solve(x.as_flattened_mut());
            }
            Self::Grouped(level) => {
                x.iter_mut().for_each(|x| *x = [0.0; B]);
                for _ in 0..CYCLES {
                    level.cycle(workers, r, x);
                }
            }
        }
    }
}

impl<const D: usize, const B: usize> Grouped<D, B> {
    fn cycle(&mut self, workers: &Workers, r: &[[f64; B]], x: &mut [[f64; B]]) {
        for _ in 0..SWEEPS {
            self.smooth(workers, r, x);
        }
        self.correct(workers, r, x);
        for _ in 0..SWEEPS {
            self.smooth(workers, r, x);
        }
    }

    /// Adds what the coarser level makes of the residual.
    fn correct(&mut self, workers: &Workers, r: &[[f64; B]], x: &mut [[f64; B]]) {
        self.matrix.residual(workers, r, x, &mut self.left);
        let Some(below) = &mut self.below else { return };
        let [right, solution] = &mut self.coarse;
        right.iter_mut().for_each(|value| *value = [0.0; B]);
        for (member, &group) in self.groups.of.iter().enumerate() {
            let group = group as usize;
            let p: Block<B> =
                prolongation(&self.places[member], &self.groups.centres[group], self.scale);
            for (row, left) in p.iter().zip(&self.left[member]) {
                for (right, entry) in right[group].iter_mut().zip(row) {
                    *right += entry * left;
                }
            }
        }
        below.cycle(workers, right, solution);
        for (member, &group) in self.groups.of.iter().enumerate() {
            let group = group as usize;
            let p: Block<B> =
                prolongation(&self.places[member], &self.groups.centres[group], self.scale);
            add_product(&mut x[member], 1.0, &p, &solution[group]);
        }
    }

    fn smooth(&mut self, workers: &Workers, r: &[[f64; B]], x: &mut [[f64; B]]) {
        self.matrix.residual(workers, r, x, &mut self.left);
        for ((x, left), inverse) in x.iter_mut().zip(&self.left).zip(&self.inverses) {
            add_product(x, self.damping, inverse, left);
        }
    }

    /// 4/3 over the largest eigenvalue of D^-1 A, by powers.
    fn find_damping(&mut self, workers: &Workers) -> Result<f64> {
        let count = self.places.len();
        let zero = memory::filled([0.0; B], count, PURPOSE)?;
        let mut x = memory::filled([0.0; B], count, PURPOSE)?;
        for (number, value) in x.as_flattened_mut().iter_mut().enumerate() {
            *value = (number as f64 * 1.7).sin();
        }
        let mut largest = 1.0;
        for _ in 0..12 {
            self.matrix.residual(workers, &zero, &x, &mut self.left);
            for ((x, left), inverse) in x.iter_mut().zip(&self.left).zip(&self.inverses) {
                *x = [0.0; B];
                add_product(x, -1.0, inverse, left);
            }
            largest = crate::solver::space::largest(x.as_flattened());
            if largest == 0.0 || !largest.is_finite() {
                return Ok(0.5);
            }
            x.as_flattened_mut().iter_mut().for_each(|value| *value /= largest);
        }
        Ok(4.0 / (3.0 * 1.1 * largest))
    }
}

#[inline(always)]
fn add_product<const B: usize>(x: &mut [f64; B], factor: f64, matrix: &Block<B>, v: &[f64; B]) {
    for (x, row) in x.iter_mut().zip(matrix) {
        *x += factor * row.iter().zip(v).map(|(a, v)| a * v).sum::<f64>();
    }
}

/// The modes of a member of a group, from those of the group.
#[inline(always)]
fn prolongation<const D: usize, const B: usize>(
    place: &Vector<D>,
    centre: &Vector<D>,
    scale: f64,
) -> Block<B> {
    let modes: [Vector<D>; B] = modes(&super::bond_stiffness::apart(centre, place), scale);
    let mut p = [[0.0; B]; B];
    for (column, mode) in modes.iter().enumerate() {
        for axis in 0..D {
            p[axis][column] = mode[axis];
        }
        if column >= D {
            p[column][column] = 1.0;
        }
    }
    p
}

/// P^T A P
fn coarsened<const D: usize, const B: usize>(
    matrix: &Matrix<B>,
    groups: &Aggregates<D>,
    places: &[Vector<D>],
    scale: f64,
) -> Result<Matrix<B>> {
    let mut coarser = Matrix::new(groups.count())?;
    let mut maker = RowMaker::new(groups.count())?;
    let of = |member: usize| groups.of[member] as usize;
    let p = |member: usize| -> Block<B> {
        prolongation(&places[member], &groups.centres[of(member)], scale)
    };
    for group in 0..groups.count() {
        for &member in groups.members(group) {
            let own = p(member as usize);
            for (other, block) in matrix.row(member as usize) {
                let there = p(other);
                let sum = maker.block(&mut coarser, of(other))?;
                for row in 0..B {
                    let mut half = [0.0; B];
                    for (column, value) in half.iter_mut().enumerate() {
                        *value = (0..B).map(|k| own[k][row] * block[k][column]).sum();
                    }
                    for column in 0..B {
                        sum[row][column] += (0..B).map(|k| half[k] * there[k][column]).sum::<f64>();
                    }
                }
            }
        }
        maker.end_row(&mut coarser);
    }
    Ok(coarser)
}

fn whole<const B: usize>(matrix: &Matrix<B>) -> Result<Factor> {
    let size = matrix.rows() * B;
    let mut full = memory::filled(0.0, size * size, PURPOSE)?;
    for row in 0..matrix.rows() {
        for (column, block) in matrix.row(row) {
            for (line, entries) in block.iter().enumerate() {
                let start = (row * B + line) * size + column * B;
                full[start..start + B].copy_from_slice(entries);
            }
        }
    }
    Factor::new(full, size)
}

fn inverses<const B: usize>(matrix: &Matrix<B>) -> Result<Vec<Block<B>>> {
    let mut inverses = memory::filled([[0.0; B]; B], matrix.rows(), PURPOSE)?;
    for (row, inverse) in inverses.iter_mut().enumerate() {
        if let Some((_, own)) = matrix.row(row).find(|(column, _)| *column == row) {
            let own = memory::copied(own.as_flattened(), PURPOSE)?;
            Factor::new(own, B)?.inverse(inverse.as_flattened_mut());
        }
    }
    Ok(inverses)
}
