//! The measures as rows of text: for the terminal, and as `validation.csv`.

use crate::run::{CaseResult, Measured, SeriesResult, Value};
use output::report::short;
use std::fmt::Write as _;
use std::path::Path;

/// File of the table.
pub const FILE: &str = "validation.csv";

/// Headings of a row of [`row`].
pub const HEADINGS: [&str; 8] =
    ["measure", "layers", "ours", "paper", "reference", "error", "tolerance", "result"];

/// One value as words for people: percentages and four to five digits.
pub fn row(measured: &Measured, value: &Value, judged: bool) -> [String; 8] {
    let measure = &measured.measure;
    let error = |e: f64| {
        if measure.reference == 0.0 { format!("{e:.1e}") } else { format!("{:+.2} %", 100.0 * e) }
    };
    let allowed = |t: f64| {
        if measure.reference == 0.0 { format!("{t:.0e}") } else { format!("{:.1} %", 100.0 * t) }
    };
    let result = match (value.passes(), judged) {
        _ if !value.found.is_finite() => "failed",
        (None, _) => "shown",
        (Some(true), _) => "pass",
        (Some(false), true) => "MISS",
        (Some(false), false) => "miss, not judged",
    };
    [
        measure.name.clone(),
        value.resolution.to_string(),
        five(value.found),
        value.paper.map_or_else(|| "–".to_owned(), five),
        five(measure.reference),
        error(value.error),
        value.tolerance.map_or_else(|| "–".to_owned(), allowed),
        result.to_owned(),
    ]
}

/// What a measure's refinement shows, in words; empty for fewer than three resolutions.
pub fn order(measured: &Measured) -> String {
    match measured.convergence {
        Some(c) => format!("observed order {:.1}, towards {}", c.order, five(c.limit)),
        None if measured.values.len() < 3 || measured.measure.reference == 0.0 => String::new(),
        None => {
            "no observed order: the steps between the three finest do not shrink as a power of the spacing"
                .to_owned()
        }
    }
}

/// Tables of all series for the terminal.
pub fn text(results: &[CaseResult]) -> String {
    let mut text = String::new();
    for case in results {
        for series in &case.series {
            let judged = if series.series.judged { "" } else { " (not judged)" };
            let _ = writeln!(text, "\n{} · {}{judged}", case.name, series.series.name);
            series_text(&mut text, series);
        }
    }
    text
}

fn series_text(text: &mut String, series: &SeriesResult) {
    let mut rows = vec![HEADINGS.map(str::to_owned)];
    for measured in &series.measures {
        rows.extend(measured.values.iter().map(|value| row(measured, value, series.series.judged)));
    }
    let width = |column: usize| rows.iter().map(|r| r[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..HEADINGS.len()).map(width).collect();
    for row in &rows {
        let mut line = format!("  {:<1$}", row[0], widths[0]);
        for (cell, width) in row[1..7].iter().zip(&widths[1..]) {
            let _ = write!(line, "  {cell:>width$}");
        }
        let _ = writeln!(text, "{line}  {}", row[7]);
    }
    for measured in &series.measures {
        let order = order(measured);
        if !order.is_empty() {
            let _ = writeln!(text, "  {}: {order}", measured.measure.name);
        }
    }
    let times: Vec<String> =
        series.variants.iter().map(|v| format!("{}: {} s", v.resolution, short(v.seconds))).collect();
    let _ = writeln!(text, "  computing, by layers: {}", times.join(", "));
}

/// Five significant digits.
pub fn five(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !value.is_finite() {
        "none".to_owned()
    } else if (1e-3..1e5).contains(&magnitude) {
        let decimals = (4.0 - magnitude.log10().floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.4e}")
    }
}

/// Writes `validation.csv`: one row a measure, series and resolution, numbers in full.
///
/// # Errors
/// A file that cannot be written.
pub fn write(results: &[CaseResult], out: &Path) -> output::Result<()> {
    let mut text = String::from(
        "case,series,measure,resolution,found,paper,reference,error,tolerance,judged,passes,order,limit,compute_seconds,source\n",
    );
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    for case in results {
        for series in &case.series {
            for measured in &series.measures {
                for (value, variant) in measured.values.iter().zip(&series.variants) {
                    let cells = [
                        case.name.clone(),
                        series.series.name.clone(),
                        quoted(&measured.measure.name),
                        value.resolution.to_string(),
                        value.found.to_string(),
                        number(value.paper),
                        measured.measure.reference.to_string(),
                        value.error.to_string(),
                        number(value.tolerance),
                        series.series.judged.to_string(),
                        value.passes().map_or_else(String::new, |p| p.to_string()),
                        number(measured.convergence.map(|c| c.order)),
                        number(measured.convergence.map(|c| c.limit)),
                        variant.seconds.to_string(),
                        quoted(&measured.measure.source),
                    ];
                    text.push_str(&cells.join(","));
                    text.push('\n');
                }
            }
        }
    }
    output::atomic::write_file(&out.join(FILE), text.as_bytes())
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
