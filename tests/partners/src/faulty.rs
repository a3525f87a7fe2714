//! Any participant, broken at a chosen place: what the rest must survive.

use interfaces::{
    Call, Description, Direction, Exchange, Fields, Participant, ParticipantError, Readiness, Result,
};
use interfaces::{TimeWindow, WindowReport};
use rustix::process::{Signal, getpid, kill_process};
use std::str::FromStr;
use std::time::Duration;
use thiserror::Error;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// The call returns an error.
    Error,
    /// The call panics.
    Panic,
    /// The first field given has a component that is not a number at this point.
    NotANumber(usize),
    /// The first field given every window has another last bit in its first component at this point.
    Bit(usize),
    /// The first field given has an infinite component at this point.
    Infinite(usize),
    /// The fields given are of no points.
    NoPoints,
    /// The report has one scalar too many.
    Scalars,
    /// The report names this window limit (s).
    WindowLimit(f64),
    /// The call does not return.
    Hang,
    /// The call takes so much longer (s).
    Slow(f64),
    /// The process aborts.
    Abort,
    /// The process ends as if all were done (exit code 0).
    Exit,
    /// The process is killed (`SIGKILL`).
    Kill,
    /// The process is stopped (`SIGSTOP`); it goes on when it is continued.
    Stop,
}

/// A fault and its place. Written `KIND@WHERE`, where `KIND` is `error`, `panic`, `nan[:POINT]`,
/// `inf[:POINT]`, `bit[:POINT]`, `no-points`, `scalars`, `limit:SECONDS`, `hang`, `slow:SECONDS`, `abort`,
/// `exit`, `kill` or `stop`, and `WHERE` is `WINDOW[.ITERATION][/CALL]` (in `finish` where no call is named;
/// `*` is every window) or a `CALL` alone: `nan@12`, `kill@3.1/start`, `slow:0.01@*`, `error@terminate`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What goes wrong.
    pub kind: FaultKind,
    /// In which call.
    pub call: Call,
    /// In which window (the last one started), or in any and outside.
    pub window: Option<u64>,
    /// In which iteration of it, or in all.
    pub iteration: Option<u32>,
}

/// A fault that cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "fault `{text}`: {what}; write KIND@WHERE such as nan:3@12, kill@3.1/start, limit:0@5, error@terminate"
)]
pub struct FaultError {
    /// What was written.
    pub text: String,
    /// What is wrong with it.
    pub what: String,
}

const CALLS: [Call; 7] =
    [Call::Initialize, Call::Start, Call::Finish, Call::Accept, Call::Save, Call::Restore, Call::Terminate];

impl FromStr for Fault {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, FaultError> {
        let wrong = |what: &str| FaultError { text: text.to_owned(), what: what.to_owned() };
        let call = |name: &str| {
            let found = CALLS.into_iter().find(|call| call.to_string() == name);
            found.ok_or_else(|| wrong(&format!("there is no call `{name}`")))
        };
        let (kind, place) = text.split_once('@').ok_or_else(|| wrong("it names no place"))?;
        let kind = kind_from(kind).map_err(|what| wrong(&what))?;
        let (place, named) = match place.split_once('/') {
            Some((place, name)) => (place, Some(call(name)?)),
            None => (place, None),
        };
        let (window, iteration) = match place.split_once('.') {
            Some((window, iteration)) => (window, Some(iteration)),
            None => (place, None),
        };
        let iteration = iteration.map(|i| i.parse().map_err(|_| wrong("the iteration is no number")));
        let iteration = iteration.transpose()?;
        let (window, call) = match (window, window.parse()) {
            ("*", _) => (None, named.unwrap_or(Call::Finish)),
            (_, Ok(number)) => (Some(number), named.unwrap_or(Call::Finish)),
            (name, Err(_)) if named.is_none() && iteration.is_none() => (None, call(name)?),
            _ => return Err(wrong("the window is no number")),
        };
        let reports = matches!(call, Call::Initialize | Call::Finish);
        let needs_report = matches!(
            kind,
            FaultKind::NotANumber(_)
                | FaultKind::Bit(_)
                | FaultKind::Infinite(_)
                | FaultKind::NoPoints
                | FaultKind::Scalars
                | FaultKind::WindowLimit(_)
        );
        if needs_report && !reports {
            return Err(wrong(&format!("`{call}` gives nothing that could be wrong")));
        }
        Ok(Self { kind, call, window, iteration })
    }
}

