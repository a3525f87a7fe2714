//! Scenarios: what shall be otherwise in a run than its participants have it, and who shall fail when. For
//! tests of couplings and for sensitivity.
//!
//! A scenario is a file beside the case. Its changes act between a participant and the coupler ([`Altered`]):
//! neither knows of it.

mod altered;
mod change;

pub use altered::{Altered, Blow, Strike};
pub use change::Change;

use change::{Corrupt, How, Place};
use interfaces::port::names;
use interfaces::{Direction, Role};
use output::files;
use rustix::process::Signal;
use serde::Deserialize;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Duration;
use thiserror::Error;

/// File of the scenario in the folder of the outputs: that which was given.
pub const FILE: &str = "scenario.toml";
/// Quantities that cross every window.
const QUANTITIES: [&str; 11] = [
    names::POSITION,
    names::VELOCITY,
    names::PRESSURE_GRADIENT,
    names::PRESSURE,
    names::PAIR_REACTION,
    names::NORMAL,
    names::HELD_PRESSURE_GRADIENT,
    names::START_PRESSURE_GRADIENT,
    names::DISPLACEMENT,
    names::FORCE,
    names::START_FORCE,
];
/// Longest file that is read (bytes).
const LONGEST: u64 = 1 << 20;

/// What shall be otherwise in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scenario {
    /// Where it was read from.
    pub path: PathBuf,
    /// As it was written.
    pub text: String,
    /// Changes of quantities, in the order of the file, in which they act.
    pub changes: Vec<Change>,
    /// Faults.
    pub faults: Vec<Fault>,
}

/// A participant fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Which.
    pub of: Role,
    /// With the first window that starts then or later (s).
    pub at: f64,
    /// How.
    pub kind: FaultKind,
}

/// How a participant fails.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// Its process gets a signal: killed, terminated, aborted.
    Signal(Signal),
    /// Its process is stopped for so long, on the clock; for good where nothing is said.
    Stop(Option<Duration>),
    /// It fails with these words.
    Error(String),
}

/// A scenario is none.
#[derive(Debug, Error)]
#[error("{}: {}", .path.display(), .mistakes.join("\n  "))]
pub struct ScenarioError {
    /// Its file.
    pub path: PathBuf,
    /// All that is wrong with it, each with key, value and remedy.
    pub mistakes: Vec<String>,
}

/// As it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default)]
    change: Vec<WrittenChange>,
    #[serde(default)]
    fault: Vec<WrittenFault>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenChange {
    given: Option<String>,
    taken: Option<String>,
    from: Option<f64>,
    until: Option<f64>,
    points: Option<Vec<usize>>,
    component: Option<String>,
    #[serde(rename = "override")]
    set: Option<f64>,
    bias: Option<f64>,
    scale: Option<f64>,
    delay: Option<f64>,
    drop: Option<bool>,
    noise: Option<f64>,
    seed: Option<u64>,
    corrupt: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenFault {
    of: String,
    at: f64,
    kind: String,
    #[serde(rename = "for")]
    lasts: Option<f64>,
}

impl Scenario {
    /// Reads a scenario.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let refused = |mistakes| ScenarioError { path: path.to_owned(), mistakes };
        let text = files::read_text(path, LONGEST);
        let text = text.map_err(|error| refused(vec![format!("failed to read it: {error}")]))?;
        let written: Written =
            toml::from_str(&text).map_err(|error| refused(vec![error.to_string().trim().to_owned()]))?;
        let mut scenario = Self { path: path.to_owned(), text, ..Self::default() };
        let mut mistakes = Vec::new();
        for (index, change) in written.change.into_iter().enumerate() {
            let place = format!("change.{index}");
            match change.understood(index) {
                Ok(change) => scenario.changes.push(change),
                Err(found) => mistakes.extend(found.into_iter().map(|what| format!("{place}.{what}"))),
            }
        }
        for (index, fault) in written.fault.into_iter().enumerate() {
            let place = format!("fault.{index}");
            match fault.understood() {
                Ok(fault) => scenario.faults.push(fault),
                Err(found) => mistakes.extend(found.into_iter().map(|what| format!("{place}.{what}"))),
            }
        }
        if scenario.changes.is_empty() && scenario.faults.is_empty() && mistakes.is_empty() {
            mistakes.push("it changes nothing; write a [[change]] or a [[fault]]".to_owned());
        }
        if mistakes.is_empty() { Ok(scenario) } else { Err(refused(mistakes)) }
    }

    /// Holds it against a run of the sides `there`, in one process or not.
    ///
    /// # Errors
    /// Sides that the run does not have, signals to processes that there are not.
    pub fn fits(&self, there: &[Role], in_process: bool) -> Result<(), ScenarioError> {
        let of_changes = self.changes.iter().map(|change| change.place.role);
        let of_faults = self.faults.iter().map(|fault| fault.of);
        let mut missing: Vec<_> = of_changes.chain(of_faults).filter(|role| !there.contains(role)).collect();
        missing.dedup();
        let mut mistakes: Vec<_> =
            missing.into_iter().map(|role| format!("the case has no {role} that it could change")).collect();
        // Those that participants have, whoever they are: what only one of them has is seen when it has come.
        for change in &self.changes {
            let (direction, quantity) = (change.place.direction, &change.place.quantity);
            if !QUANTITIES.contains(&quantity.as_str()) {
                mistakes.push(format!(
                    "change.{}.{} = \"{}.{quantity}\": there is no such quantity; write one of {}",
                    change.number,
                    if direction == Direction::Out { "given" } else { "taken" },
                    change.place.role,
                    QUANTITIES.join(", ")
                ));
            }
        }
        let is_signal = |fault: &&Fault| !matches!(fault.kind, FaultKind::Error(_));
        if in_process && let Some(fault) = self.faults.iter().find(is_signal) {
            mistakes.push(format!(
                "the {} has no process that could be killed or stopped; leave out --in-process, or write kind = \"error: WORDS\"",
                fault.of
            ));
        }
        if mistakes.is_empty() { Ok(()) } else { Err(ScenarioError { path: self.path.clone(), mistakes }) }
    }

    /// What of it is of the participant `role`; nothing where nothing is.
    pub(crate) fn of(&self, role: Role) -> Option<Of> {
        let changes: Vec<_> =
            self.changes.iter().filter(|change| change.place.role == role).cloned().collect();
        let faults: Vec<_> = self.faults.iter().filter(|fault| fault.of == role).cloned().collect();
        (!changes.is_empty() || !faults.is_empty()).then_some(Of { changes, faults })
    }
}

