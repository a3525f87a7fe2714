//! An instance of a unit as a participant: a time window is a step.

use crate::Error;
use crate::archive::{Archive, Unpacked};
use crate::instantiate::instantiate;
use crate::saved;
use crate::unit::{Instance, Stepped};
use crate::wiring::{Values, Wire, Wiring, wire};
use interfaces::case::Case;
use interfaces::case::participant::{Start, Unit};
use interfaces::port::names;
use interfaces::{
    Description, Direction, END_REQUESTED, Exchange, Fields, Participant, ParticipantError, Readiness,
    Result, Role, Scalar, ScalarKind, TimeWindow, WindowReport,
};
use output::{ParticleFrame, PointArray, Series};
use std::path::Path;
use std::time::Instant;

/// The unit that solves the side `role` of `case`, unpacked below the folder `out`, where a structure's
/// points are written too.
///
/// # Errors
/// An archive that cannot be used here, variables that do not fit the case, a unit that refuses to be made.
///
/// # Panics
/// Where the case has no unit for that side.
pub fn open(case: &Case, role: Role, out: &Path) -> Result<Box<dyn Participant>, Error> {
    let unit = unit_of(case, role).expect("the caller asks for the unit of a side that has one");
    let mut archive = Archive::open(unit.file)?;
    let described = archive.description()?;
    let wiring = wire(unit, &described, case, role)?;
    let unpacked = archive.unpack(&described, &out.join(format!("{role}_fmu")))?;
    let instance = instantiate(&described, &unpacked, unit.file)?;
    let snapshots = (role == Role::Structure).then(|| Series::create(out, "structure")).transpose()?;
    let mut scalars: Vec<Scalar> = wiring.records.iter().map(|record| record.scalar.clone()).collect();
    scalars.push(
        Scalar::new(END_REQUESTED, "1", ScalarKind::Balance).meaning("whether the unit asks for the end"),
    );
    Ok(Box::new(UnitParticipant {
        description: Description {
            role,
            solver: format!("{} ({} unit)", described.model, described.version),
            dimension: case.general.dimension,
            ports: wiring.wires.iter().map(|wire| wire.port.clone()).collect(),
            scalars,
            saves: described.keeps_state && described.serializes_state,
            notes: wiring.notes.clone(),
        },
        instance: Some(instance),
        _unpacked: unpacked,
        wiring,
        abilities: Abilities {
            name: unit.file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            token: described.token.clone(),
            keeps_state: described.keeps_state,
            serializes_state: described.serializes_state,
            variable_steps: described.variable_steps,
        },
        initialized: false,
        left_accepted: false,
        step_size: None,
        solved: None,
        last_input: None,
        last_output: None,
        repeated: 0,
        time: 0.0,
        reference: Vec::new(),
        snapshots,
    }))
}

/// What the unit of a side would be: pairs of what and value, for `meniscus check`.
///
/// # Errors
/// As [`open`], but for what only an instance can tell.
///
/// # Panics
/// As [`open`].
pub fn preview(case: &Case, role: Role) -> Result<Vec<(String, String)>, Error> {
    let unit = unit_of(case, role).expect("the caller asks for the unit of a side that has one");
    let mut archive = Archive::open(unit.file)?;
    let described = archive.description()?;
    archive.library(&described)?;
    let wiring = wire(unit, &described, case, role)?;
    let mut lines = vec![
        ("FMU".to_owned(), format!("{} ({})", described.model, described.version)),
        (
            "state kept, serialised".to_owned(),
            format!("{}, {}", described.keeps_state, described.serializes_state),
        ),
    ];
    for Wire { port, values, .. } in &wiring.wires {
        let arrow = if port.direction == Direction::In { "takes" } else { "gives" };
        let how = match values {
            Values::Variables(references) => format!("{} variable(s)", references.len()),
            Values::Same(_) => "one variable for all".to_owned(),
            Values::Number(number) => format!("{number} at all"),
        };
        let points = port.points.map_or(String::new(), |points| format!("{points} points, "));
        lines.push((format!("{arrow} {}", port.name), format!("{points}{how}")));
    }
    let records: Vec<&str> = wiring.records.iter().map(|record| record.scalar.name.as_str()).collect();
    lines.push(("records".to_owned(), records.join(", ")));
    lines.extend(wiring.notes.into_iter().map(|note| ("note".to_owned(), note)));
    Ok(lines)
}

