//! What `summary.json` says of all windows, kept while they come: no table is read again at a run's end.

use words::balances;

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

/// The energies of the whole at one time (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Of motion.
    pub kinetic: f64,
    /// Of gravity, with all that left the run.
    pub potential: f64,
    /// Of strain, and of contact.
    pub strain: f64,
}

impl Energies {
    /// Adds the value (J) of a participant's balance, if it is one of these energies. Says whether it is.
    pub fn add(&mut self, name: &str, value: f64) -> bool {
        let part = match name {
            balances::KINETIC_ENERGY => &mut self.kinetic,
            balances::POTENTIAL_ENERGY | balances::LEFT_ENERGY => &mut self.potential,
            balances::STRAIN_ENERGY | balances::CONTACT_ENERGY => &mut self.strain,
            _ => return false,
        };
        *part += value;
        true
    }

    /// Their sum (J).
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential + self.strain
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
    /// Least of each kind.
    pub least: Energies,
    /// Most of each kind.
    pub most: Energies,
}

impl EnergySum {
    /// Of the first window.
    pub fn new(energies: Energies) -> Self {
        let total = energies.total();
        let rise = if total.is_nan() { f64::NAN } else { 0.0 };
        Self { start: total, end: total, lowest: total, rise, least: energies, most: energies }
    }

    /// One more window. A rise over what is not a number is none.
    pub fn add(&mut self, energies: Energies) {
        let total = energies.total();
        self.end = total;
        self.lowest = total.min(self.lowest);
        self.rise = match total.is_nan() || self.rise.is_nan() {
            true => f64::NAN,
            false => (total - self.lowest).max(self.rise),
        };
        let of_each = |a: &Energies, pick: fn(f64, f64) -> f64| Energies {
            kinetic: pick(a.kinetic, energies.kinetic),
            potential: pick(a.potential, energies.potential),
            strain: pick(a.strain, energies.strain),
        };
        (self.least, self.most) = (of_each(&self.least, f64::min), of_each(&self.most, f64::max));
    }

    /// The energy that the motion has (J): the largest of the greatest kinetic energy, and of what the
    /// energies of gravity and strain went through. It depends on no origin.
    pub fn moved(&self) -> f64 {
        let (least, most) = (&self.least, &self.most);
        most.kinetic.max(most.potential - least.potential).max(most.strain - least.strain)
    }
}