/// What of a scenario is of one participant.
pub struct Of {
    /// Changes of what it takes and gives.
    pub changes: Vec<Change>,
    /// Its faults.
    pub faults: Vec<Fault>,
}

/// What a scenario did in a run, shared by those who do it and who tells of it.
#[derive(Clone, Default)]
pub struct Did(Rc<RefCell<Vec<String>>>);

impl Did {
    /// Takes lines down.
    pub fn tell(&self, lines: impl IntoIterator<Item = String>) {
        self.0.borrow_mut().extend(lines);
    }

    /// All lines.
    pub fn lines(&self) -> Vec<String> {
        self.0.borrow().clone()
    }
}

fn role(word: &str) -> Option<Role> {
    [Role::Fluid, Role::Structure].into_iter().find(|role| role.to_string() == word)
}

impl WrittenChange {
    fn understood(self, number: usize) -> Result<Change, Vec<String>> {
        let mut mistakes = Vec::new();
        let place = match (&self.given, &self.taken) {
            (Some(words), None) => place("given", words, Direction::Out),
            (None, Some(words)) => place("taken", words, Direction::In),
            _ => Err("given, taken: exactly one of them says which quantity; write for example given = \"fluid.pressure_gradient\"".to_owned()),
        };
        let (from, until) = (self.from.unwrap_or(0.0), self.until.unwrap_or(f64::INFINITY));
        if from.is_nan() || from < 0.0 {
            mistakes.push(format!("from = {from}: it has to be 0 or more; give the time in s"));
        } else if until.is_nan() || until <= from {
            mistakes.push(format!("until = {until}: it has to be behind from = {from}; give both in s"));
        }
        let mut points = self.points;
        if let Some(points) = &mut points {
            points.sort_unstable();
            points.dedup();
        }
        if points.as_ref().is_some_and(Vec::is_empty) {
            mistakes.push("points = []: there is none; leave it out for all".to_owned());
        }
        let component = match self.component.as_deref() {
            None => Ok(None),
            Some("x") => Ok(Some(0)),
            Some("y") => Ok(Some(1)),
            Some("z") => Ok(Some(2)),
            Some(other) => Err(format!(
                "component = \"{other}\": there is none; write x, y or z, or leave it out for all"
            )),
        };
        let hows: Vec<_> = [
            self.set.map(How::Override),
            self.bias.map(How::Bias),
            self.scale.map(How::Scale),
            self.delay.map(How::Delay),
            self.drop.filter(|drop| *drop).map(|_| How::Drop),
            self.noise.map(|deviation| How::Noise { deviation, seed: self.seed.unwrap_or(0) }),
        ]
        .into_iter()
        .flatten()
        .collect();
        let corrupt = self.corrupt.as_deref().map(|word| {
            Corrupt::from_word(word).ok_or_else(|| {
                format!("corrupt = \"{word}\": there is no such way; write not-a-number, infinite or bit:N, N from 0 (the smallest) to 63 (the sign)")
            })
        });
        let how = match (&hows[..], corrupt) {
            ([how], None) => how.checked(),
            ([], Some(corrupt)) => corrupt.map(How::Corrupt),
            _ => Err(
                "override, bias, scale, delay, drop, noise, corrupt: exactly one of them says what is done"
                    .to_owned(),
            ),
        };
        if self.seed.is_some() && self.noise.is_none() {
            mistakes.push("seed: only noise has one; leave it out".to_owned());
        }
        match (place, component, how) {
            (Ok(place), Ok(component), Ok(how)) if mistakes.is_empty() => {
                Ok(Change { number, place, from, until, points, component, how })
            }
            (place, component, how) => {
                let found = [place.err(), component.err(), how.err()];
                Err(found.into_iter().flatten().chain(mistakes).collect())
            }
        }
    }
}

