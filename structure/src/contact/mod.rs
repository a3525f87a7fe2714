//! Contact of bodies with each other, with themselves and with rigid walls. It knows no method: it takes
//! positions and velocities of particles and gives forces.
//!
//! | to understand | read |
//! |---|---|
//! | what may be chosen | `options`: `[structure.contact]` |
//! | what a body's outer surface is | `surface` |
//! | what a rigid wall is | `walls` |
//! | what may meet what, and which particles are near which surface | `pairing`, `search`, `distance` |
//! | the potential | `meeting` |
//! | forces, works and energies in the time step | `acting` |
//! | sticking and sliding | `friction` |
//!
//! A particle of a surface meets the surface of another body, the far parts of its own, or a wall, where
//! their distance `d` is less than `T`, the half thicknesses of both. The energy of that is
//! `½ k Σ_f c_f g_f² (1 + g_f²/T²)` with the depth `g_f = T − d_f` over the parts `f` of the surface that are
//! nearer than `T`: segments (triangles) count once, the points (edges) that they share with the opposite
//! sign, so that on a surface that is flat or convex the sum is the term of the least distance, and in a
//! hollow both of its sides count (inclusion and exclusion, as Li et al. 2023, "Convergent incremental
//! potential contact", count nodes and edges). Each distance to a convex part has a continuous gradient, and
//! so has the sum: across joints, edges and corners.

mod acting;
mod distance;
mod friction;
mod meeting;
pub(crate) mod options;
mod pairing;
mod search;
mod surface;
mod walls;

pub(crate) use acting::Power;
pub(crate) use meeting::Passed;
pub use options::{ContactOptions, ContactSetup};
pub(crate) use pairing::Contact;
pub use walls::{Wall, WallShape};
