//! A participant without a partner: the same windows and records, nothing to exchange.

use super::{Accepted, SchemeError, Solver};
use crate::schedule::Schedule;
use crate::side::Side;
use interfaces::TimeWindow;
use words::bytes::{self, Reader, Writer};

impl Solver for Side {
    fn window_limit(&self) -> f64 {
        self.window_limit
    }

    fn solve(&mut self, window: TimeWindow, schedule: &mut Schedule) -> Result<Accepted, SchemeError> {
        self.solve_window(&window)?;
        let ends = self.asks_for_end();
        let output = if ends { schedule.accept_last(&window) } else { schedule.accept(&window) };
        self.accept(&window, output)?;
        Ok(Accepted { window, time: schedule.time(), output, condition46: None, applied: None })
    }

    fn ending(&self) -> Option<String> {
        self.asks_for_end().then(|| format!("the {} asked for it", self.role()))
    }

    fn sides(&self) -> impl AsRef<[&Side]> {
        [self]
    }

    fn sides_mut(&mut self) -> impl IntoIterator<Item = &mut Side> {
        [self]
    }

    fn save(&self, state: &mut Writer) {
        Side::save(self, state);
    }

    fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        Side::restore(self, state)
    }
}
