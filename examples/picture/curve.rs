//! A curve: the second column of a table over its first.

use crate::axes::{Axis, Frame};
use crate::colours::{Colour, LINE};
use crate::options::Options;
use crate::raster::Canvas;
use crate::table::{Table, extremes};

pub fn compose(table: &Table, options: &Options) -> Result<Canvas, String> {
    if table.names.len() < 2 || table.rows[0].len() < 2 {
        return Err("needs two columns, with their names in the first line".into());
    }
    let axis = |column: usize| {
        let (low, high) = extremes(table.rows.iter().map(|row| row[column]));
        Axis::new(&table.names[column], low, high).map(Axis::rounded)
    };
    let title = options.title.as_deref();
    let frame = Frame::new(options.width, [axis(0)?, axis(1)?], title.is_some(), 0);
    let mut canvas = Canvas::white(options.width, frame.picture_height());
    frame.draw_grid(&mut canvas);
    let line: Vec<[f64; 2]> = table.rows.iter().map(|row| frame.pixel(row[0], row[1])).collect();
    draw_line(&mut canvas, &line, options.width as f64 / 400.0, LINE);
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
