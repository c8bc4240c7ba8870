//! The C interface: each function a guard, the host's pointers turned into references, and a few lines
//! of safe Rust. `include/perion.h` is generated from here.

mod arguments;
mod float_environment;
mod guard;
mod handle;
mod last_error;
mod status;
