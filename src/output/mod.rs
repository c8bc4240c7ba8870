//! Files that ParaView reads: a cloud of points at one time ([`vtu`]) and a series of them ([`series`]).

pub(crate) mod series;
pub(crate) mod vtu;
