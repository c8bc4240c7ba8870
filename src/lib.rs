//! Perion: the peridynamics core that simulation codes link.
//!
//! Peridynamics models solids as points that pull on every neighbour within a horizon, so that cracks
//! need no special treatment. A host hands over a cloud of points, chooses a formulation and a
//! material, and lets Perion step, or asks only for forces and steps itself.
//!
//! ```
//! use perion::{Field, Model, Points, Quantity, Simulation};
//!
//! let spacing = 0.5e-3;
//! let mut plate = Points::block(2, &[0.0, -0.01], &[0.05, 0.01], spacing)?;
//! plate.add_set_box("upper", &[0.0, 0.01 - spacing], &[0.05, 0.01])?;
//! plate.add_set_box("lower", &[0.0, -0.01], &[0.05, spacing - 0.01])?;
//!
//! let mut glass = Model::new("bond_based")?;
//! glass.set("density", 2440.0)?;
//! glass.set("youngs_modulus", 32e9)?;
//! glass.set("horizon", 3.015 * spacing)?;
//! glass.set("critical_energy_release_rate", 0.75)?;
//!
//! let mut test = Simulation::new(&plate, &glass)?;
//! test.break_crossing(&[-0.001, 0.0, 0.025, 0.0])?;
//! test.prescribe("upper", Quantity::Velocity, 1, 0.5)?;
//! test.prescribe("lower", Quantity::Velocity, 1, -0.5)?;
//! let time_step = test.stable_time_step()?;
//! test.step(time_step, 20)?;
//! println!("force on the upper edge: {} N", test.sum(Field::Reaction, Some("upper"))?[1]);
//! # Ok::<(), perion::Error>(())
//! ```
//!
//! # What lives where
//! [`Points`] and [`Model`] are what the host gives. `families` and `plan` make of them what the scene
//! needs, `formulation`, `damage` and `kernel` turn displacements into forces, `solver` moves the
//! state on, and [`Simulation`] ties them together. `ffi` is the C interface, `output` writes files,
//! `memory` and `workers` are what all of them stand on.

#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_macros))]

mod conditions;
mod damage;
mod error;
mod families;
#[doc(hidden)]
pub mod ffi;
mod formulation;
mod kernel;
mod material;
mod memory;
mod model;
mod output;
mod plan;
mod points;
mod simulation;
mod solver;
mod sort;
mod state;
mod suggest;
mod tensor;
mod workers;

pub use conditions::{ConditionFunction, Quantity};
pub use error::{Error, Result};
pub use formulation::{FORMULATIONS, FormulationEntry, Operator, Skips};
pub use kernel::simd::SimdLevel;
pub use material::MaterialBatch;
pub use model::{Elastic, Influence, KEYS, Key, Kind, Model, Plane};
pub use points::Points;
pub use simulation::{
    AdvanceOptions, Advancing, Energy, Field, Health, Log, LogLevel, Memory, PointReport, Progress,
    RelaxOptions, Report, Simulation, SolveOptions, Solving, StaticsReport, Stepping,
};
pub use solver::newton_krylov::Krylov;
pub use solver::newton_krylov::preconditioner::Preconditioning;
