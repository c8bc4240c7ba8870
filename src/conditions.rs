//! Conditions: what the host prescribes on sets of points, along one axis each.
//!
//! Per point and axis the last displacement or velocity wins for good; body forces and tractions of
//! different sets add. Each is asked once per time it is needed at.

use std::ops::ControlFlow;

use crate::error::{Error, Result, argument, state};
use crate::memory;
use crate::points::Points;

/// What a condition prescribes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Displacement, a length.
    Displacement,
    /// Velocity.
    Velocity,
    /// Force per reference volume.
    BodyForce,
    /// Force per reference area of the surface along a set of points; it keeps its direction.
    Traction,
}

impl Quantity {
    fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::BodyForce => "body force",
            Self::Traction => "traction",
        }
    }

    /// Whether it is a force, and not a motion.
    pub(crate) fn is_load(self) -> bool {
        matches!(self, Self::BodyForce | Self::Traction)
    }
}

/// A function of time and reference positions (point after point, in the set's order) that fills one
/// value per point, or breaks off the run.
pub type ConditionFunction =
    Box<dyn FnMut(f64, &[f64], &mut [f64]) -> ControlFlow<()> + Send + Sync>;

/// Where the values of a condition come from.
pub(crate) enum Source {
    Constant(f64),
    Table { times: Vec<f64>, values: Vec<f64> },
    Function { function: ConditionFunction, positions: Vec<f64> },
    Values(Vec<f64>),
}

impl Source {
    /// A table of values over increasing times: linear between them, constant outside.
    pub(crate) fn table(times: &[f64], values: &[f64]) -> Result<Self> {
        if times.is_empty() || times.len() != values.len() {
            return argument(format!(
                "'times' has {} numbers and 'values' {}; there must be as many of both, and one at \
                 least",
                times.len(),
                values.len()
            ));
        }
        check_finite("times", times)?;
        check_finite("values", values)?;
        if let Some(place) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
            return argument(format!(
                "'times'[{}] is {}, not above the one before, {}; times must increase",
                place + 1,
                times[place + 1],
                times[place]
            ));
        }
        let purpose = "a table of values";
        Ok(Self::Table {
            times: memory::copied(times, purpose)?,
            values: memory::copied(values, purpose)?,
        })
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Function { .. } => "the function that",
            Self::Table { .. } => "the table that",
            Self::Constant(_) | Self::Values(_) => "what",
        }
    }

    fn varies_in_time(&self) -> bool {
        matches!(self, Self::Table { .. } | Self::Function { .. })
    }
}

fn check_finite(name: &str, values: &[f64]) -> Result<()> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(place) => {
            argument(format!("'{name}'[{place}] is {}; it must be finite", values[place]))
        }
        None => Ok(()),
    }
}

/// One prescribed quantity on one set and axis.
struct Condition {
    set: String,
    quantity: Quantity,
    axis: usize,
    source: Source,
    /// Inner places of the set's points, in the set's order.
    members: Vec<u32>,
    /// The members by inner place, so that sums do not depend on the set's order.
    sorted: Vec<u32>,
    /// Which members it still rules; a later condition takes points away from earlier ones.
    rules: Vec<bool>,
    /// Values last asked for: one for all members, or one each.
    now: Vec<f64>,
    /// For velocities, those at the middle of the step.
    midway: Vec<f64>,
    /// For tractions, the points that they act on, once it is known.
    spread: Option<Vec<Part>>,
}

/// What of the traction at a point of a set acts on a point of the body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Inner place of the point.
    pub(crate) place: u32,
    /// Number of the point in its set.
    pub(crate) member: u32,
    /// Area over the volume of the point.
    pub(crate) weight: f64,
}

/// All conditions of a simulation.
#[derive(Default)]
pub(crate) struct Conditions {
    list: Vec<Condition>,
}

/// One component ruled by a condition.
pub(crate) struct Ruled {
    /// Place of the component in a field: inner place times dimension plus axis.
    pub(crate) component: usize,
    pub(crate) quantity: Quantity,
    /// The prescribed value at the end of the step.
    pub(crate) value: f64,
    /// The prescribed velocity at the middle of the step.
    pub(crate) midway: f64,
    /// It changes by itself in time.
    pub(crate) varies: bool,
}

