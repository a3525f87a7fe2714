//! Incompressible SPH by projection (ISPH), after Salehizadeh and Shafiei 2022.
//!
//! | stage | equations | module |
//! |---|---|---|
//! | neighbours, kernel sums, `B` | (1), (2), (5) | [`neighbourhood`](crate::particles::neighbourhood) |
//! | free surface, α, normals, pockets | (16), (17), (25), (26) | [`surface::detection`] |
//! | predictor: gravity, laminar, sub-particle-scale and approach viscosity | (10)–(13), (4), (6), (7) | [`viscosity`], [`correction`] |
//! | positions projected onto the density | – | [`pressure::position_projection`] |
//! | pressure Poisson equation | (14)–(16) | [`pressure::pressure_operator`], [`surface::surface_offset`], [`surface::tearing`] |
//! | its solution | – | [`pressure::conjugate_gradients`], [`pressure::preconditioner`], [`pressure::multigrid`], [`pressure::hierarchy`] |
//! | velocity | (18) | [`pressure::velocity_correction`] |
//! | motion, shifting, Taylor correction | (19)–(32) | [`shifting`], [`taylor`], [`contact`](crate::boundaries::contact) |
//! | load on the structure, reaction, wall forces | (46), (48) | [`interface_load`] |
//! | energy, momentum, volume | – | [`accounting`](crate::particles::accounting) |
//! | particles kept in order | – | [`order`](crate::particles::order) |
//!
//! The stages in their order are [`step`], choices are [`options`], what the method remembers from step to
//! step is in [`state`], what a fluid is made of and its stable step in [`solver`].

pub mod correction;
pub mod interface_load;
pub mod options;
pub mod pressure;
pub mod shifting;
pub mod solver;
pub mod state;
pub mod step;
pub mod surface;
pub mod taylor;
pub mod viscosity;