/// The unit that the case has for a side.
pub fn unit_of(case: &Case, role: Role) -> Option<Unit<'_>> {
    match case.start(role)? {
        Start::Fmu(unit) => Some(unit),
        _ => None,
    }
}

/// Windows of which the first solution is taken twice.
const REPEATED: u32 = 3;
/// Largest difference of a repeated solution, over the largest value: a unit's own solver may start its
/// iterations elsewhere.
const REPEATS: f64 = 1e-9;

struct UnitParticipant {
    description: Description,
    /// There until it is terminated.
    instance: Option<Box<dyn Instance>>,
    wiring: Wiring,
    abilities: Abilities,
    /// Whether steps can follow.
    initialized: bool,
    /// Whether the instance stands at the end of a solution that is not accepted.
    left_accepted: bool,
    /// Size (s) of the steps so far, of a unit whose steps are all of one size.
    step_size: Option<f64>,
    solved: Option<Solved>,
    /// What the last solution was solved under and gave, as long as solutions are repeated to see whether the
    /// state that the unit keeps is whole.
    last_input: Option<(TimeWindow, Fields)>,
    last_output: Option<Fields>,
    /// Solutions repeated so far.
    repeated: u32,
    /// End of the last window (s).
    time: f64,
    /// Positions at the start (m).
    reference: Vec<f64>,
    snapshots: Option<Series>,
    /// After the instance: its library is in there.
    _unpacked: Unpacked,
}

/// What the unit says of itself that it can do.
struct Abilities {
    name: String,
    token: String,
    keeps_state: bool,
    serializes_state: bool,
    variable_steps: bool,
}

struct Solved {
    ended: Stepped,
    compute_seconds: f64,
}

fn failed(error: impl std::fmt::Display) -> ParticipantError {
    ParticipantError::failed(error.to_string())
}

impl UnitParticipant {
    fn instance(&mut self) -> &mut dyn Instance {
        self.instance.as_mut().expect("the table of legal calls puts nothing after terminate").as_mut()
    }

    fn set(&mut self, inputs: &Fields, which: impl Fn(Exchange) -> bool) -> Result<()> {
        let instance = self.instance.as_mut().expect("the table of legal calls puts nothing after terminate");
        for Wire { port, values, factor } in &self.wiring.wires {
            let (Values::Variables(references), Direction::In) = (values, port.direction) else { continue };
            if let (Some(field), true) = (inputs.get(&port.name), which(port.exchange)) {
                let own: Vec<f64>;
                let field = match *factor {
                    1.0 => field,
                    factor => {
                        own = field.iter().map(|value| value / factor).collect();
                        &own
                    }
                };
                instance.set(references, field).map_err(failed)?;
            }
        }
        Ok(())
    }

    fn get(&mut self, outputs: &mut Fields, which: impl Fn(Exchange) -> bool) -> Result<()> {
        let instance = self.instance.as_mut().expect("the table of legal calls puts nothing after terminate");
        for Wire { port, values, factor } in &self.wiring.wires {
            if port.direction != Direction::Out || !which(port.exchange) {
                continue;
            }
            let Some(field) = outputs.get_mut(&port.name) else { continue };
            match values {
                Values::Variables(references) => instance.get(references, field).map_err(failed)?,
                Values::Same(reference) => {
                    let mut value = [0.0];
                    instance.get(&[*reference], &mut value).map_err(failed)?;
                    field.fill(value[0]);
                }
                Values::Number(number) => field.fill(*number),
            }
            if *factor != 1.0 {
                field.iter_mut().for_each(|value| *value *= factor);
            }
        }
        Ok(())
    }

    fn scalars(&mut self, ended: Stepped) -> Result<Vec<f64>> {
        let instance = self.instance.as_mut().expect("the table of legal calls puts nothing after terminate");
        let read = self
            .wiring
            .records
            .iter()
            .map(|record| Ok(record.factor * instance.number(&record.variable).map_err(failed)?));
        let mut scalars = read.collect::<Result<Vec<f64>>>()?;
        scalars.push(f64::from(u8::from(ended == Stepped::EndRequested)));
        Ok(scalars)
    }

