//! The beams that the benchmarks step: clamped, elastic, under gravity, of any number of particles, on a
//! lattice or not.

use sph::Vector;
use structure::{Body, Gradient, Law, Material, Options, Plane, Setup, Side, Solid, TotalLagrangian};

/// How the particles lie, which decides how the time step finds neighbours and weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// On a lattice: runs of neighbours, and one set of weights for all slices that look alike.
    Lattice,
    /// The same particles turned by 15° against the axes that they are sorted by: an index and weights for
    /// each pair.
    General,
}

impl Path {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Lattice, Self::General];

    /// As benchmarks are called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lattice => "lattice",
            Self::General => "general",
        }
    }
}

/// As benchmarks are called.
pub fn name(gradient: Gradient) -> &'static str {
    match gradient {
        Gradient::FirstOrder => "first-order",
        Gradient::Quadratic => "quadratic",
    }
}

/// A beam of `layers` times `columns` free particles and the clamp's.
pub fn beam(gradient: Gradient, path: Path, [layers, columns]: [usize; 2]) -> TotalLagrangian<2> {
    let spacing = 1e-3;
    let material = Material::new(Law::AlmansiHooke, 12e6, 0.4, Plane::Strain);
    let high = Vector::from([columns as f64, layers as f64]) * spacing;
    let ratio = gradient.default_smoothing_ratio();
    let mut body = Body::block(Vector::zeros(), high, spacing, material, 1100.0);
    body = body.clamp(0, Side::Low, gradient, ratio);
    if path == Path::General {
        let (sine, cosine) = 15.0_f64.to_radians().sin_cos();
        for x in &mut body.positions {
            *x = Vector::from([cosine * x.x - sine * x.y, sine * x.x + cosine * x.y]);
        }
    }
    let mut setup = Setup::new(vec![body]);
    setup.options = Options::of(gradient);
    setup.gravity = Vector::from([0.0, -9.81]);
    TotalLagrangian::new(setup).expect("the beam is sound")
}
