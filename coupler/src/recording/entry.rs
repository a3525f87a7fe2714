//! What stands in the blocks: a call on a participant each, with all that crossed.
//!
//! ```text
//! block: length of the entry (u32) │ entry │ length (u32) │ entry │ …
//! entry: mnscent1 │ role (u8: 0 fluid, 1 structure) │ call (u8) │ what went in │ whether it succeeded (u8)
//!        │ what came out, or the error's text
//! field: base (u8) │ bytes (u64) │ bytes
//! ```
//!
//! An entry is a state of [`words::bytes`]. Of its fields those that cross every window are written, at
//! initialisation all, in the order of the description's ports. Consecutive values of a field share their
//! leading bits: each double is written as its bits XOR those of the same place in a base (0: zero, 1: the
//! field's last values, 2: the last that the other side gave under this name), and of all doubles first the
//! lowest byte, then the next, and so on. Packed after that, a field takes what is new of it.

use interfaces::{
    Description, Direction, Exchange, Fields, Port, Readiness, Role, SubSteps, TimeWindow, WindowReport,
};
use std::collections::BTreeMap;
use std::fmt::Display;
use words::bytes::{Error, Reader, Writer};
use words::text::{EXPLANATION, tame};

const MAGIC: &[u8; 8] = b"mnscent1";
/// What is read, in messages.
const ENTRY: &str = "recording's entry";

/// What a call gave, or the text of its error.
pub type Outcome<T> = Result<T, String>;

/// One call.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// On which side.
    pub role: Role,
    /// Which, and what crossed.
    pub event: Event,
}

/// A call with what crossed. Fields are flat arrays, in the order of the description's ports of that
/// direction: all of them at initialisation, those that cross every window later.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// What the side is; comes first.
    Described(Box<Description>),
    /// `initialize` at a start time (s).
    Initialized {
        /// The start time (s).
        start: f64,
        /// What it took.
        inputs: Vec<Vec<f64>>,
        /// What it gave.
        given: Outcome<(Vec<Vec<f64>>, Readiness)>,
    },
    /// `start`.
    Started {
        /// The window, with its iteration.
        window: TimeWindow,
        /// What it took.
        inputs: Vec<Vec<f64>>,
        /// Whether it did.
        given: Outcome<()>,
    },
    /// `finish`: what it gave.
    Finished(Outcome<(Vec<Vec<f64>>, WindowReport)>),
    /// `accept`.
    Accepted {
        /// Number of the snapshot that was due.
        snapshot: Option<u64>,
        /// Whether it did.
        given: Outcome<()>,
    },
    /// `terminate`.
    Terminated(Outcome<()>),
}

/// Whether a port's field stands in an entry: at initialisation all, later what crosses every window.
pub fn is_kept(port: &Port, initial: bool) -> bool {
    initial || port.exchange == Exchange::EveryWindow
}

/// Makes entries; those of a file are made by one, in their order.
#[derive(Debug, Default)]
pub struct Encoder(Latest);

impl Encoder {
    /// What a side is.
    pub fn described(&mut self, description: &Description) -> Vec<u8> {
        let mut entry = begin(description.role, 0);
        // A description holds names and numbers: it always is JSON.
        entry.text(&serde_json::to_string(description).unwrap_or_default());
        entry.finish()
    }

    /// `initialize`.
    pub fn initialized<E: Display>(
        &mut self,
        role: Role,
        start: f64,
        inputs: &Fields,
        given: Result<(&Fields, &Readiness), E>,
    ) -> Vec<u8> {
        let mut entry = begin(role, 1);
        entry.f64(start);
        self.fields(&mut entry, role, Direction::In, inputs, true);
        outcome(&mut entry, given, |entry, (outputs, ready)| {
            self.fields(entry, role, Direction::Out, outputs, true);
            entry.f64(ready.window_limit);
            entry.f64s(&ready.scalars);
        });
        entry.finish()
    }

    /// `start`.
    pub fn started<E: Display>(
        &mut self,
        role: Role,
        window: &TimeWindow,
        inputs: &Fields,
        given: Result<(), E>,
    ) -> Vec<u8> {
        let mut entry = begin(role, 2);
        entry.u64(window.index);
        entry.u32(window.iteration);
        entry.f64(window.start);
        entry.f64(window.size);
        entry.option(window.sub_steps.count().as_ref(), |entry, count| entry.u32(*count));
        self.fields(&mut entry, role, Direction::In, inputs, false);
        outcome(&mut entry, given, |_, ()| ());
        entry.finish()
    }

