//! The examples give what mechanics says, and the same in C, Fortran and Rust.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../fortran_interface/compilers.rs"]
#[allow(dead_code)]
mod compilers;

mod beam;
mod bend;
mod checkerboard;
mod hyperelastic_bar;
mod own_material;
mod patch;
mod specimen;
mod traction_bar;
mod twins;
mod twist;
mod wave;
