//! What a simulation tells of itself as a whole: energy, health, memory.

use super::Simulation;
use super::setup::Built;
use crate::error::{Error, Result};
use crate::formulation::EnergyPart;
use crate::memory;
use crate::solver::time_step::StableStep;
use crate::state::Ledger;
use crate::workers::{Workers, block_count};

/// The energy of a simulation, in units of energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energy {
    /// sum 1/2 rho V v^2.
    pub kinetic: f64,
    /// sum V W: what the bonds hold.
    pub elastic: f64,
    /// What broken bonds held when they broke, and the work of plastic flow.
    pub dissipated: f64,
    /// Part of it that plastic flow took.
    pub plastic: f64,
    /// Work of body forces, and of the constraints that hold prescribed points.
    pub external_work: f64,
    /// Kinetic + elastic + dissipated energy that neither external work accounts for, nor what was
    /// there at the start or was written by the host. Velocity Verlet lets it swing by about
    /// (omega dt)^2/8 of the energy; growing above that, energy comes out of nothing. Steps that the
    /// host commits itself are not in it: their work is not known.
    pub closure_error: f64,
}

/// What a host may want to look at before it trusts a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PointReport {
    /// How many points it concerns.
    pub count: usize,
    /// The first of them, by the host's index.
    pub first: Option<usize>,
}

/// The health of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Health {
    /// Points without a neighbour in the reference configuration.
    pub isolated: PointReport,
    /// Points that had neighbours and have lost all bonds.
    pub detached: PointReport,
    /// Bonds in all.
    pub bonds: u64,
    /// Bonds broken.
    pub broken_bonds: u64,
    /// Last time step over the stable one as it was last found; 0 before the first step. Near 1 the limit is near.
    pub time_step_ratio: f64,
    /// The stable step as it was last found; 0 before that. Where the host's own steps are known to be below it no more is looked
    /// for: then an estimate, no lower than these.
    pub stable_time_step: f64,
    /// Whether it was found from forces that have a potential, and is stable for small motions about the state it was
    /// found at; else it is an estimate.
    pub stable_step_is_guaranteed: bool,
    /// Smallest stretch of a bond that is not broken, 0 when none is compressed. Bonds pressed below
    /// about -0.3 are on their way to collapse, where their force turns over: the stable step
    /// promises nothing then.
    pub smallest_stretch: f64,
    /// Points with bonds whose families do not span the body (a plate one point thick, a chain, a family thinned
    /// by broken bonds), or do not bear the second order of gradient that was asked for. The material is
    /// asked in the directions spanned alone, as a membrane or a string without stress across; the gradient
    /// is of first order.
    pub degenerate: PointReport,
}

/// Heap bytes held by a simulation, without its conditions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// For points, their order, sets, places and materials.
    pub points: usize,
    /// For bonds, their state and when they break; 0 before set-up has ended.
    pub bonds: usize,
    /// For displacement, velocity, acceleration, forces and dissipated energy.
    pub state: usize,
}

impl Memory {
    /// All of it.
    pub fn total(&self) -> usize {
        self.points + self.bonds + self.state
    }
}

impl Simulation {
    /// The energy balance. Costs a sweep over the bonds.
    ///
    /// # Errors
    /// `Memory`, and what building the families can fail with.
    pub fn energy(&self) -> Result<Energy> {
        let (kinetic, elastic) = (self.kinetic()?, self.elastic()?);
        let [dissipated, plastic] = self.dissipated()?;
        let Ledger { work, given, carried, open } = self.state.ledger;
        let closure_error =
            if open { kinetic + elastic + dissipated - (work + given) } else { carried };
        Ok(Energy { kinetic, elastic, dissipated, plastic, external_work: work, closure_error })
    }

    pub(super) fn kinetic(&self) -> Result<f64> {
        let plan = &self.built()?.plan;
        let dimension = plan.dimension;
        self.sum_over_points(|point| {
            let velocity = &self.state.current.velocity[point * dimension..(point + 1) * dimension];
            let squared: f64 = velocity.iter().map(|v| v * v).sum();
            0.5 * plan.density.at(point) * plan.places()[point][3] * squared
        })
    }

