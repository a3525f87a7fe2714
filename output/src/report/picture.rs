//! One picture of particles: each a disc of about its own area, coloured by one quantity a medium, in axes of
//! equal scale with the time above and the colour bars below.

use super::colours::{self, ColourMap};
use super::image::{Image, Rectangle, Rgb};
use super::letters::width;
use super::scale;

/// The particles of one medium.
pub(crate) struct Layer {
    /// Places in m, in drawing order.
    pub points: Vec<(f64, f64)>,
    pub paint: Paint,
    /// Distance of neighbouring particles in m.
    pub spacing: f64,
}

pub(crate) enum Paint {
    Plain(Rgb),
    /// A value a point, and the colour bar that it is read from.
    Values(Vec<f64>, Bar),
}

/// What the colours of a layer mean.
#[derive(Debug, Clone)]
pub(crate) struct Bar {
    pub label: String,
    pub unit: &'static str,
    pub map: ColourMap,
    pub low: f64,
    pub high: f64,
}

/// The part of space that a picture shows, in m; in three dimensions, seen along y, `y` is of the third axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From the left to the right.
    pub x: (f64, f64),
    /// From the bottom to the top.
    pub y: (f64, f64),
}

const BACKGROUND: Rgb = [255; 3];
const INK: Rgb = [40, 44, 52];
const LEFT: usize = 76;
const RIGHT: usize = 24;
const TOP: usize = 44;
const LINE: usize = 24;
const BAR_HEIGHT: usize = 16;
/// Heights of lines of text, in pixels.
const HEADING: f32 = 26.0;
const TEXT: f32 = 19.0;

/// Draws the layers over each other, below a heading.
pub(crate) fn draw(heading: &str, view: &View, layers: &[Layer]) -> Image {
    let (width, height) = (view.x.1 - view.x.0, view.y.1 - view.y.0);
    // Pixels a metre: as large as fits into 800 × 560.
    let scale = (800.0 / width).min(560.0 / height);
    let plot_width = (width * scale).round().max(1.0) as usize;
    let plot_height = (height * scale).round().max(1.0) as usize;
    let plot = Rectangle { left: LEFT, top: TOP, right: LEFT + plot_width, bottom: TOP + plot_height };
    let bars: Vec<&Bar> = layers
        .iter()
        .filter_map(|layer| match &layer.paint {
            Paint::Values(_, bar) => Some(bar),
            Paint::Plain(_) => None,
        })
        .collect();
    let bars_top = plot.bottom + 2 * LINE;
    let image_height = if bars.is_empty() { bars_top } else { bars_top + 2 * LINE + BAR_HEIGHT + 8 };
    let image_width = (plot.right + RIGHT).max(LEFT + RIGHT + 310 * bars.len().max(1));

    let mut image = Image::new(image_width, image_height, BACKGROUND);
    for layer in layers {
        draw_layer(&mut image, layer, view, plot, scale);
    }
    image.outline(plot, INK);
    image.text(heading, LEFT as f32, 0.5 * TOP as f32, HEADING, INK);
    axes(&mut image, view, plot, scale);
    for (index, bar) in bars.iter().enumerate() {
        let share = (image_width - LEFT - RIGHT) / bars.len();
        let left = LEFT + index * share;
        draw_bar(&mut image, bar, left, left + share - if index + 1 < bars.len() { 48 } else { 0 }, bars_top);
    }
    image
}

fn draw_layer(image: &mut Image, layer: &Layer, view: &View, plot: Rectangle, scale: f64) {
    // A disc of the area of a square of side Δx has the radius 0.56 Δx; with 0.6 Δx a lattice shows no
    // pattern of gaps, and a hole of one particle still shows. Below 0.8 pixels a disc would fade away.
    let radius = (0.6 * layer.spacing * scale).max(0.8);
    let place = |index: usize| {
        let (x, y) = layer.points[index];
        (plot.left as f64 + (x - view.x.0) * scale, plot.bottom as f64 - (y - view.y.0) * scale)
    };
    let (values, bar) = match &layer.paint {
        Paint::Values(values, bar) => (values, bar),
        Paint::Plain(colour) => {
            (0..layer.points.len()).for_each(|index| image.disc(place(index), radius, *colour, plot));
            return;
        }
    };
    for (index, value) in values.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
        let colour = colours::colour(bar.map, (value - bar.low) / (bar.high - bar.low));
        image.disc(place(index), radius, colour, plot);
    }
    // What is no number is drawn last and never small: it must be seen.
    for (index, _) in values.iter().enumerate().filter(|(_, value)| value.is_nan()) {
        image.disc(place(index), radius.max(3.0), colours::BROKEN, plot);
    }
}

