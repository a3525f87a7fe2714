//! Discrete operators: by hand on few particles, and the properties the method stands on.

use fluid::InterfaceParticles;
use fluid::boundaries::sampling::Sampling;
use fluid::isph::correction::second_derivative_correction;
use fluid::isph::pressure::adjoint_pair::{self, AdjointPair};
use fluid::isph::pressure::along::{Along, BoundaryVelocities};
use fluid::isph::pressure::pressure_operator::{OperatorScratch, PressureOperator, Yielding};
use fluid::particles::neighbourhood::{Bodies, Neighbourhood};
use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use sph::{Matrix, Vector};

struct Random(u64);
impl Random {
    /// Uniform in −½..½.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    }
    fn vector<const D: usize>(&mut self) -> Vector<D> {
        Vector::from_fn(|_, _| self.next())
    }
}

/// What is carried along boundaries: nothing, or all there is.
fn along<const D: usize>(neighbourhood: &Neighbourhood<D>, carries: bool) -> Along<D> {
    let mut along = Along::default();
    let beside =
        |a: usize| !neighbourhood.structure.of(a).is_empty() || !neighbourhood.walls.of(a).is_empty();
    // As `block` has them: the structure to the right, the wall below.
    let unit = |axis: usize, sign: f64| Vector::from_fn(|i, _| if i == axis { sign } else { 0.0 });
    let structure = vec![unit(0, -1.0); neighbourhood.fluid_of_structure.len()];
    along.find(neighbourhood, |a| carries && beside(a), &structure, |_, _| unit(D - 1, 1.0));
    along
}

/// A jittered block of fluid of unit spacing on a wall (below) and beside a structure (right).
struct Block<const D: usize> {
    neighbourhood: Neighbourhood<D>,
    fluid: Vec<Vector<D>>,
    structure: Vec<Vector<D>>,
}

fn block<const D: usize>(side: usize, jitter: f64) -> Block<D> {
    let mut random = Random(7);
    let all = |low: [i64; D], high: [i64; D]| {
        let mut points = vec![Vector::<D>::zeros()];
        for axis in 0..D {
            points = points
                .iter()
                .flat_map(|p| {
                    (low[axis]..high[axis]).map(move |k| {
                        let mut q = *p;
                        q[axis] = k as f64;
                        q
                    })
                })
                .collect();
        }
        points
    };
    let n = side as i64;
    let last = D - 1;
    let range = |low_last, high_last, low_first, high_first| {
        let (mut low, mut high) = ([0; D], [n; D]);
        (low[last], high[last], low[0], high[0]) = (low_last, high_last, low_first, high_first);
        all(low, high)
    };
    let fluid: Vec<Vector<D>> = range(0, n, 0, n).iter().map(|p| p + random.vector() * jitter).collect();
    let walls = range(-3, 0, 0, n);
    let structure: Vec<Vector<D>> = range(0, n, n, n + 3);
    let kernel = CubicSpline::new(1.2);
    let grid = CellGrid::new(&walls, kernel.support());
    let mut neighbourhood = Neighbourhood::default();
    let (wall_volumes, structure_volumes) = (vec![1.0; walls.len()], vec![1.0; structure.len()]);
    let bodies = Bodies {
        wall_positions: &walls,
        wall_volumes: &wall_volumes,
        wall_grid: &grid,
        structure_positions: &structure,
        structure_volumes: &structure_volumes,
    };
    neighbourhood.update(&kernel, 1.0, 1.0, &fluid, &bodies);
    Block { neighbourhood, fluid, structure }
}

