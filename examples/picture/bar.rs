//! The bar of colours with the values at its ends.

use crate::colours::{self, INK};
use crate::raster::Canvas;
use crate::table::extremes;
use crate::text::{Font, number};

pub struct Bar {
    font: Font,
    high: String,
    low: String,
}

impl Bar {
    pub fn new(font: Font, (low, high): (f64, f64)) -> Self {
        Self { font, high: number(high), low: number(low) }
    }

    /// Of the bar and its lettering.
    pub fn width(&self) -> usize {
        self.font.height() * 3 / 2 + self.font.width(&self.high).max(self.font.width(&self.low))
    }

    /// Draws it with its upper left corner at `[left, top]`.
    pub fn draw(&self, canvas: &mut Canvas, [left, top]: [usize; 2], height: usize) {
        let font = self.font;
        for row in 0..height {
            let fraction = 1.0 - row as f64 / (height - 1).max(1) as f64;
            let (from, to) = ([left, top + row], [left + font.height(), top + row + 1]);
            let whole = |corner: [usize; 2]| corner.map(|pixel| pixel as i64);
            canvas.fill(whole(from), whole(to), colours::colour(fraction));
        }
        // Digits flush with the ends of the bar.
        let [above, below] = font.blank_rows();
        let text_left = left + font.height() * 3 / 2;
        font.write(canvas, &self.high, [text_left, top - above], INK);
        font.write(canvas, &self.low, [text_left, top + height + below - font.height()], INK);
    }
}

/// The range of the finite values, widened if there is only one.
pub fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = extremes(values.filter(|value| value.is_finite()));
    if low < high {
        (low, high)
    } else if low.is_finite() && low != 0.0 {
        (low.min(0.0), low.max(0.0))
    } else {
        (0.0, 1.0)
    }
}
