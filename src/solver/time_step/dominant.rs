//! The eigenvalue of largest size of a small matrix, by squaring: high powers of it lead into the space of that
//! eigenvalue, or of a pair.

/// Rows and columns at most.
pub(super) const SPACE: usize = 30;

pub(super) type Matrix = [[f64; SPACE]; SPACE];

/// Squarings: eigenvalues that differ by 1e-12 are told apart.
const SQUARINGS: usize = 45;

/// A space of two is one of a pair if the second direction is more than this, over the eigenvalue.
const PAIR: f64 = 1e-9;

pub(super) struct Dominant {
    pub(super) real: f64,
    pub(super) imaginary: f64,
    /// The eigenvector, or one vector of the plane of a pair.
    pub(super) vector: [f64; SPACE],
    /// What the eigenvector, or the plane, has in the last direction.
    pub(super) last: f64,
}

/// Of the first `size` rows and columns.
pub(super) fn eigenvalue(matrix: &Matrix, size: usize) -> Dominant {
    let mut power = *matrix;
    for _ in 0..SQUARINGS {
        let most = power.as_flattened().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        if most == 0.0 {
            break;
        }
        power.as_flattened_mut().iter_mut().for_each(|value| *value /= most);
        power = squared(&power, size);
    }
    // The largest column.
    let column = |column: usize| -> [f64; SPACE] { std::array::from_fn(|row| power[row][column]) };
    let longest = (0..size).max_by(|&a, &b| length(&column(a)).total_cmp(&length(&column(b))));
    let mut first = column(longest.unwrap_or(0));
    let size_of_first = length(&first);
    if size_of_first > 0.0 {
        first.iter_mut().for_each(|value| *value /= size_of_first);
    } else {
        first[0] = 1.0;
    }
    let mut second = applied(matrix, &first);
    let along = dot(&first, &second);
    second.iter_mut().zip(&first).for_each(|(value, first)| *value -= along * first);
    let turned = length(&second);
    let last = first[size.max(1) - 1];
    if turned.is_nan() || turned <= PAIR * along.abs() {
        return Dominant { real: along, imaginary: 0.0, vector: first, last: last.abs() };
    }
    second.iter_mut().for_each(|value| *value /= turned);
    // Of the plane of both.
    let of_second = applied(matrix, &second);
    let (across, own) = (dot(&first, &of_second), dot(&second, &of_second));
    let (middle, half) = (0.5 * (along + own), 0.5 * (along - own));
    let discriminant = half * half + turned * across;
    let (real, imaginary) = if discriminant < 0.0 {
        (middle, (-discriminant).sqrt())
    } else {
        (middle + discriminant.sqrt().copysign(middle), 0.0)
    };
    let last = last.hypot(second[size.max(1) - 1]);
    Dominant { real, imaginary, vector: first, last }
}

fn squared(a: &Matrix, size: usize) -> Matrix {
    let mut squared = [[0.0; SPACE]; SPACE];
    for (row, squared) in a[..size].iter().zip(&mut squared) {
        for (factor, other) in row.iter().zip(a) {
            squared.iter_mut().zip(other).for_each(|(value, other)| *value += factor * other);
        }
    }
    squared
}

fn applied(a: &Matrix, v: &[f64; SPACE]) -> [f64; SPACE] {
    std::array::from_fn(|row| dot(&a[row], v))
}

fn dot(a: &[f64; SPACE], b: &[f64; SPACE]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(a: &[f64; SPACE]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> Matrix {
        let mut matrix = [[0.0; SPACE]; SPACE];
        for (row, values) in rows.iter().enumerate() {
            matrix[row][..values.len()].copy_from_slice(values);
        }
        matrix
    }

    #[test]
    fn real_eigenvalues_and_pairs_are_found() {
        // 5 and 1; -7 and 2; 3 +- 4i beside 4.9.
        let symmetric = eigenvalue(&matrix(&[&[3.0, 2.0], &[2.0, 3.0]]), 2);
        assert!((symmetric.real - 5.0).abs() < 1e-12 && symmetric.imaginary == 0.0);
        assert!((symmetric.last - 0.5_f64.sqrt()).abs() < 1e-12);
        let negative = eigenvalue(&matrix(&[&[-7.0, 1.0], &[0.0, 2.0]]), 2);
        assert!((negative.real + 7.0).abs() < 1e-12 && negative.imaginary == 0.0);
        let pair = eigenvalue(&matrix(&[&[3.0, -8.0, 1.0], &[2.0, 3.0, 1.0], &[0.0, 0.0, 4.9]]), 3);
        assert!(
            (pair.real - 3.0).abs() < 1e-9 && (pair.imaginary - 4.0).abs() < 1e-9,
            "{}",
            pair.real
        );
        let opposite = eigenvalue(&matrix(&[&[0.0, 2.0], &[2.0, 0.0]]), 2);
        assert!((opposite.real.abs() - 2.0).abs() < 1e-12 && opposite.imaginary == 0.0);
        let nothing = eigenvalue(&matrix(&[]), 0);
        assert_eq!((nothing.real, nothing.imaginary), (0.0, 0.0));
    }
}
