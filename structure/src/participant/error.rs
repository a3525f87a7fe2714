//! The structure's failures, as a participant tells them.

use interfaces::ParticipantError;

/// A failure in its own words.
pub fn failed(error: impl std::fmt::Display) -> ParticipantError {
    ParticipantError::failed(error.to_string())
}