    /// `finish`.
    pub fn finished<E: Display>(
        &mut self,
        role: Role,
        given: Result<(&Fields, &WindowReport), E>,
    ) -> Vec<u8> {
        let mut entry = begin(role, 3);
        outcome(&mut entry, given, |entry, (outputs, report)| {
            self.fields(entry, role, Direction::Out, outputs, false);
            entry.u32(report.sub_steps);
            entry.f64(report.window_limit);
            entry.f64(report.compute_seconds);
            entry.f64s(&report.scalars);
        });
        entry.finish()
    }

    /// `accept`.
    pub fn accepted<E: Display>(
        &mut self,
        role: Role,
        snapshot: Option<u64>,
        given: Result<(), E>,
    ) -> Vec<u8> {
        let mut entry = begin(role, 4);
        entry.option(snapshot.as_ref(), |entry, number| entry.u64(*number));
        outcome(&mut entry, given, |_, ()| ());
        entry.finish()
    }

    /// `terminate`.
    pub fn terminated<E: Display>(&mut self, role: Role, given: Result<(), E>) -> Vec<u8> {
        let mut entry = begin(role, 5);
        outcome(&mut entry, given, |_, ()| ());
        entry.finish()
    }

    fn fields(
        &mut self,
        entry: &mut Writer,
        role: Role,
        direction: Direction,
        fields: &Fields,
        initial: bool,
    ) {
        for (port, values) in fields.iter().filter(|(port, _)| is_kept(port, initial)) {
            let (base, of) = self.0.best(role, direction, &port.name, values);
            entry.u8(base);
            entry.bytes(&planes(values, of));
            self.0.keep(role, direction, &port.name, values);
        }
    }
}

fn begin(role: Role, call: u8) -> Writer {
    let mut entry = Writer::new(MAGIC);
    entry.u8(u8::from(role == Role::Structure));
    entry.u8(call);
    entry
}

fn outcome<T, E: Display>(entry: &mut Writer, given: Result<T, E>, some: impl FnOnce(&mut Writer, T)) {
    entry.bool(given.is_ok());
    match given {
        Ok(given) => some(entry, given),
        Err(error) => entry.text(&tame(&error.to_string(), EXPLANATION)),
    }
}

/// Reads entries, in the order of their file.
#[derive(Debug, Default)]
pub struct Decoder {
    latest: Latest,
    descriptions: BTreeMap<Role, Description>,
}

impl Decoder {
    /// The next entry.
    ///
    /// # Errors
    /// Bytes that are none, or do not fit the descriptions before.
    pub fn entry(&mut self, bytes: &[u8]) -> Result<Entry, Error> {
        let mut state = Reader::new(ENTRY, MAGIC, bytes)?;
        let role =
            state.tag("role", |byte| [Role::Fluid, Role::Structure].get(usize::from(byte)).copied())?;
        let call = state.u8("call")?;
        if call != 0 && !self.descriptions.contains_key(&role) {
            return Err(state.refuse("call", format!("one on the {role}, which was not described")));
        }
        let event = match call {
            0 => {
                let text = state.text("description")?;
                let read: Result<Description, _> = serde_json::from_str(text);
                let description = read.map_err(|error| state.refuse("description", error.to_string()))?;
                if let Some(mistake) = description.mistakes().into_iter().next() {
                    return Err(state.refuse("description", mistake));
                }
                if description.role != role || self.descriptions.contains_key(&role) {
                    return Err(state.refuse("description", format!("another of the {role}")));
                }
                self.descriptions.insert(role, description.clone());
                Event::Described(Box::new(description))
            }
            1 => {
                let start = state.f64("start time")?;
                let inputs = self.fields(&mut state, role, Direction::In, true)?;
                let given = outcome_of(&mut state, |state| {
                    let outputs = self.fields(state, role, Direction::Out, true)?;
                    let window_limit = state.f64("window limit")?;
                    Ok((outputs, Readiness { window_limit, scalars: state.f64s("scalars", None)? }))
                })?;
                Event::Initialized { start, inputs, given }
            }
            2 => {
                let window = TimeWindow {
                    index: state.u64("window")?,
                    iteration: state.u32("iteration")?,
                    start: state.f64("window's start")?,
                    size: state.f64("window's size")?,
                    sub_steps: match state.option("sub-steps", |state| state.u32("sub-steps"))? {
                        Some(count) => SubSteps::Fixed(count),
                        None => SubSteps::Stable,
                    },
                };
                let inputs = self.fields(&mut state, role, Direction::In, false)?;
                Event::Started { window, inputs, given: outcome_of(&mut state, |_| Ok(()))? }
            }
            3 => Event::Finished(outcome_of(&mut state, |state| {
                let outputs = self.fields(state, role, Direction::Out, false)?;
                let report = WindowReport {
                    sub_steps: state.u32("sub-steps")?,
                    window_limit: state.f64("window limit")?,
                    compute_seconds: state.f64("seconds of work")?,
                    scalars: state.f64s("scalars", None)?,
                };
                Ok((outputs, report))
            })?),
            4 => Event::Accepted {
                snapshot: state.option("snapshot", |state| state.u64("snapshot"))?,
                given: outcome_of(&mut state, |_| Ok(()))?,
            },
            5 => Event::Terminated(outcome_of(&mut state, |_| Ok(()))?),
            call => return Err(state.refuse("call", call.to_string())),
        };
        state.finish()?;
        Ok(Entry { role, event })
    }

