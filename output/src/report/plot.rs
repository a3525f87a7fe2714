//! A line plot as inline SVG: round ticks, units, a legend, marks with bars for references, and titles that a
//! browser shows on hovering. Colours are classes (`c0`, `c1`, …), so that the page sets them for light and
//! dark.

use super::scale::{self, Ticks};
use crate::xml::escape;
use std::fmt::Write as _;

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

const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 370.0;
const FONT: f64 = 14.0;
/// Mean advance of a character of the page's sans-serif font, generous: labels must never be cut.
const CHARACTER: f64 = 0.58 * FONT;
const LINE: f64 = 19.0;

/// The picture, or `None` if no curve has a point to draw.
pub fn svg(plot: &Plot) -> Option<String> {
    let drawable = |v: f64| v.is_finite() && (!plot.logarithmic || v > 0.0);
    let curve_points = || {
        plot.curves
            .iter()
            .flat_map(|c| c.times.iter().zip(&c.values))
            .filter(|(t, v)| t.is_finite() && drawable(**v))
    };
    let (first, last) = extent(curve_points().map(|(&t, _)| t))?;
    let x_ticks = scale::linear(first, last, 5);
    // A run that ends a window before a round time is drawn up to the round time.
    let near = |end: f64, tick: f64| if (end - tick).abs() < 0.02 * (last - first) { tick } else { end };
    let (first, last) = (near(first, x_ticks.low), near(last, x_ticks.high));
    let within = |mark: &&Mark| mark.time >= first && mark.time <= last && drawable(mark.value);
    let mark_values = plot
        .marks
        .iter()
        .flat_map(|m| m.points.iter().filter(within))
        .flat_map(|m| [m.value, m.range.map_or(m.value, |r| r.0), m.range.map_or(m.value, |r| r.1)])
        .filter(|&v| drawable(v));
    let (min, max) = extent(curve_points().map(|(_, &v)| v).chain(mark_values))?;

    let magnitude = if plot.logarithmic { 0.0 } else { min.abs().max(max.abs()) };
    let (factor, unit) = axis_unit(&plot.unit, magnitude);
    let y_ticks = if plot.logarithmic {
        scale::logarithmic(min * factor, max * factor, 8)
    } else {
        scale::linear(min * factor, max * factor, 5)
    };

    let legend = legend(plot);
    let widest = y_ticks.labels.iter().map(|(_, label)| label.chars().count()).max().unwrap_or(0);
    let area = Area {
        left: 16.0 + CHARACTER * widest as f64,
        right: WIDTH - 18.0,
        top: 30.0 + LINE * legend.rows as f64,
        bottom: HEIGHT - 42.0,
        first,
        last: if last > first { last } else { x_ticks.high },
        low: y_ticks.low,
        high: y_ticks.high,
        logarithmic: plot.logarithmic,
        factor,
    };
    let mut text = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\" xmlns=\"http://www.w3.org/2000/svg\">\n",
        escape(&plot.title)
    );
    let unit_label = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
    let _ = writeln!(
        text,
        "<text class=\"heading\" x=\"8\" y=\"18\">{}{}</text>",
        escape(&plot.title),
        escape(&unit_label)
    );
    text.push_str(&legend.svg);
    axes(&mut text, &area, &x_ticks, &y_ticks);
    for (index, curve) in plot.curves.iter().enumerate() {
        // The first of two curves is broad, so that it shows below the other where they are one.
        let broad = if index == 0 && plot.curves.len() == 2 { " broad" } else { "" };
        draw_curve(&mut text, &area, &format!("curve c{}{broad}", index % COLOURS), curve, &unit);
    }
    for (index, marks) in plot.marks.iter().enumerate() {
        for mark in marks.points.iter().filter(within) {
            draw_mark(&mut text, &area, plot.curves.len() + index, &marks.label, mark, &unit);
        }
    }
    text.push_str("</svg>\n");
    Some(text)
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

/// Where the axes lie in the picture, and what they span: time in s, values in prefixed units.
struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    first: f64,
    last: f64,
    low: f64,
    high: f64,
    logarithmic: bool,
    factor: f64,
}

impl Area {
    fn x(&self, time: f64) -> f64 {
        self.left + (self.right - self.left) * (time - self.first) / (self.last - self.first)
    }

    /// Height of a value in prefixed units.
    fn y(&self, value: f64) -> f64 {
        let map = |v: f64| if self.logarithmic { v.log10() } else { v };
        let fraction = (map(value) - map(self.low)) / (map(self.high) - map(self.low));
        self.bottom + (self.top - self.bottom) * fraction
    }

    /// Place of a value in the plot's unit; `None` where it cannot be drawn.
    fn point(&self, time: f64, value: f64) -> Option<(f64, f64)> {
        let (x, y) = (self.x(time), self.y(value * self.factor));
        (x.is_finite() && y.is_finite()).then_some((x, y))
    }
}

