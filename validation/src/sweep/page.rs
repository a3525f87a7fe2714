//! `sweep.html`: the members' curves side by side, in one file that needs nothing else.

use super::{Overs, Result};
use coupler::records::PROBES;
use output::report::{Curve, Plot, chart, document, escape, short};
use output::table::{self, Columns};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// File of the page.
pub const FILE: &str = "sweep.html";

/// Rows of a member's table that are drawn: more than a screen has points.
const ROWS: usize = 2000;

/// Writes the page into the folder of the sweep, and gives its path.
///
/// # Errors
/// A file that cannot be written.
pub fn write(results: &[Result], overs: &Overs, title: &str, out: &Path) -> output::Result<PathBuf> {
    let mut body = String::new();
    members(&mut body, results, overs, out);
    let tables: Vec<(String, Columns)> = results
        .iter()
        .filter_map(|Result { member, .. }| {
            let table = table::read_at_most(&out.join(&member.folder).join(PROBES), ROWS).ok()?;
            Some((overs.label(&member.values), table))
        })
        .collect();
    body.push_str("<h2>Probes</h2>\n<div class=\"figures\">\n");
    for (column, plot) in plots(&tables) {
        if let Some(chart) = chart(&plot) {
            let _ = writeln!(body, "<figure id=\"{}\">\n{chart}</figure>", escape(&column));
        }
    }
    body.push_str("</div>\n");
    let path = out.join(FILE);
    output::atomic::write_file(&path, document(&format!("Sweep: {title}"), &body).as_bytes())?;
    Ok(path)
}

/// A row per member, with a link to its report.
fn members(body: &mut String, results: &[Result], overs: &Overs, out: &Path) {
    let keys: String = overs.keys().map(|key| format!("<th>{}</th>", escape(key))).collect();
    let _ = writeln!(
        body,
        "<div class=\"scroll\"><table>\n<tr>{keys}<th>ended</th><th>windows</th><th>t (s)</th><th>took (s)</th><th></th></tr>"
    );
    for Result { member, summary, .. } in results {
        let values: String = member.values.iter().map(|v| format!("<td>{}</td>", escape(v))).collect();
        let report = Path::new(&member.folder).join("report.html");
        let link = match out.join(&report).exists() {
            true => format!("<a href=\"{}\">report</a>", escape(&report.to_string_lossy())),
            false => String::new(),
        };
        let message = summary.message.as_deref().map_or(String::new(), |m| format!(": {}", escape(m)));
        let _ = writeln!(
            body,
            "<tr>{values}<td>{}{message}</td><td>{}</td><td>{}</td><td>{:.1}</td><td>{link}</td></tr>",
            summary.status.word(),
            summary.windows,
            short(summary.simulated_seconds),
            summary.wall_seconds,
        );
    }
    body.push_str("</table></div>\n");
}

/// A plot for every column that any member has, all members in it.
fn plots(tables: &[(String, Columns)]) -> BTreeMap<String, Plot> {
    let mut plots: BTreeMap<String, Plot> = BTreeMap::new();
    for (label, table) in tables {
        let Some(times) = table.get("t") else { continue };
        for (column, values) in table.iter().filter(|(column, _)| *column != "t") {
            let plot = plots.entry(column.to_owned()).or_insert_with(|| Plot {
                title: column.to_owned(),
                unit: table.unit(column),
                ..Plot::default()
            });
            let (times, values) = (times.to_vec(), values.to_vec());
            plot.curves.push(Curve { label: label.clone(), times, values });
        }
    }
    plots
}
