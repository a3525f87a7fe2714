//! Properties of mappings: what is exact, what is kept, how errors fall, what is refused.

mod rebuilding;

use coupler::mapping::{Mapping, MappingError, Method, POINTS_PER_CLUSTER, PointSet, Settings};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// Rounding errors of sums of up to a few hundred products of order one, with `Σ |w|` up to 16.
const ROUND_OFF: f64 = 2e-13;

/// Numbers in [0, 1) from a linear congruence (Knuth's MMIX).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn field(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| 2.0 * self.next() - 1.0).collect()
    }

    /// Points in the box from zero to `extents`, flat.
    fn cloud(&mut self, count: usize, extents: &[f64]) -> Vec<f64> {
        (0..count * extents.len()).map(|i| extents[i % extents.len()] * self.next()).collect()
    }
}

fn settings(dimension: usize, method: Method) -> Settings {
    Settings { dimension, reach: f64::INFINITY, method }
}

fn build(dimension: usize, method: Method, source: &[f64], target: &[f64]) -> Mapping {
    Mapping::build(settings(dimension, method), source, target).expect("the points can be mapped")
}

fn radial_basis() -> Method {
    Method::RadialBasis { points_per_cluster: POINTS_PER_CLUSTER }
}

/// A scalar field at positions.
fn sample(dimension: usize, positions: &[f64], field: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    positions.chunks_exact(dimension).map(field).collect()
}

/// Positions in the plane after a motion.
fn moved(positions: &[f64], motion: impl Fn(f64, f64) -> [f64; 2]) -> Vec<f64> {
    positions.chunks_exact(2).flat_map(|p| motion(p[0], p[1])).collect()
}

fn mapped(mapping: &Mapping, components: usize, source: &[f64]) -> Vec<f64> {
    let mut target = vec![f64::NAN; components * mapping.targets()];
    mapping.consistent(components, source, &mut target);
    target
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// `R x + c` with a finite rotation: by 2 rad in the plane, by 2 rad about (1, 2, 3) in space.
fn rigidly_moved(dimension: usize, positions: &[f64]) -> Vec<f64> {
    let (sin, cos) = 2f64.sin_cos();
    let rows: Vec<[f64; 3]> = if dimension == 2 {
        vec![[cos, -sin, 0.0], [sin, cos, 0.0]]
    } else {
        let n = [1.0, 2.0, 3.0].map(|c: f64| c / 14f64.sqrt());
        let cross = [[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]];
        let identity = |i, j| if i == j { cos } else { 0.0 };
        let entry = |i: usize, j: usize| identity(i, j) + sin * cross[i][j] + (1.0 - cos) * n[i] * n[j];
        (0..3).map(|i| std::array::from_fn(|j| entry(i, j))).collect()
    };
    let row = |r: &[f64; 3], c: f64, x: &[f64]| c + r.iter().zip(x).map(|(r, x)| r * x).sum::<f64>();
    let point = |x| rows.iter().zip([0.5, -1.0, 2.0]).map(move |(r, c)| row(r, c, x));
    positions.chunks_exact(dimension).flat_map(point).collect()
}

/// Total force, and moment about the origin (in the plane the last component alone).
fn resultant(dimension: usize, positions: &[f64], forces: &[f64]) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (x, f) in positions.chunks_exact(dimension).zip(forces.chunks_exact(dimension)) {
        let component = |v: &[f64], i: usize| v.get(i).copied().unwrap_or(0.0);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            sum[i] += component(f, i);
            sum[3 + i] += component(x, j) * component(f, k) - component(x, k) * component(f, j);
        }
    }
    sum
}

