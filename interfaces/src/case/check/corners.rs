//! Walls that touch at an edge alone. The quarter behind it is open, and the water in the corner would feel
//! the open air through it: there is no fluid and no solid to say otherwise.

use super::parts::Part;
use crate::case::findings::Findings;
use crate::case::fluid::{Fluid, Wall};
use crate::case::geometry::AxisBox;

/// Of two boxes that touch at an edge alone, with fluid on one side of it, the other side must hold
/// something.
pub(super) fn check(
    fluid: &Fluid,
    (regions, bodies): (&[Part<'_>], &[Part<'_>]),
    tolerance: f64,
    findings: &mut Findings,
) {
    let boxes: Vec<(usize, &Wall, &AxisBox)> = fluid
        .walls
        .iter()
        .enumerate()
        .filter_map(|(i, wall)| Some((i, wall, wall.bounds.as_ref()?)))
        .filter(|(_, wall, _)| wall.motion.is_none())
        .collect();
    let holds = |parts: &[Part<'_>], point: &[f64]| parts.iter().any(|part| contains(&part.bounds, point));
    let walled = |point: &[f64]| {
        // A polyline that touches the corner may fill the quarter: it is not looked into.
        let lines = fluid.walls.iter().filter_map(|wall| wall.polyline.as_ref()).flatten();
        let mut lines = lines.filter(|corner| corner.len() == point.len());
        let beside =
            |corner: &Vec<f64>| corner.iter().zip(point).all(|(a, b)| (a - b).abs() < fluid.particle_spacing);
        boxes.iter().any(|(.., bounds)| contains(bounds, point)) || lines.any(beside)
    };
    for (n, (i, wall, bounds)) in boxes.iter().enumerate() {
        for (_, other, others) in &boxes[..n] {
            let Some(quarters) = open_quarters(bounds, others, 0.5 * fluid.particle_spacing, tolerance)
            else {
                continue;
            };
            let wet = quarters.each_ref().map(|quarter| holds(regions, quarter));
            let dry = quarters
                .each_ref()
                .map(|quarter| !walled(quarter) && !holds(bodies, quarter) && !holds(regions, quarter));
            if wet[0] && dry[1] || wet[1] && dry[0] {
                findings.add(
                    format!("fluid.wall.{i}.box"),
                    format!(
                        "the wall \"{}\" touches the wall \"{}\" at an edge alone, and what is behind it is open",
                        wall.name, other.name
                    ),
                    "let one of them reach behind the other, at least four particle spacings; walls that stay may overlap",
                );
            }
        }
    }
}

/// Of boxes that touch along an edge, on the sides of it where neither is, points this far (m) from it.
fn open_quarters(a: &AxisBox, b: &AxisBox, away: f64, tolerance: f64) -> Option<[Vec<f64>; 2]> {
    let mut quarters = [Vec::new(), Vec::new()];
    let mut touching = 0;
    let axes = a.low.iter().zip(&a.high).zip(b.low.iter().zip(&b.high));
    for ((low, high), (other_low, other_high)) in axes {
        // Where the edge is on this axis, and to which side of it `a` is.
        let edge = if (high - other_low).abs() <= tolerance {
            Some((*high, -1.0))
        } else if (other_high - low).abs() <= tolerance {
            Some((*low, 1.0))
        } else {
            None
        };
        if let Some((edge, side)) = edge {
            // The quarters are on the side of one box along one axis, of the other along the other.
            let turned = if touching == 0 { 1.0 } else { -1.0 };
            quarters[0].push(edge + side * turned * away);
            quarters[1].push(edge - side * turned * away);
            touching += 1;
        } else if low.max(*other_low) < high.min(*other_high) - tolerance {
            let middle = 0.5 * (low.max(*other_low) + high.min(*other_high));
            quarters.iter_mut().for_each(|quarter| quarter.push(middle));
        } else {
            return None;
        }
    }
    (touching == 2).then_some(quarters)
}

fn contains(bounds: &AxisBox, point: &[f64]) -> bool {
    let axes = bounds.low.iter().zip(&bounds.high).zip(point);
    bounds.low.len() == point.len() && axes.into_iter().all(|((low, high), x)| low <= x && x <= high)
}
