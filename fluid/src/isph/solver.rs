//! ISPH as a fluid: what it is made of, and how long a step may be.

use crate::boundaries::period::Period;
use crate::boundaries::sampling::Sampling;
use crate::boundaries::walls::Walls;
use crate::error::Error;
use crate::interface::{InterfaceInput, InterfaceOutput, InterfaceParticles};
use crate::isph::options::{LostParticles, Options};
use crate::isph::state::{Memory, State};
use crate::isph::step::scratch::Scratch;
use crate::isph::viscosity::Viscosity;
use crate::method::Fluid;
use crate::particles::accounting;
use crate::properties::FluidProperties;
use crate::report::StepReport;
use sph::kernel::CubicSpline;
use sph::{Vector, parallel};

/// The fluid solver: what does not change, and memory for a step. It remembers nothing from step to step; all
/// memory is in [`State`].
pub struct Isph<const D: usize> {
    pub(crate) properties: FluidProperties<D>,
    pub(crate) options: Options,
    pub(crate) kernel: CubicSpline<D>,
    pub(crate) walls: Walls<D>,
    pub(crate) interface: InterfaceParticles<D>,
    pub(crate) sampling: Sampling,
    /// Share of `1/ρ_s` (m³/kg) by which each interface particle yields; empty where none does.
    pub(crate) compliance: Vec<f64>,
    pub(crate) reference_velocity: f64,
    pub(crate) lattice_concentration: f64,
    pub(crate) scratch: Scratch<D>,
    pub(crate) output: InterfaceOutput<D>,
}

impl<const D: usize> Fluid<D> for Isph<D> {
    const METHOD: &'static str = "ISPH";
    type Options = Options;
    type Memory = Memory<D>;

    /// `initial` sets the scale of velocity (`√(gH)`) when the options give none.
    fn new(
        properties: FluidProperties<D>,
        options: Options,
        walls: Walls<D>,
        interface: InterfaceParticles<D>,
        initial: &State<D>,
    ) -> Result<Self, Error> {
        for (key, value) in [
            ("fluid.density", properties.density),
            ("fluid.spacing", properties.spacing),
            ("fluid.particle_volume", properties.particle_volume),
            ("options.smoothing_ratio", options.smoothing_ratio),
            ("options.courant", options.courant),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::Setting { key, value: value.to_string(), remedy: "it must be positive" });
            }
        }
        let expected = interface.volumes.len();
        for (field, found) in
            [("densities", interface.densities.len()), ("positions", interface.positions.len())]
        {
            if found != expected {
                return Err(Error::InterfaceLength { field, found, expected });
            }
        }
        let kernel = CubicSpline::new(options.smoothing_ratio * properties.spacing);
        let period = Period::new(&properties.periodic, &properties.domain);
        if (0..D).any(|i| properties.periodic[i] && period.length(i) < 2.0 * kernel.support()) {
            return Err(Error::Setting {
                key: "fluid.periodic",
                value: format!("{:?} in {:?}", properties.periodic, properties.domain),
                remedy: "a domain that repeats must be at least four smoothing lengths long",
            });
        }
        let mut scratch = Scratch::default();
        scratch.neighbourhood.period = period;
        let reference_velocity = options
            .reference_velocity
            .unwrap_or_else(|| accounting::reference_velocity(&properties, initial));
        let sampling = Sampling::new(&interface, properties.spacing, |at| walls.fill(at));
        let compliance = if options.compliance {
            let share = options.structure_velocity.compliance();
            interface.densities.iter().map(|&rho| if rho > 0.0 { share / rho } else { 0.0 }).collect()
        } else {
            Vec::new()
        };
        let lattice_concentration = accounting::lattice_concentration(&kernel, properties.spacing);
        Ok(Self {
            properties,
            options,
            kernel,
            walls,
            interface,
            sampling,
            compliance,
            reference_velocity,
            lattice_concentration,
            scratch,
            output: InterfaceOutput::default(),
        })
    }

    fn properties(&self) -> &FluidProperties<D> {
        &self.properties
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn walls(&self) -> &Walls<D> {
        &self.walls
    }

    fn smoothing_length(&self) -> f64 {
        self.kernel.smoothing_length()
    }

    /// Eq. (49) with the fastest of fluid, structure and walls that move in the step, growth, and `h²/8ν`
    /// where viscosity cannot be implicit.
    fn stable_step(&self, state: &State<D>, time: f64, structure_velocities: &[Vector<D>]) -> f64 {
        let h = self.smoothing_length();
        let fastest = parallel::max(state.len(), self.reference_velocity, |a| state.velocities[a].norm());
        let fastest = structure_velocities.iter().map(Vector::norm).fold(fastest, f64::max);
        let mut dt = self.options.courant * h / fastest.max(1e-12);
        if state.last_dt > 0.0 {
            dt = dt.min(self.options.time_step_growth * state.last_dt);
        }
        dt = dt.min(self.viscosity().longest_step());
        self.walls.longest_step(time, dt, self.options.courant * h)
    }

    fn start(
        &mut self,
        initial: &mut State<D>,
        time: f64,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
    ) -> Result<(), Error> {
        rayon::scope(|_| self.find_initial_pressure(initial, (time, dt), structure))
    }

    fn step(
        &mut self,
        accepted: &State<D>,
        time: f64,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
        trial: &mut State<D>,
    ) -> Result<StepReport<D>, Error> {
        // Into the pool once a step: from outside, each of its hundred passes would wait for a worker to wake
        // up and for its answer.
        rayon::scope(|_| self.step_watched(accepted, time, dt, structure, trial, |_| ()))
    }

    fn refuses_lost_particles(&self) -> bool {
        self.options.lost_particles == LostParticles::Refused
    }

    fn output(&self) -> &InterfaceOutput<D> {
        &self.output
    }

    fn output_mut(&mut self) -> &mut InterfaceOutput<D> {
        &mut self.output
    }

    fn wall_forces(&self) -> &[Vector<D>] {
        &self.scratch.wall_forces.forces
    }

    fn wall_moments(&self) -> &[[f64; 3]] {
        &self.scratch.wall_forces.moments
    }

    fn failed_solve<'a>(&'a self, trial: &'a State<D>) -> Vec<(&'static str, &'a [f64])> {
        vec![
            ("pressure_where_stopped", &trial.pressures),
            ("position_potential_where_stopped", &trial.memory.position_potentials),
            ("residual", self.scratch.solver.residual()),
        ]
    }

    fn save(state: &State<D>) -> Vec<u8> {
        state.to_bytes()
    }

    fn restore(bytes: &[u8]) -> Result<State<D>, Error> {
        State::from_bytes(bytes)
    }
}

impl<const D: usize> Isph<D> {
    /// The viscosities of fluid and method. Between approaching particles there is that which the method asks
    /// for, or the fluid's own where it is more.
    pub(crate) fn viscosity(&self) -> Viscosity {
        let laminar = self.properties.kinematic_viscosity;
        let smoothing_length = self.smoothing_length();
        let least = self.options.artificial_viscosity * smoothing_length * self.reference_velocity;
        Viscosity {
            laminar,
            artificial: (least - laminar).max(0.0),
            smagorinsky: self.options.smagorinsky,
            operator: self.options.viscosity_operator,
            smoothing_length,
        }
    }
}
