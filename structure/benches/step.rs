//! Runge–Kutta steps of a clamped beam, per gradient, lattice or not, number of particles and threads;
//! `cargo bench -p structure --bench step`.
//!
//! Criterion prints the time of one window and the rate in particles and steps (`Gelem/s`: one over it is ns
//! per particle and step of four force evaluations).
//! `cargo bench -p structure --bench step -- 'quadratic lattice/3000 '` runs a part.

mod beam;

use beam::{Path, beam, name};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::time::Duration;
use structure::{Gradient, Load, Solid};

/// Layers and columns, the shapes of plates and gates: 300, 3,000, 30,000 and 300,000 particles; and the
/// sub-steps of a window: 100 as in a coupled run, so that what a window's ends cost weighs as it does there,
/// fewer where a sample would last a minute.
const SIZES: [([usize; 2], usize); 4] =
    [([4, 75], 100), ([20, 150], 100), ([20, 1500], 100), ([100, 3000], 10)];

fn steps(criterion: &mut Criterion) {
    for gradient in [Gradient::FirstOrder, Gradient::Quadratic] {
        for path in Path::ALL {
            let mut group = criterion.benchmark_group(format!("{} {}", name(gradient), path.name()));
            group.sample_size(10).measurement_time(Duration::from_secs(3));
            for (size, sub_steps) in SIZES {
                // Made when the first of its benchmarks runs: one left out by a filter costs nothing.
                let mut made = None;
                for threads in [1, 2] {
                    let id = BenchmarkId::new(
                        size.iter().product::<usize>().to_string(),
                        format!("{threads} threads"),
                    );
                    group.throughput(Throughput::Elements(
                        (size.iter().product::<usize>() * sub_steps) as u64,
                    ));
                    group.bench_function(id, |bencher| {
                        let pool = rayon::ThreadPoolBuilder::new()
                            .num_threads(threads)
                            .build()
                            .expect("threads start");
                        let structure = made.get_or_insert_with(|| beam(gradient, path, size));
                        let from = structure.state_at_rest(0.0);
                        let mut to = from.clone();
                        let dt = 0.5 * sub_steps as f64 * structure.stable_time_step();
                        pool.install(|| {
                            bencher.iter(|| {
                                structure
                                    .advance(&from, &mut to, dt, sub_steps, &Load::None)
                                    .expect("it is stable")
                            });
                        });
                    });
                }
            }
        }
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
