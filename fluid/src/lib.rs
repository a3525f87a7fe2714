//! Incompressible SPH fluid (ISPH, projection method) with free surfaces, walls and elastic structure.
//!
//! Start reading at [`Fluid::step`] in [`time_step`](isph::step): it is the algorithm of the paper (Salehizadeh and
//! Shafiei 2022, "A coupled ISPH-TLSPH method for simulating fluid-elastic structure interaction problems"),
//! a line a stage. What each stage does stands in a file of its own:
//!
//! | stage | equations | module |
//! |---|---|---|
//! | neighbours, kernel sums, `B` | (1), (2), (5) | [`neighbourhood`](particles::neighbourhood), [`rows`](particles::rows) |
//! | free surface, α, normals, pockets | (16), (17), (25), (26) | [`surface`](isph::surface::detection) |
//! | predictor: gravity, laminar, sub-particle-scale and approach viscosity | (10)–(13), (4), (6), (7) | [`viscosity`](isph::viscosity), [`correction`](isph::correction) |
//! | positions projected onto the density | – | [`position_projection`](isph::pressure::position_projection) |
//! | pressure Poisson equation | (14)–(16) | [`pressure_operator`](isph::pressure::pressure_operator), [`surface_offset`](isph::surface::surface_offset), [`tearing`](isph::surface::tearing) |
//! | its solution | – | [`conjugate_gradients`](isph::pressure::conjugate_gradients), [`preconditioner`](isph::pressure::preconditioner), [`multigrid`](isph::pressure::multigrid), [`hierarchy`](isph::pressure::hierarchy) |
//! | velocity | (18) | [`velocity_correction`](isph::pressure::velocity_correction) |
//! | load on the structure, reaction, wall forces | (46), (48) | [`interface_load`](isph::interface_load), [`interface`] |
//! | motion, shifting, Taylor correction | (19)–(32) | [`shifting`](isph::shifting), [`taylor`](isph::taylor), [`contact`](boundaries::contact) |
//! | energy, momentum, volume | – | [`accounting`](particles::accounting) |
//! | particles kept in order | – | [`order`](particles::order) |
//! | periodic sides; walls that move | – | [`period`](boundaries::period), [`wall_motion`](boundaries::wall_motion) |
//!
//! [`solver`](isph::solver) holds what a fluid is made of and its stable step, walls come from [`walls`](boundaries::walls), choices from
//! [`Options`], values at points from [`probes`]. A [`State`] holds all that the next step depends on, the
//! solver's starting values included: [`Fluid::step`] takes an accepted state and makes a trial state, as
//! often as wanted, with the same bits each time and for any number of threads. Nothing here knows a process,
//! a file, a clock or a message.
//!
//! # Notation
//!
//! | symbol | meaning | unit | shape |
//! |---|---|---|---|
//! | `a`, `b` | fluid particles; `w` wall, `s` structure particle | – | index |
//! | `r_ab = r_a − r_b`, `e_ab` | offset, its unit vector | m, – | `Vector<D>` |
//! | `∇W_ab` | kernel gradient with respect to `r_a`: points towards `b` | m⁻ᴰ⁻¹ | `Vector<D>` |
//! | `V`, `V_w`, `V_s` | volumes (one metre of depth in two dimensions) | m³ | scalar |
//! | `n`, `n₀` | `Σ V W`, the same on the lattice | 1 | scalar |
//! | `∇·r` | `−Σ V r_ab·∇W_ab`, `D` inside | 1 | scalar |
//! | `α` | surface smoothing, 0 on the surface, 1 inside | 1 | scalar |
//! | `B` | correction of kernel gradients | 1 | `Matrix<D>` |
//! | `D u` | divergence | 1/s | scalar a particle |
//! | `A`, `L` | `D M⁻¹ Dᵀ`; compact Laplacian times `1/ρ` | m³/kg/m² | operator |
//! | `u*` | velocity without pressure at the step's end | m/s | `Vector<D>` |
//! | `g_s`, `R_s` | load on the structure and reaction as pressure gradients: forces `−V_s g_s` on it, `+V_s R_s` on the fluid | Pa/m | `Vector<D>` |
//! | `φ`, `θ` | share of Eq. (18) that surroundings and energy allow | 1 | scalar |
//!
//! # The structure in a step
//!
//! The interface brings positions at the window's start, the mean velocity over the window that the structure
//! is predicted to have under the load held from the last window, and that load. The held load is taken back,
//! `u*_s = u_s + ½Δt g_held/ρ_s`, and the structure takes part in the pressure solve with its mass: it yields
//! by `−½Δt g_s/ρ_s` (`compliance`). With the velocity at the window's end ([`StructureVelocity::End`]) the
//! halves are ones; why the mean is met by default stands in `docs/decisions/0003-mean-velocity.md`. The load
//! is the transpose of the divergence through which `u_s` enters, so [`InterfaceOutput`] holds `R_s = g_s` to
//! rounding next to the structure, where the fluid moves by the symmetric gradient alone. Contact (particles
//! of known pressure that would run into the structure) and no-slip friction are counted in `R_s` and are
//! **not** part of `g_s`.
//!
//! # Where this departs from the paper, and what forced it
//!
//! Measured with this crate in two dimensions, water, `h = 1.2 Δx`, all but the choice named as by default
//! (the sub-particle-scale model on): "tank" is 0.5 wide and 1 deep (H/Δx = 20, positions jittered by 0.1 Δx,
//! 6 s, means from 1 s on), "dam" a column 1 × 2 in a tank 4 wide (Δx = width/20, 1.5 s). `K` is kinetic
//! energy, "rise" the largest rise of kinetic and potential energy over the least before, over that at the
//! start. By default the tank has a mean `K` of 0.027 J (it could fall with 2450 J), the rms error of its
//! pressure is 0.07 % of ρgH and its centroid stands 0.19 % high; the dam keeps 0.970 of its energy and its
//! rise is 3.3e-4. The paper's choices together are [`Options::paper`].
//!
//! | paper | here | why |
//! |---|---|---|
//! | compact Laplacian (15), gradient (18) | gradient as the negative transpose of the divergence, `A = D M⁻¹ Dᵀ + 0.1 L` | projection cannot add energy, by construction; the paper's choices together: dam not finite at 0.89 s; tank at 2 s K 1 J, energy + 2.5 %, centroid + 2.5 %, single densities 24 % off, not finite at 5.8 s |
//! | Eq. (18) everywhere | Eq. (18) as far as energy allows (θ), none where neighbours are one-sided or beside the structure (φ) | symmetric gradient alone: tank K 88 J, pressure off by up to 0.67 ρgH; dam keeps 0.933 of its energy instead of 0.970 |
//! | thresholds 1.4/1.6 of ∇·r | 1.6/1.8, onto the surface below 1.52 ([`surface`](isph::surface::detection)) | a flat lattice surface has 1.28, the layer beneath it 1.92. 1.4/1.6 hold too: tank K 0.032 J, dam's energy 0.956 |
//! | density error left alone | position projection, velocity unchanged | without it the tank's centroid rises by 1.3 % and K is 5 times as large |
//! | `p = 0` on surface particles, drawn to 0 near it | pressure at their depth ([`surface_offset`](isph::surface::surface_offset)) | rms pressure error of the tank without 2.8 % of ρgH, with 0.07 %; K 5 times as large without |
//! | shifting (21)–(23) | concentration gradient with `ζ ≥ √(gH) Δt` | without shifting K reaches 12 J, and the dam's rise is 3.6e-3; with `ζ = u_max Δt` a resting tank is not shifted at all |
//! | Taylor correction of velocity (20), (31) | off | adds energy at ragged surfaces: the dam's rise is 1.2e-3, four times as large |
//! | walls not described | weight 2 in divergence and gradient, no wall unknowns; approach limited at 0.25 Δx from the surface | a particle of known pressure meets no resistance otherwise |
//! | incompressible under tension, too | the same; tearing is an option ([`tearing`](isph::surface::tearing)) | tension in whirls and corners of a dam break falls to 1/25 to 1/100 with it, at no cost; not the default, since it changes the gate by 6 % |
//! | – | viscosity `0.02 h √(gH)` between approaching particles | takes 0.0024 of the dam's energy in 1.5 s (0.970 is left; without it 0.972, which survives too) and most of the noise of the tank, whose K is 0.10 J without |
//! | sub-particle-scale model (10), `c_s = 0.1` | the same, can be switched off | takes 0.005 of the dam's energy in 1.5 s (0.975 is left without), nothing in the tank |
//! | Eq. (48) | transpose of the divergence | equal and opposite by construction; (48) is `load = PressureGradient` |
//! | Eq. (17) | π in the cosine | slip in print |
//! | Eqs. (6)–(7) | Fatehi and Manzari's tensor, exact for quadratic fields (tested) | garbled in print |
//! | Eq. (13) | mean viscosity with the 2 of Eq. (4) | slip in print |
//! | Eq. (27) | `d` with the sign of `δr·n` | slip in print: inward shifts would double |
//! | Cr = 0.1 | 0.2, growing by at most 1.2 a step | all numbers here are at 0.2; 0.1 was run with the paper's choices only |
//!
//! # What a step costs
//!
//! Measured with `examples/step_cost.rs` on a column that collapses (0.27 s at 2,300 particles, 0.24 s at
//! 9,000, 0.10 s at 50,000, 0.01 s at 500,000), each step three times, the least time of each stage, on an
//! idle machine of two cores with a copy bandwidth of 33 GB/s on one thread and up to 69 on two.
//!
//! | µs a particle and step, one thread / two | 2,300 | 9,000 | 50,000 | 500,000 |
//! |---|---|---|---|---|
//! | tolerance 1e-3 | 1.40 / 0.89 | 1.29 / 0.75 | 1.46 / 0.80 | 1.06 / 0.60 |
//! | its iterations, pressure and positions | 6.3, 3.3 | 6.1, 1.2 | 6.0, 1.2 | 2.0, 1.0 |
//! | tolerance 1e-6 | 1.86 / 1.15 | 1.79 / 0.98 | 2.15 / 1.15 | 1.65 / 0.90 |
//! | its iterations | 12.9, 3.2 | 13.0, 1.2 | 13.0, 1.2 | 8.0, 1.0 |
//! | memory (kB a particle) | 1.7 | 1.39 | 1.23 | 1.19 |
//!
//! Two million particles (the column 1,000 wide, 6 steps) take 1.17 kB each and 9.5 iterations at 1e-6.
//!
//! A dam that has broken and splashed for 2.4 s (8,800 particles, 9.2 and 3.3 iterations, 0.28 hierarchies a
//! step) takes 1.75 µs (on a busy machine) and 1.41 kB. `cases/dam_break` with 9,000 particles takes 8.0 and
//! 3.6 iterations a step in the mean of its 3.84 s, 10.5 and 5.0 in the eighth in which the wave falls back,
//! and never more than 16. Two threads gain less in a small fluid that makes its hierarchy often: 1.28 at
//! 2,300 particles after 0.56 s. At 50,000 particles and 1e-3, bandwidth counted as the example's `traffic`
//! says:
//!
//! | stage | share | GB/s on one thread, two | two threads are faster by |
//! |---|---|---|---|
//! | neighbours, kernel sums, surface | 0.24 | 3.9, 6.4 | 1.64 |
//! | assembly, hierarchy | 0.02 | 15.0, 23.5 | 1.57 |
//! | prediction | 0.05 | 10.7, 19.7 | 1.83 |
//! | position projection | 0.13 | 14.3, 27.2 | 1.90 |
//! | pressure solve | 0.47 | 13.8, 27.7 | 2.00 |
//! | velocity, loads | 0.04 | 17.5, 33.8 | 1.93 |
//! | motion, accounts | 0.04 | 8.0, 12.7 | 1.60 |
//! | whole | 1 | 11.2, 20.4 | 1.83 |
//!
//! No stage comes near the copy bandwidth on one thread: the caches hold much of what is gathered, and
//! arithmetic and latency take the time. What runs on one thread whatever there are is 6 % of a step in which
//! a hierarchy is made (9,000 particles: 1.9 % aggregates, 1.4 % surface, the rest in pieces), 4 % of one in
//! which none is. What keeps two threads of small fluids from twice the speed is handing over: a step has
//! about 200 passes, and a thread that has waited for some 15 µs sleeps and takes longer than that to wake.
//! Passes too short to share are not shared ([`multigrid`](isph::pressure::multigrid), [`conjugate_gradients`](isph::pressure::conjugate_gradients)).
//!
//! The hierarchy is kept while it serves ([`hierarchy`](isph::pressure::hierarchy)), and follows diagonals that change
//! ([`preconditioner`](isph::pressure::preconditioner)): made 0.2 times a step in the collapsing columns, 0.28 times in the splashing dam.
//! Making it takes 0.16 µs a particle, an iteration 0.08.
//!
//! Neighbour lists are found anew each step; lists with a skin were built and gained nothing
//! (`docs/decisions/0010-neighbour-lists.md`). Particles are sorted along Morton's curve when their order has
//! decayed ([`order`](particles::order)). That made a step of the splashing dam (9,000, 1.46 s after the start in the lattice's
//! order) 4 to 6 % faster, that of a column near the lattice's order not at all, at 50,000 and at 500,000.
//! Order matters when it is lost altogether: shuffled, 9,000 particles take 1.09 times as long, 50,000 twice,
//! and 500,000 took 6.1 µs instead of 1.35 (before their hierarchy was kept).
//!
//! Starting the solve from pressures extrapolated in time took 4.4 instead of 6.0 iterations while the column
//! began to fall smoothly, and 15.0 instead of 13.2 once it had splashed (13.1 with half the extrapolation):
//! the pressure there is not smooth in time, and nothing is extrapolated.

pub mod boundaries;
pub mod error;
pub mod interface;
pub mod isph;
pub mod method;
pub mod participant;
pub mod particles;
pub mod probes;
pub mod properties;
pub mod report;

pub use boundaries::wall_motion::{Law, Motion};
pub use boundaries::walls::{Side, SurfacePoint, WallPart, WallShape, Walls};
pub use error::Error;
pub use interface::{InterfaceInput, InterfaceOutput, InterfaceParticles};
pub use isph::options::{
    Load, Options, Preconditioner, Scheme, ShiftingLaw, StructureVelocity, Tearing, ViscousOperator,
};
pub use isph::solver::Isph;
pub use isph::state::State;
pub use isph::step::Stage;
pub use method::Fluid;
pub use particles::class::SurfaceClass;
pub use probes::{Probe, ProbeValue};
pub use properties::FluidProperties;
pub use report::{Outcome, StepReport};
