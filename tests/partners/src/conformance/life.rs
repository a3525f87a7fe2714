//! One participant under test, with the fields of its port and the windows it is at.

use super::Suite;
use crate::stand_in::bits;
use crate::{Fault, Faulty};
use interfaces::{Call, Direction, Exchange, Fields, Guarded, Participant, Readiness, Result};
use interfaces::{State, TimeWindow, WindowReport};

/// A participant in its life. The faulty wrapper is without faults unless the life has to be broken.
pub(super) struct Life<'a> {
    suite: &'a Suite<'a>,
    pub participant: Guarded<Faulty<Box<dyn Participant>>>,
    pub inputs: Fields,
    pub outputs: Fields,
    pub index: u64,
    pub iteration: u32,
}

/// A solution, comparable to the bit: everything but the time it took.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Answer {
    pub given: Given,
    pub sub_steps: u32,
}

/// What stands at a moment between windows, as bits.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Given {
    fields: Vec<u64>,
    window_limit: u64,
    scalars: Vec<u64>,
}

/// What stands in the outputs before a solution, unless a check wants something else.
pub(super) const UNTOUCHED: f64 = 7.25;

impl<'a> Life<'a> {
    /// Created, and no more.
    pub fn new(suite: &'a Suite<'a>, faults: Vec<Fault>) -> Self {
        let participant = suite.make();
        let description = participant.describe();
        let inputs = description.fields(Direction::In, suite.options.points);
        let outputs = description.fields(Direction::Out, suite.options.points);
        let participant = Guarded::new(Faulty::new(participant, faults));
        Self { suite, participant, inputs, outputs, index: 0, iteration: 0 }
    }

    /// Created and initialised.
    pub fn initialized(suite: &'a Suite<'a>) -> Result<Self, String> {
        let mut life = Self::new(suite, Vec::new());
        life.initialize().map_err(|error| format!("`initialize` failed: {error}"))?;
        Ok(life)
    }

    /// Driven to a state; broken by an error in the first window.
    pub fn in_state(suite: &'a Suite<'a>, state: State) -> Result<Self, String> {
        let broken = "error@0".parse().expect("a fault that can be read");
        let faults = if state == State::Broken { vec![broken] } else { Vec::new() };
        let mut life = Self::new(suite, faults);
        let calls: &[Call] = match state {
            State::Created => &[],
            State::Ready => &[Call::Initialize],
            State::Solving => &[Call::Initialize, Call::Start],
            State::Solved | State::Broken => &[Call::Initialize, Call::Start, Call::Finish],
            State::Terminated => &[Call::Initialize, Call::Terminate],
        };
        for call in calls {
            let made = life.call(*call, &[]);
            if state != State::Broken {
                made.map_err(|error| format!("`{call}` failed: {error}"))?;
            }
        }
        match life.participant.state() {
            found if found == state => Ok(life),
            found => Err(format!("{calls:?} led to {found} and not to {state}")),
        }
    }

    /// Makes a call, with the next window where it is a start and with `saved` where it is a restore.
    pub fn call(&mut self, call: Call, saved: &[u8]) -> Result<()> {
        match call {
            Call::Initialize => self.initialize().map(drop),
            Call::Start => self.start(0),
            Call::Finish => self.finish().map(drop),
            Call::Accept => self.accept(),
            Call::Save => self.participant.save().map(drop),
            Call::Restore => self.participant.restore(saved, &mut self.outputs).map(drop),
            Call::Terminate => self.participant.terminate(),
        }
    }

    pub fn initialize(&mut self) -> Result<Readiness> {
        let start = self.suite.options.start;
        (self.suite.options.inputs)(start, 0, &mut self.inputs);
        self.participant.initialize(start, &self.inputs, &mut self.outputs)
    }

    /// The window that comes next: sizes vary from window to window, and the times follow from the number
    /// alone.
    pub fn window(&self) -> TimeWindow {
        let options = self.suite.options;
        let size = |index: u64| options.size * [1.0, 0.5, 0.75][(index % 3) as usize];
        TimeWindow {
            index: self.index,
            iteration: self.iteration,
            start: options.start + (0..self.index).map(size).sum::<f64>(),
            size: size(self.index),
            sub_steps: options.sub_steps,
        }
    }

