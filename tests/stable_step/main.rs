//! The stable step against the true limit, what Verlet keeps at it, what it costs, and runs that follow it.
#![allow(clippy::disallowed_methods, clippy::disallowed_macros, clippy::unwrap_used)]

mod advancing;
mod body;
mod costs;
mod kept;
mod limits;
