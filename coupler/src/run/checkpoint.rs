//! A checkpoint of a run on the disk: what is told of the run beside its state, and which one there is to go
//! on from.

use super::found::{FOLDER, Found, Header};
use super::options::RunError;
use super::recorded::Recorded;
use crate::records;
use crate::schemes::{SchemeError, Solver};
use output::checkpoint::{Checkpoint, Writing};
use output::files;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// How their names end.
const ENDING: &str = "checkpoint";
/// Name of the part that tells of the run.
const HEADER: &str = "run";

/// Writes the run's state into the folder of its checkpoints. Gives its length (bytes).
pub(super) fn write<S: Solver>(
    folder: &Path,
    header: &Header,
    recorded: &mut Recorded<S>,
) -> Result<u64, RunError> {
    let mut writing = Writing::begin(&folder.join(name(header.windows)))?;
    let text = serde_json::to_string(header).expect("numbers and words make JSON");
    writing.part(HEADER, text.as_bytes())?;
    recorded.save(|name, bytes| writing.part(name, bytes).map_err(RunError::from))?;
    Ok(writing.finish()?)
}

/// Brings a run of the same case to the state, and its tables to their lengths then.
pub(super) fn restore<S: Solver>(found: &Found, recorded: &mut Recorded<S>) -> Result<(), RunError> {
    let mut file = Checkpoint::open(&found.path)?;
    recorded.restore(|name| file.part(name).map_err(RunError::from)).map_err(|error| match error {
        RunError::Scheme(SchemeError::Saved(error)) => {
            RunError::Checkpoint { path: found.path.clone(), what: format!("the {error}") }
        }
        other => other,
    })?;
    recorded.go_on(&found.header.tables)?;
    Ok(())
}

/// The newest checkpoint of the run in `dir` that is whole and to which its tables reach, and why newer ones
/// are not it.
///
/// # Errors
/// That there is none.
pub fn newest(dir: &Path) -> Result<(Found, Vec<RunError>), RunError> {
    let mut refused = Vec::new();
    for (_, path) in all(&dir.join(FOLDER)).into_iter().rev() {
        match open(&path).and_then(|found| reached(dir, &found).map(|()| found)) {
            Ok(found) => return Ok((found, refused)),
            Err(error) => refused.push(error),
        }
    }
    Err(RunError::NoCheckpoint { path: dir.to_owned(), refused })
}

/// The checkpoint in this file.
///
/// # Errors
/// That it is none, or not whole.
pub fn open(path: &Path) -> Result<Found, RunError> {
    let refuse = |what: String| RunError::Checkpoint { path: path.to_owned(), what };
    let mut file = Checkpoint::open(path)?;
    let header = serde_json::from_slice(&file.part(HEADER)?);
    let header: Header =
        header.map_err(|error| refuse(format!("what it tells of the run cannot be read: {error}")))?;
    // What a file says names no path.
    if let Some(name) = header.tables.keys().find(|name| !records::TABLES.contains(&name.as_str())) {
        return Err(refuse(format!("it tells of a table {name:?}, and a run has none of that name")));
    }
    Ok(Found { path: path.to_owned(), header })
}

/// Refuses a checkpoint to which a table in `dir` does not reach, or in which no row ends there.
fn reached(dir: &Path, found: &Found) -> Result<(), RunError> {
    for (name, &bytes) in &found.header.tables {
        let mut last = [0];
        let ends = files::open(&dir.join(name), u64::MAX).and_then(|mut table| {
            table.seek(SeekFrom::Start(bytes.saturating_sub(1)))?;
            table.read_exact(&mut last)
        });
        if ends.is_err() || last != *b"\n" {
            let what = format!("{name} has no row that ends at byte {bytes}, where it stood then");
            return Err(RunError::Checkpoint { path: found.path.clone(), what });
        }
    }
    Ok(())
}

fn name(windows: u64) -> String {
    format!("{windows:012}.{ENDING}")
}

/// The checkpoints in their folder, by the windows before them; the oldest first.
pub(super) fn all(folder: &Path) -> Vec<(u64, PathBuf)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let windows = |path: &Path| path.file_stem()?.to_str()?.parse().ok();
    let paths =
        entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|e| e == ENDING));
    let mut found: Vec<(u64, PathBuf)> = paths.filter_map(|path| Some((windows(&path)?, path))).collect();
    found.sort();
    found
}

/// Removes what a killed run began and did not finish.
pub(super) fn remove_partial(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_string_lossy().ends_with(".partial")) {
        // What cannot be removed stands in nobody's way.
        let _ = std::fs::remove_file(entry.path());
    }
}
