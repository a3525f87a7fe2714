//! One side of a coupling: a participant with the fields it takes and gives.

use interfaces::{
    Description, Direction, END_REQUESTED, Exchange, Fields, Participant, ParticipantError, Readiness,
    Result, Role, Scalar, ScalarKind, TimeWindow, WindowReport,
};
use thiserror::Error;
use words::bytes::{self, Reader, Writer};

/// A participant's failure, with who, what and when.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the {role} failed {during}: {source}")]
pub struct SideError {
    /// Which side.
    pub role: Role,
    /// What it was asked for: `while solving window 17 (iteration 1) at t = 0.0123 s`.
    pub during: String,
    /// Its failure.
    pub source: ParticipantError,
}

/// A participant with its fields and its last word.
pub struct Side {
    participant: Box<dyn Participant>,
    /// What the participant takes; the coupler writes here, but for what it lends for a start.
    pub inputs: Fields,
    /// What the participant gave last.
    pub outputs: Fields,
    /// Largest next window that the participant allows (s).
    pub window_limit: f64,
    /// Its scalars, in the order of its description.
    pub scalars: Vec<f64>,
    /// Sub-steps of the accepted windows; predictions and rejected iterations are not counted.
    pub sub_steps: u64,
    /// Sub-steps of the last solution.
    solution_sub_steps: u32,
    /// Wall time of its own work over all solutions (s).
    pub compute_seconds: f64,
}

impl Side {
    /// A side that was not initialised yet.
    pub fn new(participant: Box<dyn Participant>) -> Self {
        Self {
            participant,
            inputs: Fields::default(),
            outputs: Fields::default(),
            window_limit: f64::INFINITY,
            scalars: Vec::new(),
            sub_steps: 0,
            solution_sub_steps: 0,
            compute_seconds: 0.0,
        }
    }

    /// What the participant is and exchanges.
    pub fn describe(&self) -> &Description {
        self.participant.describe()
    }

    /// Which side it is.
    pub fn role(&self) -> Role {
        self.describe().role
    }

    /// Number of interface points, where a port of it names one.
    pub fn points(&self) -> Option<usize> {
        self.describe().ports.iter().find_map(|p| p.points)
    }

    /// Whether the participant asks for the end of the run, by a scalar of that name.
    pub fn asks_for_end(&self) -> bool {
        let mut named = self.describe().scalars.iter().zip(&self.scalars);
        named.any(|(scalar, value)| scalar.name == END_REQUESTED && *value != 0.0)
    }

    /// Initialises the participant at `time` (s) for `points` interface points, with what `partner` gives, if
    /// there is one.
    pub fn initialize(
        &mut self,
        time: f64,
        points: usize,
        partner: Option<&Fields>,
    ) -> Result<(), SideError> {
        let during = || format!("while initialising at t = {time} s");
        self.inputs = self.describe().fields(Direction::In, points);
        self.outputs = self.describe().fields(Direction::Out, points);
        if let Some(partner) = partner {
            self.inputs.copy_from(partner, |_| true).map_err(|e| self.failed(during(), e.into()))?;
        }
        let result = self.participant.initialize(time, &self.inputs, &mut self.outputs);
        let Readiness { window_limit, scalars } = result.map_err(|e| self.failed(during(), e))?;
        self.take(window_limit, scalars).map_err(|e| self.failed(during(), e))
    }

    /// Makes the forces among the probes unknown: those of a structure that was initialised without a load
    /// are not the ones that act at the start.
    pub fn forget_forces(&mut self) {
        let described = &self.participant.describe().scalars;
        let is_force = |scalar: &Scalar| scalar.kind == ScalarKind::Probe && scalar.unit == "N";
        for (_, value) in described.iter().zip(&mut self.scalars).filter(|(scalar, _)| is_force(scalar)) {
            *value = f64::NAN;
        }
    }

    /// Starts the window with the inputs as they stand.
    pub fn start(&mut self, window: &TimeWindow) -> Result<(), SideError> {
        self.start_with(window, [])
    }

    /// Starts the window with these values for the inputs of those names, as far as the participant takes
    /// them. They are lent for the call, not copied.
    pub fn start_with<const N: usize>(
        &mut self,
        window: &TimeWindow,
        mut lent: [(&str, &mut Vec<f64>); N],
    ) -> Result<(), SideError> {
        for (name, values) in &mut lent {
            self.inputs.swap(name, values);
        }
        let started = self.participant.start(window, &self.inputs);
        for (name, values) in &mut lent {
            self.inputs.swap(name, values);
        }
        started.map_err(|e| self.failed(solving(window), e))
    }

