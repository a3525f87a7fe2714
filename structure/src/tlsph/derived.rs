//! What a state means: stresses, forces, energies of its particles.

use crate::error::Error;
use crate::lanes::{LANES, plus_identity};
use crate::materials::{ConstitutiveLaw, von_mises, with_law};
use crate::state::{Derived, State};
use crate::tlsph::field::Field;
use crate::tlsph::kernels::{self, BodyPass};
use crate::tlsph::numbering::NOBODY;
use crate::tlsph::total_lagrangian::TotalLagrangian;
use sph::{Matrix, Vector};

impl<const D: usize> TotalLagrangian<D> {
    /// Stresses, energy density and deformation gradient of the stage's displacements.
    pub(super) fn observe(&mut self, out: &mut Derived<D>) {
        let gradient = self.particles.setup.options.gradient;
        kernels::average_dilatations(D, gradient, &self.stencil, &mut self.passes, &self.fields);
        let count = self.particles.len();
        out.cauchy_stress.resize(count, Matrix::zeros());
        out.von_mises.resize(count, 0.0);
        out.strain_energy_density.resize(count, 0.0);
        out.deformation_gradient.resize(count, Matrix::zeros());
        kernels::visit_gradients::<D>(
            self.particles.setup.options.gradient,
            &self.stencil,
            &self.fields,
            |s, l, gradient_energy| {
                let pass = body_of(&self.passes, s);
                let e = &pass.elasticity;
                let (volumetric, patch_energy) = pass.volumetric(s);
                let (response, energy, out_of_plane) = with_law!(pass.law, L => (
                    L::respond(e, l, volumetric),
                    L::energy(e, l) + patch_energy,
                    L::out_of_plane(e, l, volumetric),
                ));
                let f = plus_identity(l);
                for lane in 0..LANES {
                    let user = self.numbering.user_of[s * LANES + lane];
                    if user == NOBODY {
                        continue;
                    }
                    let user = user as usize;
                    let f: Matrix<D> = Matrix::from_fn(|i, j| f[i][j].0[lane]);
                    let p: Matrix<D> = Matrix::from_fn(|i, j| response.first_piola[i][j].0[lane]);
                    let sigma = p * f.transpose() / response.jacobian.0[lane];
                    out.deformation_gradient[user] = f;
                    out.cauchy_stress[user] = sigma;
                    out.strain_energy_density[user] = energy.0[lane] + gradient_energy.0[lane];
                    out.von_mises[user] = von_mises(&sigma, out_of_plane.0[lane]);
                }
            },
        );
    }

    /// The force (N) the clamps put on the structure in a state: what holds the internal forces of the free
    /// particles in balance.
    pub fn clamp_reaction(&mut self, state: &State<D>) -> Result<Vector<D>, Error> {
        // The pair forces cancel over all particles, so those on the fixed ones are minus those on the free
        // ones.
        let accelerations = self.internal_accelerations(state)?;
        Ok((0..self.particles.len())
            .fold(Vector::zeros(), |sum, i| sum + accelerations[i] * self.particles.masses[i]))
    }

    /// Accelerations (m/s²) of the internal forces, Eq. (42) without the external term but with the hourglass
    /// control; zero for fixed particles.
    pub fn internal_accelerations(&mut self, state: &State<D>) -> Result<Vec<Vector<D>>, Error> {
        self.load_state(state)?;
        if let Some(slice) = self.stresses() {
            return Err(self.inversion(slice, state.time));
        }
        let mut field = Field::new(D, self.stencil.margin, self.numbering.count());
        self.accelerations(&mut field);
        let internal_of = self.numbering.internal_of.iter();
        Ok(internal_of.map(|&internal| field.vector::<D>(internal as usize)).collect())
    }
}

fn body_of(passes: &[BodyPass], slice: usize) -> &BodyPass {
    let index = passes.partition_point(|p| p.slices.end <= slice);
    &passes[index]
}