    fn elastic(&self) -> Result<f64> {
        let built = self.built()?;
        let density = built.elastic_energy_density(&self.state.current.displacement)?;
        let places = built.plan.places();
        self.sum_over_points(|point| density[point] * places[point][3])
    }

    /// By all there is, and by plastic flow alone.
    fn dissipated(&self) -> Result<[f64; 2]> {
        let built = self.built()?;
        let (places, broken) = (built.plan.places(), &built.dissipated);
        let broken = |point: usize| broken.get(point).copied().unwrap_or(0.0);
        if built.bonds.records.is_empty() {
            let whole = self.sum_over_points(|point| broken(point) * places[point][3])?;
            return Ok([whole, 0.0]);
        }
        let plastic =
            built.energy_density(&self.state.current.displacement, EnergyPart::Plastic)?;
        Ok([
            self.sum_over_points(|point| (plastic[point] + broken(point)) * places[point][3])?,
            self.sum_over_points(|point| plastic[point] * places[point][3])?,
        ])
    }

    /// A sum over all points, in fixed blocks.
    pub(super) fn sum_over_points(&self, term: impl Fn(usize) -> f64 + Sync) -> Result<f64> {
        let count = self.points.count();
        let mut partial = memory::filled(0.0, block_count(count), "sums")?;
        Ok(match self.built.get() {
            Some(built) => built.workers.sum(count, &mut partial, term),
            None => Workers::new(1)?.sum(count, &mut partial, term),
        })
    }

    /// Takes the energy that is there as given, before steps account for its changes.
    pub(super) fn open_ledger(&mut self) -> Result<()> {
        if !self.state.ledger.open {
            let total = self.kinetic()? + self.elastic()? + self.dissipated()?[0];
            if !total.is_finite() {
                return Err(Error::Numeric(format!(
                    "the energy is not finite ({total}): displacements or velocities are too large to \
                     step from"
                )));
            }
            let ledger = &mut self.state.ledger;
            if !ledger.carried.is_finite() {
                // A run that overflowed is over: the host has set another state since.
                ledger.carried = 0.0;
            }
            ledger.given = total - ledger.work - ledger.carried;
            ledger.open = true;
        }
        Ok(())
    }

    /// Notes the closure error before the host changes the state by hand.
    pub(super) fn close_ledger(&mut self) -> Result<()> {
        if self.state.ledger.open {
            self.state.ledger.carried = self.energy()?.closure_error;
            self.state.ledger.open = false;
        }
        Ok(())
    }

    /// Lets the host change velocities; the ledger takes over the kinetic energy that it adds.
    pub(super) fn give_kinetic(&mut self, change: impl FnOnce(&mut Self)) -> Result<()> {
        if !self.state.ledger.open {
            change(self);
            return Ok(());
        }
        let before = self.kinetic()?;
        change(self);
        let added = self.kinetic().map_or(f64::NAN, |after| after - before);
        if added.is_finite() {
            self.state.ledger.given += added;
            return Ok(());
        }
        // The next step takes the energy that it finds as given, or refuses it.
        if let (Ok(elastic), Ok([dissipated, _])) = (self.elastic(), self.dissipated()) {
            let ledger = &mut self.state.ledger;
            ledger.carried = before + elastic + dissipated - (ledger.work + ledger.given);
        }
        self.state.ledger.open = false;
        Ok(())
    }

