//! Building, rebuilding and applying mappings, per method and number of points;
//! `cargo bench -p coupler --bench mapping`.
//!
//! `N` source points fill a plate of 1 m × 0.1 m, as many targets another lattice of it; points move between
//! two positions from one rebuild to the next. For nearest projection the sources are the vertices of the
//! plate's outline, and the `N` targets fill it.

use coupler::mapping::{Mapping, Method, POINTS_PER_CLUSTER, Settings};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

const EXTENTS: [f64; 2] = [1.0, 0.1];

/// Middles of `columns × rows` cells.
fn lattice(columns: usize, rows: usize) -> Vec<f64> {
    let at = |i: usize| [i % columns, i / columns].map(|k| k as f64 + 0.5);
    let point = |[x, y]: [f64; 2]| [EXTENTS[0] * x / columns as f64, EXTENTS[1] * y / rows as f64];
    (0..columns * rows).flat_map(|i| point(at(i))).collect()
}

/// The outline, anticlockwise, with as many segments along and through as there are columns and rows.
fn outline(columns: usize, rows: usize) -> (Vec<f64>, Vec<usize>) {
    let at =
        |i: usize, j: usize| [EXTENTS[0] * i as f64 / columns as f64, EXTENTS[1] * j as f64 / rows as f64];
    let mut points: Vec<f64> = (0..columns).flat_map(|i| at(i, 0)).collect();
    points.extend((0..rows).flat_map(|j| at(columns, j)));
    points.extend((0..columns).flat_map(|i| at(columns - i, rows)));
    points.extend((0..rows).flat_map(|j| at(0, rows - j)));
    let count = points.len() / 2;
    (points, (0..count).flat_map(|i| [i, (i + 1) % count]).collect())
}

/// The plate bent to a parabola.
fn bent(points: &[f64]) -> Vec<f64> {
    points.chunks_exact(2).flat_map(|p| [p[0], p[1] + 0.1 * p[0] * p[0]]).collect()
}

fn mappings(criterion: &mut Criterion) {
    for (count, columns, rows) in [(100, 25, 4), (1000, 100, 10), (10_000, 250, 40), (100_000, 1000, 100)] {
        let cloud = lattice(columns, rows);
        let (vertices, facets) = outline(columns, rows);
        // As many targets, on another lattice.
        let target = lattice(columns * 4 / 5, rows * 5 / 4);
        let radial_basis = Method::RadialBasis { points_per_cluster: POINTS_PER_CLUSTER };
        for (name, method, source) in [
            ("nearest-neighbour", Method::NearestNeighbour, &cloud),
            ("nearest-neighbour-gradient", Method::NearestNeighbourGradient, &cloud),
            ("nearest-projection", Method::NearestProjection { facets }, &vertices),
            ("radial-basis", radial_basis, &cloud),
        ] {
            let settings = Settings { dimension: 2, reach: 0.1, method };
            let mut group = criterion.benchmark_group(name);
            group.throughput(Throughput::Elements(count)).sample_size(10);
            group.bench_function(BenchmarkId::new("build", count), |bencher| {
                bencher.iter(|| Mapping::build(settings.clone(), source, &target).expect("a plate"));
            });
            let mut mapping = Mapping::build(settings.clone(), source, &target).expect("a plate");
            let moves = [(source.clone(), target.clone()), (bent(source), bent(&target))];
            let mut turn = 0;
            for (bench, threads) in [("rebuild", 1), ("rebuild with two threads", 2)] {
                mapping.use_threads(threads);
                group.bench_function(BenchmarkId::new(bench, count), |bencher| {
                    bencher.iter(|| {
                        turn = 1 - turn;
                        mapping.update(&moves[turn].0, &moves[turn].1).expect("a bent plate");
                    });
                });
            }
            let mut followed = vec![0.0; target.len()];
            group.bench_function(BenchmarkId::new("consistent", count), |bencher| {
                bencher.iter(|| mapping.consistent(2, black_box(source), &mut followed));
            });
            let mut received = vec![0.0; source.len()];
            group.bench_function(BenchmarkId::new("conservative", count), |bencher| {
                bencher.iter(|| mapping.conservative(2, black_box(&target), &mut received));
            });
        }
    }
}

criterion_group!(benches, mappings);
criterion_main!(benches);
