//! Clouds of uneven spacing, as meshes give them: each pixel shows the point nearest to it, if it is
//! near to one point, or not far from two. So the cloud has no holes, and an edge is a line.

use crate::colours::{Colour, WHITE};
use crate::raster::Canvas;

/// Neighbours whose mean distance is the spacing at a point: as many as a triangle of a mesh has.
const NEIGHBOURS: usize = 3;
/// Not far, in spacings: up to the corners of a triangle, and a little more, so that strain opens no gaps.
const REACH: f64 = 1.15;
/// Near, as a share of the reach: up to the sides of a triangle.
const CORE: f64 = 0.5 / REACH;
/// No point reaches further than so many times what is usual: chips that have flown off stay small.
const FARTHEST: f64 = 1.5;
/// A cloud is uneven if its spacings between the tenth and the ninetieth percentile differ by this share.
const UNEVEN: f64 = 0.05;

/// How far each point of a flat cloud of uneven spacing reaches; `None` for any other.
pub fn reaches(positions: &[[f64; 3]]) -> Option<Vec<f64>> {
    let height = positions.first()?[2];
    if positions.len() <= NEIGHBOURS || positions.iter().any(|position| position[2] != height) {
        return None;
    }
    let spacings = spacings(positions);
    let mut sorted = spacings.clone();
    sorted.sort_by(f64::total_cmp);
    let percentile = |percent: usize| sorted[(sorted.len() - 1) * percent / 100];
    if percentile(90) - percentile(10) <= UNEVEN * percentile(50) {
        return None;
    }
    let farthest = FARTHEST * percentile(50);
    Some(spacings.into_iter().map(|spacing| REACH * spacing.min(farthest)).collect())
}

/// The mean distance of each point to its nearest neighbours, found along x.
fn spacings(positions: &[[f64; 3]]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|&a, &b| positions[a][0].total_cmp(&positions[b][0]));
    let mut spacings = vec![0.0; positions.len()];
    for (place, &point) in order.iter().enumerate() {
        let [x, y, _] = positions[point];
        let mut nearest = [f64::INFINITY; NEIGHBOURS];
        let mut consider = |other: usize| {
            let [dx, dy] = [positions[other][0] - x, positions[other][1] - y];
            if dx.abs() >= nearest[NEIGHBOURS - 1] {
                return false;
            }
            let distance = dx.hypot(dy);
            let rank = nearest.partition_point(|&other| other <= distance);
            if rank < NEIGHBOURS {
                nearest[rank..].rotate_right(1);
                nearest[rank] = distance;
            }
            true
        };
        // Both ways, each as long as the next point can still be nearer.
        for &other in order[place + 1..].iter() {
            if !consider(other) {
                break;
            }
        }
        for &other in order[..place].iter().rev() {
            if !consider(other) {
                break;
            }
        }
        spacings[point] = nearest.iter().sum::<f64>() / NEIGHBOURS as f64;
    }
    spacings
}

/// A canvas that knows how far each pixel is from the point it shows.
pub struct Cells {
    pub canvas: Canvas,
    /// Squared, in pixels.
    distances: Vec<f64>,
    /// 1 for each point not far from the pixel, 2 for each near to it.
    covers: Vec<u8>,
}

impl Cells {
    pub fn over(canvas: Canvas) -> Self {
        let distances = vec![f64::INFINITY; canvas.width * canvas.height];
        let covers = vec![0; distances.len()];
        Self { canvas, distances, covers }
    }

    /// Gives a point the pixels within its reach that no other is nearer to.
    pub fn draw(&mut self, centre: [f64; 2], reach: f64, colour: Colour) {
        let pixels = |axis: usize, size: usize| {
            let (low, high) = (centre[axis] - reach, centre[axis] + reach);
            low.max(0.0) as usize..((high.max(0.0) as usize).saturating_add(1)).min(size)
        };
        for row in pixels(1, self.canvas.height) {
            for column in pixels(0, self.canvas.width) {
                let apart = [column as f64 + 0.5 - centre[0], row as f64 + 0.5 - centre[1]];
                let distance = apart[0] * apart[0] + apart[1] * apart[1];
                if distance > reach * reach {
                    continue;
                }
                let index = row * self.canvas.width + column;
                let cover = if distance < (CORE * reach).powi(2) { 2 } else { 1 };
                self.covers[index] = self.covers[index].saturating_add(cover);
                if distance < self.distances[index] {
                    self.distances[index] = distance;
                    self.canvas.blend([column as i64, row as i64], colour, u8::MAX);
                }
            }
        }
    }
    /// The canvas without what only one point reaches, from afar.
    pub fn finish(mut self) -> Canvas {
        for index in (0..self.covers.len()).filter(|&index| self.covers[index] == 1) {
            let pixel = [(index % self.canvas.width) as i64, (index / self.canvas.width) as i64];
            self.canvas.blend(pixel, WHITE, u8::MAX);
        }
        self.canvas
    }
}
