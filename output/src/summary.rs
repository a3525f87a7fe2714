//! `summary.json`: what a run was, how it ended, what it took and what was kept in balance.

use crate::atomic;
use crate::error::{Result, parse_error, read_error};
use crate::files;
use crate::sums::{Energies, EnergySum, ResidualSum};
use crate::table::Columns;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Lists that are open to additions: any name, any JSON value.
pub type Extra = BTreeMap<String, serde_json::Value>;

/// Everything in `summary.json`. What a run does not know (a side it does not have, a run killed before it
/// could measure) is left out. JSON has no word for not-a-number: such a value is written as `null` and reads
/// back as not-a-number.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Summary {
    /// How the run ended.
    pub status: Status,
    /// Why it did not reach its end time: for every status but `completed`, and for a run that a participant
    /// or a steady state ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// Title of the case.
    pub title: String,
    /// Hash of the resolved case, in hexadecimal, as the participants compared it.
    pub case_hash: String,
    /// Version of meniscus.
    pub version: String,
    /// Threads that a solver was given.
    pub threads: usize,
    /// Accepted time windows.
    pub windows: u64,
    /// Iterations of the accepted windows; nothing with an explicit scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<Iterations>,
    /// Sub-steps of the structure in the accepted windows.
    pub sub_steps: u64,
    /// Simulated time reached, in s.
    #[serde(deserialize_with = "null_as_nan")]
    pub simulated_seconds: f64,
    /// Time that the run took from start to end, in s.
    #[serde(deserialize_with = "null_as_nan")]
    pub wall_seconds: f64,
    /// Time and memory by role (`fluid`, `structure`, `coupler`).
    pub roles: BTreeMap<String, RoleUse>,
    /// Condition (46), normal continuity of the load across the interface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition_46: Option<Condition46>,
    /// What went across the interface, and the energy of the whole.
    pub balances: Balances,
    /// The fluid's volume and particles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<FluidBalance>,
    /// What the sides and the coupler noted and may be meant, one line each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Where the run went on from a checkpoint, in the order of time; nothing of one in one piece.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub seams: Vec<Seam>,
    /// Extremes by column of `probes.csv`, in the column's unit.
    pub probes: BTreeMap<String, Extremes>,
    /// Anything else.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub extra: Extra,
}

/// Where a run went on from a checkpoint.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Seam {
    /// Windows before it.
    pub windows: u64,
    /// Simulated time, in s.
    #[serde(deserialize_with = "null_as_nan")]
    pub simulated_seconds: f64,
    /// Time that the run had taken by then, in s.
    #[serde(deserialize_with = "null_as_nan")]
    pub wall_seconds: f64,
    /// The folder of the run that this one is a branch of; nothing where it is the same run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub branch_of: Option<String>,
    /// Keys of the case that were other before, each as `key = value (was value)`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<String>,
}

impl Seam {
    /// In one line of words.
    pub fn words(&self) -> String {
        let Self { windows, simulated_seconds, branch_of, changes, .. } = self;
        let how =
            branch_of.as_ref().map_or("resumed".to_owned(), |of| format!("a branch of the run in {of}"));
        let changed = match changes.is_empty() {
            true => String::new(),
            false => format!(", with {}", changes.join(", ")),
        };
        format!("{how} from the checkpoint at t = {simulated_seconds} s, after {windows} windows{changed}")
    }
}

/// How a run ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It reached its end time.
    Completed,
    /// Someone asked it to end before.
    Interrupted,
    /// It could not go on.
    #[default]
    Failed,
}

impl Status {
    /// The word in the file.
    pub fn word(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Interrupted => "interrupted",
            Self::Failed => "failed",
        }
    }
}

/// Iterations of an implicit scheme over the accepted windows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Iterations {
    /// Mean of a window.
    #[serde(deserialize_with = "null_as_nan")]
    pub mean: f64,
    /// Most of a window.
    pub most: u64,
    /// Windows that were accepted without having converged.
    pub not_converged: u64,
}

/// What one role used.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RoleUse {
    /// Time spent computing, in s.
    #[serde(deserialize_with = "null_as_nan")]
    pub compute_seconds: f64,
    /// Time from its initialisation on in which it did not compute, in s: it waited for its turn and for
    /// messages.
    #[serde(deserialize_with = "null_as_nan")]
    pub wait_seconds: f64,
    /// `compute_seconds` as a fraction of the run's `wall_seconds`.
    #[serde(deserialize_with = "null_as_nan")]
    pub share: f64,
    /// Largest resident memory of the role's process, in bytes; 0 where it was not measured.
    pub peak_memory_bytes: u64,
    /// Anything else.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub extra: Extra,
}