fn axes(text: &mut String, area: &Area, x_ticks: &Ticks, y_ticks: &Ticks) {
    let Area { left, right, top, bottom, .. } = *area;
    for (value, label) in &y_ticks.labels {
        let y = area.y(*value);
        let _ = writeln!(text, "<path class=\"grid\" d=\"M{left:.1} {y:.1}H{right:.1}\"/>");
        let _ = writeln!(
            text,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            left - 7.0,
            y + 5.0
        );
    }
    // Half a millionth of the span: a tick on the end up to round-off is drawn.
    let slack = 5e-7 * (area.last - area.first);
    for (value, label) in
        x_ticks.labels.iter().filter(|(v, _)| *v >= area.first - slack && *v <= area.last + slack)
    {
        let x = area.x(*value);
        let _ = writeln!(text, "<path class=\"grid\" d=\"M{x:.1} {top:.1}V{:.1}\"/>", bottom + 5.0);
        // A label at the right end would leave the picture if it were centred.
        let (anchor, x) = if x > right - 12.0 { ("end", right + 12.0) } else { ("middle", x) };
        let _ = writeln!(
            text,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{label}</text>",
            bottom + 20.0
        );
    }
    let _ = writeln!(text, "<path class=\"axis\" d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\"/>");
    let _ = writeln!(
        text,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">time (s)</text>",
        0.5 * (left + right),
        HEIGHT - 6.0
    );
}

fn draw_curve(text: &mut String, area: &Area, class: &str, curve: &Curve, unit: &str) {
    let points: Vec<Option<(f64, f64)>> =
        curve.times.iter().zip(&curve.values).map(|(&time, &value)| area.point(time, value)).collect();
    let mut path = String::new();
    let mut pen_down = false;
    for point in thinned(&points, 2 * (area.right - area.left) as usize) {
        match point {
            Some((x, y)) => {
                let _ = write!(path, "{}{x:.1} {y:.1}", if pen_down { 'L' } else { 'M' });
                pen_down = true;
            }
            None => pen_down = false,
        }
    }
    let label = escape(&curve.label);
    let _ = writeln!(text, "<path class=\"{class}\" d=\"{path}\"><title>{label}</title></path>");
    // Transparent discs that tell the value under the pointer; more than these would overlap.
    const HOVER_POINTS: usize = 60;
    let stride = points.len().div_ceil(HOVER_POINTS).max(1);
    for at in (0..points.len()).step_by(stride) {
        if let Some((x, y)) = points[at] {
            let value = scale::short(curve.values[at] * area.factor);
            let time = scale::short(curve.times[at]);
            let _ = writeln!(
                text,
                "<circle class=\"hover\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\"><title>{label}: {value} {} at {time} s</title></circle>",
                escape(unit)
            );
        }
    }
}

/// At most about `count` points that look the same: of every run of points, the lowest and the highest.
fn thinned(points: &[Option<(f64, f64)>], count: usize) -> Vec<Option<(f64, f64)>> {
    if points.len() <= count {
        return points.to_vec();
    }
    let run = (2 * points.len()).div_ceil(count);
    let mut kept = Vec::with_capacity(count + 2);
    for chunk in points.chunks(run) {
        let height = |index: &usize| chunk[*index].map_or(0.0, |(_, y)| y);
        let drawn = || (0..chunk.len()).filter(|&i| chunk[i].is_some());
        let low = drawn().min_by(|a, b| height(a).total_cmp(&height(b)));
        let high = drawn().max_by(|a, b| height(a).total_cmp(&height(b)));
        match (low, high) {
            (Some(low), Some(high)) => kept.extend([chunk[low.min(high)], chunk[low.max(high)]]),
            _ => kept.push(None),
        }
    }
    kept.push(points[points.len() - 1]);
    kept
}

fn draw_mark(text: &mut String, area: &Area, index: usize, label: &str, mark: &Mark, unit: &str) {
    let Some((x, y)) = area.point(mark.time, mark.value) else { return };
    let colour = index % COLOURS;
    let value = |v: f64| scale::short(v * area.factor);
    let mut title = format!("{label}: {} {unit} at {} s", value(mark.value), scale::short(mark.time));
    if let Some((low, high)) = mark.range {
        let _ = write!(title, " ({} to {})", value(low), value(high));
        if let (Some((_, low)), Some((_, high))) = (area.point(mark.time, low), area.point(mark.time, high)) {
            let (a, b) = (x - 4.0, x + 4.0);
            let _ = writeln!(
                text,
                "<path class=\"bar c{colour}\" d=\"M{x:.1} {low:.1}V{high:.1}M{a:.1} {low:.1}H{b:.1}M{a:.1} {high:.1}H{b:.1}\"/>"
            );
        }
    }
    let _ = writeln!(
        text,
        "<path class=\"mark c{colour}\" d=\"{}\"><title>{}</title></path>",
        mark_shape(index, x, y),
        escape(&title)
    );
}

