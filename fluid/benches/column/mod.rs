//! A column of water 1 × 2 in a tank 4 wide: what the step is measured on.

use fluid::{Fluid, FluidProperties, InterfaceParticles, Isph, Options, State, WallPart, WallShape, Walls};
use sph::Vector;
use sph::lattice::Lattice;

fn wall(name: &str, low: [f64; 2], high: [f64; 2]) -> WallPart<2> {
    let shape = WallShape::Box { low: low.into(), high: high.into() };
    WallPart { name: name.into(), shape, velocity: Vector::zeros(), motion: None }
}

/// The column at rest, `cells` particles across, and its solver.
pub fn column(cells: usize, tolerance: f64) -> (Isph<2>, State<2>) {
    let dx = 1.0 / cells as f64;
    let t = 4.0 * dx;
    let parts = vec![
        wall("bed", [-t, -t], [4.0 + t, 0.0]),
        wall("left", [-t, 0.0], [0.0, 3.0]),
        wall("right", [4.0, 0.0], [4.0 + t, 3.0]),
    ];
    let lattice = Lattice::<2>::fill_box(Vector::zeros(), [1.0, 2.0].into(), dx);
    let count = lattice.positions.len();
    let properties = FluidProperties {
        density: 1000.0,
        kinematic_viscosity: 1e-6,
        gravity: [0.0, -9.81].into(),
        spacing: dx,
        particle_volume: lattice.cell_volume(),
        domain: ([-1.0, -1.0].into(), [5.0, 10.0].into()),
        periodic: [false; 2],
    };
    let state = State::new(lattice.positions, vec![Vector::zeros(); count]);
    let walls = Walls::new(parts, dx, 2.4 * dx).expect("boxes are boxes");
    let options = Options { pressure_tolerance: tolerance, ..Options::default() };
    let fluid =
        Isph::new(properties, options, walls, InterfaceParticles::default(), &state).expect("sound settings");
    (fluid, state)
}