fn axes(image: &mut Image, view: &View, plot: Rectangle, scale: f64) {
    let reach =
        [view.x.0, view.x.1, view.y.0, view.y.1].into_iter().fold(0.0, |max: f64, v| max.max(v.abs()));
    let (factor, unit) = scale::prefixed("m", reach);
    let (below, beside) = (plot.bottom as f32 + 18.0, plot.left as f32 - 10.0);
    // A label needs about 70 pixels along x and 40 along y.
    let count = |pixels: usize, each: usize| (pixels / each).clamp(1, 8);
    let inside = |(low, high): (f64, f64), count: usize| {
        let ticks = scale::linear(low * factor, high * factor, count).labels;
        ticks.into_iter().filter(move |(v, _)| *v >= low * factor && *v <= high * factor)
    };
    for (value, label) in inside(view.x, count(plot.right - plot.left, 90)) {
        let x = plot.left + ((value / factor - view.x.0) * scale) as usize;
        image.fill(Rectangle { left: x, top: plot.bottom, right: x + 2, bottom: plot.bottom + 6 }, INK);
        let left = (x + 1) as f32 - 0.5 * width(&label, TEXT);
        image.text(&label, left, below, TEXT, INK);
    }
    for (value, label) in inside(view.y, count(plot.bottom - plot.top, 60)) {
        let y = plot.bottom - ((value / factor - view.y.0) * scale) as usize;
        image.fill(Rectangle { left: plot.left - 6, top: y - 1, right: plot.left, bottom: y + 1 }, INK);
        image.text(&label, beside - width(&label, TEXT), y as f32, TEXT, INK);
    }
    image.text(&unit, beside - width(&unit, TEXT), below, TEXT, INK);
}

fn draw_bar(image: &mut Image, bar: &Bar, left: usize, right: usize, top: usize) {
    let (factor, unit) = scale::prefixed(bar.unit, bar.low.abs().max(bar.high.abs()));
    let label = if unit.is_empty() { bar.label.clone() } else { format!("{} ({unit})", bar.label) };
    image.text(&label, left as f32, top as f32 + 9.0, TEXT, INK);
    let area = Rectangle { left, top: top + LINE, right, bottom: top + LINE + BAR_HEIGHT };
    for x in left..right {
        let fraction = (x - left) as f64 / (right - left - 1) as f64;
        image.fill(Rectangle { left: x, right: x + 1, ..area }, colours::colour(bar.map, fraction));
    }
    image.outline(area, INK);
    let (low, high) = (bar.low * factor, bar.high * factor);
    // Half a thousandth of the range: a tick on the end up to round-off is drawn.
    let slack = 5e-4 * (high - low);
    let ticks = scale::linear(low, high, ((right - left) / 80).clamp(1, 6)).labels;
    for (value, label) in ticks.into_iter().filter(|(v, _)| *v >= low - slack && *v <= high + slack) {
        let x = left + ((value - low) / (high - low) * (right - left - 1) as f64).max(0.0) as usize;
        image.fill(Rectangle { left: x, top: area.bottom, right: x + 2, bottom: area.bottom + 5 }, INK);
        let wide = width(&label, TEXT);
        let place = (x as f32 - 0.5 * wide).min(image.width as f32 - wide - 2.0);
        image.text(&label, place, area.bottom as f32 + 17.0, TEXT, INK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_seen() {
        let bar = Bar { label: "p".to_owned(), unit: "Pa", map: colours::VIRIDIS, low: 0.0, high: 1.0 };
        let points = (0..900).map(|i| (f64::from(i % 30), f64::from(i / 30))).collect();
        let mut values = vec![0.5; 900];
        values[450] = f64::NAN;
        let layer = Layer { points, paint: Paint::Values(values, bar), spacing: 1.0 };
        let image = draw("", &View { x: (-1.0, 30.0), y: (-1.0, 30.0) }, &[layer]);
        let broken = image.pixels.as_chunks::<3>().0.iter().filter(|p| **p == colours::BROKEN).count();
        // Radius 0.6 of 18 pixels a metre: 368 pixels, less the soft edge.
        assert!((250..368).contains(&broken), "{broken}");
    }
}
