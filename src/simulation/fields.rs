//! Fields: what each of them is, and how they go to the host and come from it.

use std::borrow::Cow;

use super::setup::Built;
use super::state::State;
use super::{Simulation, check_length};
use crate::damage::point_damage;
use crate::error::{Error, Result, argument, state};
use crate::memory;
use crate::points::Points;

const PURPOSE: &str = "a field";

/// A quantity that every point has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// Position in the reference configuration, a length, one number an axis.
    ReferencePosition,
    /// Current position, a length, one number an axis.
    Position,
    /// Displacement, a length, one number an axis.
    Displacement,
    /// Velocity, one number an axis.
    Velocity,
    /// Acceleration, one number an axis; 0 where displacement or velocity is prescribed.
    Acceleration,
    /// Internal force per reference volume, one number an axis.
    InternalForce,
    /// Body force per reference volume, one number an axis: the host's own and that of conditions.
    BodyForce,
    /// Force that holds prescribed components, one number an axis; 0 elsewhere.
    Reaction,
    /// Volume; in 2D area times thickness.
    Volume,
    /// Mass per volume.
    Density,
    /// Share of the family's volume that is lost, from 0 to 1.
    Damage,
    /// Energy of the bonds per reference volume.
    StrainEnergyDensity,
    /// Energy that broken bonds held, per reference volume.
    DissipatedEnergyDensity,
    /// Points within the point's own horizon.
    NeighborCount,
    /// Time step by the field's usual formula [P 3.58], a time; not a bound.
    TimeStepEstimate,
}

impl Field {
    /// All fields.
    pub const ALL: [Self; 15] = [
        Self::ReferencePosition,
        Self::Position,
        Self::Displacement,
        Self::Velocity,
        Self::Acceleration,
        Self::InternalForce,
        Self::BodyForce,
        Self::Reaction,
        Self::Volume,
        Self::Density,
        Self::Damage,
        Self::StrainEnergyDensity,
        Self::DissipatedEnergyDensity,
        Self::NeighborCount,
        Self::TimeStepEstimate,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ReferencePosition => "reference_position",
            Self::Position => "position",
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::InternalForce => "internal_force",
            Self::BodyForce => "body_force",
            Self::Reaction => "reaction",
            Self::Volume => "volume",
            Self::Density => "density",
            Self::Damage => "damage",
            Self::StrainEnergyDensity => "strain_energy_density",
            Self::DissipatedEnergyDensity => "dissipated_energy_density",
            Self::NeighborCount => "neighbor_count",
            Self::TimeStepEstimate => "time_step_estimate",
        }
    }

    /// Numbers a point has of it in a body of this dimension.
    pub fn components(self, dimension: usize) -> usize {
        match self {
            Self::ReferencePosition
            | Self::Position
            | Self::Displacement
            | Self::Velocity
            | Self::Acceleration
            | Self::InternalForce
            | Self::BodyForce
            | Self::Reaction => dimension,
            _ => 1,
        }
    }
}

impl Simulation {
    /// A field of all points in the host's order, point after point.
    ///
    /// # Errors
    /// `State` for `Acceleration`, `BodyForce` and `Reaction` while loads or forces have changed and
    /// were not evaluated; `Numeric` for a force that is not finite; `Memory`.
    pub fn get(&self, field: Field) -> Result<Vec<f64>> {
        let components = field.components(self.points.dimension());
        let mut values = memory::filled(0.0, self.points.count() * components, PURPOSE)?;
        self.get_into(field, &mut values)?;
        Ok(values)
    }

    /// As [`Simulation::get`], into the host's own memory.
    ///
    /// # Errors
    /// As [`Simulation::get`]; `Argument` when the length is not that of the field.
    pub fn get_into(&self, field: Field, values: &mut [f64]) -> Result<()> {
        let components = field.components(self.points.dimension());
        check_length(values.len(), self.points.count(), components)?;
        self.get_strided(None, field, values, components)
    }

