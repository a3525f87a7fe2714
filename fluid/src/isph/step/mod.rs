//! One time step of the fluid: the algorithm, a line a stage. The stages themselves are in the files below
//! this one, in their order: `assembly`, `prediction`, `solves`, `velocity`, `motion`.

mod assembly;
mod motion;
mod prediction;
mod solves;
mod velocity;

use crate::error::Error;
use crate::interface::{InterfaceInput, StructureSurface};
use crate::isph::interface_load::WallForces;
use crate::isph::pressure::conjugate_gradients;
use crate::isph::pressure::hierarchy::Origin;
use crate::isph::pressure::preconditioner::PressurePreconditioner;
use crate::isph::pressure::pressure_operator::OperatorScratch;
use crate::isph::solver::Fluid;
use crate::isph::state::State;
use crate::isph::surface::detection::Surface;
use crate::isph::surface::surface_offset::Outside;
use crate::particles::accounting::StepReport;
use crate::particles::neighbourhood::Neighbourhood;
use crate::particles::order::ParticleOrder;
use sph::{Matrix, Vector};
use std::sync::Arc;

/// Stages of a step, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Neighbour lists, kernel sums, surface.
    Neighbours,
    /// The operator's diagonal and the preconditioner.
    Assembly,
    /// Velocity without pressure; what it tears.
    Prediction,
    /// Projection of positions onto the density.
    PositionProjection,
    /// Pressure Poisson equation.
    PressureSolve,
    /// Velocity by pressure, loads.
    VelocityAndLoad,
    /// Motion, shifting, contact; energy and momentum; order.
    MotionAndAccounts,
}

/// Particles that one task works through at least where little is done for each.
const ROWS: usize = 1024;

/// Memory of a step, used again by the next.
#[derive(Default)]
pub(crate) struct Scratch<const D: usize> {
    pub(crate) neighbourhood: Neighbourhood<D>,
    corrections: Vec<(Matrix<D>, f64)>,
    pub(crate) surface: Surface<D>,
    structure_surface: StructureSurface,
    terms: assembly::Terms<D>,
    diagonal: Vec<f64>,
    right: Vec<f64>,
    outside: Outside,
    wall_rate: Vec<f64>,
    preconditioner: PressurePreconditioner<D>,
    prepared_for: Option<Arc<Origin<D>>>,
    solver: conjugate_gradients::Scratch,
    operator: OperatorScratch<D>,
    /// What one stage makes and uses up itself: viscosities, then what known pressures give.
    passing_numbers: Vec<f64>,
    predicted: Vec<Vector<D>>,
    predicted_structure: Vec<Vector<D>>,
    confidence: Vec<f64>,
    position_shifts: Vec<Vector<D>>,
    /// What one stage makes and uses up itself: viscous accelerations, then the difference that Eq. (18)
    /// makes, then shifts.
    passing: Vec<Vector<D>>,
    contact_impulses: Vec<Vector<D>>,
    pub(crate) wall_forces: WallForces<D>,
    keep: Vec<bool>,
    torn: Vec<u32>,
    order: ParticleOrder,
}

impl<const D: usize> Scratch<D> {
    /// Whether the preconditioner was made of `origin`.
    fn is_prepared_for(&self, origin: &Arc<Origin<D>>) -> bool {
        self.prepared_for.as_ref().is_some_and(|made| Arc::ptr_eq(made, origin) || made == origin)
    }
}

impl<const D: usize> Fluid<D> {
    /// Advances `accepted` by `dt` (s) into `trial`, memory of `trial` used again. `time` (s) says where
    /// walls that move are. Nothing but `accepted`, `time`, `dt` and `structure` decides the result: calling
    /// twice gives the same bits.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::InterfaceLength`] for what came in or out, [`Error::Solve`] when a
    /// pressure solve failed.
    pub fn step(
        &mut self,
        accepted: &State<D>,
        time: f64,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
        trial: &mut State<D>,
    ) -> Result<StepReport<D>, Error> {
        // Into the pool once a step: from outside, each of its hundred passes would wait for a worker to wake
        // up and for its answer.
        rayon::scope(|_| self.step_watched(accepted, time, dt, structure, trial, |_| ()))
    }

    /// [`step`](Self::step) that tells `done` of each stage when it is over, for whoever measures what the
    /// stages cost.
    ///
    /// # Errors
    /// Those of [`step`](Self::step).
    pub fn step_watched(
        &mut self,
        accepted: &State<D>,
        time: f64,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
        trial: &mut State<D>,
        mut done: impl FnMut(Stage),
    ) -> Result<StepReport<D>, Error> {
        structure.check(self.interface.volumes.len(), time)?;
        trial.copy_from(accepted);
        self.recover_hierarchy(accepted)?;
        self.walls.move_to(time, dt);
        let mut report = StepReport { dt, ..StepReport::default() };

        self.find_neighbours(&accepted.positions, &accepted.classes, structure.positions); //  (1), (5), (17), (25), (26)
        done(Stage::Neighbours);
        self.assemble(); //                                                 (15), (16)
        self.choose_hierarchy(accepted, (time, dt), structure, trial);
        done(Stage::Assembly);
        self.predict(accepted, dt, structure, &mut report); //              (10)–(13)
        self.find_known(accepted);
        done(Stage::Prediction);
        self.project_positions(time, trial, &mut report)?; //               density error
        done(Stage::PositionProjection);
        self.solve_pressure(accepted, time, dt, trial, &mut report)?; //     (14)–(17)
        done(Stage::PressureSolve);
        self.correct_velocity(dt, structure, trial, &mut report); //         (18)
        self.load_structure(accepted, structure, trial); //                  (46), (48)
        done(Stage::VelocityAndLoad);
        self.move_particles(accepted, dt, structure, trial, &mut report); // (19), (21)–(32)
        self.account(accepted, time, trial, &mut report)?;
        trial.last_dt = dt;
        let Scratch { order, passing, passing_numbers, .. } = &mut self.scratch;
        order.keep(trial, &self.properties.domain.0, self.kernel.support(), (passing, passing_numbers));
        done(Stage::MotionAndAccounts);
        Ok(report)
    }

    /// Residuals of the last solve, one a particle, as the equations have them; where a solve failed, this
    /// shows it.
    pub fn solve_residual(&self) -> &[f64] {
        self.scratch.solver.residual()
    }
}
