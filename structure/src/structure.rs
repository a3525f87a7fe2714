//! A structure ready to be advanced: operators built, limits known, scratch in place.

use crate::field::Field;
use crate::ganzenmuller2015::HourglassPairs;
use crate::gradient::first_order::FirstOrder;
use crate::gradient::quadratic::Quadratic;
use crate::kernels::{self, BodyPass, Fields, row};
use crate::lanes::{LANES, plus_identity};
use crate::material::{ConstitutiveLaw, with_law};
use crate::numbering::{NOBODY, Numbering};
use crate::options::Gradient;
use crate::setup::Setup;
use crate::state::{Derived, Energy, Stability, State};
use crate::stencil::Stencil;
use crate::{Error, ErrorKind, SetupError};
use sph::neighbours::{CellGrid, NeighbourList};
use sph::{Matrix, Vector};

/// A structure. It holds what never changes in a run (and scratch memory, hence `&mut` where it computes);
/// what does change is a [`State`].
#[derive(Clone, Debug)]
pub struct Structure<const D: usize> {
    pub(crate) setup: Setup<D>,
    pub(crate) numbering: Numbering,
    pub(crate) stencil: Stencil,
    pub(crate) passes: Vec<BodyPass>,
    pub(crate) fields: Fields,
    /// Reference positions, volumes, masses and clamp flags of all bodies, in the setup's order.
    pub(crate) reference: Vec<Vector<D>>,
    pub(crate) volumes: Vec<f64>,
    pub(crate) masses: Vec<f64>,
    pub(crate) clamped: Vec<bool>,
    pub(crate) interface: Vec<u32>,
    pub(crate) stable_time_step: f64,
    pub(crate) hourglass: Option<HourglassPairs<D>>,
}

impl<const D: usize> Structure<D> {
    /// Checks the setup, builds the operators in the reference configuration and computes the stable step.
    pub fn new(setup: Setup<D>) -> Result<Self, SetupError> {
        setup.check()?;
        let numbering = Numbering::new(&setup.bodies);
        let stencil = build_stencil(&setup, &numbering)?;
        let passes = (setup.bodies.iter().zip(&numbering.slices))
            .map(|(body, slices)| BodyPass {
                slices: slices.clone(),
                law: body.material.law,
                elasticity: body.material.elasticity::<D>(),
            })
            .collect();
        let basis = kernels::basis(D, setup.options.gradient);
        let mut fields = Fields::new(D, basis, stencil.margin, numbering.count());
        let bodies = &setup.bodies;
        let reference = bodies.iter().flat_map(|b| b.positions.iter().copied()).collect();
        let volumes: Vec<f64> = bodies.iter().flat_map(|b| b.volumes.iter().copied()).collect();
        let clamped: Vec<bool> = bodies.iter().flat_map(|b| b.clamped.iter().copied()).collect();
        let densities: Vec<f64> =
            bodies.iter().flat_map(|b| std::iter::repeat_n(b.density, b.positions.len())).collect();
        let masses: Vec<f64> = densities.iter().zip(&volumes).map(|(d, v)| d * v).collect();
        for (user, internal) in numbering.pairs().filter(|&(user, _)| !clamped[user]) {
            let scale = match setup.options.gradient {
                Gradient::FirstOrder => 1.0 / densities[user],
                Gradient::Quadratic => 1.0 / masses[user],
            };
            fields.scale.set(0, internal, scale);
        }
        let interface = (0..clamped.len() as u32).filter(|&i| !clamped[i as usize]).collect();
        let mut structure = Self {
            setup,
            numbering,
            stencil,
            passes,
            fields,
            reference,
            volumes,
            masses,
            clamped,
            interface,
            stable_time_step: f64::INFINITY,
            hourglass: None,
        };
        structure.hourglass = structure.build_hourglass();
        let at_rest = vec![Vector::zeros(); structure.len()];
        structure.stable_time_step = structure.stable_time_step_about(&at_rest);
        Ok(structure)
    }

