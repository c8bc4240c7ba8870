//! Solvers: what moves the state on.

pub(crate) mod balance;
pub(crate) mod newton_krylov;
pub(crate) mod relaxation;
pub(crate) mod space;
pub(crate) mod time_step;
pub(crate) mod verlet;
