//! When a run writes checkpoints, and how many of them are kept.

use super::checkpoint;
use super::found::{FOLDER, Found, Header};
use super::options::{Options, RunError};
use super::recorded::Recorded;
use crate::board::Board;
use crate::schemes::{Onward, SchemeError, Solver};
use interfaces::case::Case;
use interfaces::case::checkpoints::Checkpoints as Choice;
use output::files;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use words::text::tame;

/// A time is reached up to this part of the interval before: rounding of the sum of window sizes.
const ON_TIME: f64 = 1e-9;

/// The checkpoints of a run that goes on.
pub(super) struct Checkpoints<'a> {
    choice: &'a Choice,
    options: &'a Options,
    board: &'a Board,
    folder: PathBuf,
    /// What does not change from one to the next.
    header: Header,
    started: Instant,
    /// Simulated time (s) of the next.
    next: Option<f64>,
    last: Instant,
    /// Who cannot be saved.
    cannot: Option<String>,
    /// What became of them.
    pub written: Written,
}

/// What became of a run's checkpoints.
#[derive(Debug, Default)]
pub(super) struct Written {
    /// How many.
    pub count: u64,
    /// Bytes of all.
    pub bytes: u64,
    /// Time that they took (s).
    pub seconds: f64,
    /// What kept one from being written.
    pub notes: Vec<String>,
}

