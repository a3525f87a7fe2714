//! A plot against time as data for uPlot, which draws it where the page is opened: curves that zoom and tell
//! their values, and reference points with bars. `report.js` reads what [`chart`] writes.

use super::scale;
use crate::xml::escape;
use serde_json::{Value, json};
use words::text::tame;

/// A plot of quantities of one unit against time.
#[derive(Debug, Clone, Default)]
pub struct Plot {
    /// Heading.
    pub title: String,
    /// Unit of the values before a prefix; empty for a number without unit.
    pub unit: String,
    /// Whether values stand on a logarithmic axis; those that are not positive are left out then.
    pub logarithmic: bool,
    /// Lines.
    pub curves: Vec<Curve>,
    /// References beside them.
    pub marks: Vec<Marks>,
}

/// A line through `(time, value)`; it is broken where a value is not finite.
#[derive(Debug, Clone)]
pub struct Curve {
    /// For the legend.
    pub label: String,
    /// Times (s).
    pub times: Vec<f64>,
    /// As many values, in the plot's unit.
    pub values: Vec<f64>,
}

/// Reference points.
#[derive(Debug, Clone)]
pub struct Marks {
    /// For the legend.
    pub label: String,
    /// The points.
    pub points: Vec<Mark>,
}

/// A reference point with the range it is known in.
#[derive(Debug, Clone, Copy)]
pub struct Mark {
    /// Time (s).
    pub time: f64,
    /// Value, in the plot's unit.
    pub value: f64,
    /// Least and largest value that the source allows.
    pub range: Option<(f64, f64)>,
}

/// Rows of a table that are drawn: a screen is half as wide.
const ROWS: usize = 4000;

/// The plot as an element of a [`document`](super::page::document), or `None` if no curve has a point to
/// draw. References outside of the curves' time are left out.
pub fn chart(plot: &Plot) -> Option<String> {
    let drawable = |v: f64| v.is_finite() && (!plot.logarithmic || v > 0.0);
    let points = || {
        let all = plot.curves.iter().flat_map(|c| c.times.iter().zip(&c.values));
        all.filter(|(t, v)| t.is_finite() && drawable(**v))
    };
    let (first, last) = extent(points().map(|(t, _)| *t))?;
    let (least, largest) = extent(points().map(|(_, v)| *v))?;
    let magnitude = if plot.logarithmic { 0.0 } else { least.abs().max(largest.abs()) };
    let (factor, unit) = axis_unit(&plot.unit, magnitude);
    let number = |v: f64| if drawable(v) { json!(rounded(v * factor)) } else { Value::Null };

    let (mut tables, mut series) = (Vec::new(), Vec::new());
    for curves in plot.curves.chunk_by(|a, b| a.times == b.times) {
        let rows = thinned(curves);
        let mut table = vec![rows.iter().map(|&row| json!(curves[0].times[row])).collect::<Vec<_>>()];
        table.extend(curves.iter().map(|c| rows.iter().map(|&row| number(c.values[row])).collect()));
        tables.push(table);
        series.extend(curves.iter().map(|curve| json!({ "label": curve.label })));
    }
    for marks in &plot.marks {
        let within = |mark: &&Mark| mark.time >= first && mark.time <= last && drawable(mark.value);
        let points: Vec<&Mark> = marks.points.iter().filter(within).collect();
        let bar = |mark: &&Mark| mark.range.map(|(low, high)| json!([mark.time, number(low), number(high)]));
        tables.push(vec![
            points.iter().map(|mark| json!(mark.time)).collect(),
            points.iter().map(|mark| number(mark.value)).collect(),
        ]);
        let bars: Vec<Value> = points.iter().filter_map(bar).collect();
        series.push(json!({ "label": marks.label, "bars": bars }));
    }
    let title = if unit.is_empty() { plot.title.clone() } else { format!("{} ({unit})", plot.title) };
    let data = json!({ "title": title, "log": plot.logarithmic, "tables": tables, "series": series });
    // Nothing in it can end the element, or turn the reading direction.
    let data = tame(&data.to_string(), usize::MAX).replace('<', "\\u003c");
    Some(format!(
        "<div class=\"chart\" role=\"img\" aria-label=\"{}\"><script type=\"application/json\">{data}</script></div>\n",
        escape(&title)
    ))
}

