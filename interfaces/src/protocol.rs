//! The messages between the coupler and a participant: what they mean and where their bytes are.
//!
//! A message is a [`MessageHeader`] and a payload of doubles. The payload is, in this order, `scalars`
//! doubles, the fields of the message, and `text_bytes` bytes of text padded to whole doubles.
//! `docs/protocol.md` is the same in prose, with offsets, for those who write a participant in another
//! language; [`VERSION`] counts its changes.

use crate::fields::{FieldError, put_finite, take_finite};
use crate::{Description, Exchange, Fields, Readiness, SubSteps, TimeWindow, WindowReport};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::mem::MaybeUninit;
use thiserror::Error;

/// Version of the protocol. The first 64 bits of the header (version and kind) stay what they are in every
/// version, so that two versions can tell each other apart.
pub const VERSION: u32 = 3;

/// What [`MessageHeader::snapshot`] says where no snapshot is asked for.
pub const NO_SNAPSHOT: u64 = u64::MAX;

/// Bytes of a state that one message carries at most: shared memory holds a piece, and not the state.
pub const PIECE: usize = 4 << 20;

/// What a message asks or answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Kind {
    /// Participant → coupler: here I am. Text: [`Hello`] as JSON.
    Hello = 1,
    /// Coupler → participant: the handshake fits. Text: [`Welcome`] as JSON.
    Welcome = 2,
    /// Coupler → participant: the handshake does not fit. Text: one line a mismatch.
    Refused = 3,
    /// Request. Scalars: number of points of each port taken, then of each port given. Fields: all that are
    /// taken.
    Initialize = 4,
    /// Answer to `Initialize`. Scalars: as described. Fields: all that are given.
    Ready = 5,
    /// Request: solve this window. Fields: those taken every window.
    Start = 6,
    /// Answer to `Start`. Scalars: as described. Fields: those given every window.
    Solved = 7,
    /// Order without an answer: the last solution is final.
    Accept = 8,
    /// Request: the accepted state.
    Save = 9,
    /// Answer to `Save`. Text: the state's bytes.
    Saved = 10,
    /// Request: go to this state. Text: the state's bytes.
    Restore = 11,
    /// Answer to `Restore`. Scalars: as described. Fields: those given every window.
    Restored = 12,
    /// Request: end in order.
    Terminate = 13,
    /// Answer to `Terminate`.
    Terminated = 14,
    /// Participant → coupler, at any time after the handshake, its last message: it gave up. Text: why.
    Failed = 15,
    /// Coupler → participant, its last message: yours was received, or nothing more is wanted.
    Goodbye = 16,
}

