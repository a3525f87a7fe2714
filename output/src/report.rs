//! `report.html` from the folder of a run: one file with everything in it, that opens without a network.
//!
//! # What it looks for
//!
//! Whatever is not there leaves its part of the page out; what is there but cannot be read is named on the
//! page.
//!
//! | file | what is used |
//! |---|---|
//! | `summary.json` | everything in [`crate::Summary`] |
//! | `case.toml` | `title` (or `name`, also below `[case]`); `[[reference]]` tables: `probe` (a column of `probes.csv` or `probes_intervals.csv`), `label`, `source`, `time`, `value`, and `low`, `high` where a range is known; lists of one length, SI units |
//! | `probes.csv` | `t` or `time`; every other column `<probe>.<component>` is drawn |
//! | `probes_intervals.csv` | the same, of probes over intervals |
//! | `windows.csv` | `time` or `t`; see below |
//! | `fluid.pvd` | positions, `pressure` |
//! | `structure.pvd` | positions, `von_mises_stress` or `von_mises`, or `stress` of 4 (xx, yy, xy, zz), 6 (xx, yy, zz, xy, yz, xz) or 9 components |
//! | `walls.pvd` | positions, drawn grey |
//!
//! | columns of `windows.csv` | figure |
//! |---|---|
//! | names with `residual_before` or `residual_after` | residual of condition (46), logarithmic |
//! | names ending in `iterations` | iterations |
//! | `….force…`, `….power…`, `….impulse…`, `….work…` | what crosses the interface |
//! | `<side>.<kind>_energy` (kinds `kinetic`, `potential`, `strain`, …; `total` or `mechanical` if given, else their sum without `dissipated`), `total_energy`, `<side>.load_work` | energy of each side and of the whole, as the paper's Figs. 11 and 20; work of the loads beside what became of it |
//! | `<side>.…_work` | works on a side |
//! | `size` or `dt`, `sub_steps`, `….compute_seconds`, `….volume_drift`, `….splashes`, `….particles_left`, `….particles_lost`, `….max_speed`, other names ending in `residual` | course of the run |
//!
//! A column's unit is what `columns.json` says; a column that is not there is drawn without a unit.

mod colours;
mod figures;
mod frames;
mod image;
mod letters;
mod page;
mod picture;
mod plot;
mod references;
mod scale;

// Pieces for other pages of the same style.
pub use crate::xml::escape;
pub use frames::Shown;
pub use page::document;
pub use picture::View;
pub use plot::{Curve, Mark, Marks, Plot, chart};
pub use scale::short;

use crate::atomic;
use crate::columns;
use crate::error::{Error, Result};
use crate::summary::{Summary, probe_extremes};
use crate::table::{self, Columns};
use frames::Pictures;
use std::path::{Path, PathBuf};

/// Rows of a table at most that are held in memory for a report, about 40 MB of `windows.csv`.
const ROWS: usize = 1 << 17;

/// A report that was written.
#[derive(Debug)]
pub struct Report {
    /// Its page.
    pub page: PathBuf,
    /// What was not as it should be: parts that could not be read, references of no probe. The page has them,
    /// too.
    pub notes: Vec<String>,
}

/// Makes `dir/report.html` and the pictures `dir/frames/t<time>.png`, `dir/frames/structure.png` and
/// `dir/frames/displacement.png` from what a run left in `dir`. Works on finished, killed and still running
/// runs.
///
/// # Errors
/// [`Error::NoRun`] if nothing of a run is there, [`Error::Write`] if the report cannot be written. Files
/// that cannot be read are no error: the notes name them.
pub fn write_report(dir: &Path, shown: &Shown) -> Result<Report> {
    const PARTS: [&str; 5] = ["summary.json", "windows.csv", "probes.csv", "fluid.pvd", "structure.pvd"];
    if !PARTS.iter().any(|name| dir.join(name).exists()) {
        return Err(Error::NoRun { path: dir.to_owned() });
    }
    let mut notes = Vec::new();
    let summary = part(dir, "summary.json", Summary::read, &mut notes);
    let case = part(dir, "case.toml", references::read_case, &mut notes).unwrap_or_default();
    let probes = part(dir, "probes.csv", curves, &mut notes).unwrap_or_default();
    let intervals: Columns = part(dir, "probes_intervals.csv", curves, &mut notes).unwrap_or_default();
    let windows: Columns = part(dir, "windows.csv", curves, &mut notes).unwrap_or_default();
    if summary.is_none() && !dir.join("summary.json").exists() {
        notes.push("The run has left no summary.json: it was killed, or is still going on.".to_owned());
    }
    let is_there = |column: &str| probes.get(column).or_else(|| intervals.get(column)).is_some();
    for reference in case.references.iter().filter(|r| !is_there(&r.probe)) {
        notes.push(format!(
            "The reference `{}` is for `{}`, which is no column of probes.csv or probes_intervals.csv.",
            reference.label, reference.probe
        ));
    }
    let extremes = summary.as_ref().map_or_else(|| probe_extremes(&probes), |summary| summary.probes.clone());
    let frames = match frames::draw_frames(dir, shown, &extremes) {
        Err(error @ Error::Write { .. }) => return Err(error),
        Err(error) => {
            notes.push(error.to_string());
            Pictures::default()
        }
        Ok(frames) => frames,
    };
    let title = [summary.as_ref().map(|s| s.title.clone()), case.title.clone()]
        .into_iter()
        .flatten()
        .find(|title| !title.is_empty())
        .unwrap_or_else(|| dir.file_name().unwrap_or(dir.as_os_str()).to_string_lossy().into_owned());
    let page = page::Page {
        title,
        summary,
        probes: [
            figures::probes(&probes, &case.references),
            figures::intervals(&intervals, &case.references),
        ]
        .into_iter()
        .flatten()
        .collect(),
        comparisons: [&probes, &intervals]
            .into_iter()
            .flat_map(|table| figures::comparisons(table, &case.references))
            .collect(),
        probe_columns: probes,
        frames,
        coupling: figures::coupling(&windows),
        energy: figures::energy(&windows),
        progress: figures::progress(&windows),
        // A broken file of columns is told by the tables that it is of.
        contents: columns::read(dir).unwrap_or_default(),
        notes,
    };
    let path = dir.join("report.html");
    atomic::write_file(&path, page::html(&page).as_bytes())?;
    Ok(Report { page: path, notes: page.notes })
}

/// A table for curves, of which a page has no use for more rows.
fn curves(path: &Path) -> Result<Columns> {
    table::read_at_most(path, ROWS)
}

/// What `read` makes of a file of the folder; `None` if it is not there or, with a note, cannot be read.
fn part<T>(dir: &Path, name: &str, read: impl Fn(&Path) -> Result<T>, notes: &mut Vec<String>) -> Option<T> {
    let path = dir.join(name);
    if !path.exists() {
        return None;
    }
    read(&path).map_err(|error| notes.push(error.to_string())).ok()
}
