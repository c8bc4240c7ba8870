//! Small square matrices: what the passes over families compute with, in two or three dimensions.
//!
//! By loops: calls of `map`, `from_fn` and `sum` are compiled in or not as the rest of the crate has it, which was a quarter of
//! the speed of correspondence.
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use std::array;

/// A vector of a body in `D` dimensions.
pub(crate) type Vector<const D: usize> = [f64; D];

/// A matrix, row after row.
pub(crate) type Tensor<const D: usize> = [[f64; D]; D];

pub(crate) fn zero<const D: usize>() -> Tensor<D> {
    [[0.0; D]; D]
}

#[inline(always)]
pub(crate) fn identity<const D: usize>() -> Tensor<D> {
    let mut identity = zero();
    for axis in 0..D {
        identity[axis][axis] = 1.0;
    }
    identity
}

/// Of numbers, row after row.
#[inline(always)]
pub(crate) fn read<const D: usize>(numbers: &[f64]) -> Tensor<D> {
    let mut tensor = zero();
    for row in 0..D {
        tensor[row].copy_from_slice(&numbers[row * D..(row + 1) * D]);
    }
    tensor
}

/// With as many rows and columns as asked for: what is missing is 0, what is too much is left out.
pub(crate) fn resized<const D: usize, const E: usize>(a: &Tensor<D>) -> Tensor<E> {
    let mut resized = zero();
    for (row, a) in resized.iter_mut().zip(a) {
        for (value, a) in row.iter_mut().zip(a) {
            *value = *a;
        }
    }
    resized
}

#[inline(always)]
pub(crate) fn dot<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> f64 {
    let mut sum = a[0] * b[0];
    for axis in 1..D {
        sum += a[axis] * b[axis];
    }
    sum
}

#[inline(always)]
pub(crate) fn transposed<const D: usize>(a: &Tensor<D>) -> Tensor<D> {
    let mut result = *a;
    for row in 0..D {
        for column in 0..D {
            result[row][column] = a[column][row];
        }
    }
    result
}

#[inline(always)]
pub(crate) fn sum<const D: usize>(a: &Tensor<D>, b: &Tensor<D>) -> Tensor<D> {
    let mut result = *a;
    for row in 0..D {
        for column in 0..D {
            result[row][column] = a[row][column] + b[row][column];
        }
    }
    result
}

#[inline(always)]
pub(crate) fn difference<const D: usize>(a: &Tensor<D>, b: &Tensor<D>) -> Tensor<D> {
    let mut result = *a;
    for row in 0..D {
        for column in 0..D {
            result[row][column] = a[row][column] - b[row][column];
        }
    }
    result
}

#[inline(always)]
pub(crate) fn scaled<const D: usize>(a: &Tensor<D>, factor: f64) -> Tensor<D> {
    let mut scaled = *a;
    for value in scaled.as_flattened_mut() {
        *value *= factor;
    }
    scaled
}

/// A B
#[inline(always)]
pub(crate) fn product<const D: usize>(a: &Tensor<D>, b: &Tensor<D>) -> Tensor<D> {
    let mut product = *a;
    for row in 0..D {
        for column in 0..D {
            let mut sum = a[row][0] * b[0][column];
            for inner in 1..D {
                sum += a[row][inner] * b[inner][column];
            }
            product[row][column] = sum;
        }
    }
    product
}

/// A v
#[inline(always)]
pub(crate) fn applied<const D: usize>(a: &Tensor<D>, v: &Vector<D>) -> Vector<D> {
    let mut result = *v;
    for row in 0..D {
        result[row] = dot(&a[row], v);
    }
    result
}

/// a + factor v w^T, in place.
#[inline(always)]
pub(crate) fn add_outer<const D: usize>(
    a: &mut Tensor<D>,
    factor: f64,
    v: &Vector<D>,
    w: &Vector<D>,
) {
    for (row, v) in a.iter_mut().zip(v) {
        let scaled = factor * v;
        for (value, w) in row.iter_mut().zip(w) {
            *value += scaled * w;
        }
    }
}

