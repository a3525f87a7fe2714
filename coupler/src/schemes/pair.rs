//! A fluid and a structure with what passes between them: the steps of which the coupling schemes are made.

use super::SchemeError;
use crate::condition46::{self, Condition46, Interface, Resultant};
use crate::convergence::Residual;
use crate::side::Side;
use interfaces::case::coupling::StructureVelocity;
use interfaces::port::names;
use interfaces::{Exchange, Fields, Role, TimeWindow};

/// A fluid and a structure whose fields were paired and initialised.
pub struct Pair {
    /// The fluid's side.
    pub fluid: Side,
    /// The structure's side.
    pub structure: Side,
    /// The pressure gradient under which the structure solves (Pa/m).
    pub load: Vec<f64>,
    /// The pressure gradient that the fluid gave last, after condition (46) (Pa/m).
    pub new_load: Vec<f64>,
    /// The velocity that the structure's last solution gives the fluid to meet (m/s).
    pub new_velocity: Vec<f64>,
    /// What each iteration of the window at hand left; empty with an explicit scheme.
    pub residuals: Vec<Residual>,
    /// Which velocity over the window that is.
    structure_velocity: StructureVelocity,
    /// The structure's motion at the last accepted time.
    accepted_motion: Fields,
    /// Reference volume of the interface particles (m³).
    volume: Vec<f64>,
    /// What stands in for a vector field that a participant does not give.
    zeros: Vec<f64>,
}

impl Pair {
    /// Initialises both sides at `time` (s): the structure first, with no load; then the fluid, with the structure's constants and motion.
    pub fn initialize(
        mut fluid: Side,
        mut structure: Side,
        time: f64,
        structure_velocity: StructureVelocity,
    ) -> Result<Self, SchemeError> {
        assert_eq!(
            (fluid.role(), structure.role()),
            (Role::Fluid, Role::Structure),
            "sides are told apart by role"
        );
        let points = structure.points().or(fluid.points()).unwrap_or(0);
        structure.initialize(time, points, None)?;
        fluid.initialize(time, points, Some(&structure.outputs))?;
        let accepted_motion = structure.outputs.clone();
        let volume =
            structure.outputs.get(names::REFERENCE_VOLUME).map_or_else(|| vec![1.0; points], <[f64]>::to_vec);
        let zeros = vec![0.0; points * structure.describe().dimension];
        let load = fluid.outputs.get(names::PRESSURE_GRADIENT).unwrap_or(&zeros).to_vec();
        let new_velocity = structure.outputs.get(names::VELOCITY).unwrap_or(&zeros).to_vec();
        Ok(Self {
            fluid,
            structure,
            new_load: load.clone(),
            load,
            new_velocity,
            residuals: Vec::new(),
            structure_velocity,
            accepted_motion,
            volume,
            zeros,
        })
    }

    /// The largest window that both sides allow (s).
    pub fn window_limit(&self) -> f64 {
        self.fluid.window_limit.min(self.structure.window_limit)
    }

    /// The structure over the window under [`load`](Self::load).
    pub fn solve_structure(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        self.start_structure(window)?;
        self.finish_structure(window)
    }

    /// The fluid over the window against the motion of the structure's last solution.
    pub fn solve_fluid(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        let velocity = std::mem::take(&mut self.new_velocity);
        let started = self.start_fluid(window, &velocity);
        self.new_velocity = velocity;
        started?;
        self.finish_fluid(window)
    }

    /// Starts the structure under [`load`](Self::load).
    pub fn start_structure(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        self.structure.receive(&self.fluid.outputs);
        set(&mut self.structure.inputs, names::PRESSURE_GRADIENT, &self.load);
        Ok(self.structure.start(window)?)
    }

    /// Waits for the structure, and finds the velocity over the window that the fluid is to meet.
    pub fn finish_structure(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        self.structure.finish(window)?;
        let motion = &self.structure.outputs;
        let positions = [&self.accepted_motion, motion].map(|motion| motion.get(names::POSITION));
        match (self.structure_velocity, positions) {
            (StructureVelocity::Mean, [Some(start), Some(end)]) => {
                for ((mean, start), end) in self.new_velocity.iter_mut().zip(start).zip(end) {
                    *mean = (end - start) / window.size;
                }
            }
            _ => self.new_velocity.copy_from_slice(motion.get(names::VELOCITY).unwrap_or(&self.zeros)),
        }
        Ok(())
    }

    /// Starts the fluid against the structure's accepted position, that `velocity` (m/s), and the load of which the motion came.
    pub fn start_fluid(&mut self, window: &TimeWindow, velocity: &[f64]) -> Result<(), SchemeError> {
        self.fluid.receive(&self.structure.outputs);
        if let Some(start) = self.accepted_motion.get(names::POSITION) {
            set(&mut self.fluid.inputs, names::POSITION, start);
        }
        set(&mut self.fluid.inputs, names::VELOCITY, velocity);
        set(&mut self.fluid.inputs, names::HELD_PRESSURE_GRADIENT, &self.load);
        Ok(self.fluid.start(window)?)
    }

    /// Waits for the fluid.
    pub fn finish_fluid(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        Ok(self.fluid.finish(window)?)
    }

    /// Condition (46) on what the fluid gave last: measured, and enforced if told to. [`new_load`](Self::new_load) is the outcome.
    pub fn condition46(&mut self, enforced: bool) -> Condition46 {
        let Self { fluid, structure, volume, new_load, zeros, .. } = self;
        let sent = fluid.outputs.get(names::PRESSURE_GRADIENT).unwrap_or(zeros);
        new_load.copy_from_slice(sent);
        condition46::enforce(&interface(fluid, structure, volume, zeros), new_load, enforced)
    }

    /// Resultant of [`load`](Self::load) with the structure's last motion.
    pub fn applied(&self) -> Resultant {
        condition46::resultant(
            &interface(&self.fluid, &self.structure, &self.volume, &self.zeros),
            &self.load,
        )
    }

    /// Makes the last solution of both final.
    pub fn accept(&mut self, window: &TimeWindow, output: Option<u64>) -> Result<(), SchemeError> {
        self.fluid.accept(window, output)?;
        self.structure.accept(window, output)?;
        self.accepted_motion
            .copy_from(&self.structure.outputs, |e| e == Exchange::EveryWindow)
            .expect("a copy of the same fields");
        Ok(())
    }
}

fn interface<'a>(fluid: &'a Side, structure: &'a Side, volume: &'a [f64], zeros: &'a [f64]) -> Interface<'a> {
    let (given, motion) = (&fluid.outputs, &structure.outputs);
    Interface {
        components: structure.describe().dimension,
        volume,
        position: motion.get(names::POSITION).unwrap_or(zeros),
        velocity: motion.get(names::VELOCITY).unwrap_or(zeros),
        // A fluid that tells no pair reaction is taken at its word: what it sends is what it received.
        pair_reaction: given
            .get(names::PAIR_REACTION)
            .or_else(|| given.get(names::PRESSURE_GRADIENT))
            .unwrap_or(zeros),
        normal: given.get(names::NORMAL).unwrap_or(zeros),
    }
}

/// Writes `values` to the field of that name, if the participant takes it.
fn set(inputs: &mut Fields, name: &str, values: &[f64]) {
    if let Some(field) = inputs.get_mut(name) {
        field.copy_from_slice(values);
    }
}
