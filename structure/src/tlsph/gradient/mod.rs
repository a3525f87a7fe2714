//! Discrete gradients in the reference configuration, one file each, behind [`crate::tlsph::stencil::PairOperator`].

pub(crate) mod first_order;
pub(crate) mod quadratic;
