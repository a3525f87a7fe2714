//! Mock partners and the conformance suite for participants.
