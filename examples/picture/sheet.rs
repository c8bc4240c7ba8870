//! The page: the points, the title above them, the bar of colours beside them.

use crate::bar::Bar;
use crate::cells::Cells;
use crate::colours::{self, FAINT_INK, INK, NO_VALUE};
use crate::raster::Canvas;
use crate::scene::Scene;
use crate::text::{Font, number};
use crate::view::Balls;

/// The points are drawn this much finer than the picture, and averaged.
const OVERSAMPLING: usize = 2;
/// Dots are drawn this much larger than the spacing, so that rounding and small strain leave no lines between them.
const OVERLAP: f64 = 1.04;
/// Greatest height of the plot as a share of the picture's width.
const TALLEST: f64 = 1.25;

/// Sizes and places in pixels.
struct Layout {
    margin: usize,
    title_right: usize,
    plot: [usize; 2],
    plot_size: [usize; 2],
    bar: [usize; 2],
    bar_height: usize,
    height: usize,
}

pub fn compose(scene: &Scene, width: usize) -> Canvas {
    let font = Font::for_width(width);
    let bar = Bar::new(font, scene.range);
    let layout = Layout::new(scene, width, font, &bar);
    let mut canvas = Canvas::white(width, layout.height);
    canvas.place(&draw_dots(scene, layout.plot_size), OVERSAMPLING, layout.plot);
    draw_title(&mut canvas, scene, font, &layout);
    bar.draw(&mut canvas, layout.bar, layout.bar_height);
    canvas
}

impl Layout {
    fn new(scene: &Scene, width: usize, font: Font, bar: &Bar) -> Self {
        let margin = width / 32;
        let room = width.saturating_sub(3 * margin + bar.width()).max(width / 4);
        let ([left, bottom], [right, top]) = scene.bounds();
        let scale = (room as f64 / (right - left)).min(TALLEST * width as f64 / (top - bottom));
        let pixels = |extent: f64| ((extent * scale).round() as usize).max(1);
        let plot_size = [pixels(right - left), pixels(top - bottom)];
        let content_height = plot_size[1].max(6 * font.height());
        let content_top = margin + 2 * font.height();
        let plot_left = margin + room.saturating_sub(plot_size[0]) / 2;
        Self {
            margin,
            title_right: margin + room,
            plot: [plot_left, content_top + (content_height - plot_size[1]) / 2],
            plot_size,
            bar: [plot_left + plot_size[0] + margin, content_top],
            bar_height: content_height,
            height: content_top + content_height + margin,
        }
    }
}

fn draw_dots(scene: &Scene, size: [usize; 2]) -> Canvas {
    let [width, height] = size.map(|pixels| pixels * OVERSAMPLING);
    let ([left, bottom], [right, top]) = scene.bounds();
    let scale = [width as f64 / (right - left), height as f64 / (top - bottom)];
    let half = [0, 1].map(|axis| 0.5 * OVERLAP * scene.size[axis] * scale[axis]);
    if scene.viewed {
        return draw_balls(scene, Canvas::white(width, height), [left, top], scale);
    }
    let mut cells = Cells::over(Canvas::white(width, height));
    for dot in &scene.dots {
        let centre = [(dot.position[0] - left) * scale[0], (top - dot.position[1]) * scale[1]];
        let colour = scene.fraction(dot.value).map_or(NO_VALUE, colours::colour);
        if let Some(reach) = dot.reach {
            cells.draw(centre, reach * scale[0], colour);
            continue;
        }
        let first = [0, 1].map(|axis| (centre[axis] - half[axis]).round() as i64);
        let end =
            [0, 1].map(|axis| ((centre[axis] + half[axis]).round() as i64).max(first[axis] + 1));
        cells.canvas.fill(first, end, colour);
    }
    cells.finish()
}

/// The points as balls, from the upper left corner of what they cover.
fn draw_balls(scene: &Scene, canvas: Canvas, [left, top]: [f64; 2], scale: [f64; 2]) -> Canvas {
    let mut balls = Balls::over(canvas);
    for dot in &scene.dots {
        let [x, y, depth] = dot.position;
        let centre = [(x - left) * scale[0], (top - y) * scale[1], depth * scale[0]];
        let colour = scene.fraction(dot.value).map_or(NO_VALUE, colours::colour);
        balls.draw(centre, dot.reach.unwrap_or_default() * scale[0], colour);
    }
    balls.canvas
}

fn draw_title(canvas: &mut Canvas, scene: &Scene, font: Font, layout: &Layout) {
    font.write(canvas, &scene.title, [layout.margin, layout.margin], INK);
    if let Some(time) = scene.time {
        let text = format!("t = {}", number(time));
        let left = layout.title_right.saturating_sub(font.width(&text));
        font.write(canvas, &text, [left, layout.margin], FAINT_INK);
    }
}
