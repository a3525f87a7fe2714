//! Particles kept near in memory to those that are near in space.
//!
//! Every pass over neighbours reads their values from wherever they stand, and fluid that mixes scatters
//! them. A step rearranges the particles along a space-filling curve ([`sph::curve`]) once enough of them
//! have left their order, and at a time when the next step makes a new hierarchy anyway: aggregates are
//! groups of places, so the old one could not serve. Nothing but the state that the step has made decides it,
//! so a step repeats to the bit as before.
//!
//! [`State::ids`] tells which particle is where; whoever looks at particles over time goes by them.

use crate::isph::state::State;
use sph::Vector;
use sph::curve::CurveOrder;

/// Share of particles that come before one whose cell is earlier on the curve, from which on they are sorted.
/// In a lattice, row by row, it is one over the particles in a row; without any order ½.
const DISORDER: f64 = 0.05;

/// Memory for rearranging.
#[derive(Clone, Debug, Default)]
pub struct ParticleOrder {
    curve: CurveOrder,
    ids: Vec<u32>,
    classes: Vec<crate::SurfaceClass>,
}

impl ParticleOrder {
    /// Sorts the particles of `state` where its next step makes a hierarchy and their order has decayed;
    /// `low` (m) is a corner below which there are none, `cell` (m) the width of the curve's cells, within
    /// which order does not count. `vectors` and `numbers` are memory.
    pub fn keep<const D: usize>(
        &mut self,
        state: &mut State<D>,
        low: &Vector<D>,
        cell: f64,
        (vectors, numbers): (&mut Vec<Vector<D>>, &mut Vec<f64>),
    ) {
        if state.hierarchy.is_some() || self.curve.note(&state.positions, low, cell) <= DISORDER {
            return;
        }
        self.curve.sort();
        let State { ids, positions, velocities, pressures, classes, .. } = state;
        self.curve.apply(ids, &mut self.ids);
        self.curve.apply(classes, &mut self.classes);
        for values in [positions, velocities, &mut state.pressure_accelerations] {
            self.curve.apply(values, vectors);
        }
        for values in [pressures, &mut state.position_potentials] {
            self.curve.apply(values, numbers);
        }
    }
}