fn kind_from(text: &str) -> Result<FaultKind, String> {
    let (name, value) = match text.split_once(':') {
        Some((name, value)) => (name, Some(value)),
        None => (text, None),
    };
    let seconds = || {
        let value = value.ok_or_else(|| format!("`{name}` needs seconds, as in {name}:0.1"))?;
        value.parse::<f64>().map_err(|_| format!("`{value}` is no number of seconds"))
    };
    let point = || {
        let read = |point: &str| point.parse::<usize>().map_err(|_| format!("`{point}` is no point"));
        value.map_or(Ok(0), read)
    };
    let kind = match name {
        "nan" => FaultKind::NotANumber(point()?),
        "inf" => FaultKind::Infinite(point()?),
        "bit" => FaultKind::Bit(point()?),
        "limit" => FaultKind::WindowLimit(seconds()?),
        "slow" => match seconds()? {
            time if time >= 0.0 && time.is_finite() => FaultKind::Slow(time),
            time => return Err(format!("{time} s cannot be waited")),
        },
        _ if value.is_some() => return Err(format!("`{name}` takes no value")),
        "error" => FaultKind::Error,
        "panic" => FaultKind::Panic,
        "no-points" => FaultKind::NoPoints,
        "scalars" => FaultKind::Scalars,
        "hang" => FaultKind::Hang,
        "abort" => FaultKind::Abort,
        "exit" => FaultKind::Exit,
        "kill" => FaultKind::Kill,
        "stop" => FaultKind::Stop,
        _ => return Err(format!("there is no fault `{name}`")),
    };
    Ok(kind)
}

/// A participant with faults. What strikes before a call (error, panic, death, waiting) keeps it from the
/// participant within or delays it; what spoils an answer comes after.
pub struct Faulty<P> {
    inner: P,
    faults: Vec<Fault>,
    window: Option<(u64, u32)>,
}

impl<P: Participant> Faulty<P> {
    /// Breaks `inner` by each of the faults, at every place that fits.
    pub fn new(inner: P, faults: Vec<Fault>) -> Self {
        Self { inner, faults, window: None }
    }

    fn due(&self, call: Call) -> Vec<FaultKind> {
        let here = |fault: &&Fault| {
            fault.call == call
                && fault.window.is_none_or(|w| self.window.is_some_and(|(window, _)| window == w))
                && fault.iteration.is_none_or(|i| self.window.is_some_and(|(_, iteration)| iteration == i))
        };
        self.faults.iter().filter(here).map(|fault| fault.kind).collect()
    }

    fn strike(&self, call: Call) -> Result<()> {
        let place = match self.window {
            Some((window, iteration)) => format!("in `{call}`, window {window}, iteration {iteration}"),
            None => format!("in `{call}`"),
        };
        for kind in self.due(call) {
            match kind {
                FaultKind::Error => {
                    return Err(ParticipantError::Failed(format!("fault as told: an error {place}")));
                }
                FaultKind::Panic => panic!("fault as told: a panic {place}"),
                FaultKind::Hang => loop {
                    std::thread::sleep(Duration::from_secs(3600));
                },
                FaultKind::Slow(seconds) => std::thread::sleep(Duration::from_secs_f64(seconds)),
                FaultKind::Abort => std::process::abort(),
                FaultKind::Exit => std::process::exit(0),
                FaultKind::Kill => raise(Signal::KILL)?,
                FaultKind::Stop => raise(Signal::STOP)?,
                FaultKind::NotANumber(_)
                | FaultKind::Bit(_)
                | FaultKind::Infinite(_)
                | FaultKind::NoPoints
                | FaultKind::Scalars
                | FaultKind::WindowLimit(_) => {}
            }
        }
        Ok(())
    }

