//! No two things in one place. Touching is no overlap.

use crate::case::findings::Findings;
use crate::case::fluid::{Fluid, Wall};
use crate::case::geometry::AxisBox;
use crate::case::keys::Case;
use crate::case::region::Region;
use std::borrow::Cow;
use words::geometry::Side;

/// Depth of an overlap that counts, as a fraction of the particle spacing: over round-off in coordinates that
/// are meant to be the same, and far under what a particle would notice.
const TOLERANCE: f64 = 0.01;

/// A box with its key and name.
struct Part<'a> {
    key: String,
    what: String,
    bounds: Cow<'a, AxisBox>,
}

fn part<'a>(list: &str, index: usize, what: &str, name: &str, bounds: &'a AxisBox) -> Part<'a> {
    let what = format!("the {what} \"{name}\"");
    Part { key: format!("{list}.{index}.box"), what, bounds: Cow::Borrowed(bounds) }
}

/// The box that holds the region: a ball counts as that, too.
fn region_part(index: usize, region: &Region) -> Option<Part<'_>> {
    let part = |bounds| part("fluid.region", index, "region", &region.name, bounds);
    match (&region.bounds, &region.ball) {
        (Some(bounds), _) => Some(part(bounds)),
        (None, Some(ball)) => Some(Part {
            key: format!("fluid.region.{index}.ball"),
            what: format!("the region \"{}\"", region.name),
            bounds: Cow::Owned(ball.bounds()),
        }),
        (None, None) => None,
    }
}

pub(super) fn check(file: &Case, findings: &mut Findings) {
    let of_fluid = file.fluid.iter().map(|fluid| fluid.particle_spacing);
    let of_structure = file.structure.iter().map(|structure| structure.particle_spacing);
    let spacing =
        of_fluid.chain(of_structure).fold(f64::INFINITY, |a, b| if b < a || b.is_nan() { b } else { a });
    let tolerance = TOLERANCE * spacing;

    let (regions, walls) = match &file.fluid {
        Some(fluid) => fluid_parts(fluid),
        None => (Vec::new(), Vec::new()),
    };
    let bodies: Vec<_> = file
        .structure
        .iter()
        .flat_map(|structure| structure.bodies.iter().enumerate())
        .map(|(i, body)| part("structure.body", i, "body", &body.name, &body.bounds))
        .collect();

    among(&regions, tolerance, findings);
    among(&bodies, tolerance, findings);
    between(&regions, &walls, tolerance, findings);
    between(&bodies, &regions, tolerance, findings);
    between(&bodies, &walls, tolerance, findings);
    clamps_in_fluid(file, &regions, tolerance, findings);
    let moving: Vec<&str> = file
        .fluid
        .iter()
        .flat_map(|fluid| &fluid.walls)
        .filter(|wall| wall.motion.is_some())
        .map(|wall| wall.name.as_str())
        .collect();
    walls_that_move(&walls, &moving, tolerance, findings);
    clamps_in_moving_walls(file, &walls, &moving, tolerance, findings);
    for region in regions.iter().chain(&bodies) {
        beside_polylines(region, file.fluid.as_ref().map_or(&[], |fluid| &fluid.walls), tolerance, findings);
    }
}

fn fluid_parts(fluid: &Fluid) -> (Vec<Part<'_>>, Vec<Part<'_>>) {
    let regions = fluid.regions.iter().enumerate();
    let walls = fluid.walls.iter().enumerate().filter_map(|(i, wall)| Some((i, wall, wall.bounds.as_ref()?)));
    (
        regions.filter_map(|(i, region)| region_part(i, region)).collect(),
        walls.map(|(i, wall, bounds)| part("fluid.wall", i, "wall", &wall.name, bounds)).collect(),
    )
}

fn report(part: &Part<'_>, other: &Part<'_>, findings: &mut Findings) {
    findings.add(
        part.key.as_str(),
        format!("{} overlaps {}", part.what, other.what),
        "move or shrink one of them; they may touch",
    );
}

