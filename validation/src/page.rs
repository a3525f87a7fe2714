//! `validation.html`: tables and curves of all series in one file that needs nothing else.

use crate::run::{CaseResult, SeriesResult, Variant};
use crate::study::Figure;
use crate::tables::{HEADINGS, order, row};
use interfaces::case::probe::Reference;
use output::report::{Curve, Mark, Marks, Plot, chart, document, escape};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// File of the page.
pub const FILE: &str = "validation.html";

/// Writes the page into the folder of the validation, and gives its path.
///
/// # Errors
/// A file that cannot be written.
pub fn write(results: &[CaseResult], suite: &str, out: &Path) -> output::Result<PathBuf> {
    let mut body = String::new();
    for case in results {
        let _ = writeln!(body, "<h2>{}</h2>", escape(&case.title));
        for series in &case.series {
            let judged = if series.series.judged { "" } else { " (not judged)" };
            let _ = writeln!(body, "<h3>{}{judged}</h3>", escape(&series.series.name));
            table(&mut body, series);
            links(&mut body, series);
            figures(&mut body, series);
        }
        for figure in &case.study.figures {
            beside_each_other(&mut body, figure, case);
        }
    }
    let path = out.join(FILE);
    output::atomic::write_file(&path, document(&format!("Validation: {suite}"), &body).as_bytes())?;
    Ok(path)
}

fn table(body: &mut String, series: &SeriesResult) {
    let heads: String = HEADINGS.iter().map(|h| format!("<th>{h}</th>")).collect();
    let _ = writeln!(body, "<div class=\"scroll\"><table>\n<tr>{heads}</tr>");
    for measured in &series.measures {
        for value in &measured.values {
            let [name, cells @ ..] = row(measured, value, series.series.judged);
            let cells: String = cells.iter().map(|c| format!("<td>{}</td>", escape(c))).collect();
            let _ = writeln!(body, "<tr><th scope=\"row\">{}</th>{cells}</tr>", escape(&name));
        }
    }
    body.push_str("</table></div>\n");
    let notes: String = series
        .measures
        .iter()
        .map(|m| {
            let order = order(m);
            let order = if order.is_empty() { order } else { format!("; {order}") };
            format!(
                "<li>{}</li>",
                escape(&format!("{}: reference of {}{order}.", m.measure.name, m.measure.source))
            )
        })
        .collect();
    let _ = writeln!(body, "<ul>{notes}</ul>");
}

/// The report of each run, which has the energies.
fn links(body: &mut String, series: &SeriesResult) {
    let links: Vec<String> = series
        .variants
        .iter()
        .map(|v| {
            let failure = v.failure.as_ref().map_or(String::new(), |f| format!(" failed: {}", escape(f)));
            // Folders are made of names of cases and series.
            let href = escape(&v.folder.join("report.html").to_string_lossy());
            format!("<a href=\"{href}\">{} layers</a> ({:.1} s){failure}", v.resolution, v.seconds)
        })
        .collect();
    let _ = writeln!(body, "<p>Reports of the runs, with energies: {}.</p>", links.join(", "));
}

/// A figure for every column that is measured, all resolutions in it.
fn figures(body: &mut String, series: &SeriesResult) {
    let columns: BTreeSet<&str> =
        series.measures.iter().map(|m| m.measure.column.as_str()).filter(|c| !c.is_empty()).collect();
    body.push_str("<div class=\"figures\">\n");
    for column in columns {
        let curve = |variant: &Variant| curve(variant, column, format!("{} layers", variant.resolution));
        let plot = Plot {
            title: column.to_owned(),
            unit: unit(&series.variants, column),
            curves: series.variants.iter().filter_map(curve).collect(),
            marks: marks(series, column),
            ..Plot::default()
        };
        if let Some(chart) = chart(&plot) {
            let _ = writeln!(body, "<figure>\n{chart}</figure>");
        }
    }
    body.push_str("</div>\n");
}

/// A figure with several series in it, each at the finest resolution that was run.
fn beside_each_other(body: &mut String, figure: &Figure, case: &CaseResult) {
    let found = |name: &String| case.series.iter().find(|series| series.series.name == *name);
    let series: Vec<&SeriesResult> = figure.series.iter().filter_map(found).collect();
    let finest = |series: &&SeriesResult| {
        let variant = series.variants.last()?;
        curve(variant, &figure.column, format!("{}, {} layers", series.series.name, variant.resolution))
    };
    let plot = Plot {
        title: figure.title.clone(),
        unit: series.first().map_or_else(String::new, |series| unit(&series.variants, &figure.column)),
        curves: series.iter().filter_map(finest).collect(),
        marks: series.first().map_or_else(Vec::new, |series| marks(series, &figure.column)),
        ..Plot::default()
    };
    if let Some(chart) = chart(&plot) {
        let _ = writeln!(body, "<div class=\"figures\">\n<figure>\n{chart}</figure>\n</div>");
    }
}

/// The course of a column in a run.
fn curve(variant: &Variant, column: &str, label: String) -> Option<Curve> {
    let table = variant.table_of(column)?;
    let rows = table.get("t")?.iter().zip(table.get(column)?);
    // A row of the intervals without a value is one at which intervals of another length end, and no gap.
    let is_of_column = |(_, value): &(&f64, &f64)| value.is_finite() || variant.probes.get(column).is_some();
    let (times, values) = rows.filter(is_of_column).map(|(time, value)| (*time, *value)).unzip();
    Some(Curve { label, times, values })
}

fn unit(variants: &[Variant], column: &str) -> String {
    let table = variants.iter().find_map(|variant| variant.table_of(column));
    table.map_or_else(String::new, |table| table.unit(column))
}

/// The case's references of this column that the series names.
fn marks(series: &SeriesResult, column: &str) -> Vec<Marks> {
    let Some(case) = &series.case else { return Vec::new() };
    let drawn =
        case.references.iter().filter(|r| r.probe == column && series.series.references.contains(&r.label));
    drawn
        .map(|r| Marks {
            label: r.label.clone(),
            points: r
                .time
                .iter()
                .zip(&r.value)
                .enumerate()
                .map(|(i, (&time, &value))| Mark { time, value, range: range(r, i) })
                .collect(),
        })
        .collect()
}

/// The range in which a reference's value is known; nothing where it is none.
fn range(reference: &Reference, i: usize) -> Option<(f64, f64)> {
    let border = |borders: &[f64]| borders.get(i).copied().unwrap_or(reference.value[i]);
    let (low, high) = (border(&reference.low), border(&reference.high));
    (high > low).then_some((low, high))
}
