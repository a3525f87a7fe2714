//! The serial explicit scheme: structure predicted, fluid solved, condition (46) enforced, structure solved. No iteration.
//!
//! Per window, from the accepted state at `tⁿ` to `tⁿ⁺¹` (section 2.3 and Algorithm 1 of the paper, with the prediction that makes heavy
//! fluid on a light structure stable):
//!
//! 1. the structure is *predicted* under the load held from the last window;
//! 2. the fluid takes the structure's position at `tⁿ`, its predicted velocity at `tⁿ⁺¹` and the load of the prediction, and solves for the
//!    pressure in fluid and structure together; it gives the new load;
//! 3. condition (46) is measured and enforced;
//! 4. the load is relaxed, `g ← r g + (1 − r) g_held`, and the structure is *solved* from the same accepted state under it;
//! 5. both accept.
//!
//! With the structure's compliance in the fluid's equations, `r = 0.3 … 0.5` is stable at an added-mass ratio of 9, `r = 1` is not; without it
//! (a moving wall) no `r` is, see `docs/decisions`.

use super::{Accepted, Onward, SchemeError};
use crate::condition46::{self, Interface, Resultant};
use crate::schedule::Schedule;
use crate::side::Side;
use interfaces::port::names;
use interfaces::{Direction, Exchange, Fields, Role, TimeWindow};

/// What the case sets of the scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SerialExplicit {
    /// Relaxation `r` of the load, in (0, 1].
    pub relaxation: f64,
    /// Whether the fluid meets the structure's mean velocity over the window, or that at its end.
    pub mean_velocity: bool,
    /// Whether condition (46) is enforced, or only measured.
    pub enforce: bool,
}

/// A fluid and a structure whose fields were paired and initialised.
pub struct Pair {
    /// The fluid's side.
    pub fluid: Side,
    /// The structure's side.
    pub structure: Side,
    /// The structure's motion at the last accepted time.
    accepted_motion: Fields,
    /// Reference volume of the interface particles (m³).
    volume: Vec<f64>,
    /// The pressure gradient under which the structure was solved last (Pa/m).
    load: Vec<f64>,
    /// The load of the window at hand, before relaxation (Pa/m).
    new_load: Vec<f64>,
    /// What stands in for a vector field that a participant does not give.
    zeros: Vec<f64>,
}

impl Pair {
    /// Initialises both sides at `time` (s): the structure first, with no load; then the fluid, with the structure's constants and motion.
    pub fn initialize(mut fluid: Side, mut structure: Side, time: f64) -> Result<Self, SchemeError> {
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
        Ok(Self { fluid, structure, accepted_motion, volume, new_load: load.clone(), load, zeros })
    }
}

impl SerialExplicit {
    /// Runs the pair over the schedule. `record` hears of every accepted window.
    pub fn run(
        &self,
        pair: &mut Pair,
        schedule: &mut Schedule,
        mut record: impl FnMut(&Accepted, &Pair) -> Result<Onward, SchemeError>,
    ) -> Result<(), SchemeError> {
        while let Some(window) = schedule.next(pair.fluid.window_limit.min(pair.structure.window_limit)) {
            let prediction = window;
            let solution = TimeWindow { iteration: 1, ..window };

            pair.predict_structure(&prediction)?;
            pair.solve_fluid(&prediction, self.mean_velocity)?;
            let (condition46, applied) = self.pass_load(pair);
            pair.structure.solve(&solution)?;

            let output = schedule.accept(&solution);
            pair.accept(&solution, output)?;
            let time = schedule.time();
            let accepted = Accepted {
                window: solution,
                time,
                output,
                condition46: Some(condition46),
                applied: Some(applied),
            };
            if record(&accepted, pair)? == Onward::Stop {
                break;
            }
        }
        Ok(())
    }

    /// Steps 3 and 4: condition (46) on the fluid's new load, relaxation, and over to the structure.
    fn pass_load(&self, pair: &mut Pair) -> (condition46::Condition46, Resultant) {
        let Pair { fluid, structure, volume, load, new_load, zeros, .. } = pair;
        let (given, motion) = (&fluid.outputs, &structure.outputs);
        let sent = given.get(names::PRESSURE_GRADIENT).unwrap_or(zeros);
        let interface = Interface {
            components: structure.describe().dimension,
            volume,
            position: motion.get(names::POSITION).unwrap_or(zeros),
            velocity: motion.get(names::VELOCITY).unwrap_or(zeros),
            // A fluid that tells no pair reaction is taken at its word: what it sends is what it received.
            pair_reaction: given.get(names::PAIR_REACTION).unwrap_or(sent),
            normal: given.get(names::NORMAL).unwrap_or(zeros),
        };
        new_load.copy_from_slice(sent);
        let found = condition46::enforce(&interface, new_load, self.enforce);
        for (held, new) in load.iter_mut().zip(new_load.iter()) {
            *held = self.relaxation * new + (1.0 - self.relaxation) * *held;
        }
        let applied = condition46::resultant(&interface, load);
        pair.structure.receive(&pair.fluid.outputs);
        set(&mut pair.structure.inputs, names::PRESSURE_GRADIENT, &pair.load);
        (found, applied)
    }
}

impl Pair {
    /// Step 1: the structure over the window under the load that it felt last.
    fn predict_structure(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        set(&mut self.structure.inputs, names::PRESSURE_GRADIENT, &self.load);
        Ok(self.structure.solve(window)?)
    }

    /// Step 2: the fluid against the predicted structure.
    fn solve_fluid(&mut self, window: &TimeWindow, mean_velocity: bool) -> Result<(), SchemeError> {
        self.fluid.receive(&self.structure.outputs);
        let positions =
            [&self.accepted_motion, &self.structure.outputs].map(|motion| motion.get(names::POSITION));
        if let [Some(start), Some(end)] = positions {
            set(&mut self.fluid.inputs, names::POSITION, start);
            if let Some(velocity) = self.fluid.inputs.get_mut(names::VELOCITY).filter(|_| mean_velocity) {
                for ((mean, start), end) in velocity.iter_mut().zip(start).zip(end) {
                    *mean = (end - start) / window.size;
                }
            }
        }
        set(&mut self.fluid.inputs, names::HELD_PRESSURE_GRADIENT, &self.load);
        Ok(self.fluid.solve(window)?)
    }

    /// Step 5.
    fn accept(&mut self, window: &TimeWindow, output: Option<u64>) -> Result<(), SchemeError> {
        self.fluid.accept(window, output)?;
        self.structure.accept(window, output)?;
        self.accepted_motion
            .copy_from(&self.structure.outputs, |e| e == Exchange::EveryWindow)
            .expect("a copy of the same fields");
        Ok(())
    }

    /// Fields that the fluid takes, for records and tests.
    pub fn fluid_inputs(&self) -> &Fields {
        debug_assert!(self.fluid.inputs.ports().iter().all(|p| p.direction == Direction::In));
        &self.fluid.inputs
    }
}

/// Writes `values` to the field of that name, if the participant takes it.
fn set(inputs: &mut Fields, name: &str, values: &[f64]) {
    if let Some(field) = inputs.get_mut(name) {
        field.copy_from_slice(values);
    }
}
