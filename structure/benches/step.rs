//! One Runge–Kutta step of a clamped beam, per number of particles, gradient and threads; `cargo bench -p structure`.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sph::Vector;
use structure::{Body, Gradient, Law, Load, Material, Plane, Setup, Side, Structure};

/// Steps in one call, so that conversions at a window's ends weigh as they do in a coupled run.
const SUB_STEPS: usize = 10;

fn beam(gradient: Gradient, layers: usize, columns: usize) -> Structure<2> {
    let material =
        Material { law: Law::AlmansiHooke, plane: Plane::Strain, youngs_modulus: 12e6, poissons_ratio: 0.4 };
    let high = Vector::from([columns as f64 * 1e-3, layers as f64 * 1e-3]);
    let body = Body::block(Vector::zeros(), high, 1e-3, material, 1100.0).clamp(
        0,
        Side::Low,
        gradient,
        gradient.default_smoothing_ratio(),
    );
    let mut setup = Setup::new(vec![body]);
    setup.gradient = gradient;
    setup.gravity = Vector::from([0.0, -9.81]);
    Structure::new(setup).expect("the beam is sound")
}

fn steps(criterion: &mut Criterion) {
    for (layers, columns) in [(4, 75), (20, 150), (20, 1500), (100, 3000)] {
        for gradient in [Gradient::FirstOrder, Gradient::Quadratic] {
            let mut structure = beam(gradient, layers, columns);
            let from = structure.state_at_rest(0.0);
            let mut to = from.clone();
            let dt = 0.5 * SUB_STEPS as f64 * structure.stable_time_step();
            let mut group = criterion.benchmark_group(format!("{gradient:?}"));
            group.throughput(Throughput::Elements((structure.len() * SUB_STEPS) as u64)).sample_size(10);
            for threads in [1, 2] {
                let pool =
                    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
                let id = BenchmarkId::new(format!("{threads} threads"), structure.len());
                group.bench_function(id, |bencher| {
                    pool.install(|| {
                        bencher.iter(|| {
                            structure
                                .advance(&from, &mut to, dt, SUB_STEPS, &Load::None)
                                .expect("it is stable")
                        });
                    });
                });
            }
        }
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
