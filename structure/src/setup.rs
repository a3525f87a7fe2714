//! Everything a structure is made of: bodies, loads and options, and the checks on them.

use crate::bodies::{Body, Side};
use crate::contact::ContactSetup;
use crate::error::{ErrorKind, SetupError};
use crate::loads::DeadLoad;
use crate::options::{Gradient, Options, SAFETY};
use sph::Vector;
use words::rigid::Motion;

impl<const D: usize> Body<D> {
    /// Clamps the face of a box as the gradient wants it: on the face for the quadratic one, by fixed rows
    /// beyond it for the first-order one.
    #[must_use]
    pub fn clamp(self, axis: usize, side: Side, gradient: Gradient, smoothing_ratio: f64) -> Self {
        match gradient {
            Gradient::FirstOrder => {
                let rows = Self::rows_for_clamp(smoothing_ratio);
                self.with_fixed_rows(axis, side, rows)
            }
            Gradient::Quadratic => self.with_fixed_face(axis, side),
        }
    }
}

/// Fixed particles that move together by a law, as one rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct ClampMotion<const D: usize> {
    /// The particles, fixed ones, in the setup's numbers.
    pub particles: Vec<usize>,
    /// How they move.
    pub motion: Motion<D>,
}

/// Everything a structure is made of.
#[derive(Clone, Debug)]
pub struct Setup<const D: usize> {
    /// The bodies. Particles are counted through them in this order.
    pub bodies: Vec<Body<D>>,
    /// Gravity (m/s²).
    pub gravity: Vector<D>,
    /// Dead loads.
    pub dead_loads: Vec<DeadLoad<D>>,
    /// Fixed particles that move by a law; the others stay where they are.
    pub motions: Vec<ClampMotion<D>>,
    /// What meets what: walls, bodies, friction.
    pub contact: ContactSetup<D>,
    /// Choices of the method.
    pub options: Options,
}

impl<const D: usize> Setup<D> {
    /// Bodies without loads, with the default options: the quadratic gradient. Clamp them for the same
    /// gradient ([`Body::clamp`]).
    pub fn new(bodies: Vec<Body<D>>) -> Self {
        Self {
            bodies,
            gravity: Vector::zeros(),
            dead_loads: Vec::new(),
            motions: Vec::new(),
            contact: ContactSetup::default(),
            options: Options::default(),
        }
    }

    /// Finds all mistakes.
    pub(crate) fn check(&self) -> Result<(), SetupError> {
        let mut mistakes = Vec::new();
        if self.bodies.iter().all(|b| b.clamped.iter().all(|&c| c)) {
            mistakes.push(ErrorKind::NothingToMove);
        }
        let mut first = 0;
        for (index, body) in self.bodies.iter().enumerate() {
            check_body(index, first, body, &mut mistakes);
            first += body.positions.len();
        }
        if self.options.gradient == Gradient::Quadratic && mistakes.is_empty() {
            for (index, body) in self.bodies.iter().enumerate() {
                mistakes.extend(too_thin(index, body));
            }
        }
        let mut positive = |name: &'static str, value: f64, zero_allowed: bool| {
            if !value.is_finite() || value < 0.0 || (value == 0.0 && !zero_allowed) {
                mistakes.push(ErrorKind::Option { name, value });
            }
        };
        positive("smoothing_ratio", self.options.smoothing_ratio, false);
        positive("damping", self.options.damping, true);
        positive("hourglass", self.options.hourglass, true);
        positive("friction", self.contact.options.friction, true);
        if !(self.options.step_fraction > 0.0 && self.options.step_fraction <= SAFETY) {
            mistakes.push(ErrorKind::Option { name: "step_fraction", value: self.options.step_fraction });
        }
        if !self.gravity.iter().all(|g| g.is_finite()) {
            mistakes.push(ErrorKind::Option { name: "gravity", value: f64::NAN });
        }
        for (load, dead) in self.dead_loads.iter().enumerate() {
            if let Some(&(particle, _)) = dead.particles.iter().find(|(p, _)| *p >= first) {
                mistakes.push(ErrorKind::LoadedParticle { load, particle, count: first });
            }
        }
        let clamped: Vec<bool> = self.bodies.iter().flat_map(|b| b.clamped.iter().copied()).collect();
        for (index, moving) in self.motions.iter().enumerate() {
            let is_free = |particle: &&usize| !clamped.get(**particle).is_some_and(|clamped| *clamped);
            if let Some(&particle) = moving.particles.iter().find(is_free) {
                mistakes.push(ErrorKind::MovedParticle { index, particle });
            }
        }
        if mistakes.is_empty() { Ok(()) } else { Err(SetupError { mistakes }) }
    }
}

/// An axis along which the free particles are fewer than three layers, judged by their extent.
fn too_thin<const D: usize>(index: usize, body: &Body<D>) -> Option<ErrorKind> {
    let mut free = body.positions.iter().zip(&body.clamped).filter(|(_, clamped)| !**clamped);
    let first = free.next()?.0;
    let (low, high) = free.fold((*first, *first), |(l, h), (p, _)| (l.inf(p), h.sup(p)));
    (0..D).find_map(|axis| {
        let layers = ((high[axis] - low[axis]) / body.cell[axis]).round() as usize + 1;
        (layers < 3).then_some(ErrorKind::Layers { body: index, axis, layers })
    })
}

fn check_body<const D: usize>(index: usize, first: usize, body: &Body<D>, mistakes: &mut Vec<ErrorKind>) {
    let count = body.positions.len();
    if body.volumes.len() != count || body.clamped.len() != count {
        mistakes.push(ErrorKind::Lengths {
            body: index,
            positions: count,
            volumes: body.volumes.len(),
            clamped: body.clamped.len(),
        });
        return;
    }
    let mut number = |name: &'static str, value: f64, good: bool| {
        if !good {
            mistakes.push(ErrorKind::Number { body: index, name, value });
        }
    };
    let m = &body.material;
    number("density", body.density, body.density > 0.0 && body.density.is_finite());
    number("youngs_modulus", m.youngs_modulus, m.youngs_modulus > 0.0 && m.youngs_modulus.is_finite());
    number("poisson_ratio", m.poisson_ratio, m.poisson_ratio > -1.0 && m.poisson_ratio < 0.5);
    for &edge in &body.cell {
        number("cell", edge, edge > 0.0 && edge.is_finite());
    }
    for i in 0..count {
        let volume = body.volumes[i];
        let enough = volume > 0.0 || (volume == 0.0 && body.clamped[i]);
        if !(enough && volume.is_finite() && body.positions[i].iter().all(|x| x.is_finite())) {
            mistakes.push(ErrorKind::Particle { body: index, particle: first + i, volume });
            return;
        }
    }
}
