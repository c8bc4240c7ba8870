//! Solvers: how a state moves on.

pub(crate) mod verlet;
