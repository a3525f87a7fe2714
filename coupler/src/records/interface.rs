//! What the coupler itself can tell of a structure: probes that its participant does not report, and
//! snapshots that it does not write, from positions, velocities and loads of the interface points.

use crate::mapping::{Mapping, Method, Settings};
use crate::schemes::InterfaceState;
use interfaces::case::motion::Motion;
use interfaces::case::probe::ProbeTarget;
use interfaces::case::{Case, array};
use output::columns::Column;
use output::{ParticleFrame, PointArray, Series};
use std::path::Path;
use words::probe::ProbeQuantity;

/// Probes that are read from the interface points.
#[derive(Debug)]
pub(super) struct InterfaceProbes {
    dimension: usize,
    /// Positions of the points at the start (m), flat.
    reference: Vec<f64>,
    /// From the points to the probes' own, where they have any.
    mapping: Option<Mapping>,
    reads: Vec<Read>,
    columns: Vec<Column>,
}

#[derive(Debug)]
struct Read {
    quantity: ProbeQuantity,
    of: Of,
    frame: Option<Motion>,
}

#[derive(Debug)]
enum Of {
    /// A point: its number among the probes' points, and where it is at the start (m).
    Point(usize, Vec<f64>),
    /// Points of a body, and the point (m) that a moment is about.
    Body(Vec<usize>, Vec<f64>),
}

impl InterfaceProbes {
    /// Those of the case's probes on the structure that none of `columns` is of, where the points tell of
    /// them.
    pub(super) fn new(case: &Case, columns: &[Column], start: &InterfaceState<'_>) -> Self {
        let dimension = start.components;
        let reference = start.position.to_vec();
        let (mut reads, mut made, mut targets) = (Vec::new(), Vec::new(), Vec::new());
        for probe in case.probes.iter().filter(|probe| probe.is_of_interface() && !reference.is_empty()) {
            let own: Vec<_> = probe.scalars(dimension).collect();
            if own.iter().any(|scalar| columns.iter().any(|column| column.name == scalar.name)) {
                continue;
            }
            let of = match probe.target() {
                ProbeTarget::StructurePoint { at, .. } => {
                    targets.extend_from_slice(at);
                    Of::Point(targets.len() / dimension - 1, at.to_vec())
                }
                ProbeTarget::Body(body) => Of::Body(members(case, body, &reference, dimension), Vec::new()),
                ProbeTarget::BodyAbout { body, at } => {
                    Of::Body(members(case, body, &reference, dimension), at.to_vec())
                }
                _ => continue,
            };
            reads.push(Read { quantity: probe.quantity, of, frame: case.frame_of(probe).cloned() });
            made.extend(own.into_iter().map(|scalar| {
                let meaning = format!("{}, from the interface points", scalar.meaning);
                Column::new(scalar.name, &scalar.unit, meaning)
            }));
        }
        let mapping = (!targets.is_empty()).then(|| mapping(dimension, &reference, &targets));
        Self { dimension, reference, mapping, reads, columns: made }
    }

    /// Their columns.
    pub(super) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Adds their values at a time (s).
    pub(super) fn read(&self, time: f64, state: &InterfaceState<'_>, values: &mut Vec<f64>) {
        match self.dimension {
            2 => self.read_in::<2>(time, state, values),
            _ => self.read_in::<3>(time, state, values),
        }
    }

    fn read_in<const D: usize>(&self, time: f64, state: &InterfaceState<'_>, values: &mut Vec<f64>) {
        let mapped = |field: &[f64]| {
            let mut at_points = vec![0.0; self.mapping.as_ref().map_or(0, Mapping::targets) * D];
            if let Some(mapping) = &self.mapping {
                mapping.consistent(D, field, &mut at_points);
            }
            at_points
        };
        let moved: Vec<f64> =
            state.position.iter().zip(&self.reference).map(|(x, start)| x - start).collect();
        let (moved, velocities) = (mapped(&moved), mapped(state.velocity));
        for Read { quantity, of, frame } in &self.reads {
            let frame = frame.as_ref().and_then(Motion::rigid::<D>);
            let pose = frame.as_ref().map(|frame| frame.pose(time));
            let turned_back = |vector: [f64; D]| pose.map_or(vector, |pose| pose.turned_back(&vector));
            match of {
                Of::Point(point, start) => {
                    let entry = |field: &[f64], i: usize| field[point * D + i];
                    let now: [f64; D] = std::array::from_fn(|i| start[i] + entry(&moved, i));
                    let seen = pose.map_or(now, |pose| pose.at_rest(&now));
                    let of_frame = frame.as_ref().map_or([0.0; D], |frame| frame.twist(time).at(&now));
                    values.extend(match quantity {
                        ProbeQuantity::Position => seen,
                        ProbeQuantity::Displacement => std::array::from_fn(|i| seen[i] - start[i]),
                        _ => turned_back(std::array::from_fn(|i| entry(&velocities, i) - of_frame[i])),
                    });
                }
                Of::Body(members, about) => {
                    let about = if about.is_empty() { [0.0; D] } else { array(about) };
                    let about = pose.map_or(about, |pose| pose.moved(&about));
                    let (mut force, mut moment) = ([0.0; D], [0.0; 3]);
                    for &point in members {
                        let load = |i: usize| state.load.map_or(f64::NAN, |load| load[point * D + i]);
                        let own = turned_back(std::array::from_fn(|i| -state.volume[point] * load(i)));
                        let arm =
                            turned_back(std::array::from_fn(|i| state.position[point * D + i] - about[i]));
                        let of = |i: usize, j: usize| arm[i] * own[j] - arm[j] * own[i];
                        let turning =
                            if D == 2 { [0.0, 0.0, of(0, 1)] } else { [of(1, 2), of(2, 0), of(0, 1)] };
                        force = std::array::from_fn(|i| force[i] + own[i]);
                        moment = std::array::from_fn(|i| moment[i] + turning[i]);
                    }
                    match quantity {
                        ProbeQuantity::Force => values.extend(force),
                        _ => values.extend(if D == 2 { &moment[2..] } else { &moment[..] }),
                    }
                }
            }
        }
    }
}

