//! The implicit schemes: a window is solved again until fluid and structure agree on it.
//!
//! Per window, from the accepted state at `tⁿ` to `tⁿ⁺¹`, with the unknowns `x` (serial: the load; parallel:
//! the load and the velocity):
//!
//! 1. the first `x` is extrapolated from the last windows;
//! 2. `y = H(x)`: *serial*, the structure solves under the load `x`, then the fluid against the motion that
//!    came of it; *parallel*, the structure under the load and the fluid against the velocity of `x`, both at
//!    once. Condition (46) is enforced on the load that the fluid gives;
//! 3. small enough a residual `r = y − x`: both accept, and the load of the window is `x`, under which the
//!    structure was solved;
//! 4. else the acceleration makes the next `x` of `x`, `y` and `r`, and the window is solved again from 2.
//!
//! Nothing that was solved before step 3 is seen by records or outputs: participants solve every time from
//! their accepted state.

use super::extrapolation::Extrapolation;
use super::{Accepted, Onward, Pair, SchemeError};
use crate::acceleration::Acceleration;
use crate::convergence::{Measures, Residual};
use crate::phase::Phase;
use crate::schedule::Schedule;
use interfaces::TimeWindow;
use interfaces::case::coupling::{AtLimit, Combine, Coupling};
use std::ops::Range;

/// What the case sets of the scheme.
#[derive(Clone, Debug)]
pub struct Implicit {
    /// Whether both participants solve at once.
    pub parallel: bool,
    /// Whether condition (46) is enforced, or only measured.
    pub enforce: bool,
    /// When the iterations end.
    pub measures: Measures,
    /// Most iterations of a window.
    pub iterations_limit: u32,
    /// What becomes of a window that reached the limit.
    pub at_limit: AtLimit,
    /// From iterate to iterate.
    pub acceleration: Acceleration,
    /// Order of the extrapolation from window to window: 0, 1 or 2.
    pub extrapolation: usize,
}

/// A window is shrunk no further than to this part of what the participants allowed.
const SMALLEST_SHARE: f64 = 1.0 / 1024.0;

impl Implicit {
    /// As the case has it, whose scheme is implicit.
    pub fn of(coupling: &Coupling, parallel: bool) -> Self {
        let own = (&coupling.acceleration, &coupling.convergence);
        let (Some(acceleration), Some(convergence)) = own else {
            unreachable!("a resolved implicit coupling has acceleration and convergence")
        };
        Self {
            parallel,
            enforce: coupling.enforce_condition_46,
            measures: Measures {
                absolute: convergence.absolute,
                relative: convergence.relative,
                residual_relative: convergence.residual_relative,
                all: convergence.combine == Combine::All,
            },
            iterations_limit: convergence.max_iterations,
            at_limit: convergence.at_limit,
            acceleration: Acceleration::of(acceleration, coupling.relaxation),
            extrapolation: coupling.extrapolation.unwrap_or(0) as usize,
        }
    }

    /// Runs the pair over the schedule. `record` hears of every accepted window.
    pub fn run(
        &mut self,
        pair: &mut Pair,
        schedule: &mut Schedule,
        mut record: impl FnMut(&Accepted, &Pair) -> Result<Onward, SchemeError>,
    ) -> Result<(), SchemeError> {
        let mut unknowns = Unknowns::of(pair, self.parallel);
        let mut outcomes = Extrapolation::new(self.extrapolation, unknowns.x.clone());
        while let Some(mut window) = schedule.next(pair.window_limit()) {
            self.converge(pair, &mut window, &mut unknowns, &outcomes)?;
            pair.announce.during(Phase::Acceleration, || {
                self.acceleration.end_window(&unknowns.blocks, &unknowns.y, &unknowns.r);
                outcomes.accept(middle(&window), &unknowns.x);
            });

            let (condition46, applied) = pair.condition46();
            let output = pair.accept(&window, schedule)?;
            let accepted = Accepted::alone(window, schedule.time(), output).with(condition46, applied);
            if record(&accepted, pair)? == Onward::Stop {
                break;
            }
        }
        Ok(())
    }

