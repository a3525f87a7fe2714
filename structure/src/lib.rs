//! Total-Lagrangian SPH structure (TLSPH): Eqs. (33)–(45) of Salehizadeh and Shafiei 2022 ("the paper"), in
//! two and three dimensions.
//!
//! Describe bodies, clamps and loads in a [`Setup`], make a [`Structure`] of it, and [`Structure::advance`] a
//! [`State`] over one time window. The structure itself never changes: the same state and load give the same
//! result, to the bit, whatever the number of threads.
//!
//! Two discrete gradients ([`Gradient`]): the paper's, and a quadratic one (the default) that is right in
//! bending with three to four particles through the thickness, where the paper's is too soft. Beam under
//! gravity (`L/T = 17.5`, `ν = 0.4`), tip deflection, reference 65.56 mm: quadratic 65.1 / 65.7 / 65.8 mm
//! with 4 / 6 / 10 layers; first order 98.1 mm with 4. Oscillating plate of the paper's section 3.1, period
//! `T c₀/L`, reference 72.75: quadratic 72.73 / 73.03 / 72.99 with 4 / 6 / 10 layers; first order 76.59
//! (paper 77.50) with 10, 74.06 (paper 74.80) with 20. Two layers lock, one cannot bend: the quadratic
//! gradient refuses fewer than three. Nearly incompressible materials lock at few layers: at `ν = 0.49` −17 %
//! with 4, −3 % with 6, −0.1 % with 10.
//!
//! Particles off a lattice want cells of their own ([`voronoi_cells`], [`Body::from_cells`]), best after
//! [`relax_to_centroids`]; [`filling`] lays them in the outline of a two-dimensional body. Six layers, tip
//! deflection: 10 % jitter +3 to +6 % with the lattice's volumes, +1.3 to +2.2 % with cells, +0.5 % after one
//! sweep; a lattice at 15° to the faces +28, +13, and +2.8 % after three sweeps, +0.6 % after ten.
//!
//! Energy lost by the oscillating plate (St. Venant–Kirchhoff) in ten periods: the Runge–Kutta method damps
//! the short waves that the initial velocity excites on the lattice, with the fifth power of the step. With 4
//! / 6 / 10 layers 2.3e-3, 6.4e-4, 1.1e-4 of it at nine tenths of the limit of stability; at a quarter
//! ([`Options::step_fraction`]) 6.4e-5, 2.9e-5 and 9.5e-6.
//!
//! The stable sub-step comes from the operator's largest frequency and is found anew as the structure is
//! strained ([`State::stability`]): a bar of that law pulled to twice its length stiffens until 0.45 of the
//! step at rest is left, and rests at 2.0002 (tested).
//!
//! Speed, ns per particle and Runge–Kutta step (four force evaluations), one core with AVX-512, windows of
//! 100 steps, at 300,000 of 10 (`cargo bench -p structure --bench step`, an otherwise idle machine; single
//! runs differed by a tenth); what two threads gain; instructions counted with AVX2 (`--bench instructions`):
//!
//! | gradient, particles | 3,000 | 30,000 | 300,000 | two threads at 3,000 / 30,000 / 300,000 | instructions |
//! |---|---|---|---|---|---|
//! | first-order, lattice | 71 | 65 | 87 | 1.92 / 1.80 / 1.58 | 1,467 |
//! | first-order, general | 109 | 104 | 295 | 1.73 / 1.73 / 2.14 | 2,007 |
//! | quadratic, lattice | 110 | 87 | 191 | 1.97 / 1.56 to 2.17 / 1.93 | 2,749 |
//! | quadratic, general | 152 | 154 | 298 | 2.05 / 1.81 / 1.98 | 3,306 |
//!
//! Memory moved an evaluation, counted from the arrays: 0.33 kB a particle (first-order) and 0.47 kB
//! (quadratic), in the general path 0.84 and 1.0 kB more for weights and indices that no two particles share.
//! At 300,000 that makes 10 to 15 GB/s, where `a = b + s c` reached 38 GB/s on the same core. Threads share a
//! pass from 1,024 particles on; with fewer none is woken.
//!
//! To read the method, start at [`time_step`] (the Runge–Kutta step), then `kernels` (stresses and
//! accelerations), `gradient` (the discrete gradients) and [`material`] (the laws).
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
mod options;
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
pub use options::{Gradient, Options};
pub use point::MaterialPoint;
pub use setup::{Body, Setup, Side};
pub use state::{Derived, Energy, Report, Stability, State};
pub use structure::Structure;
