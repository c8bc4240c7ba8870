//! Simulations in C.

pub mod advance;
pub mod balance;
pub mod bonds;
pub mod conditions;
pub mod drive;
pub mod fields;
pub mod files;
pub mod operators;
pub mod setup;
pub mod views;