    fn fields(
        &mut self,
        state: &mut Reader<'_>,
        role: Role,
        direction: Direction,
        initial: bool,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let description = self.descriptions.get(&role).expect("calls on a side follow its description");
        let ports = description.ports.iter().filter(|port| port.direction == direction);
        let mut arrays = Vec::new();
        for port in ports.filter(|port| is_kept(port, initial)) {
            let base = state.u8("base of a field")?;
            let bytes = state.bytes("field")?;
            let length = bytes.len() / 8;
            let fits = port.points.is_none_or(|points| points * port.components == length);
            if bytes.len() % 8 != 0 || length % port.components != 0 || !fits {
                return Err(state.refuse("field", format!("{} bytes of `{}`", bytes.len(), port.name)));
            }
            let of = match base {
                0 => None,
                1 => self.latest.of(role, direction, &port.name, length),
                2 => self.latest.of(other(role), Direction::Out, &port.name, length),
                _ => return Err(state.refuse("base of a field", base.to_string())),
            };
            if base != 0 && of.is_none() {
                return Err(state.refuse("base of a field", "values that are not there"));
            }
            let values = from_planes(bytes, of);
            self.latest.keep(role, direction, &port.name, &values);
            arrays.push(values);
        }
        Ok(arrays)
    }
}