/// Residual of condition (46) over all windows, before and after it was enforced.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Condition46 {
    /// As the fluid sent the load.
    pub before: Residual,
    /// As the structure received it.
    pub after: Residual,
}

/// A residual that the coupler made dimensionless, as it stands in `windows.csv`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Residual {
    /// Largest over the windows, 1.
    #[serde(deserialize_with = "null_as_nan")]
    pub max: f64,
    /// Root mean square over the windows, 1.
    #[serde(deserialize_with = "null_as_nan")]
    pub rms: f64,
}

impl Residual {
    /// Maximum and root mean square of one value a window; both not-a-number if any value is, or there is
    /// none.
    pub fn of(values: &[f64]) -> Self {
        let mut sum = ResidualSum::default();
        values.iter().for_each(|&value| sum.add(value));
        Self::from(&sum)
    }
}

/// What went across the interface over the whole run, and the energy of the whole.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Balances {
    /// Impulse that the fluid gave, by axis, in N·s (per metre of depth in two dimensions).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub impulse_given_newton_seconds: Vec<f64>,
    /// Impulse that the structure took, by axis, in N·s.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub impulse_taken_newton_seconds: Vec<f64>,
    /// Work that the fluid did at the interface, in J.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work_given_joules: Option<f64>,
    /// Work that the structure received at the interface, in J.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work_taken_joules: Option<f64>,
    /// Energy of fluid and structure together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<EnergyBalance>,
    /// Anything else.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub extra: Extra,
}

/// Energy of the whole: kinetic, strain and potential, of fluid and structure.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EnergyBalance {
    /// At the start, in J.
    #[serde(deserialize_with = "null_as_nan")]
    pub start_joules: f64,
    /// At the end, in J.
    #[serde(deserialize_with = "null_as_nan")]
    pub end_joules: f64,
    /// Largest rise above an earlier value, in J: `max over t of (E(t) − min over s ≤ t of E(s))`.
    #[serde(deserialize_with = "null_as_nan")]
    pub largest_rise_joules: f64,
    /// The energy that the motion has, in J: the largest of the greatest kinetic energy, and of what the
    /// energies of gravity and strain went through. A rise is much or little beside it.
    #[serde(default, deserialize_with = "null_as_nan")]
    pub moved_joules: f64,
}

impl From<&ResidualSum> for Residual {
    fn from(sum: &ResidualSum) -> Self {
        let mean_square = sum.squares / sum.count;
        if mean_square.is_nan() {
            return Self { max: f64::NAN, rms: f64::NAN };
        }
        Self { max: sum.max, rms: mean_square.sqrt() }
    }
}

impl From<&EnergySum> for EnergyBalance {
    fn from(sum: &EnergySum) -> Self {
        Self {
            start_joules: sum.start,
            end_joules: sum.end,
            largest_rise_joules: sum.rise,
            moved_joules: sum.moved(),
        }
    }
}

impl EnergyBalance {
    /// The balance of a history; `None` if it is empty.
    pub fn of(mut history: impl Iterator<Item = Energies>) -> Option<Self> {
        let mut sum = EnergySum::new(history.next()?);
        history.for_each(|energies| sum.add(energies));
        Some(Self::from(&sum))
    }
}

/// The fluid's volume and particles.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FluidBalance {
    /// Largest change of the fluid's volume as a fraction of its volume at the start, with sign.
    #[serde(deserialize_with = "null_as_nan")]
    pub volume_drift: f64,
    /// Particles that are gone though they did not leave through an open side: a fault of the run.
    pub particles_lost: u64,
    /// Particles that left the domain through an open side.
    pub particles_left: u64,
    /// Anything else.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub extra: Extra,
}

/// Largest and smallest value of a probe's component, and when.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Extremes {
    /// Largest value, in the probe's unit.
    #[serde(deserialize_with = "null_as_nan")]
    pub max: f64,
    /// First time of the largest value, in s.
    #[serde(deserialize_with = "null_as_nan")]
    pub max_time: f64,
    /// Smallest value, in the probe's unit.
    #[serde(deserialize_with = "null_as_nan")]
    pub min: f64,
    /// First time of the smallest value, in s.
    #[serde(deserialize_with = "null_as_nan")]
    pub min_time: f64,
}

impl Extremes {
    /// Extremes of `values` at `times` (s), of one length; `None` if no value is a number.
    pub fn of(times: &[f64], values: &[f64]) -> Option<Self> {
        let mut extremes = None;
        times.iter().zip(values).for_each(|(&time, &value)| Self::extend(&mut extremes, time, value));
        extremes
    }

