//! A simulation: a body, its state, what acts on it, and what it can tell.
//!
//! Needs points and models, of which it keeps copies. Families are built once, when the first call
//! needs them; until then set-up calls are kept as requests.

mod advance;
mod balance;
mod drive;
mod fields;
mod files;
mod kinematics;
mod operators;
mod relax;
mod setup;
mod solve;
mod stable_step;
mod statics;
mod traction;
mod values;

use std::sync::{Mutex, OnceLock};

use crate::conditions::{ConditionFunction, Conditions, Quantity, Source};
use crate::error::{Result, argument, state};
use crate::formulation::Skips;
use crate::kernel::simd::SimdLevel;
use crate::memory;
use crate::model::Model;
use crate::output::series::Series;
use crate::plan::SceneRequests;
use crate::points::Points;
use crate::state::State;
use crate::workers::{MOST_THREADS, Workers};
pub use advance::{AdvanceOptions, Advancing, Report};
pub use balance::{Energy, Health, Memory, PointReport};
pub(crate) use drive::stopped;
pub use drive::{Progress, Stepping};
pub use fields::Field;
pub use relax::RelaxOptions;
use setup::{BondRequest, Built};
pub use solve::{SolveOptions, Solving};
pub use statics::StaticsReport;

/// How much a message to the host's log matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogLevel {
    /// Something the host should look at.
    Warning,
    /// Something that helps to follow what happens.
    Information,
}

/// Takes messages of the library.
pub type Log = Box<dyn Fn(LogLevel, &str) + Send + Sync>;

/// A body of points that moves under a model.
///
/// ```
/// use perion::{Field, Model, Points, Simulation};
/// let points = Points::block(3, &[0.0; 3], &[0.4, 0.2, 0.2], 0.05)?;
/// let mut steel = Model::new("bond_based")?;
/// steel.set("density", 7800.0)?;
/// steel.set("youngs_modulus", 210e9)?;
/// steel.set("horizon", 3.015 * 0.05)?;
/// let mut bar = Simulation::new(&points, &steel)?;
/// let mut velocity = vec![0.0; 3 * points.count()];
/// velocity[0] = 1.0;
/// bar.set(Field::Velocity, &velocity)?;
/// let time_step = 0.8 * bar.stable_time_step()?;
/// bar.step(time_step, 10)?;
/// assert_eq!(bar.step_count(), 10);
/// assert!(bar.energy()?.elastic > 0.0);
/// # Ok::<(), perion::Error>(())
/// ```
pub struct Simulation {
    points: Points,
    models: Vec<Model>,
    /// Number of each point's model by inner place; empty while there is only one.
    model_of: Vec<u16>,
    threads: usize,
    simd: SimdLevel,
    scene_requests: SceneRequests,
    bond_requests: Vec<BondRequest>,
    built: OnceLock<Built>,
    /// Held while the families are built, since calls that only read may come at once.
    building: Mutex<()>,
    conditions: Conditions,
    /// Areas of the surface along sets, as the host gave them.
    areas: Vec<(String, Vec<f64>)>,
    state: State,
    series: Mutex<Series>,
    log: Option<Log>,
}

impl Simulation {
    /// Brings points and a model together; both are copied.
    ///
    /// # Errors
    /// `Argument` when the model lacks what it needs or holds what does not fit together or to the
    /// dimension, or the environment's `PERION_SIMD` names no level or `PERION_NUM_THREADS` no number of threads; `Memory`.
    pub fn new(points: &Points, model: &Model) -> Result<Self> {
        model.check(points.dimension(), points.horizons().is_some())?;
        let points = points.try_clone()?;
        let mut models = memory::reserved(1, "models")?;
        models.push(model.clone());
        Ok(Self {
            state: State::new(points.count(), points.dimension())?,
            points,
            models,
            model_of: Vec::new(),
            threads: Workers::default_threads()?,
            simd: SimdLevel::of_environment()?,
            scene_requests: SceneRequests::default(),
            bond_requests: Vec::new(),
            built: OnceLock::new(),
            building: Mutex::new(()),
            conditions: Conditions::default(),
            areas: Vec::new(),
            series: Mutex::new(Series::default()),
            log: None,
        })
    }

    /// Sets the number of threads; results do not depend on it. The default is
    /// `PERION_NUM_THREADS`, else `OMP_NUM_THREADS`, else all cores.
    ///
    /// # Errors
    /// `Argument` for a number that is not between 1 and 4096; `State` when they cannot be started.
    pub fn set_threads(&mut self, threads: usize) -> Result<()> {
        if !(1..=MOST_THREADS).contains(&threads) {
            return argument(format!("'threads' is {threads}; it must be 1 to {MOST_THREADS}"));
        }
        if self.built.get().is_some() {
            let workers = self.start_workers(threads)?;
            self.built_mut()?.workers = workers;
        }
        self.threads = threads;
        Ok(())
    }

    /// Sets the instructions that the inner loops run on. The default is the widest level of the machine, no wider
    /// than `PERION_SIMD` says: `baseline`, `avx2` or `avx512`.
    ///
    /// # Errors
    /// `Unsupported` for a level that the machine does not have; `State` after set-up.
    pub fn set_simd(&mut self, level: SimdLevel) -> Result<()> {
        if self.built.get().is_some() {
            return refuse_after_setup("the choice of instructions");
        }
        self.simd = level.if_available()?;
        Ok(())
    }

