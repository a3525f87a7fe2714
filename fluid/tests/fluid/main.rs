//! Tests of the fluid from outside, in one binary: operators by hand and by property, boundaries, whole
//! steps.

mod accounts;
mod boundaries;
mod direct_solve;
mod models;
mod multigrid;
mod operators;
mod order;
mod position_projection;
mod start;
mod still_water;
mod support;
mod surface;
mod tearing;
mod time_step;
mod viscosity;
mod walls;
