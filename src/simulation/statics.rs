//! What equilibria share: loads and displacements along the way to them, bonds that break on it, and their acceptance.

use super::Simulation;
use super::drive::stopped_by_law;
use super::setup::Built;
use crate::conditions::Conditions;
use crate::damage::BondState;
use crate::error::{Error, Result};
use crate::memory;
use crate::plan::Plan;
use crate::solver::balance::{Balance, PURPOSE, Under};
use crate::solver::newton_krylov::{Ended, Reason};
use crate::state::{Settled, State};

/// From the last equilibrium to the conditions as they are: what is constant grows linearly with the share of the way,
/// tables and functions are asked along the time.
#[derive(Debug)]
pub(super) struct Way {
    pub(super) start: f64,
    pub(super) end: f64,
    /// Body force at its beginning, without what varies.
    load: Vec<f64>,
    /// Displacement at its beginning.
    displacement: Vec<f64>,
}

/// What a search for equilibrium has done.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StaticsReport {
    /// Load steps, or equilibria, that were reached.
    pub steps: u64,
    /// Load steps that failed and were cut.
    pub cuts: u64,
    /// Linear systems solved, or steps of relaxation.
    pub iterations: u64,
    /// Forces evaluated.
    pub evaluations: u64,
    /// Bonds broken.
    pub broken_bonds: u64,
    /// Share of the way that was gone.
    pub share: f64,
    /// Relative residuals, one an iteration, those of load steps that failed included.
    pub residuals: Vec<f64>,
    /// Of relaxation: energy of its motion over the largest that it had, one a step.
    pub energies: Vec<f64>,
    /// Elastic energy at the end.
    pub elastic: f64,
    /// Work of loads and constraints on the way.
    pub external_work: f64,
    /// Time at the end.
    pub time: f64,
}

/// What acts at a place of the way.
#[derive(Debug)]
pub(super) struct Acting {
    pub(super) time: f64,
    /// Components whose displacement is prescribed, and all displacements with those set.
    pub(super) held: Vec<bool>,
    pub(super) displacement: Vec<f64>,
    /// All body forces.
    pub(super) load: Vec<f64>,
}

/// A search for the equilibrium of what acts. What it finds is not yet the state; forces stand in the next one.
pub(super) struct Search {
    acting: Acting,
    bonds: BondState,
    dissipated: Vec<f64>,
    /// Bonds that it has broken.
    pub(super) broken: u64,
    displacement: Vec<f64>,
    /// Displacement at the last balance of forces.
    before: Vec<f64>,
    /// What held components are still to be moved by.
    push: Option<Vec<f64>>,
    /// How often bonds may still break.
    breaks: u64,
    /// Size of the forces at its beginning, once it is known.
    scale: Option<f64>,
}

/// Where a search stands.
pub(super) enum Standing {
    /// The balancer has more to do, or bonds have broken.
    OnItsWay,
    Reached,
    Failed(Reason),
}

impl Way {
    pub(super) fn new(simulation: &mut Simulation, end: f64) -> Result<Self> {
        simulation.conditions.check_at_rest()?;
        let dimension = simulation.points.dimension();
        let Simulation { state, conditions, .. } = simulation;
        let displacement = memory::copied(&state.current.displacement, PURPOSE)?;
        let mut way = Self { start: state.time, end, load: Vec::new(), displacement };
        way.load = match &state.settled {
            Some(settled) if settled.steps == state.steps => {
                let mut load = memory::copied(&settled.load, PURPOSE)?;
                if way.takes_time() {
                    let mut varying = memory::filled(0.0, load.len(), PURPOSE)?;
                    conditions.add_loads(state.time, dimension, &mut varying, Some(true))?;
                    load.iter_mut().zip(&varying).for_each(|(load, varying)| *load -= varying);
                }
                load
            }
            // Steps have borne the loads that there are.
            _ if state.steps > 0 => way.constant_loads(conditions, state, dimension)?,
            _ => memory::filled(0.0, way.displacement.len(), PURPOSE)?,
        };
        Ok(way)
    }

    fn takes_time(&self) -> bool {
        self.end > self.start
    }

    /// Body forces that grow with the share of the way.
    fn constant_loads(
        &self,
        conditions: &mut Conditions,
        state: &State,
        dimension: usize,
    ) -> Result<Vec<f64>> {
        let mut load = match &state.host_load {
            Some(values) => memory::copied(values, PURPOSE)?,
            None => memory::filled(0.0, self.displacement.len(), PURPOSE)?,
        };
        let which = if self.takes_time() { Some(false) } else { None };
        conditions.add_loads(self.end, dimension, &mut load, which)?;
        Ok(load)
    }

