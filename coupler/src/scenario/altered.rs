//! A participant under a scenario.

use super::change::Memory;
use super::{Change, Did, Fault, FaultKind, Of};
use interfaces::{
    Description, Direction, Fields, Participant, ParticipantError, Readiness, Result, TimeWindow,
    WindowReport,
};
use rustix::process::Signal;
use std::time::Duration;
use words::bytes::{Error, Reader, Writer};

/// First bytes of a saved state; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscsce1";

/// A signal, after so long on the clock.
pub type Blow = (Signal, Duration);
/// Sends a signal to the participant's process; says what keeps it from that.
pub type Strike = Box<dyn Fn(Blow) -> std::result::Result<(), String>>;

/// A participant whose fields are changed on their way, and which fails as it is told. Changes are part of
/// its state, faults are not: a run that goes on is not to fail again.
pub struct Altered<P> {
    inner: P,
    changes: Vec<(Change, Memory)>,
    /// With whether it was done.
    faults: Vec<(Fault, bool)>,
    strike: Strike,
    did: Did,
    /// What the participant takes, changed.
    inputs: Fields,
    window: Option<TimeWindow>,
    /// What was passed on last of the fields given that changes are of, by name: a restored participant gives
    /// its own, and the coupler had these.
    passed_on: Vec<(String, Vec<f64>)>,
}

impl<P: Participant> Altered<P> {
    /// Puts `inner` under what of a scenario is its own. `did` hears in the end of what was done.
    ///
    /// # Errors
    /// Quantities, components and points that the participant does not have, one line each.
    pub fn new(inner: P, of: Of, strike: Strike, did: Did) -> std::result::Result<Self, Vec<String>> {
        let mistakes: Vec<_> =
            of.changes.iter().filter_map(|change| mistake(change, inner.describe())).collect();
        if !mistakes.is_empty() {
            return Err(mistakes);
        }
        Ok(Self {
            inner,
            changes: of.changes.into_iter().map(|change| (change, Memory::default())).collect(),
            faults: of.faults.into_iter().map(|fault| (fault, false)).collect(),
            strike,
            did,
            inputs: Fields::default(),
            window: None,
            passed_on: Vec::new(),
        })
    }

    fn begin(&mut self, start: f64, inputs: &Fields, outputs: &Fields) {
        for (change, memory) in &mut self.changes {
            let fields = if change.place.direction == Direction::In { inputs } else { outputs };
            memory.begin(start, fields.get(&change.place.quantity).unwrap_or(&[]));
        }
    }

    /// Keeps what is passed on of the fields given that changes are of.
    fn pass_on(&mut self, outputs: &Fields) {
        let given = self.changes.iter().filter(|(change, _)| change.place.direction == Direction::Out);
        self.passed_on.clear();
        self.passed_on.extend(given.filter_map(|(change, _)| {
            let name = &change.place.quantity;
            Some((name.clone(), outputs.get(name)?.to_vec()))
        }));
    }

    fn alter(
        changes: &mut [(Change, Memory)],
        direction: Direction,
        window: &TimeWindow,
        fields: &mut Fields,
    ) {
        for (change, memory) in changes.iter_mut().filter(|(change, _)| change.place.direction == direction) {
            let port = fields.ports().iter().find(|port| port.name == change.place.quantity);
            let components = port.map_or(1, |port| port.components);
            if let Some(values) = fields.get_mut(&change.place.quantity) {
                change.apply(memory, (window.index, window.start, window.end()), components, values);
            }
        }
    }

    /// Has those faults happen that are due with this window.
    fn fail(&mut self, window: &TimeWindow) -> Result<()> {
        let (index, start) = (window.index, window.start);
        let due = |(fault, is_done): &&mut (Fault, bool)| !is_done && fault.at <= start;
        for (fault, is_done) in self.faults.iter_mut().filter(due) {
            *is_done = true;
            let (blows, word): (&[Blow], _) = match &fault.kind {
                FaultKind::Signal(Signal::KILL) => {
                    (&[(Signal::KILL, Duration::ZERO)], "was killed".to_owned())
                }
                FaultKind::Signal(signal) => {
                    (&[(*signal, Duration::ZERO)], format!("was sent signal {}", signal.as_raw()))
                }
                FaultKind::Stop(None) => (&[(Signal::STOP, Duration::ZERO)], "was stopped".to_owned()),
                FaultKind::Stop(Some(lasts)) => (
                    &[(Signal::STOP, Duration::ZERO), (Signal::CONT, *lasts)],
                    format!("was stopped for {} s", lasts.as_secs_f64()),
                ),
                FaultKind::Error(words) => {
                    self.did.tell([format!("the {} failed with window {index}: {words}", fault.of)]);
                    return Err(ParticipantError::failed(format!("{words} (by the scenario)")));
                }
            };
            for blow in blows {
                (self.strike)(*blow).map_err(|what| {
                    ParticipantError::failed(format!("the fault of the scenario could not be made: {what}"))
                })?;
            }
            self.did.tell([format!("the {}'s process {word} with window {index}, t = {start} s", fault.of)]);
        }
        Ok(())
    }

