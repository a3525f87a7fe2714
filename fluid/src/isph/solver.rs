//! The fluid as a whole: what it is made of, and how long a step may be.

use crate::boundaries::period::Period;
use crate::boundaries::walls::Walls;
use crate::error::Error;
use crate::interface::{InterfaceOutput, InterfaceParticles};
use crate::isph::options::Options;
use crate::isph::state::State;
use crate::isph::step::Scratch;
use crate::particles::accounting;
use sph::kernel::CubicSpline;
use sph::{Vector, parallel};

/// What a fluid is and where.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidProperties<const D: usize> {
    /// Density ρ (kg/m³).
    pub density: f64,
    /// Laminar kinematic viscosity ν (m²/s).
    pub kinematic_viscosity: f64,
    /// Gravity (m/s²).
    pub gravity: Vector<D>,
    /// Particle spacing Δx (m).
    pub spacing: f64,
    /// Volume of each particle (m³).
    pub particle_volume: f64,
    /// The domain's lowest and highest corner (m): particles outside have left.
    pub domain: (Vector<D>, Vector<D>),
    /// Axes along which the domain repeats.
    pub periodic: [bool; D],
}

/// The fluid solver: what does not change, and memory for a step. It remembers nothing from step to step; all
/// memory is in [`State`].
pub struct Fluid<const D: usize> {
    pub(crate) properties: FluidProperties<D>,
    pub(crate) options: Options,
    pub(crate) kernel: CubicSpline<D>,
    pub(crate) walls: Walls<D>,
    pub(crate) interface: InterfaceParticles,
    pub(crate) interface_spacings: Vec<f64>,
    pub(crate) compliance: Vec<f64>,
    pub(crate) reference_velocity: f64,
    pub(crate) lattice_concentration: f64,
    pub(crate) scratch: Scratch<D>,
    /// What the structure gets of the last step.
    pub output: InterfaceOutput<D>,
}

impl<const D: usize> Fluid<D> {
    /// A fluid between walls and interface particles; `initial` sets the scale of velocity (`√(gH)`) when the
    /// options give none.
    ///
    /// # Errors
    /// [`Error::Setting`] for values that cannot be.
    pub fn new(
        properties: FluidProperties<D>,
        options: Options,
        walls: Walls<D>,
        interface: InterfaceParticles,
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
        if interface.volumes.len() != interface.densities.len() {
            let (found, expected) = (interface.densities.len(), interface.volumes.len());
            return Err(Error::InterfaceLength { field: "densities", found, expected });
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
        let interface_spacings = interface.volumes.iter().map(|v| v.powf(1.0 / D as f64)).collect();
        let compliance = if options.compliance {
            let share = options.structure_velocity.compliance();
            interface.densities.iter().map(|rho| share / rho).collect()
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
            interface_spacings,
            compliance,
            reference_velocity,
            lattice_concentration,
            scratch,
            output: InterfaceOutput::default(),
        })
    }

    /// Smoothing length `h` (m).
    pub fn smoothing_length(&self) -> f64 {
        self.kernel.smoothing_length()
    }

    /// Mass of a particle (kg).
    pub fn particle_mass(&self) -> f64 {
        self.properties.density * self.properties.particle_volume
    }

    /// Properties as given.
    pub fn properties(&self) -> &FluidProperties<D> {
        &self.properties
    }

    /// Options as given.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Walls as given.
    pub fn walls(&self) -> &Walls<D> {
        &self.walls
    }

    /// Velocity (m/s) that stands for the flow's scale while it is slow.
    pub fn reference_velocity(&self) -> f64 {
        self.reference_velocity
    }

    /// The longest stable step (s) from `state` at `time` (s): Eq. (49) with the fastest of fluid, structure
    /// and walls that move in the step, growth, viscosity (`h²/8ν`).
    pub fn stable_step(&self, state: &State<D>, time: f64, structure_velocities: &[Vector<D>]) -> f64 {
        let h = self.smoothing_length();
        let fastest = parallel::max(state.len(), self.reference_velocity, |a| state.velocities[a].norm());
        let fastest = structure_velocities.iter().map(Vector::norm).fold(fastest, f64::max);
        let mut dt = self.options.courant * h / fastest.max(1e-12);
        if state.last_dt > 0.0 {
            dt = dt.min(self.options.growth * state.last_dt);
        }
        let viscosity = self.properties.kinematic_viscosity + self.approach_viscosity();
        if viscosity > 0.0 {
            dt = dt.min(0.125 * h * h / viscosity);
        }
        self.walls.longest_step(time, dt, self.options.courant * h)
    }

    pub(crate) fn approach_viscosity(&self) -> f64 {
        self.options.approach_viscosity * self.smoothing_length() * self.reference_velocity
    }
}
