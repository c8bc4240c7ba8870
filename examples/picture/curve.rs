//! Curves: the second column of a table, or all others, over its first.

use crate::axes::{Axis, Frame};
use crate::colours::{Colour, LINES};
use crate::options::{Kind, Options};
use crate::raster::Canvas;
use crate::table::{Table, extremes};

pub fn compose(table: &Table, options: &Options) -> Result<Canvas, String> {
    let columns = table.names.len().min(table.rows[0].len());
    if columns < 2 {
        return Err("needs two columns, with their names in the first line".into());
    }
    let last = if matches!(options.kind, Kind::Curves) { columns - 1 } else { 1 };
    let drawn = 1..=last;
    if last > LINES.len() {
        return Err(format!("has {last} curves; at most {} are drawn", LINES.len()));
    }
    let value = |row: &[f64], column: usize| {
        if options.logarithmic { row[column].abs().log10() } else { row[column] }
    };
    let values =
        || table.rows.iter().flat_map(|row| drawn.clone().map(|column| value(row, column)));
    if let Some(lost) = values().find(|value| !value.is_finite()) {
        return Err(format!("has a 0, whose logarithm is {lost}"));
    }

    let axis = |label: &str, (low, high): (f64, f64)| Axis::new(label, low, high);
    let across = extremes(table.rows.iter().map(|row| row[0]));
    let across = axis(&table.names[0], across)?.rounded();
    // With one curve its name stands at the axis, with several beside their colours.
    let mut up = axis(if last == 1 { &table.names[1] } else { "" }, extremes(values()))?;
    if options.logarithmic {
        up = up.logarithmic();
    }
    let title = options.title.as_deref();
    let above = if title.is_some() { 2 } else { 0 };
    let legend = if last == 1 { 0 } else { last };
    let frame = Frame::new(options.width, [across, up.rounded()], above + legend, 0);
    let mut canvas = Canvas::white(options.width, frame.picture_height());
    frame.draw_grid(&mut canvas);
    for (column, colour) in drawn.clone().zip(LINES) {
        let line: Vec<[f64; 2]> =
            table.rows.iter().map(|row| frame.pixel(row[0], value(row, column))).collect();
        draw_line(&mut canvas, &line, options.width as f64 / 400.0, colour);
        if last > 1 {
            frame.draw_legend(&mut canvas, above + column - 1, colour, &table.names[column]);
        }
    }
    frame.draw(&mut canvas, title);
    Ok(canvas)
}

/// A line of this width through pixels, its edges smoothed.
pub fn draw_line(canvas: &mut Canvas, line: &[[f64; 2]], width: f64, colour: Colour) {
    let mut covered = vec![0_u8; canvas.width * canvas.height];
    let reach = 0.5 * width + 0.5;
    for ends in line.windows(2) {
        let pixels = |axis: usize, size: usize| {
            let (low, high) = (ends[0][axis].min(ends[1][axis]), ends[0][axis].max(ends[1][axis]));
            (low - reach).max(0.0) as usize..((high + reach).max(0.0) as usize + 1).min(size)
        };
        for row in pixels(1, canvas.height) {
            for column in pixels(0, canvas.width) {
                let distance = distance([column as f64 + 0.5, row as f64 + 0.5], ends);
                let strength = (255.0 * (reach - distance).clamp(0.0, 1.0)) as u8;
                let pixel = &mut covered[row * canvas.width + column];
                *pixel = strength.max(*pixel);
            }
        }
    }
    for (index, &strength) in covered.iter().enumerate() {
        let pixel = [(index % canvas.width) as i64, (index / canvas.width) as i64];
        canvas.blend(pixel, colour, strength);
    }
}

/// From a place to the nearest of a straight line between two ends.
fn distance(place: [f64; 2], ends: &[[f64; 2]]) -> f64 {
    let along = [0, 1].map(|axis| ends[1][axis] - ends[0][axis]);
    let from = [0, 1].map(|axis| place[axis] - ends[0][axis]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share =
        ((from[0] * along[0] + from[1] * along[1]) / square.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (from[0] - share * along[0]).hypot(from[1] - share * along[1])
}