    /// The field on a set, in the set's order, or on all points, with `stride` numbers from one point
    /// to the next; what lies between is not touched.
    ///
    /// # Errors
    /// As [`Simulation::get`]; `Argument` for an unknown set or values that are too few.
    pub fn get_strided(
        &self,
        set: Option<&str>,
        field: Field,
        values: &mut [f64],
        stride: usize,
    ) -> Result<()> {
        let components = field.components(self.points.dimension());
        let set = self.check_strided(set, components, values.len(), stride)?;
        let inner = self.inner(field)?;
        let order = self.points.order();
        let mut start = 0;
        self.points.for_each_in_set(set, |point| {
            let from = order.place(point) * components;
            values[start..start + components].copy_from_slice(&inner[from..from + components]);
            start += stride;
        })
    }

    /// Writes a field of all points: displacement, position, velocity or the host's body force.
    ///
    /// # Errors
    /// `Argument` for a length that is not that of the field or a value that is not finite;
    /// `Unsupported` for any other field; `Memory`.
    pub fn set(&mut self, field: Field, values: &[f64]) -> Result<()> {
        let dimension = self.points.dimension();
        check_length(values.len(), self.points.count(), dimension)?;
        self.set_strided(None, field, values, dimension)
    }

    /// As [`Simulation::set`], on a set in its order or on all points, with a stride.
    ///
    /// # Errors
    /// As [`Simulation::set`]; also for an unknown set.
    pub fn set_strided(
        &mut self,
        set: Option<&str>,
        field: Field,
        values: &[f64],
        stride: usize,
    ) -> Result<()> {
        let dimension = self.points.dimension();
        if !matches!(
            field,
            Field::Displacement | Field::Position | Field::Velocity | Field::BodyForce
        ) {
            return Err(Error::Unsupported(format!(
                "'field' {} cannot be set; displacement, position, velocity and body_force can",
                field.name()
            )));
        }
        let set = self.check_strided(set, dimension, values.len(), stride)?;
        self.check_values(set, field, values, stride)?;
        match field {
            Field::Velocity => self.give_kinetic(|simulation| {
                let target = &mut simulation.state.current.velocity;
                scatter(&simulation.points, set, values, stride, target, false);
            })?,
            Field::BodyForce => {
                let target = self.state.host_load_mut()?;
                scatter(&self.points, set, values, stride, target, false);
                self.state.loads_fresh = false;
            }
            _ => {
                self.close_ledger()?;
                let target = &mut self.state.current.displacement;
                scatter(&self.points, set, values, stride, target, field == Field::Position);
                self.state.force_fresh = false;
            }
        }
        Ok(())
    }

