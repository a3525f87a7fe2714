//! A solid by the total-Lagrangian method: operators built, limits known, scratch in place.

use crate::contact::Contact;
use crate::error::{Error, ErrorKind, SetupError};
use crate::lanes::LANES;
use crate::loads::Load;
use crate::options::Gradient;
use crate::particles::Particles;
use crate::setup::Setup;
use crate::solid::Solid;
use crate::state::{Derived, Energy, Report, Stability, State};
use crate::tlsph::field::Field;
use crate::tlsph::ganzenmuller2015::HourglassPairs;
use crate::tlsph::gradient::first_order::FirstOrder;
use crate::tlsph::gradient::quadratic::Quadratic;
use crate::tlsph::kernels::{self, BodyPass, Fields};
use crate::tlsph::numbering::Numbering;
use crate::tlsph::patches::Patches;
use crate::tlsph::stencil::Stencil;
use crate::tlsph::tasks;
use sph::Vector;
use sph::neighbours::{CellGrid, NeighbourList};

/// A solid by TLSPH.
#[derive(Clone, Debug)]
pub struct TotalLagrangian<const D: usize> {
    pub(super) particles: Particles<D>,
    pub(super) numbering: Numbering,
    pub(super) stencil: Stencil,
    pub(super) passes: Vec<BodyPass>,
    pub(super) fields: Fields,
    /// External accelerations (m/s²) of all particles in the setup's order, zero for fixed ones.
    pub(super) external: Vec<Vector<D>>,
    pub(super) stable_time_step: f64,
    /// Slices in which fixed particles move by a law.
    pub(super) clamp_slices: Vec<usize>,
    /// External accelerations (m/s²) of particles in contact without it, by internal index, for one stage.
    pub(super) without_contact: Vec<(usize, Vector<D>)>,
    /// None where nothing may meet.
    pub(super) contact: Option<Contact<D>>,
    hourglass: Option<HourglassPairs<D>>,
}

impl<const D: usize> Solid<D> for TotalLagrangian<D> {
    const METHOD: &'static str = "TLSPH";

    fn new(setup: Setup<D>) -> Result<Self, SetupError> {
        let particles = Particles::new(setup)?;
        let setup = &particles.setup;
        let numbering = Numbering::new(&setup.bodies);
        let passes = build_passes(setup, &numbering);
        let stencil = build_stencil(setup, &numbering, &passes)?;
        let basis = kernels::basis(D, setup.options.gradient);
        let mut fields = Fields::new(D, basis, stencil.margin, numbering.count());
        for (user, internal) in numbering.pairs().filter(|&(user, _)| !particles.clamped[user]) {
            let scale = match setup.options.gradient {
                Gradient::FirstOrder => 1.0 / particles.densities[user],
                Gradient::Quadratic => 1.0 / particles.masses[user],
            };
            fields.scale.set(0, internal, scale);
        }
        let moving: Vec<usize> = setup.motions.iter().flat_map(|m| m.particles.iter().copied()).collect();
        for &user in &moving {
            let factor = match setup.options.gradient {
                Gradient::FirstOrder => particles.volumes[user],
                Gradient::Quadratic => 1.0,
            };
            fields.clamp_scale.set(0, numbering.internal_of[user] as usize, factor);
        }
        let clamp_slices = numbering.slices_of(&moving);
        let hourglass = HourglassPairs::new(setup);
        let at_rest = vec![Vector::zeros(); particles.len()];
        let mut solid = Self {
            particles,
            numbering,
            stencil,
            passes,
            fields,
            external: at_rest.clone(),
            stable_time_step: f64::INFINITY,
            clamp_slices,
            without_contact: Vec::new(),
            contact: None,
            hourglass,
        };
        let omega = solid.largest_frequency(&at_rest);
        solid.stable_time_step = solid.stable_step(omega);
        solid.contact = Contact::new(&solid.particles, omega);
        Ok(solid)
    }

    fn particles(&self) -> &Particles<D> {
        &self.particles
    }

    fn state_at_rest(&self, time: f64) -> State<D> {
        let mut state = State {
            time,
            positions: self.particles.reference_positions.clone(),
            velocities: vec![Vector::zeros(); self.particles.len()],
            energy: Energy::default(),
            stability: Stability { strain: 0.0, step: self.stable_time_step },
            sticks: Vec::new(),
        };
        self.particles.put_clamps(&mut state);
        state
    }

