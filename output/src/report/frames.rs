//! Which snapshots become pictures, and what they show.

use super::colours::{REDS, VIRIDIS};
use super::picture::{self, Bar, Layer, Paint, View};
use super::scale;
use crate::atomic;
use crate::error::{Result, read_error, write_error};
use crate::files;
use crate::pvd::{self, SeriesEntry};
use crate::vtu::{self, Frame};
use std::fs;
use std::path::{Path, PathBuf};

/// Pictures in a report.
const COUNT: usize = 8;

/// A picture as it was written to `frames/`.
pub(crate) struct FramePicture {
    pub caption: String,
    pub file: PathBuf,
    pub png: Vec<u8>,
}

/// Fluid, structure and walls at one time.
struct Moment {
    time: f64,
    walls: Option<Frame>,
    fluid: Option<Frame>,
    structure: Option<Frame>,
}

/// Draws about [`COUNT`] pictures evenly over the run, and one of the structure alone where it is small, and
/// of its displacement where there is no fluid, and writes them to `dir/frames/`; none if the run left no
/// snapshots. Pictures of an earlier report there are replaced.
pub(crate) fn draw_frames(dir: &Path) -> Result<Vec<FramePicture>> {
    let series = |name: &str| {
        let path = dir.join(format!("{name}.pvd"));
        if path.exists() { pvd::read(&path) } else { Ok(Vec::new()) }
    };
    let (walls, fluid, structure) = (series("walls")?, series("fluid")?, series("structure")?);
    let leading = if fluid.is_empty() { &structure } else { &fluid };
    let mut moments = Vec::new();
    for entry in evenly(leading, COUNT) {
        let at = |series: &[SeriesEntry]| nearest(series, entry.time).map(|e| vtu::read(&e.file)).transpose();
        moments.push(Moment {
            time: entry.time,
            walls: at(&walls)?,
            fluid: at(&fluid)?,
            structure: at(&structure)?,
        });
    }
    if moments.is_empty() {
        return Ok(Vec::new());
    }

    // Spacings come from the first snapshot, where particles stand on their lattice.
    let first_spacing = |series: &[SeriesEntry]| -> Result<f64> {
        series.first().map_or(Ok(0.0), |entry| Ok(spacing(&vtu::read(&entry.file)?.positions)))
    };
    let spacings = [first_spacing(&walls)?, first_spacing(&fluid)?, first_spacing(&structure)?];
    let view = view(&moments, spacings[1].max(spacings[2]));
    let fluid_bar =
        bar("pressure", "Pa", VIRIDIS, moments.iter().filter_map(|m| pressure(m.fluid.as_ref()?)));
    let stress_bar =
        bar("von Mises stress", "Pa", REDS, moments.iter().filter_map(|m| von_mises(m.structure.as_ref()?)));

    let folder = dir.join("frames");
    prepare(&folder)?;
    let layers = |moment: &Moment| {
        let mut layers = Vec::new();
        if let Some(frame) = &moment.walls {
            layers.push(layer(frame, None, WALL, spacings[0]));
        }
        if let Some(frame) = &moment.fluid {
            layers.push(layer(frame, pressure(frame).zip(fluid_bar.clone()), PLAIN_FLUID, spacings[1]));
        }
        if let Some(frame) = &moment.structure {
            layers.push(layer(frame, von_mises(frame).zip(stress_bar.clone()), PLAIN_STRUCTURE, spacings[2]));
        }
        layers
    };
    let save = |name: String, caption: String, moment: &Moment, view: &View| -> Result<FramePicture> {
        let png = picture::draw(moment.time, view, &layers(moment)).png();
        let file = folder.join(name);
        atomic::write_file(&file, &png)?;
        Ok(FramePicture { caption, file, png })
    };
    let mut pictures = Vec::new();
    for moment in &moments {
        let caption = format!("{} s", scale::short(moment.time));
        pictures.push(save(format!("t{:.4}.png", moment.time), caption, moment, &view)?);
    }
    if let Some(Displaced { moment, frame, axis, values, largest }) = furthest(&moments) {
        let label = format!("displacement u{}", ["x", "y", "z"][axis]);
        let colours = bar(&label, "m", VIRIDIS, std::iter::once(values.clone()));
        let layers = [layer(frame, Some(values).zip(colours), PLAIN_STRUCTURE, spacings[2])];
        let png = picture::draw(moment.time, &view, &layers).png();
        let file = folder.join(DISPLACEMENT);
        atomic::write_file(&file, &png)?;
        let (time, largest) = (scale::short(moment.time), scale::quantity(largest, "m"));
        let caption = format!("The {label} at {time} s, {largest} at most, as the paper's Fig. 7");
        pictures.push(FramePicture { caption, file, png });
    }
    if let Some((moment, near)) = close_up(&moments, &view, spacings[2]) {
        let caption =
            format!("The structure at {} s, where its stress is largest", scale::short(moment.time));
        pictures.push(save(CLOSE_UP.to_owned(), caption, moment, &near)?);
    }
    Ok(pictures)
}

