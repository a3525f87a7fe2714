//! Clamps in walls: what is clamped in a wall goes where the wall goes.

use super::polylines;
use crate::case::findings::Findings;
use crate::case::fluid::{Fluid, Wall};
use crate::case::geometry::AxisBox;
use crate::case::keys::Case;
use crate::case::motion::Moving;
use crate::case::structure::{Clamp, ClampRegion, Structure};

/// A clamp whose place lies in a wall, or along its surface, must move as the wall does.
pub(super) fn check(file: &Case, tolerance: f64, findings: &mut Findings) {
    let (Some(fluid), Some(structure)) = (&file.fluid, &file.structure) else { return };
    for (i, clamp) in structure.clamps.iter().enumerate() {
        // How it is meant to move is not known, which is told elsewhere.
        if clamp.with_wall.is_some() || matches!(clamp.motion, Some(Moving::Named(_))) {
            continue;
        }
        let Some(place) = place(clamp, structure, file.general.dimension) else { continue };
        let held =
            |wall: &&Wall| wall.moves() != clamp.moves() && is_held(clamp, &place, wall, fluid, tolerance);
        let Some(wall) = fluid.walls.iter().find(held) else { continue };
        let problem = match (wall.moves(), clamp.moves()) {
            (Some(_), None) => "which moves, and the clamp stays",
            (None, _) => "which stays, and the clamp moves",
            (Some(_), Some(_)) => "which moves otherwise",
        };
        let remedy = match wall.moves() {
            Some(_) => format!("let it move with the wall: with_wall = \"{}\"", wall.name),
            None => "leave its motion out, or let the wall move too".to_owned(),
        };
        findings.add(
            format!("structure.clamp.{i}"),
            format!("it holds in the wall \"{}\", {problem}", wall.name),
            remedy,
        );
    }
}

/// The box of what a clamp holds; a face without rows is as thick as nothing.
fn place(clamp: &Clamp, structure: &Structure, dimension: usize) -> Option<AxisBox> {
    let body = structure.bodies.iter().find(|body| body.name == clamp.body)?;
    let inside = |bounds: &AxisBox| AxisBox {
        low: bounds.low.iter().zip(&body.bounds.low).map(|(a, b)| a.max(*b)).collect(),
        high: bounds.high.iter().zip(&body.bounds.high).map(|(a, b)| a.min(*b)).collect(),
    };
    match clamp.region()? {
        ClampRegion::Face { face, .. } if face.axis() >= dimension => None,
        ClampRegion::Face { face, rows } => {
            let cells = body.bounds.lattice_counts(structure.particle_spacing)[face.axis()] as f64;
            Some(body.bounds.beyond(face, rows as f64 * body.bounds.extent()[face.axis()] / cells))
        }
        ClampRegion::Box(bounds) => Some(inside(bounds)),
        ClampRegion::Circle(ball) => Some(inside(&ball.bounds())),
    }
}

fn is_held(clamp: &Clamp, place: &AxisBox, wall: &Wall, fluid: &Fluid, tolerance: f64) -> bool {
    match &wall.bounds {
        Some(bounds) => {
            let Some(across) = shared_face(place, bounds, tolerance) else { return false };
            // A wall may slide along what is clamped by itself, as a gate does along a post.
            let slides = |axis: usize| {
                let direction = wall.moves().and_then(|motion| motion.direction.as_ref());
                clamp.face.is_none() && direction.is_some_and(|direction| direction[axis] == 0.0)
            };
            across.is_none_or(|axis| !slides(axis))
        }
        None => {
            let deep = polylines::FILLED * fluid.particle_spacing;
            polylines::lies_along(wall, place, tolerance, 4.0 * tolerance)
                || polylines::holds(wall, place, deep)
        }
    }
}

/// Whether two boxes overlap, or touch along a face: the axis across the face, where they touch only.
fn shared_face(a: &AxisBox, b: &AxisBox, tolerance: f64) -> Option<Option<usize>> {
    let axes = a.low.iter().zip(&a.high).zip(b.low.iter().zip(&b.high));
    let shared =
        axes.map(|((low, high), (other_low, other_high))| high.min(*other_high) - low.max(*other_low));
    let mut across = None;
    for (axis, length) in shared.enumerate() {
        if length < -tolerance || length.is_nan() || (length <= tolerance && across.is_some()) {
            return None;
        }
        if length <= tolerance {
            across = Some(axis);
        }
    }
    Some(across)
}