impl Kind {
    /// The kind of that number.
    pub fn from_number(number: u32) -> Option<Self> {
        use Kind::*;
        [
            Hello, Welcome, Refused, Initialize, Ready, Start, Solved, Accept, Save, Saved, Restore,
            Restored, Terminate, Terminated, Failed, Goodbye,
        ]
        .into_iter()
        .find(|kind| *kind as u32 == number)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{self:?}`")
    }
}

/// What stands in front of every payload: 80 bytes, without gaps. Fields that a kind does not name are zero.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MessageHeader {
    /// Offset 0: [`VERSION`] of the sender.
    pub version: u32,
    /// Offset 4: number of the [`Kind`].
    pub kind: u32,
    /// Offset 8: number of the request, from 1; an answer repeats it. Zero in the handshake.
    pub sequence: u64,
    /// Offset 16: number of the window (`Start`, `Solved`, `Accept`).
    pub window: u64,
    /// Offset 24: iteration of the window (`Start`, `Solved`, `Accept`).
    pub iteration: u32,
    /// Offset 28: sub-steps to take, 0 for as many as stability asks (`Start`), or taken (`Solved`).
    pub sub_steps: u32,
    /// Offset 32: time (s) at the start of the window (`Start`), of the run (`Initialize`).
    pub time: f64,
    /// Offset 40: size (s) of the window (`Start`); largest next window that can be solved (`Ready`,
    /// `Solved`, `Restored`).
    pub size: f64,
    /// Offset 48: wall time (s) of the participant's own work (`Solved`).
    pub compute_seconds: f64,
    /// Offset 56: number of the snapshot to write, all bits set for none (`Accept`).
    pub snapshot: u64,
    /// Offset 64: doubles at the payload's beginning that are not fields.
    pub scalars: u64,
    /// Offset 72: bytes of text at the payload's end, before padding with zeros to whole doubles.
    pub text_bytes: u64,
}

impl MessageHeader {
    /// A header of that kind and number, all else zero.
    pub fn new(kind: Kind, sequence: u64) -> Self {
        Self { version: VERSION, kind: kind as u32, sequence, ..Self::default() }
    }

    /// The header of a `Start`.
    pub fn start(sequence: u64, window: &TimeWindow) -> Self {
        let sub_steps = match window.sub_steps {
            SubSteps::Fixed(count) => count,
            SubSteps::Stable => 0,
        };
        Self {
            window: window.index,
            iteration: window.iteration,
            sub_steps,
            time: window.start,
            size: window.size,
            ..Self::new(Kind::Start, sequence)
        }
    }

    /// The window of a `Start`.
    pub fn time_window(&self) -> TimeWindow {
        TimeWindow {
            index: self.window,
            iteration: self.iteration,
            start: self.time,
            size: self.size,
            sub_steps: if self.sub_steps == 0 { SubSteps::Stable } else { SubSteps::Fixed(self.sub_steps) },
        }
    }

    /// The answer `Solved` to this `Start`.
    pub fn solved(&self, report: &WindowReport) -> Self {
        Self {
            window: self.window,
            iteration: self.iteration,
            sub_steps: report.sub_steps,
            size: report.window_limit,
            compute_seconds: report.compute_seconds,
            ..Self::new(Kind::Solved, self.sequence)
        }
    }

    /// The report of a `Solved` with these scalars.
    pub fn window_report(&self, scalars: &[f64]) -> WindowReport {
        WindowReport {
            sub_steps: self.sub_steps,
            window_limit: self.size,
            compute_seconds: self.compute_seconds,
            scalars: scalars.to_vec(),
        }
    }

    /// The answer of that kind to this `Initialize` or `Restore`.
    pub fn ready(&self, kind: Kind, readiness: &Readiness) -> Self {
        Self { size: readiness.window_limit, ..Self::new(kind, self.sequence) }
    }

    /// The kind, or nothing where the number is none.
    pub fn kind(&self) -> Option<Kind> {
        Kind::from_number(self.kind)
    }

    /// What the message is, for errors: "`Solved` 12 of window 5, iteration 0".
    pub fn name(&self) -> String {
        let kind =
            self.kind().map_or_else(|| format!("message of unknown kind {}", self.kind), |k| k.to_string());
        match self.kind() {
            Some(Kind::Start | Kind::Solved | Kind::Accept) => {
                format!("{kind} {} of window {}, iteration {}", self.sequence, self.window, self.iteration)
            }
            _ => format!("{kind} {}", self.sequence),
        }
    }
}

/// What a participant says of itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Hash of the case it was given; both sides must have been given the same.
    pub case_hash: String,
    /// What it is and exchanges.
    pub description: Description,
}

/// What the coupler says of itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Welcome {
    /// Hash of the case it was given.
    pub case_hash: String,
    /// Space dimension of the case.
    pub dimension: usize,
}

/// Which fields of a direction a message carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// All of them (`Initialize`, `Ready`).
    All,
    /// Those exchanged every window (`Start`, `Solved`, `Restored`).
    EveryWindow,
}

impl Selection {
    /// Whether a field of that exchange is carried.
    pub fn admits(self, exchange: Exchange) -> bool {
        self == Self::All || exchange == Exchange::EveryWindow
    }

    /// Doubles that the selected fields have together.
    pub fn total(self, fields: &Fields) -> usize {
        fields.total(|exchange| self.admits(exchange))
    }

    /// Copies the payload's fields, in the order of their ports, and refuses values that are not finite on
    /// the way.
    pub fn read(self, payload: &[f64], fields: &mut Fields) -> Result<(), ReadError> {
        let expected = self.total(fields);
        if payload.len() != expected {
            let ports: Vec<_> = fields
                .ports()
                .iter()
                .filter(|port| self.admits(port.exchange))
                .map(|port| format!("`{}` {} × {}", port.name, port.points.unwrap_or(0), port.components))
                .collect();
            let ports = if ports.is_empty() { "none".to_owned() } else { ports.join(", ") };
            return Err(ReadError::WrongLength { found: payload.len(), expected, ports });
        }
        let mut rest = payload;
        for (port, array) in fields.iter_mut() {
            if self.admits(port.exchange) {
                let (values, after) = rest.split_at(array.len());
                take_finite(port, values, array)?;
                rest = after;
            }
        }
        Ok(())
    }
}

/// Why fields of a message were not taken.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReadError {
    /// They are more or fewer doubles than the ports have.
    #[error("fields of {found} doubles came where {expected} belong (points × components: {ports})")]
    WrongLength {
        /// Doubles that came.
        found: usize,
        /// Doubles that belong there.
        expected: usize,
        /// The ports, with points and components.
        ports: String,
    },
    /// One of them must not cross.
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// What a message carries behind its header.
#[derive(Clone, Copy, Debug, Default)]
pub struct Payload<'a> {
    /// Doubles that are not fields.
    pub scalars: &'a [f64],
    /// Fields, of which some may be selected.
    pub fields: Option<(&'a Fields, Selection)>,
    /// Bytes of text.
    pub text: &'a [u8],
}

impl<'a> Payload<'a> {
    /// Nothing but text.
    pub fn text(text: &'a [u8]) -> Self {
        Self { text, ..Self::default() }
    }

    /// Its doubles.
    pub fn len(&self) -> usize {
        let fields = self.fields.map_or(0, |(fields, selection)| selection.total(fields));
        self.scalars.len() + fields + words(self.text.len())
    }

    /// Whether it carries nothing.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes it into memory for [`Payload::len`] doubles, and refuses fields with values that are not finite
    /// on the way. Every double of `into` has been written where there is no error.
    pub fn write(&self, into: &mut [MaybeUninit<f64>]) -> Result<(), FieldError> {
        assert_eq!(into.len(), self.len(), "memory is laid out for the payload");
        let (scalars, mut rest) = into.split_at_mut(self.scalars.len());
        for (place, scalar) in scalars.iter_mut().zip(self.scalars) {
            place.write(*scalar);
        }
        if let Some((fields, selection)) = self.fields {
            for (port, array) in fields.iter().filter(|(port, _)| selection.admits(port.exchange)) {
                let (place, after) = rest.split_at_mut(array.len());
                put_finite(port, array, place)?;
                rest = after;
            }
        }
        for (place, word) in rest.iter_mut().zip(packed(self.text)) {
            place.write(word);
        }
        Ok(())
    }
}

/// Doubles that hold so many bytes.
pub fn words(bytes: usize) -> usize {
    bytes.div_ceil(8)
}

/// Bytes in the bits of doubles, [`words`](fn@words) of them, the last padded with zeros.
pub fn packed(bytes: &[u8]) -> impl ExactSizeIterator<Item = f64> {
    bytes.chunks(8).map(|chunk| {
        let mut eight = [0; 8];
        eight[..chunk.len()].copy_from_slice(chunk);
        f64::from_bits(u64::from_ne_bytes(eight))
    })
}

/// The bytes that [`packed`] packed.
pub fn unpack(packed: &[f64], bytes: usize) -> Vec<u8> {
    let used = &packed[..packed.len().min(words(bytes))];
    let mut all: Vec<u8> = used.iter().flat_map(|word| word.to_bits().to_ne_bytes()).collect();
    all.truncate(bytes);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::{offset_of, size_of};

    #[test]
    fn the_header_has_the_documented_layout() {
        assert_eq!(size_of::<MessageHeader>(), 80);
        let offsets = [
            offset_of!(MessageHeader, version),
            offset_of!(MessageHeader, kind),
            offset_of!(MessageHeader, sequence),
            offset_of!(MessageHeader, window),
            offset_of!(MessageHeader, iteration),
            offset_of!(MessageHeader, sub_steps),
            offset_of!(MessageHeader, time),
            offset_of!(MessageHeader, size),
            offset_of!(MessageHeader, compute_seconds),
            offset_of!(MessageHeader, snapshot),
            offset_of!(MessageHeader, scalars),
            offset_of!(MessageHeader, text_bytes),
        ];
        assert_eq!(offsets, [0, 4, 8, 16, 24, 28, 32, 40, 48, 56, 64, 72]);
    }

    #[test]
    fn kinds_have_their_documented_numbers() {
        for number in 1..=16 {
            assert_eq!(Kind::from_number(number).expect("numbers are contiguous") as u32, number);
        }
        assert_eq!((Kind::from_number(0), Kind::from_number(17)), (None, None));
        assert_eq!(Kind::Goodbye as u32, 16);
    }

    #[test]
    fn windows_come_back_as_they_were_sent() {
        for sub_steps in [SubSteps::Stable, SubSteps::Fixed(100)] {
            let window = TimeWindow { index: 7, iteration: 2, start: 0.1, size: 3e-5, sub_steps };
            assert_eq!(MessageHeader::start(4, &window).time_window(), window);
        }
    }

    #[test]
    fn a_payload_is_scalars_then_fields_then_text() {
        use crate::{Direction, Port, Quantity};
        let ports = [
            Port::new("density", Quantity::Density, 2, Some(2), Direction::Out).constant(),
            Port::new("velocity", Quantity::Velocity, 2, Some(1), Direction::Out),
        ];
        let mut fields = Fields::new(&ports, Direction::Out, 0);
        fields.get_mut("density").unwrap().copy_from_slice(&[3.0, 4.0]);
        fields.get_mut("velocity").unwrap().copy_from_slice(&[5.0, 6.0]);
        let text = 8.0_f64.to_ne_bytes();
        let payload = Payload { scalars: &[1.0, 2.0], fields: Some((&fields, Selection::All)), text: &text };
        let written = written(&payload).unwrap();
        assert_eq!(written, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]);
        let mut read = Fields::new(&ports, Direction::Out, 0);
        Selection::EveryWindow.read(&written[4..6], &mut read).unwrap();
        assert_eq!(
            (read.get("density").unwrap(), read.get("velocity").unwrap()),
            (&[0.0; 2][..], &[5.0, 6.0][..])
        );
        assert_eq!(
            Selection::EveryWindow.read(&written, &mut read).unwrap_err().to_string(),
            "fields of 7 doubles came where 2 belong (points × components: `velocity` 1 × 2)"
        );
    }

    /// What a payload writes; a double that it left out is a NaN of bits that nothing else has.
    fn written(payload: &Payload) -> Result<Vec<f64>, FieldError> {
        let mut into = vec![MaybeUninit::new(f64::from_bits(u64::MAX)); payload.len()];
        payload.write(&mut into)?;
        // SAFETY: all were initialised when the vector was made.
        #[expect(unsafe_code, reason = "reading what was written into uninitialised memory")]
        let values: Vec<f64> = into.into_iter().map(|value| unsafe { value.assume_init() }).collect();
        assert!(values.iter().all(|value| value.to_bits() != u64::MAX), "{values:?}");
        Ok(values)
    }

    #[test]
    fn values_that_are_not_finite_are_neither_written_nor_read() {
        use crate::{Direction, Port, Quantity};
        let ports = [Port::new("velocity", Quantity::Velocity, 2, Some(20), Direction::Out)];
        let mut fields = Fields::new(&ports, Direction::Out, 0);
        let mut values = vec![0.5; 40];
        values[33] = f64::NEG_INFINITY;
        fields.get_mut("velocity").unwrap().copy_from_slice(&values);
        let refused = "field `velocity` is not finite: component 1 at point 16 is -inf";
        let payload = Payload { fields: Some((&fields, Selection::All)), ..Payload::default() };
        assert_eq!(written(&payload).unwrap_err().to_string(), refused);
        let read = Selection::All.read(&values, &mut fields);
        assert_eq!(read.unwrap_err().to_string(), refused);
    }

    #[test]
    fn text_of_any_length_and_any_bytes_comes_back() {
        for length in [0, 1, 7, 8, 9, 4099] {
            // The bytes of signalling and quiet NaNs among them.
            let bytes: Vec<u8> =
                (0..length).map(|i| if i % 8 > 5 { 0xff } else { (i % 251) as u8 }).collect();
            let packed: Vec<f64> = packed(&bytes).collect();
            assert_eq!((packed.len(), unpack(&packed, length)), (words(length), bytes));
        }
    }
}