/// Everything that holds to round-off for a method that reproduces linear fields.
fn is_exact_and_conserves(dimension: usize, mapping: &Mapping, source: &[f64], target: &[f64]) {
    let random = &mut Random(11);
    assert_eq!((mapping.sources(), mapping.targets()), (source.len() / dimension, target.len() / dimension));
    let ones = vec![1.0; mapping.sources()];
    assert!(largest_difference(&mapped(mapping, 1, &ones), &vec![1.0; mapping.targets()]) < ROUND_OFF);
    let linear = |x: &[f64]| 0.3 + x.iter().zip([1.0, -2.0, 0.7]).map(|(x, a)| a * x).sum::<f64>();
    let found = mapped(mapping, 1, &sample(dimension, source, linear));
    let error = largest_difference(&found, &sample(dimension, target, linear));
    assert!(error < 4.0 * ROUND_OFF, "{error}");
    let found = mapped(mapping, dimension, &rigidly_moved(dimension, source));
    let error = largest_difference(&found, &rigidly_moved(dimension, target));
    assert!(error < 4.0 * ROUND_OFF, "{error}");

    // Forces of order one: their sums round in proportion to the number of points.
    let forces = random.field(target.len());
    let tolerance = ROUND_OFF * mapping.targets() as f64;
    let mut received = vec![f64::NAN; source.len()];
    mapping.conservative(dimension, &forces, &mut received);
    let (given, taken) = (resultant(dimension, target, &forces), resultant(dimension, source, &received));
    assert!(largest_difference(&given, &taken) < tolerance, "{given:?} {taken:?}");

    // After any motion of the sources, about target positions that were mapped; and the power of any
    // velocities.
    let stirred: Vec<f64> = source.iter().map(|x| x + 0.2 * random.next()).collect();
    let followed = mapped(mapping, dimension, &stirred);
    let (given, taken) =
        (resultant(dimension, &followed, &forces), resultant(dimension, &stirred, &received));
    assert!(largest_difference(&given, &taken) < tolerance, "{given:?} {taken:?}");
    let power = |f: &[f64], u: &[f64]| f.iter().zip(u).map(|(f, u)| f * u).sum::<f64>();
    assert!((power(&forces, &followed) - power(&received, &stirred)).abs() < tolerance);
}

fn maps_exactly(dimension: usize, method: Method, source: &[f64], target: &[f64]) {
    is_exact_and_conserves(dimension, &build(dimension, method, source, target), source, target);
}

/// A rectangle's outline of equal segments, anticlockwise, with the facets that join them.
fn outline(extents: [f64; 2], divisions: [usize; 2]) -> (Vec<f64>, Vec<usize>) {
    let [nx, ny] = divisions;
    let at = |i: usize, j: usize| [extents[0] * i as f64 / nx as f64, extents[1] * j as f64 / ny as f64];
    let mut points = Vec::new();
    points.extend((0..nx).flat_map(|i| at(i, 0)));
    points.extend((0..ny).flat_map(|j| at(nx, j)));
    points.extend((0..nx).flat_map(|i| at(nx - i, ny)));
    points.extend((0..ny).flat_map(|j| at(0, ny - j)));
    let count = 2 * (nx + ny);
    (points, (0..count).flat_map(|i| [i, (i + 1) % count]).collect())
}

/// A box's surface of triangles, outwards.
fn surface(extents: [f64; 3], divisions: [usize; 3]) -> (Vec<f64>, Vec<usize>) {
    let mut number = BTreeMap::new();
    let (mut points, mut facets) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for end in [0, divisions[axis]] {
            let mut vertex = |i: usize, j: usize| {
                let mut node = [0; 3];
                (node[axis], node[b], node[c]) = (end, i, j);
                *number.entry(node).or_insert_with(|| {
                    points.extend((0..3).map(|k| extents[k] * node[k] as f64 / divisions[k] as f64));
                    points.len() / 3 - 1
                })
            };
            for i in 0..divisions[b] {
                for j in 0..divisions[c] {
                    let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    let [p, q, r, s] = corners.map(|(i, j)| vertex(i, j));
                    // The axes b, c and the outward normal are right-handed at the far end, left-handed at
                    // the near one.
                    facets.extend(if end > 0 { [p, q, r, p, r, s] } else { [p, r, q, p, s, r] });
                }
            }
        }
    }
    (points, facets)
}

/// The middles of a lattice of cells in a box.
fn lattice(extents: &[f64], counts: &[usize]) -> Vec<f64> {
    let mut points = Vec::new();
    for cell in 0..counts.iter().product() {
        let mut rest: usize = cell;
        for (extent, count) in extents.iter().zip(counts) {
            points.push(extent * ((rest % count) as f64 + 0.5) / *count as f64);
            rest /= count;
        }
    }
    points
}