    /// What acts at a share of the way; displacements go on from those of the state.
    pub(super) fn at(&self, simulation: &mut Simulation, share: f64) -> Result<Acting> {
        let dimension = simulation.points.dimension();
        let Simulation { state, conditions, .. } = simulation;
        let time =
            if share == 1.0 { self.end } else { self.start + share * (self.end - self.start) };
        let mut load = self.constant_loads(conditions, state, dimension)?;
        for (load, before) in load.iter_mut().zip(&self.load) {
            *load = if share == 1.0 { *load } else { before + share * (*load - before) };
        }
        if self.takes_time() {
            conditions.add_loads(time, dimension, &mut load, Some(true))?;
        }
        conditions.ask_motion(time, 0.0)?;
        let mut held = memory::filled(false, load.len(), PURPOSE)?;
        let mut displacement = memory::copied(&state.current.displacement, PURPOSE)?;
        conditions.for_each_ruled(dimension, |ruled| {
            let component = ruled.component;
            held[component] = true;
            let whole = share == 1.0 || (ruled.varies && self.takes_time());
            displacement[component] = if whole {
                ruled.value
            } else {
                let before = self.displacement[component];
                before + share * (ruled.value - before)
            };
        });
        Ok(Acting { time, held, displacement, load })
    }
}