    /// What to look at before trusting a result.
    ///
    /// # Errors
    /// What building the families can fail with.
    pub fn health(&self) -> Result<Health> {
        let Built { plan, bonds, workers, stable_step, .. } = self.built()?;
        let mut isolated = PointReport { count: 0, first: None };
        let (mut detached, mut degenerate) = (isolated, isolated);
        let mut marks = memory::filled(0.0, plan.count(), "health")?;
        let scene = plan.scene(workers, bonds, &self.state.current.displacement);
        plan.formulation.degenerate(&scene, &mut marks);
        for point in 0..self.points.count() {
            let inner = self.points.order().place(point);
            let blocks = plan.families.blocks(inner);
            let report = if plan.families.is_alone(inner) {
                &mut isolated
            } else if bonds.intact[blocks].iter().all(|&mask| mask == 0) {
                &mut detached
            } else if marks[inner] != 0.0 {
                &mut degenerate
            } else {
                continue;
            };
            report.count += 1;
            report.first.get_or_insert(point);
        }
        let (mut bonds, mut broken_bonds, mut smallest_stretch) = (0, 0, 0.0);
        self.for_each_bond(|_, stretch, integrity| {
            bonds += 1;
            if integrity == 0.0 {
                broken_bonds += 1;
            } else if stretch < smallest_stretch {
                smallest_stretch = stretch;
            }
        })?;
        let known = stable_step.as_ref();
        let stable_time_step = known.map_or(0.0, |known| known.step);
        let last = self.state.last_time_step;
        let time_step_ratio = if known.is_some() { last / stable_time_step } else { 0.0 };
        Ok(Health {
            isolated,
            detached,
            bonds,
            broken_bonds,
            time_step_ratio,
            stable_time_step,
            stable_step_is_guaranteed: known.is_some_and(|known| known.is_guaranteed),
            smallest_stretch,
            degenerate,
        })
    }

    /// Number of bonds, broken or not, each counted once.
    ///
    /// # Errors
    /// What building the families can fail with.
    pub fn bond_count(&self) -> Result<u64> {
        let families = &self.built()?.plan.families;
        let ends = (0..self.points.count()).map(|point| families.bond_count(point) as u64);
        Ok(ends.sum::<u64>() / 2)
    }

    /// Heap bytes held.
    pub fn memory(&self) -> Memory {
        let mut memory = Memory {
            points: self.points.bytes() + memory::bytes(&self.model_of),
            bonds: 0,
            state: self.state.bytes(),
        };
        if let Some(built) = self.built.get() {
            let Built { plan, bonds, aside, dissipated, scratch, partial, .. } = built;
            memory.state += built.stable_step.as_ref().map_or(0, StableStep::bytes);
            memory.points += plan.point_bytes();
            memory.bonds += plan.bond_bytes() + bonds.bytes() + aside.bytes_of_masks();
            memory.state += memory::bytes(dissipated) + aside.bytes_of_losses();
            memory.state += memory::bytes(partial) + memory::bytes(scratch);
        }
        memory
    }

    /// All bonds, each once, as pairs of the host's indices, in an order that depends on the scene
    /// alone. Calls `visit` with pair, stretch at the current displacement, and integrity.
    ///
    /// # Errors
    /// What building the families can fail with.
    pub fn for_each_bond(&self, mut visit: impl FnMut([usize; 2], f64, f64)) -> Result<()> {
        let Built { plan, bonds, .. } = self.built()?;
        let (dimension, order) = (plan.dimension, self.points.order());
        let displacement = &self.state.current.displacement;
        for point in 0..plan.count() {
            for bond in plan.families.bonds(point).filter(|bond| point < bond.neighbor) {
                let (mut squared, mut change) = (0.0, 0.0);
                for axis in 0..dimension {
                    let reference = plan.places()[bond.neighbor][axis] - plan.places()[point][axis];
                    let moved = displacement[bond.neighbor * dimension + axis]
                        - displacement[point * dimension + axis];
                    squared += (reference + moved).powi(2);
                    change += moved * (2.0 * reference + moved);
                }
                let stretch = change / (bond.length * (bond.length + squared.sqrt()));
                let pair = [point, bond.neighbor].map(|place| order.host[place] as usize);
                visit(pair, stretch, bonds.integrity(bond.slot));
            }
        }
        Ok(())
    }
}