fn place(key: &str, words: &str, direction: Direction) -> Result<Place, String> {
    let split = words.split_once('.').and_then(|(side, quantity)| Some((role(side)?, quantity)));
    match split.filter(|(_, quantity)| !quantity.is_empty()) {
        Some((role, quantity)) => Ok(Place { role, direction, quantity: quantity.to_owned() }),
        None => Err(format!(
            "{key} = \"{words}\": it names no side and quantity; write for example {key} = \"structure.position\""
        )),
    }
}

impl WrittenFault {
    fn understood(self) -> Result<Fault, Vec<String>> {
        let mut mistakes = Vec::new();
        let of = role(&self.of);
        if of.is_none() {
            mistakes.push(format!("of = \"{}\": there is no such side; write fluid or structure", self.of));
        }
        if !(self.at >= 0.0 && self.at.is_finite()) {
            mistakes.push(format!("at = {}: give the time in s", self.at));
        }
        let lasts = self.lasts.map(Duration::try_from_secs_f64);
        let lasts = lasts.transpose().unwrap_or_else(|_| {
            mistakes.push("for: give the time on the clock in s".to_owned());
            None
        });
        let kind = match (self.kind.as_str(), self.kind.strip_prefix("error")) {
            ("kill", _) => Some(FaultKind::Signal(Signal::KILL)),
            ("terminate", _) => Some(FaultKind::Signal(Signal::TERM)),
            ("abort", _) => Some(FaultKind::Signal(Signal::ABORT)),
            ("stop", _) => Some(FaultKind::Stop(lasts)),
            (_, Some("")) => Some(FaultKind::Error("the scenario says so".to_owned())),
            (_, Some(words)) => {
                words.strip_prefix(':').map(|words| FaultKind::Error(words.trim().to_owned()))
            }
            _ => None,
        };
        if kind.is_none() {
            mistakes.push(format!(
                "kind = \"{}\": there is no such fault; write kill, terminate, abort, stop, or error: WORDS",
                self.kind
            ));
        }
        if lasts.is_some() && self.kind != "stop" {
            mistakes.push("for: only a stop lasts; leave it out".to_owned());
        }
        match (of, kind) {
            (Some(of), Some(kind)) if mistakes.is_empty() => Ok(Fault { of, at: self.at, kind }),
            _ => Err(mistakes),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Scenario, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.toml");
        std::fs::write(&path, text).unwrap();
        Scenario::read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn a_scenario_is_read() {
        let scenario = read(
            "[[change]]\ngiven = 'fluid.pressure_gradient'\nscale = 0.9\nfrom = 0.1\nuntil = 0.2\n\
             [[change]]\ntaken = 'fluid.position'\npoints = [0, 3]\ncomponent = 'y'\nbias = 1e-3\n\
             [[fault]]\nof = 'structure'\nat = 0.5\nkind = 'stop'\nfor = 2",
        );
        let scenario = scenario.unwrap();
        assert_eq!(scenario.changes.len(), 2);
        assert_eq!(scenario.changes[1].component, Some(1));
        assert_eq!(scenario.faults[0].kind, FaultKind::Stop(Some(Duration::from_secs(2))));
        let of = scenario.of(Role::Structure).unwrap();
        assert!(of.changes.is_empty() && of.faults.len() == 1);
    }

    #[test]
    fn every_mistake_is_told_at_once() {
        let error = read(
            "[[change]]\ngiven = 'water.pressure'\nscale = 0.9\nbias = 1\ncomponent = 'w'\n\
             [[change]]\ngiven = 'fluid.pressure'\ntaken = 'fluid.position'\ncorrupt = 'bit:64'\n\
             [[change]]\ngiven = 'fluid.pressure'\ndelay = -1\nuntil = 0\nseed = 3\n\
             [[change]]\ngiven = 'fluid.pressure'\nbias = 1\nfrom = -1\npoints = []\n\
             [[fault]]\nof = 'gas'\nat = -1\nkind = 'sulk'\nfor = 1",
        )
        .unwrap_err();
        for part in [
            "change.0.given = \"water.pressure\"",
            "change.0.component = \"w\"",
            "change.0.override, bias",
            "change.1.given, taken: exactly one",
            "change.1.corrupt = \"bit:64\"",
            "change.2.until = 0: it has to be behind from = 0",
            "change.3.from = -1: it has to be 0 or more",
            "change.3.points = []",
            "change.2.delay = -1",
            "change.2.seed",
            "fault.0.of = \"gas\"",
            "fault.0.at = -1",
            "fault.0.kind = \"sulk\"",
            "fault.0.for: only a stop lasts",
        ] {
            assert!(error.contains(part), "`{part}` is not in: {error}");
        }
        assert!(read("").unwrap_err().contains("it changes nothing"));
        let unknown = read("[[change]]\ngivven = 'fluid.pressure'").unwrap_err();
        assert!(unknown.contains("givven") && unknown.contains("line 2"), "{unknown}");
    }
}