/// Work of the pressure's force on any motion is its transpose: `Σ m a·u + Σ m_s a_s·u_s = Σ V p D u` with
/// walls at rest.
fn force_is_the_transpose_of_the_divergence<const D: usize>(side: usize, carries: bool) {
    let Block { neighbourhood, fluid, structure } = block::<D>(side, 0.2);
    let mut random = Random(3);
    let (rho, rho_s) = (1000.0, 300.0);
    let p: Vec<f64> = fluid.iter().map(|_| random.next()).collect();
    let u: Vec<Vector<D>> = fluid.iter().map(|_| random.vector()).collect();
    let u_s: Vec<Vector<D>> = structure.iter().map(|_| random.vector()).collect();
    let (mut own, mut a, mut g_s, mut rate) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let along = along(&neighbourhood, carries);
    assert_eq!(along.rows.len() > side, carries, "{} rows", along.rows.len());
    adjoint_pair::own_gradients(&neighbourhood, &along, &mut own);
    let pair = AdjointPair { neighbourhood: &neighbourhood, along: &along, own: &own };
    pair.accelerations(1.0 / rho, &p, &mut a);
    pair.structure_gradients(&p, &mut Vec::new(), &mut g_s);
    let boundaries = BoundaryVelocities { walls: &[], structure: &u_s };
    pair.divergence(&mut u.clone(), &boundaries, &mut Vec::new(), &mut rate);
    let work: f64 = a.iter().zip(&u).map(|(a, u)| rho * a.dot(u)).sum::<f64>()
        + g_s.iter().zip(&u_s).map(|(g, u)| -(g / rho_s).dot(u) * rho_s).sum::<f64>();
    let transposed: f64 = p.iter().zip(&rate).map(|(p, d)| p * d).sum();
    let scale: f64 = p.iter().zip(&rate).map(|(p, d)| (p * d).abs()).sum();
    // Some thousand terms, each rounded at 1e-16 of the scale.
    assert!((work - transposed).abs() < 1e-13 * scale, "{work} {transposed}");
}

#[test]
fn force_is_the_transpose_of_the_divergence_in_two_dimensions() {
    force_is_the_transpose_of_the_divergence::<2>(12, false);
    force_is_the_transpose_of_the_divergence::<2>(12, true);
}

#[test]
fn force_is_the_transpose_of_the_divergence_in_three_dimensions() {
    force_is_the_transpose_of_the_divergence::<3>(6, false);
    force_is_the_transpose_of_the_divergence::<3>(6, true);
}