    /// Whether points on a common grid are computed together as a lattice, which is faster; on by default. Results
    /// agree to rounding.
    ///
    /// # Errors
    /// `State` after set-up.
    pub fn set_lattices(&mut self, look_for: bool) -> Result<()> {
        if self.built.get().is_some() {
            return refuse_after_setup("the choice of lattices");
        }
        self.scene_requests.lattices = look_for;
        Ok(())
    }

    /// Whether bonds are computed several at a time wherever they can be; on by default. Without, state-based formulations go
    /// over single bonds, ten to forty times slower, and no lattices are looked for: for comparison. Results agree to
    /// rounding.
    ///
    /// # Errors
    /// `State` after set-up.
    pub fn set_lanes(&mut self, several: bool) -> Result<()> {
        if self.built.get().is_some() {
            return refuse_after_setup("the choice of single bonds");
        }
        self.scene_requests.lanes = several;
        Ok(())
    }

    /// What sweeps leave out where it changes nothing; all of it by default. No choice changes a bit of the results.
    ///
    /// # Errors
    /// `State` after set-up.
    pub fn set_skips(&mut self, skips: Skips) -> Result<()> {
        if self.built.get().is_some() {
            return refuse_after_setup("the choice of what is left out");
        }
        self.scene_requests.skips = skips;
        Ok(())
    }

    /// The points, as they were given.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// Sends messages of the library to the host; silent without.
    pub fn set_log(&mut self, log: Option<Log>) {
        self.log = log;
    }

    fn tell(&self, level: LogLevel, text: &str) {
        if let Some(log) = &self.log {
            log(level, text);
        }
    }

    /// Time of the last completed step.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Sets the clock; tables and functions are asked along it.
    ///
    /// # Errors
    /// `Argument` for a time that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<()> {
        if !time.is_finite() {
            return argument(format!("'time' is {time}; it must be finite"));
        }
        self.state.time = time;
        self.state.loads_fresh = false;
        Ok(())
    }

    /// Number of completed steps, commits included.
    pub fn step_count(&self) -> u64 {
        self.state.steps
    }

    /// Prescribes a value on a set, along one axis, from the next step on.
    ///
    /// # Errors
    /// `Argument` for an unknown set, an axis out of range or a value that is not finite.
    pub fn prescribe(
        &mut self,
        set: &str,
        quantity: Quantity,
        axis: usize,
        value: f64,
    ) -> Result<()> {
        self.add_condition(set, quantity, axis, Source::Constant(value))
    }

    /// Prescribes values over increasing times: linear between, constant outside.
    ///
    /// # Errors
    /// As [`Simulation::prescribe`]; also for an empty table or times that do not increase.
    pub fn prescribe_table(
        &mut self,
        set: &str,
        quantity: Quantity,
        axis: usize,
        times: &[f64],
        values: &[f64],
    ) -> Result<()> {
        self.add_condition(set, quantity, axis, Source::table(times, values)?)
    }

    /// Prescribes a function of time and reference position. It is called on the calling thread: for
    /// displacements at the end of each step, for velocities also at its middle, for body forces
    /// also at the beginning of the first.
    ///
    /// # Errors
    /// As [`Simulation::prescribe`]. A function that breaks off ends a later step with
    /// `Interrupted`, one that gives a value that is not finite with `Numeric`.
    pub fn prescribe_function(
        &mut self,
        set: &str,
        quantity: Quantity,
        axis: usize,
        function: ConditionFunction,
    ) -> Result<()> {
        let source = Source::Function { function, positions: Vec::new() };
        self.add_condition(set, quantity, axis, source)
    }

    /// Prescribes one value per point of the set, in the set's order.
    ///
    /// # Errors
    /// As [`Simulation::prescribe`]; also when there is not one value per point.
    pub fn prescribe_values(
        &mut self,
        set: &str,
        quantity: Quantity,
        axis: usize,
        values: &[f64],
    ) -> Result<()> {
        self.points.check_set_size(set, values.len())?;
        let source = Source::Values(memory::copied(values, "a condition")?);
        self.add_condition(set, quantity, axis, source)
    }

    /// Ends what was prescribed on a set along an axis.
    ///
    /// # Errors
    /// `Argument` when nothing is.
    pub fn release(&mut self, set: &str, quantity: Quantity, axis: usize) -> Result<()> {
        self.conditions.release(&self.points, set, quantity, axis)?;
        self.state.loads_fresh = false;
        Ok(())
    }

    fn add_condition(
        &mut self,
        set: &str,
        quantity: Quantity,
        axis: usize,
        source: Source,
    ) -> Result<()> {
        Conditions::check(&self.points, set, axis, &source)?;
        if quantity.is_load() {
            self.state.make_room_for_loads()?;
        }
        self.conditions.prescribe(&self.points, set, quantity, axis, source)?;
        self.state.loads_fresh = false;
        Ok(())
    }
}

/// Checks a count against the number of values that a field of all points has.
fn check_length(given: usize, points: usize, components: usize) -> Result<()> {
    if given == points * components {
        return Ok(());
    }
    argument(format!(
        "'length' is {given}; the field has {components} numbers for each of {points} points, {} in all",
        points * components
    ))
}

/// Refuses what only makes sense before the families are built.
fn refuse_after_setup<T>(what: &str) -> Result<T> {
    state(format!(
        "{what} belongs to set-up, which ended with the first step, evaluation or derived field"
    ))
}
