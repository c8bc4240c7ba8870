//! A picture as rows of pixels.

use crate::colours::{Colour, WHITE};

pub struct Canvas {
    pub width: usize,
    pub height: usize,
    pixels: Vec<Colour>,
}

impl Canvas {
    pub fn white(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![WHITE; width * height] }
    }

    /// Fills the pixels from `[left, top]` up to but without `[right, bottom]`, as far as they lie in the picture.
    pub fn fill(&mut self, [left, top]: [i64; 2], [right, bottom]: [i64; 2], colour: Colour) {
        let clip = |edge: i64, size: usize| edge.clamp(0, size as i64) as usize;
        let (left, right) = (clip(left, self.width), clip(right, self.width));
        let (top, bottom) = (clip(top, self.height), clip(bottom, self.height));
        if left >= right {
            return;
        }
        for row in top..bottom {
            self.pixels[row * self.width + left..row * self.width + right].fill(colour);
        }
    }

    /// Lays `colour` over one pixel, from nothing (0) to full (255).
    pub fn blend(&mut self, [column, row]: [i64; 2], colour: Colour, strength: u8) {
        let inside =
            (0..self.width as i64).contains(&column) && (0..self.height as i64).contains(&row);
        if inside {
            let pixel = &mut self.pixels[row as usize * self.width + column as usize];
            let (new, old) = (u32::from(strength), 255 - u32::from(strength));
            *pixel = std::array::from_fn(|k| {
                ((u32::from(colour[k]) * new + u32::from(pixel[k]) * old + 127) / 255) as u8
            });
        }
    }

    /// Places `finer` with its upper left corner at `[left, top]`, each `factor` x `factor` of its pixels as their mean.
    pub fn place(&mut self, finer: &Canvas, factor: usize, [left, top]: [usize; 2]) {
        let area = (factor * factor) as u32;
        for row in 0..(finer.height / factor).min(self.height.saturating_sub(top)) {
            for column in 0..(finer.width / factor).min(self.width.saturating_sub(left)) {
                let mut sum = [0_u32; 3];
                for k in 0..factor * factor {
                    let (y, x) = (row * factor + k / factor, column * factor + k % factor);
                    let pixel = finer.pixels[y * finer.width + x];
                    sum = std::array::from_fn(|k| sum[k] + u32::from(pixel[k]));
                }
                self.pixels[(top + row) * self.width + left + column] =
                    sum.map(|sum| ((sum + area / 2) / area) as u8);
            }
        }
    }

    pub fn to_png(&self) -> Result<Vec<u8>, String> {
        let failed = |reason| format!("cannot make the picture: {reason}");
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(self.pixels.as_flattened()).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(png)
    }
}
