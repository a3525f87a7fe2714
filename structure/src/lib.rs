//! Total-Lagrangian SPH structure (TLSPH): Eqs. (33)–(45) of Salehizadeh and Shafiei 2022 ("the paper"), in two and three dimensions.
//!
//! Describe bodies, clamps and loads in a [`Setup`], make a [`Structure`] of it, and [`Structure::advance`] a [`State`] over
//! one time window. The structure itself never changes: the same state and load give the same result, to the bit,
//! whatever the number of threads.
//!
//! Two discrete gradients ([`Gradient`]): the paper's, and a quadratic one (the default) that is right in bending with three to four
//! particles through the thickness, where the paper's is too soft. Beam under gravity (`L/T = 17.5`, `ν = 0.4`), tip deflection, reference
//! 65.42 mm: quadratic 64.8 / 65.1 / 65.7 mm with 3 / 4 / 6 layers; first order 98.5 mm with 4. Oscillating plate of the paper's section 3.1,
//! period `T c₀/L`, reference 72.75: quadratic 72.74 / 73.04 / 73.00 with 4 / 6 / 10 layers; first order 76.58 (paper 77.50) with 10, 74.05
//! (paper 74.80) with 20. Two layers lock, one cannot bend: the quadratic gradient refuses fewer than three. Particles off a lattice want
//! cells of their own ([`voronoi_cells`], [`Body::from_cells`]), best after [`relax_to_centroids`]; six layers, tip deflection: 10 % jitter
//! +3 to +6 % with the lattice's volumes, +1.3 to +2.2 % with cells, +0.5 % after one sweep; a lattice at 15° to the faces +28, +13, and
//! +2.8 % after three. Energy lost by the oscillating plate (St. Venant–Kirchhoff, 4 layers) in ten periods: 2.5e-3 at the stable step,
//! 4.5e-4 at a half, 1.7e-4 at 0.35 of it.
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

mod cells;
mod error;
mod external;
mod field;
pub mod filling;
mod ganzenmuller2015;
mod gradient;
mod kernels;
mod lanes;
mod load;
pub mod material;
mod numbering;
pub mod participant;
mod point;
mod setup;
mod stability;
mod state;
mod stencil;
mod structure;
pub mod time_step;

pub use cells::{Cell, relax_to_centroids, voronoi_cells};
pub use error::{Error, ErrorKind, SetupError};
pub use load::{DeadLoad, History, Load};
pub use material::{Law, Material, Plane};
pub use point::MaterialPoint;
pub use setup::{Body, Gradient, Setup, Side};
pub use state::{Derived, Energy, Report, State};
pub use structure::Structure;