    /// Largest next step (s). Where the unit names none, any will do; so will it where it names the largest
    /// number there is.
    fn window_limit(&mut self) -> Result<f64> {
        let Some((variable, factor)) = self.wiring.window_limit.clone() else { return Ok(f64::INFINITY) };
        let limit = self.instance().number(&variable).map_err(failed)?;
        Ok(if limit == f64::MAX { f64::INFINITY } else { factor * limit })
    }

    fn write_snapshot(&mut self) -> Result<()> {
        let (Some(snapshots), Some(instance)) = (&mut self.snapshots, &mut self.instance) else {
            return Ok(());
        };
        let dimension = self.description.dimension;
        let mut vectors = Vec::new();
        for Wire { port, values, factor } in &self.wiring.wires {
            let (Values::Variables(references), Some(points)) = (values, port.points) else { continue };
            if port.exchange == Exchange::EveryWindow && port.components == dimension {
                let mut field = vec![0.0; points * dimension];
                // An input that a unit does not give back is no reason to fail.
                match (instance.get(references, &mut field), port.direction) {
                    (Ok(()), _) => {
                        field.iter_mut().for_each(|value| *value *= factor);
                        vectors.push((port.name.as_str(), field));
                    }
                    (Err(_), Direction::In) => {}
                    (Err(error), Direction::Out) => return Err(failed(error)),
                }
            }
        }
        let Some(at) = vectors.iter().position(|(name, _)| *name == names::POSITION) else { return Ok(()) };
        let (_, positions) = vectors.swap_remove(at);
        if self.reference.is_empty() {
            self.reference.clone_from(&positions);
        }
        let displacement: Vec<f64> =
            positions.iter().zip(&self.reference).map(|(x, start)| x - start).collect();
        let mut arrays = vec![PointArray::vector("displacement", dimension, &displacement)];
        arrays.extend(vectors.iter().map(|(name, field)| PointArray::vector(name, dimension, field)));
        let frame = ParticleFrame { time: self.time, dimension, positions: &positions, arrays: &arrays };
        snapshots.write(&frame).map_err(failed)?;
        Ok(())
    }

    fn check_step(&mut self, size: f64) -> Result<()> {
        if self.abilities.variable_steps {
            return Ok(());
        }
        let first = *self.step_size.get_or_insert(size);
        // Windows of one size differ by the rounding of their ends.
        if (size - first).abs() <= 1e-9 * first {
            return Ok(());
        }
        let name = &self.abilities.name;
        Err(failed(format_args!(
            "{name} takes steps of one size only (canHandleVariableCommunicationStepSize is false): the first had {first} s, this one has {size} s; choose coupling.max_window so that no other limit is smaller and case.output_interval is a multiple of it"
        )))
    }
}

