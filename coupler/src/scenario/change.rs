//! One change of a quantity: where, when, and what is done to its values.

use interfaces::{Direction, Role};
use std::collections::VecDeque;
use std::fmt;
use words::bytes::{Error, Reader, Writer};

/// A quantity is other than its giver has it, for a while.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Its number in the file, from 0.
    pub number: usize,
    /// Which quantity.
    pub place: Place,
    /// In windows that start then or later (s).
    pub from: f64,
    /// And before this time (s).
    pub until: f64,
    /// At these points, as the participant counts them from 0; at all where left out.
    pub points: Option<Vec<usize>>,
    /// In this component, from 0; in all where left out.
    pub component: Option<usize>,
    /// What is done.
    pub how: How,
}

/// A quantity on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The participant.
    pub role: Role,
    /// Whether it takes it, as it comes from the coupler, or gives it.
    pub direction: Direction,
    /// Name of its port.
    pub quantity: String,
}

/// What is done to values, each in the unit of its quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum How {
    /// They are this.
    Override(f64),
    /// This is added.
    Bias(f64),
    /// They are multiplied by this.
    Scale(f64),
    /// They are those of so long ago (s), linear between the ends of windows.
    Delay(f64),
    /// They stay what they were when the change began.
    Drop,
    /// A normally distributed value of this deviation is added, the same to every iteration of a window.
    Noise {
        /// The standard deviation.
        deviation: f64,
        /// What the values are made from.
        seed: u64,
    },
    /// They are spoilt.
    Corrupt(Corrupt),
}

/// How a value is spoilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Corrupt {
    /// It is not a number.
    NotANumber,
    /// It is infinite.
    Infinite,
    /// One of its bits is turned over, 0 the smallest, 63 the sign.
    Bit(u32),
}

impl Corrupt {
    /// As it is written.
    pub(super) fn from_word(word: &str) -> Option<Self> {
        match word {
            "not-a-number" => Some(Self::NotANumber),
            "infinite" => Some(Self::Infinite),
            _ => word.strip_prefix("bit:")?.parse().ok().filter(|bit| *bit < 64).map(Self::Bit),
        }
    }

    fn of(self, value: f64) -> f64 {
        match self {
            Self::NotANumber => f64::NAN,
            Self::Infinite => f64::INFINITY,
            Self::Bit(bit) => f64::from_bits(value.to_bits() ^ 1 << bit),
        }
    }
}

impl How {
    /// The same, if its numbers make sense.
    pub(super) fn checked(self) -> Result<Self, String> {
        let finite = |key: &str, value: f64| match value.is_finite() {
            true => Ok(self),
            false => Err(format!("{key} = {value}: it has to be finite; to spoil a value write corrupt")),
        };
        match self {
            Self::Override(value) => finite("override", value),
            Self::Bias(value) => finite("bias", value),
            Self::Scale(value) => finite("scale", value),
            Self::Delay(seconds) if seconds.is_nan() || seconds < 0.0 || seconds.is_infinite() => {
                Err(format!("delay = {seconds}: it has to be 0 or more; give it in s"))
            }
            Self::Noise { deviation, .. } if deviation.is_nan() || deviation < 0.0 => {
                Err(format!("noise = {deviation}: it has to be 0 or more; give the standard deviation"))
            }
            Self::Noise { deviation, .. } => finite("noise", deviation),
            Self::Delay(_) | Self::Drop | Self::Corrupt(_) => Ok(self),
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { role, direction, quantity } = &self.place;
        let way = if *direction == Direction::Out { "given by" } else { "taken by" };
        write!(f, "{quantity} {way} the {role}")?;
        if let Some(component) = self.component {
            write!(f, ", component {}", ["x", "y", "z"].get(component).unwrap_or(&"?"))?;
        }
        match self.points.as_deref() {
            None => {}
            Some([point]) => write!(f, ", point {point}")?,
            Some(points) => write!(f, ", {} points", points.len())?,
        }
        match self.how {
            How::Override(value) => write!(f, ": {value}"),
            How::Bias(value) => write!(f, ": {value} added"),
            How::Scale(value) => write!(f, ": times {value}"),
            How::Delay(seconds) => write!(f, ": late by {seconds} s"),
            How::Drop => write!(f, ": dropped, the last value stays"),
            How::Noise { deviation, seed } => {
                write!(f, ": noise of deviation {deviation} added, seed {seed}")
            }
            How::Corrupt(Corrupt::NotANumber) => write!(f, ": not a number"),
            How::Corrupt(Corrupt::Infinite) => write!(f, ": infinite"),
            How::Corrupt(Corrupt::Bit(bit)) => write!(f, ": bit {bit} turned over"),
        }
    }
}

/// What a change remembers over the windows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Memory {
    /// Ends of accepted windows (s) and the values then, as they were before the change; as many as are
    /// needed.
    past: VecDeque<(f64, Vec<f64>)>,
    /// Values of the solution at hand.
    now: Vec<f64>,
    /// Accepted windows in which it acted.
    pub windows: u64,
    /// Where the first of them started (s).
    pub first: f64,
}

