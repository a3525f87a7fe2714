//! Fluid at rest in boxes.

use fluid::*;
use sph::Vector;
use sph::lattice::Lattice;

pub type V = Vector<2>;

pub fn v(x: f64, y: f64) -> V {
    Vector::from([x, y])
}

pub fn solid<const D: usize>(name: &str, low: Vector<D>, high: Vector<D>) -> WallPart<D> {
    let shape = WallShape::Box { low, high };
    WallPart { name: name.into(), shape, velocity: Vector::zeros(), motion: None }
}

/// Fluid at rest in boxes, with what a run needs.
pub struct Run<const D: usize> {
    pub fluid: Isph<D>,
    pub state: State<D>,
    pub time: f64,
}

pub fn filled<const D: usize>(
    (low, high): (Vector<D>, Vector<D>),
    dx: f64,
    properties: FluidProperties<D>,
    walls: Vec<WallPart<D>>,
    options: Options,
) -> Run<D> {
    let positions = Lattice::fill_box(low, high, dx).positions;
    let state = State::new(positions.clone(), vec![Vector::zeros(); positions.len()]);
    let walls = Walls::new(walls, dx, 2.4 * dx).unwrap();
    let fluid = Isph::new(properties, options, walls, InterfaceParticles::default(), &state).unwrap();
    Run { fluid, state, time: 0.0 }
}

pub fn water<const D: usize>(dx: f64) -> FluidProperties<D> {
    FluidProperties {
        density: 1000.0,
        kinematic_viscosity: 1e-6,
        gravity: Vector::from_fn(|i, _| if i == D - 1 { -9.81 } else { 0.0 }),
        spacing: dx,
        particle_volume: dx.powi(D as i32),
        domain: (Vector::repeat(-2.0), Vector::repeat(5.0)),
        periodic: [false; D],
    }
}

impl<const D: usize> Run<D> {
    pub fn to(&mut self, end: f64, mut each: impl FnMut(f64, &State<D>, &StepReport<D>)) {
        let mut trial = State::default();
        while self.time < end {
            let dt = self.fluid.stable_step(&self.state, self.time, &[]);
            let report =
                self.fluid.step(&self.state, self.time, dt, &InterfaceInput::NONE, &mut trial).unwrap();
            std::mem::swap(&mut self.state, &mut trial);
            self.time += dt;
            each(self.time, &self.state, &report);
        }
    }
}
