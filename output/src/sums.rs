//! What `summary.json` says of all windows, kept while they come: no table is read again at a run's end.

/// A residual over the windows so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualSum {
    /// Largest; not-a-number from the first such value on, until a greater one comes.
    pub max: f64,
    /// Sum of the squares.
    pub squares: f64,
    /// How many.
    pub count: f64,
}

impl Default for ResidualSum {
    fn default() -> Self {
        Self { max: f64::NEG_INFINITY, squares: 0.0, count: 0.0 }
    }
}

impl ResidualSum {
    /// One more value.
    pub fn add(&mut self, value: f64) {
        // `f64::max` would drop a not-a-number, which has to be seen.
        if value > self.max || value.is_nan() {
            self.max = value;
        }
        self.squares += value * value;
        self.count += 1.0;
    }
}

/// The energy of the whole over the windows so far (J).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergySum {
    /// Of the first window.
    pub start: f64,
    /// Of the last.
    pub end: f64,
    /// Smallest.
    pub lowest: f64,
    /// Largest rise above what was the smallest before.
    pub rise: f64,
}

impl EnergySum {
    /// Of the first window.
    pub fn new(energy: f64) -> Self {
        let rise = if energy.is_nan() { f64::NAN } else { 0.0 };
        Self { start: energy, end: energy, lowest: energy, rise }
    }

    /// One more window. A rise over what is not a number is none.
    pub fn add(&mut self, energy: f64) {
        self.end = energy;
        self.lowest = energy.min(self.lowest);
        self.rise = match energy.is_nan() || self.rise.is_nan() {
            true => f64::NAN,
            false => (energy - self.lowest).max(self.rise),
        };
    }
}
