//! Hourglass control of Ganzenmüller 2015 ("An hourglass control algorithm for Lagrangian smooth particle
//! hydrodynamics", Eqs. (18)–(22)), an option, off by default: neither gradient needs it in the cases of this
//! workspace.
//!
//! Where the distance of a pair is not what the deformation gradients of its ends predict,
//! `δ_a = (F_a X_ab − x_ab)·x_ab/|x_ab|` with `X_ab = X_b − X_a`, a force along the pair resists:
//! `f_a = −½ ζ E Σ_b V_a V_b W_ab/|X_ab|² (δ_a + δ_b) x_ab/|x_ab|`, equal and opposite on the pair. A linear
//! deformation feels nothing.

use crate::field::Field;
use crate::kernels;
use crate::lanes::LANES;
use crate::structure::Structure;
use sph::kernel::CubicSpline;
use sph::neighbours::{CellGrid, NeighbourList};
use sph::{Matrix, Vector};

/// Pairs of the control, by user indices.
#[derive(Clone, Debug, Default)]
pub(crate) struct HourglassPairs<const D: usize> {
    starts: Vec<u32>,
    others: Vec<u32>,
    /// `½ ζ E V_b W_ab/(ρ_s |X_ab|²)` (1/s² a metre of `δ`).
    stiffness: Vec<f64>,
    gradients: Vec<Matrix<D>>,
}

impl<const D: usize> Structure<D> {
    /// Builds the pairs if the option is on.
    pub(crate) fn build_hourglass(&self) -> Option<HourglassPairs<D>> {
        let coefficient = self.setup.options.hourglass;
        if coefficient == 0.0 {
            return None;
        }
        let mut pairs = HourglassPairs { starts: vec![0], ..Default::default() };
        let mut first = 0;
        for body in &self.setup.bodies {
            let kernel = CubicSpline::<D>::new(self.setup.options.smoothing_ratio * body.spacing());
            let mut list = NeighbourList::default();
            list.rebuild(&body.positions, &CellGrid::new(&body.positions, kernel.support()), &body.positions);
            for a in 0..body.positions.len() {
                for &b in list.of(a) {
                    let distance = (body.positions[b as usize] - body.positions[a]).norm();
                    pairs.others.push(first + b);
                    pairs.stiffness.push(
                        0.5 * coefficient
                            * body.material.youngs_modulus
                            * body.volumes[b as usize]
                            * kernel.value(distance)
                            / (body.density * distance * distance),
                    );
                }
                pairs.starts.push(pairs.others.len() as u32);
            }
            first += body.positions.len() as u32;
        }
        pairs.gradients = vec![Matrix::identity(); self.len()];
        Some(pairs)
    }

    /// Adds the control's accelerations of the free particles in the stage's displacements.
    pub(crate) fn add_hourglass(&mut self, out: &mut Field) {
        let Some(mut pairs) = self.hourglass.take() else { return };
        kernels::visit_gradients::<D>(self.setup.options.gradient, &self.stencil, &self.fields, |s, l, _| {
            for lane in 0..LANES {
                let user = self.numbering.user_of[s * LANES + lane] as usize;
                if let Some(f) = pairs.gradients.get_mut(user) {
                    *f = Matrix::identity() + Matrix::from_fn(|i, j| l[i][j].0[lane]);
                }
            }
        });
        let displacement = |user: usize| -> Vector<D> {
            self.fields.displacement.vector(self.numbering.internal_of[user] as usize)
        };
        for (a, internal) in self.numbering.pairs().filter(|&(user, _)| !self.clamped[user]) {
            let mut acceleration = out.vector::<D>(internal);
            let own = displacement(a);
            for n in pairs.starts[a] as usize..pairs.starts[a + 1] as usize {
                let b = pairs.others[n] as usize;
                let reference = self.reference[b] - self.reference[a];
                let current = reference + displacement(b) - own;
                let length = current.norm();
                if length == 0.0 {
                    continue;
                }
                let direction = current / length;
                let predicted = (pairs.gradients[a] + pairs.gradients[b]) * reference;
                let error = predicted.dot(&direction) - 2.0 * length;
                acceleration -= direction * (pairs.stiffness[n] * error);
            }
            out.set_vector(internal, &acceleration);
        }
        self.hourglass = Some(pairs);
    }
}
