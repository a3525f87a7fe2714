//! Particles kept near in memory to those that are near in space.
//!
//! Every pass over neighbours reads their values from wherever they stand, and fluid that mixes scatters
//! them. A step rearranges the particles along a space-filling curve ([`sph::curve`]) once enough of them
//! have left their order, and when its method bears it. Nothing but the state that the step has made decides
//! it, so a step repeats to the bit as before.
//!
//! [`State::ids`] tells which particle is where; whoever looks at particles over time goes by them.

use crate::particles::class::SurfaceClass;
use crate::particles::state::State;
use sph::Vector;
use sph::curve::CurveOrder;

/// Share of particles that come before one whose cell is earlier on the curve, from which on they are sorted.
/// In a lattice, row by row, it is one over the particles in a row; without any order ½.
const DISORDER: f64 = 0.05;

/// The order along the curve, and memory for rearranging.
#[derive(Clone, Debug, Default)]
pub struct ParticleOrder {
    curve: CurveOrder,
    ids: Vec<u32>,
    classes: Vec<SurfaceClass>,
}

impl ParticleOrder {
    /// Whether the order of particles at `positions` (m) has decayed, and is to be made anew; `low` (m) is a
    /// corner below which there are none, `cell` (m) the width of the curve's cells, within which order does
    /// not count.
    pub fn has_decayed<const D: usize>(
        &mut self,
        positions: &[Vector<D>],
        low: &Vector<D>,
        cell: f64,
    ) -> bool {
        let decayed = self.curve.note(positions, low, cell) > DISORDER;
        if decayed {
            self.curve.sort();
        }
        decayed
    }

    /// Brings the particles of `state` into the order found last, all but the method's memory of them;
    /// `vectors` and `numbers` are memory for it.
    pub fn rearrange<const D: usize, M>(
        &mut self,
        state: &mut State<D, M>,
        (vectors, numbers): (&mut Vec<Vector<D>>, &mut Vec<f64>),
    ) {
        self.curve.apply(&mut state.ids, &mut self.ids);
        self.curve.apply(&mut state.classes, &mut self.classes);
        self.curve.apply(&mut state.positions, vectors);
        self.curve.apply(&mut state.velocities, vectors);
        self.curve.apply(&mut state.pressures, numbers);
    }

    /// Brings values of the particles, one each, into the order found last; `memory` is memory for it.
    pub fn apply<T: Copy + Send + Sync>(&self, values: &mut Vec<T>, memory: &mut Vec<T>) {
        self.curve.apply(values, memory);
    }
}
