//! The structure as a library: operators, motion, statics and coarse benchmark cases.

mod cases;
mod clamps;
mod contact;
mod motion;
mod operators;
mod probes;
mod stability;
mod statics;
mod stretch;
