//! States as bytes: what a participant or the coupler saves, and reads again without trusting it.
