//! What is asked of a run while it goes on: a file that `meniscus ask` puts into its folder and the run takes
//! away. A folder reaches wherever its files do, other hosts of a cluster among them, as signals do not.

use output::{atomic, files};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// File of a request that was not taken up yet, in the folder of the outputs.
pub const FILE: &str = "request.json";
/// Longest file that is read (bytes).
const LONGEST: u64 = 4096;

/// What is asked for, all of it taken up after the window at hand.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Request {
    /// By which its answer is known.
    pub number: u64,
    /// A checkpoint.
    pub checkpoint: bool,
    /// The end of the run, in order, as by SIGTERM.
    pub stop: bool,
    /// Another interval of the outputs (s).
    pub output_interval: Option<f64>,
}

impl Request {
    /// Puts it into the folder of a run, together with one that was not taken up yet.
    ///
    /// # Errors
    /// If the folder cannot be written to.
    pub fn write(&self, folder: &Path) -> output::Result<()> {
        let earlier = read(&folder.join(FILE)).ok();
        let text =
            serde_json::to_vec(&self.clone().after(earlier)).expect("flags and finite numbers are JSON");
        atomic::write_file(&folder.join(FILE), &text)
    }

    /// Both this and an earlier one that was not taken up yet.
    #[must_use]
    pub fn after(self, earlier: Option<Self>) -> Self {
        let earlier = earlier.unwrap_or_default();
        Self {
            number: self.number,
            checkpoint: self.checkpoint || earlier.checkpoint,
            stop: self.stop || earlier.stop,
            output_interval: self.output_interval.or(earlier.output_interval),
        }
    }

    /// Takes the one that is in the folder of a run, if any; one that cannot be read is taken away, too.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn take(folder: &Path) -> Option<Result<Self, String>> {
        let path = folder.join(FILE);
        // Nothing is the usual, and costs one call of the system.
        std::fs::symlink_metadata(&path).ok()?;
        let request = read(&path);
        let _ = std::fs::remove_file(&path);
        let request = request.and_then(|request| match request.output_interval {
            Some(interval) if !(interval > 0.0 && interval.is_finite()) => {
                Err(format!("an output interval of {interval} s"))
            }
            _ => Ok(request),
        });
        Some(request.map_err(|what| format!("{FILE} was not taken up: {what}")))
    }
}

fn read(path: &Path) -> Result<Request, String> {
    let text = files::read_text(path, LONGEST).map_err(|error| error.to_string())?;
    serde_json::from_str(&text).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_taken_once_and_nonsense_is_told() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(Request::take(dir.path()), None);
        let request = Request { number: 7, output_interval: Some(0.5), ..Request::default() };
        Request { number: 5, stop: true, ..Request::default() }.write(dir.path()).unwrap();
        request.write(dir.path()).unwrap();
        let request = Request { stop: true, ..request };
        assert_eq!(Request::take(dir.path()), Some(Ok(request)));
        assert_eq!(Request::take(dir.path()), None);
        for (text, what) in [
            ("{\"number\": 1, \"output_interval\": 0}", "an output interval of 0 s"),
            ("{\"number\": 1, \"stopp\": true}", "stopp"),
            ("", "EOF"),
        ] {
            std::fs::write(dir.path().join(FILE), text).unwrap();
            let told = Request::take(dir.path()).unwrap().unwrap_err();
            assert!(told.starts_with("request.json was not taken up: ") && told.contains(what), "{told}");
            assert_eq!(Request::take(dir.path()), None);
        }
    }
}
