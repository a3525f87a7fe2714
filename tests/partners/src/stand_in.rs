//! What all mocks share: the accepted state and the trial, saving, and the checks of shapes.

use interfaces::fields::wrong_length;
use interfaces::{
    Description, Direction, Exchange, Fields, Participant, ParticipantError, Port, Readiness, Result,
};
use interfaces::{TimeWindow, WindowReport};
use std::time::Instant;
use words::bytes::{self, Reader, Writer};

const MAGIC: &[u8; 8] = b"mnscmck1";

/// The physics of a mock. Its state is one vector, and solving a window is a function of the accepted state,
/// the window and the inputs: solutions repeat to the bit, and saving the state is saving the mock.
pub trait Model {
    /// What it is and exchanges.
    fn description(&self) -> Description;

    /// Keeps the constant inputs, and gives the state at time `start` (s).
    fn initial(&mut self, start: f64, inputs: &Fields) -> Result<Vec<f64>>;

    /// Writes the constant fields.
    fn constants(&self, outputs: &mut Fields);

    /// The state at the window's end and the sub-steps taken.
    fn advance(&self, accepted: &[f64], window: &TimeWindow, inputs: &Fields) -> Result<(Vec<f64>, u32)>;

    /// Writes the fields exchanged every window.
    fn outputs(&self, state: &[f64], outputs: &mut Fields);

    /// The scalars, in the order of the description.
    fn scalars(&self, state: &[f64]) -> Vec<f64>;
}

/// A [`Model`] as a participant.
pub struct StandIn<M> {
    model: M,
    description: Description,
    window_limit: f64,
    points: usize,
    accepted: Vec<f64>,
    trial: Option<Trial>,
}

struct Trial {
    state: Vec<f64>,
    sub_steps: u32,
    compute_seconds: f64,
}

impl<M: Model> StandIn<M> {
    /// A participant that takes windows of any size.
    pub fn new(model: M) -> Self {
        let description = model.description();
        Self { model, description, window_limit: f64::INFINITY, points: 0, accepted: Vec::new(), trial: None }
    }

    /// The same, but it asks for windows of at most `limit` (s). Larger ones are solved all the same: the
    /// limit is the coupler's to keep.
    pub fn with_window_limit(self, limit: f64) -> Self {
        Self { window_limit: limit, ..self }
    }

    /// The model.
    pub fn model(&self) -> &M {
        &self.model
    }

    fn readiness(&self) -> Readiness {
        Readiness { window_limit: self.window_limit, scalars: self.model.scalars(&self.accepted) }
    }

    fn check_lengths(&self, fields: &Fields, direction: Direction) -> Result<()> {
        for port in self.description.ports.iter().filter(|p| p.direction == direction) {
            let port = Port { points: port.points.or(Some(self.points)), ..port.clone() };
            let found = fields.get(&port.name).map_or(0, <[f64]>::len);
            if Some(found) != port.points.map(|n| n * port.components) {
                return Err(wrong_length(&port, found).into());
            }
        }
        Ok(())
    }
}

impl<M: Model> Participant for StandIn<M> {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.points = inputs
            .iter()
            .chain(outputs.iter())
            .map(|(port, array)| array.len() / port.components)
            .next()
            .unwrap_or(0);
        self.check_lengths(inputs, Direction::In)?;
        self.check_lengths(outputs, Direction::Out)?;
        self.accepted = self.model.initial(start, inputs)?;
        self.model.constants(outputs);
        self.model.outputs(&self.accepted, outputs);
        Ok(self.readiness())
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let began = Instant::now();
        self.check_lengths(inputs, Direction::In)?;
        let (state, sub_steps) = self.model.advance(&self.accepted, window, inputs)?;
        self.trial = Some(Trial { state, sub_steps, compute_seconds: began.elapsed().as_secs_f64() });
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        self.check_lengths(outputs, Direction::Out)?;
        let trial = self.trial.as_ref().ok_or_else(no_window)?;
        self.model.outputs(&trial.state, outputs);
        Ok(WindowReport {
            sub_steps: trial.sub_steps,
            window_limit: self.window_limit,
            compute_seconds: trial.compute_seconds,
            scalars: self.model.scalars(&trial.state),
        })
    }

    fn accept(&mut self, _snapshot: Option<u64>) -> Result<()> {
        self.accepted = self.trial.take().ok_or_else(no_window)?.state;
        Ok(())
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        let mut state = Writer::new(MAGIC);
        state.f64s(&self.accepted);
        Ok(state.finish())
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let refused = |error: bytes::Error| ParticipantError::Failed(error.to_string());
        let mut state = Reader::new("mock's state", MAGIC, state).map_err(refused)?;
        self.accepted = state.f64s("numbers", Some(self.accepted.len())).map_err(refused)?;
        state.finish().map_err(refused)?;
        self.trial = None;
        self.model.outputs(&self.accepted, outputs);
        Ok(self.readiness())
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}

/// Writes `values` (a slice of the field's length) to the field of that name.
///
/// # Panics
/// Where the field is missing: the model described it itself.
pub fn write(outputs: &mut Fields, name: &str, values: &[f64]) {
    outputs.get_mut(name).expect("a field that the model described").copy_from_slice(values);
}

/// Bits of all fields that are exchanged every window, to compare solutions to the bit.
pub fn bits(fields: &Fields) -> Vec<u64> {
    let every = fields.iter().filter(|(port, _)| port.exchange == Exchange::EveryWindow);
    every.flat_map(|(_, array)| array.iter().map(|v| v.to_bits())).collect()
}

fn no_window() -> ParticipantError {
    ParticipantError::failed("no window was started: put the mock behind `Guarded`")
}
