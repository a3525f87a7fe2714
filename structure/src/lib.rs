//! Elastic solids of particles. The method is total-Lagrangian SPH (TLSPH): Eqs. (33)–(45) of Salehizadeh and
//! Shafiei 2022 ("the paper"), in two and three dimensions.
//!
//! Describe bodies, clamps and loads in a [`Setup`], make a [`TotalLagrangian`] of it, and
//! [`advance`](Solid::advance) a [`State`] over one time window. The solid itself never changes: the same
//! state and load give the same result, to the bit, whatever the number of threads.
//!
//! What any solid of particles meets stands apart from the method that moves it:
//!
//! | to understand | read |
//! |---|---|
//! | what a structure is made of | [`bodies`]: particles, their cells, points between them; [`Setup`] |
//! | how it answers strain | [`materials`]: the laws, one file each |
//! | how its clamps move | [`ClampMotion`] |
//! | what acts on it | `loads`: the fluid's load, dead loads; `external`: the accelerations that they give |
//! | what it meets | `contact`: bodies, itself and walls, with friction |
//! | what changes in time | [`State`], and its bytes for a restart |
//! | what a method gives | [`solid`]: the one trait that a second method implements |
//! | the total-Lagrangian method | [`tlsph`], at its [`step`](tlsph::step) |
//! | what is read of it | [`probes`] |
//! | case, messages, files | [`participant`], which alone knows them |
//!
//! How right the method is and what it costs, resolution by resolution, and where it departs from the paper:
//! `docs/structure.md`.
//!
//! | symbol | meaning | unit | shape |
//! |---|---|---|---|
//! | `X`, `x`, `U = x − X` | reference position, position, displacement | m | `Vector<D>` per particle |
//! | `u` | velocity | m/s | `Vector<D>` per particle |
//! | `V` | reference volume | m³ | per particle |
//! | `ρ_s` | reference density | kg/m³ | per body |
//! | `F = I + L` | deformation gradient, entry `(i, J)` spatial and material | – | `Matrix<D>` |
//! | `J = det F` | volume ratio | – | scalar |
//! | `E`, `ε` | Green–Lagrange and Almansi strain | – | `Matrix<D>` |
//! | `P`, `σ` | first Piola–Kirchhoff and Cauchy stress | Pa | `Matrix<D>` |
//! | `K_a` | moment matrix of the kernel gradient | – | `Matrix<D>` |
//! | `h` | smoothing length: a ratio times the mean spacing | m | per body |
//! | `∇p_s` | the fluid's load: acceleration `−∇p_s/ρ_s` | Pa/m | `Vector<D>` per interface particle |
//!
//! In two dimensions one metre of depth is meant: volumes are in m³, forces in N.

pub mod bodies;
mod contact;
mod error;
mod external;
mod lanes;
mod loads;
pub mod materials;
mod options;
// Left out of unit tests, none of which needs it: it compiles every method for every dimension once more.
#[cfg(not(test))]
pub mod participant;
mod particles;
pub mod probes;
mod setup;
pub mod solid;
mod state;
pub mod tlsph;

pub use bodies::cells::{Cell, relax_to_centroids, voronoi_cells};
pub use bodies::point::MaterialPoint;
pub use bodies::{Body, Side};
pub use contact::{ContactOptions, ContactSetup, Wall, WallShape};
pub use error::{Error, ErrorKind, SetupError};
pub use loads::{DeadLoad, History, Load};
pub use materials::{Constants, Law, Material, Plane};
pub use options::{Gradient, Options};
pub use particles::Particles;
pub use setup::{ClampMotion, Setup};
pub use solid::Solid;
pub use state::{Derived, Energy, Report, Stability, State, Stick};
pub use tlsph::total_lagrangian::TotalLagrangian;
