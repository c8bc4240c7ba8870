//! A map: the numbers of a table as colours over two axes, row upon row.

use crate::axes::{Axis, Frame};
use crate::bar::{self, Bar};
use crate::colours;
use crate::options::Options;
use crate::raster::Canvas;
use crate::table::{Table, numbers};
use crate::text::Font;

pub fn compose(table: &Table, options: &Options) -> Result<Canvas, String> {
    let [across, first, last, up, bottom, top, values] = table.names.as_slice() else {
        return Err(format!("its first line has {} entries, not 7; see --help", table.names.len()));
    };
    let ends = numbers([first, last, bottom, top].into_iter().map(String::as_str))
        .map_err(|text| format!("line 1: {text}"))?;
    let (low, high) =
        options.range.unwrap_or_else(|| bar::range(table.rows.iter().flatten().copied()));
    let axes = [Axis::new(across, ends[0], ends[1])?, Axis::new(up, ends[2], ends[3])?];

    let font = Font::for_width(options.width);
    let legend = Bar::new(font, (low, high));
    let margin = options.width / 32;
    let frame = Frame::new(options.width, axes, 2, legend.width() + margin);
    let mut canvas = Canvas::white(options.width, frame.picture_height());
    draw_cells(&mut canvas, &frame, table, &ends, (low, high));
    frame.draw(&mut canvas, Some(options.title.as_deref().unwrap_or(values)));
    let [left, top] = frame.corner;
    legend.draw(&mut canvas, [left + frame.size[0] + margin, top], frame.size[1]);
    Ok(canvas)
}

/// Colours each pixel by the row and the column of the table that are nearest to it.
fn draw_cells(
    canvas: &mut Canvas,
    frame: &Frame,
    table: &Table,
    ends: &[f64],
    (low, high): (f64, f64),
) {
    let counts = [table.rows[0].len(), table.rows.len()];
    let nearest = |axis: usize, place: f64| {
        let share = (place - ends[2 * axis]) / (ends[2 * axis + 1] - ends[2 * axis]);
        (share * (counts[axis] - 1) as f64).round() as usize
    };
    for row in 0..frame.size[1] {
        for column in 0..frame.size[0] {
            let [across, up] = frame.place(column, row);
            let value = table.rows[nearest(1, up)][nearest(0, across)];
            let colour = colours::colour((value - low) / (high - low));
            let pixel = [(frame.corner[0] + column) as i64, (frame.corner[1] + row) as i64];
            canvas.fill(pixel, pixel.map(|place| place + 1), colour);
        }
    }
}