/// Whatever moves as one has no divergence, and what boundaries carry of a pressure that is linear along a
/// face makes the gradient beside it what it is inside: 0.79 of it without, at any spacing.
fn along_a_face<const D: usize>(side: usize, jitter: f64) {
    let Block { neighbourhood, fluid, structure } = block::<D>(side, jitter);
    let along = along(&neighbourhood, true);
    let mut own = Vec::new();
    adjoint_pair::own_gradients(&neighbourhood, &along, &mut own);
    let pair = AdjointPair { neighbourhood: &neighbourhood, along: &along, own: &own };
    let wind = Random(9).vector::<D>();
    let walls = vec![wind; neighbourhood.walls.pairs()];
    let (mut u, mut rate) = (vec![wind; fluid.len()], Vec::new());
    let boundaries = BoundaryVelocities { walls: &walls, structure: &vec![wind; structure.len()] };
    pair.divergence(&mut u, &boundaries, &mut Vec::new(), &mut rate);
    // Some ten sums over all pairs, which are kept in single precision but opposite.
    assert!(rate.iter().all(|d| d.abs() < 1e-13), "{:?}", rate.iter().fold(0.0f64, |m, d| m.max(d.abs())));

    // Linear along the structure's face, whose normal is the first axis: G of the particles' own.
    let last = D - 1;
    let p: Vec<f64> = fluid.iter().map(|r| 3.0 * r[last]).collect();
    let mut gradients = Vec::new();
    along.gradients(&neighbourhood, &p, &mut gradients);
    let beside_structure_alone = |a: usize| neighbourhood.walls.of(a).is_empty();
    let mut checked = 0;
    for (row, gradient) in along.rows.iter().zip(&gradients) {
        if beside_structure_alone(row.particle as usize) && row.trust == 1.0 {
            let expected = Vector::<D>::from_fn(|i, _| if i == last { 3.0 } else { 0.0 });
            assert!((gradient - expected).norm() < 1e-12, "{gradient}");
            checked += 1;
        }
    }
    assert!(checked > 10, "{checked}");
    if jitter > 0.0 {
        return;
    }
    let mut with = Vec::new();
    pair.accelerations(1.0, &p, &mut with);
    let (nothing, mut plain, mut without) = (Along::default(), Vec::new(), Vec::new());
    adjoint_pair::own_gradients(&neighbourhood, &nothing, &mut plain);
    let pair = AdjointPair { neighbourhood: &neighbourhood, along: &nothing, own: &plain };
    pair.accelerations(1.0, &p, &mut without);
    // In the middle of the face: particles of the first and the second layer, and one inside.
    let at = |first: usize| {
        let wanted = Vector::<D>::from_fn(|i, _| if i == 0 { first as f64 } else { (side / 2) as f64 });
        fluid.iter().position(|r| *r == wanted).expect("a particle of the lattice")
    };
    let (inside, beside, second) = (at(side / 2), at(side - 1), at(side - 2));
    // In the corner what is along the structure is carried onto it alone, and what is along the wall, which is
    // nothing, onto the wall.
    let corner = fluid.iter().position(|r| r[0] == (side - 1) as f64 && r[last] == 0.0).expect("a corner");
    let mut expected = Vector::zeros();
    let near = &neighbourhood;
    for (&b, pair) in near.fluid.of(corner).iter().zip(&near.fluid_pairs[near.fluid.range(corner)]) {
        expected -= pair.gradient() * (p[corner] + p[b as usize]);
    }
    let walls = near.wall_gradients[near.walls.range(corner)].iter().sum::<Vector<D>>();
    expected -= walls * (2.0 * p[corner]);
    for e in near.structure.range(corner) {
        expected -= near.structure_gradients[e] * (2.0 * p[corner] + 3.0 * near.structure_offsets[e][last]);
    }
    assert!((with[corner] - expected).norm() < 1e-6, "{} {expected}", with[corner]);
    let ratio = |a: &[Vector<D>], of: usize| a[of][last] / a[inside][last];
    assert!((ratio(&with, beside) - 1.0).abs() < 1e-6 && (ratio(&with, second) - 1.0).abs() < 1e-6);
    assert!((ratio(&without, beside) - 0.79).abs() < 0.01, "{}", ratio(&without, beside));
    assert!((ratio(&without, second) - 0.997).abs() < 0.003, "{}", ratio(&without, second));
}

#[test]
fn a_pressure_that_is_linear_along_a_face_is_met_as_inside() {
    along_a_face::<2>(12, 0.0);
    along_a_face::<2>(12, 0.2);
    along_a_face::<3>(9, 0.2);
}

#[test]
fn the_pressure_operator_is_symmetric_positive_and_its_diagonal_is_right() {
    let structure = block::<2>(9, 0.2).structure;
    let volumes = vec![1.0; structure.len()];
    let fine = InterfaceParticles { densities: vec![300.0; volumes.len()], positions: structure, volumes };
    // As many boundary points, three of each particle.
    let positions = (0..9).map(|i| Vector::from([f64::from(i % 3), f64::from(i / 3) * 3.0])).collect();
    let coarse = InterfaceParticles { positions, densities: vec![300.0; 9], volumes: vec![3.0; 9] };
    for particles in [fine, coarse] {
        let sampling = Sampling::new(&particles, 1.0, |_| false);
        assert_eq!(sampling.len(), 27);
        operator_is_symmetric_positive(false, &sampling, particles.volumes.len());
        operator_is_symmetric_positive(true, &sampling, particles.volumes.len());
    }
}

