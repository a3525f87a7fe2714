//! Nothing on a polyline's solid side, and nothing cut by it. Touching is no overlap.

use super::parts::Part;
use crate::case::findings::Findings;
use crate::case::fluid::Wall;
use crate::case::geometry::AxisBox;
use words::geometry::Side;

/// Spacings of the fluid to which a polyline counts as filled behind.
pub(super) const FILLED: f64 = 4.0;

/// A polyline must not cut a region or a body, and it must lie on its open side or farther than `deepest` (m)
/// behind.
pub(super) fn beside(
    region: &Part<'_>,
    walls: &[Wall],
    (tolerance, deepest): (f64, f64),
    findings: &mut Findings,
) {
    let cutting = walls.iter().find(|wall| cuts(wall, &region.bounds, tolerance));
    if let Some(wall) = cutting {
        findings.add(
            region.key.as_str(),
            format!("{} is cut by the wall \"{}\"", region.what, wall.name),
            "move or shrink one of them; they may touch",
        );
        return;
    }
    let centre = middle(&region.bounds);
    let nearest = walls.iter().enumerate().filter_map(|(i, wall)| Some((i, nearest(wall, &centre)?)));
    let nearest = nearest.min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance));
    let within = |nearest: &Nearest| nearest.solid && nearest.distance - reach(&region.bounds) < deepest;
    if let Some((i, _)) = nearest.filter(|(_, nearest)| within(nearest)) {
        findings.add(
            format!("fluid.wall.{i}.solid_side"),
            format!("puts {} into the solid", region.what),
            "take the other side, or move what is in it",
        );
    }
}

/// A box that moves must stand in no polyline's solid, and a polyline that moves must cut no box: it would
/// drag its particles through the other's.
pub(super) fn walls_that_move(walls: &[Wall], tolerance: f64, findings: &mut Findings) {
    for (i, wall) in walls.iter().enumerate() {
        let Some(bounds) = wall.bounds.as_ref().filter(|bounds| bounds.low.len() == 2) else { continue };
        let centre = middle(bounds);
        for line in walls.iter().filter(|line| line.motion != wall.motion) {
            let within = || nearest(line, &centre).is_some_and(|nearest| nearest.solid);
            // What stands behind a polyline without being cut is as deep in its solid as it likes to be.
            let near = || nearest(line, &centre).is_some_and(|nearest| nearest.distance < reach(bounds));
            if cuts(line, bounds, tolerance) || near() && within() {
                let mover = if wall.motion.is_some() { wall } else { line };
                findings.add(
                    format!("fluid.wall.{i}.box"),
                    format!(
                        "the wall \"{}\" overlaps the solid of the wall \"{}\", and the wall \"{}\" moves",
                        wall.name, line.name, mover.name
                    ),
                    "move or shrink one of them; they may touch",
                );
            }
        }
    }
}

/// Distance (m) from a point to the nearest place of a polyline, and whether the solid is on its side.
struct Nearest {
    distance: f64,
    solid: bool,
}

/// Of the pieces and the corners between them; a polyline has no side beyond its ends.
fn nearest(wall: &Wall, point: &[f64]) -> Option<Nearest> {
    let (Some(points), Some(side)) = (&wall.polyline, wall.solid_side) else { return None };
    if point.len() != 2 || points.iter().any(|p| p.len() != 2) {
        return None;
    }
    let (closed, last) = (points.first() == points.last(), points.len().checked_sub(2)?);
    // At a corner two pieces are equally near; the one that the point stands more squarely before tells.
    let mut best: Option<(f64, f64)> = None;
    for (k, piece) in points.windows(2).enumerate() {
        let [dx, dy] = [piece[1][0] - piece[0][0], piece[1][1] - piece[0][1]];
        let [rx, ry] = [point[0] - piece[0][0], point[1] - piece[0][1]];
        let along = (rx * dx + ry * dy) / (dx * dx + dy * dy);
        let beyond = !closed && (k == 0 && along < 0.0 || k == last && along > 1.0);
        if beyond || along.is_nan() {
            continue;
        }
        let s = along.clamp(0.0, 1.0);
        let distance = (rx - s * dx).hypot(ry - s * dy);
        let left = (dx * ry - dy * rx) / dx.hypot(dy);
        let tie = best.is_some_and(|(nearest, _)| (distance - nearest).abs() <= 1e-9 * dx.hypot(dy));
        let better = match best {
            None => true,
            Some((_, square)) if tie => left.abs() > square.abs(),
            Some((nearest, _)) => distance < nearest,
        };
        if better {
            best = Some((distance, left));
        }
    }
    best.map(|(distance, left)| Nearest { distance, solid: (left > 0.0) == (side == Side::Left) })
}

/// Whether a piece of the wall's polyline passes through the box.
fn cuts(wall: &Wall, bounds: &AxisBox, tolerance: f64) -> bool {
    let points = wall.polyline.as_deref().unwrap_or_default();
    let in_plane = bounds.low.len() == 2 && points.iter().all(|point| point.len() == 2);
    in_plane && points.windows(2).any(|piece| passes_through(&piece[0], &piece[1], bounds, tolerance))
}

fn middle(bounds: &AxisBox) -> Vec<f64> {
    bounds.low.iter().zip(&bounds.high).map(|(low, high)| 0.5 * (low + high)).collect()
}

/// Half the diagonal (m) of a box.
fn reach(bounds: &AxisBox) -> f64 {
    0.5 * bounds.extent().iter().map(|side| side * side).sum::<f64>().sqrt()
}

/// Whether the middle of the box is in a polyline's solid, at most so deep (m).
pub(super) fn holds(wall: &Wall, bounds: &AxisBox, deepest: f64) -> bool {
    nearest(wall, &middle(bounds)).is_some_and(|nearest| nearest.solid && nearest.distance < deepest)
}

/// Whether the wall's polyline lies along the box: whether more than `least` (m) of a piece is inside it,
/// grown by `tolerance` (m). One that only touches a corner of it does not.
pub(super) fn lies_along(wall: &Wall, bounds: &AxisBox, tolerance: f64, least: f64) -> bool {
    let points = wall.polyline.as_deref().unwrap_or_default();
    let in_plane = bounds.low.len() == 2 && points.iter().all(|point| point.len() == 2);
    let length = |piece: &[Vec<f64>]| (piece[1][0] - piece[0][0]).hypot(piece[1][1] - piece[0][1]);
    let within = |piece: &[Vec<f64>]| match part_inside(&piece[0], &piece[1], bounds, -tolerance) {
        Some((enter, leave)) => (leave - enter) * length(piece) > least,
        None => false,
    };
    in_plane && points.windows(2).any(within)
}

/// Whether the segment has a part inside the box shrunk by `tolerance`.
fn passes_through(from: &[f64], to: &[f64], bounds: &AxisBox, tolerance: f64) -> bool {
    part_inside(from, to, bounds, tolerance).is_some_and(|(enter, leave)| enter < leave)
}

/// The part of the segment inside the box shrunk by `tolerance` (m), from 0 to 1 along it (clipped axis by
/// axis, after Liang and Barsky 1984).
fn part_inside(from: &[f64], to: &[f64], bounds: &AxisBox, tolerance: f64) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (low, high) = (bounds.low[axis] + tolerance, bounds.high[axis] - tolerance);
        let step = to[axis] - from[axis];
        if step == 0.0 {
            if from[axis] <= low || from[axis] >= high {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - from[axis]) / step, (high - from[axis]) / step);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    let known = bounds.low.iter().chain(&bounds.high).chain(from).chain(to).all(|x| x.is_finite());
    known.then_some((enter, leave))
}
