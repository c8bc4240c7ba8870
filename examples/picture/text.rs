//! Lettering on a picture, and numbers as a reader likes them.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use crate::colours::Colour;
use crate::raster::Canvas;

#[derive(Clone, Copy)]
pub struct Font(RasterHeight);

impl Font {
    /// A size that can be read in a picture of this width.
    pub fn for_width(width: usize) -> Self {
        Self(match width {
            0..700 => RasterHeight::Size16,
            700..1200 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        })
    }

    pub fn height(self) -> usize {
        self.0.val()
    }

    pub fn width(self, text: &str) -> usize {
        text.chars().count() * get_raster_width(FontWeight::Regular, self.0)
    }

    /// Rows of a line above the digits, and below them.
    pub fn blank_rows(self) -> [usize; 2] {
        [self.height() * 7 / 32, self.height() * 9 / 32]
    }

    /// Writes `text` with its upper left corner at `[left, top]`; characters that the font lacks appear as '?'.
    pub fn write(self, canvas: &mut Canvas, text: &str, [left, top]: [usize; 2], colour: Colour) {
        let advance = get_raster_width(FontWeight::Regular, self.0);
        for (place, character) in text.chars().enumerate() {
            let glyph = get_raster(character, FontWeight::Regular, self.0)
                .or_else(|| get_raster('?', FontWeight::Regular, self.0));
            let Some(glyph) = glyph else { continue };
            for (y, row) in glyph.rows().enumerate() {
                for (x, &strength) in row.iter().enumerate() {
                    let pixel = [(left + place * advance + x) as i64, (top + y) as i64];
                    canvas.blend(pixel, colour, strength);
                }
            }
        }
    }
}

/// `value` to four significant digits, with an exponent where it would be long without.
pub fn number(value: f64) -> String {
    let scientific = format!("{value:.3e}");
    let Some((digits, exponent)) = scientific.split_once('e') else { return scientific };
    match exponent.parse::<i32>() {
        Ok(exponent @ -3..=4) => {
            let decimals = (3 - exponent).max(0) as usize;
            without_trailing_zeros(&format!("{value:.decimals$}")).into()
        }
        _ => format!("{}e{exponent}", without_trailing_zeros(digits)),
    }
}

fn without_trailing_zeros(decimal: &str) -> &str {
    if decimal.contains('.') {
        decimal.trim_end_matches('0').trim_end_matches('.')
    } else {
        decimal
    }
}
