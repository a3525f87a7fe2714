//! The fluid by itself.

use super::{Findings, check_box, check_filled_box, check_names, check_participant, is_own};
use crate::case::resolve::default_characteristic_speed;
use crate::case::typed::{Fluid, General, Wall};

pub(super) fn check(fluid: &Fluid, case: &General, findings: &mut Findings) {
    let spacing = fluid.particle_spacing.unwrap_or(case.particle_spacing);
    check_names("fluid.region", fluid.region.iter().map(|region| region.name.as_str()), findings);
    check_names("fluid.wall", fluid.wall.iter().map(|wall| wall.name.as_str()), findings);
    check_participant("fluid", &fluid.participant, findings);
    let domain_is_box = check_box("fluid.domain", &fluid.domain, findings);
    for (i, region) in fluid.region.iter().enumerate() {
        let key = format!("fluid.region.{i}.box");
        check_filled_box(&key, &region.bounds, spacing, findings);
        let (domain, bounds) = (&fluid.domain, &region.bounds);
        let outside = bounds.low.iter().zip(&domain.low).any(|(region, domain)| region < domain)
            || bounds.high.iter().zip(&domain.high).any(|(region, domain)| region > domain);
        if domain_is_box && outside {
            findings.add(key, "reaches out of fluid.domain", "enlarge the domain, or move the region");
        }
    }
    for (i, wall) in fluid.wall.iter().enumerate() {
        check_wall(&format!("fluid.wall.{i}"), wall, case.dimension, findings);
    }
    if fluid.region.is_empty() && is_own(&fluid.participant) {
        findings.add("fluid", "there is no fluid in it", "add a [[fluid.region]]");
    }
    let thresholds = fluid.numerics.resolve().surface_thresholds;
    if thresholds[0] >= thresholds[1] {
        findings.add("fluid.numerics.surface_thresholds", "do not grow", "write the lower threshold first");
    }
    let gravity = case.gravity.as_deref().unwrap_or(&[]);
    let needs_speed =
        fluid.characteristic_speed.is_none() && is_own(&fluid.participant) && !fluid.region.is_empty();
    if needs_speed && default_characteristic_speed(fluid, gravity) == 0.0 {
        findings.add(
            "fluid.characteristic_speed",
            "is missing, and there is neither gravity nor a velocity at the start to take it from",
            "add it: the greatest speed to be expected (m/s)",
        );
    }
}

fn check_wall(key: &str, wall: &Wall, dimension: u32, findings: &mut Findings) {
    match (&wall.bounds, &wall.polyline) {
        (Some(_), Some(_)) => findings.add(key, "has both box and polyline", "make two walls of it"),
        (None, None) => findings.add(key, "has no shape", "add box or polyline"),
        (Some(bounds), None) => {
            check_box(&format!("{key}.box"), bounds, findings);
            if wall.solid_side.is_some() {
                findings.add(format!("{key}.solid_side"), "is for polylines", "leave it out: a box is solid");
            }
        }
        (None, Some(points)) => check_polyline(key, wall, points, dimension, findings),
    }
}

fn check_polyline(key: &str, wall: &Wall, points: &[Vec<f64>], dimension: u32, findings: &mut Findings) {
    if dimension != 2 {
        findings.add(format!("{key}.polyline"), "is for two dimensions", "build the wall of boxes");
        return;
    }
    if points.len() < 2 {
        findings.add(format!("{key}.polyline"), "has fewer than two points", "write [[x, y], [x, y], ...]");
    }
    if let Some(first) = points.windows(2).position(|pair| pair[0] == pair[1]) {
        findings.add(
            format!("{key}.polyline.{}", first + 1),
            "is the point before it once more",
            "leave it out",
        );
    }
    if wall.solid_side.is_none() {
        findings.add(
            format!("{key}.solid_side"),
            "is missing",
            "add \"left\" or \"right\": where the solid is, walking along the polyline from its first point",
        );
    }
}
