//! Lines and areas of probes, intervals and filters.

use crate::case::findings::Findings;
use crate::case::fluid::Wall;
use crate::case::keys::Case;
use crate::case::probe::{Probe, ProbeSide};
use words::probe::ProbeQuantity;

/// Intervals of a probe at most, as many as outputs.
const INTERVALS: f64 = 1e6;
/// Sine of an angle that counts as none.
const FLAT: f64 = 1e-6;

pub(super) fn check(key: &str, probe: &Probe, file: &Case, findings: &mut Findings) {
    check_interval(key, probe, file.general.end_time, findings);
    let is_line = probe.quantity == ProbeQuantity::SurfaceHeight;
    let is_flux = probe.quantity == ProbeQuantity::Flux;
    let is_sensor = probe.quantity == ProbeQuantity::Pressure && probe.on != ProbeSide::Structure;
    let has_area = probe.span.is_some() || probe.radius.is_some();
    let areas = "leave it out; there are areas for \"flux\" and \"pressure\"";
    for (name, is_given) in [("span", probe.span.is_some()), ("radius", probe.radius.is_some())] {
        if is_given && !is_flux && !is_sensor {
            findings.add(format!("{key}.{name}"), "does not go with the quantity", areas);
        }
    }
    let is_directed = is_line || is_flux || (is_sensor && probe.radius.is_some());
    if probe.direction.is_some() && !is_directed {
        let remedy = "leave it out; there are directions for \"surface-height\", \"flux\" and discs";
        findings.add(format!("{key}.direction"), "does not go with the quantity", remedy);
    }
    if probe.direction.as_deref().is_some_and(|direction| length(direction) == 0.0) {
        findings.add(format!("{key}.direction"), "is zero", "give a vector with a direction");
    }
    if is_line && probe.direction.is_none() && length(&file.general.gravity) == 0.0 {
        let problem = "is missing, and there is no gravity against which the line would go";
        findings.add(format!("{key}.direction"), problem, "add where the line goes");
    }
    if is_flux && !has_area {
        let remedy = match file.general.dimension {
            2 => "add the edge of the segment (m)",
            _ => "add the two edges of the rectangle (m), or the radius of a disc",
        };
        findings.add(format!("{key}.span"), "is missing", remedy);
    }
    if (is_flux || is_sensor) && has_area {
        check_area(key, probe, file, findings);
    }
}

fn check_interval(key: &str, probe: &Probe, end_time: f64, findings: &mut Findings) {
    let Some(interval) = probe.interval else { return };
    let key = format!("{key}.interval");
    let count = end_time / interval;
    if interval > end_time * (1.0 + 1e-9) {
        let remedy = format!("take at most {end_time} s");
        findings.add(key, "is longer than the run, in which no interval would end", remedy);
    } else if count > INTERVALS {
        let problem = format!("asks for {count:.1e} intervals in {end_time} s");
        findings.add(key, problem, format!("take an interval for at most {INTERVALS:.0e}"));
    }
}

fn check_area(key: &str, probe: &Probe, file: &Case, findings: &mut Findings) {
    let dimension = file.general.dimension;
    let needs_direction = probe.quantity == ProbeQuantity::Flux || probe.radius.is_some();
    if needs_direction && probe.direction.is_none() {
        let remedy = match probe.quantity {
            ProbeQuantity::Flux => "add the side to which what crosses counts as positive",
            _ => "add the normal of the disc",
        };
        findings.add(format!("{key}.direction"), "is missing", remedy);
    }
    if probe.radius.is_some() && dimension == 2 {
        findings.add(format!("{key}.radius"), "there are no discs in two dimensions", "write a span");
        return;
    }
    let Some(span) = &probe.span else { return };
    let key_of_span = format!("{key}.span");
    if probe.radius.is_some() {
        findings.add(key_of_span, "is there beside a radius", "leave one of the two out");
        return;
    }
    if span.len() != dimension - 1 {
        let problem = format!("has {} edges in {dimension} dimensions", span.len());
        let remedy = if dimension == 2 { "write one edge" } else { "write two edges" };
        findings.add(key_of_span, problem, remedy);
        return;
    }
    let (normal, size) = (normal(span), span.iter().map(|edge| length(edge)).product::<f64>());
    if length(&normal) <= FLAT * size {
        findings.add(key_of_span, "has no area", "give edges that are long and not parallel");
        return;
    }
    let direction = probe.direction.as_deref().filter(|_| needs_direction);
    if direction.is_some_and(|to| dot(to, &normal).abs() < FLAT * length(to) * length(&normal)) {
        let remedy = "let it point to one of the area's two sides";
        findings.add(format!("{key}.direction"), "lies in the area", remedy);
    }
    let Some(at) = &probe.at else { return };
    let corners = corners(at, span);
    let Some(fluid) = &file.fluid else { return };
    if probe.on == ProbeSide::Wall {
        let wall = fluid.walls.iter().find(|wall| Some(&wall.name) == probe.wall.as_ref());
        let off = |wall| corners.iter().any(|corner| is_off_wall(corner, wall, fluid.particle_spacing));
        if let Some(wall) = wall.filter(|wall| off(wall)) {
            let problem = format!("goes farther than one particle spacing from the wall \"{}\"", wall.name);
            findings.add(key_of_span, problem, "take an area of its surface");
        }
    } else if probe.relative_to.is_none()
        && corners.iter().any(|corner| fluid.domain.is_clear_of(corner, 0.0))
    {
        findings.add(key_of_span, "goes outside of fluid.domain", "take an area inside");
    }
}

/// What stands upright on one edge in two dimensions, on two in three, as long as the area is large.
fn normal(span: &[Vec<f64>]) -> Vec<f64> {
    match span {
        [edge] if edge.len() == 2 => vec![-edge[1], edge[0]],
        [a, b] if a.len() == 3 && b.len() == 3 => {
            let cross = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
            vec![cross(1, 2), cross(2, 0), cross(0, 1)]
        }
        // Vectors of wrong lengths have been told of.
        _ => vec![f64::NAN],
    }
}

/// Corners of the area with these edges around a point (m).
fn corners(at: &[f64], span: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut corners = vec![at.to_vec()];
    for edge in span {
        let moved = |corner: &Vec<f64>, share: f64| -> Vec<f64> {
            corner.iter().zip(edge).map(|(x, step)| x + share * step).collect()
        };
        corners = corners.iter().flat_map(|corner| [moved(corner, -0.5), moved(corner, 0.5)]).collect();
    }
    corners
}

/// Whether a point (m) is farther than one spacing (m) from a wall.
pub(super) fn is_off_wall(at: &[f64], wall: &Wall, spacing: f64) -> bool {
    if let Some(bounds) = &wall.bounds {
        return bounds.is_clear_of(at, spacing);
    }
    let points = wall.polyline.as_deref().unwrap_or(&[]);
    points.len() > 1 && points.windows(2).all(|pair| distance(at, &pair[0], &pair[1]) > spacing)
}

/// Distance of a point from a segment.
fn distance(point: &[f64], from: &[f64], to: &[f64]) -> f64 {
    let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>();
    let (edge, arm) = (minus(to, from), minus(point, from));
    let along = (dot(&arm, &edge) / dot(&edge, &edge)).clamp(0.0, 1.0);
    let foot: Vec<_> = edge.iter().map(|step| along * step).collect();
    let gap = minus(&arm, &foot);
    length(&gap)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}
