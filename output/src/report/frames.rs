//! Which snapshots become pictures, and what they show.

use super::colours::{REDS, VIRIDIS};
use super::picture::{self, Bar, Layer, Paint, View};
use super::scale;
use crate::atomic;
use crate::error::{Result, read_error, write_error};
use crate::files;
use crate::pvd::{self, SeriesEntry};
use crate::summary::Extremes;
use crate::vtu::{self, Frame};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Pictures evenly over the run.
const COUNT: usize = 16;
/// Pictures at extremes of probes beside these, at most.
const EXTREMES: usize = 16;
/// Values of a snapshot that the colour scales are taken from, at most.
const SAMPLE: usize = 20_000;

/// Which pictures a report has.
#[derive(Debug, Clone, Default)]
pub struct Shown {
    /// Times (s) whose nearest snapshots are drawn; where there is none, pictures are spread over the run,
    /// and the extremes of probes have theirs.
    pub times: Vec<f64>,
    /// What they show; where nothing is said, all of the structure and the most of the fluid.
    pub view: Option<View>,
}

/// A picture as it was written to `frames/`.
pub(crate) struct FramePicture {
    pub caption: String,
    pub file: PathBuf,
    pub png: Vec<u8>,
}

/// Pictures over time, and others that show one thing more closely.
#[derive(Default)]
pub(crate) struct Pictures {
    pub moments: Vec<FramePicture>,
    pub others: Vec<FramePicture>,
}

/// Draws the pictures of the run in `dir` and writes them to `dir/frames/`, where they replace those of an
/// earlier report; none if the run left no snapshots. `extremes` are those of its probes. Beside them stand
/// one of the structure alone where it is small, and one of its displacement where there is no fluid.
///
/// Snapshots are read one after the other, twice: a run has more of them than memory.
pub(crate) fn draw_frames(
    dir: &Path,
    shown: &Shown,
    extremes: &BTreeMap<String, Extremes>,
) -> Result<Pictures> {
    let all = Snapshots::list(dir)?;
    let chosen = chosen(all.leading(), shown, extremes);
    let seen = |(index, words): (usize, Vec<String>)| -> Result<Seen> {
        Ok(Seen::of(&all.at(all.leading()[index].time)?, words))
    };
    let moments: Vec<Seen> = chosen.into_iter().map(seen).collect::<Result<_>>()?;
    if moments.is_empty() {
        return Ok(Pictures::default());
    }
    let scene = Scene {
        spacings: all.spacings()?,
        pressure: bar("pressure", "Pa", VIRIDIS, moments.iter().flat_map(|seen| &seen.pressure)),
        stress: bar("von Mises stress", "Pa", REDS, moments.iter().flat_map(|seen| &seen.stress)),
        decimals: decimals(&moments),
    };
    let largest_spacing = scene.spacings[1].max(scene.spacings[2]);
    let view = shown.view.unwrap_or_else(|| around(moments.iter().flat_map(|s| &s.extents), largest_spacing));

    let folder = dir.join("frames");
    prepare(&folder)?;
    let save = |name: String, caption: String, png: Vec<u8>| -> Result<FramePicture> {
        let file = folder.join(name);
        atomic::write_file(&file, &png)?;
        Ok(FramePicture { caption, file, png })
    };
    let mut pictures = Pictures::default();
    for seen in &moments {
        let (moment, decimals) = (all.at(seen.time)?, scene.decimals);
        let name = format!("t{:.decimals$}.png", seen.time);
        pictures.moments.push(save(name, seen.caption(), scene.draw(&moment, &view))?);
    }
    if let Some((seen, axis, largest)) = furthest(&moments) {
        let label = format!("displacement u{}", ["x", "y", "z"][axis]);
        let png = scene.draw_displacement(&all.at(seen.time)?, &view, axis, &label);
        let (time, largest) = (scale::short(seen.time), scale::quantity(largest, "m"));
        let caption = format!("The {label} at {time} s, {largest} at most, as the paper's Fig. 7");
        pictures.others.push(save(DISPLACEMENT.to_owned(), caption, png)?);
    }
    if let Some((seen, near)) = close_up(&moments, &view, scene.spacings[2]) {
        let caption = format!("The structure at {} s, where its stress is largest", scale::short(seen.time));
        let png = scene.draw(&all.at(seen.time)?, &near);
        pictures.others.push(save(CLOSE_UP.to_owned(), caption, png)?);
    }
    Ok(pictures)
}

