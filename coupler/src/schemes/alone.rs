//! A participant without a partner: the same windows and records, nothing to exchange.

use super::{Accepted, Onward, SchemeError};
use crate::schedule::Schedule;
use crate::side::Side;

/// Runs `side` from an initialised state over the schedule. `record` hears of every accepted window.
pub fn run(
    side: &mut Side,
    schedule: &mut Schedule,
    mut record: impl FnMut(&Accepted, &Side) -> Result<Onward, SchemeError>,
) -> Result<(), SchemeError> {
    while let Some(window) = schedule.next(side.window_limit) {
        side.solve(&window)?;
        let ends = side.asks_for_end();
        let output = if ends { schedule.accept_last(&window) } else { schedule.accept(&window) };
        side.accept(&window, output)?;
        let accepted = Accepted::alone(window, schedule.time(), output);
        if record(&accepted, side)? == Onward::Stop {
            break;
        }
    }
    Ok(())
}
