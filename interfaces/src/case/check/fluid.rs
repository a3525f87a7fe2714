//! The fluid by itself.

use super::is_own;
use super::parts::{check_box, check_filled_box, check_names, check_participant};
use crate::case::defaults::characteristic_speed;
use crate::case::findings::Findings;
use crate::case::fluid::{Fluid, Wall};
use crate::case::keys::General;
use crate::case::region::{FluidVelocity, Region};

pub(super) fn check(fluid: &Fluid, case: &General, findings: &mut Findings) {
    check_names("fluid.region", fluid.regions.iter().map(|region| region.name.as_str()), findings);
    check_names("fluid.wall", fluid.walls.iter().map(|wall| wall.name.as_str()), findings);
    check_participant("fluid", &fluid.participant, findings);
    let domain_is_box = check_box("fluid.domain", &fluid.domain, findings);
    check_periodic(fluid, case.dimension, findings);
    for (i, region) in fluid.regions.iter().enumerate() {
        let key = format!("fluid.region.{i}");
        check_region(&key, region, case.dimension, findings);
        let Some(bounds) = region.shape() else { continue };
        let key = format!("{key}.{}", if region.bounds.is_some() { "box" } else { "ball" });
        let domain = &fluid.domain;
        check_filled_box(&key, &bounds, fluid.particle_spacing, findings);
        let outside = bounds.low.iter().zip(&domain.low).any(|(region, domain)| region < domain)
            || bounds.high.iter().zip(&domain.high).any(|(region, domain)| region > domain);
        if domain_is_box && outside {
            findings.add(key, "reaches out of fluid.domain", "enlarge the domain, or move the region");
        }
    }
    for (i, wall) in fluid.walls.iter().enumerate() {
        check_wall(&format!("fluid.wall.{i}"), wall, fluid.particle_spacing, case.dimension, findings);
    }
    if fluid.regions.is_empty() && is_own(&fluid.participant) {
        findings.add("fluid", "there is no fluid in it", "add a [[fluid.region]]");
    }
    check_characteristic_speed(fluid, &case.gravity, findings);
}

fn check_characteristic_speed(fluid: &Fluid, gravity: &[f64], findings: &mut Findings) {
    if !is_own(&fluid.participant) || fluid.regions.is_empty() {
        return;
    }
    let speed = fluid.characteristic_speed;
    let is_known = gravity.iter().all(|g| g.is_finite())
        && fluid
            .regions
            .iter()
            .filter_map(Region::shape)
            .all(|bounds| bounds.low.iter().chain(&bounds.high).all(|x| x.is_finite()));
    // One that was written and found wrong is not finite either.
    if is_known && !speed.is_finite() && !characteristic_speed(fluid, gravity).is_finite() {
        let problem = format!("cannot be taken from gravity and the regions: it would be {speed} m/s");
        findings.add("fluid.characteristic_speed", problem, "add it, or correct case.gravity");
    }
    if speed == 0.0 {
        findings.add(
            "fluid.characteristic_speed",
            "is missing, and there is neither gravity nor a velocity at the start to take it from",
            "add it: the greatest speed to be expected (m/s)",
        );
    }
}

fn check_periodic(fluid: &Fluid, dimension: usize, findings: &mut Findings) {
    for (i, axis) in fluid.periodic.iter().enumerate() {
        let key = format!("fluid.periodic.{i}");
        if axis.index() >= dimension {
            findings.add(key, "is an axis in three dimensions", "take \"x\" or \"y\"");
        } else if fluid.periodic[..i].contains(axis) {
            findings.add(key, "is there already", "leave it out");
        }
    }
}

fn check_region(key: &str, region: &Region, dimension: usize, findings: &mut Findings) {
    match (&region.bounds, &region.ball) {
        (Some(_), Some(_)) => findings.add(key, "has both box and ball", "make two regions of it"),
        (None, None) => findings.add(key, "has no shape", "add box or ball"),
        _ => {}
    }
    if region.wave.is_some() && (dimension != 2 || region.bounds.is_none()) {
        findings.add(format!("{key}.wave"), "is for a box in two dimensions", "leave it out");
    }
    if dimension != 2 && matches!(region.velocity, FluidVelocity::Mode(_)) {
        findings.add(format!("{key}.velocity"), "has a shape for two dimensions", "give a vector (m/s)");
    }
}

fn check_wall(key: &str, wall: &Wall, spacing: f64, dimension: usize, findings: &mut Findings) {
    match (&wall.bounds, &wall.polyline) {
        (Some(_), Some(_)) => findings.add(key, "has both box and polyline", "make two walls of it"),
        (None, None) => findings.add(key, "has no shape", "add box or polyline"),
        (Some(bounds), None) => {
            check_filled_box(&format!("{key}.box"), bounds, spacing, findings);
            if wall.solid_side.is_some() {
                findings.add(format!("{key}.solid_side"), "is for polylines", "leave it out: a box is solid");
            }
        }
        (None, Some(points)) => check_polyline(key, wall, points, dimension, findings),
    }
}

fn check_polyline(key: &str, wall: &Wall, points: &[Vec<f64>], dimension: usize, findings: &mut Findings) {
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