#[test]
fn clouds_are_exact_for_linear_fields_and_conserve() {
    for method in [Method::NearestNeighbourGradient, radial_basis()] {
        for seed in 0..4 {
            let random = &mut Random(seed);
            let (source, target) = (random.cloud(400, &[1.0, 0.7]), random.cloud(300, &[1.0, 0.7]));
            maps_exactly(2, method.clone(), &source, &target);
            let extents = [1.0, 0.7, 0.4];
            let (source, target) = (random.cloud(600, &extents), random.cloud(200, &extents));
            maps_exactly(3, method.clone(), &source, &target);
        }
    }
}

#[test]
fn thin_plates_of_particles_are_exact_too() {
    for method in [Method::NearestNeighbourGradient, radial_basis()] {
        // Three particles through the thickness, followed by five.
        maps_exactly(2, method.clone(), &lattice(&[1.0, 0.03], &[100, 3]), &lattice(&[1.0, 0.03], &[170, 5]));
        let extents = [1.0, 0.8, 0.05];
        maps_exactly(3, method.clone(), &lattice(&extents, &[20, 16, 3]), &lattice(&extents, &[15, 12, 2]));
        // Points on both faces, five times further apart than the plate is thick, followed inside.
        let mut faces = lattice(&[1.0, 0.0], &[20, 1]);
        faces.extend(moved(&faces, |x, _| [x, 0.01]));
        maps_exactly(2, method.clone(), &faces, &lattice(&[1.0, 0.01], &[60, 3]));
    }
}

#[test]
fn boundaries_carry_what_fills_the_body() {
    let plane = |extents: [f64; 2], divisions, counts: [usize; 2]| {
        let (source, facets) = outline(extents, divisions);
        maps_exactly(2, Method::NearestProjection { facets }, &source, &lattice(&extents, &counts));
    };
    // A thin plate of three particles, on segments shorter and longer than its thickness, one through the
    // thickness or more.
    plane([1.0, 0.03], [100, 3], [100, 3]);
    plane([1.0, 0.03], [7, 1], [100, 3]);
    plane([1.0, 0.03], [1, 1], [100, 3]);
    plane([1.0, 1.0], [8, 8], [31, 30]);
    let solid = |extents: [f64; 3], divisions, counts: [usize; 3]| {
        let (source, facets) = surface(extents, divisions);
        maps_exactly(3, Method::NearestProjection { facets }, &source, &lattice(&extents, &counts));
    };
    solid([1.0, 0.7, 0.05], [10, 7, 1], [40, 28, 3]);
    solid([1.0, 0.7, 0.05], [2, 2, 1], [20, 14, 3]);
    solid([1.0, 1.0, 1.0], [4, 4, 4], [9, 9, 9]);
}

#[test]
fn boundaries_carry_random_points_in_bent_bodies_and_a_little_outside() {
    let random = &mut Random(5);
    for dimension in [2, 3] {
        let extents = [2.0, 0.1, 0.6];
        let (flat, facets) = match dimension {
            2 => outline([2.0, 0.1], [40, 2]),
            _ => surface(extents, [20, 1, 6]),
        };
        // Bent to an arc of radius one, with a wavy thickness.
        let bent = |p: &[f64]| {
            let radius = 1.0 - p[1] * (1.0 + 0.2 * (9.0 * p[0]).sin());
            let mut x = p.to_vec();
            (x[0], x[1]) = (radius * p[0].sin(), -radius * p[0].cos());
            x
        };
        let bend = |points: &[f64]| points.chunks_exact(dimension).flat_map(bent).collect::<Vec<_>>();
        let source = bend(&flat);
        let inside = bend(&random.cloud(500, &extents[..dimension]));
        let method = Method::NearestProjection { facets };
        maps_exactly(dimension, method.clone(), &source, &inside);
        let jitter: Vec<f64> = inside.iter().map(|x| x + 0.02 * random.next()).collect();
        maps_exactly(dimension, method, &source, &jitter);
    }
}

#[test]
fn points_of_the_boundary_take_its_values() {
    let (source, facets) = outline([1.0, 0.2], [10, 2]);
    // Vertices themselves, middles of segments, and points off a face by less than can be told.
    let mut target = source.clone();
    target.extend([0.55, 0.0, 1.0, 0.05, 0.33, 0.2 + 1e-16, 0.47, 1e-17]);
    let mapping = build(2, Method::NearestProjection { facets }, &source, &target);
    is_exact_and_conserves(2, &mapping, &source, &target);
    let vertices = source.len() / 2;
    for (t, row) in mapping.weights().outer_iterator().enumerate() {
        assert!(row.nnz() == if t < vertices { 1 } else { 2 }, "row {t}");
    }
}

