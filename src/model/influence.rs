//! Influence functions omega(L): how much a bond counts by its length. [P 4.34-4.35]

use std::f64::consts::PI;

/// An influence function of the bond length. Families end at the horizon; the functions need not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Influence {
    /// 1
    Constant,
    /// horizon / length
    Inverse,
    /// 1 - length / horizon
    Conical,
    /// The cubic B-spline, scaled to integrate to 1 over the ball (in 2D the disc). [P 4.35]
    CubicSpline,
}

impl Influence {
    /// The function at a bond `length` for a `horizon`, both in units of length.
    ///
    /// ```
    /// use perion::Influence;
    /// assert_eq!(Influence::Inverse.value(3, 0.5, 2.0), 4.0);
    /// ```
    pub fn value(self, dimension: usize, length: f64, horizon: f64) -> f64 {
        let q = length / horizon;
        match self {
            Self::Constant => 1.0,
            Self::Inverse => 1.0 / q,
            Self::Conical => 1.0 - q,
            Self::CubicSpline => {
                let scale = if dimension == 3 {
                    8.0 / (PI * horizon.powi(3))
                } else {
                    40.0 / (7.0 * PI * horizon.powi(2))
                };
                if q <= 0.5 {
                    scale * (1.0 - 6.0 * q * q * (1.0 - q))
                } else if q <= 1.0 {
                    scale * 2.0 * (1.0 - q).powi(3)
                } else {
                    0.0
                }
            }
        }
    }
}
