//! Properties that hold for any body: momentum, energy, bits, conditions, and what failures leave.
//!
//! Bodies come from `proptest`: clouds and lattices in 2D and 3D with unequal volumes, horizons and
//! materials. The seed is fixed, so that every run sees the same bodies.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

mod bits;
mod bonds;
mod conditions;
mod cracks;
mod energy;
mod failure;
mod forces;
mod formulations;
mod hosts;
mod isolated;
mod levels;
mod random;
mod scene;
mod skips;
mod stability;
mod tearing;
