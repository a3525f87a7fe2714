//! A fluid and a structure with what passes between them: the steps of which the coupling schemes are made.

use super::{Accepted, InterfaceState, SchemeError};
use crate::condition46::{self, Condition46, Interface, Reaction, Resultant};
use crate::convergence::Residual;
use crate::flat;
use crate::phase::{Announce, Phase};
use crate::schedule::Schedule;
use crate::side::Side;
use crate::steady_state::SteadyState;
use interfaces::case::coupling::{
    LoadInWindow, SteadyQuantity, SteadyState as SteadyChoice, StructureVelocity,
};
use interfaces::port::names;
use interfaces::{Fields, Role, TimeWindow};
use words::bytes::{self, Reader, Writer};

/// A fluid and a structure whose fields were paired and initialised.
pub struct Pair {
    /// The fluid's side.
    pub fluid: Side,
    /// The structure's side.
    pub structure: Side,
    /// The pressure gradient under which the structure solves (Pa/m).
    pub load: Vec<f64>,
    /// The structure's velocity that the fluid is to meet (m/s): that of the structure's last solution, by
    /// `structure_velocity`, unless a scheme guesses it.
    pub new_velocity: Vec<f64>,
    /// What each iteration of the window at hand left; empty with an explicit scheme.
    pub residuals: Vec<Residual>,
    /// What a structure that takes the load at a window's start gets there: the window's own load once more,
    /// or the last window's.
    pub load_in_window: LoadInWindow,
    /// Who hears what the coupler is at.
    pub announce: Announce,
    /// Why the run ends before its end time, once it does.
    pub ending: Option<String>,
    /// The load that the fluid gave last, with condition (46) enforced on it (Pa/m); of use only where
    /// [`enforced`](Self::enforced).
    enforced_load: Vec<f64>,
    /// Whether condition (46) was enforced on the load that the fluid gave last.
    enforced: bool,
    /// Which velocity of the structure over a window the fluid meets: the mean, or that at the end.
    structure_velocity: StructureVelocity,
    /// The load under which the structure solved the last accepted window (Pa/m): that at the next one's
    /// start, where the load is linear in a window.
    accepted_load: Vec<f64>,
    /// The load under which the structure found its last solution (Pa/m), empty before the first; nothing
    /// where nobody asked for it.
    solved_load: Option<Vec<f64>>,
    /// The watch for the steady state that ends the run, where the case has one.
    steady_state: Option<SteadyState>,
    /// The structure's position at the last accepted time (m), if it gives any.
    accepted_position: Option<Vec<f64>>,
    /// Reference volume of the interface particles (m³).
    volume: Vec<f64>,
    /// The structure's mean velocity over the window at hand (m/s).
    mean_velocity: Vec<f64>,
    /// What stands in for a vector field that a participant does not give.
    zeros: Vec<f64>,
}

