use super::*;
use crate::flat::dot;
use quasi_newton::Choice;

/// The only block of a vector of `n` entries.
fn one(n: usize) -> [Range<usize>; 1] {
    std::array::from_fn(|_| 0..n)
}

/// A linear map `H(x) = A x + b` of `n` unknowns, full, with eigenvalues of a size that no constant
/// relaxation brings to rest at once.
struct Linear {
    n: usize,
    scale: Vec<f64>,
}

impl Linear {
    fn image(&self, x: &[f64], shift: f64) -> Vec<f64> {
        let at = |i: usize, j: usize| {
            -8.0 / (1.0 + (i as f64 - j as f64).abs()) - if i == j { i as f64 } else { 0.0 }
        };
        (0..self.n)
            .map(|i| {
                let sum: f64 = (0..self.n).map(|j| at(i, j) * x[j] / self.scale[j]).sum();
                self.scale[i] * (sum + 1.0 + i as f64 + shift)
            })
            .collect()
    }

    /// Iterations until the residual is below `tolerance` of the image, and the iterate.
    fn solve(
        &self,
        method: &mut Acceleration,
        blocks: &[Range<usize>],
        shift: f64,
        tolerance: f64,
    ) -> (usize, Vec<f64>) {
        let mut x = vec![0.0; self.n];
        for iteration in 1..=60 {
            let y = self.image(&x, shift);
            let r: Vec<f64> = y.iter().zip(&x).map(|(y, x)| y - x).collect();
            if blocks.iter().all(|b| {
                dot(&r[b.clone()], &r[b.clone()]) <= tolerance * tolerance * dot(&y[b.clone()], &y[b.clone()])
            }) {
                method.end_window(blocks, &y, &r);
                return (iteration, x);
            }
            method.next(blocks, &mut x, &y, &r);
        }
        panic!("not converged: {x:?}");
    }
}

fn quasi_newton(reused_windows: usize, multi_vector: bool, columns: usize) -> Acceleration {
    let choice = Choice { relaxation: 0.05, reused_windows, multi_vector, filter: 1e-6, columns };
    Acceleration::QuasiNewton(Box::new(QuasiNewton::new(choice)))
}

fn linear(n: usize) -> Linear {
    Linear { n, scale: vec![1.0; n] }
}

/// After `n` differences a linear map of `n` unknowns is known: `n + 1` images to know it, one more to see
/// that the residual is gone.
#[test]
fn a_linear_map_of_n_unknowns_is_solved_after_n_differences() {
    for n in [1, 2, 5] {
        for multi_vector in [false, true] {
            let (count, _) = linear(n).solve(&mut quasi_newton(0, multi_vector, 100), &one(n), 0.0, 1e-9);
            assert!(count <= n + 2, "{n}: {count}");
        }
    }
}

/// What was learnt of the map in one window serves the next, whose right-hand side differs.
#[test]
fn reused_windows_know_the_map_already() {
    for multi_vector in [false, true] {
        let mut method = quasi_newton(4, multi_vector, 100);
        let (first, _) = linear(5).solve(&mut method, &one(5), 0.0, 1e-9);
        for window in 1..4 {
            let (count, _) = linear(5).solve(&mut method, &one(5), window as f64, 1e-9);
            assert!(count <= 3 && count < first, "{multi_vector} {window}: {count} after {first}");
        }
    }
}

/// A map of which each window meets another direction: what the newest windows told must stand when older
/// ones are forgotten.
#[test]
fn the_jacobian_of_many_windows_is_right_about_the_last_ones() {
    let n = 6;
    let diagonal = |i: usize| -1.0 - i as f64;
    let choice =
        Choice { relaxation: 0.1, reused_windows: 3, multi_vector: true, filter: 1e-6, columns: 100 };
    let mut method = QuasiNewton::new(choice);
    // r = y − x with y = D x; each window differs along one axis and a little along the last one met.
    for window in 0..20 {
        let mut x = vec![1.0; n];
        for step in 0..2 {
            x[window % n] += f64::from(step);
            x[(window + n - 1) % n] += 0.3 * f64::from(step);
            let y: Vec<f64> = x.iter().enumerate().map(|(i, x)| diagonal(i) * x).collect();
            let r: Vec<f64> = y.iter().zip(&x).map(|(y, x)| y - x).collect();
            if step == 0 {
                let mut next = x.clone();
                method.next(&one(n), &mut next, &y, &r);
            } else {
                method.end_window(&one(n), &y, &r);
            }
        }
        // The residual of the window's own difference is now answered by its own image.
        let own: Vec<f64> = (0..n)
            .map(|i| [(i == window % n, 1.0), (i == (window + n - 1) % n, 0.3)])
            .map(|parts| parts.iter().filter(|(here, _)| *here).map(|(_, by)| by).sum())
            .collect();
        let y: Vec<f64> = own.iter().enumerate().map(|(i, d)| diagonal(i) * d).collect();
        let r: Vec<f64> = y.iter().zip(&own).map(|(y, d)| y - d).collect();
        let mut probe = method.clone();
        let mut next = own.clone();
        probe.next(&one(n), &mut next, &y, &r);
        // y − J r = 0 where J r is the image that belongs to r.
        assert!(next.iter().all(|x| x.abs() < 1e-12), "{window}: {next:?}");
    }
}

