//! What a case would make is counted before it is made: particles, their memory, cells of the grid in which
//! they look for neighbours, windows and outputs.

use super::is_own;
use crate::case::findings::Findings;
use crate::case::fluid::{Fluid, Wall};
use crate::case::geometry::AxisBox;
use crate::case::keys::Case;
use crate::case::structure::Structure;
use toml::Table;

/// Memory (bytes) of a particle of fluid and of structure with its neighbours, and of one in a wall: about
/// what `meniscus check` says of the first, and less than the others take.
const FLUID: f64 = 1.3e3;
const STRUCTURE: f64 = 1.0e3;
const WALL: f64 = 300.0;
/// Rows of particles in a wall, within the support of those beside it.
const WALL_ROWS: f64 = 3.0;
/// Memory (bytes) of a cell of the grid.
const CELL: f64 = 4.0;
/// Width of a cell over the particle spacing, at least.
const CELL_WIDTH: f64 = 2.0;
/// Particles that can be numbered.
const NUMBERED: f64 = 2e9;
/// Outputs of a run at most, and windows.
const OUTPUTS: f64 = 1e6;
const WINDOWS: f64 = 1e11;

/// A part of the case with the particles that fill it.
struct Count {
    key: String,
    particles: f64,
    bytes: f64,
}

pub(super) fn check(file: &Case, coupling: Option<&Table>, findings: &mut Findings) {
    let general = &file.general;
    let mut counts = Vec::new();
    if let Some(fluid) = file.fluid.as_ref().filter(|fluid| is_own(&fluid.participant)) {
        of_fluid(fluid, &mut counts);
        // That of a case that names none is the output interval, which has its own check.
        let step = Some(fluid.max_time_step).filter(|step| *step != general.output_interval);
        check_steps("fluid.max_time_step", step, general.end_time, findings);
    }
    match &file.structure {
        Some(structure) if is_own(&structure.participant) => of_structure(structure, &mut counts),
        Some(structure) => of_filling(structure, coupling, &mut counts),
        None => {}
    }
    let window = coupling.and_then(|coupling| coupling.get("max_window")?.as_float());
    check_steps("coupling.max_window", window, general.end_time, findings);
    let outputs = general.end_time / general.output_interval;
    if outputs > OUTPUTS {
        let problem = format!("asks for {outputs:.1e} outputs in {} s", general.end_time);
        findings.add("case.output_interval", problem, format!("take an interval for at most {OUTPUTS:.0e}"));
    }
    refuse_too_many(&counts, findings);
}

fn check_steps(key: &str, step: Option<f64>, end_time: f64, findings: &mut Findings) {
    let Some(windows) = step.map(|step| end_time / step).filter(|windows| *windows > WINDOWS) else { return };
    let problem = format!("asks for {windows:.1e} windows in {end_time} s");
    findings.add(key, problem, format!("take a size for at most {WINDOWS:.0e}, or leave it out"));
}

fn refuse_too_many(counts: &[Count], findings: &mut Findings) {
    let (particles, bytes) =
        counts.iter().fold((0.0, 0.0), |(n, bytes), count| (n + count.particles, bytes + count.bytes));
    let memory = memory();
    let largest =
        counts.iter().filter(|count| !count.bytes.is_nan()).max_by(|a, b| a.bytes.total_cmp(&b.bytes));
    if let Some(largest) = largest.filter(|_| particles > NUMBERED || bytes > memory) {
        let problem = format!(
            "with all else the case asks for {particles:.1e} particles and about {:.1e} GB of memory, and this machine has {:.0} GB",
            bytes / 1e9,
            memory / 1e9
        );
        findings.add(largest.key.as_str(), problem, "take a larger particle_spacing, or make it smaller");
    }
}

fn of_fluid(fluid: &Fluid, counts: &mut Vec<Count>) {
    let spacing = fluid.particle_spacing;
    for (i, region) in fluid.regions.iter().enumerate() {
        let Some(bounds) = region.shape() else { continue };
        let word = if region.bounds.is_some() { "box" } else { "ball" };
        let particles = cells(&bounds, spacing);
        counts.push(Count { key: format!("fluid.region.{i}.{word}"), particles, bytes: FLUID * particles });
    }
    for (i, wall) in fluid.walls.iter().enumerate() {
        let (word, particles) = of_wall(wall, spacing);
        counts.push(Count { key: format!("fluid.wall.{i}.{word}"), particles, bytes: WALL * particles });
    }
    // A particle may fly to any place of the domain, and the grid holds them all.
    let bytes = CELL * cells(&fluid.domain, CELL_WIDTH * spacing);
    counts.push(Count { key: "fluid.domain".to_owned(), particles: 0.0, bytes });
}

/// Particles on the surface of a wall, in rows.
fn of_wall(wall: &Wall, spacing: f64) -> (&'static str, f64) {
    if let Some(bounds) = &wall.bounds {
        let sides = bounds.extent().into_iter().map(|side| side / spacing).collect::<Vec<_>>();
        let all: f64 = sides.iter().product();
        let faces: f64 = sides.iter().map(|side| 2.0 * all / side.max(1.0)).sum();
        return ("box", (WALL_ROWS * faces).min(all.max(1.0)));
    }
    let points = wall.polyline.as_deref().unwrap_or_default();
    let length: f64 = points
        .windows(2)
        .map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt())
        .sum();
    ("polyline", WALL_ROWS * length / spacing)
}

fn of_structure(structure: &Structure, counts: &mut Vec<Count>) {
    let spacing = structure.particle_spacing;
    for (i, body) in structure.bodies.iter().enumerate() {
        let particles = cells(&body.bounds, spacing);
        counts.push(Count {
            key: format!("structure.body.{i}.box"),
            particles,
            bytes: STRUCTURE * particles,
        });
        for (k, clamp) in structure.clamps.iter().enumerate().filter(|(_, clamp)| clamp.body == body.name) {
            let (Some(face), Some(rows)) = (clamp.face, clamp.rows) else { continue };
            let across = body.bounds.extent().get(face.axis()).map_or(1.0, |side| (side / spacing).max(1.0));
            let particles = f64::from(rows) * particles / across;
            counts.push(Count {
                key: format!("structure.clamp.{k}.rows"),
                particles,
                bytes: STRUCTURE * particles,
            });
        }
    }
}

/// Particles in the bodies of another solver's structure, to which its points are mapped.
fn of_filling(structure: &Structure, coupling: Option<&Table>, counts: &mut Vec<Count>) {
    let written = coupling.and_then(|coupling| coupling.get("mapping")?.get("spacing")?.as_float());
    let spacing = written.unwrap_or(structure.particle_spacing);
    for (i, body) in structure.bodies.iter().enumerate() {
        let key = match written {
            Some(_) => "coupling.mapping.spacing".to_owned(),
            None => format!("structure.body.{i}.box"),
        };
        let particles = cells(&body.bounds, spacing);
        counts.push(Count { key, particles, bytes: STRUCTURE * particles });
    }
}

/// Cells of that width in the box.
fn cells(bounds: &AxisBox, width: f64) -> f64 {
    bounds.extent().into_iter().map(|side| (side / width).max(1.0)).product()
}

/// Memory of this machine (bytes); without limit where it does not tell.
fn memory() -> f64 {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kilobytes.map_or(f64::INFINITY, |kilobytes| 1024.0 * kilobytes)
}
