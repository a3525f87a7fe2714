//! Where an instance is in its life.
//!
//! The standards' state machines, cut to co-simulation without events:
//!
//! ```text
//! Instantiated ⇄ Configuration        (FMI 3.0: structural parameters)
//! Instantiated → Initialization → Step → Terminated
//! any → Broken (a step that failed, a panic); reset leads back to Instantiated from everywhere
//! ```

/// Where an instance is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[expect(missing_docs, reason = "terms of the standards, and `Broken`")]
pub enum Phase {
    Instantiated = 0,
    Configuration = 1,
    Initialization = 2,
    Step = 3,
    Terminated = 4,
    Broken = 5,
}

impl Phase {
    /// All in which real values can be read.
    pub const ALIVE: [Self; 4] = [Self::Instantiated, Self::Initialization, Self::Step, Self::Terminated];
    /// All but a broken one.
    pub const SOUND: [Self; 5] =
        [Self::Instantiated, Self::Configuration, Self::Initialization, Self::Step, Self::Terminated];
    /// All.
    pub const ALL: [Self; 6] = [
        Self::Instantiated,
        Self::Configuration,
        Self::Initialization,
        Self::Step,
        Self::Terminated,
        Self::Broken,
    ];

    /// Of the byte of a serialised state.
    pub fn from_byte(byte: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|phase| *phase as u8 == byte)
    }
}