/// File of the structure's picture, as the paper's Fig. 18.
const CLOSE_UP: &str = "structure.png";

/// File of the picture of the displacement, as the paper's Fig. 7, in runs of the structure alone.
const DISPLACEMENT: &str = "displacement.png";

/// The snapshots of a run.
struct Snapshots {
    walls: Vec<SeriesEntry>,
    fluid: Vec<SeriesEntry>,
    structure: Vec<SeriesEntry>,
}

/// Fluid, structure and walls at one time.
struct Moment {
    time: f64,
    walls: Option<Frame>,
    fluid: Option<Frame>,
    structure: Option<Frame>,
}

impl Snapshots {
    fn list(dir: &Path) -> Result<Self> {
        let series = |name: &str| {
            let path = dir.join(format!("{name}.pvd"));
            if path.exists() { pvd::read(&path) } else { Ok(Vec::new()) }
        };
        Ok(Self { walls: series("walls")?, fluid: series("fluid")?, structure: series("structure")? })
    }

    /// The series whose times count.
    fn leading(&self) -> &[SeriesEntry] {
        if self.fluid.is_empty() { &self.structure } else { &self.fluid }
    }

    fn at(&self, time: f64) -> Result<Moment> {
        let frame = |series: &[SeriesEntry]| {
            nearest(series, time).map(|index| vtu::read(&series[index].file)).transpose()
        };
        let [walls, fluid, structure] = [&self.walls, &self.fluid, &self.structure].map(|s| frame(s));
        Ok(Moment { time, walls: walls?, fluid: fluid?, structure: structure? })
    }

    /// Spacings of walls, fluid and structure (m) in the first snapshots, where particles stand on their
    /// lattice.
    fn spacings(&self) -> Result<[f64; 3]> {
        let first = |series: &[SeriesEntry]| -> Result<f64> {
            series.first().map_or(Ok(0.0), |entry| Ok(spacing(&vtu::read(&entry.file)?.positions)))
        };
        Ok([first(&self.walls)?, first(&self.fluid)?, first(&self.structure)?])
    }
}

/// What is kept of a moment while the scales of all pictures are found.
struct Seen {
    time: f64,
    /// Extremes that it is near.
    words: Vec<String>,
    pressure: Vec<f64>,
    stress: Vec<f64>,
    /// Extents of the fluid, without what flies far, and of the structure.
    extents: Vec<View>,
    structure: Option<View>,
    /// The component of the structure's displacement that is largest where there is no fluid, and its size
    /// (m).
    displacement: Option<(usize, f64)>,
}

impl Seen {
    fn of(moment: &Moment, words: Vec<String>) -> Self {
        let (fluid, structure) = (moment.fluid.as_ref(), moment.structure.as_ref());
        let around = structure.and_then(|frame| extent(frame, 0.0));
        let largest = |axis: usize| -> Option<(usize, f64)> {
            let values = displacement(structure.filter(|_| fluid.is_none())?, axis)?;
            let largest = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            (largest > 0.0 && largest.is_finite()).then_some((axis, largest))
        };
        Self {
            time: moment.time,
            words,
            pressure: sample(fluid.and_then(pressure)),
            stress: sample(structure.and_then(von_mises)),
            extents: fluid.and_then(|frame| extent(frame, STRAY)).into_iter().chain(around).collect(),
            structure: around,
            displacement: (0..3).filter_map(largest).max_by(|a, b| a.1.total_cmp(&b.1)),
        }
    }

    fn caption(&self) -> String {
        let time = scale::short(self.time);
        if self.words.is_empty() {
            format!("{time} s")
        } else {
            format!("{time} s, nearest to the {}", self.words.join(", "))
        }
    }
}

fn sample(values: Option<Vec<f64>>) -> Vec<f64> {
    let values = values.unwrap_or_default();
    let stride = values.len().div_ceil(SAMPLE).max(1);
    values.into_iter().step_by(stride).collect()
}

/// What all pictures have in common.
struct Scene {
    /// Of walls, fluid and structure (m).
    spacings: [f64; 3],
    pressure: Option<Bar>,
    stress: Option<Bar>,
    /// Of the time.
    decimals: usize,
}

