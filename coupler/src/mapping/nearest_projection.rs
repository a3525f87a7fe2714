//! Nearest projection onto a boundary, continued through the body to its far side.
//!
//! A target *on* the boundary takes the values of its facet's vertices with barycentric weights. A target
//! *off* it cannot do with one facet: all combinations of a facet's vertices lie in the facet's plane, so
//! weights that reproduce the target's own position, which exact rotations ask for, need points off that
//! plane. (The offset could be turned with the facet's normal instead, but the normal is no linear function
//! of the vertices in space and mixes components in the plane: no one matrix for vectors of any kind, and no
//! transpose that keeps moments.) The far side of the body has such points. The line from the foot `a` on the
//! near facet through the target `x` leaves the body at `b` on a far facet, and with barycentric weights of
//! both feet
//!
//! ```text
//! x = (1 − s) a + s b,    u(x) = (1 − s) Σ aᵢ uᵢ + s Σ bᵢ uᵢ,    s = (x − a)·(b − a) / |b − a|²
//! ```
//!
//! `Σ w = 1` and `Σ w xᵢ = x` to round-off for every target, weights of targets inside are positive, and a
//! row has at most `2 D` of them. In a thin plate this is a motion linear through the thickness, as in plate
//! theory, whatever the size of the facets. A target outside lies on the same line with `s < 0`.
//!
//! Linear interpolation along a chord errs by at most `½ |x − a| |x − b| |u''|`. So of the chords that start
//! perpendicular to a facet (and the one from the nearest point, which in a concave corner is perpendicular
//! to none) that with the smallest `|x − a| |x − b|` is taken: near the tip of a plate the one through its
//! thickness, not the one along the plate that the nearest facet, the tip, would give.
//!
//! The error falls with the square of the facets' size on the boundary. Inside it has that of the chord as
//! well, which no refinement of the boundary mends: in a thick body that bends, follow a source that has
//! points inside. A target outside has no choice of chords: beyond the tip of a plate it is carried by the
//! line along the plate. Where the best chord changes, the mapped field jumps by the difference of two such
//! errors.
//!
//! A body's particles keep their places in it, so the weights are best made once, in the reference
//! configuration: they then move as material points of the boundary's motion, and nothing is rebuilt.
//! [`super::Mapping::update`] is for targets that slide along.

use super::boundary::{Boundary, Foot, Stack};
use super::cell_grid::{bounds, distance_squared};
use super::error::MappingError;
use super::facet;
use super::parts::Parts;
use super::rows::Rows;
use super::semidefinite::{dot, minus};
use std::ops::Range;

/// The boundary and its tree.
#[derive(Clone, Debug)]
pub(super) struct NearestProjection {
    boundary: Boundary,
    parts: Parts<Scratch>,
}

/// Memory of a search for facets, and of one for where a line meets them.
#[derive(Clone, Debug, Default)]
struct Scratch {
    near: Stack,
    line: Stack,
}

/// Facets where searches begin.
#[derive(Clone, Copy, Default)]
struct Hint {
    near: Option<usize>,
    far: Option<usize>,
}

/// A line through the target from near foot to far foot.
struct Chord<const D: usize> {
    /// `|x − a| |x − b|` (m²).
    product: f64,
    near: Foot<D>,
    far: Foot<D>,
}

impl NearestProjection {
    /// Facets of `dimension` vertices each, by number of source point.
    pub fn new(facets: Vec<usize>, dimension: usize) -> Result<Self, MappingError> {
        Ok(Self { boundary: Boundary::new(facets, dimension)?, parts: Parts::default() })
    }

    /// Gathers a row for each target. All points are finite.
    pub fn fill<const D: usize>(
        &mut self,
        source: &[[f64; D]],
        target: &[[f64; D]],
        reach: f64,
        threads: usize,
        rows: &mut Rows,
    ) -> Result<(), MappingError> {
        self.boundary.update(source)?;
        let (lower, upper) = bounds(source);
        // Rounding error of a coordinate, some times over: nearer than this is on the boundary.
        let rounding =
            16.0 * f64::EPSILON * (0..D).map(|i| lower[i].abs().max(upper[i].abs())).fold(0.0, f64::max);
        let mut parts = std::mem::take(&mut self.parts);
        let gathered = parts.gather(target.len(), threads, rows, |part, scratch, rows| {
            self.fill_part(target, part, reach, rounding, scratch, rows)
        });
        self.parts = parts;
        gathered
    }

    fn fill_part<const D: usize>(
        &self,
        target: &[[f64; D]],
        part: Range<usize>,
        reach: f64,
        rounding: f64,
        scratch: &mut Scratch,
        rows: &mut Rows,
    ) -> Result<(), MappingError> {
        // Targets come in an order in which one is mostly near the next: what was found for the last one is
        // where the search begins.
        let mut last = Hint::default();
        for point in part {
            let x = &target[point];
            let (foot, squared) = self.boundary.nearest(x, last.near, &mut scratch.near);
            last.near = Some(foot.facet);
            let distance = squared.sqrt();
            if distance <= rounding {
                self.add(&foot, 1.0, rows);
            } else {
                let chord = self.chord_inside(x, foot, rounding, last.far, scratch);
                if chord.is_none() && distance > reach {
                    return Err(MappingError::OutOfReach { point, position: x.to_vec(), distance, reach });
                }
                let chord = chord
                    .or_else(|| self.chord_outside(x, foot, scratch))
                    .ok_or_else(|| MappingError::NoFarSide { point, position: x.to_vec(), distance })?;
                last.far = Some(chord.far.facet);
                self.add_chord(x, &chord, rows);
            }
            rows.end_row();
        }
        Ok(())
    }

