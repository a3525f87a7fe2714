//! Set-up and application of the multigrid preconditioner, and solves with it, on scattered particles.

#[path = "../tests/fluid/models.rs"]
mod models;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fluid::isph::pressure::conjugate_gradients::{Limits, Scratch, solve};
use fluid::isph::pressure::multigrid::{Multigrid, Options};

fn measure<const D: usize>(criterion: &mut Criterion, what: &str, model: &mut models::Model<D>) {
    let n = model.len();
    let mut values = model.values.clone();
    model.add_reaction(&mut values);
    let b: Vec<f64> =
        (0..n as u64).map(|i| (i.wrapping_mul(2654435761) % 1000) as f64 / 1000.0 - 0.3).collect();
    let (mut x, mut scratch) = (vec![0.0; n], Scratch::default());
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        let mut group = criterion.benchmark_group(format!("multigrid/{what}/{threads}-threads"));
        group.sample_size(10).throughput(Throughput::Elements(n as u64));
        let mut multigrid = Multigrid::new(Options::WIDE_OPERATOR);
        group.bench_function(BenchmarkId::new("rebuild", n), |bencher| {
            bencher.iter(|| pool.install(|| multigrid.rebuild(&model.offsets, &model.columns, &values)));
        });
        group.bench_function(BenchmarkId::new("update", n), |bencher| {
            bencher.iter(|| pool.install(|| multigrid.update(&model.offsets, &model.columns, &values)));
        });
        group.bench_function(BenchmarkId::new("apply", n), |bencher| {
            bencher.iter(|| pool.install(|| multigrid.apply(&b, &mut x)));
        });
        group.bench_function(BenchmarkId::new("solve_wide_1e-6", n), |bencher| {
            bencher.iter(|| {
                pool.install(|| {
                    x.fill(0.0);
                    let limits = Limits { tolerance: 1e-6, iterations: 100 };
                    let operator = |p: &[f64], out: &mut [f64]| model.operator(0.1, p, out);
                    solve(operator, |r, z| multigrid.apply(r, z), &b, &mut x, limits, &mut scratch)
                })
            });
        });
    }
}

fn benchmarks(criterion: &mut Criterion) {
    for unknowns in [5_000, 50_000, 500_000] {
        measure(criterion, "tank", &mut models::tank(unknowns));
    }
    measure(criterion, "dam_break", &mut models::dam_break(50_000));
    measure(criterion, "cube", &mut models::cube(50_000));
}

criterion_group!(benches, benchmarks);
criterion_main!(benches);