impl Conditions {
    /// Refuses what cannot be prescribed.
    pub(crate) fn check(points: &Points, set: &str, axis: usize, source: &Source) -> Result<()> {
        check_axis(points, axis)?;
        points.set_size(set)?;
        match source {
            Source::Constant(value) if !value.is_finite() => {
                argument(format!("'value' is {value}; it must be finite"))
            }
            Source::Values(values) => check_finite("values", values),
            _ => Ok(()),
        }
    }

    /// Adds a condition that has been checked, or replaces the one on the same set, quantity and axis.
    pub(crate) fn prescribe(
        &mut self,
        points: &Points,
        set: &str,
        quantity: Quantity,
        axis: usize,
        source: Source,
    ) -> Result<()> {
        let size = points.set_size(set)?;
        let purpose = "a condition";
        let mut members = memory::reserved(size, purpose)?;
        points.for_each_in_set(set, |point| members.push(points.order().place(point) as u32))?;
        let mut sorted = memory::collected(0..size as u32, purpose)?;
        sorted.sort_unstable_by_key(|&member| members[member as usize]);
        let each = matches!(source, Source::Function { .. } | Source::Values(_));
        let asked = if each { size } else { 1 };
        let mut condition = Condition {
            set: set.to_owned(),
            quantity,
            axis,
            rules: memory::filled(true, size, purpose)?,
            now: memory::filled(0.0, asked, purpose)?,
            midway: memory::filled(0.0, asked, purpose)?,
            source,
            members,
            sorted,
            spread: None,
        };
        if let Source::Function { positions, .. } = &mut condition.source {
            let dimension = points.dimension();
            *positions = memory::reserved(size * dimension, purpose)?;
            points.for_each_in_set(set, |point| {
                let start = point * dimension;
                positions.extend_from_slice(&points.coordinates()[start..start + dimension]);
            })?;
        }
        let taken = self.taken_by(&condition, points.count())?;
        memory::push(&mut self.list, condition, purpose)?;
        let new = self.list.len() - 1;
        for (place, condition) in self.list.iter_mut().enumerate() {
            if place != new && !condition.quantity.is_load() && condition.axis == axis {
                for (rules, &member) in condition.rules.iter_mut().zip(&condition.members) {
                    *rules &= !taken.get(member as usize).is_some_and(|&taken| taken);
                }
            }
        }
        let mut place = 0;
        self.list.retain(|condition| {
            place += 1;
            let replaced = condition.is(set, quantity, axis) && place <= new;
            !replaced && condition.rules.contains(&true)
        });
        Ok(())
    }

    /// The points that a displacement or velocity takes from earlier conditions.
    fn taken_by(&self, condition: &Condition, count: usize) -> Result<Vec<bool>> {
        if condition.quantity.is_load() {
            return Ok(Vec::new());
        }
        let mut taken = memory::filled(false, count, "a condition")?;
        for &member in &condition.members {
            taken[member as usize] = true;
        }
        Ok(taken)
    }

    /// Removes the condition on a set, quantity and axis.
    pub(crate) fn release(
        &mut self,
        points: &Points,
        set: &str,
        quantity: Quantity,
        axis: usize,
    ) -> Result<()> {
        check_axis(points, axis)?;
        points.set_size(set)?;
        let Some(place) = self.list.iter().position(|known| known.is(set, quantity, axis)) else {
            return argument(format!(
                "no {} is prescribed on set '{set}', axis {axis}, or others have taken all its points",
                quantity.name()
            ));
        };
        self.list.remove(place);
        Ok(())
    }

    /// Refuses velocities, which a body at rest has none of.
    pub(crate) fn check_at_rest(&self) -> Result<()> {
        match self.list.iter().find(|known| known.quantity == Quantity::Velocity) {
            Some(known) => state(format!(
                "a velocity is prescribed on set '{}', axis {}; equilibrium has none: release it, or \
                 prescribe a displacement",
                known.set, known.axis
            )),
            None => Ok(()),
        }
    }