fn operator_is_symmetric_positive(carries: bool, sampling: &Sampling, particles: usize) {
    let Block { neighbourhood, fluid, .. } = block::<2>(9, 0.2);
    let mut own = Vec::new();
    let along = along(&neighbourhood, carries);
    adjoint_pair::own_gradients(&neighbourhood, &along, &mut own);
    let n = fluid.len();
    let mut random = Random(11);
    let free: Vec<bool> = (0..n).map(|a| a % 7 != 0).collect();
    let extra = vec![1e-6; n];
    let compliance = vec![1.0 / 300.0; particles];
    let operator = |yielding| PressureOperator {
        pair: AdjointPair { neighbourhood: &neighbourhood, along: &along, own: &own },
        inverse_density: 1e-3,
        yielding,
        pressure_stabilization: 0.1,
        wide_share: 1.0,
        extra_diagonal: &extra,
        free: &free,
    };
    let mut scratch = OperatorScratch::default();
    let mut apply = |operator: &PressureOperator<'_, 2>, p: &[f64]| {
        let mut out = vec![0.0; n];
        operator.apply(p, &mut out, &mut scratch);
        out
    };
    let mut vector = || -> Vec<f64> { free.iter().map(|f| if *f { random.next() } else { 0.0 }).collect() };
    let (p, q) = (vector(), vector());
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let yielding = operator(Some(Yielding { sampling, compliance: &compliance }));
    let (ap, aq) = (apply(&yielding, &p), apply(&yielding, &q));
    assert!((dot(&q, &ap) - dot(&p, &aq)).abs() < 1e-13 * dot(&p, &ap).abs());
    assert!(dot(&p, &ap) > 0.0 && dot(&q, &aq) > 0.0);
    // A structure that yields takes energy too.
    let stiff = operator(None);
    assert!(dot(&p, &apply(&stiff, &p)) < dot(&p, &ap));
    let mut diagonal = Vec::new();
    stiff.diagonal(&mut diagonal);
    for a in [8, 40, 77] {
        let mut unit = vec![0.0; n];
        unit[a] = 1.0;
        let entry = apply(&stiff, &unit)[a] - extra[a];
        if free[a] {
            assert!((entry - diagonal[a]).abs() < 1e-13 * entry, "{a}: {entry} {}", diagonal[a]);
        }
    }
}

#[test]
fn two_particles_by_hand() {
    let kernel = CubicSpline::<2>::new(1.2);
    let fluid = [Vector::from([0.0, 0.0]), Vector::from([1.0, 0.0])];
    let volume = 0.8;
    let none = CellGrid::new(&[], 2.4);
    let bodies = Bodies {
        wall_positions: &[],
        wall_volumes: &[],
        wall_grid: &none,
        structure_positions: &[],
        structure_volumes: &[],
    };
    let mut neighbourhood = Neighbourhood::default();
    neighbourhood.update(&kernel, 1.0, volume, &fluid, &bodies);
    // ∇W_01 = W'(1) (r_0 − r_1)/1 = (−W', 0), W' negative: it points from particle 0 to particle 1.
    // Pairs are stored in single precision.
    let rounded = f64::from((volume * kernel.slope(1.0)) as f32);
    let slope = rounded / volume;
    let (mut own, mut rate, mut a) = (Vec::new(), Vec::new(), Vec::new());
    let along = Along::default();
    adjoint_pair::own_gradients(&neighbourhood, &along, &mut own);
    let pair = AdjointPair { neighbourhood: &neighbourhood, along: &along, own: &own };
    assert_eq!(own[0], Vector::from([-rounded, 0.0]));
    // They part at speed 3: D_0 u = V (u_1 − u_0)·∇W_01 = V · 3 · |W'|.
    let mut u = [Vector::from([-1.0, 5.0]), Vector::from([2.0, 5.0])];
    let still = BoundaryVelocities { walls: &[], structure: &[] };
    pair.divergence(&mut u, &still, &mut Vec::new(), &mut rate);
    let expected = volume * 3.0 * -slope;
    assert!((rate[0] - expected).abs() < 1e-15 && (rate[1] - expected).abs() < 1e-15);
    // Pressures 2 and 3 push them apart: a_0 = −(1/ρ) V (2 + 3) ∇W_01.
    pair.accelerations(0.001, &[2.0, 3.0], &mut a);
    let expected = 0.001 * volume * 5.0 * slope;
    assert!((a[0].x - expected).abs() < 1e-18 && (a[1].x + expected).abs() < 1e-18);
    let sums = neighbourhood.surroundings[0];
    assert!((sums.concentration - volume * (kernel.value(0.0) + kernel.value(1.0))).abs() < 1e-15);
    assert!((sums.moment[(0, 0)] - volume * -slope).abs() < 1e-15 && sums.moment[(1, 1)] == 0.0);
    let stiffness = neighbourhood.fluid_pairs[0].stiffness();
    assert!((stiffness / (2.0 * volume * -slope) - 1.0).abs() < 2.0 * f64::from(f32::EPSILON));
}