/// Linear fields are carried exactly where the points around a target tell of a gradient, the nearest point's
/// value where they do not.
fn mapping(dimension: usize, points: &[f64], targets: &[f64]) -> Mapping {
    let settings = |method| Settings { dimension, reach: f64::INFINITY, method };
    Mapping::build(settings(Method::NearestNeighbourGradient), points, targets)
        .or_else(|_| Mapping::build(settings(Method::NearestNeighbour), points, targets))
        .expect("there are points, and one of them is the nearest")
}

/// Points of a body: those in its box, to half a spacing; all of a structure of one body, or without any.
fn members(case: &Case, body: &str, positions: &[f64], dimension: usize) -> Vec<usize> {
    let structure = case.structure.as_ref();
    let bodies = structure.map_or(&[][..], |structure| &structure.bodies);
    let of_name = bodies.iter().find(|of| of.name == body).filter(|_| bodies.len() > 1);
    let near = structure.map_or(0.0, |structure| 0.5 * structure.particle_spacing);
    let is_member = |at: &[f64]| of_name.is_none_or(|body| !body.bounds.is_clear_of(at, near));
    positions.chunks_exact(dimension).enumerate().filter(|(_, at)| is_member(at)).map(|(i, _)| i).collect()
}

/// Snapshots of a structure whose participant writes none, as far as its points tell.
#[derive(Debug)]
pub(super) struct InterfaceSnapshots {
    series: Series,
    reference: Vec<f64>,
    /// Times (s) of an earlier run's snapshots, behind which it is to go on.
    before: Vec<f64>,
}

impl InterfaceSnapshots {
    /// Starts the series `structure` in the run's folder, with the snapshot of the start; nothing where the
    /// participant has begun one itself.
    pub(super) fn create(dir: &Path, time: f64, start: &InterfaceState<'_>) -> output::Result<Option<Self>> {
        if start.position.is_empty() || dir.join("structure.pvd").exists() {
            return Ok(None);
        }
        let series = Series::create(dir, "structure")?;
        let mut snapshots = Self { series, reference: start.position.to_vec(), before: Vec::new() };
        snapshots.write(time, start)?;
        Ok(Some(snapshots))
    }

    /// Times (s) of the snapshots so far.
    pub(super) fn times(&self) -> &[f64] {
        self.series.times()
    }

    /// Is to [`go_on`](Self::go_on) behind snapshots of these times (s).
    pub(super) fn stand_at(&mut self, times: Vec<f64>) {
        self.before = times;
    }

    /// Goes on behind an earlier run's snapshots.
    pub(super) fn go_on(&mut self) -> output::Result<()> {
        self.series.go_on(std::mem::take(&mut self.before))
    }

