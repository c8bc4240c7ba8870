//! How each field is had: from the state as it is, or computed when asked for.

use std::borrow::Cow;

use super::drive::stopped_by_law;
use super::fields::PURPOSE;
use super::setup::Built;
use super::{Field, Simulation};
use crate::damage::point_damage;
use crate::error::{Error, Result, state};
use crate::formulation::EnergyPart;
use crate::memory;
use crate::state::State;

impl Simulation {
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
            Field::Volume => self.per_point(|built, point| built.plan.places()[point][3])?,
            Field::Density => self.per_point(|built, point| built.plan.density.at(point))?,
            Field::Damage => self.swept(|built, values| {
                let Built { workers, plan, bonds, .. } = built;
                point_damage(workers, &plan.families, plan.places(), bonds, values);
            })?,
            Field::StrainEnergyDensity => self.energy_density(EnergyPart::Strain)?,
            Field::StabilizationEnergyDensity => self.energy_density(EnergyPart::Stabilization)?,
            Field::DissipatedEnergyDensity => {
                Cow::Owned(self.built()?.dissipated_density(&current.displacement)?)
            }
            Field::NeighborCount => self.per_point(|built, point| {
                let families = &built.plan.families;
                families.bonds(point).filter(|bond| families.owns(point, *bond)).count() as f64
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
            _ => Cow::Owned(self.kinematics(field)?),
        })
    }

    fn energy_density(&self, part: EnergyPart) -> Result<Cow<'_, [f64]>> {
        let density = self.built()?.energy_density(&self.state.current.displacement, part)?;
        Ok(Cow::Owned(density))
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
        let mut scratch = memory::filled(0.0, plan.scratch(bonds.is_graded()), PURPOSE)?;
        let scene = plan.scene(workers, bonds, &current.displacement);
        let failed = plan.formulation.force(&scene, &mut scratch, &mut force, None);
        if let Some(error) = stopped_by_law(plan) {
            return Err(error);
        }
        match failed {
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
            let volume = plan.places()[component / plan.dimension][3];
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
        if field == Field::Displacement {
            return Ok(self.state.displacement_mut());
        }
        Ok(&mut self.state.current.velocity)
    }

    /// Checks what the host has written to a field that was lent.
    pub(crate) fn take_back(&self, field: Field) -> Result<()> {
        let values = match field {
            Field::Displacement => &self.state.current.displacement,
            Field::Velocity => &self.state.current.velocity,
            Field::Acceleration => &self.state.current.acceleration,
            Field::InternalForce => &self.state.current.force,
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