fn corrected_gradients_are_exact_for_linear_fields<const D: usize>(side: usize) {
    let Block { neighbourhood, fluid, .. } = block::<D>(side, 0.3);
    let mut corrections = Vec::new();
    neighbourhood.corrections(0.25, &mut corrections);
    let slope = Vector::<D>::from_fn(|i, _| 1.0 + i as f64);
    let mut checked = 0;
    for a in 0..fluid.len() {
        // Linear fields over the fluid alone need the correction of the fluid alone: where there is nothing
        // else around.
        let alone = neighbourhood.walls.of(a).is_empty() && neighbourhood.structure.of(a).is_empty();
        if !alone || corrections[a].1 < 0.25 {
            continue;
        }
        let range = neighbourhood.fluid.range(a);
        let gradient = neighbourhood.fluid.of(a).iter().zip(&neighbourhood.fluid_pairs[range]).fold(
            Vector::<D>::zeros(),
            |sum, (&b, pair)| {
                sum + corrections[a].0 * pair.gradient() * slope.dot(&(fluid[b as usize] - fluid[a]))
            },
        );
        assert!((gradient - slope).norm() < 1e-12, "particle {a}: {gradient}");
        checked += 1;
    }
    assert!(checked > 20, "{checked}");
}

#[test]
fn corrected_gradients_are_exact_for_linear_fields_in_two_and_three_dimensions() {
    corrected_gradients_are_exact_for_linear_fields::<2>(12);
    corrected_gradients_are_exact_for_linear_fields::<3>(6);
}

fn corrected_laplacian_is_exact_for_quadratic_fields<const D: usize>(side: usize) {
    let Block { neighbourhood, fluid, .. } = block::<D>(side, 0.2);
    let mut corrections = Vec::new();
    neighbourhood.corrections(0.25, &mut corrections);
    let mut random = Random(5);
    let curvature = Matrix::<D>::from_fn(|_, _| random.next());
    let slope = random.vector::<D>();
    let field = |r: &Vector<D>| r.dot(&(curvature * r)) + slope.dot(r);
    let mut checked = 0;
    for a in 0..fluid.len() {
        let alone = neighbourhood.walls.of(a).is_empty() && neighbourhood.structure.of(a).is_empty();
        if !alone || corrections[a].1 < 0.7 {
            continue;
        }
        let pairs = &neighbourhood.fluid_pairs[neighbourhood.fluid.range(a)];
        let around = || {
            neighbourhood
                .fluid
                .of(a)
                .iter()
                .zip(pairs)
                .map(|(&b, pair)| (fluid[a] - fluid[b as usize], pair.gradient()))
        };
        let b_hat = second_derivative_correction(&around(), &corrections[a].0).expect("enough neighbours");
        let jump = |r: &Vector<D>| field(&fluid[a]) - field(&(fluid[a] - r));
        let gradient = around().fold(Vector::zeros(), |sum, (r, g)| sum - corrections[a].0 * g * jump(&r));
        let laplacian: f64 = around()
            .map(|(r, g)| {
                let (distance, e) = (r.norm(), r / r.norm());
                2.0 * e.dot(&(b_hat * g)) * (jump(&r) / distance - e.dot(&gradient))
            })
            .sum();
        // Conditioning of the 3×3 or 6×6 system: some hundreds of roundings.
        assert!((laplacian - 2.0 * curvature.trace()).abs() < 1e-10, "particle {a}: {laplacian}");
        checked += 1;
    }
    assert!(checked > 5, "{checked}");
}

#[test]
fn corrected_laplacian_is_exact_for_quadratic_fields_in_two_and_three_dimensions() {
    corrected_laplacian_is_exact_for_quadratic_fields::<2>(12);
    corrected_laplacian_is_exact_for_quadratic_fields::<3>(7);
}