/// File of the structure's picture, as the paper's Fig. 18.
const CLOSE_UP: &str = "structure.png";

/// File of the picture of the displacement, as the paper's Fig. 7, in runs of the structure alone.
const DISPLACEMENT: &str = "displacement.png";

/// One component of the displacement at one moment.
struct Displaced<'a> {
    moment: &'a Moment,
    frame: &'a Frame,
    axis: usize,
    /// At each particle (m).
    values: Vec<f64>,
    /// Largest size among them (m).
    largest: f64,
}

/// Of a structure alone: the component of displacement that is largest among the moments drawn.
fn furthest(moments: &[Moment]) -> Option<Displaced<'_>> {
    let component = |moment: &'_ Moment, axis: usize| -> Option<(Vec<f64>, f64)> {
        let array = moment.structure.as_ref()?.array("displacement").filter(|a| axis < a.components)?;
        let values: Vec<f64> = array.values.chunks_exact(array.components).map(|u| u[axis]).collect();
        let largest = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        (largest > 0.0 && largest.is_finite()).then_some((values, largest))
    };
    let mut best: Option<Displaced> = None;
    for moment in moments.iter().filter(|moment| moment.fluid.is_none()) {
        let Some(frame) = &moment.structure else { continue };
        for axis in 0..3 {
            let Some((values, largest)) = component(moment, axis) else { continue };
            if best.as_ref().is_none_or(|b| largest > b.largest) {
                best = Some(Displaced { moment, frame, axis, values, largest });
            }
        }
    }
    best
}

/// The moment of largest stress among those drawn, and the structure's surroundings then; `None` without
/// stress, or if the other pictures show the structure as large already.
fn close_up<'a>(moments: &'a [Moment], whole: &View, spacing: f64) -> Option<(&'a Moment, View)> {
    let stress = |moment: &Moment| quantile(von_mises(moment.structure.as_ref()?)?, 0.995);
    let (moment, _) = moments
        .iter()
        .filter_map(|moment| Some((moment, stress(moment)?)))
        .max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let alone = Moment { time: moment.time, walls: None, fluid: None, structure: moment.structure.clone() };
    let near = view(std::slice::from_ref(&alone), spacing);
    let size = |view: &View| (view.x.1 - view.x.0).max(view.y.1 - view.y.0);
    (size(&near) < 0.7 * size(whole)).then_some((moment, near))
}

const WALL: [u8; 3] = [150, 154, 160];
const PLAIN_FLUID: [u8; 3] = [51, 99, 141];
const PLAIN_STRUCTURE: [u8; 3] = [196, 32, 38];

/// At most `count` entries, the first and the last among them.
fn evenly(entries: &[SeriesEntry], count: usize) -> Vec<&SeriesEntry> {
    if entries.len() <= count {
        return entries.iter().collect();
    }
    (0..count).map(|i| &entries[(i * (entries.len() - 1) + (count - 1) / 2) / (count - 1)]).collect()
}

fn nearest(entries: &[SeriesEntry], time: f64) -> Option<&SeriesEntry> {
    entries.iter().min_by(|a, b| (a.time - time).abs().total_cmp(&(b.time - time).abs()))
}