    /// Whether any body force changes by itself.
    pub(crate) fn loads_vary(&self) -> bool {
        self.list.iter().any(|known| known.quantity.is_load() && known.source.varies_in_time())
    }

    /// Asks displacements and velocities for a step from `time` to `time + time_step`.
    pub(crate) fn ask_motion(&mut self, time: f64, time_step: f64) -> Result<()> {
        let motions = self.list.iter_mut().filter(|known| !known.quantity.is_load());
        for condition in motions {
            if condition.quantity == Quantity::Velocity {
                condition.ask(time + 0.5 * time_step)?;
                std::mem::swap(&mut condition.now, &mut condition.midway);
            }
            condition.ask(time + time_step)?;
        }
        Ok(())
    }

    /// Adds up the body forces at `time` into `load`, `dimension` numbers a point.
    pub(crate) fn ask_loads(
        &mut self,
        time: f64,
        dimension: usize,
        load: &mut [f64],
    ) -> Result<()> {
        load.fill(0.0);
        self.add_loads(time, dimension, load, None)
    }

    /// Adds the body forces at `time` to `load`: all, those that vary in time, or those that do not.
    pub(crate) fn add_loads(
        &mut self,
        time: f64,
        dimension: usize,
        load: &mut [f64],
        varying: Option<bool>,
    ) -> Result<()> {
        let loads = self.list.iter_mut().filter(|known| known.quantity.is_load());
        for condition in loads {
            if varying.is_some_and(|varying| varying != condition.source.varies_in_time()) {
                continue;
            }
            condition.ask(time)?;
            if let Some(spread) = &condition.spread {
                for part in spread {
                    let value = part.weight * condition.value(part.member as usize);
                    load[part.place as usize * dimension + condition.axis] += value;
                }
                continue;
            }
            for (member, &place) in condition.members.iter().enumerate() {
                load[place as usize * dimension + condition.axis] += condition.value(member);
            }
        }
        Ok(())
    }

    /// A set with a traction of which it is not known where it acts, and the inner places of its points.
    pub(crate) fn unspread(&self) -> Option<(&str, &[u32])> {
        let unknown =
            |known: &&Condition| known.quantity == Quantity::Traction && known.spread.is_none();
        self.list.iter().find(unknown).map(|known| (&known.set[..], &known.members[..]))
    }

    /// Tells where the tractions of a set act.
    pub(crate) fn spread(&mut self, set: &str, parts: &[Part]) -> Result<()> {
        let of_set = |known: &&mut Condition| {
            known.quantity == Quantity::Traction && known.spread.is_none() && known.set == set
        };
        for condition in self.list.iter_mut().filter(of_set) {
            condition.spread = Some(memory::copied(parts, "a traction")?);
        }
        Ok(())
    }

    /// Forgets where the tractions of a set act.
    pub(crate) fn forget_spread(&mut self, set: &str) {
        for condition in self.list.iter_mut().filter(|known| known.set == set) {
            condition.spread = None;
        }
    }

    /// Calls `visit` with every component that a displacement or velocity rules.
    pub(crate) fn for_each_ruled(&self, dimension: usize, mut visit: impl FnMut(Ruled)) {
        let motions = self.list.iter().filter(|known| !known.quantity.is_load());
        for condition in motions {
            let members = condition.sorted.iter().map(|&member| member as usize);
            for member in members.filter(|&member| condition.rules[member]) {
                let each = if condition.midway.len() == 1 { 0 } else { member };
                visit(Ruled {
                    component: condition.members[member] as usize * dimension + condition.axis,
                    quantity: condition.quantity,
                    value: condition.value(member),
                    midway: condition.midway[each],
                    varies: condition.source.varies_in_time(),
                });
            }
        }
    }
}

impl Condition {
    fn is(&self, set: &str, quantity: Quantity, axis: usize) -> bool {
        self.set == set && self.quantity == quantity && self.axis == axis
    }

    fn value(&self, member: usize) -> f64 {
        if self.now.len() == 1 { self.now[0] } else { self.now[member] }
    }

