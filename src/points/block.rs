//! A regular block of points: cell-centred lattice, x fastest.

use super::{Points, check_count, check_dimension};
use crate::error::{Result, argument};
use crate::memory;

impl Points {
    /// Fills the box from `lower` to `upper` with cells of edge `spacing` and puts a point of volume
    /// `spacing^dimension` in the middle of each. Counts per axis are rounded to the nearest.
    ///
    /// ```
    /// let plate = perion::Points::block(2, &[0.0, 0.0], &[2.0, 1.0], 0.5)?;
    /// assert_eq!(plate.count(), 8);
    /// assert_eq!(plate.coordinates()[..4], [0.25, 0.25, 0.75, 0.25]);
    /// # Ok::<(), perion::Error>(())
    /// ```
    ///
    /// # Errors
    /// `Argument` for limits that are not finite, upper not above lower, a spacing that is not
    /// positive, or more points than fit.
    pub fn block(dimension: usize, lower: &[f64], upper: &[f64], spacing: f64) -> Result<Self> {
        check_dimension(dimension)?;
        if lower.len() != dimension || upper.len() != dimension {
            return argument(format!("'lower' and 'upper' must have {dimension} numbers each"));
        }
        if !(spacing > 0.0 && spacing.is_finite()) {
            return argument(format!("'spacing' is {spacing}; it must be positive and finite"));
        }
        let mut counts = [1_usize; 3];
        for axis in 0..dimension {
            counts[axis] = count_along(axis, lower[axis], upper[axis], spacing)?;
        }
        let count = counts.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
        let count = count.unwrap_or(usize::MAX);
        check_count(count)?;
        let mut coordinates = memory::reserved(count * dimension, "coordinates")?;
        for cell in 0..count {
            let index =
                [cell % counts[0], cell / counts[0] % counts[1], cell / counts[0] / counts[1]];
            for axis in 0..dimension {
                coordinates.push(lower[axis] + (index[axis] as f64 + 0.5) * spacing);
            }
        }
        let volume = spacing.powi(dimension as i32);
        if !(volume > 0.0 && volume.is_finite()) {
            return argument(format!("'spacing' is {spacing}; its cells have volume {volume}"));
        }
        Self::assemble(dimension, coordinates, memory::filled(volume, count, "volumes")?)
    }
}

fn count_along(axis: usize, lower: f64, upper: f64, spacing: f64) -> Result<usize> {
    if !(lower.is_finite() && upper.is_finite() && upper > lower) {
        return argument(format!(
            "'lower' is {lower} and 'upper' {upper} on axis {axis}; both must be finite and upper \
             above lower"
        ));
    }
    if lower + spacing == lower || upper - spacing == upper {
        return argument(format!(
            "'spacing' is {spacing}, too small to tell points apart between 'lower' {lower} and \
             'upper' {upper} on axis {axis}"
        ));
    }
    let cells = ((upper - lower) / spacing).round();
    if cells < 1.0 {
        return argument(format!(
            "'spacing' is {spacing}, too large for the {} between 'lower' and 'upper' on axis {axis}",
            upper - lower
        ));
    }
    if cells > u32::MAX as f64 {
        return argument(format!(
            "'spacing' is {spacing}: {cells:e} points on axis {axis} are too many"
        ));
    }
    Ok(cells as usize)
}
