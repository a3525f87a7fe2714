//! The free surface: which particles are on it, which pressure they have, and where more of it opens.

pub mod detection;
pub mod surface_offset;
pub mod tearing;