    /// Fills `now` with the values at a time.
    fn ask(&mut self, time: f64) -> Result<()> {
        match &mut self.source {
            Source::Constant(value) => self.now[0] = *value,
            Source::Values(values) => self.now.copy_from_slice(values),
            Source::Table { times, values } => self.now[0] = interpolate(times, values, time),
            Source::Function { function, positions } => {
                if function(time, positions, &mut self.now).is_break() {
                    return Err(Error::Interrupted(format!(
                        "the function that prescribes the {} of set '{}', axis {}, asked to stop at \
                         time {time}",
                        self.quantity.name(),
                        self.set,
                        self.axis
                    )));
                }
            }
        }
        match self.now.iter().position(|value| !value.is_finite()) {
            Some(place) => Err(Error::Numeric(format!(
                "{} prescribes the {} of set '{}', axis {}, gave {} for point {place} of the set at time \
                 {time}; it must be finite",
                self.source.name(),
                self.quantity.name(),
                self.set,
                self.axis,
                self.now[place]
            ))),
            None => Ok(()),
        }
    }
}

fn check_axis(points: &Points, axis: usize) -> Result<()> {
    if axis < points.dimension() {
        return Ok(());
    }
    argument(format!("'axis' is {axis}; the points have axes 0 to {}", points.dimension() - 1))
}

fn interpolate(times: &[f64], values: &[f64], time: f64) -> f64 {
    let after = times.partition_point(|&known| known <= time);
    if after == 0 {
        return values[0];
    }
    if after == times.len() {
        return values[after - 1];
    }
    let share = (time - times[after - 1]) / (times[after] - times[after - 1]);
    values[after - 1] + share * (values[after] - values[after - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_linear_between_their_times_and_constant_outside() {
        let (times, values) = ([1.0, 2.0, 4.0], [10.0, 20.0, 0.0]);
        for (time, value) in [(0.0, 10.0), (1.0, 10.0), (1.5, 15.0), (3.0, 10.0), (9.0, 0.0)] {
            assert_eq!(interpolate(&times, &values, time), value);
        }
    }

    #[test]
    fn the_last_motion_wins_and_takes_its_points_from_earlier_ones_for_good() {
        let mut points = Points::block(2, &[0.0; 2], &[4.0, 1.0], 1.0).unwrap();
        points.add_set("left", &[0, 1]).unwrap();
        points.add_set("middle", &[1, 2]).unwrap();
        let mut conditions = Conditions::default();
        let mut add = |set, quantity, value| {
            conditions.prescribe(&points, set, quantity, 0, Source::Constant(value)).unwrap();
        };
        add("left", Quantity::Displacement, 1.0);
        add("middle", Quantity::Velocity, 2.0);
        add("left", Quantity::BodyForce, 3.0);
        conditions.ask_motion(0.0, 1.0).unwrap();
        let ruled = |conditions: &Conditions| {
            let mut seen = Vec::new();
            conditions.for_each_ruled(2, |ruled| seen.push((ruled.component, ruled.value)));
            seen
        };
        assert_eq!(ruled(&conditions), [(0, 1.0), (2, 2.0), (4, 2.0)]);
        conditions.release(&points, "middle", Quantity::Velocity, 0).unwrap();
        assert_eq!(ruled(&conditions), [(0, 1.0)]);
        assert!(conditions.release(&points, "middle", Quantity::Velocity, 0).is_err());
    }

    #[test]
    fn body_forces_of_different_sets_add_and_of_the_same_set_replace() {
        let mut points = Points::block(2, &[0.0; 2], &[2.0, 1.0], 1.0).unwrap();
        points.add_set("one", &[1]).unwrap();
        let mut conditions = Conditions::default();
        for (set, value) in [("all", 1.0), ("one", 10.0), ("all", 2.0)] {
            let source = Source::Constant(value);
            conditions.prescribe(&points, set, Quantity::BodyForce, 1, source).unwrap();
        }
        let mut load = [0.0; 4];
        conditions.ask_loads(0.0, 2, &mut load).unwrap();
        assert_eq!(load, [0.0, 2.0, 0.0, 12.0]);
    }
}
