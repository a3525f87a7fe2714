//! The recording of a run, and the participant before which it is made.

use super::entry::Encoder;
use super::file::{End, Error, Header, Writing};
use crate::phase::{Announce, Phase};
use interfaces::{Description, Fields, Participant, Readiness, Result, Role, TimeWindow, WindowReport};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Bytes of entries, not yet packed, from which a block is written.
const BLOCK: usize = 1 << 20;
/// Time after which a block is written all the same, with the next call: what a killed run loses.
const WHILE: Duration = Duration::from_secs(2);

/// The recording of a run, which its participants share.
///
/// A disk that is full, or the limit, ends the recording and not the run: see [`Kept::note`].
#[derive(Clone)]
pub struct Recording(Rc<RefCell<Sink>>);

/// What was recorded of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// The file.
    pub path: PathBuf,
    /// Its bytes.
    pub bytes: u64,
    /// Its blocks of entries.
    pub blocks: u64,
    /// Why it ends before its run, where it does.
    pub note: Option<String>,
}

struct Sink {
    encoder: Encoder,
    /// Nothing once the recording has ended.
    writing: Option<Writing>,
    block: Vec<u8>,
    since: Instant,
    limit: u64,
    kept: Kept,
}

impl Recording {
    /// Makes the file, of at most `limit` bytes.
    ///
    /// # Errors
    /// One that is there already, a folder that is not, a full disk.
    pub fn create(path: &Path, header: &Header, limit: u64) -> Result<Self, Error> {
        let writing = Writing::create(path, header, limit)?;
        Ok(Self(Rc::new(RefCell::new(Sink {
            encoder: Encoder::default(),
            writing: Some(writing),
            block: Vec::new(),
            since: Instant::now(),
            limit,
            kept: Kept { path: path.to_owned(), bytes: 0, blocks: 0, note: None },
        }))))
    }

    /// Records all that crosses to and from this participant, as [`Phase::Records`].
    pub fn recorder<P: Participant>(&self, participant: P, announce: Announce) -> Recorder<P> {
        let recorder = Recorder { inner: participant, recording: self.clone(), announce };
        self.keep(|encoder| encoder.described(recorder.inner.describe()));
        recorder
    }

    /// Ends the file, and says what was recorded.
    pub fn end(&self) -> Kept {
        let mut sink = self.0.borrow_mut();
        sink.end(None);
        sink.kept.clone()
    }

    fn keep(&self, entry: impl FnOnce(&mut Encoder) -> Vec<u8>) {
        let mut sink = self.0.borrow_mut();
        if sink.writing.is_some() {
            let entry = entry(&mut sink.encoder);
            sink.add(&entry);
        }
    }
}

impl Sink {
    fn add(&mut self, entry: &[u8]) {
        // A block that is too long for its lengths is too long for the file, and refused there.
        self.block.extend((entry.len() as u32).to_le_bytes());
        self.block.extend(entry);
        if self.block.len() >= BLOCK || self.since.elapsed() >= WHILE {
            self.write();
        }
    }

    fn write(&mut self) {
        let Some(writing) = &mut self.writing else { return };
        if self.block.is_empty() {
            return;
        }
        let written = writing.entries(&self.block);
        (self.kept.bytes, self.kept.blocks) = (writing.bytes, writing.blocks);
        self.block.clear();
        self.since = Instant::now();
        match written {
            Ok(true) => {}
            Ok(false) => {
                self.end(Some(format!("it has reached its limit of {} bytes (--record-limit)", self.limit)));
            }
            Err(error) => {
                // What follows a torn block could not be read.
                self.writing = None;
                self.kept.note = Some(format!("the recording ended, the run went on: {error}"));
            }
        }
    }

    /// Ends the file, before the run's end where there is a reason.
    fn end(&mut self, early: Option<String>) {
        if early.is_none() {
            self.write();
        }
        let Some(writing) = self.writing.take() else { return };
        let path = self.kept.path.display();
        self.kept.note =
            early.as_ref().map(|why| format!("the recording {path} ended, the run went on: {why}"));
        match writing.end(&End { early }) {
            Ok(bytes) => self.kept.bytes = bytes,
            Err(error) => self.kept.note = Some(format!("the recording has no end: {error}")),
        }
    }
}

impl Drop for Sink {
    fn drop(&mut self) {
        self.end(None);
    }
}

/// A participant before which all that crosses is recorded.
pub struct Recorder<P> {
    inner: P,
    recording: Recording,
    announce: Announce,
}

impl<P: Participant> Recorder<P> {
    fn keep(&self, entry: impl FnOnce(&mut Encoder, Role) -> Vec<u8>) {
        let role = self.inner.describe().role;
        self.announce.during(Phase::Records, || self.recording.keep(|encoder| entry(encoder, role)));
    }
}

impl<P: Participant> Participant for Recorder<P> {
    fn describe(&self) -> &Description {
        self.inner.describe()
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        let result = self.inner.initialize(start, inputs, outputs);
        let given = result.as_ref().map(|ready| (&*outputs, ready));
        self.keep(|encoder, role| encoder.initialized(role, start, inputs, given));
        result
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let result = self.inner.start(window, inputs);
        self.keep(|encoder, role| encoder.started(role, window, inputs, result.as_ref().copied()));
        result
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let result = self.inner.finish(outputs);
        let given = result.as_ref().map(|report| (&*outputs, report));
        self.keep(|encoder, role| encoder.finished(role, given));
        result
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        let result = self.inner.accept(snapshot);
        self.keep(|encoder, role| encoder.accepted(role, snapshot, result.as_ref().copied()));
        result
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        self.inner.save()
    }

    /// A participant that goes to a saved state leaves what was recorded: the recording ends.
    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let mut sink = self.recording.0.borrow_mut();
        sink.write();
        sink.end(Some("the run went to a saved state".to_owned()));
        drop(sink);
        self.inner.restore(state, outputs)
    }

    fn terminate(&mut self) -> Result<()> {
        let result = self.inner.terminate();
        self.keep(|encoder, role| encoder.terminated(role, result.as_ref().copied()));
        result
    }
}
