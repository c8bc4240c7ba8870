//! Factorisation of a small symmetric matrix that may be singular: directions without stiffness are left out.

use crate::error::Result;
use crate::memory;
use crate::solver::balance::PURPOSE;

/// A pivot smaller than this share of its diagonal is none.
const SINGULAR: f64 = 1e-9;

/// L L^T, the rows of L one after the other.
pub(super) struct Factor {
    size: usize,
    lower: Vec<f64>,
    /// First column of each row with an entry.
    first: Vec<usize>,
}

impl Factor {
    /// Of a matrix, row after row, that it takes.
    pub(super) fn new(mut matrix: Vec<f64>, size: usize) -> Result<Self> {
        let mut first = memory::filled(0, size, PURPOSE)?;
        for row in 0..size {
            let (above, own) = matrix.split_at_mut(row * size);
            let own = &mut own[..size];
            let start = own[..row].iter().position(|&entry| entry != 0.0).unwrap_or(row);
            first[row] = start;
            let diagonal = own[row];
            let mut pivot = diagonal;
            for column in start..row {
                let other = &above[column * size..][..=column];
                let from = start.max(first[column]);
                let known: f64 = (other[from..column].iter().zip(&own[from..column]))
                    .map(|(other, own)| other * own)
                    .sum();
                let entry =
                    if other[column] > 0.0 { (own[column] - known) / other[column] } else { 0.0 };
                own[column] = entry;
                pivot -= entry * entry;
            }
            own[row] = if pivot > SINGULAR * diagonal { pivot.sqrt() } else { 0.0 };
        }
        Ok(Self { size, lower: matrix, first })
    }

    /// Solves in place; what has no stiffness stays 0.
    pub(super) fn solve(&self, x: &mut [f64]) {
        for row in 0..self.size {
            let own = &self.lower[row * self.size..][..=row];
            let start = self.first[row];
            let known: f64 =
                own[start..row].iter().zip(&x[start..row]).map(|(entry, x)| entry * x).sum();
            x[row] = if own[row] > 0.0 { (x[row] - known) / own[row] } else { 0.0 };
        }
        for row in (0..self.size).rev() {
            let own = &self.lower[row * self.size..][..=row];
            let value = if own[row] > 0.0 { x[row] / own[row] } else { 0.0 };
            x[row] = value;
            let start = self.first[row];
            for (entry, x) in own[start..row].iter().zip(&mut x[start..row]) {
                *x -= entry * value;
            }
        }
    }

    /// The inverse, row after row, 0 where there is no stiffness.
    pub(super) fn inverse(&self, inverse: &mut [f64]) {
        inverse.fill(0.0);
        for (number, row) in inverse.chunks_exact_mut(self.size).enumerate() {
            row[number] = 1.0;
            self.solve(row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_solved_and_what_it_leaves_free_stays_where_it_is() {
        let matrix = vec![4.0, 2.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0];
        let factor = Factor::new(matrix, 3).unwrap();
        let mut x = [8.0, 7.0, 5.0];
        factor.solve(&mut x);
        assert!((x[0] - 1.25).abs() < 1e-15 && (x[1] - 1.5).abs() < 1e-15 && x[2] == 0.0, "{x:?}");
    }
}
