//! `sweep.csv`: a row per member.

use super::{Overs, Result};
use output::summary::Extremes;
use output::table::{push_number, quoted};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// File of the table.
pub const FILE: &str = "sweep.csv";

/// Writes the table: folder, the swept keys, how the member ended and what it took, and of each column of its
/// probes the extremes with their times. A cell is empty where there is no value.
///
/// # Errors
/// A file that cannot be written.
pub fn write(results: &[Result], overs: &Overs, out: &Path) -> output::Result<PathBuf> {
    let probes: BTreeSet<&String> = results.iter().flat_map(|result| result.summary.probes.keys()).collect();
    let mut heads: Vec<String> = vec!["folder".to_owned()];
    heads.extend(overs.keys().map(str::to_owned));
    heads.extend(["status", "windows", "simulated_seconds", "wall_seconds", "message"].map(str::to_owned));
    for probe in &probes {
        heads.extend(["max", "max_time", "min", "min_time"].map(|of| format!("{probe}.{of}")));
    }
    let mut text = row(&heads);
    for Result { member, summary, .. } in results {
        let mut cells = vec![member.folder.clone()];
        cells.extend(member.values.iter().cloned());
        cells.extend([
            summary.status.word().to_owned(),
            summary.windows.to_string(),
            number(summary.simulated_seconds),
            number(summary.wall_seconds),
            summary.message.clone().unwrap_or_default(),
        ]);
        for probe in &probes {
            let of = |e: &Extremes| [e.max, e.max_time, e.min, e.min_time].map(number);
            cells.extend(summary.probes.get(*probe).map(of).unwrap_or_default());
        }
        text += &row(&cells);
    }
    let path = out.join(FILE);
    output::atomic::write_file(&path, text.as_bytes())?;
    Ok(path)
}

fn number(value: f64) -> String {
    let mut text = String::new();
    push_number(&mut text, value);
    text
}

/// A line of comma-separated cells.
fn row(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| quoted(cell)).collect();
    cells.join(",") + "\n"
}