#[test]
fn near_the_tip_of_a_plate_the_line_goes_through_its_thickness() {
    let (source, facets) = outline([1.0, 0.03], [100, 3]);
    // Nearest is the tip, 0.005 away; the line from there would end at the other end of the plate.
    let mapping = build(2, Method::NearestProjection { facets }, &source, &[0.995, 0.015]);
    let weights = mapping.weights();
    let row = weights.outer_view(0).expect("one target");
    assert!(row.iter().all(|(column, w)| source[2 * column] > 0.98 && *w > 0.0), "{row:?}");
}

#[test]
fn an_open_boundary_serves_where_a_far_side_is() {
    // The two long sides and the tip of a plate; its clamped end is open.
    let (source, facets) = outline([1.0, 0.03], [100, 3]);
    let facets = facets[..2 * 203].to_vec();
    maps_exactly(2, Method::NearestProjection { facets }, &source, &lattice(&[1.0, 0.03], &[200, 3]));
}

#[test]
fn coinciding_points_take_each_others_values() {
    let random = &mut Random(3);
    for (dimension, extents) in [(2, &[1.0, 1.0][..]), (3, &[1.0, 1.0, 1.0])] {
        let points = random.cloud(200, extents);
        for method in [Method::NearestNeighbour, Method::NearestNeighbourGradient] {
            let mapping = build(dimension, method, &points, &points);
            assert_eq!(mapping.weights().nnz(), 200);
            assert_eq!(mapped(&mapping, dimension, &points), points);
        }
        // Interpolation up to the conditioning of a cluster's matrix.
        let field = random.field(200);
        let found = mapped(&build(dimension, radial_basis(), &points, &points), 1, &field);
        assert!(largest_difference(&found, &field) < 1e-9);
    }
}

#[test]
fn nearest_neighbour_by_hand() {
    let source = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let target = [0.9, 0.2, -0.1, 0.1, 0.1, 0.8, 0.2, 0.9];
    let mapping = build(2, Method::NearestNeighbour, &source, &target);
    assert_eq!(mapped(&mapping, 1, &[1.0, 2.0, 3.0]), [2.0, 1.0, 3.0, 3.0]);
    let forces = [1.0, 10.0, 100.0, 1000.0];
    let mut received = [0.0; 3];
    mapping.conservative(1, &forces, &mut received);
    assert_eq!(received, [10.0, 1.0, 1100.0]);
    // Forces 2·1, 1·10, 3·100, 1·1000 arrive on volumes 4, 1, 2.
    mapping
        .conservative_per_volume(1, &[2.0, 1.0, 3.0, 1.0], &forces, &[4.0, 1.0, 2.0], &mut received)
        .expect("volumes are positive");
    assert_eq!(received, [2.5, 2.0, 650.0]);
}

#[test]
fn a_load_per_volume_keeps_force_and_moment() {
    let random = &mut Random(17);
    let (source, target) = (lattice(&[1.0, 0.1], &[40, 4]), lattice(&[1.0, 0.1], &[70, 7]));
    let mapping = build(2, Method::NearestNeighbourGradient, &source, &target);
    let volumes = |points: &[f64]| vec![0.1 / (points.len() / 2) as f64; points.len() / 2];
    let (target_volume, source_volume) = (volumes(&target), volumes(&source));
    let (load, mut received) = (random.field(target.len()), vec![0.0; source.len()]);
    mapping.conservative_per_volume(2, &target_volume, &load, &source_volume, &mut received).unwrap();
    let forces = |volume: &[f64], load: &[f64]| -> Vec<f64> {
        load.iter().enumerate().map(|(i, g)| -volume[i / 2] * g).collect()
    };
    let given = resultant(2, &target, &forces(&target_volume, &load));
    let taken = resultant(2, &source, &forces(&source_volume, &received));
    assert!(largest_difference(&given, &taken) < ROUND_OFF);
    let refused = mapping.conservative_per_volume(2, &target_volume, &load, &[0.0; 160], &mut received);
    assert_eq!(refused, Err(MappingError::Volume { point: 0, volume: 0.0 }));
}

