//! A participant behind a mapping, whichever side it is: its own fields, the weights, and the contract.

use super::weights::Weights;
use crate::mapping::Settings;
use crate::phase::{Announce, Phase};
use interfaces::{
    Description, Direction, Fields, Participant, ParticipantError, Readiness, Result, TimeWindow,
    WindowReport,
};

/// What the two sides do differently.
pub trait Side {
    /// What the mapping is between, for messages.
    const BETWEEN: &'static str;

    /// Whether the weights are made anew after every window.
    fn rebuilds(&self) -> bool;

    /// How the weights are made, of the fields that the participant gives.
    fn settings(&self, dimension: usize, own: &Fields) -> Result<Settings>;

    /// Where sources and targets are at the start (m), of the fields given by the other side and its own.
    fn points(&mut self, given: &Fields, own: &Fields) -> Result<[Vec<f64>; 2]>;

    /// Where the sources are when a window starts (m).
    fn sources<'f>(given: &'f Fields, own: &'f Fields) -> &'f [f64];

    /// What the participant takes, of what the other side gives it.
    fn take(&mut self, weights: &mut Weights, given: &Fields, own: &Fields, taken: &mut Fields)
    -> Result<()>;

    /// What it gives the other side every window, of its own.
    fn give(&self, weights: &mut Weights, own: &Fields, given: &mut Fields);

    /// What it gives the other side once.
    fn constants(&self, _given: &mut Fields) {}
}

/// A participant behind a mapping.
pub struct Shell<P, S> {
    inner: P,
    description: Description,
    announce: Announce,
    threads: usize,
    /// The participant's own fields.
    inputs: Fields,
    outputs: Fields,
    /// Made at initialisation.
    weights: Option<Weights>,
    /// Whether the next window starts with weights that are made anew.
    stale: bool,
    side: S,
}

/// The error of a mapping.
pub(super) fn failed<S: Side>(error: impl std::fmt::Display) -> ParticipantError {
    ParticipantError::failed(format!("failed to map between {}: {error}", S::BETWEEN))
}

impl<P: Participant, S: Side> Shell<P, S> {
    pub(super) fn around(inner: P, description: Description, side: S, announce: Announce) -> Self {
        Self {
            inner,
            description,
            announce,
            threads: 1,
            inputs: Fields::default(),
            outputs: Fields::default(),
            weights: None,
            stale: false,
            side,
        }
    }

    /// Lets the weights be made with so many threads.
    pub fn use_threads(&mut self, threads: usize) {
        self.threads = threads;
    }

    /// Gives the other side what the participant's own fields say, as the phase of mapping.
    fn give(&mut self, given: &mut Fields) {
        let Self { side, weights, outputs, announce, .. } = self;
        announce.during(Phase::Mapping, || side.give(initialised(weights), outputs, given));
    }
}

/// The weights, which are made at initialisation.
fn initialised(weights: &mut Option<Weights>) -> &mut Weights {
    weights.as_mut().expect("initialisation comes before all else")
}

impl<P: Participant, S: Side> Participant for Shell<P, S> {
    fn describe(&self) -> &Description {
        &self.description
    }

    /// The participant is initialised without what depends on the mapping: what it gives decides the weights.
    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.inputs = self.inner.describe().fields(Direction::In, 0);
        self.outputs = self.inner.describe().fields(Direction::Out, 0);
        let ready = self.inner.initialize(start, &self.inputs, &mut self.outputs)?;
        let settings = self.side.settings(self.description.dimension, &self.outputs)?;
        let points = self.side.points(inputs, &self.outputs)?;
        let made = || Weights::build(settings, points, self.threads);
        self.weights = Some(self.announce.during(Phase::Mapping, made).map_err(failed::<S>)?);
        self.stale = self.side.rebuilds();
        self.give(outputs);
        self.side.constants(outputs);
        Ok(ready)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let Self { side, weights, outputs, stale, .. } = self;
        let weights = initialised(weights);
        self.announce.during(Phase::Mapping, || {
            // Every iteration of a window begins at the same positions, so the weights of the first serve
            // all.
            if std::mem::take(stale) {
                weights.follow(S::sources(inputs, outputs)).map_err(failed::<S>)?;
            }
            side.take(weights, inputs, outputs, &mut self.inputs)
        })?;
        self.inner.start(window, &self.inputs)
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let report = self.inner.finish(&mut self.outputs)?;
        self.give(outputs);
        Ok(report)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        self.stale = self.side.rebuilds();
        self.inner.accept(snapshot)
    }

    /// The participant's state, and where the weights were made.
    fn save(&mut self) -> Result<Vec<u8>> {
        let own = self.inner.save()?;
        Ok(initialised(&mut self.weights).save(&own))
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let weights = initialised(&mut self.weights);
        let own = self.announce.during(Phase::Mapping, || weights.restore(state)).map_err(failed::<S>)?;
        let ready = self.inner.restore(own, &mut self.outputs)?;
        self.give(outputs);
        // Of a state before the first window, weights made anew are the same.
        self.stale = self.side.rebuilds();
        Ok(ready)
    }

    fn terminate(&mut self) -> Result<()> {
        self.inner.terminate()
    }
}