    fn read<'a>(&mut self, state: &'a [u8]) -> std::result::Result<&'a [u8], Error> {
        let mut state = Reader::new("state under a scenario", MAGIC, state)?;
        let own = state.bytes("own state")?;
        for (_, memory) in &mut self.changes {
            memory.restore(&mut state)?;
        }
        self.passed_on.clear();
        for _ in 0..state.usize("fields that were changed")? {
            let name = state.text("name of a field")?.to_owned();
            self.passed_on.push((name, state.f64s("a field that was changed", None)?));
        }
        state.finish().map(|()| own)
    }
}

impl<P> Altered<P> {
    /// What was done, for the summary.
    fn tell(&mut self) {
        let lines = self.changes.drain(..).map(|(change, memory)| match memory.windows {
            0 => format!("{change}, in no window"),
            windows => format!("{change}, in {windows} windows from t = {} s on", memory.first),
        });
        let lines: Vec<_> = lines.collect();
        self.did.tell(lines);
        let missed = self.faults.drain(..).filter(|(_, done)| !done);
        let missed: Vec<_> = missed
            .map(|(fault, _)| {
                format!(
                    "the {} had no fault: it was due at t = {} s, and the run ended first",
                    fault.of, fault.at
                )
            })
            .collect();
        self.did.tell(missed);
    }
}

/// What the participant does not have of a change.
fn mistake(change: &Change, description: &Description) -> Option<String> {
    let place = &change.place;
    let number = change.number;
    let of_way = |port: &&interfaces::Port| {
        port.direction == place.direction && port.exchange == interfaces::Exchange::EveryWindow
    };
    let ports: Vec<_> = description.ports.iter().filter(of_way).collect();
    let way = if place.direction == Direction::Out { "gives" } else { "takes" };
    let Some(port) = ports.iter().find(|port| port.name == place.quantity) else {
        let names: Vec<_> = ports.iter().map(|port| port.name.as_str()).collect();
        return Some(format!(
            "change.{number}.{} = \"{}.{}\": the {}, {}, {way} no such quantity every window; it {way} {}",
            if way == "gives" { "given" } else { "taken" },
            place.role,
            place.quantity,
            place.role,
            description.solver,
            names.join(", ")
        ));
    };
    if change.component.is_some_and(|component| component >= port.components) {
        return Some(format!(
            "change.{number}.component: {} has {} components; leave it out for all",
            place.quantity, port.components
        ));
    }
    let known = description.ports.iter().find_map(|port| port.points);
    let beyond =
        change.points.iter().flatten().find(|point| port.points.or(known).is_some_and(|n| **point >= n));
    beyond.map(|point| {
        let n = port.points.or(known).unwrap_or(0);
        format!(
            "change.{number}.points: {} has {n} points, and {point} is none of 0 to {}",
            place.quantity,
            n.saturating_sub(1)
        )
    })
}

impl<P: Participant> Participant for Altered<P> {
    fn describe(&self) -> &Description {
        self.inner.describe()
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        let ready = self.inner.initialize(start, inputs, outputs)?;
        self.inputs = inputs.clone();
        self.begin(start, inputs, outputs);
        Ok(ready)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        self.window = Some(*window);
        self.fail(window)?;
        if self.changes.iter().all(|(change, _)| change.place.direction == Direction::Out) {
            return self.inner.start(window, inputs);
        }
        self.inputs.clone_from(inputs);
        Self::alter(&mut self.changes, Direction::In, window, &mut self.inputs);
        self.inputs.check_finite()?;
        self.inner.start(window, &self.inputs)
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let report = self.inner.finish(outputs)?;
        if let Some(window) = self.window {
            Self::alter(&mut self.changes, Direction::Out, &window, outputs);
            self.pass_on(outputs);
        }
        Ok(report)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        self.inner.accept(snapshot)?;
        if let Some(window) = self.window.take() {
            for (change, memory) in &mut self.changes {
                memory.accept(change, window.start, window.end());
            }
        }
        Ok(())
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        let own = self.inner.save()?;
        if self.changes.is_empty() {
            return Ok(own);
        }
        let mut state = Writer::new(MAGIC);
        state.bytes(&own);
        for (_, memory) in &self.changes {
            memory.save(&mut state);
        }
        state.usize(self.passed_on.len());
        for (name, values) in &self.passed_on {
            state.text(name);
            state.f64s(values);
        }
        Ok(state.finish())
    }

    /// Also goes to a state of a run without a scenario: a branch of it begins under this one.
    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        if self.changes.is_empty() {
            return self.inner.restore(state, outputs);
        }
        if !state.starts_with(MAGIC) {
            let ready = self.inner.restore(state, outputs)?;
            let inputs = std::mem::take(&mut self.inputs);
            self.begin(f64::NEG_INFINITY, &inputs, outputs);
            self.inputs = inputs;
            return Ok(ready);
        }
        let own = self.read(state).map_err(|error| ParticipantError::failed(error.to_string()))?;
        let ready = self.inner.restore(own, outputs)?;
        for (name, values) in &self.passed_on {
            match outputs.get_mut(name) {
                Some(field) if field.len() == values.len() => field.copy_from_slice(values),
                _ => return Err(ParticipantError::failed(format!("the state has other values of `{name}`"))),
            }
        }
        Ok(ready)
    }

    fn terminate(&mut self) -> Result<()> {
        self.inner.terminate()
    }
}

impl<P> Drop for Altered<P> {
    fn drop(&mut self) {
        self.tell();
    }
}
