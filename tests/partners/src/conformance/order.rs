//! What must be refused, and leave the participant as it was.

use super::life::Life;
use super::{Check, Suite};
use interfaces::lifecycle::LEGAL;
use interfaces::{
    Call, FieldError, Fields, IllegalCall, Participant, ParticipantError, Result, State, TimeWindow,
};

const STATES: [State; 6] =
    [State::Created, State::Ready, State::Solving, State::Solved, State::Terminated, State::Broken];

/// Every call in every state: legal ones succeed and lead where the table says, the others are refused.
pub(super) fn table(suite: &Suite) -> Check {
    let undisturbed = Life::initialized(suite)?.solve(0)?;
    for state in STATES {
        let mut life = Life::in_state(suite, state)?;
        for (call, from, to, _) in LEGAL {
            if from.contains(&state) {
                legal(suite, *call, state, *to)?;
                continue;
            }
            let refused = life.call(*call, &[]);
            if !matches!(refused, Err(ParticipantError::IllegalCall(IllegalCall { .. }))) {
                return Err(format!("`{call}` when {state} gave {refused:?}"));
            }
            if life.participant.state() != state {
                let now = life.participant.state();
                return Err(format!("`{call}` was refused when {state}, and left it {now}"));
            }
        }
        if state == State::Solving {
            let answer = life.finish().map_err(|error| format!("`finish` failed: {error}"))?;
            undisturbed.same_as(&answer, "without and with calls that were refused")?;
        }
    }
    Ok(())
}

fn legal(suite: &Suite, call: Call, state: State, to: State) -> Check {
    let saves = matches!(call, Call::Save | Call::Restore);
    if saves && !suite.options.can_save {
        return Ok(());
    }
    let saved = if call == Call::Restore { Life::initialized(suite)?.save()? } else { Vec::new() };
    let mut life = Life::in_state(suite, state)?;
    life.call(call, &saved).map_err(|error| format!("`{call}` failed when {state}: {error}"))?;
    match life.participant.state() {
        found if found == to => Ok(()),
        found => Err(format!("`{call}` when {state} led to {found} and not to {to}")),
    }
}

/// Windows out of turn, solved before, or of no size.
pub(super) fn wrong_windows(suite: &Suite) -> Check {
    let mut life = Life::initialized(suite)?;
    life.advance(0)?;
    life.solve(0)?;
    let next = life.window();
    let wrong = [
        TimeWindow { index: 0, ..next },
        TimeWindow { index: 2, ..next },
        TimeWindow { iteration: 0, ..next },
        TimeWindow { size: 0.0, ..next },
        TimeWindow { size: -next.size, ..next },
        TimeWindow { size: f64::NAN, ..next },
        TimeWindow { size: f64::INFINITY, ..next },
        TimeWindow { start: f64::NAN, ..next },
    ];
    for window in wrong {
        let refused = life.participant.start(&window, &life.inputs);
        if !matches!(refused, Err(ParticipantError::WrongWindow { .. })) {
            return Err(format!("{window:?} gave {refused:?}"));
        }
        if life.participant.state() != State::Solved {
            return Err(format!("{window:?} was refused, and left it {}", life.participant.state()));
        }
    }
    life.advance(0).map(drop).map_err(|what| format!("after windows that were refused: {what}"))
}

/// A single value that is not finite, in every field taken.
pub(super) fn not_finite(suite: &Suite) -> Check {
    let mut life = Life::new(suite, Vec::new());
    (suite.options.inputs)(suite.options.start, 0, &mut life.inputs);
    for spoilt in spoilt(&life.inputs) {
        let start = suite.options.start;
        let refused = life.participant.initialize(start, &spoilt, &mut life.outputs).map(drop);
        refused_field(&refused, "initialize")?;
        if life.participant.state() != State::Created {
            return Err(format!("it refused the field, and is {}", life.participant.state()));
        }
    }
    life.initialize().map_err(|error| format!("`initialize` failed after a refusal: {error}"))?;
    for spoilt in spoilt(&life.inputs) {
        let window = life.window();
        let refused = life.participant.start(&window, &spoilt);
        refused_field(&refused, "start")?;
        if life.participant.state() != State::Ready {
            return Err(format!("it refused the field, and is {}", life.participant.state()));
        }
    }
    life.advance(0).map(drop).map_err(|what| format!("after a refusal: {what}"))
}

fn refused_field(refused: &Result<()>, call: &str) -> Check {
    match refused {
        Err(ParticipantError::Field(FieldError::NotFinite { .. })) => Ok(()),
        other => Err(format!("`{call}` with a value that is not finite gave {other:?}")),
    }
}

/// Copies of the fields, each with the last value of one of them spoilt.
fn spoilt(fields: &Fields) -> Vec<Fields> {
    let names = fields.iter().filter(|(_, array)| !array.is_empty()).map(|(port, _)| port.name.clone());
    let spoil = |(number, name): (usize, String)| {
        let mut copy = fields.clone();
        let value = if number % 2 == 0 { f64::NAN } else { f64::INFINITY };
        let array = copy.get_mut(&name).expect("a field of that name");
        *array.last_mut().expect("not empty") = value;
        copy
    };
    names.enumerate().map(spoil).collect()
}
