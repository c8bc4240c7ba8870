//! The frame of a plot: two axes with ticks at round numbers, and the lettering around them.

use crate::colours::{Colour, FAINT_INK, GRID, INK};
use crate::raster::Canvas;
use crate::text::{Font, number};

/// About how many ticks an axis has.
const TICKS: f64 = 6.0;

pub struct Axis {
    label: String,
    low: f64,
    high: f64,
    step: f64,
    /// Its values are powers of ten.
    is_logarithmic: bool,
}

impl Axis {
    /// From `low` to `high`, with ticks at steps of 1, 2 or 5 times a power of ten.
    pub fn new(label: &str, low: f64, high: f64) -> Result<Self, String> {
        let rough = (high - low) / TICKS;
        if !(rough > 0.0 && rough.log10().abs() < 300.0) {
            return Err(format!("its '{label}' goes from {low} to {high}"));
        }
        let power = 10_f64.powf(rough.log10().floor());
        let step = match rough / power {
            ..1.5 => power,
            1.5..3.5 => 2.0 * power,
            3.5..7.5 => 5.0 * power,
            _ => 10.0 * power,
        };
        Ok(Self { label: label.into(), low, high, step, is_logarithmic: false })
    }

    /// From `low` to `high`, powers of ten, and as far as the next whole ones, where its ticks are.
    pub fn of_powers(label: &str, low: f64, high: f64) -> Result<Self, String> {
        let (low, high) = (low.floor(), high.ceil().max(low.floor() + 1.0));
        if high - low > 30.0 {
            return Err(format!("its '{label}' goes over {} powers of ten", high - low));
        }
        Ok(Self { label: label.into(), low, high, step: 1.0, is_logarithmic: true })
    }

    /// The axis of numbers whose decimal logarithms it has, with ticks at powers of ten.
    pub fn logarithmic(self) -> Self {
        Self { step: self.step.ceil(), is_logarithmic: true, ..self }
    }

    /// The axis as far as its next ticks.
    pub fn rounded(self) -> Self {
        let step = self.step;
        let (low, high) = ((self.low / step).floor() * step, (self.high / step).ceil() * step);
        Self { low, high, ..self }
    }

    /// Where `value` lies, from 0 at the lower end to 1 at the upper.
    fn fraction(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// What stands at a tick.
    fn text(&self, tick: f64) -> String {
        if self.is_logarithmic { number(10_f64.powf(tick)) } else { number(tick) }
    }

    fn ticks(&self) -> Vec<f64> {
        let step = self.step;
        // Ticks that rounding alone puts beyond the ends belong to them.
        let (first, last) = (self.low / step - 1e-6, self.high / step + 1e-6);
        (first.ceil() as i64..=last.floor() as i64).map(|tick| tick as f64 * step).collect()
    }
}

/// Where the plot lies, in pixels.
pub struct Frame {
    pub corner: [usize; 2],
    pub size: [usize; 2],
    font: Font,
    margin: usize,
    across: Axis,
    up: Axis,
}

impl Frame {
    /// A plot in a picture of this width, half as high as it is wide, with room for lines of text above it and some room
    /// left free on its right.
    pub fn new(width: usize, [across, up]: [Axis; 2], above: usize, right: usize) -> Self {
        let (font, margin) = (Font::for_width(width), width / 32);
        let label =
            up.ticks().into_iter().map(|tick| font.width(&up.text(tick))).max().unwrap_or(0);
        let left = margin + label + font.height() / 2;
        // The label of the last tick is centred below it.
        let size = [width.saturating_sub(left + right + 2 * margin).max(width / 4), width * 7 / 16];
        let top = margin + (2 + above) * font.height();
        Self { corner: [left, top], size, font, margin, across, up }
    }

    /// Height of the whole picture.
    pub fn picture_height(&self) -> usize {
        self.corner[1] + self.size[1] + 3 * self.font.height() + self.margin
    }

    /// The pixel of a place in the plot.
    pub fn pixel(&self, across: f64, up: f64) -> [f64; 2] {
        let [right, down] = [self.across.fraction(across), 1.0 - self.up.fraction(up)];
        [0, 1].map(|axis| self.corner[axis] as f64 + [right, down][axis] * self.size[axis] as f64)
    }

    /// The value halfway along the pixel in so many of the plot's columns, and rows from above.
    pub fn place(&self, column: usize, row: usize) -> [f64; 2] {
        let share = |pixel: usize, axis: usize| (pixel as f64 + 0.5) / self.size[axis] as f64;
        let (right, up) = (share(column, 0), 1.0 - share(row, 1));
        [
            self.across.low + right * (self.across.high - self.across.low),
            self.up.low + up * (self.up.high - self.up.low),
        ]
    }

    /// Faint lines across the plot at the ticks of the upright axis.
    pub fn draw_grid(&self, canvas: &mut Canvas) {
        for tick in self.up.ticks() {
            let colour = if tick == 0.0 && !self.up.is_logarithmic { FAINT_INK } else { GRID };
            let [left, row] = self.pixel(self.across.low, tick).map(|pixel| pixel.round() as i64);
            canvas.fill([left, row - 1], [left + self.size[0] as i64, row + 1], colour);
        }
    }

    /// What a line of text above the plot says, behind a line of this colour.
    pub fn draw_legend(&self, canvas: &mut Canvas, line: usize, colour: Colour, text: &str) {
        let height = self.font.height();
        let top = self.margin + line * height;
        let [left, middle] = [self.margin as i64, (top + height / 2) as i64];
        let long = 2 * height;
        canvas.fill([left, middle - 2], [left + long as i64, middle + 2], colour);
        self.font.write(canvas, text, [self.margin + long + height / 2, top], INK);
    }

    /// The axes with their ticks, numbers and labels, and the title.
    pub fn draw(&self, canvas: &mut Canvas, title: Option<&str>) {
        let (font, [left, top]) = (self.font, self.corner);
        let (right, bottom) = (left + self.size[0], top + self.size[1]);
        let whole = |[x, y]: [usize; 2]| [x as i64, y as i64];
        canvas.fill(whole([left - 2, top]), whole([left, bottom + 2]), INK);
        canvas.fill(whole([left, bottom]), whole([right, bottom + 2]), INK);
        let length = font.height() / 3;
        for tick in self.across.ticks() {
            let column = self.pixel(tick, self.up.low)[0].round() as usize;
            canvas.fill(whole([column - 1, bottom]), whole([column + 1, bottom + length]), INK);
            let text = self.across.text(tick);
            let text_left = column.saturating_sub(font.width(&text) / 2);
            font.write(canvas, &text, [text_left, bottom + length], INK);
        }
        for tick in self.up.ticks() {
            let row = self.pixel(self.across.low, tick)[1].round() as usize;
            canvas.fill(whole([left - length, row - 1]), whole([left, row + 1]), INK);
            let text = self.up.text(tick);
            let text_left = left.saturating_sub(font.width(&text) + length + font.height() / 6);
            font.write(canvas, &text, [text_left, row - font.height() / 2], INK);
        }
        let under = bottom + length + font.height() * 5 / 4;
        let label_left = right.saturating_sub(font.width(&self.across.label));
        font.write(canvas, &self.across.label, [label_left, under], FAINT_INK);
        font.write(canvas, &self.up.label, [self.margin, top - font.height() * 7 / 4], FAINT_INK);
        if let Some(title) = title {
            font.write(canvas, title, [self.margin, self.margin], INK);
        }
    }
}
