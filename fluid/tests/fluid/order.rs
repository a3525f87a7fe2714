//! The order of particles in memory: kept along a curve, and of no consequence.

use fluid::*;
use sph::Vector;
use sph::lattice::{Lattice, jittered};

type V = Vector<2>;

const DX: f64 = 0.02;

/// A column about to collapse in a tank, its particles listed in the lattice's order or in none, each with
/// the number that it has in the lattice.
fn column(shuffled: bool, options: Options) -> (Isph<2>, State<2>) {
    let lattice = Lattice::<2>::fill_box(V::zeros(), [0.3, 0.6].into(), DX);
    let positions = jittered(lattice.positions.clone(), 0.1 * DX, 7);
    let count = positions.len();
    // 7919 is prime and does not divide the number of particles: every place is taken once.
    let ids: Vec<u32> = (0..count).map(|i| if shuffled { i * 7919 % count } else { i } as u32).collect();
    let listed = ids.iter().map(|&i| positions[i as usize]).collect();
    let state = State { ids, ..State::new(listed, vec![V::zeros(); count]) };
    let part = |name: &str, low: [f64; 2], high: [f64; 2]| WallPart {
        name: name.into(),
        shape: WallShape::Box { low: low.into(), high: high.into() },
        velocity: V::zeros(),
        motion: None,
    };
    let parts = vec![
        part("bed", [-0.1, -0.1], [0.7, 0.0]),
        part("left", [-0.1, 0.0], [0.0, 2.0]),
        part("right", [0.6, 0.0], [0.7, 2.0]),
    ];
    let properties = FluidProperties {
        density: 1000.0,
        kinematic_viscosity: 1e-6,
        gravity: [0.0, -9.81].into(),
        spacing: DX,
        particle_volume: lattice.cell_volume(),
        domain: ([-0.2, -0.2].into(), [0.8, 3.0].into()),
        periodic: [false; 2],
    };
    let walls = Walls::new(parts, DX, 2.4 * DX).unwrap();
    let fluid = Isph::new(properties, options, walls, InterfaceParticles::default(), &state).unwrap();
    (fluid, state)
}

fn advance(fluid: &mut Isph<2>, state: &mut State<2>, steps: usize) {
    let mut trial = State::default();
    for _ in 0..steps {
        let dt = fluid.stable_step(state, 0.0, &[]);
        fluid.step(state, 0.0, dt, &InterfaceInput::NONE, &mut trial).unwrap();
        std::mem::swap(state, &mut trial);
    }
}

/// Particle for particle the same flow; what is left is rounding, and solves to 1e-11.
#[test]
fn the_order_of_the_particles_has_no_part_in_the_flow() {
    let options = || Options { pressure_tolerance: 1e-11, position_tolerance: 1e-11, ..Options::default() };
    let [listed, shuffled] = [false, true].map(|shuffled| {
        let (mut fluid, mut state) = column(shuffled, options());
        advance(&mut fluid, &mut state, 12);
        state
    });
    assert_ne!(listed.ids, shuffled.ids);
    for (a, b) in listed.by_id().into_iter().zip(shuffled.by_id()) {
        let (a, b) = (a as usize, b as usize);
        assert_eq!(listed.ids[a], shuffled.ids[b]);
        let apart = (listed.positions[a] - shuffled.positions[b]).norm();
        assert!(apart < 1e-8 * DX, "particle {}: {apart} m apart", listed.ids[a]);
        assert!((listed.pressures[a] - shuffled.pressures[b]).abs() < 1e-5, "particle {}", listed.ids[a]);
    }
}

#[test]
fn a_step_that_sorts_repeats_to_the_bit_for_any_number_of_threads_and_after_a_restart() {
    // Without a hierarchy every step may sort.
    let options = || Options { preconditioner: Preconditioner::Jacobi, ..Options::default() };
    let sorted = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (mut fluid, start) = column(true, options());
            let mut trial = State::default();
            let dt = fluid.stable_step(&start, 0.0, &[]);
            fluid.step(&start, 0.0, dt, &InterfaceInput::NONE, &mut trial).unwrap();
            let first = trial.to_bytes();
            fluid.step(&start, 0.0, dt, &InterfaceInput::NONE, &mut trial).unwrap();
            assert!(first == trial.to_bytes(), "the same step from the same state");
            let saved = State::from_bytes(&first).unwrap();
            assert!(saved == trial);
            // The sorted state goes on as the saved one does.
            let (mut fresh, _) = column(true, options());
            let (mut a, mut b) = (trial, saved);
            advance(&mut fluid, &mut a, 3);
            advance(&mut fresh, &mut b, 3);
            assert!(a.to_bytes() == b.to_bytes(), "after a restart");
            (start, first)
        })
    };
    let (start, one) = sorted(1);
    assert!(one == sorted(2).1, "one thread and two");
    let after = State::<2>::from_bytes(&one).unwrap();
    assert_ne!(start.ids, after.ids, "the step has sorted");
    let mut numbers = after.ids.clone();
    numbers.sort_unstable();
    assert!(numbers.iter().enumerate().all(|(i, &id)| i == id as usize), "every particle is still there");
    for a in 0..after.len() {
        let place = start.ids.iter().position(|&id| id == after.ids[a]).unwrap();
        assert!((after.positions[a] - start.positions[place]).norm() < 0.5 * DX, "and where it was");
    }
}