    fn add_chord<const D: usize>(&self, x: &[f64; D], chord: &Chord<D>, rows: &mut Rows) {
        let line = minus(&chord.far.position, &chord.near.position);
        let s = dot(&minus(x, &chord.near.position), &line) / dot(&line, &line);
        self.add(&chord.near, 1.0 - s, rows);
        self.add(&chord.far, s, rows);
    }

    fn add<const D: usize>(&self, foot: &Foot<D>, weight: f64, rows: &mut Rows) {
        for (&vertex, b) in self.boundary.vertices::<D>(foot.facet).iter().zip(foot.barycentric) {
            rows.add(vertex, weight * b);
        }
    }

    /// The best chord through a target inside; none if lines from the boundary through the target leave
    /// nowhere.
    fn chord_inside<const D: usize>(
        &self,
        x: &[f64; D],
        nearest: Foot<D>,
        rounding: f64,
        hint: Option<usize>,
        Scratch { near, line }: &mut Scratch,
    ) -> Option<Chord<D>> {
        let tried = nearest.facet;
        let mut best = self.chord_from(x, nearest, rounding, hint, line);
        // A chord is drawn from its nearer foot, so that of a better one is nearer than the root of the best
        // product. In the middle plane of a plate both feet are equally near, up to rounding.
        let limit = |chord: &Chord<D>| (1.0 + 1e-9) * chord.product;
        let bound = best.as_ref().map_or(f64::INFINITY, limit);
        self.boundary.visit_near(x, bound, true, near, |facet, bound| {
            if facet == tried || facet::is_beside(self.boundary.corners(facet), x) {
                return bound;
            }
            let foot = self.boundary.foot(facet, x);
            let squared = distance_squared(&foot.position, x);
            if squared <= bound
                && is_perpendicular(self.boundary.corners(facet), &foot, x)
                && let Some(chord) = self.chord_from(x, foot, rounding, hint, line)
                && squared <= limit(&chord)
                && best.as_ref().is_none_or(|b| (chord.product, facet) < (b.product, b.near.facet))
            {
                best = Some(chord);
            }
            best.as_ref().map_or(f64::INFINITY, limit)
        });
        best
    }

    /// The chord from `near` through `x`, if the boundary is left beyond `x`.
    fn chord_from<const D: usize>(
        &self,
        x: &[f64; D],
        near: Foot<D>,
        rounding: f64,
        hint: Option<usize>,
        line: &mut Stack,
    ) -> Option<Chord<D>> {
        let (direction, distance) = self.direction(x, &near);
        if distance <= rounding {
            return None;
        }
        let (t, far) = self.boundary.first_meeting(x, &direction, 0.0, hint, line)?;
        self.leaves(&far, &direction).then_some(Chord { product: distance * t, near, far })
    }

    /// The chord of a target outside, from the nearest point away from the target through the body.
    fn chord_outside<const D: usize>(
        &self,
        x: &[f64; D],
        near: Foot<D>,
        scratch: &mut Scratch,
    ) -> Option<Chord<D>> {
        let (direction, distance) = self.direction(x, &near);
        let direction = direction.map(|c| -c);
        // Facets that meet in the foot are met at zero, up to rounding.
        let corners = self.boundary.corners::<D>(near.facet);
        let after = 1e-7 * distance_squared(&corners[1], &corners[0]).sqrt();
        let (t, far) =
            self.boundary.first_meeting(&near.position, &direction, after, None, &mut scratch.line)?;
        self.leaves(&far, &direction).then_some(Chord { product: distance * (distance + t), near, far })
    }

    /// Unit vector from the foot to the target, and their distance (m). Very near a facet it is the facet's
    /// normal, as the difference of the two is lost in rounding.
    fn direction<const D: usize>(&self, x: &[f64; D], near: &Foot<D>) -> ([f64; D], f64) {
        let off = minus(x, &near.position);
        let distance = dot(&off, &off).sqrt();
        let corners = self.boundary.corners::<D>(near.facet);
        let normal = facet::normal(corners);
        let length = dot(&normal, &normal).sqrt();
        let scale = distance_squared(&corners[1], &corners[0]).sqrt();
        if distance > 1e-8 * scale {
            return (off.map(|c| c / distance), distance);
        }
        let sign = dot(&off, &normal).signum();
        (normal.map(|c| sign * c / length), distance)
    }

    /// Whether a line in this direction leaves the body at `foot`.
    fn leaves<const D: usize>(&self, foot: &Foot<D>, direction: &[f64; D]) -> bool {
        dot(&facet::normal(self.boundary.corners::<D>(foot.facet)), direction) > 0.0
    }
}

/// Whether the line from `foot` to `x` is perpendicular to the facet, up to an angle of 1e-6;
/// [`facet::is_beside`] is sure that it is not.
fn is_perpendicular<const D: usize>(corners: &[[f64; D]; D], foot: &Foot<D>, x: &[f64; D]) -> bool {
    let off = minus(x, &foot.position);
    let normal = facet::normal(corners);
    dot(&off, &normal).powi(2) >= (1.0 - 1e-12) * dot(&off, &off) * dot(&normal, &normal)
}