impl Participant for UnitParticipant {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        let parameters = std::mem::take(&mut self.wiring.parameters);
        self.instance().enter_initialization(&parameters, start).map_err(failed)?;
        self.set(inputs, |_| true)?;
        self.instance().exit_initialization().map_err(failed)?;
        self.initialized = true;
        self.get(outputs, |_| true)?;
        self.time = start;
        self.write_snapshot()?;
        Ok(Readiness { window_limit: self.window_limit()?, scalars: self.scalars(Stepped::On)? })
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let started = Instant::now();
        self.check_step(window.size)?;
        match (self.left_accepted, self.abilities.keeps_state) {
            (true, true) => {
                self.instance().go_back().map_err(failed)?;
                self.check_state()?;
            }
            (false, true) => self.instance().keep().map_err(failed)?,
            (false, false) => {}
            (true, false) => {
                let name = &self.abilities.name;
                return Err(failed(format_args!(
                    "{name} cannot solve a window again (canGetAndSetFMUState is false): take coupling.scheme = \"serial-explicit\" with coupling.prediction = false, or \"parallel-explicit\""
                )));
            }
        }
        self.set(inputs, |exchange| exchange == Exchange::EveryWindow)?;
        self.left_accepted = true;
        let ended = self.instance().step(window.start, window.size).map_err(failed)?;
        self.time = window.end();
        if self.abilities.keeps_state && self.repeated < REPEATED {
            self.last_input = Some((*window, inputs.clone()));
        }
        self.solved = Some(Solved { ended, compute_seconds: started.elapsed().as_secs_f64() });
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let solved = self.solved.take().expect("the table of legal calls puts a start before every finish");
        self.get(outputs, |exchange| exchange == Exchange::EveryWindow)?;
        self.last_output = self.last_input.is_some().then(|| outputs.clone());
        let sub_steps = match self.wiring.sub_steps.clone() {
            Some(variable) => self.instance().number(&variable).map_err(failed)? as u32,
            None => 1,
        };
        Ok(WindowReport {
            sub_steps,
            window_limit: self.window_limit()?,
            compute_seconds: solved.compute_seconds,
            scalars: self.scalars(solved.ended)?,
        })
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        self.left_accepted = false;
        (self.last_input, self.last_output) = (None, None);
        if snapshot.is_some() { self.write_snapshot() } else { Ok(()) }
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        self.check_serializes()?;
        self.instance().keep().map_err(failed)?;
        let state = self.instance().serialize().map_err(failed)?;
        let times = self.snapshots.as_ref().map_or(&[][..], Series::times);
        Ok(saved::seal(&self.abilities.token, times, &state))
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        self.check_serializes()?;
        let (times, state) = saved::open(&self.abilities.token, state)
            .map_err(|error| failed(format_args!("of {}: {error}", self.abilities.name)))?;
        if let Some(snapshots) = &mut self.snapshots {
            snapshots.go_on(times).map_err(failed)?;
        }
        self.instance().deserialize(state).map_err(failed)?;
        self.instance().go_back().map_err(failed)?;
        self.left_accepted = false;
        self.get(outputs, |exchange| exchange == Exchange::EveryWindow)?;
        Ok(Readiness { window_limit: self.window_limit()?, scalars: self.scalars(Stepped::On)? })
    }

    fn terminate(&mut self) -> Result<()> {
        match self.instance.take() {
            Some(mut instance) if self.initialized => instance.terminate().map_err(failed),
            // One that never began has nothing to end; it is given back.
            _ => Ok(()),
        }
    }
}

impl UnitParticipant {
    /// Of a unit that went back to its accepted state: the step that it took from there, taken again under
    /// the same input, gives the same. One whose state leaves something out would give wrong numbers in all
    /// schemes that solve a window again, and nobody would notice.
    fn check_state(&mut self) -> Result<()> {
        let (Some((window, inputs)), Some(before)) = (self.last_input.take(), self.last_output.take()) else {
            return Ok(());
        };
        self.repeated += 1;
        self.set(&inputs, |exchange| exchange == Exchange::EveryWindow)?;
        self.instance().step(window.start, window.size).map_err(failed)?;
        let mut again = before.clone();
        self.get(&mut again, |exchange| exchange == Exchange::EveryWindow)?;
        for ((port, before), (_, again)) in before.iter().zip(again.iter()) {
            let largest = before.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            let differs = |(before, again): (&f64, &f64)| (before - again).abs() > REPEATS * largest;
            let Some(at) = before.iter().zip(again).position(differs) else { continue };
            let (name, port, index) = (&self.abilities.name, &port.name, window.index);
            return Err(failed(format_args!(
                "{name} gives other numbers when it steps again from the state that it kept: `{port}` was {} and is {} in window {index}; its state (fmi…FMUState) leaves something out, so no window can be solved again: take coupling.scheme = \"serial-explicit\" with coupling.prediction = false, or \"parallel-explicit\"",
                before[at], again[at]
            )));
        }
        self.instance().go_back().map_err(failed)
    }

    fn check_serializes(&self) -> Result<()> {
        if self.abilities.keeps_state && self.abilities.serializes_state {
            return Ok(());
        }
        let name = &self.abilities.name;
        Err(failed(format_args!(
            "{name} cannot be saved (canSerializeFMUState is false): it can only run from the start"
        )))
    }
}
