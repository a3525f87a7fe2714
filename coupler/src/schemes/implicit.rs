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
use super::{Accepted, Pair, SchemeError};
use crate::acceleration::Acceleration;
use crate::convergence::{Measures, Residual};
use crate::phase::Phase;
use crate::schedule::Schedule;
use interfaces::TimeWindow;
use interfaces::case::coupling::{AtLimit, Combine, Coupling};
use std::ops::Range;
use words::bytes::{self, Reader, Writer};

/// What the case sets of the scheme, and what the scheme remembers.
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
    /// From window to window.
    pub extrapolation: Extrapolation,
    /// The iteration at hand.
    pub unknowns: Unknowns,
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
            extrapolation: Extrapolation::new(coupling.extrapolation.unwrap_or(0) as usize),
            unknowns: Unknowns::default(),
        }
    }

    /// Solves the window with the pair until it converges, and accepts it.
    pub fn solve(
        &mut self,
        pair: &mut Pair,
        mut window: TimeWindow,
        schedule: &mut Schedule,
    ) -> Result<Accepted, SchemeError> {
        self.begin(pair);
        self.converge(pair, &mut window)?;
        let Self { unknowns, acceleration, extrapolation, .. } = self;
        pair.announce.during(Phase::Acceleration, || {
            acceleration.end_window(&unknowns.blocks, &unknowns.y, &unknowns.r);
            extrapolation.accept(middle(&window), &unknowns.x);
        });
        let found = pair.condition46(&window);
        pair.accept(&window, found, schedule)
    }

    /// Lays the unknowns out, as they stand before the first window.
    fn begin(&mut self, pair: &Pair) {
        if self.unknowns.blocks.is_empty() {
            self.unknowns = Unknowns::of(pair, self.parallel);
            self.extrapolation.begin(&self.unknowns.x);
        }
    }

    /// Writes what the next windows depend on. Iterates and residuals are of one window alone.
    pub(super) fn save(&self, state: &mut Writer) {
        self.acceleration.save(state);
        self.extrapolation.save(state);
    }

    /// Goes to what [`save`](Self::save) wrote.
    pub(super) fn restore(&mut self, state: &mut Reader<'_>, pair: &Pair) -> Result<(), bytes::Error> {
        self.unknowns = Unknowns::default();
        self.begin(pair);
        let unknowns = self.unknowns.x.len();
        self.acceleration.restore(state, self.unknowns.blocks.len(), unknowns)?;
        self.extrapolation.restore(state, unknowns)
    }

    /// Steps 1 to 4: iterates until the window has converged, or the limit decides. The window may have
    /// shrunk then; what each iteration left is in [`Pair::residuals`].
    fn converge(&mut self, pair: &mut Pair, window: &mut TimeWindow) -> Result<(), SchemeError> {
        let Self { unknowns, acceleration, extrapolation, .. } = self;
        let smallest = SMALLEST_SHARE * window.size;
        let (mut first, mut attempts) = (Vec::new(), 0);
        pair.residuals.clear();
        extrapolation.guess(middle(window), &mut unknowns.x);
        loop {
            if self.parallel {
                unknowns.parallel_image(pair, window, self.enforce)?;
            } else {
                unknowns.serial_image(pair, window, self.enforce)?;
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
                pair.announce.during(Phase::Acceleration, || acceleration.next(blocks, x, y, r));
            } else {
                match self.at_limit {
                    AtLimit::Continue => return Ok(()),
                    AtLimit::Shrink if 0.5 * window.size >= smallest => {
                        window.size *= 0.5;
                        acceleration.restart_window();
                        extrapolation.guess(middle(window), x);
                        (attempts, first) = (0, Vec::new());
                    }
                    _ => return Err(not_converged(window, attempts, &residual)),
                }
            }
            window.iteration += 1;
        }
    }
}

/// The vectors of the fixed-point iteration, and their parts of one quantity each; nothing before the first
/// window.
#[derive(Clone, Debug, Default)]
pub struct Unknowns {
    blocks: Vec<Range<usize>>,
    x: Vec<f64>,
    y: Vec<f64>,
    r: Vec<f64>,
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
        Self { blocks, y: x.clone(), r: vec![0.0; x.len()], x }
    }

    /// The structure under the load `x`, then the fluid against its motion: `y` is the load that the fluid
    /// gives.
    fn serial_image(
        &mut self,
        pair: &mut Pair,
        window: &TimeWindow,
        enforce: bool,
    ) -> Result<(), SchemeError> {
        pair.load.copy_from_slice(&self.x);
        pair.solve_structure(window)?;
        pair.solve_fluid(window)?;
        pair.take_load(enforce);
        self.y.copy_from_slice(pair.new_load());
        Ok(())
    }

    /// The structure under the load of `x` and the fluid against the velocity of `x`, at once: `y` is what
    /// both give.
    fn parallel_image(
        &mut self,
        pair: &mut Pair,
        window: &TimeWindow,
        enforce: bool,
    ) -> Result<(), SchemeError> {
        let [load, velocity] = [0, 1].map(|block| self.blocks[block].clone());
        pair.load.copy_from_slice(&self.x[load.clone()]);
        pair.start_structure(window)?;
        pair.new_velocity.copy_from_slice(&self.x[velocity.clone()]);
        pair.start_fluid(window)?;
        pair.finish_structure(window)?;
        pair.finish_fluid(window)?;
        pair.take_load(enforce);
        self.y[load].copy_from_slice(pair.new_load());
        self.y[velocity].copy_from_slice(&pair.new_velocity);
        Ok(())
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
