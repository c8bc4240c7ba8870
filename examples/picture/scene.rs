//! What is drawn: where the points are, how large, and what value each has.

use crate::bar;
use crate::cells;
use crate::options::Options;
use crate::table::extremes;
use crate::view;
use crate::vtu::VtuFile;

/// Points examined to estimate the spacing: a median needs no more.
const SAMPLES: usize = 128;
/// Neighbours count as lying along an axis if they stray from it by at most this share of their distance along it.
const CONE: f64 = 0.5;
/// Extents that can be scaled to pixels and back.
const DRAWABLE: std::ops::Range<f64> = 1e-300..1e300;

pub struct Dot {
    pub position: [f64; 3],
    pub value: f64,
    /// How far it reaches at most, in a cloud of uneven spacing, or as a ball in a view.
    pub reach: Option<f64>,
}

pub struct Scene {
    /// From the lowest to the highest, so that the highest is drawn last.
    pub dots: Vec<Dot>,
    /// Size of a dot along x and y, in a cloud of even spacing.
    pub size: [f64; 2],
    /// Whether the body is seen from aside.
    pub viewed: bool,
    /// Values at the ends of the colours.
    pub range: (f64, f64),
    pub title: String,
    pub time: Option<f64>,
}

impl Scene {
    pub fn new(file: &VtuFile, options: &Options) -> Result<Self, String> {
        let (name, values) = scalar(file, &options.field)?;
        let title = options.title.clone().unwrap_or(name);
        let mut positions = file.positions()?;
        let reaches = cells::reaches(&positions);
        if let Some(scale) = options.displacement_scale {
            exaggerate(file, &mut positions, scale)?;
        }
        let dots = positions.into_iter().zip(values).enumerate().map(|(k, (position, value))| {
            let reach = reaches.as_ref().map(|reaches| reaches[k]);
            Dot { position, value, reach }
        });
        let mut dots: Vec<Dot> =
            dots.filter(|dot| dot.position.iter().all(|x| x.is_finite())).collect();
        if dots.is_empty() {
            return Err("holds no point with a finite position".into());
        }
        let [dx, dy, dz] = spacing(&dots);
        // A row of points has neighbours along one axis only, a single point none at all.
        let size = [dx.or(dy).unwrap_or(1.0), dy.or(dx).unwrap_or(1.0)];
        if let Some(height) = options.slice {
            keep_layer(&mut dots, height, dz.unwrap_or(size[0].max(size[1])))?;
        }
        if let Some(view) = options.view {
            let spacing = [dx, dy, dz].into_iter().flatten().fold(f64::INFINITY, f64::min);
            let reach = view::RADIUS * if spacing.is_finite() { spacing } else { size[0] };
            for dot in &mut dots {
                dot.position = view.place(dot.position);
                dot.reach = Some(reach);
            }
        }
        dots.sort_by(|a, b| a.position[2].total_cmp(&b.position[2]));
        let range = options.range.unwrap_or_else(|| bar::range(dots.iter().map(|dot| dot.value)));
        let viewed = options.view.is_some();
        let scene = Self { dots, size, viewed, range, title, time: file.time()? };
        let (low, high) = scene.bounds();
        let drawable = |axis: usize| DRAWABLE.contains(&(high[axis] - low[axis]));
        if drawable(0) && drawable(1) {
            Ok(scene)
        } else {
            Err(format!("cannot be drawn: its points reach from {low:?} to {high:?}"))
        }
    }

    /// The corners of what the dots cover, of least and of greatest x and y.
    pub fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for dot in &self.dots {
            for axis in 0..2 {
                let half = dot.reach.unwrap_or(0.5 * self.size[axis]);
                low[axis] = low[axis].min(dot.position[axis] - half);
                high[axis] = high[axis].max(dot.position[axis] + half);
            }
        }
        (low, high)
    }

    /// Where `value` lies in the range of colours; `None` if it is not a number.
    pub fn fraction(&self, value: f64) -> Option<f64> {
        let (low, high) = self.range;
        // Halved first: the width of a range may exceed the greatest number.
        let fraction = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
        value.is_finite().then_some(fraction)
    }
}

/// The title and the values of the field that `request` names: as it is, its magnitude, or a component.
fn scalar(file: &VtuFile, request: &str) -> Result<(String, Vec<f64>), String> {
    if let Some(field) = file.field(request)? {
        if field.components == 1 {
            return Ok((request.into(), field.values));
        }
        let magnitude = |vector: &[f64]| vector.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
        let values = field.values.chunks_exact(field.components).map(magnitude).collect();
        return Ok((format!("|{request}|"), values));
    }
    let absent = || format!("has no field '{request}'; it has {}", file.field_names());
    let (name, suffix) = request.rsplit_once('.').ok_or_else(absent)?;
    let field = file.field(name)?.ok_or_else(absent)?;
    let component = match suffix {
        "x" => Some(0),
        "y" => Some(1),
        "z" => Some(2),
        _ => suffix.parse::<usize>().ok(),
    };
    let component = component.filter(|&component| component < field.components).ok_or(format!(
        "its field '{name}' has {} components, and none is '{suffix}'",
        field.components
    ))?;
    let values = field.values.chunks_exact(field.components).map(|vector| vector[component]);
    Ok((request.into(), values.collect()))
}

/// The file has current positions: the displacement is in them once.
fn exaggerate(file: &VtuFile, positions: &mut [[f64; 3]], scale: f64) -> Result<(), String> {
    let displacement = file.field("displacement")?.ok_or_else(|| {
        format!("has no field 'displacement' to scale; it has {}", file.field_names())
    })?;
    let vectors = displacement.values.chunks_exact(displacement.components);
    for (position, vector) in positions.iter_mut().zip(vectors) {
        for (x, u) in position.iter_mut().zip(vector) {
            *x += (scale - 1.0) * u;
        }
    }
    Ok(())
}

/// Keeps the layer that holds the point nearest to `height`.
fn keep_layer(dots: &mut Vec<Dot>, height: f64, thickness: f64) -> Result<(), String> {
    let heights = || dots.iter().map(|dot| dot.position[2]);
    let distance = |z: &f64| (z - height).abs();
    let nearest = heights().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    match nearest.filter(|z| distance(z) <= thickness) {
        Some(layer) => {
            dots.retain(|dot| (dot.position[2] - layer).abs() < 0.5 * thickness);
            Ok(())
        }
        None => {
            let (low, high) = extremes(heights());
            Err(format!("has no points near z = {height}; they lie from {low} to {high}"))
        }
    }
}

/// The median distance to the nearest neighbour along each axis, where at least half the points have one.
fn spacing(dots: &[Dot]) -> [Option<f64>; 3] {
    let stride = dots.len().div_ceil(SAMPLES);
    let mut nearest: [Vec<f64>; 3] = Default::default();
    for sample in dots.iter().step_by(stride) {
        let mut distances = [f64::INFINITY; 3];
        for other in dots {
            let apart: [f64; 3] =
                std::array::from_fn(|k| (other.position[k] - sample.position[k]).abs());
            for axis in 0..3 {
                let (x, y, z) = (apart[axis], apart[(axis + 1) % 3], apart[(axis + 2) % 3]);
                if x > 0.0 && y <= CONE * x && z <= CONE * x {
                    distances[axis] = distances[axis].min(x);
                }
            }
        }
        for (all, one) in nearest.iter_mut().zip(distances) {
            all.push(one);
        }
    }
    nearest.map(|mut distances| {
        distances.sort_by(f64::total_cmp);
        distances.get((distances.len() - 1) / 2).copied().filter(|median| median.is_finite())
    })
}