/// Blocks are weighed by their own size: Pa/m against m/s, or all of one unit, makes no difference.
#[test]
fn the_units_of_a_block_do_not_matter() {
    let blocks = [0..3, 3..6];
    let units = Linear { n: 6, scale: vec![1e6, 1e6, 1e6, 1e-4, 1e-4, 1e-4] };
    for (mut a, mut b) in [
        (quasi_newton(0, false, 100), quasi_newton(0, false, 100)),
        (quasi_newton(0, true, 100), quasi_newton(0, true, 100)),
        (Acceleration::Aitken(Aitken::new(0.02)), Acceleration::Aitken(Aitken::new(0.02))),
    ] {
        let tolerance = if matches!(a, Acceleration::Aitken(_)) { 1e-2 } else { 1e-9 };
        let (count, x) = linear(6).solve(&mut a, &blocks, 0.0, tolerance);
        let (scaled_count, scaled) = units.solve(&mut b, &blocks, 0.0, tolerance);
        assert_eq!(count, scaled_count);
        for i in 0..6 {
            // Rounding of 1e-16, raised by the condition of the columns at the filter of 1e-6.
            assert!((scaled[i] / units.scale[i] - x[i]).abs() < 1e-6 * x[i].abs(), "{x:?} {scaled:?}");
        }
    }
}

/// Two residuals on a line: Aitken finds where it crosses zero. H(x) = 1 − 9 x, from 0 with ω = 0.05: 0.05,
/// then 0.1 exactly.
#[test]
fn aitken_by_hand() {
    let mut method = Acceleration::Aitken(Aitken::new(0.05));
    let mut x = [0.0];
    for expected in [0.05, 0.1] {
        let y = [1.0 - 9.0 * x[0]];
        let r = [y[0] - x[0]];
        method.next(&one(1), &mut x, &y, &r);
        assert!((x[0] - expected).abs() < 1e-15, "{x:?}");
    }
}

#[test]
fn the_same_residual_twice_keeps_aitkens_factor_and_adds_no_column() {
    let mut aitken = Aitken::new(0.3);
    assert_eq!(aitken.relaxation(&one(1), &[1.0], &[0.5]), 0.3);
    assert_eq!(aitken.relaxation(&one(1), &[1.0], &[0.5]), 0.3);
    let choice = Choice { relaxation: 0.3, reused_windows: 0, multi_vector: false, filter: 1e-3, columns: 9 };
    let mut method = QuasiNewton::new(choice);
    let mut x = [0.0, 0.0];
    for _ in 0..3 {
        method.next(&one(2), &mut x, &[1.0, 2.0], &[1.0, 2.0]);
    }
    assert_eq!(method.columns(), 0);
    assert!(x[0].is_finite() && x[1].is_finite());
}

/// The third difference is the sum of the first two but for 1e-5: with a filter of 1e-3 it is left out, and
/// nothing blows up.
#[test]
fn columns_that_tell_nothing_new_are_filtered() {
    let choice = Choice { relaxation: 0.1, reused_windows: 0, multi_vector: false, filter: 1e-3, columns: 9 };
    let mut method = QuasiNewton::new(choice);
    let mut x = [0.0; 3];
    let residuals = [[1.0, 1.0, 1.0], [2.0, 1.0, 1.0], [2.0, 2.0, 1.0], [3.0, 3.0, 1.0 + 1e-5]];
    for r in residuals {
        let y = [r[0] * 0.5, r[1] * 0.5, r[2] * 0.5];
        method.next(&one(3), &mut x, &y, &r);
    }
    assert_eq!(method.columns(), 3);
    assert!(x.iter().all(|x| x.abs() < 10.0), "{x:?}");
}

#[test]
fn a_window_that_starts_anew_forgets_its_own_differences_only() {
    let choice = Choice { relaxation: 0.1, reused_windows: 3, multi_vector: false, filter: 1e-3, columns: 9 };
    let mut method = QuasiNewton::new(choice);
    let mut x = [0.0; 2];
    method.next(&one(2), &mut x, &[1.0, 0.0], &[1.0, 0.0]);
    method.next(&one(2), &mut x, &[0.5, 0.0], &[0.4, 0.1]);
    method.end_window(&one(2), &[0.1, 0.0], &[0.0, 0.0]);
    assert_eq!(method.columns(), 2);
    method.next(&one(2), &mut x, &[1.0, 1.0], &[1.0, 1.0]);
    method.next(&one(2), &mut x, &[0.5, 1.0], &[0.2, 0.7]);
    assert_eq!(method.columns(), 3);
    method.restart_window();
    assert_eq!(method.columns(), 2);
}

/// Where the fluid has come to touch the structure since the last window, the map answers with the other
/// sign: what was learnt before would throw the iterate a hundred residuals far.
#[test]
fn what_was_learnt_before_a_first_contact_throws_no_iterate_far() {
    let solve = |method: &mut Acceleration, slope: f64| {
        let (mut x, mut farthest) = ([0.0, 0.0], 0.0f64);
        for iteration in 1..=30 {
            let y = x.map(|x| 1.0 + slope * x);
            let r: [f64; 2] = std::array::from_fn(|i| y[i] - x[i]);
            let residual = dot(&r, &r).sqrt();
            if residual <= 1e-9 * dot(&y, &y).sqrt() {
                method.end_window(&one(2), &y, &r);
                return (iteration, farthest);
            }
            let before = x;
            method.next(&one(2), &mut x, &y, &r);
            let step: [f64; 2] = std::array::from_fn(|i| x[i] - before[i]);
            farthest = farthest.max(dot(&step, &step).sqrt() / residual);
        }
        panic!("not converged: {x:?}");
    };
    for multi_vector in [false, true] {
        let mut method = quasi_newton(8, multi_vector, 100);
        // In the window's own words a step of a hundred residuals is taken.
        let (_, far) = solve(&mut method, 0.99);
        assert!(far > 90.0, "{far}");
        let (count, far) = solve(&mut method, -9.0);
        assert!(far <= 2.0 && count <= 6, "{count} iterations, {far} residuals");
        // Which then is known.
        let (count, _) = solve(&mut method, -9.0);
        assert!(count <= 4, "{count} iterations");
    }
}
