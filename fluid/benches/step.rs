//! The whole step and its parts on a column of water of about 5,000, 50,000 and 500,000 particles that has
//! begun to collapse: `cargo bench -p fluid --bench step`.

mod column;

use column::column;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fluid::isph::pressure::adjoint_pair::{self, AdjointPair};
use fluid::isph::pressure::along::Along;
use fluid::isph::pressure::conjugate_gradients::{self, Limits};
use fluid::isph::pressure::preconditioner::PressurePreconditioner;
use fluid::isph::pressure::pressure_operator::{OperatorScratch, PressureOperator};
use fluid::particles::neighbourhood::{Bodies, Neighbourhood};
use fluid::{Fluid, InterfaceInput, Isph, Preconditioner, State};
use sph::Vector;
use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;

/// The column after 20 steps, and its solver.
fn collapsing(cells: usize, tolerance: f64) -> (Isph<2>, State<2>) {
    let (mut fluid, mut state) = column(cells, tolerance);
    let mut trial = State::default();
    for _ in 0..20 {
        let dt = fluid.stable_step(&state, 0.0, &[]);
        fluid.step(&state, 0.0, dt, &InterfaceInput::NONE, &mut trial).expect("it flows");
        std::mem::swap(&mut state, &mut trial);
    }
    (fluid, state)
}

fn measure(criterion: &mut Criterion) {
    for cells in [50, 158, 500] {
        let (fluid, state) = collapsing(cells, 1e-3);
        let n = state.len();
        let dx = fluid.properties().spacing;
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
            let mut group = criterion.benchmark_group(format!("step/{threads}-threads"));
            group.sample_size(10).throughput(Throughput::Elements(n as u64));
            let kernel = CubicSpline::new(fluid.smoothing_length());
            let mut neighbourhood = Neighbourhood::default();
            let walls = fluid.walls();
            let bodies = Bodies {
                wall_positions: &walls.positions,
                wall_volumes: &walls.volumes,
                wall_grid: &walls.grid,
                structure_positions: &[],
                structure_volumes: &[],
            };
            let grid_of = |points: &[Vector<2>]| CellGrid::new(points, kernel.support());
            let mut list = sph::neighbours::NeighbourList::default();
            group.bench_function(BenchmarkId::new("fluid_lists_only", n), |bencher| {
                bencher.iter(|| {
                    pool.install(|| {
                        list.rebuild(&state.positions, &grid_of(&state.positions), &state.positions);
                    });
                });
            });
            group.bench_function(BenchmarkId::new("neighbourhood", n), |bencher| {
                bencher.iter(|| {
                    pool.install(|| {
                        neighbourhood.update(&kernel, dx, dx * dx, &state.positions, &bodies);
                    });
                });
            });
            let mut own = Vec::new();
            let along = Along::default();
            adjoint_pair::own_gradients(&neighbourhood, &along, &mut own);
            let (extra, free) = (vec![1e-9; n], vec![true; n]);
            let operator = PressureOperator {
                pair: AdjointPair { neighbourhood: &neighbourhood, along: &along, own: &own },
                inverse_density: 1e-3,
                yielding: None,
                pressure_stabilization: 0.1,
                wide_share: 1.0,
                extra_diagonal: &extra,
                free: &free,
            };
            let (mut out, mut scratch, mut diagonal) = (vec![0.0; n], OperatorScratch::default(), Vec::new());
            let mut sums = Vec::new();
            group.bench_function(BenchmarkId::new("assembly", n), |bencher| {
                bencher.iter(|| {
                    pool.install(|| {
                        adjoint_pair::own_gradients(&neighbourhood, &along, &mut sums);
                        operator.diagonal(&mut diagonal);
                    });
                });
            });
            operator.diagonal(&mut diagonal);
            group.bench_function(BenchmarkId::new("operator", n), |bencher| {
                bencher.iter(|| pool.install(|| operator.apply(&state.pressures, &mut out, &mut scratch)));
            });
            let mut preconditioner = PressurePreconditioner::default();
            group.bench_function(BenchmarkId::new("hierarchy", n), |bencher| {
                bencher.iter(|| {
                    pool.install(|| {
                        preconditioner.prepare(Preconditioner::Multigrid, &operator, &diagonal);
                    });
                });
            });
            group.bench_function(BenchmarkId::new("preconditioner", n), |bencher| {
                bencher.iter(|| pool.install(|| preconditioner.apply(&state.pressures, &mut out)));
            });
            let (mut right, mut x, mut solver) =
                (vec![0.0; n], vec![0.0; n], conjugate_gradients::Scratch::default());
            operator.apply(&state.pressures, &mut right, &mut scratch);
            for tolerance in [1e-3, 1e-6] {
                let limits = Limits { tolerance, iterations: 200 };
                group.bench_function(BenchmarkId::new(format!("solve_{tolerance:.0e}"), n), |bencher| {
                    bencher.iter(|| {
                        pool.install(|| {
                            x.fill(0.0);
                            let apply = |p: &[f64], out: &mut [f64]| operator.apply(p, out, &mut scratch);
                            let precondition = |r: &[f64], z: &mut [f64]| preconditioner.apply(r, z);
                            conjugate_gradients::solve(
                                apply,
                                precondition,
                                &right,
                                &mut x,
                                limits,
                                &mut solver,
                            )
                        })
                    });
                });
            }
            for tolerance in [1e-3, 1e-6] {
                let (mut fluid, state) = collapsing(cells, tolerance);
                let mut trial = State::default();
                let dt = fluid.stable_step(&state, 0.0, &[]);
                group.bench_function(BenchmarkId::new(format!("whole_{tolerance:.0e}"), n), |bencher| {
                    bencher.iter(|| {
                        pool.install(|| {
                            fluid.step(&state, 0.0, dt, &InterfaceInput::NONE, &mut trial).expect("it flows")
                        })
                    });
                });
            }
        }
    }
}

criterion_group!(benches, measure);
criterion_main!(benches);