    /// Writes the next snapshot.
    pub(super) fn write(&mut self, time: f64, state: &InterfaceState<'_>) -> output::Result<()> {
        let dimension = state.components;
        let displacements: Vec<f64> =
            state.position.iter().zip(&self.reference).map(|(x, start)| x - start).collect();
        let mut arrays = vec![
            PointArray::vector("displacement", dimension, &displacements),
            PointArray::vector("velocity", dimension, state.velocity),
            PointArray::scalar("reference_volume", state.volume),
        ];
        arrays.extend(state.load.map(|load| PointArray::vector("pressure_gradient", dimension, load)));
        let frame = ParticleFrame { time, dimension, positions: state.position, arrays: &arrays };
        self.series.write(&frame)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASE: &str = r#"
[case]
title = "Two blocks"
dimension = 2
end_time = 1.0
output_interval = 0.1
particle_spacing = 0.1

[motion.quarter]
pivot = [0.0, 0.0]
table = [[0.0, 0.0], [1.0, 1.5707963267948966]]

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
characteristic_speed = 1.0
domain = { low = [0.0, 0.0], high = [1.0, 1.0] }
participant = { command = ["other"] }

[structure]
participant = { command = ["other"] }

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0

[[structure.body]]
name = "left"
box = { low = [0.0, 0.0], high = [0.4, 0.4] }

[[structure.body]]
name = "right"
box = { low = [0.6, 0.0], high = [1.0, 0.4] }

[[probe]]
name = "corner"
on = "structure"
body = "left"
quantity = "displacement"
at = [0.4, 0.4]

[[probe]]
name = "riding"
on = "structure"
body = "left"
quantity = "position"
at = [0.4, 0.4]
relative_to = "quarter"

[[probe]]
name = "fast"
on = "structure"
body = "right"
quantity = "velocity"
at = [0.8, 0.0]

[[probe]]
name = "push"
on = "structure"
body = "right"
quantity = "force"

[[probe]]
name = "turn"
on = "structure"
body = "right"
quantity = "moment"
at = [0.8, 0.2]

[[probe]]
name = "told"
on = "structure"
body = "right"
quantity = "force"

[[probe]]
name = "inside"
on = "structure"
body = "right"
quantity = "stress"
at = [0.8, 0.2]
"#;

    /// 4 × 4 points of each block, and the fields on them.
    fn points() -> Vec<f64> {
        let of = |low: f64| {
            (0..16).flat_map(move |i| [low + 0.1 * (f64::from(i % 4) + 0.5), 0.1 * (f64::from(i / 4) + 0.5)])
        };
        of(0.0).chain(of(0.6)).collect()
    }

    /// A quarter turn of all about the origin, with the velocity field (−y, x)·2 of the place before; on the
    /// right block 3 Pa/m down and to the left, but for 8 Pa/m upwards at its first point. By hand; linear
    /// fields are carried to round-off, beyond the outermost points too.
    #[test]
    fn probes_of_a_foreign_structure_by_hand() {
        let case = Case::parse(CASE, Path::new("case.toml"), &[], &[]).expect("a sound case");
        let (start, zeros, volume) = (points(), vec![0.0; 64], vec![0.01; 32]);
        let state =
            InterfaceState { components: 2, position: &start, velocity: &zeros, volume: &volume, load: None };
        let reported = [Column::new("t", "s", ""), Column::new("told.fx", "N", "")];
        let probes = InterfaceProbes::new(&case, &reported, &state);
        let names: Vec<_> =
            probes.columns().iter().map(|c| (c.name.as_str(), c.content.unit.as_str())).collect();
        let expected = [
            ("corner.ux", "m"),
            ("corner.uy", "m"),
            ("riding.x", "m"),
            ("riding.y", "m"),
            ("fast.vx", "m/s"),
            ("fast.vy", "m/s"),
            ("push.fx", "N"),
            ("push.fy", "N"),
            ("turn.mz", "N*m"),
        ];
        assert_eq!(names, expected);
        let mut values = Vec::new();
        probes.read(0.0, &state, &mut values);
        assert!(values[..2].iter().all(|u| u.abs() < 1e-12) && values[6..].iter().all(|f| f.is_nan()));

        let turned: Vec<f64> = start.chunks_exact(2).flat_map(|x| [-x[1], x[0]]).collect();
        let velocity: Vec<f64> = start.chunks_exact(2).flat_map(|x| [-2.0 * x[1], 2.0 * x[0]]).collect();
        let mut load = vec![0.0; 64];
        load[32..].fill(3.0);
        load[33] = -8.0;
        let state = InterfaceState { position: &turned, velocity: &velocity, load: Some(&load), ..state };
        values.clear();
        probes.read(1.0, &state, &mut values);
        // The corner (0.4, 0.4) has come to (−0.4, 0.4). 16 points of 0.01 m³ take −3·0.16 N, the first one
        // 0.08 N upwards in place of 0.03 N downwards. The middle has come to (−0.2, 0.8), and the first
        // point (0.65, 0.05) to (−0.05, 0.65): about (0.8, 0.2) the uniform part has an arm of (−1, 0.6),
        // and the other 0.11 N one of −0.85 m.
        let moment = -0.48 * (-1.0 - 0.6) - 0.85 * 0.11;
        let expected = [-0.8, 0.0, 0.4, 0.4, 0.0, 1.6, -0.48, -0.37, moment];
        for ((name, _), (found, expected)) in names.iter().zip(values.iter().zip(expected)) {
            assert!((found - expected).abs() < 1e-12, "{name}: {found} and not {expected}");
        }
    }
}
