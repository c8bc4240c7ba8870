//! Points from files: what independent programs write is read right to 1e-12, files that are not what
//! they should be are refused with their line, and no change to a file makes a reader fail otherwise.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

mod bad;
#[path = "../common/mod.rs"]
mod common;
mod independent;
mod mutated;
mod written;
