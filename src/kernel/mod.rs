//! The inner loops over bonds, eight at a time.

pub(crate) mod associated;
pub(crate) mod bond_based;
pub(crate) mod collocation;
pub(crate) mod elastic;
pub(crate) mod family;
pub(crate) mod fields;
pub(crate) mod gradient;
pub(crate) mod gradient_pull;
pub(crate) mod lattice;
pub(crate) mod ordinary_plastic;
pub(crate) mod ordinary_state_based;
pub(crate) mod quadrature;
pub(crate) mod simd;
