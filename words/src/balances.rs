//! Names of what solvers report of accepted windows, where records and report look for them.

/// Kinetic energy (J).
pub const KINETIC_ENERGY: &str = "kinetic_energy";
/// Potential energy of gravity (J).
pub const POTENTIAL_ENERGY: &str = "potential_energy";
/// Elastic energy of strain (J).
pub const STRAIN_ENERGY: &str = "strain_energy";
/// Energy that damping took (J).
pub const DISSIPATED_ENERGY: &str = "dissipated_energy";
/// Work of all loads, gravity among them (J).
pub const LOAD_WORK: &str = "load_work";
/// Kinetic and potential energy that left with particles since the start (J).
pub const LEFT_ENERGY: &str = "left_energy";
/// Work of clamps that move (J).
pub const CLAMP_WORK: &str = "clamp_work";
/// Energy of contact of a structure's surfaces (J).
pub const CONTACT_ENERGY: &str = "contact_energy";
/// Energy that the friction of contact took (J).
pub const FRICTION_LOSS: &str = "friction_loss";
/// Work of walls that move on a structure, or a fluid, that they touch (J).
pub const WALL_WORK: &str = "wall_work";
/// Change of the fluid's volume over that at the start.
pub const VOLUME_DRIFT: &str = "volume_drift";
/// Particles that left the domain.
pub const PARTICLES_LEFT: &str = "particles_left";
/// Particles that were lost inside a wall or the structure.
pub const PARTICLES_LOST: &str = "particles_lost";

/// Energies whose sum over both sides is that of the whole, with what left it.
pub const ENERGIES: [&str; 5] =
    [KINETIC_ENERGY, POTENTIAL_ENERGY, STRAIN_ENERGY, CONTACT_ENERGY, LEFT_ENERGY];
