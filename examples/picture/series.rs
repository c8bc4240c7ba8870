//! Lines of several series on logarithmic axes, from a table of four columns: the series, the line of it, and the place
//! across and up, above zero. A line joins rows of one series and one line, in their order; its end tells which it is.

use crate::axes::{Axis, Frame};
use crate::colours::{Colour, FAINT_INK, INK};
use crate::curve::draw_line;
use crate::options::Options;
use crate::raster::Canvas;
use crate::table::{extremes, numbers, rows_of};
use crate::text::Font;

/// Colours that colour-blind eyes tell apart; series beyond them have them again, with another mark.
const COLOURS: [Colour; 6] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [60, 60, 60]];

struct Line {
    /// Number of its series among the names.
    series: usize,
    name: String,
    places: Vec<[f64; 2]>,
}

pub fn compose(text: &str, options: &Options) -> Result<Canvas, String> {
    let (columns, rows) = rows_of(text)?;
    let [_, _, across, up] = columns[..] else {
        return Err("needs four columns: series, line, across and up".into());
    };
    let (mut names, mut lines): (Vec<&str>, Vec<Line>) = (Vec::new(), Vec::new());
    for (number, row) in rows {
        let [series, name, place @ ..] = &row[..] else { continue };
        let place = numbers(place.iter().copied())
            .ok()
            .and_then(|place| <[f64; 2]>::try_from(place).ok())
            .filter(|place| place.iter().all(|value| *value > 0.0))
            .ok_or(format!("line {number} needs a series, a line, and two numbers above zero"))?
            .map(f64::log10);
        let known = names.iter().position(|known| known == series);
        let series = known.unwrap_or_else(|| {
            names.push(series);
            names.len() - 1
        });
        match lines.last_mut().filter(|line| line.series == series && line.name == *name) {
            Some(line) => line.places.push(place),
            None => lines.push(Line { series, name: (*name).into(), places: vec![place] }),
        }
    }
    let axis = |label: &str, axis: usize| {
        let places = lines.iter().flat_map(|line| &line.places);
        let (low, high) = extremes(places.map(|place| place[axis]));
        Axis::of_powers(label, low, high)
    };
    let font = Font::for_width(options.width);
    let widest = names.iter().map(|name| font.width(name)).max().unwrap_or(0);
    let axes = [axis(across, 0)?, axis(up, 1)?];
    let title = options.title.as_deref();
    let frame = Frame::new(
        options.width,
        axes,
        if title.is_some() { 2 } else { 0 },
        widest + 3 * font.height(),
    );
    let mut canvas = Canvas::white(options.width, frame.picture_height());
    frame.draw_grid(&mut canvas);
    let mark = options.width as f64 / 250.0;
    for Line { series, name, places } in &lines {
        let colour = COLOURS[series % COLOURS.len()];
        let pixels: Vec<[f64; 2]> =
            places.iter().map(|place| frame.pixel(place[0], place[1])).collect();
        draw_line(&mut canvas, &pixels, options.width as f64 / 800.0, colour);
        for pixel in &pixels {
            draw_mark(&mut canvas, *pixel, mark, *series, colour);
        }
        if let Some([column, row]) = pixels.last() {
            let corner = [column + 1.5 * mark, row - 0.5 * font.height() as f64];
            font.write(&mut canvas, name, corner.map(|pixel| pixel as usize), colour);
        }
    }
    frame.draw(&mut canvas, title);
    let left = frame.corner[0] + frame.size[0] + 2 * font.height();
    for (series, name) in names.iter().enumerate() {
        let top = frame.corner[1] + series * font.height() * 5 / 4;
        let middle = [left as f64, (top + font.height() / 2) as f64];
        draw_mark(&mut canvas, middle, mark, series, COLOURS[series % COLOURS.len()]);
        font.write(&mut canvas, name, [left + font.height() / 2, top], INK);
    }
    let note = [left, frame.corner[1] + names.len() * font.height() * 5 / 4 + font.height() / 2];
    Font::for_width(options.width / 2).write(
        &mut canvas,
        &format!("numbers: {}", columns[1]),
        note,
        FAINT_INK,
    );
    Ok(canvas)
}

/// A disc, or for series beyond the colours a square, of so many pixels from its middle to its side.
fn draw_mark(canvas: &mut Canvas, [x, y]: [f64; 2], size: f64, series: usize, colour: Colour) {
    if series < COLOURS.len() {
        // A line without length has round ends.
        draw_line(canvas, &[[x, y]; 2], 2.0 * size, colour);
    } else {
        let [low, high] = [-0.9 * size, 0.9 * size].map(|off| [(x + off) as i64, (y + off) as i64]);
        canvas.fill(low, high, colour);
    }
}