fn among(parts: &[Part<'_>], tolerance: f64, findings: &mut Findings) {
    for (i, part) in parts.iter().enumerate() {
        for other in &parts[..i] {
            if part.bounds.overlaps(&other.bounds, tolerance) {
                report(part, other, findings);
            }
        }
    }
}

/// Walls that stay may overlap, as at the corners of a tank. One that moves would drag its particles through
/// the other's.
fn walls_that_move(walls: &[Part<'_>], moving: &[&str], tolerance: f64, findings: &mut Findings) {
    let moves = |part: &Part<'_>| moving.iter().any(|name| part.what == format!("the wall \"{name}\""));
    for (i, part) in walls.iter().enumerate() {
        for other in &walls[..i] {
            if (moves(part) || moves(other)) && part.bounds.overlaps(&other.bounds, tolerance) {
                let mover = if moves(part) { part } else { other };
                findings.add(
                    part.key.as_str(),
                    format!("{} overlaps {}, and {} moves", part.what, other.what, mover.what),
                    "move or shrink one of them; they may touch",
                );
            }
        }
    }
}

fn between(parts: &[Part<'_>], others: &[Part<'_>], tolerance: f64, findings: &mut Findings) {
    for part in parts {
        for other in others {
            if part.bounds.overlaps(&other.bounds, tolerance) {
                report(part, other, findings);
            }
        }
    }
}

/// The fixed rows beyond a clamped face may lie in a wall that stays, but not in fluid.
fn clamps_in_fluid(file: &Case, regions: &[Part<'_>], tolerance: f64, findings: &mut Findings) {
    for (i, rows) in fixed_rows(file) {
        for region in regions.iter().filter(|region| rows.overlaps(&region.bounds, tolerance)) {
            findings.add(
                format!("structure.clamp.{i}"),
                format!("its fixed rows lie in {}", region.what),
                "clamp another face, or move the region",
            );
        }
    }
}

/// What is clamped stays where it is; a wall around it that moves away, or through it, does not.
fn clamps_in_moving_walls(
    file: &Case,
    walls: &[Part<'_>],
    moving: &[&str],
    tolerance: f64,
    findings: &mut Findings,
) {
    for (i, rows) in fixed_rows(file) {
        for wall in walls.iter().filter(|wall| rows.overlaps(&wall.bounds, tolerance)) {
            if moving.iter().any(|name| wall.what == format!("the wall \"{name}\"")) {
                findings.add(
                    format!("structure.clamp.{i}"),
                    format!("its fixed rows lie in {}, which moves, and a clamp stays", wall.what),
                    "clamp another face, or leave the wall's motion out",
                );
            }
        }
    }
}

/// The place of the fixed rows of each clamp that has any, with its index.
fn fixed_rows(file: &Case) -> Vec<(usize, AxisBox)> {
    let Some(structure) = &file.structure else { return Vec::new() };
    let mut found = Vec::new();
    for (i, clamp) in structure.clamps.iter().enumerate() {
        let body = structure.bodies.iter().find(|body| body.name == clamp.body);
        let (Some(face), Some(body)) = (clamp.face, body) else { continue };
        if face.axis() >= file.general.dimension {
            continue;
        }
        let cells = body.bounds.lattice_counts(structure.particle_spacing)[face.axis()] as f64;
        let depth = f64::from(clamp.rows.unwrap_or(0)) * body.bounds.extent()[face.axis()] / cells;
        found.push((i, body.bounds.beyond(face, depth)));
    }
    found
}

/// A polyline must not cut a region or a body, and it must lie on its open side.
fn beside_polylines(region: &Part<'_>, walls: &[Wall], tolerance: f64, findings: &mut Findings) {
    let centre: Vec<_> =
        region.bounds.low.iter().zip(&region.bounds.high).map(|(low, high)| 0.5 * (low + high)).collect();
    // Distance to the nearest segment that faces the centre, and whether the centre is on its solid side.
    let mut nearest: Option<(f64, bool, usize)> = None;
    let mut cut = false;
    for (i, wall) in walls.iter().enumerate() {
        let (Some(points), Some(side)) = (&wall.polyline, wall.solid_side) else { continue };
        for segment in points.windows(2).filter(|segment| segment[0].len() == 2 && centre.len() == 2) {
            if passes_through(&segment[0], &segment[1], &region.bounds, tolerance) && !cut {
                cut = true;
                findings.add(
                    region.key.as_str(),
                    format!("{} is cut by the wall \"{}\"", region.what, wall.name),
                    "move or shrink one of them; they may touch",
                );
            }
            let [dx, dy] = [segment[1][0] - segment[0][0], segment[1][1] - segment[0][1]];
            let [rx, ry] = [centre[0] - segment[0][0], centre[1] - segment[0][1]];
            let along = (rx * dx + ry * dy) / (dx * dx + dy * dy);
            let left = (dx * ry - dy * rx) / dx.hypot(dy);
            if (0.0..=1.0).contains(&along) && nearest.is_none_or(|(distance, ..)| left.abs() < distance) {
                nearest = Some((left.abs(), (left > 0.0) == (side == Side::Left), i));
            }
        }
    }
    if let (false, Some((_, true, i))) = (cut, nearest) {
        findings.add(
            format!("fluid.wall.{i}.solid_side"),
            format!("puts {} into the solid", region.what),
            "take the other side, or move what is in it",
        );
    }
}

/// Whether the segment has a part inside the box shrunk by `tolerance` (clipped axis by axis, after Liang and
/// Barsky 1984).
fn passes_through(from: &[f64], to: &[f64], bounds: &AxisBox, tolerance: f64) -> bool {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (low, high) = (bounds.low[axis] + tolerance, bounds.high[axis] - tolerance);
        let step = to[axis] - from[axis];
        if step == 0.0 {
            if from[axis] <= low || from[axis] >= high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - from[axis]) / step, (high - from[axis]) / step);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter < leave && bounds.low.iter().chain(&bounds.high).chain(from).chain(to).all(|x| x.is_finite())
}
