//! `meniscus bench exchange`: what the coupling takes where the participants do nothing.
//!
//! Three processes, as in a run: the coupler, a fluid that gives a load (2N doubles in the plane) and a
//! structure that gives position and velocity (4N), at the same N points. Everything is as in a run:
//! contract, checks of every field, condition (46), records. Beside each series stands the *raw* transfer:
//! the same messages between as many processes through the same shared memory, each copied in and out, and
//! nothing else. And a copy of the same bytes within one process. All times are of one window, without
//! start-up and the first tenth of the windows.

mod coupled;
mod raw;
mod table;

pub use raw::echo;

use crate::run::RunError;
use interfaces::ParticipantError;
use interfaces::case::Sections;
use std::hint::black_box;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use thiserror::Error;

/// What the command line sets.
pub struct Options {
    /// Numbers of interface points.
    pub points: Vec<usize>,
    /// Windows to measure, where not as many as take about a second.
    pub windows: Option<u64>,
    /// Whether the processes may be put on one core, raw as coupled ([`crate::placement`]).
    pub share_core: bool,
    /// Our executable, for the participants' processes.
    pub executable: PathBuf,
    /// Domain of shared memory, where it is not the usual one.
    pub domain: Option<String>,
    /// Sections of the case that the participants' executable knows: both ends have to read the same.
    pub sections: Vec<Sections>,
    /// Becomes true when the bench is told to stop.
    pub stop: Arc<AtomicBool>,
}

/// Why there is no measurement.
#[derive(Debug, Error)]
pub enum BenchError {
    /// The coupling failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The raw transfer failed.
    #[error("the raw transfer failed: {0}")]
    Raw(#[from] ParticipantError),
    /// Processes or files failed.
    #[error("failed to {during}: {source}")]
    System {
        /// What was tried.
        during: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
}

/// What is coupled how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Series {
    /// Serial explicit, each participant once.
    Explicit,
    /// The same, the structure reading a load that is interpolated to each of 100 sub-steps.
    Interpolated,
    /// Serial explicit with the structure predicted: as a case has it that does not say.
    Predicted,
    /// Serial implicit, so many iterations by IQN-ILS, of which none converges.
    Iterated(u32),
}

const SERIES: [Series; 5] =
    [Series::Explicit, Series::Interpolated, Series::Predicted, Series::Iterated(2), Series::Iterated(4)];

impl Series {
    fn name(self) -> String {
        match self {
            Self::Explicit => "serial-explicit".to_owned(),
            Self::Interpolated => "100 interpolated sub-steps".to_owned(),
            Self::Predicted => "serial-explicit, predicted".to_owned(),
            Self::Iterated(count) => format!("serial-implicit, {count} IQN-ILS iterations"),
        }
    }

    /// Solutions of a window: of the structure, of the fluid.
    fn solutions(self) -> (usize, usize) {
        match self {
            Self::Explicit | Self::Interpolated => (1, 1),
            Self::Predicted => (2, 1),
            Self::Iterated(count) => (count as usize, count as usize),
        }
    }

    /// Doubles that a structure's solution takes, of `n` points.
    fn structure_takes(self, n: usize) -> usize {
        if self == Self::Interpolated { 4 * n } else { 2 * n }
    }

    /// Doubles of all messages of a window.
    fn doubles(self, n: usize) -> usize {
        let (structure, fluid) = self.solutions();
        structure * (self.structure_takes(n) + 4 * n) + fluid * (4 * n + 2 * n)
    }
}

/// What was measured of one series.
struct Measured {
    /// Time of each window (s), sorted.
    times: Vec<f64>,
    /// Processor time of all processes, per window (s).
    cpu_seconds: f64,
    /// Largest resident memory of all processes together (bytes).
    peak_memory_bytes: u64,
}

impl Measured {
    /// The time below which that share of the windows is (s).
    fn at(&self, share: f64) -> f64 {
        self.times[(share * (self.times.len() - 1) as f64).round() as usize]
    }
}

/// Measures, and tells each line of the table as soon as there is one.
///
/// # Errors
/// What ended a measurement.
pub fn exchange(options: &Options, mut tell: impl FnMut(&str)) -> Result<(), BenchError> {
    table::legend().lines().for_each(&mut tell);
    for &points in &options.points {
        tell("");
        tell(&table::head(points));
        for series in SERIES {
            let windows = options.windows.unwrap_or_else(|| windows(series.doubles(points)));
            let raw = raw::measure(series, points, windows, options)?;
            let coupled = coupled::measure(series, points, windows, options)?;
            tell(&table::row(series, points, &coupled, &raw, copy(series.doubles(points))));
        }
    }
    Ok(())
}

/// Windows of about a second all together, at the 2 GB/s of several copies and some 40 µs of waking.
fn windows(doubles: usize) -> u64 {
    let seconds = 40e-6 + 8.0 * doubles as f64 / 2e9;
    ((1.0 / seconds) as u64).clamp(200, 10_000)
}

/// Median time of copying so many doubles within this process (s).
fn copy(doubles: usize) -> f64 {
    let (from, mut to) = (vec![1.0; doubles], vec![0.0; doubles]);
    let mut times: Vec<f64> = (0..50)
        .map(|_| {
            let started = Instant::now();
            to.copy_from_slice(black_box(&from));
            black_box(&mut to);
            started.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Windows at the beginning that are not measured.
fn warm_up(windows: u64) -> u64 {
    windows / 10
}
