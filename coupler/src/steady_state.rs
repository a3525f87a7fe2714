//! Whether anything at the interface still changes.

use interfaces::case::coupling::{SteadyQuantity, SteadyState as Choice};
use words::bytes::{self, Reader, Writer};

/// Watches the quantities that the case names.
///
/// The relative change of a quantity `q` per time is `‖qⁿ⁺¹ − qⁿ‖ / (Δt · max ‖q − q⁰‖)`, the greatest
/// departure from the start so far being the scale: a velocity that dies out is small against what it was,
/// and a position does not depend on where the origin is. What never changed is steady.
#[derive(Clone, Debug)]
pub struct SteadyState {
    choice: Choice,
    tracked: Vec<Tracked>,
    /// Time since which all changes are below the bound (s).
    since: Option<f64>,
}

#[derive(Clone, Debug)]
struct Tracked {
    initial: Vec<f64>,
    last: Vec<f64>,
    departure: f64,
}

impl SteadyState {
    /// From the values at the start.
    pub fn new<'a>(choice: Choice, value: impl Fn(SteadyQuantity) -> &'a [f64]) -> Self {
        let track = |quantity: &SteadyQuantity| {
            let initial = value(*quantity).to_vec();
            Tracked { last: initial.clone(), initial, departure: 0.0 }
        };
        let tracked = choice.quantities.iter().map(track).collect();
        Self { choice, tracked, since: None }
    }

    /// Writes what later windows are held against.
    pub fn save(&self, state: &mut Writer) {
        state.list(&self.tracked, |state, Tracked { initial, last, departure }| {
            state.f64s(initial);
            state.f64s(last);
            state.f64(*departure);
        });
        state.option(self.since.as_ref(), |state, since| state.f64(*since));
    }

    /// Goes to what [`save`](Self::save) wrote.
    pub fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        let lengths: Vec<usize> = self.tracked.iter().map(|tracked| tracked.initial.len()).collect();
        let mut lengths = lengths.into_iter();
        self.tracked = state.list("quantities of the steady state", Some(self.tracked.len()), |state| {
            let expected = lengths.next();
            Ok(Tracked {
                initial: state.f64s("initial values", expected)?,
                last: state.f64s("last values", expected)?,
                departure: state.f64("greatest departure")?,
            })
        })?;
        self.since = state.option("time of steadiness", |state| state.f64("time of steadiness"))?;
        Ok(())
    }

    /// After a window from `start` (s) of `size` (s): what is steady, if all has been for long enough.
    pub fn observe<'a>(
        &mut self,
        start: f64,
        size: f64,
        value: impl Fn(SteadyQuantity) -> &'a [f64],
    ) -> Option<String> {
        let mut steady = true;
        for (quantity, tracked) in self.choice.quantities.iter().zip(&mut self.tracked) {
            let now = value(*quantity);
            tracked.departure = tracked.departure.max(distance(now, &tracked.initial));
            // Not the other way round: what is no number is not steady.
            let change = distance(now, &tracked.last);
            steady &= change <= self.choice.rate * size * tracked.departure;
            tracked.last.copy_from_slice(now);
        }
        if !steady {
            self.since = None;
            return None;
        }
        let since = *self.since.get_or_insert(start);
        let lasted = start + size - since;
        // A duration that is a whole number of windows is not to take one more for rounding.
        (lasted >= self.choice.duration * (1.0 - 1e-9)).then(|| {
            format!(
                "a steady state: less than {:e} of its greatest departure from the start changed per second for {:.6} s at the interface",
                self.choice.rate, lasted
            )
        })
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(quantities: &[SteadyQuantity]) -> Choice {
        Choice { quantities: quantities.to_vec(), rate: 0.1, duration: 0.5 }
    }

    #[test]
    fn a_decay_is_steady_when_its_rate_is_below_the_bound_for_long_enough() {
        // q = 1 − e⁻ᵗ departs by at most 1 and changes by e⁻ᵗ a second: below 0.1 from about t = ln 10 = 2.30
        // on.
        let mut value = vec![0.0, 5.0];
        let choice = choice(&[SteadyQuantity::Position]);
        let mut steady = SteadyState::new(choice, |_| &[0.0, 5.0]);
        let size = 0.01;
        let ended = (0..).find(|step| {
            let start = f64::from(*step) * size;
            value[0] = 1.0 - (-(start + size)).exp();
            steady.observe(start, size, |_| value.as_slice()).is_some()
        });
        let end = f64::from(ended.unwrap() + 1) * size;
        // The departure is 0.9 by then: e⁻ᵗ = 0.1 (1 − e⁻ᵗ), t = ln 11 = 2.40; a window and the half second.
        assert!((end - (11.0_f64.ln() + 0.5)).abs() < 2.0 * size, "{end}");
    }

    #[test]
    fn what_never_changed_is_steady_and_one_that_changes_keeps_the_run_going() {
        use SteadyQuantity::{Load, Position};
        let mut still = SteadyState::new(choice(&[Position]), |_| &[1.0]);
        let ends: Vec<bool> =
            (0..3).map(|n| still.observe(0.25 * f64::from(n), 0.25, |_| &[1.0]).is_some()).collect();
        assert_eq!(ends, [false, true, true]);
        let mut moving = SteadyState::new(choice(&[Position, Load]), |_| &[1.0]);
        for n in 0..10 {
            let load = [1.0 + f64::from(n + 1)];
            let at = |quantity| if quantity == Load { &load[..] } else { &[1.0] };
            assert!(moving.observe(0.25 * f64::from(n), 0.25, at).is_none());
        }
    }

    #[test]
    fn what_is_no_number_is_not_steady() {
        let mut steady = SteadyState::new(choice(&[SteadyQuantity::Load]), |_| &[1.0]);
        for n in 0..5 {
            assert!(steady.observe(f64::from(n), 1.0, |_| &[f64::NAN]).is_none());
        }
    }
}
