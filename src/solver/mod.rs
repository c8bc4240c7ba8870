//! Solvers: what moves the state on.

pub(crate) mod time_step;
pub(crate) mod verlet;
