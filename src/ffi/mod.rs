//! The C interface: each function a guard, the host's pointers turned into references, and a few lines
//! of safe Rust. `include/perion.h` is generated from here.
//!
//! Every function promises C the same: pointers are NULL or lead to as much as the counts beside them
//! say, handles came from a `create` and are not yet destroyed, text ends in NUL, and nothing else
//! writes to what is lent for the length of the call. That is the safety contract of all of them.
#![allow(clippy::missing_safety_doc)]
// Documentation here is for C, where brackets are the lengths of arrays.
#![allow(rustdoc::broken_intra_doc_links, rustdoc::invalid_html_tags)]

mod arguments;
mod float_environment;
mod guard;
mod handle;
mod last_error;
pub mod model;
pub mod points;
pub mod simulation;
mod sized;
pub mod status;
mod texts;
pub mod version;

pub use last_error::perion_last_error;