    /// Adds a value to the extremes so far, unless it is not a number.
    pub fn extend(extremes: &mut Option<Self>, time: f64, value: f64) {
        if value.is_nan() {
            return;
        }
        let found = extremes.get_or_insert(Self { max: value, max_time: time, min: value, min_time: time });
        if value > found.max {
            (found.max, found.max_time) = (value, time);
        }
        if value < found.min {
            (found.min, found.min_time) = (value, time);
        }
    }
}

/// Extremes of every column of a probe table but its first, which is the time.
pub fn probe_extremes(probes: &Columns) -> BTreeMap<String, Extremes> {
    let Some((_, times)) = probes.iter().next() else { return BTreeMap::new() };
    let column = |(name, values): (&str, &[f64])| Some((name.to_owned(), Extremes::of(times, values)?));
    probes.iter().skip(1).filter_map(column).collect()
}

impl Summary {
    /// Writes the summary to `path` in one piece (see [`atomic::write_file`]).
    ///
    /// # Errors
    /// [`crate::Error::Write`] if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|error| parse_error(path, format!("the summary is no JSON: {error}")))?;
        text.push('\n');
        atomic::write_file(path, text.as_bytes())
    }

    /// Reads a summary. What is missing keeps its default, what is unknown is passed over.
    ///
    /// # Errors
    /// [`crate::Error::Read`] if the file cannot be read, [`crate::Error::Parse`] if it is no such JSON.
    pub fn read(path: &Path) -> Result<Self> {
        let text = files::read_text(path, files::WORDS).map_err(read_error(path))?;
        serde_json::from_str(&text).map_err(|error| parse_error(path, error.to_string()))
    }
}

fn null_as_nan<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_as_it_was_written() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("summary.json");
        let mut summary = Summary {
            status: Status::Interrupted,
            message: Some("Ctrl-C".to_owned()),
            simulated_seconds: 0.1 + 0.2,
            condition_46: Some(Condition46 {
                before: Residual { max: 0.5, rms: 0.1 },
                ..Condition46::default()
            }),
            ..Summary::default()
        };
        summary.roles.insert("fluid".to_owned(), RoleUse { compute_seconds: 1.5, ..RoleUse::default() });
        summary.extra.insert("note".to_owned(), serde_json::json!({"any": ["thing"]}));
        summary.write(&path).unwrap();
        assert_eq!(Summary::read(&path).unwrap(), summary);
        assert!(std::fs::read_to_string(&path).unwrap().contains("\"status\": \"interrupted\""));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "no temporary file stays");

        summary.wall_seconds = f64::NAN;
        summary.write(&path).unwrap();
        assert!(Summary::read(&path).unwrap().wall_seconds.is_nan());
        std::fs::write(&path, "{\"status\": \"completed\", \"from_the_future\": 1}").unwrap();
        assert_eq!(Summary::read(&path).unwrap().status, Status::Completed);
    }

    #[test]
    fn measures_by_hand() {
        // Falls to 8, rises to 9.5 (1.5 above 8), falls to 3, rises to 4.
        let history = |totals: &[f64]| {
            let of = |total| Energies { kinetic: 1.0, potential: total - 1.0, strain: 0.0 };
            EnergyBalance::of(totals.iter().copied().map(of))
        };
        let energy = history(&[10.0, 8.0, 9.5, 3.0, 4.0]).unwrap();
        assert_eq!(energy.moved_joules, 7.0);
        assert_eq!((energy.start_joules, energy.end_joules, energy.largest_rise_joules), (10.0, 4.0, 1.5));
        assert!(history(&[1.0, f64::NAN, 2.0]).unwrap().largest_rise_joules.is_nan());
        assert_eq!(history(&[]), None);

        // sqrt((9 + 16) / 2) to the bit: every step is exact but the root.
        assert_eq!(Residual::of(&[3.0, 4.0]), Residual { max: 4.0, rms: 12.5f64.sqrt() });
        assert!(Residual::of(&[3.0, f64::NAN, 4.0]).max.is_nan());

        let extremes = Extremes::of(&[0.0, 1.0, 2.0, 3.0], &[f64::NAN, 2.0, -1.0, 2.0]).unwrap();
        assert_eq!(extremes, Extremes { max: 2.0, max_time: 1.0, min: -1.0, min_time: 2.0 });
        let table = Columns {
            names: vec!["t".to_owned(), "tip.ux".to_owned()],
            columns: vec![vec![0.0, 1.0], vec![5.0, 7.0]],
            ..Columns::default()
        };
        assert_eq!(probe_extremes(&table)["tip.ux"].max_time, 1.0);
    }
}
