//! Conjugate gradients with algebraic multigrid on pressure Poisson operators of scattered particles.

use crate::models::{self, Model};
use fluid::isph::pressure::conjugate_gradients::{Limits, Scratch, solve};
use fluid::isph::pressure::multigrid::{Multigrid, Options};
use fluid::report::Outcome;

const TIGHT: Limits = Limits { tolerance: 1e-6, iterations: 100 };

fn rough(count: usize) -> Vec<f64> {
    (0..count as u64).map(|i| (i.wrapping_mul(2654435761) % 1000) as f64 / 1000.0 - 0.3).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Rows of a dense symmetric matrix without its zeros.
fn compressed(dense: &[Vec<f64>]) -> (Vec<u32>, Vec<u32>, Vec<f64>) {
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for (i, row) in dense.iter().enumerate() {
        for (j, &a) in row.iter().enumerate().filter(|&(j, &a)| a != 0.0 || j == i) {
            columns.push(j as u32);
            values.push(a);
        }
        offsets.push(columns.len() as u32);
    }
    (offsets, columns, values)
}

fn product(offsets: &[u32], columns: &[u32], values: &[f64], x: &[f64], out: &mut [f64]) {
    for i in 0..out.len() {
        let row = offsets[i] as usize..offsets[i + 1] as usize;
        out[i] = row.map(|e| values[e] * x[columns[e] as usize]).sum();
    }
}

/// A chain of springs of strength one between neighbours, each end held by `anchor`.
fn chain(dense: &mut [Vec<f64>], unknowns: std::ops::Range<usize>, anchor: f64) {
    let (first, last) = (unknowns.start, unknowns.end - 1);
    for i in first..last {
        dense[i][i] += 1.0;
        dense[i + 1][i + 1] += 1.0;
        dense[i][i + 1] -= 1.0;
        dense[i + 1][i] -= 1.0;
    }
    dense[first][first] += anchor;
    dense[last][last] += anchor;
}

fn solve_compact<const D: usize>(model: &Model<D>, x: &mut [f64]) -> Outcome {
    let mut multigrid = Multigrid::new(Options::SAME_OPERATOR);
    multigrid.rebuild(&model.offsets, &model.columns, &model.values);
    let b = rough(model.len());
    let (operator, preconditioner) = (
        |p: &[f64], out: &mut [f64]| model.laplacian(p, out),
        |r: &[f64], z: &mut [f64]| multigrid.apply(r, z),
    );
    solve(operator, preconditioner, &b, x, TIGHT, &mut Scratch::default())
}

fn solve_wide<const D: usize>(model: &mut Model<D>, tolerance: f64) -> Outcome {
    let mut values = model.values.clone();
    model.add_reaction(&mut values);
    let mut multigrid = Multigrid::new(Options::WIDE_OPERATOR);
    multigrid.rebuild(&model.offsets, &model.columns, &values);
    let b = rough(model.len());
    let mut x = vec![0.0; b.len()];
    let limits = Limits { tolerance, ..TIGHT };
    let apply = |r: &[f64], z: &mut [f64]| multigrid.apply(r, z);
    solve(|p, out| model.operator(0.1, p, out), apply, &b, &mut x, limits, &mut Scratch::default())
}

/// Measured: 15 and 19 in the tank, 14 and 17 in the dam break, 16 in the cube; two more are allowed for
/// other layouts.
#[test]
fn iterations_hardly_grow_on_the_compact_laplacian() {
    for (what, model, bound) in [
        ("tank", models::tank(5_000), 17),
        ("tank", models::tank(50_000), 21),
        ("dam break", models::dam_break(5_000), 16),
        ("dam break", models::dam_break(50_000), 19),
    ] {
        let outcome = solve_compact(&model, &mut vec![0.0; model.len()]);
        assert!(
            outcome.converged && outcome.iterations <= bound,
            "{what}, {} unknowns: {outcome:?}",
            model.len()
        );
    }
    let cube = models::cube(20_000);
    let outcome = solve_compact(&cube, &mut vec![0.0; cube.len()]);
    assert!(outcome.converged && outcome.iterations <= 18, "cube: {outcome:?}");
}

/// Measured: 18 and 19 in the tank, 16 and 19 in the dam break; two more are allowed for other layouts.
#[test]
fn iterations_hardly_grow_on_the_wide_operator() {
    for (what, mut model, bound) in [
        ("tank", models::tank(5_000), 20),
        ("tank", models::tank(50_000), 21),
        ("dam break", models::dam_break(5_000), 18),
        ("dam break", models::dam_break(50_000), 21),
    ] {
        let outcome = solve_wide(&mut model, 1e-6);
        assert!(
            outcome.converged && outcome.iterations <= bound,
            "{what}, {} unknowns: {outcome:?}",
            model.len()
        );
    }
}

/// `⟨Bx, y⟩ = ⟨x, By⟩` to rounding, `⟨Bx, x⟩ > 0`, and `B(x + y) = Bx + By`. The cycle's sums of at most some
/// hundred terms of mixed sign lose four digits of sixteen at worst.
#[test]
fn the_preconditioner_is_linear_symmetric_and_positive_definite() {
    let model = models::dam_break(8_000);
    for options in [Options::SAME_OPERATOR, Options::WIDE_OPERATOR] {
        let mut multigrid = Multigrid::new(options);
        multigrid.rebuild(&model.offsets, &model.columns, &model.values);
        let n = model.len();
        let x = rough(n);
        let smooth: Vec<f64> = (0..n).map(|i| (i as f64 * 1e-3).cos()).collect();
        let sum: Vec<f64> = x.iter().zip(&smooth).map(|(a, b)| a + b).collect();
        let mut of = |v: &[f64]| {
            let mut out = vec![0.0; n];
            multigrid.apply(v, &mut out);
            out
        };
        let (bx, by, bsum) = (of(&x), of(&smooth), of(&sum));
        let (left, right) = (dot(&bx, &smooth), dot(&x, &by));
        let scale = (dot(&bx, &x) * dot(&by, &smooth)).sqrt();
        assert!((left - right).abs() < 1e-12 * scale, "{left} {right}");
        assert!(dot(&bx, &x) > 0.0 && dot(&by, &smooth) > 0.0);
        let largest = bsum.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for i in 0..n {
            assert!((bx[i] + by[i] - bsum[i]).abs() < 1e-12 * largest);
        }
    }
}

/// The dense inverse is the preconditioner where there is one level only, and the limit of the iteration
/// where there are more.
#[test]
fn solutions_are_those_of_a_dense_solve() {
    for count in [1, 2, 7, 90, 300] {
        let mut dense = vec![vec![0.0; count]; count];
        chain(&mut dense, 0..count, 0.5);
        let (offsets, columns, values) = compressed(&dense);
        let b = rough(count);
        let exact = nalgebra::DMatrix::from_fn(count, count, |i, j| dense[i][j])
            .cholesky()
            .expect("a held chain is positive definite")
            .solve(&nalgebra::DVector::from_column_slice(&b));
        let mut multigrid = Multigrid::new(Options::SAME_OPERATOR);
        multigrid.rebuild(&offsets, &columns, &values);
        let mut x = vec![0.0; count];
        let outcome = solve(
            |v, out| product(&offsets, &columns, &values, v, out),
            |r, z| multigrid.apply(r, z),
            &b,
            &mut x,
            Limits { tolerance: 1e-12, iterations: 100 },
            &mut Scratch::default(),
        );
        assert!(outcome.converged && (count > 100 || outcome.iterations == 1), "{count}: {outcome:?}");
        // Condition (0.8 count²) times the tolerance.
        let error = exact.iter().zip(&x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12 * 0.8 * (count * count).max(10) as f64 * exact.amax(), "{count}: {error}");
    }
}

/// Chains apart from each other, among them pairs held by next to nothing, as pockets of water are.
#[test]
fn disconnected_components_are_solved_each() {
    let count = 400;
    let mut dense = vec![vec![0.0; count]; count];
    chain(&mut dense, 0..150, 0.3);
    chain(&mut dense, 150..300, 1e-8);
    for pair in 0..50 {
        chain(&mut dense, 300 + 2 * pair..302 + 2 * pair, 1e-8);
    }
    let (offsets, columns, values) = compressed(&dense);
    let mut multigrid = Multigrid::new(Options::SAME_OPERATOR);
    multigrid.rebuild(&offsets, &columns, &values);
    let expected = rough(count);
    let mut b = vec![0.0; count];
    product(&offsets, &columns, &values, &expected, &mut b);
    let mut x = vec![0.0; count];
    let outcome = solve(
        |v, out| product(&offsets, &columns, &values, v, out),
        |r, z| multigrid.apply(r, z),
        &b,
        &mut x,
        Limits { tolerance: 1e-12, iterations: 60 },
        &mut Scratch::default(),
    );
    assert!(outcome.converged, "{outcome:?}");
    let mut residual = vec![0.0; count];
    product(&offsets, &columns, &values, &x, &mut residual);
    // The recurrence's residual drifts from the true one by rounding times the number of iterations.
    assert!(b.iter().zip(&residual).all(|(a, b)| (a - b).abs() < 1e-10));
}

/// Unit rows of Dirichlet particles, alone and on every level: the preconditioner inverts them.
#[test]
fn isolated_unknowns_are_solved_exactly() {
    let model = models::tank(2_000);
    let n = model.len();
    let (mut offsets, mut columns, mut values) = (model.offsets, model.columns, model.values);
    for k in 0..300u32 {
        columns.push(n as u32 + k);
        values.push(4.0);
        offsets.push(columns.len() as u32);
    }
    let mut multigrid = Multigrid::new(Options::SAME_OPERATOR);
    let mut z = vec![0.0; n + 300];
    multigrid.rebuild(&offsets, &columns, &values);
    multigrid.apply(&rough(n + 300), &mut z);
    for (z, r) in z.iter().zip(&rough(n + 300)).skip(n) {
        assert!((z - 0.25 * r).abs() < 1e-15);
    }
    // Nothing but isolated unknowns, and nothing at all.
    let alone: Vec<u32> = (0..=500).collect();
    multigrid.rebuild(&alone, &alone[..500], &[2.0; 500]);
    let mut z = vec![0.0; 500];
    multigrid.apply(&[1.0; 500], &mut z);
    assert_eq!(z, [0.5; 500]);
    multigrid.rebuild(&[0], &[], &[]);
    multigrid.apply(&[], &mut []);
}

#[test]
fn results_are_the_same_to_the_bit_for_any_number_of_threads() {
    let model = models::dam_break(30_000);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut x = vec![0.0; model.len()];
            let outcome = solve_compact(&model, &mut x);
            (outcome, x)
        })
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