impl Memory {
    /// Values at the start (s).
    pub fn begin(&mut self, time: f64, values: &[f64]) {
        self.past = VecDeque::from([(time, values.to_vec())]);
    }

    /// The window is accepted, which the change `acted` in.
    pub fn accept(&mut self, change: &Change, start: f64, end: f64) {
        let acted = change.acts(start);
        if acted {
            self.first = if self.windows == 0 { start } else { self.first };
            self.windows += 1;
        }
        let keeps = match change.how {
            How::Delay(seconds) => {
                // One at or before what is asked for next is enough.
                while self.past.get(1).is_some_and(|(time, _)| *time <= end - seconds) {
                    self.past.pop_front();
                }
                true
            }
            How::Drop => {
                if !acted {
                    self.past.clear();
                }
                !acted
            }
            _ => false,
        };
        if keeps {
            self.past.push_back((end, std::mem::take(&mut self.now)));
        }
    }

    pub fn save(&self, state: &mut Writer) {
        state.u64(self.windows);
        state.f64(self.first);
        state.usize(self.past.len());
        for (time, values) in &self.past {
            state.f64(*time);
            state.f64s(values);
        }
    }

    pub fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), Error> {
        self.windows = state.u64("windows with a change")?;
        self.first = state.f64("first change")?;
        let count = state.usize("values of a change")?;
        self.past.clear();
        for _ in 0..count {
            let time = state.f64("time of a value")?;
            self.past.push_back((time, state.f64s("values of a change", None)?));
        }
        Ok(())
    }

    /// The values at `time`, `now` being those at `end`.
    fn at(&self, time: f64, end: f64, index: usize, now: f64) -> f64 {
        let value = |(at, values): &(f64, Vec<f64>)| (*at, values.get(index).copied().unwrap_or(now));
        let before = self.past.iter().rev().find(|(at, _)| *at <= time).map(value);
        let after = self.past.iter().find(|(at, _)| *at > time).map_or((end, now), value);
        match before {
            None => after.1,
            Some((_, old)) if after.0 <= time => {
                if time >= end {
                    now
                } else {
                    old
                }
            }
            // Of the time before a branch nothing is known but its values.
            Some((f64::NEG_INFINITY, old)) => old,
            Some((at, old)) => old + (after.1 - old) * ((time - at) / (after.0 - at)),
        }
    }
}

impl Change {
    /// Whether it acts in a window that starts then (s).
    pub(super) fn acts(&self, start: f64) -> bool {
        self.from <= start && start < self.until
    }

    /// Changes values of `components` a point, in the window from `start` to `end` (s) of that number.
    pub(super) fn apply(
        &self,
        memory: &mut Memory,
        (window, start, end): (u64, f64, f64),
        components: usize,
        values: &mut [f64],
    ) {
        if matches!(self.how, How::Delay(_) | How::Drop) {
            memory.now.clear();
            memory.now.extend_from_slice(values);
        }
        if !self.acts(start) {
            return;
        }
        let count = values.len() / components.max(1);
        let all = 0..count;
        let mut one = |point: usize| {
            for component in (0..components).filter(|c| self.component.is_none_or(|only| only == *c)) {
                let index = point * components + component;
                let Some(value) = values.get_mut(index) else { continue };
                *value = match self.how {
                    How::Override(new) => new,
                    How::Bias(more) => *value + more,
                    How::Scale(factor) => *value * factor,
                    How::Delay(seconds) => memory.at(end - seconds, end, index, *value),
                    How::Drop => memory.past.back().map_or(*value, |(_, past)| past[index]),
                    How::Noise { deviation, seed } => *value + deviation * normal(seed, window, index),
                    How::Corrupt(corrupt) => corrupt.of(*value),
                };
            }
        };
        match &self.points {
            Some(points) => points.iter().copied().for_each(&mut one),
            None => all.for_each(&mut one),
        }
    }
}