/// A : B
#[inline(always)]
pub(crate) fn contracted<const D: usize>(a: &Tensor<D>, b: &Tensor<D>) -> f64 {
    let mut sum = dot(&a[0], &b[0]);
    for row in 1..D {
        sum += dot(&a[row], &b[row]);
    }
    sum
}

#[inline(always)]
pub(crate) fn trace<const D: usize>(a: &Tensor<D>) -> f64 {
    let mut sum = a[0][0];
    for axis in 1..D {
        sum += a[axis][axis];
    }
    sum
}

/// (A + A^T)/2
#[inline(always)]
pub(crate) fn symmetric<const D: usize>(a: &Tensor<D>) -> Tensor<D> {
    let mut result = *a;
    for row in 0..D {
        for column in 0..D {
            result[row][column] = 0.5 * (a[row][column] + a[column][row]);
        }
    }
    result
}

pub(crate) fn determinant<const D: usize>(a: &Tensor<D>) -> f64 {
    if D == 2 {
        return a[0][0] * a[1][1] - a[0][1] * a[1][0];
    }
    (0..D).map(|column| a[0][column] * cofactor(a, 0, column)).sum()
}

/// The inverse, not a number where there is none.
pub(crate) fn inverse<const D: usize>(a: &Tensor<D>) -> Tensor<D> {
    let determinant = determinant(a);
    if D == 2 {
        let mut inverse = zero();
        inverse[0][0] = a[1][1] / determinant;
        inverse[0][1] = -a[0][1] / determinant;
        inverse[1][0] = -a[1][0] / determinant;
        inverse[1][1] = a[0][0] / determinant;
        return inverse;
    }
    array::from_fn(|row| array::from_fn(|column| cofactor(a, column, row) / determinant))
}

/// All cofactors: the transposed inverse times the determinant, where there is one.
pub(crate) fn cofactors<const D: usize>(a: &Tensor<D>) -> Tensor<D> {
    if D == 2 {
        let mut cofactors = zero();
        cofactors[0][0] = a[1][1];
        cofactors[0][1] = -a[1][0];
        cofactors[1][0] = -a[0][1];
        cofactors[1][1] = a[0][0];
        return cofactors;
    }
    array::from_fn(|row| array::from_fn(|column| cofactor(a, row, column)))
}

/// Of a matrix of three rows.
fn cofactor<const D: usize>(a: &Tensor<D>, row: usize, column: usize) -> f64 {
    let next = |index: usize, by: usize| (index + by) % D;
    let at = |by_row: usize, by_column: usize| a[next(row, by_row)][next(column, by_column)];
    at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
}

/// Eigenvalues of a symmetric matrix, and its eigenvectors as columns, by Jacobi's rotations.
pub(crate) fn eigen<const D: usize>(a: &Tensor<D>) -> (Vector<D>, Tensor<D>) {
    let (mut a, mut vectors) = (*a, identity());
    for _ in 0..32 {
        let mut off = 0.0_f64;
        for p in 0..D {
            for q in p + 1..D {
                off = off.max(a[p][q].abs());
                if a[p][q] == 0.0 {
                    continue;
                }
                let slope = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
                let tangent = slope.signum() / (slope.abs() + slope.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = tangent * cosine;
                for row in &mut a {
                    let (at_p, at_q) = (row[p], row[q]);
                    row[p] = cosine * at_p - sine * at_q;
                    row[q] = sine * at_p + cosine * at_q;
                }
                for k in 0..D {
                    let (at_p, at_q) = (a[p][k], a[q][k]);
                    a[p][k] = cosine * at_p - sine * at_q;
                    a[q][k] = sine * at_p + cosine * at_q;
                    let (v_p, v_q) = (vectors[k][p], vectors[k][q]);
                    vectors[k][p] = cosine * v_p - sine * v_q;
                    vectors[k][q] = sine * v_p + cosine * v_q;
                }
            }
        }
        if off == 0.0 {
            break;
        }
    }
    (array::from_fn(|axis| a[axis][axis]), vectors)
}
