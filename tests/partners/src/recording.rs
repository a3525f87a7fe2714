//! A participant whose calls are kept, for tests of the order of calls.

use interfaces::{Call, Description, Fields, Participant, Readiness, Result, Role};
use interfaces::{TimeWindow, WindowReport};
use std::sync::{Arc, Mutex, MutexGuard};

/// One call with its arguments, and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Whose call.
    pub role: Role,
    /// Which call.
    pub call: Call,
    /// Start time (s), for `initialize`.
    pub start: Option<f64>,
    /// The window, for `start`.
    pub window: Option<TimeWindow>,
    /// What went in, for `initialize` and `start`.
    pub inputs: Option<Fields>,
    /// What came out, for `initialize`, `finish` and `restore`, where they succeeded.
    pub outputs: Option<Fields>,
    /// The snapshot's number, for `accept`.
    pub snapshot: Option<u64>,
    /// Size of the state (bytes), for `save` and `restore`.
    pub bytes: Option<usize>,
    /// The error's message, where it failed.
    pub error: Option<String>,
}

impl Recorded {
    /// The call in a few words, to compare an order of calls with a list: `structure start 3.1` (window and
    /// iteration), `fluid accept #2` (snapshot), else role and call.
    pub fn brief(&self) -> String {
        let window = self.window.map(|w| format!(" {}.{}", w.index, w.iteration));
        let snapshot = self.snapshot.map(|number| format!(" #{number}"));
        format!("{} {}{}{}", self.role, self.call, window.unwrap_or_default(), snapshot.unwrap_or_default())
    }
}

/// A list of calls, which several recorded participants may share: it then holds the order among them.
#[derive(Clone, Debug, Default)]
pub struct Log(Arc<Mutex<Vec<Recorded>>>);

impl Log {
    /// All calls so far, in order.
    pub fn calls(&self) -> Vec<Recorded> {
        self.lock().clone()
    }

    /// All calls so far in a few words each; see [`Recorded::brief`].
    pub fn brief(&self) -> Vec<String> {
        self.lock().iter().map(Recorded::brief).collect()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Recorded>> {
        self.0.lock().expect("nothing panics while it holds the log")
    }
}

/// A participant whose calls go into a log and on to the participant within.
pub struct Recording<P> {
    inner: P,
    log: Log,
}

impl<P: Participant> Recording<P> {
    /// Records the calls of `inner` in `log`.
    pub fn new(inner: P, log: Log) -> Self {
        Self { inner, log }
    }

    fn keep<T>(&self, call: Call, result: Result<T>, fill: impl FnOnce(&mut Recorded)) -> Result<T> {
        let mut record = Recorded {
            role: self.inner.describe().role,
            call,
            start: None,
            window: None,
            inputs: None,
            outputs: None,
            snapshot: None,
            bytes: None,
            error: result.as_ref().err().map(ToString::to_string),
        };
        fill(&mut record);
        self.log.lock().push(record);
        result
    }
}

impl<P: Participant> Participant for Recording<P> {
    fn describe(&self) -> &Description {
        self.inner.describe()
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        let result = self.inner.initialize(start, inputs, outputs);
        let given = result.is_ok().then(|| outputs.clone());
        self.keep(Call::Initialize, result, |record| {
            (record.start, record.inputs, record.outputs) = (Some(start), Some(inputs.clone()), given);
        })
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let result = self.inner.start(window, inputs);
        self.keep(Call::Start, result, |record| {
            (record.window, record.inputs) = (Some(*window), Some(inputs.clone()));
        })
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let result = self.inner.finish(outputs);
        let given = result.is_ok().then(|| outputs.clone());
        self.keep(Call::Finish, result, |record| record.outputs = given)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        let result = self.inner.accept(snapshot);
        self.keep(Call::Accept, result, |record| record.snapshot = snapshot)
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        let result = self.inner.save();
        let bytes = result.as_ref().ok().map(Vec::len);
        self.keep(Call::Save, result, |record| record.bytes = bytes)
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let result = self.inner.restore(state, outputs);
        let given = result.is_ok().then(|| outputs.clone());
        self.keep(Call::Restore, result, |record| {
            (record.bytes, record.outputs) = (Some(state.len()), given);
        })
    }

    fn terminate(&mut self) -> Result<()> {
        let result = self.inner.terminate();
        self.keep(Call::Terminate, result, |_| {})
    }
}
