//! The first iterate of a window from the last windows' outcomes.

use std::collections::VecDeque;
use words::bytes::{self, Reader, Writer};

/// Outcomes of the last windows with the middle of their windows (s), the newest first.
#[derive(Clone, Debug)]
pub struct Extrapolation {
    order: usize,
    /// The first iterate of the first window; nothing until it begins.
    initial: Vec<f64>,
    outcomes: VecDeque<(f64, Vec<f64>)>,
}

impl Extrapolation {
    /// Order 0 takes the last outcome, order 1 and 2 the line and the parabola through the last two and
    /// three.
    pub fn new(order: usize) -> Self {
        Self { order, initial: Vec::new(), outcomes: VecDeque::new() }
    }

    /// Takes the `initial` values, which stand in before the first window.
    pub fn begin(&mut self, initial: &[f64]) {
        self.initial = initial.to_vec();
    }

    /// Fills `x` for the window with its middle at `time` (s).
    pub fn guess(&self, time: f64, x: &mut [f64]) {
        let points: Vec<f64> = self.outcomes.iter().map(|(t, _)| *t).collect();
        if points.is_empty() {
            x.copy_from_slice(&self.initial);
            return;
        }
        x.fill(0.0);
        for (i, (own, outcome)) in self.outcomes.iter().enumerate() {
            let others = points.iter().enumerate().filter(|(j, _)| *j != i);
            let weight: f64 = others.map(|(_, other)| (time - other) / (own - other)).product();
            for (x, outcome) in x.iter_mut().zip(outcome) {
                *x += weight * outcome;
            }
        }
    }

    /// Remembers the outcome of the window with its middle at `time` (s).
    pub fn accept(&mut self, time: f64, outcome: &[f64]) {
        let mut values = if self.outcomes.len() > self.order { self.outcomes.pop_back() } else { None }
            .unwrap_or_default();
        values.0 = time;
        values.1.clear();
        values.1.extend_from_slice(outcome);
        self.outcomes.push_front(values);
    }

    /// Writes the outcomes. The initial values count for nothing once there is one.
    pub fn save(&self, state: &mut Writer) {
        let outcomes: Vec<_> = self.outcomes.iter().collect();
        state.list(&outcomes, |state, (time, outcome)| {
            state.f64(*time);
            state.f64s(outcome);
        });
    }

    /// Goes to what [`save`](Self::save) wrote, of so many unknowns.
    pub fn restore(&mut self, state: &mut Reader<'_>, unknowns: usize) -> Result<(), bytes::Error> {
        let outcomes = state.list("outcomes", None, |state| {
            Ok((state.f64("time of an outcome")?, state.f64s("unknowns of an outcome", Some(unknowns))?))
        })?;
        if outcomes.len() > self.order + 1 {
            let found = format!("{} outcomes of an order of {}", outcomes.len(), self.order);
            return Err(state.refuse("extrapolation", found));
        }
        self.outcomes = outcomes.into();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_the_order_are_continued_exactly() {
        for order in 0..3 {
            let value = |t: f64| [1.0, 2.0 + t, 3.0 - t + t * t][order];
            let mut extrapolation = Extrapolation::new(order);
            extrapolation.begin(&[7.0]);
            let mut x = [1e9];
            extrapolation.guess(0.0, &mut x);
            assert_eq!(x, [7.0], "nothing is known before the first window");
            // Unequal windows.
            for t in [0.0, 0.5, 0.8, 1.6] {
                extrapolation.accept(t, &[value(t)]);
            }
            extrapolation.guess(2.0, &mut x);
            assert!((x[0] - value(2.0)).abs() < 1e-14, "{order}: {x:?}");
        }
    }
}
