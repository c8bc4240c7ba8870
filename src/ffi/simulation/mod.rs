//! Simulations in C.

pub mod advance;
pub mod balance;
pub mod bonds;
pub mod conditions;
pub mod drive;
pub mod fields;
pub mod files;
pub mod operators;
pub mod report;
pub mod setup;
pub mod statics;
pub mod views;