/// What brings a body to equilibrium: moves a displacement, its held components first by a push, and is told of the
/// size of the forces at the beginning. `None` where it has more to do.
pub(super) type Balancer<'a> =
    dyn FnMut(&mut Balance<'_>, &mut [f64], Option<&[f64]>, f64) -> Result<Option<Ended>> + 'a;

impl Simulation {
    /// Begins a search for an equilibrium, in which bonds may break so many times; the state stays as it is.
    pub(super) fn start_search(&self, acting: Acting, breaks: u64) -> Result<Search> {
        let Built { bonds, dissipated, .. } = self.built()?;
        let current = &self.state.current;
        let mut push = memory::copied(&acting.displacement, PURPOSE)?;
        push.iter_mut().zip(&current.displacement).for_each(|(push, was)| *push -= was);
        Ok(Search {
            acting,
            bonds: bonds.try_clone()?,
            dissipated: memory::copied(dissipated, PURPOSE)?,
            broken: 0,
            displacement: memory::copied(&current.displacement, PURPOSE)?,
            before: memory::copied(&current.displacement, PURPOSE)?,
            push: push.iter().any(|&component| component != 0.0).then_some(push),
            breaks,
            scale: None,
        })
    }

    /// Lets the balancer go on. Where it has balanced the forces, the bonds that they would break are broken, and there is a
    /// balance to be looked for again, until none break.
    pub(super) fn continue_search(
        &mut self,
        search: &mut Search,
        balancer: &mut Balancer<'_>,
        evaluations: &mut u64,
    ) -> Result<Standing> {
        let Self { state, built, .. } = self;
        let Some(built) = built.get_mut() else { return Ok(Standing::Failed(Reason::TooMany)) };
        let Built { workers, plan, aside, scratch, .. } = built;
        let Search { acting, bonds, dissipated, displacement, before, push, scale, .. } = search;
        let loads = state.settled.as_ref().map(|settled| &settled.load[..]);
        let under = Under { held: &acting.held, load: &acting.load };
        let mut balance = Balance::new(plan, workers, bonds, scratch, &under)?;
        let scale = *scale.get_or_insert_with(|| {
            let before = loads.map_or(0.0, |loads| balance.load_size(loads));
            let holding = holding(plan, &acting.held, &state.current.force, &acting.load);
            balance.load_size(&acting.load).max(before).max(holding)
        });
        let ended = balancer(&mut balance, displacement, push.as_deref(), scale);
        *evaluations += balance.evaluations;
        match ended? {
            None => return Ok(Standing::OnItsWay),
            Some(Ended::Failed(reason)) => return Ok(Standing::Failed(reason)),
            Some(Ended::Converged { .. }) => *push = None,
        }
        // The forces of the equilibrium, and what they break.
        let scene = plan.scene(workers, bonds, displacement);
        let breaking = plan
            .rule
            .as_ref()
            .map(|rule| aside.breaking(workers, rule, (bonds, dissipated), Some(&before[..])));
        *evaluations += 1;
        let failed = plan.formulation.force(&scene, scratch, &mut state.next.force, breaking);
        if let Some(error) = stopped_by_law(plan) {
            return Err(error);
        }
        if let Some(place) = failed {
            return Ok(Standing::Failed(Reason::NotFinite(place)));
        }
        let ends = plan.rule.as_ref().map(|_| bonds.count());
        let Some(ends) = ends.filter(|_| aside.accept(bonds, dissipated)) else {
            bonds.keep_records(scratch);
            return Ok(Standing::Reached);
        };
        search.broken += (ends - bonds.count()) / 2;
        before.copy_from_slice(displacement);
        if search.breaks == 0 {
            return Ok(Standing::Failed(Reason::Breaking));
        }
        search.breaks -= 1;
        Ok(Standing::OnItsWay)
    }

    /// Makes an equilibrium the state, as a completed step.
    pub(super) fn accept_equilibrium(&mut self, search: Search) -> Result<()> {
        let Search { acting, bonds: found_bonds, dissipated: lost, broken, displacement, .. } =
            search;
        self.state.next.displacement.copy_from_slice(&displacement);
        let work = self.work_of_equilibrium(&acting)?;
        let kinetic = if self.state.ledger.open { self.resting_energy()? } else { 0.0 };
        let Self { state, built, conditions, .. } = self;
        let Some(Built { plan, bonds, aside, dissipated, stable_step, .. }) = built.get_mut()
        else {
            return Ok(());
        };
        if let Some(known) = stable_step {
            known.is_stale |= broken > 0;
        }
        let host = state.host_load.as_deref();
        let next = &mut state.next;
        for (component, load) in next.load.iter_mut().enumerate() {
            *load = acting.load[component] - host.map_or(0.0, |host| host[component]);
        }
        next.velocity.fill(0.0);
        for (component, acceleration) in next.acceleration.iter_mut().enumerate() {
            let density = plan.density.at(component / plan.dimension);
            *acceleration = (next.force[component] + acting.load[component]) / density;
        }
        conditions.for_each_ruled(plan.dimension, |ruled| {
            next.acceleration[ruled.component] = 0.0;
        });
        *bonds = found_bonds;
        *dissipated = lost;
        aside.forget();
        std::mem::swap(&mut state.current, &mut state.next);
        state.ledger.work += work;
        state.ledger.given -= kinetic;
        state.time = acting.time;
        state.steps += 1;
        (state.pulled, state.force_fresh, state.loads_fresh) = (true, true, true);
        state.settled = Some(Settled { load: acting.load, steps: state.steps });
        Ok(())
    }

    /// Kinetic energy that comes to rest.
    fn resting_energy(&self) -> Result<f64> {
        if self.state.current.velocity.iter().all(|&velocity| velocity == 0.0) {
            return Ok(0.0);
        }
        self.kinetic()
    }

    /// Work of loads and constraints from the state to an equilibrium, by the trapezoid.
    fn work_of_equilibrium(&self, acting: &Acting) -> Result<f64> {
        let Self { state, .. } = self;
        let plan = &self.built()?.plan;
        let (current, next, dimension) = (&state.current, &state.next, plan.dimension);
        let before = state.settled.as_ref().map(|settled| &settled.load[..]);
        self.sum_over_points(|point| {
            let mut work = 0.0;
            for component in point * dimension..(point + 1) * dimension {
                let moved = next.displacement[component] - current.displacement[component];
                let was = before.map_or(0.0, |before| before[component]);
                work += if acting.held[component] {
                    -0.5 * (current.force[component] + next.force[component]) * moved
                } else {
                    0.5 * (was + acting.load[component]) * moved
                };
            }
            plan.places()[point][3] * work
        })
    }
}

impl Simulation {
    /// The error of a search that has failed.
    pub(super) fn not_converged(&self, reason: &Reason, share: f64, residuals: &[f64]) -> Error {
        let host = &self.points.order().host;
        let last = &residuals[residuals.len().saturating_sub(6)..];
        let mut text = String::new();
        for residual in last {
            text += &format!("{}{residual:.2e}", if text.is_empty() { "" } else { ", " });
        }
        if text.is_empty() {
            text = "none".into();
        }
        Error::Convergence(format!(
            "no equilibrium was found beyond {share:.4} of the way, which the state is left at: {}; last relative \
             residuals: {text}; more supports, more and smaller load steps, or relax may help",
            told(reason, host)
        ))
    }
}

/// The size of what holds held components against these forces.
fn holding(plan: &Plan, held: &[bool], force: &[f64], load: &[f64]) -> f64 {
    let of = |(component, &held): (usize, &bool)| {
        if !held {
            return 0.0;
        }
        let volume = plan.places()[component / plan.dimension][3];
        (volume * (force[component] + load[component])).powi(2)
    };
    held.iter().enumerate().map(of).sum::<f64>().sqrt()
}

/// The reason in words.
pub(super) fn told(reason: &Reason, host: &[u32]) -> String {
    match reason {
        Reason::NotFinite(place) => {
            format!("the force on point {} is not finite", host[*place])
        }
        Reason::Stuck { indefinite: true } => {
            "the stiffness has a direction without resistance (loose parts, a \
             mechanism, buckling, or softening), along which nothing balances the forces"
                .into()
        }
        Reason::Stuck { indefinite: false } => {
            "no step along Newton's direction brings the forces closer to balance".into()
        }
        Reason::TooMany => "as many iterations as were allowed have been made".into(),
        Reason::Diverged => "the motions of relaxation grow, whatever the masses".into(),
        Reason::Breaking => "bonds go on breaking, as often as was allowed".into(),
    }
}
