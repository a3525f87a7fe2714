//! What the coupler is at. Schemes announce it and know no clock; whoever listens has one: [`crate::timing`].

use std::rc::Rc;

/// What the coupler does, for the summary and the trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// All that is none of the others: setting up fields, the loop itself.
    Coupling,
    /// Handing a participant its window or its acceptance; in one process, the participant's own work too.
    Sending,
    /// Waiting for a participant's solution.
    Waiting,
    /// Mapping between points that do not match.
    Mapping,
    /// Measuring and enforcing condition (46).
    Condition46,
    /// From iterate to iterate.
    Acceleration,
    /// Writing tables.
    Records,
    /// Starting participants and ending them.
    Starting,
}

impl Phase {
    /// All of them, in the order of a table.
    pub const ALL: [Self; 8] = [
        Self::Sending,
        Self::Waiting,
        Self::Mapping,
        Self::Condition46,
        Self::Acceleration,
        Self::Records,
        Self::Coupling,
        Self::Starting,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coupling => "coupling",
            Self::Sending => "sending",
            Self::Waiting => "waiting",
            Self::Mapping => "mapping",
            Self::Condition46 => "condition (46)",
            Self::Acceleration => "acceleration",
            Self::Records => "records",
            Self::Starting => "starting and ending",
        }
    }

    /// As a key of the summary.
    pub fn key(self) -> &'static str {
        match self {
            Self::Condition46 => "condition_46",
            Self::Starting => "starting_and_ending",
            other => other.name(),
        }
    }
}

/// Hears that a phase begins, and says which one ended.
#[derive(Clone)]
pub struct Announce(Rc<dyn Fn(Phase) -> Phase>);

impl Announce {
    /// To this listener.
    pub fn to(listener: impl Fn(Phase) -> Phase + 'static) -> Self {
        Self(Rc::new(listener))
    }

    /// To nobody.
    pub fn nobody() -> Self {
        Self::to(|_| Phase::Coupling)
    }

    /// Does `work` as this phase; the one before goes on after it.
    pub fn during<T>(&self, phase: Phase, work: impl FnOnce() -> T) -> T {
        let before = (self.0)(phase);
        let result = work();
        (self.0)(before);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn a_phase_within_another_gives_way_to_it_again() {
        let heard = Rc::new(RefCell::new(vec![Phase::Coupling]));
        let listener = Rc::clone(&heard);
        let announce = Announce::to(move |phase| {
            let before = *listener.borrow().last().expect("never empty");
            listener.borrow_mut().push(phase);
            before
        });
        announce.during(Phase::Sending, || announce.during(Phase::Mapping, || ()));
        let order = [Phase::Coupling, Phase::Sending, Phase::Mapping, Phase::Sending, Phase::Coupling];
        assert_eq!(*heard.borrow(), order);
    }
}