impl Scene {
    fn draw(&self, moment: &Moment, view: &View) -> Vec<u8> {
        let mut layers = Vec::new();
        if let Some(frame) = &moment.walls {
            layers.push(layer(frame, None, WALL, self.spacings[0]));
        }
        if let Some(frame) = &moment.fluid {
            let values = pressure(frame).zip(self.pressure.clone());
            layers.push(layer(frame, values, PLAIN_FLUID, self.spacings[1]));
        }
        if let Some(frame) = &moment.structure {
            let values = von_mises(frame).zip(self.stress.clone());
            layers.push(layer(frame, values, PLAIN_STRUCTURE, self.spacings[2]));
        }
        picture::draw(&self.heading(moment.time), view, &layers).png()
    }

    fn draw_displacement(&self, moment: &Moment, view: &View, axis: usize, label: &str) -> Vec<u8> {
        let layers: Vec<Layer> = (moment.structure.iter())
            .map(|frame| {
                let values = displacement(frame, axis);
                let colours = bar(label, "m", VIRIDIS, values.iter().flatten());
                layer(frame, values.zip(colours), PLAIN_STRUCTURE, self.spacings[2])
            })
            .collect();
        picture::draw(&self.heading(moment.time), view, &layers).png()
    }

    fn heading(&self, time: f64) -> String {
        format!("t = {time:.*} s", self.decimals)
    }
}

/// Decimals that tell the moments apart, four at least.
fn decimals(moments: &[Seen]) -> usize {
    let gap = moments.windows(2).map(|pair| pair[1].time - pair[0].time).fold(1.0, f64::min);
    if gap > 0.0 { (-gap.log10()).ceil().clamp(4.0, 15.0) as usize } else { 4 }
}

/// One component of the displacement at each particle (m).
fn displacement(frame: &Frame, axis: usize) -> Option<Vec<f64>> {
    let array = frame.array("displacement").filter(|a| axis < a.components)?;
    Some(array.values.chunks_exact(array.components).map(|u| u[axis]).collect())
}

/// Of a structure alone: the moment, component and size (m) of its largest displacement.
fn furthest(moments: &[Seen]) -> Option<(&Seen, usize, f64)> {
    let found = moments.iter().filter_map(|seen| seen.displacement.map(|(axis, size)| (seen, axis, size)));
    found.max_by(|a, b| a.2.total_cmp(&b.2))
}

/// The moment of largest stress among those drawn, and the structure's surroundings then; `None` without
/// stress, or if the other pictures show the structure as large already.
fn close_up<'a>(moments: &'a [Seen], whole: &View, spacing: f64) -> Option<(&'a Seen, View)> {
    let stress = |seen: &Seen| quantile(seen.stress.clone(), 0.995);
    let (seen, _) = moments
        .iter()
        .filter_map(|seen| Some((seen, stress(seen)?)))
        .max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let near = around(seen.structure.iter(), spacing);
    let size = |view: &View| (view.x.1 - view.x.0).max(view.y.1 - view.y.0);
    (size(&near) < 0.7 * size(whole)).then_some((seen, near))
}

const WALL: [u8; 3] = [150, 154, 160];
const PLAIN_FLUID: [u8; 3] = [51, 99, 141];
const PLAIN_STRUCTURE: [u8; 3] = [196, 32, 38];

/// Which entries are drawn, and the extremes that each is near.
fn chosen(
    entries: &[SeriesEntry],
    shown: &Shown,
    extremes: &BTreeMap<String, Extremes>,
) -> BTreeMap<usize, Vec<String>> {
    if !shown.times.is_empty() {
        let wanted = shown.times.iter().filter_map(|time| nearest(entries, *time));
        return wanted.map(|index| (index, Vec::new())).collect();
    }
    let mut chosen: BTreeMap<usize, Vec<String>> =
        evenly(entries.len(), COUNT).map(|index| (index, Vec::new())).collect();
    let most = chosen.len() + EXTREMES;
    for (probe, found) in extremes.iter().filter(|(_, found)| found.max > found.min) {
        for (word, time) in [("largest", found.max_time), ("least", found.min_time)] {
            let Some(index) = nearest(entries, time) else { continue };
            if chosen.contains_key(&index) || chosen.len() < most {
                chosen.entry(index).or_default().push(format!("{word} {probe}"));
            }
        }
    }
    chosen
}

