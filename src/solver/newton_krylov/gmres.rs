//! Restarted generalised minimal residuals, preconditioned from the right, so that it judges the residual itself.

use super::krylov::Left;
use super::{Cycle, System};
use crate::memory;
use crate::solver::balance::{PURPOSE, Trial};

/// Vectors kept before it starts again.
const SPACE: usize = 40;

/// From x = 0.
pub(super) fn gmres(
    system: &mut impl System,
    b: &[f64],
    x: &mut [f64],
    cycle: Cycle,
) -> Trial<Left> {
    x.fill(0.0);
    let mut r = system.copied(b)?;
    let mut left = cycle.products;
    let first = system.dot(&r, &r).sqrt();
    let goal = cycle.reduction * first;
    let mut size = first;
    while size > goal && left > 0 {
        let used = turn(system, &mut r, x, goal, left)?;
        left -= used;
        let next = system.dot(&r, &r).sqrt();
        if next.is_nan() || next >= 0.999 * size {
            break;
        }
        size = next;
    }
    Ok(if size <= goal { Left::Solved } else { Left::Open })
}

/// One space from the residual r: adds to x, takes from r, gives how many products it took.
fn turn(
    system: &mut impl System,
    r: &mut [f64],
    x: &mut [f64],
    goal: f64,
    most: usize,
) -> Trial<usize> {
    let turns = most.min(SPACE);
    let size = system.dot(r, r).sqrt();
    let mut basis = memory::reserved(turns + 1, PURPOSE)?;
    let mut first = system.copied(r)?;
    first.iter_mut().for_each(|value| *value /= size);
    basis.push(first);
    let mut columns: [[f64; SPACE + 1]; SPACE] = [[0.0; SPACE + 1]; SPACE];
    let mut rotations = [[1.0, 0.0]; SPACE];
    let mut right = [0.0; SPACE + 1];
    right[0] = size;
    let mut count = 0;
    let mut z = system.empty()?;
    for number in 0..turns {
        system.precondition(&basis[number], &mut z);
        let mut next = system.empty()?;
        system.multiply(&z, &mut next)?;
        let column = &mut columns[number];
        // Twice, since the first time leaves what rounding has kept.
        for _ in 0..2 {
            for (entry, vector) in column.iter_mut().zip(&basis) {
                let along = system.dot(vector, &next);
                *entry += along;
                system.combine(&mut next, 1.0, -along, vector);
            }
        }
        let rest = system.dot(&next, &next).sqrt();
        column[number + 1] = rest;
        for (place, [cosine, sine]) in rotations[..number].iter().enumerate() {
            let (above, below) = (column[place], column[place + 1]);
            column[place] = cosine * above + sine * below;
            column[place + 1] = cosine * below - sine * above;
        }
        let length = column[number].hypot(column[number + 1]);
        if length == 0.0 || !length.is_finite() {
            break;
        }
        let [cosine, sine] = [column[number] / length, column[number + 1] / length];
        rotations[number] = [cosine, sine];
        column[number] = length;
        right[number + 1] = -sine * right[number];
        right[number] *= cosine;
        count = number + 1;
        if rest <= 1e-14 * length {
            break;
        }
        next.iter_mut().for_each(|value| *value /= rest);
        basis.push(next);
        if right[count].abs() <= goal {
            break;
        }
    }
    // What is left is the last direction, turned back.
    let mut rest = [0.0; SPACE + 1];
    rest[count] = right[count];
    for (place, [cosine, sine]) in rotations[..count].iter().enumerate().rev() {
        let below = rest[place + 1];
        (rest[place], rest[place + 1]) = (-sine * below, cosine * below);
    }
    r.fill(0.0);
    for (factor, vector) in rest.iter().zip(&basis) {
        system.combine(r, 1.0, *factor, vector);
    }
    for row in (0..count).rev() {
        for column in row + 1..count {
            right[row] -= columns[column][row] * right[column];
        }
        right[row] /= columns[row][row];
    }
    let mut sum = system.empty()?;
    for (factor, vector) in right[..count].iter().zip(&basis) {
        system.combine(&mut sum, 1.0, *factor, vector);
    }
    system.precondition(&sum, &mut z);
    system.combine(x, 1.0, 1.0, &z);
    Ok(count.max(1))
}