impl<'a> Checkpoints<'a> {
    /// Of a run that began at `started`; what becomes of them is told to `board`, too.
    pub(super) fn new<S: Solver>(
        case: &'a Case,
        options: &'a Options,
        recorded: &Recorded<S>,
        (started, board): (Instant, &'a Board),
    ) -> Self {
        let from = options.from.as_ref();
        let cannot = recorded
            .run
            .solver
            .sides()
            .as_ref()
            .iter()
            .find(|side| !side.describe().saves)
            .map(|side| format!("the {}, {}, cannot be saved", side.role(), side.describe().solver));
        let mut checkpoints = Self {
            choice: &case.checkpoints,
            options,
            board,
            folder: options.out.join(FOLDER),
            header: Header {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                case_hash: case.hash(),
                case: case.to_toml(),
                wall_seconds: from.map_or(0.0, Found::wall_seconds),
                seams: from.map_or_else(Vec::new, |found| found.header.seams.clone()),
                ..Header::default()
            },
            started,
            next: None,
            last: Instant::now(),
            cannot,
            written: Written::default(),
        };
        checkpoints.after(recorded.run.schedule.time());
        checkpoint::remove_partial(&checkpoints.folder);
        if let (Some(who), Some(_)) = (&checkpoints.cannot, checkpoints.choice.every) {
            checkpoints.tell(format!("there will be no checkpoints: {who}"));
        }
        checkpoints
    }

    /// Whether a run that is told to stop may finish its window for a last checkpoint.
    pub(super) fn wait_at_stop(&self) -> bool {
        self.options.checkpoints.is_some() && self.choice.at_stop && self.cannot.is_none()
    }

    /// Whether one is due at a time (s) between two windows.
    pub(super) fn are_due(&self, time: f64) -> bool {
        let Some(asked) = &self.options.checkpoints else { return false };
        let Choice { every, wall_interval, .. } = self.choice;
        let by_time = self.next.zip(*every).is_some_and(|(next, every)| time >= next - ON_TIME * every);
        let by_clock = *wall_interval > 0.0 && self.last.elapsed().as_secs_f64() >= *wall_interval;
        by_time || by_clock || asked.load(Ordering::Relaxed)
    }

    /// Writes one if it is due: at a time, on the clock, because somebody asked for it, at a stop, and at the
    /// end of a run that writes any. Says whether the run goes on.
    ///
    /// # Errors
    /// A participant that failed while it was saved, tables that cannot be written. A checkpoint that cannot
    /// be is no reason to end: it is told, and tried again when the next is due.
    pub(super) fn between_windows<S: Solver>(
        &mut self,
        recorded: &mut Recorded<S>,
    ) -> Result<Onward, RunError> {
        let (time, is_over) = (recorded.run.schedule.time(), recorded.run.schedule.finished());
        let is_stopped = self.options.stop.load(Ordering::Relaxed);
        // A run that ended early does so again from the one before.
        let is_early = recorded.run.solver.ending().is_some();
        let writes = self.choice.every.is_some() || self.written.count > 0 || self.options.from.is_some();
        let at_end = is_over && !is_early && writes;
        let wanted = self.options.checkpoints.is_some() && (at_end || is_stopped && self.choice.at_stop);
        if (wanted || self.are_due(time)) && recorded.run.schedule.windows() > 0 {
            self.write(recorded)?;
        }
        Ok(if is_over || is_stopped { Onward::Stop } else { Onward::Continue })
    }

    fn write<S: Solver>(&mut self, recorded: &mut Recorded<S>) -> Result<(), RunError> {
        let begun = Instant::now();
        let schedule = &recorded.run.schedule;
        let (time, windows) = (schedule.time(), schedule.windows());
        if let Some(asked) = &self.options.checkpoints {
            asked.store(false, Ordering::Relaxed);
        }
        if let Some(who) = self.cannot.clone() {
            self.tell(format!("no checkpoint was written: {who}"));
            self.after(time);
            return Ok(());
        }
        // Rows first: a checkpoint names no row that is not on the disk.
        let synced = recorded.sync();
        let tables =
            synced.map_err(|error| SchemeError::Record { window: windows, what: error.to_string() })?;
        let wall_seconds = self.options.from.as_ref().map_or(0.0, Found::wall_seconds)
            + self.started.elapsed().as_secs_f64();
        let header = Header { time, windows, tables, wall_seconds, ..self.header.clone() };
        let written = files::folder(&self.folder)
            .map_err(|error| output::Error::Write { path: self.folder.clone(), source: error }.into())
            .and_then(|()| checkpoint::write(&self.folder, &header, recorded));
        match written {
            Ok(bytes) => {
                self.board.checkpoint(windows, time);
                self.written.count += 1;
                self.written.bytes += bytes;
                self.keep_newest(windows);
            }
            Err(RunError::Output(error)) => {
                self.tell(format!("a checkpoint was not written, the run goes on: {error}"));
            }
            Err(error) => return Err(error),
        }
        self.after(time);
        self.written.seconds += begun.elapsed().as_secs_f64();
        Ok(())
    }

    /// The next is due an interval after a time (s), on the clock from now on.
    fn after(&mut self, time: f64) {
        let intervals = |every: f64| (time / every + ON_TIME).floor() + 1.0;
        self.next = self.choice.every.map(|every| intervals(every) * every);
        self.last = Instant::now();
    }

    /// Removes those of a future that did not come, and the oldest.
    fn keep_newest(&self, windows: u64) {
        let all = checkpoint::all(&self.folder);
        let (past, future): (Vec<_>, Vec<_>) = all.into_iter().partition(|(of, _)| *of <= windows);
        let many = past.len().saturating_sub(self.choice.keep as usize);
        for (_, path) in past.into_iter().take(many).chain(future) {
            // One that cannot be removed is in nobody's way.
            let _ = std::fs::remove_file(path);
        }
    }

    /// Once: what is told again and again is read no more.
    fn tell(&mut self, what: String) {
        if !self.written.notes.contains(&what) {
            eprintln!("warning: {}", tame(&what, usize::MAX));
            self.board.warn(&what);
            self.written.notes.push(what);
        }
    }
}

/// How long a run that is told to stop waits for its window, of which the longest so far took `longest`.
pub(super) fn patience(longest: Duration) -> Duration {
    const LEAST: Duration = Duration::from_secs(2);
    LEAST + 2 * longest
}
