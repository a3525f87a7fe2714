//! Incompressible SPH fluid (ISPH, projection method).
