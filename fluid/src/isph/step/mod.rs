//! One time step of the fluid: the algorithm, a line a stage. The stages themselves are in the files below
//! this one, in their order: `assembly`, `prediction`, `solves`, `velocity`, `motion`.

mod assembly;
mod motion;
mod prediction;
pub(crate) mod scratch;
mod solves;
mod start;
mod velocity;

use crate::boundaries::sampling::BoundaryPoints;
use crate::error::Error;
use crate::interface::InterfaceInput;
use crate::isph::solver::Isph;
use crate::isph::state::State;
use crate::report::StepReport;

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
    /// Velocity by pressure.
    Velocity,
    /// Motion, shifting, contact; loads; energy and momentum; order.
    MotionAndAccounts,
}

impl<const D: usize> Isph<D> {
    /// [`step`](crate::method::Fluid::step) that tells `done` of each stage when it is over, for whoever
    /// measures what the stages cost.
    ///
    /// # Errors
    /// Those of [`step`](crate::method::Fluid::step).
    pub fn step_watched(
        &mut self,
        accepted: &State<D>,
        time: f64,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
        trial: &mut State<D>,
        done: impl FnMut(Stage),
    ) -> Result<StepReport<D>, Error> {
        structure.check(self.interface.volumes.len(), time)?;
        let mut points = std::mem::take(&mut self.scratch.points);
        points.take(&self.sampling, structure, &self.compliance, dt);
        let report = self.step_beside(&points, accepted, (time, dt), trial, done);
        self.scratch.points = points;
        report
    }

    /// The step beside a structure of these boundary points.
    fn step_beside(
        &mut self,
        structure: &BoundaryPoints<D>,
        accepted: &State<D>,
        (time, dt): (f64, f64),
        trial: &mut State<D>,
        mut done: impl FnMut(Stage),
    ) -> Result<StepReport<D>, Error> {
        trial.copy_from(accepted);
        self.recover_hierarchy(accepted)?;
        self.walls.move_to(time, (dt, accepted.last_dt));
        let mut report = StepReport { dt, ..StepReport::default() };

        //                                                                  (1), (5), (17), (25), (26)
        self.find_neighbours(&accepted.positions, &accepted.classes, &structure.positions);
        done(Stage::Neighbours);
        self.assemble(&accepted.positions); //                              (15), (16)
        self.choose_hierarchy(accepted, (time, dt), structure, trial);
        done(Stage::Assembly);
        self.predict(accepted, (time, dt), structure, &mut report)?; //     (10)–(13)
        self.find_known(accepted, structure);
        done(Stage::Prediction);
        self.project_positions(time, trial, &mut report)?; //               density error
        done(Stage::PositionProjection);
        self.solve_pressure(accepted, (time, dt), structure, trial, &mut report)?; // (14)–(17)
        done(Stage::PressureSolve);
        self.correct_velocity(dt, structure, trial, &mut report); //         (18)
        done(Stage::Velocity);
        self.move_particles(accepted, dt, structure, trial, &mut report); // (19)–(31)
        self.load_boundaries(dt, structure, trial, &mut report); //          (46), (48)
        self.shift_pressures(trial); //                                      (32)
        self.account(accepted, time, trial, &mut report)?;
        trial.last_dt = dt;
        self.keep_order(trial);
        done(Stage::MotionAndAccounts);
        Ok(report)
    }
}