/// Empties `folder` of the pictures of an earlier report.
fn prepare(folder: &Path) -> Result<()> {
    files::folder(folder).map_err(write_error(folder))?;
    for entry in fs::read_dir(folder).map_err(read_error(folder))? {
        let path = entry.map_err(read_error(folder))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let time = name.strip_prefix('t').and_then(|rest| rest.strip_suffix(".png"));
        if name == CLOSE_UP || name == DISPLACEMENT || time.is_some_and(|text| text.parse::<f64>().is_ok()) {
            fs::remove_file(&path).map_err(write_error(&path))?;
        }
    }
    Ok(())
}

/// Median distance to the nearest other particle, over at most 2000 of them, in m; 0 for fewer than two.
fn spacing(positions: &[f64]) -> f64 {
    let mut points: Vec<[f64; 3]> =
        positions.as_chunks::<3>().0.iter().copied().filter(|p| p.iter().all(|v| v.is_finite())).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let nearest = |index: usize| {
        let p = points[index];
        let mut best = f64::INFINITY;
        // Sorted by x: no particle beyond the best distance along x can be nearer.
        let mut look = |others: &mut dyn Iterator<Item = &[f64; 3]>| {
            for q in others {
                if (q[0] - p[0]).abs() >= best {
                    break;
                }
                best =
                    best.min(((q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2) + (q[2] - p[2]).powi(2)).sqrt());
            }
        };
        look(&mut points[index + 1..].iter());
        look(&mut points[..index].iter().rev());
        best
    };
    let stride = points.len().div_ceil(2000).max(1);
    let distances: Vec<f64> =
        (0..points.len()).step_by(stride).map(nearest).filter(|d| d.is_finite()).collect();
    quantile(distances, 0.5).unwrap_or(0.0)
}

fn quantile(mut values: Vec<f64>, fraction: f64) -> Option<f64> {
    values.retain(|v| v.is_finite());
    let last = values.len().checked_sub(1)?;
    values.sort_by(f64::total_cmp);
    Some(values[(fraction * last as f64).round() as usize])
}

/// Everything of the structure and, but for one particle in 500 at each side, of the fluid, with a margin: a
/// few drops that fly far would shrink all the rest.
fn view(moments: &[Moment], spacing: f64) -> View {
    let range = |axis: usize| {
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        let mut include = |frame: &Frame, cut: f64| {
            let (horizontal, vertical) = plane(frame);
            let component = [horizontal, vertical][axis];
            let values: Vec<f64> = frame.positions.as_chunks::<3>().0.iter().map(|p| p[component]).collect();
            if let (Some(a), Some(b)) = (quantile(values.clone(), cut), quantile(values, 1.0 - cut)) {
                low = low.min(a);
                high = high.max(b);
            }
        };
        for moment in moments {
            moment.fluid.iter().for_each(|frame| include(frame, 0.002));
            moment.structure.iter().for_each(|frame| include(frame, 0.0));
        }
        if low > high { (0.0, 1.0) } else { (low, high) }
    };
    let (x, y) = (range(0), range(1));
    // A single particle has neither extent nor spacing.
    let margin = (3.0 * spacing).max(0.02 * (x.1 - x.0).max(y.1 - y.0)).max(1e-9);
    View { x: (x.0 - margin, x.1 + margin), y: (y.0 - margin, y.1 + margin) }
}

/// The components that a picture shows: x and y, or in three dimensions x and z, seen along y.
fn plane(frame: &Frame) -> (usize, usize) {
    if frame.dimension == 3 { (0, 2) } else { (0, 1) }
}

fn layer(frame: &Frame, values: Option<(Vec<f64>, Bar)>, plain: [u8; 3], spacing: f64) -> Layer {
    let (horizontal, vertical) = plane(frame);
    let mut order: Vec<usize> = (0..frame.particles()).collect();
    if frame.dimension == 3 {
        // From the far side (large y) to the near one.
        order.sort_by(|&a, &b| frame.positions[3 * b + 1].total_cmp(&frame.positions[3 * a + 1]));
    }
    let points = order
        .iter()
        .map(|&i| (frame.positions[3 * i + horizontal], frame.positions[3 * i + vertical]))
        .collect();
    let paint = match values {
        Some((values, bar)) => Paint::Values(order.iter().map(|&i| values[i]).collect(), bar),
        None => Paint::Plain(plain),
    };
    Layer { points, paint, spacing }
}

fn pressure(frame: &Frame) -> Option<Vec<f64>> {
    frame.array("pressure").filter(|array| array.components == 1).map(|array| array.values.clone())
}