    /// Steps 1 to 4: iterates until the window has converged, or the limit decides. The window may have
    /// shrunk then; what each iteration left is in [`Pair::residuals`].
    fn converge(
        &mut self,
        pair: &mut Pair,
        window: &mut TimeWindow,
        unknowns: &mut Unknowns,
        outcomes: &Extrapolation,
    ) -> Result<(), SchemeError> {
        let smallest = SMALLEST_SHARE * window.size;
        let (mut first, mut attempts) = (Vec::new(), 0);
        pair.residuals.clear();
        outcomes.guess(middle(window), &mut unknowns.x);
        loop {
            if self.parallel {
                self.parallel_image(pair, window, unknowns)?;
            } else {
                self.serial_image(pair, window, unknowns)?;
            }
            let residual = pair.announce.during(Phase::Acceleration, || {
                unknowns.residual();
                self.measures.judge(&unknowns.blocks, &unknowns.y, &unknowns.r, &mut first)
            });
            let Unknowns { blocks, x, y, r, .. } = unknowns;
            pair.residuals.push(residual);
            attempts += 1;
            if residual.converged {
                return Ok(());
            }
            if attempts < self.iterations_limit {
                pair.announce.during(Phase::Acceleration, || self.acceleration.next(blocks, x, y, r));
            } else {
                match self.at_limit {
                    AtLimit::Continue => return Ok(()),
                    AtLimit::Shrink if 0.5 * window.size >= smallest => {
                        window.size *= 0.5;
                        self.acceleration.restart_window();
                        outcomes.guess(middle(window), x);
                        (attempts, first) = (0, Vec::new());
                    }
                    _ => return Err(not_converged(window, attempts, &residual)),
                }
            }
            window.iteration += 1;
        }
    }

    /// The structure under the load `x`, then the fluid against its motion: `y` is the load that the fluid
    /// gives.
    fn serial_image(
        &self,
        pair: &mut Pair,
        window: &TimeWindow,
        unknowns: &mut Unknowns,
    ) -> Result<(), SchemeError> {
        pair.load.copy_from_slice(&unknowns.x);
        pair.solve_structure(window)?;
        pair.solve_fluid(window)?;
        pair.take_load(self.enforce);
        unknowns.y.copy_from_slice(pair.new_load());
        Ok(())
    }

    /// The structure under the load of `x` and the fluid against the velocity of `x`, at once: `y` is what
    /// both give.
    fn parallel_image(
        &self,
        pair: &mut Pair,
        window: &TimeWindow,
        unknowns: &mut Unknowns,
    ) -> Result<(), SchemeError> {
        let [load, velocity] = [0, 1].map(|block| unknowns.blocks[block].clone());
        pair.load.copy_from_slice(&unknowns.x[load.clone()]);
        pair.start_structure(window)?;
        unknowns.velocity.clear();
        unknowns.velocity.extend_from_slice(&unknowns.x[velocity.clone()]);
        pair.start_fluid(window, &mut unknowns.velocity)?;
        pair.finish_structure(window)?;
        pair.finish_fluid(window)?;
        pair.take_load(self.enforce);
        unknowns.y[load].copy_from_slice(pair.new_load());
        unknowns.y[velocity].copy_from_slice(&pair.new_velocity);
        Ok(())
    }
}

/// The vectors of the fixed-point iteration, and their parts of one quantity each.
struct Unknowns {
    blocks: Vec<Range<usize>>,
    x: Vec<f64>,
    y: Vec<f64>,
    r: Vec<f64>,
    /// The velocity of `x`, while the fluid is given it.
    velocity: Vec<f64>,
}

impl Unknowns {
    /// The load as it stands and, for a parallel scheme, the velocity.
    fn of(pair: &Pair, parallel: bool) -> Self {
        let n = pair.load.len();
        let mut x = pair.load.clone();
        let mut blocks = Vec::with_capacity(2);
        blocks.push(0..n);
        if parallel {
            x.extend_from_slice(&pair.new_velocity);
            blocks.push(n..2 * n);
        }
        Self { blocks, y: x.clone(), r: vec![0.0; x.len()], x, velocity: Vec::new() }
    }

    /// `r = y − x`.
    fn residual(&mut self) {
        for ((r, y), x) in self.r.iter_mut().zip(&self.y).zip(&self.x) {
            *r = y - x;
        }
    }
}

fn middle(window: &TimeWindow) -> f64 {
    window.start + 0.5 * window.size
}

fn not_converged(window: &TimeWindow, iterations: u32, residual: &Residual) -> SchemeError {
    SchemeError::NotConverged {
        window: window.index,
        time: window.start,
        size: window.size,
        iterations,
        relative: residual.relative,
    }
}