/// Kept aggregates serve a changed matrix: the same to the bit for the same one, and right for one whose
/// values have changed.
#[test]
fn an_update_keeps_the_aggregates() {
    let model = models::tank(6_000);
    let n = model.len();
    let (b, mut first, mut second) = (rough(n), vec![0.0; n], vec![0.0; n]);
    let mut multigrid = Multigrid::new(Options::SAME_OPERATOR);
    multigrid.update(&model.offsets, &model.columns, &model.values);
    multigrid.apply(&b, &mut first);
    let sizes: Vec<_> = multigrid.level_sizes().collect();
    multigrid.update(&model.offsets, &model.columns, &model.values);
    multigrid.apply(&b, &mut second);
    assert_eq!(first, second);
    let fourfold: Vec<f64> = model.values.iter().map(|v| 4.0 * v).collect();
    multigrid.update(&model.offsets, &model.columns, &fourfold);
    multigrid.apply(&b, &mut second);
    // A power of four scales without rounding, through the square roots of the factorisation too.
    assert!(first.iter().zip(&second).all(|(a, b)| *a == 4.0 * b));
    assert_eq!(sizes, multigrid.level_sizes().collect::<Vec<_>>());
}

#[test]
fn a_warm_start_at_the_solution_takes_no_iteration_and_a_vanishing_right_hand_side_gives_zero() {
    let model = models::tank(1_000);
    let n = model.len();
    let (mut x, mut scratch) = (vec![0.0; n], Scratch::default());
    solve_compact(&model, &mut x);
    let again = solve_compact(&model, &mut x);
    assert!(again.converged && again.iterations <= 1, "{again:?}");
    let identity = |r: &[f64], z: &mut [f64]| z.copy_from_slice(r);
    let outcome = solve(|p, q| model.laplacian(p, q), identity, &vec![0.0; n], &mut x, TIGHT, &mut scratch);
    assert_eq!(outcome, Outcome { iterations: 0, residual: 0.0, converged: true });
    assert!(x.iter().all(|&v| v == 0.0));
}

#[test]
fn a_right_hand_side_that_is_not_finite_ends_the_solve_unconverged() {
    let model = models::tank(1_000);
    let mut b = rough(model.len());
    b[17] = f64::NAN;
    let identity = |r: &[f64], z: &mut [f64]| z.copy_from_slice(r);
    let mut x = vec![0.0; b.len()];
    let outcome = solve(|p, q| model.laplacian(p, q), identity, &b, &mut x, TIGHT, &mut Scratch::default());
    assert!(!outcome.converged && outcome.iterations == 0 && outcome.residual.is_nan());
}