    fn evaluate(&mut self, state: &mut State<D>) -> Result<(), Error> {
        self.load_state(state)?;
        state.energy.kinetic = self.kinetic_energy();
        state.energy.strain = self.strain_energy();
        state.energy.contact = self.contact_energy(state)?;
        state.stability = self.stability(state, state.stability);
        Ok(())
    }

    fn advance(
        &mut self,
        from: &State<D>,
        to: &mut State<D>,
        dt: f64,
        sub_steps: usize,
        load: &Load<D>,
    ) -> Result<Report, Error> {
        if tasks::is_shared(self.stencil.slices.len()) {
            // Into the pool once per window: from outside, each pass would wait for a worker to wake up and
            // for its answer.
            rayon::scope(|_| self.solve(from, to, dt, sub_steps, load))
        } else {
            self.solve(from, to, dt, sub_steps, load)
        }
    }

    fn derive(&mut self, state: &State<D>, out: &mut Derived<D>) -> Result<(), Error> {
        self.load_state(state)?;
        self.observe(out);
        Ok(())
    }
}

impl<const D: usize> TotalLagrangian<D> {
    /// Conjugates of the stage's displacements; the first slice with an inverted particle.
    pub(super) fn stresses(&mut self) -> Option<usize> {
        let gradient = self.particles.setup.options.gradient;
        kernels::stress_pass(D, gradient, &self.stencil, &mut self.passes, &mut self.fields)
    }

    /// Internal accelerations (m/s²) of the stage from its conjugates, the hourglass control's among them;
    /// zero for fixed particles.
    pub(super) fn accelerations(&mut self, out: &mut Field) {
        kernels::acceleration_pass(
            D,
            self.particles.setup.options.gradient,
            &self.stencil,
            &self.fields,
            out,
        );
        if let Some(pairs) = &mut self.hourglass {
            pairs.add(&self.particles, &self.numbering, &self.stencil, &self.fields, out);
        }
    }

    /// Whether external accelerations change between two times (s) of a window. Those of the hourglass
    /// control are among them, and so its work is among that of the loads.
    pub(super) fn load_varies(&self, load: &Load<D>, from: f64, to: f64) -> bool {
        self.hourglass.is_some() || self.particles.load_varies(load, from, to)
    }

    /// Whether there is any external acceleration.
    pub(super) fn is_loaded(&self, load: &Load<D>) -> bool {
        self.hourglass.is_some() || self.particles.is_loaded(load)
    }

    /// Fills the external accelerations at a time (s), `fraction` of the window being over.
    pub(super) fn fill_external(&mut self, load: &Load<D>, time: f64, fraction: f64) {
        self.particles.accelerate(load, time, fraction, &mut self.external);
        for &user in &self.particles.free {
            let internal = self.numbering.internal_of[user as usize] as usize;
            self.fields.external.set_vector(internal, &self.external[user as usize]);
        }
        if let Some(pairs) = &mut self.hourglass {
            let mut field = std::mem::take(&mut self.fields.external);
            pairs.add(&self.particles, &self.numbering, &self.stencil, &self.fields, &mut field);
            self.fields.external = field;
        }
    }
}

/// Law and constants of all bodies, and patches of those that would lock without.
fn build_passes<const D: usize>(setup: &Setup<D>, numbering: &Numbering) -> Vec<BodyPass> {
    let mut first_user = 0;
    let mut passes = Vec::new();
    for (body, slices) in setup.bodies.iter().zip(&numbering.slices) {
        let mut elasticity = body.material.elasticity::<D>();
        if setup.options.gradient == Gradient::Quadratic {
            elasticity = elasticity.with_patches();
        }
        let patches = (elasticity.patch_lambda > 0.0)
            .then(|| Patches::new(body, &numbering.members(slices, first_user)));
        passes.push(BodyPass { slices: slices.clone(), law: body.material.law, elasticity, patches });
        first_user += body.positions.len();
    }
    passes
}

/// Neighbours and weights of all bodies.
fn build_stencil<const D: usize>(
    setup: &Setup<D>,
    numbering: &Numbering,
    passes: &[BodyPass],
) -> Result<Stencil, SetupError> {
    let mut stencil = Stencil::default();
    let ratio = setup.options.smoothing_ratio;
    let mut first_user = 0;
    for (body, pass) in setup.bodies.iter().zip(passes) {
        let slices = &pass.slices;
        let first = slices.start * LANES;
        let members = numbering.members(slices, first_user);
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
                let operator = Quadratic::new(body, pass.elasticity, ratio, first, &members);
                stencil.push(slices.clone(), &rows, &operator)
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