/// Ball, square, triangle or diamond: marks differ without their colour.
fn mark_shape(index: usize, x: f64, y: f64) -> String {
    let (l, r, t, b) = (x - 4.5, x + 4.5, y - 4.5, y + 4.5);
    match index % 4 {
        0 => format!("M{l:.1} {t:.1}H{r:.1}V{b:.1}H{l:.1}Z"),
        1 => format!("M{l:.1} {y:.1}a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0 -9 0Z"),
        2 => format!("M{x:.1} {t:.1}L{r:.1} {b:.1}H{l:.1}Z"),
        _ => format!(
            "M{x:.1} {:.1}L{:.1} {y:.1}L{x:.1} {:.1}L{:.1} {y:.1}Z",
            y - 6.0,
            x + 6.0,
            y + 6.0,
            x - 6.0
        ),
    }
}

/// Colours that the page defines.
pub(crate) const COLOURS: usize = 8;

struct Legend {
    svg: String,
    rows: usize,
}

/// Keys in rows under the heading; none for a single curve, which the heading names.
fn legend(plot: &Plot) -> Legend {
    let mut legend = Legend { svg: String::new(), rows: 0 };
    if plot.curves.len() + plot.marks.len() < 2 {
        return legend;
    }
    legend.rows = 1;
    let labels = plot.curves.iter().map(|c| &c.label).chain(plot.marks.iter().map(|m| &m.label));
    let mut x = 10.0;
    for (index, label) in labels.enumerate() {
        let width = 40.0 + CHARACTER * label.chars().count() as f64;
        if x + width > WIDTH && x > 10.0 {
            x = 10.0;
            legend.rows += 1;
        }
        let y = 18.0 + LINE * legend.rows as f64;
        let colour = index % COLOURS;
        let key = if index < plot.curves.len() {
            format!("<path class=\"curve c{colour}\" d=\"M{x:.1} {:.1}h20\"/>", y - 5.0)
        } else {
            format!("<path class=\"mark c{colour}\" d=\"{}\"/>", mark_shape(index, x + 10.0, y - 5.0))
        };
        let _ =
            writeln!(legend.svg, "{key}<text x=\"{:.1}\" y=\"{y:.1}\">{}</text>", x + 26.0, escape(label));
        x += width;
    }
    legend
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

    #[test]
    fn values_land_where_the_axes_say() {
        let plot = Plot { unit: "m".to_owned(), curves: vec![line(&[0.0, 0.05, 0.01])], ..Plot::default() };
        let text = svg(&plot).unwrap();
        // Left end at 16 + 2 characters ("50"), right 582; 0 mm at the bottom (328), 50 mm at the top (30).
        assert!(text.contains("d=\"M32.2 328.0L307.1 30.0L582.0 268.4\""), "{text}");
        assert!(text.contains("(mm)") && text.contains("a &lt; b: 50 mm at 1 s"));
    }

    #[test]
    fn lines_break_where_there_is_no_number() {
        let text =
            svg(&Plot { curves: vec![line(&[0.0, 1.0, f64::NAN, 1.0, 0.0])], ..Plot::default() }).unwrap();
        let path = text.split("class=\"curve c0\" d=\"").nth(1).unwrap().split('"').next().unwrap();
        assert_eq!(path.matches('M').count(), 2);
        assert!(!text.contains("NaN"));
        let none = Plot { curves: vec![line(&[f64::NAN])], ..Plot::default() };
        assert!(svg(&none).is_none());
        // Zero has no place on a logarithmic axis.
        let log = Plot { logarithmic: true, curves: vec![line(&[0.0, 1e-3, 1e-16])], ..Plot::default() };
        assert!(!svg(&log).unwrap().contains("inf"));
    }

    #[test]
    fn long_labels_become_a_power_of_ten() {
        assert_eq!(axis_unit("N·m", 3.2e-9), (1e9, "10⁻⁹ N·m".to_owned()));
        assert_eq!(axis_unit("", 4e-3), (1.0, String::new()));
        assert_eq!(axis_unit("m", 3e-5).1, "µm");
    }

    #[test]
    fn thinning_keeps_the_extremes() {
        let points: Vec<_> =
            (0..10_000).map(|i| Some((f64::from(i), if i == 4321 { 9.0 } else { 0.0 }))).collect();
        let kept = thinned(&points, 1000);
        assert!(kept.len() < 1010 && kept.contains(&Some((4321.0, 9.0))));
    }
}
