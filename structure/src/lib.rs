//! Total-Lagrangian SPH structure (TLSPH).
