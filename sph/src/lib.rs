//! Numerics both particle solvers stand on.
//!
//! Start at [`kernel`], then [`neighbours`]. Everything is generic over the dimension `D` (2 or 3);
//! in two dimensions one metre of depth is meant, so volumes are in m³ and masses in kg there too.
//!
//! | symbol | meaning | unit | shape |
//! |---|---|---|---|
//! | `Δx` (`spacing`) | particle spacing | m | scalar or one an axis |
//! | `h` (`smoothing_length`) | smoothing length; kernels reach `2h` | m | scalar |
//! | `W_ab` | kernel at the distance of particles a and b | m⁻ᴰ | scalar |
//! | `∇W_ab` | its gradient with respect to `r_a` | m⁻ᴰ⁻¹ | `Vector<D>` |

pub mod curve;
pub mod kernel;
pub mod lattice;
pub mod neighbours;
pub mod parallel;
pub mod tensor;

/// A point or vector in `D` dimensions; a slice of them is flat memory (`D` doubles each).
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;
/// A second-order tensor in `D` dimensions.
pub type Matrix<const D: usize> = nalgebra::SMatrix<f64, D, D>;
