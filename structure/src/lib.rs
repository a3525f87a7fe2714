//! Total-Lagrangian SPH structure (TLSPH): Eqs. (33)–(45) of Salehizadeh and Shafiei 2022 ("the paper"), in two and three dimensions.
//!
//! Describe bodies, clamps and loads in a [`Setup`], make a [`Structure`] of it, and [`Structure::advance`] a [`State`] over
//! one time window. The structure itself never changes: the same state and load give the same result, to the bit,
//! whatever the number of threads.
//!
//! To read the method, start at [`time_step`] (the Runge–Kutta step), then `kernels` (stresses and accelerations), `gradient` (the
//! discrete gradients) and [`material`] (the laws).
//!
//! | symbol | meaning | unit | shape |
//! |---|---|---|---|
//! | `X`, `x`, `U = x − X` | reference position, position, displacement | m | `Vector<D>` a particle |
//! | `u` | velocity | m/s | `Vector<D>` a particle |
//! | `V` | reference volume | m³ | a particle |
//! | `ρ_s` | reference density | kg/m³ | a body |
//! | `F = I + L` | deformation gradient, entry `(i, J)` spatial and material | – | `Matrix<D>` |
//! | `J = det F` | volume ratio | – | scalar |
//! | `E`, `ε` | Green–Lagrange and Almansi strain | – | `Matrix<D>` |
//! | `P`, `σ` | first Piola–Kirchhoff and Cauchy stress | Pa | `Matrix<D>` |
//! | `K_a` | moment matrix of the kernel gradient | – | `Matrix<D>` |
//! | `h` | smoothing length: a ratio times the mean spacing | m | a body |
//! | `∇p_s` | the fluid's load: acceleration `−∇p_s/ρ_s` | Pa/m | `Vector<D>` an interface particle |
//!
//! In two dimensions one metre of depth is meant: volumes are in m³, forces in N.

mod error;
mod external;
mod field;
mod ganzenmuller2015;
mod gradient;
mod kernels;
mod lanes;
mod load;
pub mod material;
mod numbering;
mod point;
mod setup;
mod stability;
mod state;
mod stencil;
mod structure;
pub mod time_step;

pub use error::{Error, ErrorKind, SetupError};
pub use load::{DeadLoad, History, Load};
pub use material::{Law, Material, Plane};
pub use point::MaterialPoint;
pub use setup::{Body, Gradient, Setup, Side};
pub use state::{Derived, Energy, Report, State};
pub use structure::Structure;
