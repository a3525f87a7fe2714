//! Free-surface detection and the smoothing coefficient of Eqs. (16)–(17), normals (25)–(26), and pockets of
//! fluid without a surface.
//!
//! A particle that was not on the surface comes onto it where `∇·r` falls below 1.52 (in space 2.28), one
//! that was leaves it above 1.6 (2.4): with one threshold for both, particles just below the surface go on
//! and off it, and their pressure with them. `docs/fluid.md` has the errors of the alternatives.

use crate::isph::options::Options;
use crate::particles::class::SurfaceClass;
use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::{Matrix, Vector};

/// Below this α a particle's pressure is known.
pub const KNOWN: f64 = 1e-3;

/// The surface as detected.
#[derive(Clone, Debug, Default)]
pub struct Surface<const D: usize> {
    /// α of Eq. (17), 0 on the surface to 1 inside.
    pub alpha: Vec<f64>,
    /// Whether the pressure is unknown.
    pub free: Vec<bool>,
    /// Classes.
    pub classes: Vec<SurfaceClass>,
    /// Outward unit normals of surface and near-surface particles, zero elsewhere.
    pub normals: Vec<Vector<D>>,
    /// Whether a particle belongs to a pocket: a connected body of fluid in which no pressure is known.
    pub in_pocket: Vec<bool>,
    /// Number of particles in pockets.
    pub pocket_particles: usize,
    stack: Vec<u32>,
}

/// α of Eq. (17), its cosine's argument completed by the factor π that the paper's text lacks.
///
/// `divergence` is `∇·r/D`, the thresholds are in the same unit.
pub fn smoothing(divergence: f64, thresholds: (f64, f64)) -> f64 {
    let s = ((divergence - thresholds.0) / (thresholds.1 - thresholds.0)).clamp(0.0, 1.0);
    0.5 * (1.0 - (std::f64::consts::PI * s).cos())
}

impl<const D: usize> Surface<D> {
    /// Classifies all fluid particles, of which `before` tells the classes that they had last.
    pub fn detect(
        &mut self,
        neighbourhood: &Neighbourhood<D>,
        corrections: &[(Matrix<D>, f64)],
        positions: &[Vector<D>],
        before: &[SurfaceClass],
        options: &Options,
        smoothing_length: f64,
    ) {
        let count = positions.len();
        self.alpha.resize(count, 0.0);
        self.classes.resize(count, SurfaceClass::Interior);
        self.normals.resize(count, Vector::zeros());
        self.free.resize(count, true);
        let first = self.alpha.par_iter_mut().zip(&mut self.classes).zip(&mut self.normals);
        first.zip(&mut self.free).with_min_len(512).enumerate().for_each(
            |(a, (((alpha, class), normal), free))| {
                let sums = &neighbourhood.surroundings[a];
                let divergence = sums.moment.trace() / D as f64;
                let alone = neighbourhood.fluid.of(a).is_empty();
                *alpha = if alone { 0.0 } else { smoothing(divergence, options.surface_thresholds) };
                let was_known = matches!(before[a], SurfaceClass::Surface | SurfaceClass::Splash);
                let stays = !was_known
                    && !alone
                    && divergence > options.surface_thresholds.0 - options.surface_hysteresis;
                if stays {
                    *alpha = alpha.max(KNOWN);
                }
                *free = *alpha >= KNOWN;
                *class = match (alone, *free) {
                    (true, _) => SurfaceClass::Splash,
                    (false, false) => SurfaceClass::Surface,
                    (false, true) => SurfaceClass::Interior,
                };
                *normal = if *class == SurfaceClass::Surface {
                    let inward = corrections[a].0 * (sums.fluid_gradient + sums.boundary_gradient);
                    inward.try_normalize(0.0).map_or(Vector::zeros(), |n| -n)
                } else {
                    Vector::zeros()
                };
            },
        );
        // Neighbours of the surface take the normal of the nearest surface particle.
        let surface = |b: u32| !self.free[b as usize];
        let near: Vec<(u32, u32)> = (0..count as u32)
            .into_par_iter()
            .with_min_len(512)
            .filter(|&a| self.free[a as usize])
            .filter_map(|a| {
                let at = positions[a as usize];
                let mut nearest = (smoothing_length, None);
                for &b in neighbourhood.fluid.of(a as usize).iter().filter(|&&b| surface(b)) {
                    let distance = neighbourhood.period.nearest(at - positions[b as usize]).norm();
                    if distance < nearest.0 {
                        nearest = (distance, Some(b));
                    }
                }
                nearest.1.map(|b| (a, b))
            })
            .collect();
        for (a, b) in near {
            self.classes[a as usize] = SurfaceClass::NearSurface;
            self.normals[a as usize] = self.normals[b as usize];
        }
        self.find_pockets(neighbourhood);
    }

    /// Whether there is fluid and no pressure of it is known: it is one pocket.
    pub fn is_closed(&self) -> bool {
        !self.free.is_empty() && self.pocket_particles == self.free.len()
    }

    /// Floods the fluid from the particles of known pressure; what stays dry is a pocket.
    fn find_pockets(&mut self, neighbourhood: &Neighbourhood<D>) {
        self.in_pocket.clear();
        self.in_pocket.extend_from_slice(&self.free);
        self.stack.clear();
        self.stack.extend((0..self.free.len() as u32).filter(|&a| !self.free[a as usize]));
        let mut dry = self.free.len() - self.stack.len();
        while let Some(a) = self.stack.pop() {
            for &b in neighbourhood.fluid.of(a as usize) {
                if self.in_pocket[b as usize] {
                    self.in_pocket[b as usize] = false;
                    dry -= 1;
                    self.stack.push(b);
                }
            }
        }
        self.pocket_particles = dry;
    }
}
