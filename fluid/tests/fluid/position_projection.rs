//! The position projection as a step applies it.

use crate::support::{V, water};
use fluid::*;
use sph::lattice::{Lattice, jittered};

/// Largest displacement over the spacing of particles at rest off the lattice, in a step so short that
/// nothing but the position projection moves them.
fn largest_displacement(position_limit: f64) -> f64 {
    let spacing = 0.1;
    let lattice = Lattice::fill_box(V::zeros(), V::repeat(1.0), spacing);
    let positions = jittered(lattice.positions, 0.2 * spacing, 1);
    let at_rest = vec![V::zeros(); positions.len()];
    let state = State::new(positions, at_rest);
    let properties = FluidProperties { gravity: V::zeros(), kinematic_viscosity: 0.0, ..water(spacing) };
    let options = Options { position_limit, reference_velocity: Some(1.0), ..Options::default() };
    let walls = Walls::new(Vec::new(), spacing, 0.24).expect("no walls are sound");
    let mut fluid = Isph::new(properties, options, walls, InterfaceParticles::default(), &state)
        .expect("the drop is sound");
    let mut trial = state.clone();
    fluid.step(&state, 0.0, 1e-9, &InterfaceInput::NONE, &mut trial).expect("the solve converges");
    let moved = trial.positions.iter().zip(&state.positions).map(|(after, before)| (after - before).norm());
    moved.fold(0.0, f64::max) / spacing
}

#[test]
fn no_particle_is_moved_farther_than_the_limit() {
    assert!(largest_displacement(0.1) > 0.02, "the limit below would do nothing");
    assert!((largest_displacement(0.01) - 0.01).abs() < 1e-6);
}
