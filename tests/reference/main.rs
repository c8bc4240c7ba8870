//! Perion held against numbers of an implementation that shares no line with it: forces, energies,
//! damage, 60 steps of velocity Verlet, material constants, influence functions and time steps. The
//! numbers lie in `tests/data`.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

mod constants;
mod convergence;
mod data;
mod energy_release;
mod formulations;
mod influence;
mod invariants;
mod kinematics;
mod mechanics;
mod memory;
mod motion;
mod operators;
mod order;
mod thickness;
mod time_step;