impl Pair {
    /// Initialises both sides at `time` (s): the structure first, with no load; then the fluid, with the
    /// structure's constants and motion.
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
        structure.forget_forces();
        fluid.initialize(time, points, Some(&structure.outputs))?;
        let accepted_position = structure.outputs.get(names::POSITION).map(<[f64]>::to_vec);
        let volume =
            structure.outputs.get(names::REFERENCE_VOLUME).map_or_else(|| vec![1.0; points], <[f64]>::to_vec);
        let zeros = vec![0.0; points * structure.describe().dimension];
        let load = fluid.outputs.get(names::PRESSURE_GRADIENT).unwrap_or(&zeros).to_vec();
        let new_velocity = structure.outputs.get(names::VELOCITY).unwrap_or(&zeros).to_vec();
        Ok(Self {
            fluid,
            structure,
            enforced_load: load.clone(),
            accepted_load: load.clone(),
            load,
            new_velocity,
            residuals: Vec::new(),
            load_in_window: LoadInWindow::Held,
            announce: Announce::nobody(),
            ending: None,
            solved_load: None,
            steady_state: None,
            enforced: false,
            structure_velocity,
            accepted_position,
            volume,
            mean_velocity: zeros.clone(),
            zeros,
        })
    }

    /// Ends the run at this steady state.
    pub fn end_when_steady(&mut self, choice: SteadyChoice) {
        self.steady_state = Some(SteadyState::new(choice, |quantity| quantity_at(quantity, self)));
    }

    /// Keeps the load of each solution for [`interface_state`](Self::interface_state): the next window's may
    /// have taken its place by then.
    pub fn keep_load(&mut self) {
        self.solved_load = Some(Vec::new());
    }

    /// The interface in the accepted state, if the structure gives positions.
    pub fn interface_state(&self) -> Option<InterfaceState<'_>> {
        let position = self.accepted_position()?;
        let velocity = self.structure.outputs.get(names::VELOCITY).unwrap_or(&self.zeros);
        let load = self.solved_load.as_deref().filter(|load| !load.is_empty());
        let components = self.structure.describe().dimension;
        Some(InterfaceState { components, position, velocity, volume: &self.volume, load })
    }

    /// The structure's position at the last accepted time (m), if it gives any.
    pub fn accepted_position(&self) -> Option<&[f64]> {
        self.accepted_position.as_deref()
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
        self.start_fluid(window)?;
        self.finish_fluid(window)
    }

    /// Starts the structure under [`load`](Self::load).
    pub fn start_structure(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        const WRITTEN: [&str; 2] = [names::PRESSURE_GRADIENT, names::START_PRESSURE_GRADIENT];
        self.structure.receive(&self.fluid.outputs, &WRITTEN);
        let start = match self.load_in_window {
            LoadInWindow::Held => &self.load,
            LoadInWindow::Linear => &self.accepted_load,
        };
        set(&mut self.structure.inputs, names::START_PRESSURE_GRADIENT, start);
        Ok(self.structure.start_with(window, [(names::PRESSURE_GRADIENT, &mut self.load)])?)
    }

    /// Waits for the structure, and finds the velocity over the window that the fluid is to meet.
    pub fn finish_structure(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        self.structure.finish(window)?;
        if let Some(solved) = &mut self.solved_load {
            solved.clone_from(&self.load);
        }
        let motion = &self.structure.outputs;
        let end = motion.get(names::POSITION);
        match (self.structure_velocity, &self.accepted_position, end) {
            (StructureVelocity::Mean, Some(start), Some(end)) => {
                flat::mean_rate(&mut self.new_velocity, start, end, window.size);
            }
            _ => self.new_velocity.copy_from_slice(motion.get(names::VELOCITY).unwrap_or(&self.zeros)),
        }
        Ok(())
    }

    /// Starts the fluid against the structure's accepted position and [`new_velocity`](Self::new_velocity),
    /// and tells it the load of which the motion came.
    pub fn start_fluid(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        const WRITTEN: [&str; 3] = [names::POSITION, names::VELOCITY, names::HELD_PRESSURE_GRADIENT];
        let Self { fluid, structure, accepted_position, load, new_velocity, .. } = self;
        fluid.receive(&structure.outputs, &WRITTEN);
        let motion = (names::VELOCITY, new_velocity);
        let held = (names::HELD_PRESSURE_GRADIENT, load);
        Ok(match accepted_position {
            Some(start) => fluid.start_with(window, [(names::POSITION, start), motion, held]),
            None => fluid.start_with(window, [motion, held]),
        }?)
    }

    /// Waits for the fluid.
    pub fn finish_fluid(&mut self, window: &TimeWindow) -> Result<(), SchemeError> {
        Ok(self.fluid.finish(window)?)
    }

    /// Takes the load that the fluid gave last, and enforces condition (46) on it if told to.
    /// [`new_load`](Self::new_load) is the outcome.
    pub fn take_load(&mut self, enforced: bool) {
        let Self { fluid, structure, volume, enforced_load, zeros, announce, enforced: was_enforced, .. } =
            self;
        let interface = interface(fluid, structure, volume, zeros);
        *was_enforced = enforced && interface.reaction.is_some();
        if *was_enforced {
            announce.during(Phase::Condition46, || {
                enforced_load.copy_from_slice(given_load(fluid, zeros));
                condition46::enforce(&interface, enforced_load);
            });
        }
    }

    /// The pressure gradient that the fluid gave last, after condition (46) (Pa/m).
    pub fn new_load(&self) -> &[f64] {
        if self.enforced { &self.enforced_load } else { given_load(&self.fluid, &self.zeros) }
    }

    /// Makes [`load`](Self::load) that of the last solution of the fluid, relaxed: `g ← r g_new + (1 − r) g`.
    pub fn relax_load(&mut self, r: f64) {
        let Self { fluid, load, enforced_load, zeros, enforced, .. } = self;
        flat::relax(load, if *enforced { enforced_load } else { given_load(fluid, zeros) }, r);
    }

    /// Condition (46) on what the fluid gave last, and the resultant of [`load`](Self::load), both with the
    /// motion of the structure's last solution of the window: its power, times the window, is the work that a
    /// held load did.
    pub fn condition46(&mut self, window: &TimeWindow) -> (Condition46, Resultant) {
        let Self { fluid, structure, volume, zeros, mean_velocity, accepted_position, .. } = self;
        self.announce.during(Phase::Condition46, || {
            let mut interface = interface(fluid, structure, volume, zeros);
            if let Some(start) = accepted_position {
                flat::mean_rate(mean_velocity, start, interface.position, window.size);
                interface.velocity = mean_velocity;
            }
            let passed = self.enforced.then_some(self.enforced_load.as_slice());
            condition46::measure(&interface, given_load(fluid, zeros), passed, &self.load)
        })
    }

    /// Makes the last solution of both final, of which condition (46) and the load's resultant are `found`,
    /// and moves the schedule on. The schedule ends there where a participant asks for it or the state is
    /// steady; [`ending`](Self::ending) then says why.
    pub fn accept(
        &mut self,
        window: &TimeWindow,
        (condition46, applied): (Condition46, Resultant),
        schedule: &mut Schedule,
    ) -> Result<Accepted, SchemeError> {
        self.ending = self.reason_to_end(window);
        let output =
            if self.ending.is_some() { schedule.accept_last(window) } else { schedule.accept(window) };
        self.fluid.accept(window, output)?;
        self.structure.accept(window, output)?;
        if let Some(accepted) = &mut self.accepted_position {
            // The next solution overwrites what stands there then.
            self.structure.outputs.swap(names::POSITION, accepted);
        }
        if self.load_in_window == LoadInWindow::Linear {
            self.accepted_load.copy_from_slice(&self.load);
        }
        Ok(Accepted {
            window: *window,
            time: schedule.time(),
            output,
            condition46: Some(condition46),
            applied: Some(applied),
        })
    }

    /// Writes what the next windows depend on, but for the participants' own states. Positions are those that
    /// the structure gives when it is restored; [`residuals`](Self::residuals) and [`ending`](Self::ending)
    /// are of the last window alone.
    pub fn save(&self, state: &mut Writer) {
        self.fluid.save(state);
        self.structure.save(state);
        for field in [&self.load, &self.accepted_load, &self.new_velocity] {
            state.f64s(field);
        }
        state.option(self.enforced.then_some(&self.enforced_load), |state, load| state.f64s(load));
        state.option(self.steady_state.as_ref(), |state, steady_state| steady_state.save(state));
    }

    /// Goes to what [`save`](Self::save) wrote, with participants that are in their own states.
    pub fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        self.fluid.restore(state)?;
        self.structure.restore(state)?;
        self.accepted_position = self.structure.outputs.get(names::POSITION).map(<[f64]>::to_vec);
        let expected = Some(self.zeros.len());
        self.load = state.f64s("load", expected)?;
        self.accepted_load = state.f64s("accepted load", expected)?;
        self.new_velocity = state.f64s("velocity", expected)?;
        let enforced = state.option("enforced load", |state| state.f64s("enforced load", expected))?;
        self.enforced = enforced.is_some();
        self.enforced_load = enforced.unwrap_or_else(|| self.load.clone());
        if state.bool("steady state")? != self.steady_state.is_some() {
            return Err(state.refuse("steady state", "what this case does not ask for, or lacks"));
        }
        if let Some(steady_state) = &mut self.steady_state {
            steady_state.restore(state)?;
        }
        self.residuals.clear();
        self.ending = None;
        Ok(())
    }

    fn reason_to_end(&mut self, window: &TimeWindow) -> Option<String> {
        let steady = self.steady_state.take().and_then(|mut steady_state| {
            let reason =
                steady_state.observe(window.start, window.size, |quantity| quantity_at(quantity, self));
            self.steady_state = Some(steady_state);
            reason
        });
        let asked = [&self.fluid, &self.structure].into_iter().find(|side| side.asks_for_end());
        asked.map(|side| format!("the {} asked for it", side.role())).or(steady)
    }
}

