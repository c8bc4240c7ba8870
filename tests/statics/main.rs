//! Equilibria: what is solved and relaxed, against solutions that are known.

mod bars;
mod traction_bar;
