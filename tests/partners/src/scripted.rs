//! A participant that plays a fixed part: what it is told to give, for what it is told to expect.

use interfaces::{
    Description, Fields, Participant, ParticipantError, Readiness, Result, TimeWindow, WindowReport,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use words::bytes::{Reader, Writer};

const MAGIC: &[u8; 8] = b"mnscscr1";

/// Fields by port name, each flat, point by point. Ports left out are not compared, and not written.
pub type Arrays = BTreeMap<String, Vec<f64>>;

/// The part, as data: it can be written in a test or read from a JSON file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Script {
    /// What the participant is.
    pub description: Description,
    /// What `initialize` must bring.
    #[serde(default)]
    pub expected: Arrays,
    /// What `initialize` gives.
    #[serde(default)]
    pub given: Arrays,
    /// What `initialize` says. In JSON, which has no infinity, name a large window limit.
    pub readiness: Readiness,
    /// The solutions, in order.
    pub solutions: Vec<Solution>,
    /// Largest difference from an expected value, relative to the larger of 1 and its size; 0 asks for the
    /// same bits up to the sign of zero.
    #[serde(default)]
    pub tolerance: f64,
}

/// One start and finish.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// The window that must be started. Start and size are compared within the tolerance.
    pub window: TimeWindow,
    /// What `start` must bring.
    #[serde(default)]
    pub expected: Arrays,
    /// What `finish` gives.
    #[serde(default)]
    pub given: Arrays,
    /// What `finish` says.
    pub report: WindowReport,
    /// Whether this solution must be accepted (else it must be solved again).
    pub accepted: bool,
}

/// A script being played. Where the coupler leaves it, the call fails with the place and both values;
/// `terminate` fails where solutions are left over.
///
/// The saved state is the place in the script.
pub struct Scripted {
    script: Script,
    played: usize,
    open: Open,
    left: bool,
}

/// What the last solution played still waits for.
#[derive(Clone, Copy, PartialEq)]
enum Open {
    Nothing,
    Finish,
    Accept,
}

impl Scripted {
    /// Plays the script from its start.
    pub fn new(script: Script) -> Self {
        Self { script, played: 0, open: Open::Nothing, left: false }
    }

    /// Solutions started so far.
    pub fn played(&self) -> usize {
        self.played
    }

    fn fail<T>(&mut self, what: &str) -> Result<T> {
        self.left = true;
        Err(ParticipantError::Failed(format!(
            "the coupler left the script at solution {}: {what}",
            self.played
        )))
    }

    fn compare(&mut self, expected: &Arrays, inputs: &Fields) -> Result<()> {
        for (name, values) in expected {
            let Some(found) = inputs.get(name) else {
                return self.fail(&format!("it brought no field `{name}`"));
            };
            if found.len() != values.len() {
                let (found, expected) = (found.len(), values.len());
                return self.fail(&format!("`{name}` has {found} values where the script has {expected}"));
            }
            let differs = (0..found.len()).find(|&i| !self.same(values[i], found[i]));
            if let Some(at) = differs {
                let (found, expected) = (found[at], values[at]);
                return self.fail(&format!("`{name}`[{at}] is {found} where the script has {expected}"));
            }
        }
        Ok(())
    }

    /// What stood there when the script was at its place: what was given last, field by field.
    fn give_last(&self, outputs: &mut Fields) -> Result<Readiness> {
        let played = &self.script.solutions[..self.played];
        for given in std::iter::once(&self.script.given).chain(played.iter().map(|s| &s.given)) {
            give(given, outputs)?;
        }
        Ok(played.last().map_or_else(
            || self.script.readiness.clone(),
            |Solution { report, .. }| Readiness {
                window_limit: report.window_limit,
                scalars: report.scalars.clone(),
            },
        ))
    }

    fn same(&self, expected: f64, found: f64) -> bool {
        (expected - found).abs() <= self.script.tolerance * expected.abs().max(1.0)
    }
}

fn give(given: &Arrays, outputs: &mut Fields) -> Result<()> {
    for (name, values) in given {
        match outputs.get_mut(name) {
            Some(array) if array.len() == values.len() => array.copy_from_slice(values),
            Some(array) => {
                let (found, expected) = (values.len(), array.len());
                let what = format!("the script gives {found} values for `{name}` where {expected} belong");
                return Err(ParticipantError::Failed(what));
            }
            None => {
                return Err(ParticipantError::Failed(format!(
                    "the script gives `{name}`, which it does not describe"
                )));
            }
        }
    }
    Ok(())
}

impl Participant for Scripted {
    fn describe(&self) -> &Description {
        &self.script.description
    }

    fn initialize(&mut self, _start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        let expected = self.script.expected.clone();
        self.compare(&expected, inputs)?;
        give(&self.script.given, outputs)?;
        Ok(self.script.readiness.clone())
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        match self.open {
            Open::Nothing => {}
            Open::Finish => return self.fail("it started a window before it finished the last"),
            Open::Accept => return self.fail("it started a window where the script accepts the last"),
        }
        let Some(solution) = self.script.solutions.get(self.played).cloned() else {
            return self.fail(&format!("it started window {} after the end", window.index));
        };
        let wanted = solution.window;
        if (wanted.index, wanted.iteration) != (window.index, window.iteration) {
            return self.fail(&format!(
                "it started window {}, iteration {}, where the script has window {}, iteration {}",
                window.index, window.iteration, wanted.index, wanted.iteration
            ));
        }
        if !self.same(wanted.start, window.start) || !self.same(wanted.size, window.size) {
            return self.fail(&format!(
                "the window starts at {} s and lasts {} s, where the script has {} s and {} s",
                window.start, window.size, wanted.start, wanted.size
            ));
        }
        if wanted.sub_steps != window.sub_steps {
            let (found, expected) = (window.sub_steps, wanted.sub_steps);
            return self.fail(&format!("it asks for sub-steps {found:?} where the script has {expected:?}"));
        }
        self.compare(&solution.expected, inputs)?;
        (self.played, self.open) = (self.played + 1, Open::Finish);
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        if self.open != Open::Finish {
            return self.fail("it finished a window that it did not start");
        }
        let solution = &self.script.solutions[self.played - 1];
        self.open = if solution.accepted { Open::Accept } else { Open::Nothing };
        give(&solution.given, outputs)?;
        Ok(solution.report.clone())
    }

    fn accept(&mut self, _snapshot: Option<u64>) -> Result<()> {
        if self.open != Open::Accept {
            return self.fail("it accepted where the script does not");
        }
        self.open = Open::Nothing;
        Ok(())
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        let mut state = Writer::new(MAGIC);
        state.usize(self.played);
        Ok(state.finish())
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let read = |state| {
            let mut state = Reader::new("script's state", MAGIC, state)?;
            let played = state.usize("place")?;
            state.finish().map(|()| played)
        };
        let played: Result<usize, words::bytes::Error> = read(state);
        match played {
            Ok(played) if played <= self.script.solutions.len() => {
                (self.played, self.open) = (played, Open::Nothing);
                self.give_last(outputs)
            }
            _ => self.fail("it restored a state that is no place in the script"),
        }
    }

    fn terminate(&mut self) -> Result<()> {
        let left_over = self.script.solutions.len() - self.played;
        if left_over > 0 && !self.left {
            return self.fail(&format!("it terminated with {left_over} solution(s) left over"));
        }
        Ok(())
    }
}
