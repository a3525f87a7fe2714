//! The table, with what was asked for and what others take beside.

use super::{Measured, Series};
use std::fmt::Write as _;

/// Medians of a window's exchange with preCICE 3.4.1 on a machine of this kind, as published with the goals:
/// points, serial explicit (s).
const PRECICE: [(usize, f64); 4] = [(100, 103e-6), (1_000, 179e-6), (10_000, 1.64e-3), (100_000, 20.4e-3)];
/// The same with four IQN-ILS iterations at 10 000 points (s).
const PRECICE_FOUR_ITERATIONS: f64 = 17.6e-3;
/// Goals of a serial explicit window: points, time (s).
const GOALS: [(usize, f64); 4] = [(100, 30e-6), (1_000, 35e-6), (10_000, 200e-6), (100_000, 2.5e-3)];
/// Goal of four IQN-ILS iterations at 10 000 points (s).
const GOAL_FOUR_ITERATIONS: f64 = 2e-3;

/// What the columns are.
pub fn legend() -> String {
    "Participants that do nothing, three processes, two dimensions; µs per window.\n\
     raw: the same messages without the coupling; ratio: median over the median of raw; cpu: of all processes; copy: of the same bytes within one \
     process; MB: largest resident memory of all processes together."
        .to_owned()
}

/// Over the rows of so many points.
pub fn head(points: usize) -> String {
    format!(
        "{:<38}{:>9}{:>9}{:>9}{:>9}{:>9}{:>7}{:>8}{:>7}{:>9}{:>9}",
        format!("{points} points"),
        "median",
        "p10",
        "p99",
        "cpu",
        "raw",
        "ratio",
        "copy",
        "MB",
        "goal",
        "preCICE"
    )
}

/// One series.
pub fn row(series: Series, points: usize, coupled: &Measured, raw: &Measured, copy: f64) -> String {
    let micro = |seconds: f64| format!("{:.1}", 1e6 * seconds);
    let at = |list: &[(usize, f64)]| list.iter().find(|(n, _)| *n == points).map(|(_, seconds)| *seconds);
    let (goal, precice) = match series {
        Series::Explicit => (at(&GOALS), at(&PRECICE)),
        Series::Iterated(4) if points == 10_000 => {
            (Some(GOAL_FOUR_ITERATIONS), Some(PRECICE_FOUR_ITERATIONS))
        }
        _ => (None, None),
    };
    let known = |seconds: Option<f64>| seconds.map_or(String::new(), micro);
    let (median, raw) = (coupled.at(0.5), raw.at(0.5));
    let mut row = format!("  {:<36}", series.name());
    for time in [median, coupled.at(0.1), coupled.at(0.99), coupled.cpu_seconds, raw] {
        write!(row, "{:>9}", micro(time)).expect("a string takes all");
    }
    let megabytes = coupled.peak_memory_bytes as f64 / 1e6;
    write!(
        row,
        "{:>7.2}{:>8}{megabytes:>7.0}{:>9}{:>9}",
        median / raw,
        micro(copy),
        known(goal),
        known(precice)
    )
    .expect("a string takes all");
    row
}