/// `von_mises_stress` or `von_mises` as written, or from `stress` of 4 (xx, yy, xy, zz), 6 (xx, yy, zz, xy,
/// yz, xz) or 9 (row by row) components.
fn von_mises(frame: &Frame) -> Option<Vec<f64>> {
    if let Some(array) = ["von_mises_stress", "von_mises"].iter().find_map(|name| frame.array(name)) {
        return (array.components == 1).then(|| array.values.clone());
    }
    let stress = frame.array("stress")?;
    // Places of xx, yy, zz, xy, yz, xz; without the last two in plane problems.
    let place: &[usize] = match stress.components {
        4 => &[0, 1, 3, 2],
        6 => &[0, 1, 2, 3, 4, 5],
        9 => &[0, 4, 8, 1, 5, 2],
        _ => return None,
    };
    let equivalent = |s: &[f64]| {
        let [xx, yy, zz] = [s[place[0]], s[place[1]], s[place[2]]];
        let shear: f64 = place[3..].iter().map(|&i| s[i] * s[i]).sum();
        (0.5 * ((xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2)) + 3.0 * shear).sqrt()
    };
    Some(stress.values.chunks_exact(stress.components).map(equivalent).collect())
}

/// The colour bar of a quantity over all pictures: to the 99.5 % quantile, so that single particles do not
/// take the colours of all others, rounded outwards; from zero unless a good part is negative.
fn bar(
    label: &str,
    unit: &'static str,
    map: super::colours::ColourMap,
    moments: impl Iterator<Item = Vec<f64>>,
) -> Option<Bar> {
    let values: Vec<f64> = moments.flatten().collect();
    let high = quantile(values.clone(), 0.995)?.max(0.0);
    let low = quantile(values, 0.005)?;
    let low = if low < -0.05 * high { low } else { 0.0 };
    // All zero, as a stress at the start: any bar from zero will do.
    let ticks = scale::linear(low, if high > low { high } else { low + 1.0 }, 5);
    Some(Bar { label: label.to_owned(), unit, map, low: ticks.low, high: ticks.high })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vtu::Array;

    #[test]
    fn spacing_is_that_of_the_lattice() {
        let positions: Vec<f64> =
            (0..600).flat_map(|i| [0.25 * f64::from(i % 20), 0.25 * f64::from(i / 20), 0.0]).collect();
        assert_eq!(spacing(&positions), 0.25);
        assert_eq!(spacing(&[1.0, 2.0, 3.0]), 0.0);
    }

    #[test]
    fn pictures_are_spread_over_the_whole_run() {
        let entries: Vec<SeriesEntry> =
            (0..101).map(|i| SeriesEntry { time: f64::from(i), file: PathBuf::new() }).collect();
        let times: Vec<f64> = evenly(&entries, 8).iter().map(|e| e.time).collect();
        assert_eq!(times, [0.0, 14.0, 29.0, 43.0, 57.0, 71.0, 86.0, 100.0]);
        assert_eq!(evenly(&entries[..3], 8).len(), 3);
        assert_eq!(nearest(&entries, 41.7).unwrap().time, 42.0);
    }

    #[test]
    fn von_mises_by_hand() {
        let frame = |components: usize, values: &[f64]| Frame {
            time: 0.0,
            dimension: 2,
            positions: vec![0.0; 3],
            arrays: vec![Array { name: "stress".to_owned(), components, values: values.to_vec() }],
        };
        // Uniaxial tension 3: von Mises 3. Pure shear 2: 2√3. Equal in all directions: 0.
        assert_eq!(von_mises(&frame(4, &[3.0, 0.0, 0.0, 0.0])).unwrap(), [3.0]);
        assert_eq!(von_mises(&frame(4, &[0.0, 0.0, 2.0, 0.0])).unwrap(), [12f64.sqrt()]);
        assert_eq!(von_mises(&frame(6, &[5.0, 5.0, 5.0, 0.0, 0.0, 0.0])).unwrap(), [0.0]);
        assert_eq!(von_mises(&frame(9, &[0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0])).unwrap(), [3.0]);
        assert_eq!(von_mises(&frame(3, &[0.0; 3])), None);
    }
}
