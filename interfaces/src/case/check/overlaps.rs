//! No two things in one place. Touching is no overlap.

use super::parts::Part;
use super::{corners, held, polylines};
use crate::case::findings::Findings;
use crate::case::fluid::Fluid;
use crate::case::geometry::AxisBox;
use crate::case::keys::Case;
use crate::case::region::Region;
use std::borrow::Cow;

/// Depth of an overlap that counts, as a fraction of the particle spacing: over round-off in coordinates that
/// are meant to be the same, and far under what a particle would notice.
const TOLERANCE: f64 = 0.01;

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
    held::check(file, tolerance, findings);
    let all_walls = file.fluid.as_ref().map_or(&[][..], |fluid| &fluid.walls);
    // A polyline's solid has no other side, but no particles either beyond a few spacings: what fluid is put
    // into it is a mistake anywhere, a body that stands so far behind is in the open.
    let filled = file.fluid.as_ref().map_or(0.0, |fluid| polylines::FILLED * fluid.particle_spacing);
    for (parts, deepest) in [(&regions, f64::INFINITY), (&bodies, filled)] {
        for part in parts {
            polylines::beside(part, all_walls, (tolerance, deepest), findings);
        }
    }
    polylines::walls_that_move(all_walls, tolerance, findings);
    if let Some(fluid) = &file.fluid {
        corners::check(fluid, (&regions, &bodies), tolerance, findings);
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

/// The fixed rows beyond a clamped face may lie in a wall, but not in fluid.
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
