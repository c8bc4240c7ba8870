//! A body seen from aside: its points as balls, the nearest in front, each darker towards its rim.

use crate::colours::Colour;
use crate::raster::Canvas;

/// Radius of a ball in spacings: balls on the corners of a cube leave no hole in its faces.
pub const RADIUS: f64 = 0.75;
/// How much of the light is left at the rim of a ball.
const RIM: f64 = 0.55;

/// Where the viewer stands.
#[derive(Clone, Copy)]
pub struct View {
    /// The axis that points to the right; the next one points up.
    pub right: usize,
    /// About the upright axis, degrees.
    pub turn: f64,
    /// From above, degrees.
    pub tilt: f64,
}

impl View {
    /// To the right, up, and towards the viewer.
    pub fn place(self, position: [f64; 3]) -> [f64; 3] {
        let [right, up, near] = [0, 1, 2].map(|next| position[(self.right + next) % 3]);
        let (sin, cos) = self.turn.to_radians().sin_cos();
        let (right, near) = (right * cos + near * sin, near * cos - right * sin);
        let (sin, cos) = self.tilt.to_radians().sin_cos();
        [right, up * cos - near * sin, up * sin + near * cos]
    }
}

/// A canvas that knows how near to the viewer each pixel is.
pub struct Balls {
    pub canvas: Canvas,
    /// In pixels.
    depths: Vec<f64>,
}

impl Balls {
    pub fn over(canvas: Canvas) -> Self {
        let depths = vec![f64::NEG_INFINITY; canvas.width * canvas.height];
        Self { canvas, depths }
    }

    /// Draws a ball where it is not hidden; all lengths are in pixels, the last of the centre is its depth.
    pub fn draw(&mut self, centre: [f64; 3], radius: f64, colour: Colour) {
        let pixels = |axis: usize, size: usize| {
            let (low, high) = (centre[axis] - radius, centre[axis] + radius);
            low.max(0.0) as usize..((high.max(0.0) as usize).saturating_add(1)).min(size)
        };
        for row in pixels(1, self.canvas.height) {
            for column in pixels(0, self.canvas.width) {
                let apart = [column as f64 + 0.5 - centre[0], row as f64 + 0.5 - centre[1]];
                let rest = radius * radius - apart[0] * apart[0] - apart[1] * apart[1];
                let rise = rest.max(0.0).sqrt();
                let depth = centre[2] + rise;
                let index = row * self.canvas.width + column;
                if rest < 0.0 || depth <= self.depths[index] {
                    continue;
                }
                self.depths[index] = depth;
                let light = RIM + (1.0 - RIM) * rise / radius;
                let lit = colour.map(|part| (light * f64::from(part)) as u8);
                self.canvas.blend([column as i64, row as i64], lit, u8::MAX);
            }
        }
    }
}