    fn spoil(&self, call: Call, outputs: &mut Fields, limit: &mut f64, scalars: &mut Vec<f64>) {
        let set = |outputs: &mut Fields, point: usize, to: f64| {
            if let Some((port, array)) = outputs.iter_mut().next()
                && let Some(value) = array.get_mut(point * port.components)
            {
                *value = to;
            }
        };
        for kind in self.due(call) {
            match kind {
                FaultKind::NotANumber(point) => set(outputs, point, f64::NAN),
                FaultKind::Infinite(point) => set(outputs, point, f64::INFINITY),
                FaultKind::Bit(point) => {
                    let mut every = outputs.iter_mut().filter(|(p, _)| p.exchange == Exchange::EveryWindow);
                    if let Some((port, array)) = every.next()
                        && let Some(value) = array.get_mut(point * port.components)
                    {
                        *value = f64::from_bits(value.to_bits() ^ 1);
                    }
                }
                FaultKind::NoPoints => {
                    let ports = outputs.ports().iter();
                    let ports: Vec<_> =
                        ports.map(|p| interfaces::Port { points: Some(0), ..p.clone() }).collect();
                    *outputs = Fields::new(&ports, Direction::Out, 0);
                }
                FaultKind::Scalars => scalars.push(0.0),
                FaultKind::WindowLimit(seconds) => *limit = seconds,
                _ => {}
            }
        }
    }
}

fn raise(signal: Signal) -> Result<()> {
    let sent = kill_process(getpid(), signal);
    sent.map_err(|error| ParticipantError::Failed(format!("failed to signal the own process: {error}")))
}

impl<P: Participant> Participant for Faulty<P> {
    fn describe(&self) -> &Description {
        self.inner.describe()
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.strike(Call::Initialize)?;
        let mut ready = self.inner.initialize(start, inputs, outputs)?;
        self.spoil(Call::Initialize, outputs, &mut ready.window_limit, &mut ready.scalars);
        Ok(ready)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        self.window = Some((window.index, window.iteration));
        self.strike(Call::Start)?;
        self.inner.start(window, inputs)
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        self.strike(Call::Finish)?;
        let mut report = self.inner.finish(outputs)?;
        self.spoil(Call::Finish, outputs, &mut report.window_limit, &mut report.scalars);
        Ok(report)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        self.strike(Call::Accept)?;
        self.inner.accept(snapshot)
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        self.strike(Call::Save)?;
        self.inner.save()
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        self.strike(Call::Restore)?;
        self.inner.restore(state, outputs)
    }

    fn terminate(&mut self) -> Result<()> {
        self.strike(Call::Terminate)?;
        self.inner.terminate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_read_from_words() {
        let read = |text: &str| text.parse::<Fault>();
        let fault = |kind, call, window, iteration| Ok(Fault { kind, call, window, iteration });
        assert_eq!(read("nan@12"), fault(FaultKind::NotANumber(0), Call::Finish, Some(12), None));
        assert_eq!(read("nan:7@2.1"), fault(FaultKind::NotANumber(7), Call::Finish, Some(2), Some(1)));
        assert_eq!(read("bit:2@7"), fault(FaultKind::Bit(2), Call::Finish, Some(7), None));
        assert_eq!(read("inf:7@2"), fault(FaultKind::Infinite(7), Call::Finish, Some(2), None));
        assert_eq!(read("exit@2"), fault(FaultKind::Exit, Call::Finish, Some(2), None));
        assert_eq!(read("kill@3.1/start"), fault(FaultKind::Kill, Call::Start, Some(3), Some(1)));
        assert_eq!(read("slow:0.01@*"), fault(FaultKind::Slow(0.01), Call::Finish, None, None));
        assert_eq!(read("error@terminate"), fault(FaultKind::Error, Call::Terminate, None, None));
        assert_eq!(
            read("limit:0@initialize"),
            fault(FaultKind::WindowLimit(0.0), Call::Initialize, None, None)
        );
        for wrong in
            ["nan", "oops@3", "error@x", "error@3/x", "error@3.x", "nan@3/start", "hang:2@1", "slow@1"]
        {
            let message = read(wrong).unwrap_err().to_string();
            assert!(message.contains(&format!("`{wrong}`")) && message.contains("KIND@WHERE"), "{message}");
        }
    }
}
