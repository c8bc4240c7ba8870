//! Points: where the material is, how much of it each point stands for, and named sets of them.
//!
//! Needs nothing. Gives positions in the host's order, the inner order that everything else works
//! in (`order`), volumes, optional horizons, and sets.

mod block;
mod order;
mod read;
mod sets;

use crate::error::{Result, argument};
use crate::memory;
use order::Coincident;
pub(crate) use order::Order;
pub(crate) use sets::{ALL, Sets};

/// A cloud of points in 2 or 3 dimensions, with the volume (in 2D: the area) of each.
///
/// Points may come in any order; no two may stand in one place. A point without neighbours is
/// allowed and reported by the simulation's health.
///
/// ```
/// use perion::Points;
/// let corners = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0];
/// let mut points = Points::new(2, &corners, &[0.25; 4])?;
/// points.add_set("left", &[0, 2])?;
/// assert_eq!(points.set("left")?, [0, 2]);
/// # Ok::<(), perion::Error>(())
/// ```
#[derive(Debug)]
pub struct Points {
    dimension: usize,
    coordinates: Vec<f64>,
    volumes: Vec<f64>,
    horizons: Option<Vec<f64>>,
    sets: Sets,
    order: Order,
}

impl Points {
    /// Takes `volumes.len()` points from `coordinates`, point after point, `dimension` numbers each.
    ///
    /// # Errors
    /// `Argument` for a dimension other than 2 and 3, no points, lengths that do not match, a
    /// coordinate that is not finite, a volume that is not positive and finite, or two points in
    /// one place. `Memory` when the copies do not fit.
    pub fn new(dimension: usize, coordinates: &[f64], volumes: &[f64]) -> Result<Self> {
        Self::from_strided(dimension, coordinates, dimension, volumes)
    }

    /// As [`Points::new`], with `stride` numbers from one point to the next.
    ///
    /// # Errors
    /// As [`Points::new`]; also for a stride smaller than the dimension.
    pub fn from_strided(
        dimension: usize,
        coordinates: &[f64],
        stride: usize,
        volumes: &[f64],
    ) -> Result<Self> {
        check_dimension(dimension)?;
        let count = volumes.len();
        check_count(count)?;
        if stride < dimension {
            return argument(format!(
                "'stride' is {stride}, but a point has {dimension} coordinates"
            ));
        }
        let needed = (count - 1).checked_mul(stride).and_then(|n| n.checked_add(dimension));
        if needed.is_none_or(|needed| coordinates.len() < needed) {
            return argument(format!(
                "'coordinates' has {} numbers, too few for {count} points of stride {stride}",
                coordinates.len()
            ));
        }
        let mut packed = memory::reserved(count * dimension, "coordinates")?;
        for (point, place) in coordinates.chunks(stride).take(count).enumerate() {
            for (axis, &value) in place[..dimension].iter().enumerate() {
                if !value.is_finite() || value.abs() > LARGEST_COORDINATE {
                    return argument(format!(
                        "'coordinates' of point {point}, axis {axis}, is {value}; it must be \
                         finite and at most {LARGEST_COORDINATE:e} in magnitude"
                    ));
                }
                packed.push(value);
            }
        }
        for (point, &volume) in volumes.iter().enumerate() {
            check_positive("volumes", point, volume)?;
        }
        Self::assemble(dimension, packed, memory::copied(volumes, "volumes")?)
    }

    fn assemble(dimension: usize, coordinates: Vec<f64>, volumes: Vec<f64>) -> Result<Self> {
        Self::try_assemble(dimension, coordinates, volumes)?.or_else(|Coincident(first, second)| {
            argument(format!("'coordinates': points {first} and {second} stand in one place"))
        })
    }

    /// Points of sound numbers, unless two stand in one place.
    fn try_assemble(
        dimension: usize,
        coordinates: Vec<f64>,
        volumes: Vec<f64>,
    ) -> Result<std::result::Result<Self, Coincident>> {
        let order = Order::new(dimension, &coordinates)?;
        Ok(order.map(|order| Self {
            dimension,
            coordinates,
            volumes,
            horizons: None,
            sets: Sets::default(),
            order,
        }))
    }

    /// A copy, which may run out of memory.
    pub(crate) fn try_clone(&self) -> Result<Self> {
        let horizons = match &self.horizons {
            Some(values) => Some(memory::copied(values, "horizons")?),
            None => None,
        };
        Ok(Self {
            dimension: self.dimension,
            coordinates: memory::copied(&self.coordinates, "coordinates")?,
            volumes: memory::copied(&self.volumes, "volumes")?,
            horizons,
            sets: self.sets.try_clone()?,
            order: self.order.try_clone()?,
        })
    }

    /// Gives each point its own horizon (length), in place of the model's.
    ///
    /// # Errors
    /// `Argument` when there is not one per point or one is not positive and finite.
    pub fn set_horizons(&mut self, horizons: &[f64]) -> Result<()> {
        if horizons.len() != self.count() {
            return argument(format!(
                "'count' is {}, but there are {} points",
                horizons.len(),
                self.count()
            ));
        }
        for (point, &horizon) in horizons.iter().enumerate() {
            check_positive("horizons", point, horizon)?;
        }
        self.horizons = Some(memory::copied(horizons, "horizons")?);
        Ok(())
    }

