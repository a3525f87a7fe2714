//! What a particle is by its surroundings.

use words::bytes::{Error, Reader};

/// What a particle is by its surroundings (the paper's Fig. 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum SurfaceClass {
    /// Surrounded.
    #[default]
    Interior = 0,
    /// Within `h` of a surface particle.
    NearSurface = 1,
    /// On the surface: its pressure is known.
    Surface = 2,
    /// Without fluid neighbours: flies freely.
    Splash = 3,
    /// Within the fluid, but without pressure, since it would be pulled
    /// ([`tearing`](crate::isph::surface::tearing)).
    Torn = 4,
}

impl SurfaceClass {
    /// The classes of so many particles in a saved state.
    pub fn read(state: &mut Reader, field: &'static str, particles: usize) -> Result<Vec<Self>, Error> {
        let all = [Self::Interior, Self::NearSurface, Self::Surface, Self::Splash, Self::Torn];
        state.list(field, Some(particles), |state| {
            state.tag(field, |byte| all.get(usize::from(byte)).copied())
        })
    }
}
