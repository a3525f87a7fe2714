//! The coupler on points and partners that are known.

mod mapping;
mod recording;
mod states;