#[test]
fn any_number_of_components_is_mapped_alike() {
    let random = &mut Random(23);
    let (source, target) = (random.cloud(100, &[1.0, 1.0]), random.cloud(80, &[1.0, 1.0]));
    let mapping = build(2, Method::NearestNeighbourGradient, &source, &target);
    let column = |field: &[f64], components: usize, c: usize| -> Vec<f64> {
        field.iter().skip(c).step_by(components).copied().collect()
    };
    for components in 1..=5 {
        let (u, f) = (random.field(components * 100), random.field(components * 80));
        let followed = mapped(&mapping, components, &u);
        let mut received = vec![0.0; components * 100];
        mapping.conservative(components, &f, &mut received);
        for c in 0..components {
            assert_eq!(column(&followed, components, c), mapped(&mapping, 1, &column(&u, components, c)));
            let mut alone = vec![0.0; 100];
            mapping.conservative(1, &column(&f, components, c), &mut alone);
            assert_eq!(column(&received, components, c), alone);
        }
    }
}

/// Root of the mean square error of a smooth field, mapped from `n×n` points that are off a lattice by up to
/// a quarter of its spacing.
fn error_at(n: usize, method: Method) -> f64 {
    let random = &mut Random(29);
    let spacing = 1.0 / n as f64;
    let source: Vec<f64> =
        lattice(&[1.0, 1.0], &[n, n]).iter().map(|x| x + spacing * (0.5 * random.next() - 0.25)).collect();
    // Inside, where no extrapolation adds to the error.
    let target: Vec<f64> = random.cloud(2000, &[0.8, 0.8]).iter().map(|x| 0.1 + x).collect();
    let field = |x: &[f64]| (PI * x[0]).sin() * (TAU * x[1]).cos();
    let found = mapped(&build(2, method, &source, &target), 1, &sample(2, &source, field));
    let squares: f64 = found.iter().zip(sample(2, &target, field)).map(|(u, v)| (u - v).powi(2)).sum();
    (squares / found.len() as f64).sqrt()
}

#[test]
fn errors_fall_with_the_order_of_the_method() {
    // The order over a factor of four; a quarter is left for the chance in the points.
    for (method, order) in
        [(Method::NearestNeighbour, 1.0), (Method::NearestNeighbourGradient, 2.0), (radial_basis(), 2.0)]
    {
        let (coarse, fine) = (error_at(20, method.clone()), error_at(80, method.clone()));
        let found = (coarse / fine).log2() / 2.0;
        println!("{method:?}: {coarse:.2e} at 20², {fine:.2e} at 80², order {found:.2}");
        assert!(found > order - 0.25, "{method:?}: {found}");
    }
}