    /// The setup it was made of.
    pub fn setup(&self) -> &Setup<D> {
        &self.setup
    }

    /// Number of particles, fixed ones included.
    pub fn len(&self) -> usize {
        self.reference.len()
    }

    /// Whether there are no particles (there always are).
    pub fn is_empty(&self) -> bool {
        self.reference.is_empty()
    }

    /// Reference positions `X` (m).
    pub fn reference_positions(&self) -> &[Vector<D>] {
        &self.reference
    }

    /// Reference volumes `V` (m³).
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// Masses `ρ_s V` (kg).
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Which particles are fixed.
    pub fn clamped(&self) -> &[bool] {
        &self.clamped
    }

    /// The interface particles: all that are not fixed, ascending. Loads of the fluid come in this order.
    pub fn interface_particles(&self) -> &[u32] {
        &self.interface
    }

    /// Reference density `ρ_s` (kg/m³) of a particle.
    pub fn density(&self, particle: usize) -> f64 {
        let mut first = 0;
        for body in &self.setup.bodies {
            first += body.positions.len();
            if particle < first {
                return body.density;
            }
        }
        panic!("particle {particle} of {first}");
    }

    /// The state at rest in the reference configuration at a time (s).
    pub fn state_at_rest(&self, time: f64) -> State<D> {
        State {
            time,
            positions: self.reference.clone(),
            velocities: vec![Vector::zeros(); self.len()],
            energy: Energy::default(),
            stability: Stability { strain: 0.0, step: self.stable_time_step },
        }
    }

    /// Sets the kinetic and strain energy and the stable step of a state made by hand (with initial
    /// velocities, say); the works are left as they are.
    pub fn evaluate(&mut self, state: &mut State<D>) -> Result<(), Error> {
        self.load_state(state)?;
        state.energy.kinetic = self.kinetic_energy();
        state.energy.strain = self.strain_energy();
        state.stability = self.stability(state, state.stability);
        Ok(())
    }

