//! What a structure is made of: its particles, their cells, points between them.

pub mod cells;
pub mod filling;
pub mod point;
