//! Equilibria: what is solved and relaxed, against solutions that are known.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![allow(clippy::disallowed_methods, clippy::disallowed_macros)]

mod all_forms;
mod bars;
mod breaking;
mod cantilever;
mod conditions;
mod contour;
mod hyperelastic;
mod preconditioned;
mod surface;
mod traction_bar;
mod uniform_tension;
mod watched;
