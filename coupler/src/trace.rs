//! A trace of the run in the array form of Chrome's trace events, which Perfetto (ui.perfetto.dev) and
//! `chrome://tracing` read.
//!
//! An event a line, written in whole lines some thousand bytes at a time: what a kill leaves can be read,
//! since the form allows the closing bracket to be missing.

use interfaces::Role;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// File of the trace, in the folder of the outputs.
pub const TRACE: &str = "trace.json";

/// Bytes after which lines are handed to the operating system.
const FLUSH: usize = 8192;

/// Whose line an event stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Track {
    /// The coupler's.
    Coupler,
    /// The fluid's.
    Fluid,
    /// The structure's.
    Structure,
}

impl Track {
    /// That of a participant.
    pub fn of(role: Role) -> Self {
        match role {
            Role::Fluid => Self::Fluid,
            Role::Structure => Self::Structure,
        }
    }
}

/// A trace being written.
pub struct Trace {
    path: PathBuf,
    file: File,
    buffer: String,
    failed: Option<std::io::Error>,
    ended: bool,
}

impl Trace {
    /// Makes the file (an earlier one is emptied) and names the tracks.
    ///
    /// # Errors
    /// If the file cannot be made.
    pub fn create(path: &Path) -> output::Result<Self> {
        let file = output::files::create(path).map_err(|source| write_error(path, source))?;
        let mut trace =
            Self { path: path.to_owned(), file, buffer: "[\n".to_owned(), failed: None, ended: false };
        for (track, name) in
            [(Track::Coupler, "coupler"), (Track::Fluid, "fluid"), (Track::Structure, "structure")]
        {
            let track = track as u32;
            writeln!(
                trace.buffer,
                r#"{{"name":"thread_name","ph":"M","pid":0,"tid":{track},"args":{{"name":"{name}"}}}},"#
            )
            .expect("a string takes all");
        }
        Ok(trace)
    }

    /// A span on a track, from and to in seconds since the start. `name` has no character that JSON would
    /// have escaped.
    pub fn span(&mut self, track: Track, name: &str, from: f64, to: f64) {
        let (track, start, duration) = (track as u32, 1e6 * from, 1e6 * (to - from));
        writeln!(
            self.buffer,
            r#"{{"name":"{name}","ph":"X","pid":0,"tid":{track},"ts":{start:.3},"dur":{duration:.3}}},"#
        )
        .expect("a string takes all");
        if self.buffer.len() >= FLUSH {
            self.flush();
        }
    }

    /// Closes the list and reports what kept events from being written at any time.
    ///
    /// # Errors
    /// The first failure.
    pub fn end(&mut self) -> output::Result<()> {
        if !self.ended {
            self.ended = true;
            // Every event ends with a comma: an empty one that means nothing closes the list.
            self.buffer.push_str("{}\n]\n");
            self.flush();
        }
        self.failed.take().map_or(Ok(()), |source| Err(write_error(&self.path, source)))
    }

    fn flush(&mut self) {
        if let (None, Err(error)) = (&self.failed, self.file.write_all(self.buffer.as_bytes())) {
            self.failed = Some(error);
        }
        self.buffer.clear();
    }
}

impl Drop for Trace {
    fn drop(&mut self) {
        // A drop cannot report; who has to know calls `end` before.
        let _ = self.end();
    }
}

fn write_error(path: &Path, source: std::io::Error) -> output::Error {
    output::Error::Write { path: path.to_owned(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_kill_leaves_and_what_an_end_leaves_can_be_read() {
        let path = std::env::temp_dir().join(format!("meniscus-trace-{}.json", std::process::id()));
        let mut trace = Trace::create(&path).unwrap();
        for event in 0..500 {
            trace.span(
                Track::Fluid,
                "window 0 iteration 1",
                f64::from(event) * 1e-3,
                f64::from(event) * 1e-3 + 5e-4,
            );
        }
        // As a kill leaves it: whole lines, no end.
        let left = std::fs::read_to_string(&path).unwrap();
        assert!(left.ends_with("},\n") && left.lines().count() > 300);
        let closed: serde_json::Value = serde_json::from_str(&format!("{left}{{}}]")).unwrap();
        assert_eq!(closed[4]["ts"], 1000.0);
        assert_eq!(closed[4]["dur"], 500.0);
        trace.end().unwrap();
        let whole: Vec<serde_json::Value> =
            serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        assert_eq!(whole.len(), 3 + 500 + 1);
        std::fs::remove_file(&path).unwrap();
    }
}
