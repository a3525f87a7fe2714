//! Coupling loop, condition (46), launching of participants, records.