/// At most `count` of `all` places, the first and the last among them.
fn evenly(all: usize, count: usize) -> impl Iterator<Item = usize> {
    let drawn = all.min(count);
    (0..drawn).map(move |i| (i * (all - 1) + (drawn - 1) / 2) / (drawn - 1).max(1))
}

fn nearest(entries: &[SeriesEntry], time: f64) -> Option<usize> {
    let off = |index: &usize| (entries[*index].time - time).abs();
    (0..entries.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
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

/// Part of the fluid's particles that may lie outside of a picture at each of its sides: drops that fly far
/// would shrink all the rest.
const STRAY: f64 = 0.005;

/// The box of all particles but that part of them at each side; nothing of none.
fn extent(frame: &Frame, cut: f64) -> Option<View> {
    let (horizontal, vertical) = plane(frame);
    let range = |component: usize| {
        let values: Vec<f64> = frame.positions.as_chunks::<3>().0.iter().map(|p| p[component]).collect();
        Some((quantile(values.clone(), cut)?, quantile(values, 1.0 - cut)?))
    };
    Some(View { x: range(horizontal)?, y: range(vertical)? })
}

/// All these boxes with a margin.
fn around<'a>(extents: impl Iterator<Item = &'a View>, spacing: f64) -> View {
    let joined = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
    let all = extents.copied().reduce(|a, b| View { x: joined(a.x, b.x), y: joined(a.y, b.y) });
    let View { x, y } = all.unwrap_or(View { x: (0.0, 1.0), y: (0.0, 1.0) });
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
fn bar<'a>(
    label: &str,
    unit: &'static str,
    map: super::colours::ColourMap,
    values: impl Iterator<Item = &'a f64>,
) -> Option<Bar> {
    let values: Vec<f64> = values.copied().collect();
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
    fn pictures_are_spread_over_the_run_and_stand_at_extremes_or_where_they_are_asked_for() {
        let entries: Vec<SeriesEntry> =
            (0..101).map(|i| SeriesEntry { time: f64::from(i), file: PathBuf::new() }).collect();
        assert_eq!(evenly(101, 8).collect::<Vec<_>>(), [0, 14, 29, 43, 57, 71, 86, 100]);
        assert_eq!(evenly(3, 8).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!((evenly(1, 8).collect::<Vec<_>>(), evenly(0, 8).count()), (vec![0], 0));
        assert_eq!(nearest(&entries, 41.7), Some(42));

        let found = |max_time, min_time| Extremes { max: 2.0, max_time, min: 1.0, min_time };
        let mut extremes = BTreeMap::from([("tip.ux".to_owned(), found(41.7, 0.0))]);
        let constant = Extremes { max: 1.0, min: 1.0, max_time: 3.0, min_time: 3.0 };
        extremes.insert("wall.fx".to_owned(), constant);
        let pictures = chosen(&entries, &Shown::default(), &extremes);
        assert_eq!(pictures.len(), COUNT + 1);
        assert_eq!(
            (&pictures[&42], &pictures[&0]),
            (&vec!["largest tip.ux".to_owned()], &vec!["least tip.ux".to_owned()])
        );
        extremes.extend((0..50).map(|i| (format!("p{i}"), found(f64::from(2 * i), f64::from(2 * i + 1)))));
        assert_eq!(chosen(&entries, &Shown::default(), &extremes).len(), COUNT + EXTREMES);

        let shown = Shown { times: vec![90.2, 3.0, 2.9], view: None };
        assert_eq!(chosen(&entries, &shown, &extremes).into_keys().collect::<Vec<_>>(), [3, 90]);
    }

    #[test]
    fn a_few_drops_shrink_no_picture() {
        let mut positions: Vec<f64> =
            (0..1000).flat_map(|i| [f64::from(i % 50), f64::from(i / 50), 0.0]).collect();
        (0..4).for_each(|drop| positions[3 * drop + 1] = 500.0);
        let frame = Frame { time: 0.0, dimension: 2, positions, arrays: vec![] };
        assert_eq!(extent(&frame, STRAY), Some(View { x: (0.0, 49.0), y: (0.0, 19.0) }));
        assert_eq!(extent(&frame, 0.0).unwrap().y, (0.0, 500.0));
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
