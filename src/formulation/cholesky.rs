//! Cholesky's factors of small symmetric matrices.

/// L of L L^T; `None` where a pivot is less than a share of the diagonal it came from.
pub(super) fn factor<const N: usize>(
    matrix: &[[f64; N]; N],
    size: usize,
    least_pivot: f64,
) -> Option<[[f64; N]; N]> {
    let mut lower = [[0.0; N]; N];
    for row in 0..size {
        for column in 0..=row {
            let done: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
            let rest = matrix[row][column] - done;
            if row == column {
                if rest.is_nan() || rest <= least_pivot * matrix[row][row] {
                    return None;
                }
                lower[row][row] = rest.sqrt();
            } else {
                lower[row][column] = rest / lower[column][column];
            }
        }
    }
    Some(lower)
}

/// Solves L L^T x = b in place.
pub(super) fn solve<const N: usize>(lower: &[[f64; N]; N], size: usize, x: &mut [f64; N]) {
    for k in 0..size {
        let done: f64 = (0..k).map(|inner| lower[k][inner] * x[inner]).sum();
        x[k] = (x[k] - done) / lower[k][k];
    }
    for k in (0..size).rev() {
        let done: f64 = (k + 1..size).map(|inner| lower[inner][k] * x[inner]).sum();
        x[k] = (x[k] - done) / lower[k][k];
    }
}