    /// Stresses, energy density and deformation gradient of a state; the vectors given are filled anew.
    pub fn derive(&mut self, state: &State<D>, out: &mut Derived<D>) -> Result<(), Error> {
        self.load_state(state)?;
        let count = self.len();
        out.cauchy_stress.resize(count, Matrix::zeros());
        out.von_mises.resize(count, 0.0);
        out.strain_energy_density.resize(count, 0.0);
        out.deformation_gradient.resize(count, Matrix::zeros());
        kernels::visit_gradients::<D>(
            self.setup.options.gradient,
            &self.stencil,
            &self.fields,
            |s, l, gradient_energy| {
                let pass = body_of(&self.passes, s);
                let e = &pass.elasticity;
                let (response, energy, out_of_plane) =
                    with_law!(pass.law, L => (L::respond(e, l), L::energy(e, l), L::out_of_plane(e, l)));
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
        Ok(())
    }

    /// The force (N) the clamps put on the structure in a state: what holds the internal forces of the free
    /// particles in balance.
    pub fn clamp_reaction(&mut self, state: &State<D>) -> Result<Vector<D>, Error> {
        // The pair forces cancel over all particles, so those on the fixed ones are minus those on the free
        // ones.
        let accelerations = self.internal_accelerations(state)?;
        Ok((0..self.len()).fold(Vector::zeros(), |sum, i| sum + accelerations[i] * self.masses[i]))
    }

    /// Accelerations (m/s²) of the internal forces, Eq. (42) without the external term but with the hourglass
    /// control; zero for fixed particles.
    pub fn internal_accelerations(&mut self, state: &State<D>) -> Result<Vec<Vector<D>>, Error> {
        self.load_state(state)?;
        if let Some(slice) = self.stresses() {
            return Err(self.inversion(slice, state.time));
        }
        let mut field = Field::new(D, self.stencil.margin, self.numbering.count());
        kernels::acceleration_pass(D, self.setup.options.gradient, &self.stencil, &self.fields, &mut field);
        self.add_hourglass(&mut field);
        let internal_of = self.numbering.internal_of.iter();
        Ok(internal_of.map(|&internal| field.vector::<D>(internal as usize)).collect())
    }

    /// Momentum (kg m/s) of the free particles.
    pub fn momentum(&self, state: &State<D>) -> Vector<D> {
        (0..self.len())
            .filter(|&i| !self.clamped[i])
            .fold(Vector::zeros(), |sum, i| sum + state.velocities[i] * self.masses[i])
    }

    /// Internal order from a state.
    pub(crate) fn load_state(&mut self, state: &State<D>) -> Result<(), Error> {
        for (what, given) in
            [("state.positions", state.positions.len()), ("state.velocities", state.velocities.len())]
        {
            if given != self.len() {
                return Err(Error::Length { what, given, expected: self.len() });
            }
        }
        self.fields.step.clear();
        for (user, internal) in self.numbering.pairs() {
            let displacement = state.positions[user] - self.reference[user];
            let velocity = if self.clamped[user] { Vector::zeros() } else { state.velocities[user] };
            let finite = |v: &Vector<D>| v.iter().all(|c| c.is_finite());
            if !(finite(&displacement) && finite(&velocity)) {
                return Err(Error::NotFinite { particle: user, time: state.time });
            }
            self.fields.displacement.set_vector(internal, &displacement);
            for i in 0..D {
                self.fields.step.set(row::START_DISPLACEMENT * D + i, internal, displacement[i]);
                self.fields.step.set(row::START_VELOCITY * D + i, internal, velocity[i]);
                self.fields.step.set(row::STAGE_VELOCITY * D + i, internal, velocity[i]);
            }
        }
        Ok(())
    }

    /// Positions, velocities and energies to a state from the internal order, the works added to those of
    /// `from`.
    pub(crate) fn store_state(&mut self, from: &State<D>, to: &mut State<D>, dt: f64) -> Result<(), Error> {
        to.time = from.time + dt;
        to.positions.resize(self.len(), Vector::zeros());
        to.velocities.resize(self.len(), Vector::zeros());
        for (user, internal) in self.numbering.pairs() {
            let row =
                |r: usize| -> Vector<D> { Vector::from_fn(|i, _| self.fields.step.get(r * D + i, internal)) };
            let (displacement, velocity) = (row(row::START_DISPLACEMENT), row(row::START_VELOCITY));
            if !displacement.iter().chain(velocity.iter()).all(|c| c.is_finite()) {
                return Err(Error::NotFinite { particle: user, time: to.time });
            }
            to.positions[user] = self.reference[user] + displacement;
            to.velocities[user] = velocity;
        }
        to.energy.kinetic = self.kinetic_energy();
        to.energy.strain = self.strain_energy();
        to.energy.load_work = from.energy.load_work + self.work(row::WORK);
        to.energy.dissipated = from.energy.dissipated + self.work(row::DISSIPATION);
        to.stability = self.stability(to, from.stability);
        Ok(())
    }

    /// Conjugates of the stage's displacements; the first slice with an inverted particle.
    pub(crate) fn stresses(&mut self) -> Option<usize> {
        kernels::stress_pass(D, self.setup.options.gradient, &self.stencil, &self.passes, &mut self.fields)
    }

    /// The error for a slice in which `J` is not positive.
    pub(crate) fn inversion(&self, slice: usize, time: f64) -> Error {
        let mut found = None;
        kernels::visit_gradients::<D>(self.setup.options.gradient, &self.stencil, &self.fields, |s, l, _| {
            if s == slice {
                let jacobian = crate::lanes::cofactor(&plus_identity(l)).1;
                found = (0..LANES)
                    .find(|&lane| jacobian.0[lane].is_nan() || jacobian.0[lane] <= 0.0)
                    .map(|lane| (self.numbering.user_of[s * LANES + lane], jacobian.0[lane]));
            }
        });
        let (user, jacobian) = found.unwrap_or((0, f64::NAN));
        let particle = user as usize;
        let position = self.reference[particle].as_slice().to_vec();
        if jacobian.is_nan() {
            Error::NotFinite { particle, time }
        } else {
            Error::Inverted { particle, time, jacobian, position }
        }
    }

    fn kinetic_energy(&self) -> f64 {
        let internal_of = &self.numbering.internal_of;
        sph::parallel::sum(self.len(), |user| {
            let a = internal_of[user] as usize;
            let square: f64 =
                (0..D).map(|i| self.fields.step.get(row::START_VELOCITY * D + i, a).powi(2)).sum();
            0.5 * self.masses[user] * square
        })
    }

    fn work(&self, row: usize) -> f64 {
        let internal_of = &self.numbering.internal_of;
        sph::parallel::sum(self.len(), |user| {
            let a = internal_of[user] as usize;
            self.masses[user] * (0..D).map(|i| self.fields.step.get(row * D + i, a)).sum::<f64>()
        })
    }

    fn strain_energy(&mut self) -> f64 {
        let (gradient, stencil) = (self.setup.options.gradient, &self.stencil);
        kernels::energy_pass(D, gradient, stencil, &self.passes, &mut self.fields);
        let internal_of = &self.numbering.internal_of;
        sph::parallel::sum(self.len(), |user| {
            self.volumes[user] * self.fields.energy.get(0, internal_of[user] as usize)
        })
    }
}

fn body_of(passes: &[BodyPass], slice: usize) -> &BodyPass {
    let index = passes.partition_point(|p| p.slices.end <= slice);
    &passes[index]
}

/// `√(3/2 s : s)` of the deviator, with the stress out of the plane in two dimensions.
fn von_mises<const D: usize>(sigma: &Matrix<D>, out_of_plane: f64) -> f64 {
    let third = if D == 2 { out_of_plane } else { 0.0 };
    let mean = (sigma.trace() + third) / 3.0;
    let mut square = if D == 2 { (third - mean).powi(2) } else { 0.0 };
    for i in 0..D {
        for j in 0..D {
            square += (sigma[(i, j)] - if i == j { mean } else { 0.0 }).powi(2);
        }
    }
    (1.5 * square).sqrt()
}

/// Neighbours and weights of all bodies.
fn build_stencil<const D: usize>(setup: &Setup<D>, numbering: &Numbering) -> Result<Stencil, SetupError> {
    let mut stencil = Stencil::default();
    let ratio = setup.options.smoothing_ratio;
    let mut first_user = 0;
    for (body, slices) in setup.bodies.iter().zip(&numbering.slices) {
        let first = slices.start * LANES;
        let members: Vec<Option<usize>> = numbering.user_of[first..slices.end * LANES]
            .iter()
            .map(|&user| (user != NOBODY).then(|| user as usize - first_user))
            .collect();
        // A neighbour on the very edge of the support has no weight; round-off must not decide whether it is
        // in the list.
        let radius = 2.0 * ratio * body.spacing() * (1.0 - 1e-9);
        let mut list = NeighbourList::default();
        list.rebuild(&body.positions, &CellGrid::new(&body.positions, radius), &body.positions);
        let rows: Vec<Vec<u32>> = members
            .iter()
            .map(|member| {
                let mut row: Vec<u32> = member.map_or(Vec::new(), |m| {
                    let neighbours = list.of(m).iter();
                    neighbours.map(|&j| numbering.internal_of[first_user + j as usize]).collect()
                });
                row.sort_unstable();
                row
            })
            .collect();
        let pushed = match setup.options.gradient {
            Gradient::FirstOrder => {
                stencil.push(slices.clone(), &rows, &FirstOrder::new(body, ratio, first, &members))
            }
            Gradient::Quadratic => {
                stencil.push(slices.clone(), &rows, &Quadratic::new(body, ratio, first, &members))
            }
        };
        pushed.map_err(|internal| SetupError {
            mistakes: vec![ErrorKind::Neighbours {
                particle: numbering.user_of[internal] as usize,
                neighbours: rows[internal - first].len(),
            }],
        })?;
        first_user += body.positions.len();
    }
    Ok(stencil)
}