    /// Waits for the solution; outputs, limit and scalars are then those of the window's end.
    pub fn finish(&mut self, window: &TimeWindow) -> Result<(), SideError> {
        let result = self.participant.finish(&mut self.outputs);
        let report = result.map_err(|e| self.failed(solving(window), e))?;
        let WindowReport { sub_steps, window_limit, compute_seconds, scalars } = report;
        self.solution_sub_steps = sub_steps;
        self.compute_seconds += compute_seconds;
        self.take(window_limit, scalars).map_err(|e| self.failed(solving(window), e))
    }

    /// Starts the window and waits for its solution.
    pub fn solve_window(&mut self, window: &TimeWindow) -> Result<(), SideError> {
        self.start(window)?;
        self.finish(window)
    }

    /// Makes the last solution final, and has a snapshot written if one is due.
    pub fn accept(&mut self, window: &TimeWindow, snapshot: Option<u64>) -> Result<(), SideError> {
        let during = || format!("while accepting window {} at t = {} s", window.index, window.end());
        self.participant.accept(snapshot).map_err(|e| self.failed(during(), e))?;
        self.sub_steps += u64::from(self.solution_sub_steps);
        Ok(())
    }

    /// The participant's accepted state.
    pub fn save_participant(&mut self) -> Result<Vec<u8>, SideError> {
        self.participant.save().map_err(|e| self.failed("while saving its state".to_owned(), e))
    }

    /// Brings the participant to what [`save_participant`](Self::save_participant) gave; outputs, limit and
    /// scalars are then those of that state.
    pub fn restore_participant(&mut self, state: &[u8]) -> Result<(), SideError> {
        let restored = self.participant.restore(state, &mut self.outputs);
        let taken = restored.and_then(|Readiness { window_limit, scalars }| self.take(window_limit, scalars));
        taken.map_err(|e| self.failed("while going to a saved state".to_owned(), e))
    }

    /// Writes what was counted of the participant's work.
    pub fn save(&self, state: &mut Writer) {
        state.u64(self.sub_steps);
        state.f64(self.compute_seconds);
    }

    /// Goes to what [`save`](Self::save) wrote.
    pub fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        self.sub_steps = state.u64("sub-steps")?;
        self.compute_seconds = state.f64("seconds of work")?;
        Ok(())
    }

    /// Ends the participant in order.
    pub fn terminate(&mut self) -> Result<(), SideError> {
        self.participant.terminate().map_err(|e| self.failed("while ending".to_owned(), e))
    }

    /// Copies what `partner` gave in the last solution to the inputs of the same name, but for those
    /// `written` otherwise.
    pub fn receive(&mut self, partner: &Fields, written: &[&str]) {
        self.inputs
            .copy_from(partner, |port| {
                port.exchange == Exchange::EveryWindow && !written.contains(&port.name.as_str())
            })
            .expect("lengths were compared at initialisation");
    }

    fn take(&mut self, window_limit: f64, scalars: Vec<f64>) -> Result<()> {
        let expected = self.describe().scalars.len();
        if scalars.len() != expected {
            let found = scalars.len();
            return Err(ParticipantError::failed(format!(
                "it reported {found} scalars where it described {expected}"
            )));
        }
        if window_limit.is_nan() || window_limit <= 0.0 {
            return Err(ParticipantError::failed(format!(
                "it allows a next window of {window_limit} s, which is none"
            )));
        }
        // A probe may find nothing where it looks, and says so.
        let described = || self.describe().scalars.iter();
        let is_wrong = |(scalar, value): (&Scalar, &f64)| {
            !(value.is_finite() || value.is_nan() && scalar.kind == ScalarKind::Probe)
        };
        if let Some(at) = described().zip(&scalars).position(is_wrong) {
            let name = &self.describe().scalars[at].name;
            return Err(ParticipantError::failed(format!("its scalar `{name}` is {}", scalars[at])));
        }
        (self.window_limit, self.scalars) = (window_limit, scalars);
        Ok(())
    }

    fn failed(&self, during: String, source: ParticipantError) -> SideError {
        SideError { role: self.role(), during, source }
    }
}

fn solving(window: &TimeWindow) -> String {
    format!(
        "while solving window {} (iteration {}) from t = {} s",
        window.index, window.iteration, window.start
    )
}