/// A value of the standard normal distribution (Box and Muller 1958), from uniform ones (SplitMix64; Steele,
/// Lea and Flood 2014) that window and index alone decide.
fn normal(seed: u64, window: u64, index: usize) -> f64 {
    let mut state = seed ^ window.wrapping_mul(0xd134_2543_de82_ef95) ^ (index as u64).rotate_left(32);
    let mut uniform = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (one, two) = (1.0 - uniform(), uniform());
    (-2.0 * one.ln()).sqrt() * (std::f64::consts::TAU * two).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(how: How) -> Change {
        let place =
            Place { role: Role::Fluid, direction: Direction::Out, quantity: "pressure_gradient".to_owned() };
        Change { number: 0, place, from: 0.2, until: 0.5, points: None, component: None, how }
    }

    /// What becomes of `1, 2, 3, …` at the ends of windows of 0.1 s, 0 at the start.
    fn ramp(change: &Change) -> Vec<f64> {
        let mut memory = Memory::default();
        memory.begin(0.0, &[0.0]);
        let ends = (0..7).map(|window| {
            let (start, end) = (0.1 * f64::from(window), 0.1 * f64::from(window + 1));
            // An iterate that is rejected leaves nothing.
            change.apply(&mut memory, (window as u64, start, end), 1, &mut [77.0]);
            let mut values = [f64::from(window + 1)];
            change.apply(&mut memory, (window as u64, start, end), 1, &mut values);
            memory.accept(change, start, end);
            values[0]
        });
        ends.collect()
    }

    #[test]
    fn every_change_acts_in_its_windows_only() {
        assert_eq!(ramp(&change(How::Override(9.0))), [1.0, 2.0, 9.0, 9.0, 9.0, 6.0, 7.0]);
        assert_eq!(ramp(&change(How::Bias(0.5))), [1.0, 2.0, 3.5, 4.5, 5.5, 6.0, 7.0]);
        assert_eq!(ramp(&change(How::Scale(2.0))), [1.0, 2.0, 6.0, 8.0, 10.0, 6.0, 7.0]);
        assert_eq!(ramp(&change(How::Drop)), [1.0, 2.0, 2.0, 2.0, 2.0, 6.0, 7.0]);
        let spoilt = ramp(&change(How::Corrupt(Corrupt::Bit(63))));
        assert_eq!(spoilt, [1.0, 2.0, -3.0, -4.0, -5.0, 6.0, 7.0]);
        assert!(ramp(&change(How::Corrupt(Corrupt::NotANumber)))[2].is_nan());
        // By less than a window, by more, and by more than there was.
        for (delay, values) in [(0.05, [2.5, 3.5, 4.5]), (0.15, [1.5, 2.5, 3.5]), (0.35, [0.0, 0.5, 1.5])] {
            for (found, wanted) in ramp(&change(How::Delay(delay)))[2..5].iter().zip(values) {
                assert!((found - wanted).abs() < 1e-12, "{delay}: {found} for {wanted}");
            }
        }
        assert_eq!(ramp(&change(How::Delay(0.0))), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    }

    #[test]
    fn noise_is_normal_and_the_same_again() {
        let values: Vec<f64> = (0..20_000).map(|n| normal(3, n % 100, n as usize)).collect();
        let mean = values.iter().sum::<f64>() / 2e4;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 2e4;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "{mean} {variance}");
        assert_eq!(normal(3, 7, 11), normal(3, 7, 11));
        assert_ne!(normal(4, 7, 11), normal(3, 7, 11));
    }

    #[test]
    fn points_and_components_are_met() {
        let only = Change { points: Some(vec![1, 9]), component: Some(1), ..change(How::Override(5.0)) };
        let mut values = [0.0; 6];
        only.apply(&mut Memory::default(), (2, 0.2, 0.3), 2, &mut values);
        assert_eq!(values, [0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    }

    #[test]
    fn a_memory_is_saved_whole() {
        let mut memory = Memory::default();
        let late = change(How::Delay(0.2));
        memory.begin(0.0, &[1.0, 2.0]);
        late.apply(&mut memory, (0, 0.3, 0.4), 2, &mut [3.0, 4.0]);
        memory.accept(&late, 0.3, 0.4);
        let mut state = Writer::new(b"test0001");
        memory.save(&mut state);
        let bytes = state.finish();
        let mut other = Memory::default();
        other.restore(&mut Reader::new("memory", b"test0001", &bytes).unwrap()).unwrap();
        assert_eq!(other, memory);
    }
}