    /// Names a set of points by their indices, which keep their order.
    ///
    /// # Errors
    /// `Argument` for a name that is empty, taken or not text, no points, an index out of range or
    /// given twice.
    pub fn add_set(&mut self, name: &str, indices: &[usize]) -> Result<()> {
        self.sets.add(name, indices, self.count())
    }

    /// Adds a set that a file names, its points ascending.
    fn add_new_set(&mut self, name: &str, members: Vec<u32>, names: &mut sets::SetNames) {
        self.sets.add_new(name, members, self.count(), names);
    }

    /// Names of the sets in alphabetical order, without `all`.
    pub fn set_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.sets.names()
    }

    /// Refuses a set of more points than there are, before its indices are looked at.
    pub(crate) fn refuse_set_of(&self, size: usize) -> Result<()> {
        sets::too_many(size, self.count())
    }

    /// Names the set of all points within a box, its faces included, in the order of the points.
    ///
    /// # Errors
    /// `Argument` as for [`Points::add_set`], and for a box that is not finite, turned inside out
    /// or without points.
    pub fn add_set_box(&mut self, name: &str, lower: &[f64], upper: &[f64]) -> Result<()> {
        for (limits, label) in [(lower, "lower"), (upper, "upper")] {
            if limits.len() != self.dimension {
                return argument(format!(
                    "'{label}' has {} numbers; the points have {} axes",
                    limits.len(),
                    self.dimension
                ));
            }
        }
        for axis in 0..self.dimension {
            if lower[axis].is_nan() || upper[axis].is_nan() {
                return argument(format!("'lower' or 'upper' on axis {axis} is not a number"));
            }
            if lower[axis] > upper[axis] {
                return argument(format!(
                    "'lower' is {} and 'upper' {} on axis {axis}; lower must not exceed upper",
                    lower[axis], upper[axis]
                ));
            }
        }
        let mut inside = Vec::new();
        for (point, place) in self.coordinates.chunks_exact(self.dimension).enumerate() {
            if place
                .iter()
                .zip(lower.iter().zip(upper))
                .all(|(x, (low, high))| low <= x && x <= high)
            {
                memory::push(&mut inside, point, "a set")?;
            }
        }
        if inside.is_empty() {
            return argument(format!(
                "no point of set '{name}' lies between 'lower' {lower:?} and 'upper' {upper:?}"
            ));
        }
        self.add_set(name, &inside)
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        self.volumes.len()
    }

    /// Number of axes, 2 or 3.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Positions, point after point, in the host's order.
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// Volumes, in 2D areas, in the host's order.
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// Per-point horizons, if any were given.
    pub fn horizons(&self) -> Option<&[f64]> {
        self.horizons.as_deref()
    }

    /// Indices of a set in the order they were given. The set `all` always exists.
    ///
    /// # Errors
    /// `Argument` when there is no such set; the text names a similar one.
    pub fn set(&self, name: &str) -> Result<Vec<usize>> {
        let mut indices = memory::reserved(self.set_size(name)?, "a set")?;
        self.for_each_in_set(name, |point| indices.push(point))?;
        Ok(indices)
    }

    /// Number of points of a set.
    ///
    /// # Errors
    /// `Argument` when there is no such set.
    pub fn set_size(&self, name: &str) -> Result<usize> {
        if name == ALL { Ok(self.count()) } else { Ok(self.sets.find(name)?.len()) }
    }

    /// Refuses another count of values than the set has points.
    pub(crate) fn check_set_size(&self, name: &str, count: usize) -> Result<()> {
        let size = self.set_size(name)?;
        if count == size {
            return Ok(());
        }
        argument(format!("'count' is {count}, but set '{name}' has {size} points"))
    }

    /// Calls `visit` with the host index of each point of a set, in the set's order.
    pub(crate) fn for_each_in_set(&self, name: &str, mut visit: impl FnMut(usize)) -> Result<()> {
        if name == ALL {
            (0..self.count()).for_each(visit);
        } else {
            self.sets.find(name)?.iter().for_each(|&point| visit(point as usize));
        }
        Ok(())
    }

    /// The inner order, in which fields are kept and sums are taken.
    pub(crate) fn order(&self) -> &Order {
        &self.order
    }

    /// Heap bytes held.
    pub(crate) fn bytes(&self) -> usize {
        memory::bytes(&self.coordinates)
            + memory::bytes(&self.volumes)
            + self.horizons.as_ref().map_or(0, memory::bytes)
            + self.sets.bytes()
            + self.order.bytes()
    }
}

/// Squares of differences of coordinates below this stay finite.
const LARGEST_COORDINATE: f64 = 1e150;

fn check_dimension(dimension: usize) -> Result<()> {
    if matches!(dimension, 2 | 3) {
        return Ok(());
    }
    argument(format!("'dimension' is {dimension}; it must be 2 or 3"))
}

fn check_count(count: usize) -> Result<()> {
    if count == 0 {
        return argument("'count' is 0; at least one point is needed");
    }
    if count >= u32::MAX as usize {
        return argument(format!("'count' is {count}; at most {} points fit", u32::MAX - 1));
    }
    Ok(())
}

fn check_positive(name: &str, point: usize, value: f64) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    argument(format!("'{name}' of point {point} is {value}; it must be positive and finite"))
}