/// The quantity as it stands on the structure's points.
fn quantity_at(quantity: SteadyQuantity, pair: &Pair) -> &[f64] {
    let motion = |name| pair.structure.outputs.get(name).unwrap_or(&pair.zeros);
    match quantity {
        SteadyQuantity::Position => motion(names::POSITION),
        SteadyQuantity::Velocity => motion(names::VELOCITY),
        SteadyQuantity::Load => &pair.load,
    }
}

/// The load as the fluid gave it last.
fn given_load<'a>(fluid: &'a Side, zeros: &'a [f64]) -> &'a [f64] {
    fluid.outputs.get(names::PRESSURE_GRADIENT).unwrap_or(zeros)
}

fn interface<'a>(fluid: &'a Side, structure: &'a Side, volume: &'a [f64], zeros: &'a [f64]) -> Interface<'a> {
    let (given, motion) = (&fluid.outputs, &structure.outputs);
    Interface {
        components: structure.describe().dimension,
        volume,
        position: motion.get(names::POSITION).unwrap_or(zeros),
        velocity: motion.get(names::VELOCITY).unwrap_or(zeros),
        reaction: given
            .get(names::PAIR_REACTION)
            .zip(given.get(names::NORMAL))
            .map(|(pair_reaction, normal)| Reaction { pair_reaction, normal }),
    }
}

/// Writes `values` to the field of that name, if the participant takes it.
fn set(inputs: &mut Fields, name: &str, values: &[f64]) {
    if let Some(field) = inputs.get_mut(name) {
        field.copy_from_slice(values);
    }
}