fn outcome_of<T>(
    state: &mut Reader<'_>,
    some: impl FnOnce(&mut Reader<'_>) -> Result<T, Error>,
) -> Result<Outcome<T>, Error> {
    if state.bool("success")? { some(state).map(Ok) } else { Ok(Err(state.text("error")?.to_owned())) }
}

/// The last values of every field.
#[derive(Debug, Default)]
struct Latest(Vec<(Role, Direction, String, Vec<f64>)>);

impl Latest {
    /// Those of a field, if they are as many.
    fn of(&self, role: Role, direction: Direction, name: &str, length: usize) -> Option<&[f64]> {
        let found = self.0.iter().find(|(r, d, n, _)| *r == role && *d == direction && n == name)?;
        Some(found.3.as_slice()).filter(|values| values.len() == length)
    }

    /// The base that shares most doubles with the values.
    fn best(&self, role: Role, direction: Direction, name: &str, values: &[f64]) -> (u8, Option<&[f64]>) {
        let same = |of: &[f64]| of.iter().zip(values).filter(|(a, b)| a.to_bits() == b.to_bits()).count();
        let own = self.of(role, direction, name, values.len());
        let partner = self.of(other(role), Direction::Out, name, values.len());
        match (own, partner.filter(|_| direction == Direction::In)) {
            (None, None) => (0, None),
            (Some(own), Some(partner)) if same(partner) > same(own) => (2, Some(partner)),
            (Some(own), _) => (1, Some(own)),
            (None, Some(partner)) => (2, Some(partner)),
        }
    }

    fn keep(&mut self, role: Role, direction: Direction, name: &str, values: &[f64]) {
        match self.0.iter_mut().find(|(r, d, n, _)| *r == role && *d == direction && n == name) {
            Some((.., kept)) => {
                kept.clear();
                kept.extend_from_slice(values);
            }
            None => self.0.push((role, direction, name.to_owned(), values.to_vec())),
        }
    }
}

fn other(role: Role) -> Role {
    match role {
        Role::Fluid => Role::Structure,
        Role::Structure => Role::Fluid,
    }
}

/// The doubles XOR their base, the lowest byte of all first.
fn planes(values: &[f64], base: Option<&[f64]>) -> Vec<u8> {
    let count = values.len();
    let mut bytes = vec![0; 8 * count];
    for (index, value) in values.iter().enumerate() {
        let word = value.to_bits() ^ base.map_or(0, |base| base[index].to_bits());
        for (plane, byte) in word.to_le_bytes().into_iter().enumerate() {
            bytes[plane * count + index] = byte;
        }
    }
    bytes
}

/// The reverse of [`planes`].
fn from_planes(bytes: &[u8], base: Option<&[f64]>) -> Vec<f64> {
    let count = bytes.len() / 8;
    let value = |index: usize| {
        let word = u64::from_le_bytes(std::array::from_fn(|plane| bytes[plane * count + index]));
        f64::from_bits(word ^ base.map_or(0, |base| base[index].to_bits()))
    };
    (0..count).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use interfaces::Quantity;

    #[test]
    fn entries_come_back_to_the_bit_and_cut_ones_are_refused() {
        let description = Description {
            role: Role::Fluid,
            solver: "test".to_owned(),
            dimension: 2,
            ports: vec![
                Port::new("velocity", Quantity::Velocity, 2, Some(3), Direction::In),
                Port::new("density", Quantity::Density, 2, None, Direction::In).constant(),
                Port::new("pressure", Quantity::Pressure, 2, Some(3), Direction::Out),
            ],
            scalars: vec![],
            saves: true,
            notes: vec![],
        };
        let mut inputs = description.fields(Direction::In, 3);
        let mut outputs = description.fields(Direction::Out, 3);
        let velocity = [-0.0, 1.5, f64::MIN_POSITIVE, 5e-324, -1e300, 0.1];
        inputs.get_mut("velocity").unwrap().copy_from_slice(&velocity);
        outputs.get_mut("pressure").unwrap().copy_from_slice(&[1.0, 2.0, 3.0]);
        let window =
            TimeWindow { index: 0, iteration: 1, start: 0.0, size: 1e-3, sub_steps: SubSteps::Fixed(7) };
        let ready = Readiness { window_limit: f64::INFINITY, scalars: vec![] };
        let report = WindowReport { sub_steps: 7, window_limit: 0.1, compute_seconds: 2.0, scalars: vec![] };
        let (mut encoder, role) = (Encoder::default(), Role::Fluid);
        let no_error = |()| -> Result<(), String> { Ok(()) };
        let entries = [
            encoder.described(&description),
            encoder.initialized(role, 0.5, &inputs, Ok::<_, String>((&outputs, &ready))),
            encoder.started(role, &window, &inputs, no_error(())),
            encoder.finished(role, Ok::<_, String>((&outputs, &report))),
            encoder.accepted(role, Some(3), no_error(())),
            encoder.finished(role, Err::<(&Fields, &WindowReport), _>("it broke")),
            encoder.terminated(role, no_error(())),
        ];
        let mut decoder = Decoder::default();
        let read: Vec<_> = entries.iter().map(|entry| decoder.entry(entry).unwrap().event).collect();
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let Event::Initialized { inputs, given: Ok((_, found)), .. } = &read[1] else { panic!() };
        assert_eq!((bits(&inputs[0]), inputs.len(), found), (bits(&velocity), 2, &ready));
        let Event::Started { window: found, inputs, .. } = &read[2] else { panic!() };
        assert_eq!((bits(&inputs[0]), inputs.len(), *found), (bits(&velocity), 1, window));
        assert_eq!(read[3], Event::Finished(Ok((vec![vec![1.0, 2.0, 3.0]], report))));
        assert_eq!(read[4], Event::Accepted { snapshot: Some(3), given: Ok(()) });
        assert_eq!(read[5], Event::Finished(Err("it broke".to_owned())));
        for cut in 0..entries.len() {
            for length in 0..entries[cut].len() {
                let mut decoder = Decoder::default();
                entries[..cut].iter().for_each(|entry| drop(decoder.entry(entry).unwrap()));
                assert!(decoder.entry(&entries[cut][..length]).is_err(), "entry {cut}, {length} bytes");
            }
        }
        // Whatever stands there is read or refused: nothing panics, nothing large is reserved.
        for (changed, entry) in entries.iter().enumerate() {
            for (at, value) in (0..entry.len()).flat_map(|at| [0, 1, 127, 255].map(|value| (at, value))) {
                let mut decoder = Decoder::default();
                entries[..changed].iter().for_each(|entry| drop(decoder.entry(entry).unwrap()));
                let mut other = entry.clone();
                other[at] = value;
                if let Ok(read) = decoder.entry(&other) {
                    assert!(other == *entry || at > 8, "{read:?}");
                }
            }
        }
    }
}
