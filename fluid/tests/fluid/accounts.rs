//! Every joule has a name.

use crate::support::{V, filled, v, water};
use fluid::*;

/// Water falls aslant through periodic sides and out of the domain's bottom: what it has, and what left with
/// particles or seems to rise where they come in again, is the sum of its works.
#[test]
fn what_leaves_takes_its_energy_along() {
    let dx = 0.05;
    let properties = FluidProperties {
        gravity: v(3.0, -9.81),
        domain: (v(0.0, 0.0), v(0.5, 1.0)),
        periodic: [true, false],
        ..water(dx)
    };
    let block = (v(0.0, 0.3), v(0.5, 0.6));
    let mut run = filled(block, dx, properties.clone(), Vec::new(), Options::default());
    let mass = properties.particle_mass();
    let energy = |state: &State<2>| -> f64 {
        let of = |(r, u): (&V, &V)| 0.5 * u.norm_squared() - properties.gravity.dot(r);
        mass * state.positions.iter().zip(&state.velocities).map(of).sum::<f64>()
    };
    let (start, count) = (energy(&run.state), run.state.len());
    let (mut left, mut works, mut worst) = (0.0, 0.0, 0.0f64);
    run.to(0.4, |_, state, step| {
        left += step.left_energy;
        works += step.structure_work
            + step.wall_work
            + step.viscous_work
            + step.contact_work
            + step.displacement_work
            + step.projection_work;
        let has = step.kinetic_energy + step.potential_energy;
        worst = worst.max((has - energy(state)).abs());
        worst = worst.max((has + left - start - works).abs());
    });
    let gone = run.state.left as usize;
    assert!(gone > 10 && gone + run.state.len() == count, "{gone} of {count}");
    assert!(worst < 1e-9 * start.abs(), "{worst} J of {start} J");
    // Falling freely gains nothing and loses nothing.
    assert!(works.abs() < 0.02 * start.abs(), "{works} J");
}
