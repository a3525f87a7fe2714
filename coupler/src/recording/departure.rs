//! Where what crosses now departs from what was recorded, and by how much.

use super::entry::is_kept;
use interfaces::{Fields, TimeWindow};
use std::collections::BTreeMap;
use std::fmt;

/// Where in a run something crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// At initialisation.
    Initialisation,
    /// In a solution of a window.
    Solution(TimeWindow),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Initialisation => f.write_str("at initialisation"),
            Self::Solution(TimeWindow { index, iteration, start, .. }) => {
                write!(f, "in window {index} (iteration {iteration}) from t = {start} s")
            }
        }
    }
}

/// A value of a field that is another than recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Departure {
    /// Where.
    pub place: Place,
    /// The field.
    pub field: String,
    /// Its unit.
    pub unit: String,
    /// The interface point.
    pub point: usize,
    /// The component of the value.
    pub component: usize,
    /// What was recorded.
    pub recorded: f64,
    /// What crosses now.
    pub now: f64,
}

impl Departure {
    /// What crosses now without what was recorded.
    pub fn difference(&self) -> f64 {
        self.now - self.recorded
    }

    /// Recorded value, new value and difference, in words.
    pub fn amounts(&self) -> String {
        let Self { recorded, now, unit, .. } = self;
        // What is shown with the fewest digits that read back tells neighbours apart, and zeros by the bits.
        format!(
            "recorded {recorded:e} {unit} (bits {:016x}), now {now:e} {unit} (bits {:016x}), difference {:.3e} {unit}",
            recorded.to_bits(),
            now.to_bits(),
            self.difference()
        )
    }
}

impl fmt::Display for Departure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, field, point, component, .. } = self;
        write!(f, "{place}, field `{field}`, point {point}, component {component}: {}", self.amounts())
    }
}

/// All departures of a replay, of each field the largest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Departures {
    /// Solutions that were compared.
    pub solutions: u64,
    /// Of them those whose inputs depart.
    pub departed: u64,
    /// The largest of each field.
    pub largest: BTreeMap<String, Departure>,
    /// What departs otherwise: times and order of calls, the first of it.
    pub otherwise: Option<String>,
}

impl Departures {
    /// Compares what crosses now with what was recorded, bit by bit, and gives the first departure and the
    /// number of values that depart.
    ///
    /// # Errors
    /// Fields of other lengths, in words.
    pub(super) fn compare(
        &mut self,
        place: Place,
        recorded: &[Vec<f64>],
        now: &Fields,
    ) -> Result<Option<(Departure, usize)>, String> {
        let kept = now.iter().filter(|(port, _)| is_kept(port, place == Place::Initialisation));
        let (mut first, mut count) = (None, 0);
        for ((port, now), recorded) in kept.zip(recorded) {
            if now.len() != recorded.len() {
                let (field, now, was) = (&port.name, now.len(), recorded.len());
                return Err(format!("{place}, field `{field}` has {now} values, and {was} were recorded"));
            }
            let pairs = recorded.iter().zip(now).enumerate();
            for (at, (was, is)) in pairs.filter(|(_, (was, is))| was.to_bits() != is.to_bits()) {
                count += 1;
                let departure = || Departure {
                    place,
                    field: port.name.clone(),
                    unit: port.unit.clone(),
                    point: at / port.components,
                    component: at % port.components,
                    recorded: *was,
                    now: *is,
                };
                first.get_or_insert_with(departure);
                let largest = self.largest.entry(port.name.clone()).or_insert_with(departure);
                if (is - was).abs() > largest.difference().abs() {
                    *largest = departure();
                }
            }
        }
        self.solutions += 1;
        self.departed += u64::from(count > 0);
        Ok(first.map(|first| (first, count)))
    }

    /// What became of it, a line each.
    pub fn summary(&self) -> Vec<String> {
        let Self { solutions, departed, largest, otherwise } = self;
        if largest.is_empty() && otherwise.is_none() {
            return vec![format!("replayed {solutions} inputs, all of them as recorded, to the bit")];
        }
        let mut lines =
            vec![format!("replayed {solutions} inputs, of which {departed} depart from the recording")];
        lines.extend(otherwise.iter().map(|what| format!("  {what}")));
        lines.extend(largest.values().map(|departure| format!("  largest departure: {departure}")));
        lines
    }
}