/// To seven digits, more than a screen shows.
fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// As [`scale::prefixed`]; a power of ten where there is no prefix and tick labels would get long.
fn axis_unit(unit: &str, magnitude: f64) -> (f64, String) {
    let (factor, prefixed) = scale::prefixed(unit, magnitude);
    let magnitude = magnitude * factor;
    if magnitude == 0.0 || (1e-3..1e5).contains(&magnitude) {
        return (factor, prefixed);
    }
    let power = magnitude.log10().floor() as i32;
    (factor * 10f64.powi(-power), format!("{} {prefixed}", scale::power_of_ten(power)).trim_end().to_owned())
}

fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, v| {
        Some(range.map_or((v, v), |(low, high): (f64, f64)| (low.min(v), high.max(v))))
    })
}

/// About [`ROWS`] rows of curves of the same times that look the same as all of them: the ends, and of each
/// stretch those with the least and the largest value of each curve.
fn thinned(curves: &[Curve]) -> Vec<usize> {
    let all = curves[0].times.len();
    if all <= ROWS {
        return (0..all).collect();
    }
    let mut rows = vec![0, all - 1];
    let size = (2 * curves.len() * all).div_ceil(ROWS);
    for first in (0..all).step_by(size) {
        for curve in curves {
            let finite = || (first..all.min(first + size)).filter(|&row| curve.values[row].is_finite());
            let by_value = |a: &usize, b: &usize| curve.values[*a].total_cmp(&curve.values[*b]);
            // Where there is no number, the gap is kept.
            rows.push(finite().min_by(by_value).unwrap_or(first));
            rows.extend(finite().max_by(by_value));
        }
    }
    rows.sort_unstable();
    rows.dedup();
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(values: &[f64]) -> Curve {
        Curve {
            label: "a < b".to_owned(),
            times: (0..values.len()).map(|i| i as f64).collect(),
            values: values.to_vec(),
        }
    }

    fn data(plot: &Plot) -> Value {
        let text = chart(plot).unwrap();
        let json = text.split_once("json\">").unwrap().1.split_once('<').unwrap().0;
        serde_json::from_str(json).unwrap()
    }

    #[test]
    fn values_are_in_the_unit_of_the_title_and_marks_within_the_time() {
        let mark = |time, value, range| Mark { time, value, range };
        let marks = vec![Marks {
            label: "experiment".to_owned(),
            points: vec![mark(1.0, 0.04, Some((0.03, 0.05))), mark(2.0, 0.02, None), mark(9.0, 1.0, None)],
        }];
        let curves = vec![line(&[0.0, 0.05, f64::NAN, 0.01])];
        let plot = Plot { title: "tip".to_owned(), unit: "m".to_owned(), curves, marks, ..Plot::default() };
        let expected = json!({
            "title": "tip (mm)",
            "log": false,
            "tables": [[[0.0, 1.0, 2.0, 3.0], [0.0, 50.0, null, 10.0]], [[1.0, 2.0], [40.0, 20.0]]],
            "series": [{ "label": "a < b" }, { "label": "experiment", "bars": [[1.0, 30.0, 50.0]] }],
        });
        assert_eq!(data(&plot), expected);
    }

    #[test]
    fn what_cannot_be_drawn_is_left_out() {
        assert!(chart(&Plot { curves: vec![line(&[f64::NAN])], ..Plot::default() }).is_none());
        assert!(chart(&Plot { logarithmic: true, curves: vec![line(&[0.0])], ..Plot::default() }).is_none());
        // Zero has no place on a logarithmic axis.
        let plot = Plot { logarithmic: true, curves: vec![line(&[0.0, 0.5])], ..Plot::default() };
        assert_eq!(data(&plot)["tables"], json!([[[0.0, 1.0], [null, 0.5]]]));
    }

    #[test]
    fn long_labels_become_a_power_of_ten() {
        assert_eq!(axis_unit("N·m", 3.2e-9), (1e9, "10⁻⁹ N·m".to_owned()));
        assert_eq!(axis_unit("", 4e-3), (1.0, String::new()));
        assert_eq!(axis_unit("m", 3e-5).1, "µm");
    }

    #[test]
    fn thinning_keeps_ends_and_extremes_at_their_times() {
        let mut values = vec![0.0; 100_000];
        values[43_210] = 9.0;
        let rows = thinned(&[line(&values), line(&vec![f64::NAN; 100_000])]);
        assert!(rows.len() <= ROWS + 2 && rows.is_sorted());
        assert!([0, 43_210, 99_999].iter().all(|row| rows.contains(row)));
    }
}