    fn check_strided<'a>(
        &self,
        set: Option<&'a str>,
        components: usize,
        length: usize,
        stride: usize,
    ) -> Result<&'a str> {
        let set = set.unwrap_or(crate::points::ALL);
        let size = self.points.set_size(set)?;
        if stride < components {
            return argument(format!(
                "'stride' is {stride}, but a point has {components} numbers of this field"
            ));
        }
        let needed = (size - 1).checked_mul(stride).and_then(|n| n.checked_add(components));
        if needed.is_none_or(|needed| length < needed) {
            return argument(format!(
                "'values' has {length} numbers, too few for {size} points of stride {stride}"
            ));
        }
        Ok(set)
    }

    fn check_values(&self, set: &str, field: Field, values: &[f64], stride: usize) -> Result<()> {
        let dimension = self.points.dimension();
        let mut bad = None;
        let mut start = 0;
        self.points.for_each_in_set(set, |point| {
            for (axis, &value) in values[start..start + dimension].iter().enumerate() {
                if !value.is_finite() && bad.is_none() {
                    bad = Some((point, axis, value));
                }
            }
            start += stride;
        })?;
        match bad {
            Some((point, axis, value)) => argument(format!(
                "'values': {} of point {point}, axis {axis}, is {value}; it must be finite",
                field.name()
            )),
            None => Ok(()),
        }
    }

    /// A field in the inner order.
    pub(super) fn inner(&self, field: Field) -> Result<Cow<'_, [f64]>> {
        let current = &self.state.current;
        Ok(match field {
            Field::Displacement => Cow::Borrowed(&current.displacement),
            Field::Velocity => Cow::Borrowed(&current.velocity),
            Field::ReferencePosition => Cow::Owned(self.reference_positions()?),
            Field::Position => {
                let mut positions = self.reference_positions()?;
                positions.iter_mut().zip(&current.displacement).for_each(|(x, u)| *x += u);
                Cow::Owned(positions)
            }
            Field::InternalForce => self.internal_force()?,
            Field::Acceleration => {
                self.check_fresh(field)?;
                Cow::Borrowed(&current.acceleration)
            }
            Field::BodyForce => {
                if !current.load.is_empty() {
                    self.check_fresh(field)?;
                }
                let host = self.state.host_load.as_deref();
                self.per_component(|component| State::body_force(host, &current.load, component))?
            }
            Field::Reaction => {
                self.check_fresh(field)?;
                self.reactions()?
            }
            Field::Volume => self.per_point(|built, point| built.plan.places[point][3])?,
            Field::Density => self.per_point(|built, point| built.plan.density.at(point))?,
            Field::Damage => self.swept(|built, values| {
                let Built { workers, plan, bonds, .. } = built;
                point_damage(workers, &plan.families, &plan.places, bonds, values);
            })?,
            Field::StrainEnergyDensity => Cow::Owned(self.strain_energy_density()?),
            Field::DissipatedEnergyDensity => Cow::Borrowed(&self.built()?.dissipated[0]),
            Field::NeighborCount => self.per_point(|built, point| {
                let families = &built.plan.families;
                families.bonds(point).filter(|bond| families.owns(point, bond.length)).count()
                    as f64
            })?,
            Field::TimeStepEstimate => {
                let mut values = self.swept(|built, values| {
                    let Built { workers, plan, bonds, .. } = built;
                    let scene = plan.scene(workers, bonds, &current.displacement);
                    plan.formulation.conventional_stiffness(&scene, values);
                })?;
                let density = &self.built()?.plan.density;
                for (point, value) in values.to_mut().iter_mut().enumerate() {
                    *value = if *value > 0.0 {
                        (2.0 * density.at(point) / *value).sqrt()
                    } else {
                        f64::MAX
                    };
                }
                values
            }
        })
    }

    fn reference_positions(&self) -> Result<Vec<f64>> {
        let dimension = self.points.dimension();
        let mut positions = memory::reserved(self.points.coordinates().len(), PURPOSE)?;
        for &point in &self.points.order().host {
            let start = point as usize * dimension;
            positions.extend_from_slice(&self.points.coordinates()[start..start + dimension]);
        }
        Ok(positions)
    }

    fn internal_force(&self) -> Result<Cow<'_, [f64]>> {
        let current = &self.state.current;
        if self.state.force_fresh {
            return Ok(Cow::Borrowed(&current.force));
        }
        let Built { workers, plan, bonds, .. } = self.built()?;
        let mut force = memory::filled(0.0, current.force.len(), PURPOSE)?;
        let scene = plan.scene(workers, bonds, &current.displacement);
        match plan.formulation.force(&scene, &mut force, None) {
            Some(place) => Err(Error::Numeric(format!(
                "the force on point {} is not finite",
                self.points.order().host[place]
            ))),
            None => Ok(Cow::Owned(force)),
        }
    }

    fn reactions(&self) -> Result<Cow<'_, [f64]>> {
        let Built { plan, .. } = self.built()?;
        let (current, host) = (&self.state.current, self.state.host_load.as_deref());
        let mut reaction = memory::filled(0.0, current.force.len(), PURPOSE)?;
        self.conditions.for_each_ruled(plan.dimension, |ruled| {
            let component = ruled.component;
            let body = State::body_force(host, &current.load, component);
            let volume = plan.places[component / plan.dimension][3];
            reaction[component] = -volume * (current.force[component] + body);
        });
        Ok(Cow::Owned(reaction))
    }

    fn check_fresh(&self, field: Field) -> Result<()> {
        if self.state.force_fresh && self.state.loads_fresh {
            return Ok(());
        }
        state(format!(
            "{} is not known: displacements, loads, conditions or bonds have changed since the last \
             evaluation; evaluate or step first",
            field.name()
        ))
    }

    fn per_component(&self, value: impl Fn(usize) -> f64) -> Result<Cow<'_, [f64]>> {
        let components = 0..self.state.current.displacement.len();
        Ok(Cow::Owned(memory::collected(components.map(value), PURPOSE)?))
    }

    fn per_point(&self, value: impl Fn(&Built, usize) -> f64) -> Result<Cow<'_, [f64]>> {
        let built = self.built()?;
        let points = 0..self.points.count();
        Ok(Cow::Owned(memory::collected(points.map(|point| value(built, point)), PURPOSE)?))
    }

    fn swept(&self, sweep: impl FnOnce(&Built, &mut [f64])) -> Result<Cow<'_, [f64]>> {
        let built = self.built()?;
        let mut values = memory::filled(0.0, self.points.count(), PURPOSE)?;
        sweep(built, &mut values);
        Ok(Cow::Owned(values))
    }

    /// A field's own memory, to be written by the host until [`Simulation::take_back`].
    pub(crate) fn lend(&mut self, field: Field) -> Result<&mut [f64]> {
        match field {
            Field::Displacement | Field::Velocity => self.close_ledger()?,
            Field::BodyForce => {
                self.state.loads_fresh = false;
                return Ok(self.state.host_load_mut()?);
            }
            _ => {
                return Err(Error::Unsupported(format!(
                    "{} cannot be lent to write; displacement, velocity and body_force can",
                    field.name()
                )));
            }
        }
        let current = &mut self.state.current;
        if field == Field::Displacement {
            self.state.force_fresh = false;
            return Ok(&mut current.displacement);
        }
        Ok(&mut current.velocity)
    }

    /// Checks what the host has written to a field that was lent.
    pub(crate) fn take_back(&self, field: Field) -> Result<()> {
        let values = match field {
            Field::Displacement => &self.state.current.displacement,
            Field::Velocity => &self.state.current.velocity,
            _ => self.state.host_load.as_ref().unwrap_or(&self.state.current.load),
        };
        let dimension = self.points.dimension();
        match values.iter().position(|value| !value.is_finite()) {
            Some(component) => Err(Error::Numeric(format!(
                "'view': {} of point {}, axis {}, is {}; it must be finite",
                field.name(),
                self.points.order().host[component / dimension],
                component % dimension,
                values[component]
            ))),
            None => Ok(()),
        }
    }

    /// A field's own memory, to be read.
    pub(crate) fn show(&self, field: Field) -> Result<&[f64]> {
        let current = &self.state.current;
        match field {
            Field::Displacement => Ok(&current.displacement),
            Field::Velocity => Ok(&current.velocity),
            Field::Acceleration | Field::InternalForce => {
                self.check_fresh(field)?;
                let acceleration = field == Field::Acceleration;
                Ok(if acceleration { &current.acceleration } else { &current.force })
            }
            _ => Err(Error::Unsupported(format!(
                "{} cannot be lent; displacement, velocity, acceleration and internal_force can, get \
                 the others",
                field.name()
            ))),
        }
    }

    /// The sum of a field over a set or all points, one number per component. It is taken in fixed
    /// blocks of the inner order, so that its bits depend on the scene alone.
    ///
    /// # Errors
    /// As [`Simulation::get`]; `Argument` for an unknown set.
    pub fn sum(&self, field: Field, set: Option<&str>) -> Result<Vec<f64>> {
        let mut sums = Vec::new();
        let inner = self.inner(field)?;
        let components = field.components(self.points.dimension());
        let mut chosen = Vec::new();
        if let Some(set) = set {
            chosen = memory::filled(false, self.points.count(), PURPOSE)?;
            let order = self.points.order();
            self.points.for_each_in_set(set, |point| chosen[order.place(point)] = true)?;
        }
        for component in 0..components {
            let sum = self.sum_over_points(|point| {
                let counts = chosen.is_empty() || chosen[point];
                if counts { inner[point * components + component] } else { 0.0 }
            })?;
            memory::push(&mut sums, sum, PURPOSE)?;
        }
        Ok(sums)
    }
}

/// Copies checked values of a checked set into the inner order; `positions` become displacements.
fn scatter(
    points: &Points,
    set: &str,
    values: &[f64],
    stride: usize,
    target: &mut [f64],
    positions: bool,
) {
    let dimension = points.dimension();
    let mut start = 0;
    // The set is known to exist.
    let _ = points.for_each_in_set(set, |point| {
        let to = points.order().place(point) * dimension;
        for axis in 0..dimension {
            let reference =
                if positions { points.coordinates()[point * dimension + axis] } else { 0.0 };
            target[to + axis] = values[start + axis] - reference;
        }
        start += stride;
    });
}