    pub fn start(&mut self, variant: u32) -> Result<()> {
        let window = self.window();
        let constants = self.inputs.clone();
        (self.suite.options.inputs)(window.end(), variant, &mut self.inputs);
        self.inputs.copy_from(&constants, |port| port.exchange == Exchange::Constant)?;
        let started = self.participant.start(&window, &self.inputs);
        if started.is_ok() {
            self.iteration += 1;
        }
        started
    }

    pub fn finish(&mut self) -> Result<Answer> {
        self.fill(UNTOUCHED);
        self.participant.finish(&mut self.outputs).map(|report| self.answer(&report))
    }

    pub fn accept(&mut self) -> Result<()> {
        self.participant.accept(None)?;
        (self.index, self.iteration) = (self.index + 1, 0);
        Ok(())
    }

    /// Starts and finishes the next window.
    pub fn solve(&mut self, variant: u32) -> Result<Answer, String> {
        let place = format!("window {}, iteration {}", self.index, self.iteration);
        self.start(variant).map_err(|error| format!("`start` failed in {place}: {error}"))?;
        self.finish().map_err(|error| format!("`finish` failed in {place}: {error}"))
    }

    /// Starts, finishes and accepts the next window.
    pub fn advance(&mut self, variant: u32) -> Result<Answer, String> {
        let answer = self.solve(variant)?;
        let place = format!("window {}", self.index);
        self.accept().map_err(|error| format!("`accept` failed in {place}: {error}"))?;
        Ok(answer)
    }

    pub fn save(&mut self) -> Result<Vec<u8>, String> {
        self.participant.save().map_err(|error| format!("`save` failed: {error}"))
    }

    /// Restores a state saved when window `index` was next, over outputs that held something else. Gives
    /// what stands there then: fields of every window, limit and scalars, to the bit.
    pub fn restore(&mut self, state: &[u8], index: u64) -> Result<Given, String> {
        self.fill(UNTOUCHED);
        let ready = self.participant.restore(state, &mut self.outputs);
        let ready = ready.map_err(|error| format!("`restore` failed: {error}"))?;
        (self.index, self.iteration) = (index, 0);
        let constants = self.outputs.iter().filter(|(port, _)| port.exchange == Exchange::Constant);
        for (port, array) in constants {
            if array.iter().any(|v| v.to_bits() != UNTOUCHED.to_bits()) {
                return Err(format!("`restore` wrote the constant field `{}`", port.name));
            }
        }
        Ok(Given::new(bits(&self.outputs), ready.window_limit, &ready.scalars))
    }

    /// Writes `value` over all outputs.
    pub fn fill(&mut self, value: f64) {
        self.outputs.iter_mut().for_each(|(_, array)| array.fill(value));
    }

    pub fn answer(&self, report: &WindowReport) -> Answer {
        let given = Given::new(bits(&self.outputs), report.window_limit, &report.scalars);
        Answer { given, sub_steps: report.sub_steps }
    }
}

impl Answer {
    /// Whether both are the same to the bit; else where they first differ.
    pub fn same_as(&self, other: &Self, what: &str) -> Result<(), String> {
        self.given.same_as(&other.given, what)?;
        if self.sub_steps != other.sub_steps {
            return Err(format!("{what}: {} and {} sub-steps", self.sub_steps, other.sub_steps));
        }
        Ok(())
    }
}

impl Given {
    /// Of fields of every window, limit (s) and scalars.
    pub fn new(fields: Vec<u64>, window_limit: f64, scalars: &[f64]) -> Self {
        let scalars = scalars.iter().map(|v| v.to_bits()).collect();
        Self { fields, window_limit: window_limit.to_bits(), scalars }
    }

    /// Whether both are the same to the bit; else where they first differ.
    pub fn same_as(&self, other: &Self, what: &str) -> Result<(), String> {
        for (name, ours, theirs) in
            [("output", &self.fields, &other.fields), ("scalar", &self.scalars, &other.scalars)]
        {
            if ours.len() != theirs.len() {
                return Err(format!("{what}: {} and {} {name}s", ours.len(), theirs.len()));
            }
            if let Some(at) = (0..ours.len()).find(|&i| ours[i] != theirs[i]) {
                let (a, b) = (f64::from_bits(ours[at]), f64::from_bits(theirs[at]));
                return Err(format!("{what}: {name} {at} is {a:e} and then {b:e}"));
            }
        }
        if self.window_limit != other.window_limit {
            return Err(format!("{what}: window limits differ"));
        }
        Ok(())
    }
}
