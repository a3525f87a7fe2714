//! Beside a run: tells once a second in its folder what it is at, and hears what is asked of it.

use super::checkpoints::Written;
use super::options::Options;
use crate::board::Board;
use crate::request::Request;
use crate::schedule::Schedule;
use crate::status::{Answered, FILE};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

/// Between two looks for a request.
const LOOK: Duration = Duration::from_millis(250);
/// Between two writings of the status.
const TELL: Duration = Duration::from_secs(1);

/// The watch of a run. Dropped, it ends, and its file goes: the summary then tells how the run ended.
pub(super) struct Watch {
    board: Board,
    asked: Arc<Mutex<Option<Request>>>,
    /// Wakes the thread; closed, it ends it.
    wake: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// A request that is being taken up.
pub(super) struct Asked {
    request: Request,
    written_before: u64,
    /// What is to be kept of it in the summary.
    pub note: Option<String>,
    /// What was not taken up.
    refused: Option<String>,
}

impl Watch {
    /// Begins to watch the run whose outputs go to `out`. Without a thread, the run goes on unwatched.
    pub fn start(out: &Path, board: &Board) -> Self {
        let (wake, woken) = channel();
        let asked = Arc::default();
        let watcher = Watcher { out: out.to_owned(), board: board.clone(), asked: Arc::clone(&asked) };
        let thread = std::thread::Builder::new().name("watch".to_owned());
        let thread = thread.spawn(move || watcher.watch(&woken)).ok();
        Self { board: board.clone(), asked, wake: Some(wake), thread }
    }

    /// Whether something is asked for. Costs a lock that nobody else wants.
    pub fn is_asked(&self) -> bool {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Takes up what is asked for, between two windows: what is to be done by others is marked for them.
    pub fn take_up(&self, schedule: &mut Schedule, options: &Options, written: &Written) -> Option<Asked> {
        let request = self.asked.lock().unwrap_or_else(PoisonError::into_inner).take()?;
        let (mut note, mut refused) = (None, None);
        if let Some(interval) = request.output_interval {
            let (time, windows) = (schedule.time(), schedule.windows());
            match schedule.set_output_interval(interval) {
                Ok(before) => {
                    self.board.about(|status| status.output_interval = interval);
                    note = Some(format!(
                        "asked to, outputs came every {interval:?} s, no longer every {before:?} s, from t = {time} s, after {windows} windows"
                    ));
                }
                Err(least) => {
                    refused = Some(format!(
                        "an output interval of {interval:?} s was not taken: it would cut the windows to slivers; give {least:.1e} s at least"
                    ));
                }
            }
        }
        if let (true, Some(flag)) = (request.checkpoint, &options.checkpoints) {
            flag.store(true, Ordering::Relaxed);
        }
        if request.stop {
            options.stop.store(true, Ordering::Relaxed);
        }
        Some(Asked { request, written_before: written.count, note, refused })
    }

    /// Tells what came of it.
    pub fn answer(&self, asked: &Asked, schedule: &Schedule, written: &Written) {
        let Request { number, checkpoint, stop, output_interval } = asked.request;
        let at = format!("after {} windows, t = {} s", schedule.windows(), schedule.time());
        let is_written = written.count > asked.written_before;
        let mut what = Vec::new();
        if let Some(refused) = &asked.refused {
            what.push(refused.clone());
        } else if let Some(interval) = output_interval {
            what.push(format!("outputs come every {interval:?} s from now on, {at}"));
        }
        if checkpoint || stop && is_written {
            what.push(match (is_written, written.notes.last()) {
                (true, _) => format!("a checkpoint was written, {at}"),
                (false, Some(note)) => note.clone(),
                (false, None) => "this run writes no checkpoints".to_owned(),
            });
        }
        if stop {
            what.push(format!("the run ends, {at}"));
        }
        self.board.about(|status| status.answered = Some(Answered { number, what }));
        let _ = self.wake.as_ref().map(|wake| wake.send(()));
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        drop(self.wake.take());
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// The thread's part.
struct Watcher {
    out: PathBuf,
    board: Board,
    asked: Arc<Mutex<Option<Request>>>,
}

impl Watcher {
    fn watch(self, woken: &Receiver<()>) {
        let mut told: Option<Instant> = None;
        loop {
            if told.is_none_or(|told| told.elapsed() >= TELL) {
                self.board.look();
                self.tell();
                told = Some(Instant::now());
            }
            match woken.recv_timeout(LOOK) {
                Ok(()) => told = None,
                Err(RecvTimeoutError::Timeout) => self.hear(),
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        let _ = std::fs::remove_file(self.out.join(FILE));
    }

    /// Writes the status. A disk that is full is told by those whose files matter.
    fn tell(&self) {
        let mut status = self.board.status();
        status.process = std::process::id();
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        status.written = now.map_or(0.0, |now| now.as_secs_f64());
        if let Ok(text) = serde_json::to_vec_pretty(&status) {
            let _ = output::atomic::write_file(&self.out.join(FILE), &text);
        }
    }

    fn hear(&self) {
        match Request::take(&self.out) {
            None => {}
            Some(Ok(request)) => {
                let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
                *asked = Some(request.after(asked.take()));
            }
            Some(Err(what)) => {
                eprintln!("warning: {}", words::text::tame(&what, 1000));
                self.board.warn(&what);
            }
        }
    }
}