#[test]
fn errors_on_a_boundary_fall_with_the_square_of_its_facets() {
    let field = |x: &[f64]| (3.0 * x[0]).sin() * (2.0 * x[1]).cos();
    let error = |n: usize| {
        let (source, facets) = outline([1.0, 0.5], [2 * n, n]);
        let (target, _) = outline([1.0, 0.5], [2 * 97, 97]);
        let mapping = build(2, Method::NearestProjection { facets }, &source, &target);
        largest_difference(&mapped(&mapping, 1, &sample(2, &source, field)), &sample(2, &target, field))
    };
    let order = (error(8) / error(32)).log2() / 2.0;
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

/// A beam bent to a quarter circle, sections kept plane: what fills it follows its boundary with the error of
/// the segments alone.
#[test]
fn a_beam_that_bends_carries_its_particles() {
    let (source, facets) = outline([1.0, 0.05], [400, 4]);
    let target = lattice(&[1.0, 0.05], &[100, 5]);
    let mapping = build(2, Method::NearestProjection { facets }, &source, &target);
    let bend = |x: f64, y: f64| {
        let curvature = PI / 2.0;
        let (radius, angle) = (1.0 / curvature - y, curvature * x);
        [radius * angle.sin(), 1.0 / curvature - radius * angle.cos()]
    };
    let error = largest_difference(&mapped(&mapping, 2, &moved(&source, bend)), &moved(&target, bend));
    // ⅛ h² |u''| with h = 1/400 and |u''| = the curvature.
    assert!(error < PI / 2.0 / 400f64.powi(2) / 8.0, "{error}");
}

#[test]
fn what_cannot_be_mapped_is_refused_with_the_point() {
    let square = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    let all = [
        Method::NearestNeighbour,
        Method::NearestNeighbourGradient,
        radial_basis(),
        Method::NearestProjection { facets: vec![0, 1, 1, 2, 2, 3, 3, 0] },
    ];
    for method in all {
        let build = |source: &[f64], target: &[f64]| {
            Mapping::build(Settings { dimension: 2, reach: 0.5, method: method.clone() }, source, target)
        };
        let refused = |source: &[f64], target: &[f64]| build(source, target).unwrap_err();
        assert!(matches!(
            refused(&square, &[0.2, 0.1, 0.5, 9.0]),
            MappingError::OutOfReach { point: 1, reach: 0.5, .. }
        ));
        assert!(matches!(
            refused(&square, &[0.5, f64::NAN]),
            MappingError::NotFinite { set: PointSet::Target, point: 0, .. }
        ));
        let mut broken = square;
        broken[5] = f64::INFINITY;
        assert!(matches!(
            refused(&broken, &[0.5, 0.5]),
            MappingError::NotFinite { set: PointSet::Source, point: 2, .. }
        ));
        let length = MappingError::Length { set: PointSet::Source, length: 3, dimension: 2 };
        assert_eq!(refused(&square[..3], &[0.5, 0.5]), length);
        assert_eq!(refused(&[], &[0.5, 0.5]), MappingError::NoSource { targets: 1 });
        // Nobody to follow is nothing wrong.
        assert_eq!(build(&square, &[]).unwrap().targets(), 0);
    }
    let refused = Mapping::build(settings(4, Method::NearestNeighbour), &square, &square).unwrap_err();
    assert_eq!(refused, MappingError::Dimension { dimension: 4 });
}

#[test]
fn neighbourhoods_that_do_not_determine_a_rotation_are_refused() {
    let line = lattice(&[1.0, 0.0], &[50, 1]);
    let sheet = lattice(&[1.0, 1.0, 0.0], &[12, 12, 1]);
    for method in [Method::NearestNeighbourGradient, radial_basis()] {
        let degenerate = |dimension, source: &[f64], target: &[f64]| match Mapping::build(
            settings(dimension, method.clone()),
            source,
            target,
        ) {
            Err(MappingError::Degenerate { point, .. }) => point,
            other => panic!("{other:?}"),
        };
        // On the line or sheet all is well.
        maps_exactly(2, method.clone(), &line, &[0.313, 0.0, 0.777, 0.0]);
        maps_exactly(3, method.clone(), &sheet, &[0.313, 0.41, 0.0, 0.777, 0.2, 0.0]);
        // Off it none of the source points says how it turns.
        assert_eq!(degenerate(2, &line, &[0.3, 0.0, 0.5, 0.01]), 1);
        assert_eq!(degenerate(3, &sheet, &[0.3, 0.3, 0.01]), 0);
        // Two points in the plane.
        assert_eq!(degenerate(2, &[0.0, 0.0, 1.0, 0.0], &[0.5, 0.5]), 0);
    }
    let twice = [lattice(&[1.0, 1.0], &[5, 5]), vec![0.1, 0.1]].concat();
    let refused = Mapping::build(settings(2, radial_basis()), &twice, &[0.4, 0.4]).unwrap_err();
    assert_eq!(refused, MappingError::Coincident { first: 0, second: 25 });
}

#[test]
fn boundaries_that_are_none_are_refused() {
    let square = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    let refused = |facets: &[usize]| {
        let method = Method::NearestProjection { facets: facets.to_vec() };
        Mapping::build(Settings { dimension: 2, reach: 0.2, method }, &square, &[0.5, 0.1]).unwrap_err()
    };
    assert_eq!(refused(&[0, 1, 1]), MappingError::Facets { length: 3, dimension: 2 });
    assert_eq!(refused(&[]), MappingError::Facets { length: 0, dimension: 2 });
    assert_eq!(refused(&[0, 1, 1, 4]), MappingError::Vertex { facet: 1, vertex: 4, points: 4 });
    assert_eq!(refused(&[0, 1, 1, 1]), MappingError::FlatFacet { facet: 1, vertices: vec![1, 1] });
    assert_eq!(refused(&[1, 0, 2, 1, 3, 2, 0, 3]), MappingError::Inwards { volume: -1.0 });
    // One side alone: nothing behind it.
    assert!(matches!(refused(&[0, 1]), MappingError::NoFarSide { point: 0, .. }));
}
