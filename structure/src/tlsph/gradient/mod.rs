//! Discrete gradients in the reference configuration, one file each, behind `stencil::PairOperator`.

pub(crate) mod first_order;
pub(crate) mod quadratic;
