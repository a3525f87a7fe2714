//! The pressure Poisson equation against a direct solve: the operator written out as a dense matrix and
//! factorised.

use fluid::Preconditioner;
use fluid::isph::pressure::adjoint_pair::{self, AdjointPair};
use fluid::isph::pressure::along::Along;
use fluid::isph::pressure::conjugate_gradients::{self, Limits};
use fluid::isph::pressure::preconditioner::PressurePreconditioner;
use fluid::isph::pressure::pressure_operator::{OperatorScratch, PressureOperator};
use fluid::particles::neighbourhood::{Bodies, Neighbourhood};
use nalgebra::{DMatrix, DVector};
use sph::Vector;
use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;

/// A jittered pool 24 × 14 on a wall, its top row of known pressure, with a share of (16) in the diagonal of
/// the row below.
#[test]
fn conjugate_gradients_agree_with_a_dense_factorisation() {
    let mut seed = 5u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    };
    let (width, height) = (24, 14);
    let mut fluid = Vec::new();
    for j in 0..height {
        for i in 0..width {
            fluid.push(Vector::from([f64::from(i) + 0.3 * random(), f64::from(j) + 0.3 * random()]));
        }
    }
    let walls: Vec<Vector<2>> = (-3..0)
        .flat_map(|j| (-3..width + 3).map(move |i| Vector::from([f64::from(i), f64::from(j)])))
        .collect();
    let kernel = CubicSpline::new(1.2);
    let grid = CellGrid::new(&walls, kernel.support());
    let wall_volumes = vec![1.0; walls.len()];
    let bodies = Bodies {
        wall_positions: &walls,
        wall_volumes: &wall_volumes,
        wall_grid: &grid,
        structure_positions: &[],
        structure_volumes: &[],
    };
    let mut neighbourhood = Neighbourhood::default();
    neighbourhood.update(&kernel, 1.0, 1.0, &fluid, &bodies);
    let n = fluid.len();
    let row = |a: usize| a / width as usize;
    let free: Vec<bool> = (0..n).map(|a| row(a) + 1 < height as usize).collect();
    let inverse_density = 1e-3;
    let extra: Vec<f64> =
        (0..n).map(|a| inverse_density * if row(a) + 2 == height as usize { 3.0 } else { 1e-6 }).collect();
    let mut own = Vec::new();
    let along = Along::default();
    adjoint_pair::own_gradients(&neighbourhood, &along, &mut own);
    let operator = PressureOperator {
        pair: AdjointPair { neighbourhood: &neighbourhood, along: &along, own: &own },
        inverse_density,
        yielding: None,
        pressure_stabilization: 0.1,
        wide_share: 1.0,
        extra_diagonal: &extra,
        free: &free,
    };
    let b: Vec<f64> = free.iter().map(|f| if *f { random() } else { 0.0 }).collect();

    let mut scratch = OperatorScratch::default();
    let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
    let mut dense = DMatrix::<f64>::identity(n, n);
    for a in (0..n).filter(|&a| free[a]) {
        unit[a] = 1.0;
        operator.apply(&unit, &mut column, &mut scratch);
        dense.column_mut(a).copy_from_slice(&column);
        unit[a] = 0.0;
    }
    let direct =
        dense.cholesky().expect("the operator is positive definite").solve(&DVector::from_vec(b.clone()));

    let mut diagonal = Vec::new();
    operator.diagonal(&mut diagonal);
    diagonal.iter_mut().zip(&extra).for_each(|(d, e)| *d += e);
    for kind in [Preconditioner::Multigrid, Preconditioner::Jacobi] {
        let mut preconditioner = PressurePreconditioner::default();
        preconditioner.prepare(kind, &operator, &diagonal);
        let mut p = vec![0.0; n];
        let outcome = conjugate_gradients::solve(
            |p, out| operator.apply(p, out, &mut scratch),
            |r, z| preconditioner.apply(r, z),
            &b,
            &mut p,
            Limits { tolerance: 1e-12, iterations: 1000 },
            &mut conjugate_gradients::Scratch::default(),
        );
        assert!(outcome.converged, "{kind:?}: {outcome:?}");
        let largest = direct.amax();
        // The condition number of a pool 14 deep is some hundreds, times the tolerance.
        for a in 0..n {
            assert!((p[a] - direct[a]).abs() < 1e-9 * largest, "{kind:?}, {a}: {} for {}", p[a], direct[a]);
        }
    }
}
