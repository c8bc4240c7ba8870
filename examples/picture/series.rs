//! Lines of several series on logarithmic axes, from the first four columns of a table: the series, the line of it, and the place
//! across and up, sizes of numbers. A line joins rows of one series and one line, in their order; its end tells which it is.
//! The axis across has round numbers instead where it is shorter than a power of ten.

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
    let [_, _, across, up, ..] = columns[..] else {
        return Err("needs four columns: series, line, across and up".into());
    };
    let (mut names, mut lines): (Vec<&str>, Vec<Line>) = (Vec::new(), Vec::new());
    for (number, row) in rows {
        let [series, name, place @ ..] = &row[..] else { continue };
        let place = numbers(place.iter().copied().take(2))
            .ok()
            .and_then(|place| <[f64; 2]>::try_from(place).ok())
            .filter(|place| place.iter().all(|value| *value != 0.0))
            .ok_or(format!("line {number} needs a series, a line, and two numbers that are not 0"))?
            .map(f64::abs);
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
    let ends =
        |axis: usize| extremes(lines.iter().flat_map(|line| &line.places).map(|place| place[axis]));
    let [(left, right), (low, high)] = [ends(0), ends(1)];
    let is_narrow = left < right && right < 10.0 * left;
    for [across, up] in lines.iter_mut().flat_map(|line| &mut line.places) {
        *across = if is_narrow { *across } else { across.log10() };
        *up = up.log10();
    }
    let across = if is_narrow {
        Axis::new(across, left, right)?.rounded()
    } else {
        Axis::of_powers(across, left.log10(), right.log10())?
    };
    let up = Axis::of_powers(up, low.log10(), high.log10())?;
    let font = Font::for_width(options.width);
    let widest = names.iter().map(|name| font.width(name)).max().unwrap_or(0);
    let title = options.title.as_deref();
    let frame = Frame::new(
        options.width,
        [across, up],
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

/// A disc, or for series beyond the colours a square, and then a cross, of so many pixels from its middle to its side.
fn draw_mark(canvas: &mut Canvas, [x, y]: [f64; 2], size: f64, series: usize, colour: Colour) {
    match series / COLOURS.len() {
        // A line without length has round ends.
        0 => draw_line(canvas, &[[x, y]; 2], 2.0 * size, colour),
        1 => {
            let corner = |off: f64| [(x + off) as i64, (y + off) as i64];
            canvas.fill(corner(-0.9 * size), corner(0.9 * size), colour);
        }
        _ => {
            for side in [size, -size] {
                let ends = [[x - size, y - side], [x + size, y + side]];
                draw_line(canvas, &ends, 0.7 * size, colour);
            }
        }
    }
}
