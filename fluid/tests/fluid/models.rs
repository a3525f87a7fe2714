//! Pressure Poisson operators on scattered particles.

use rayon::prelude::*;
use sph::Vector;
use sph::kernel::CubicSpline;
use sph::neighbours::{CellGrid, NeighbourList};

/// Particles, spacing one, and the operators on their pressures.
pub struct Model<const D: usize> {
    /// Compact Laplacian `L`, over free unknowns, rows with their diagonal.
    pub offsets: Vec<u32>,
    pub columns: Vec<u32>,
    pub values: Vec<f64>,
    fluid: Vec<u32>,
    list: NeighbourList,
    gradients: Vec<Vector<D>>,
    wall_gradient: Vec<Vector<D>>,
    acceleration: Vec<Vector<D>>,
    pressure: Vec<f64>,
}

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 33) as f64 / (1u64 << 31) as f64
}

impl<const D: usize> Model<D> {
    /// Jittered lattice points of the box `[0, extent)` where `inside` holds, evened out by some steps of
    /// shifting; walls at all sides but the top of the last axis.
    pub fn new(
        extent: [usize; D],
        inside: impl Fn(&Vector<D>) -> bool,
        jitter: f64,
        relaxations: usize,
    ) -> Self {
        let kernel = CubicSpline::<D>::new(1.2);
        let mut state = 7u64;
        let (mut points, mut walls) = (Vec::new(), Vec::new());
        let mut cell = [-3i64; D];
        'lattice: loop {
            let centre = Vector::<D>::from_fn(|i, _| cell[i] as f64 + 0.5);
            let fluid = (0..D).all(|i| cell[i] >= 0 && cell[i] < extent[i] as i64);
            if fluid {
                let point = centre.map(|c| c + jitter * (random(&mut state) - 0.5));
                if inside(&centre) {
                    points.push(point);
                }
            } else if cell[D - 1] < extent[D - 1] as i64 + 3 {
                walls.push(centre);
            }
            let mut axis = 0;
            loop {
                if axis == D {
                    break 'lattice;
                }
                cell[axis] += 1;
                if cell[axis] < extent[axis] as i64 + if axis == D - 1 { 0 } else { 3 } {
                    break;
                }
                cell[axis] = -3;
                axis += 1;
            }
        }
        points.sort_by_key(|p| {
            let mut key = 0u64;
            for bit in 0..20 {
                for i in 0..D {
                    key |= ((p[i] as u64 >> bit) & 1) << (bit * D + i);
                }
            }
            key
        });
        let n = points.len();
        let mut list = NeighbourList::default();
        let mut wall_list = NeighbourList::default();
        let wall_grid = CellGrid::new(&walls, 2.4);
        for sweep in 0.. {
            list.rebuild(&points, &CellGrid::new(&points, 2.4), &points);
            wall_list.rebuild(&points, &wall_grid, &walls);
            if sweep == relaxations {
                break;
            }
            points = (0..n)
                .map(|i| {
                    let (mut shift, mut divergence) = (Vector::<D>::zeros(), 0.0);
                    for q in list
                        .of(i)
                        .iter()
                        .map(|&j| &points[j as usize])
                        .chain(wall_list.of(i).iter().map(|&j| &walls[j as usize]))
                    {
                        let g = kernel.gradient(&(points[i] - q));
                        shift += g;
                        divergence -= g.dot(&(points[i] - q));
                    }
                    if divergence > 0.95 * D as f64 { points[i] - 0.3 * shift } else { points[i] }
                })
                .collect();
        }
        let mut gradients = vec![Vector::zeros(); list.pairs()];
        let mut wall_gradient = vec![Vector::zeros(); n];
        let mut unknown = vec![u32::MAX; n];
        let mut fluid = Vec::new();
        for i in 0..n {
            let mut divergence = 0.0;
            for (e, &j) in list.range(i).zip(list.of(i)) {
                let r = points[i] - points[j as usize];
                gradients[e] = kernel.gradient(&r);
                divergence -= r.dot(&gradients[e]);
            }
            for &j in wall_list.of(i) {
                let r = points[i] - walls[j as usize];
                let g = kernel.gradient(&r);
                wall_gradient[i] += g;
                divergence -= r.dot(&g);
            }
            if divergence > if D == 2 { 1.6 } else { 2.4 } {
                unknown[i] = fluid.len() as u32;
                fluid.push(i as u32);
            }
        }
        let (mut offsets, mut columns, mut values) = (vec![0u32], Vec::new(), Vec::new());
        for (u, &i) in fluid.iter().enumerate() {
            let i = i as usize;
            let at = columns.len();
            columns.push(u as u32);
            values.push(1e-9);
            for (e, &j) in list.range(i).zip(list.of(i)) {
                let r = points[i] - points[j as usize];
                let w = -2.0 * r.dot(&gradients[e]) / (r.norm_squared() + 1e-4);
                values[at] += w;
                if unknown[j as usize] != u32::MAX {
                    columns.push(unknown[j as usize]);
                    values.push(-w);
                }
            }
            offsets.push(columns.len() as u32);
        }
        let acceleration = vec![Vector::zeros(); n];
        let pressure = vec![0.0; n];
        Self { offsets, columns, values, fluid, list, gradients, wall_gradient, acceleration, pressure }
    }

    /// Adds the reaction of the wide operator to the diagonal of `values`: `|Σ_j w_ij ∇W_ij|²`, `w` = 2 over
    /// fluid and walls, which is the square of the force of a constant pressure.
    pub fn add_reaction(&self, values: &mut [f64]) {
        for (u, &i) in self.fluid.iter().enumerate() {
            let i = i as usize;
            let of_fluid = self.gradients[self.list.range(i)].iter().sum::<Vector<D>>();
            values[self.offsets[u] as usize] += (2.0 * (of_fluid + self.wall_gradient[i])).norm_squared();
        }
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.fluid.len()
    }

    /// `out = L p`.
    pub fn laplacian(&self, p: &[f64], out: &mut [f64]) {
        out.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, out)| {
            let range = self.offsets[i] as usize..self.offsets[i + 1] as usize;
            *out = range.map(|e| self.values[e] * p[self.columns[e] as usize]).sum();
        });
    }

    /// `out = (D M⁻¹ Dᵀ + share · L) p`.
    pub fn operator(&mut self, share: f64, p: &[f64], out: &mut [f64]) {
        let mut pressure = std::mem::take(&mut self.pressure);
        let mut acceleration = std::mem::take(&mut self.acceleration);
        for (u, &i) in self.fluid.iter().enumerate() {
            pressure[i as usize] = p[u];
        }
        acceleration.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, a)| {
            let mut sum = self.wall_gradient[i] * (2.0 * pressure[i]);
            for (e, &j) in self.list.range(i).zip(self.list.of(i)) {
                sum += self.gradients[e] * (pressure[i] + pressure[j as usize]);
            }
            *a = -sum;
        });
        self.laplacian(p, out);
        out.par_iter_mut().enumerate().with_min_len(1024).for_each(|(u, out)| {
            let i = self.fluid[u] as usize;
            let mut sum = -2.0 * acceleration[i].dot(&self.wall_gradient[i]);
            for (e, &j) in self.list.range(i).zip(self.list.of(i)) {
                sum += (acceleration[j as usize] - acceleration[i]).dot(&self.gradients[e]);
            }
            *out = share * *out + sum;
        });
        self.pressure = pressure;
        self.acceleration = acceleration;
    }
}

/// A tank of water, twice as wide as deep, of about `unknowns` particles.
pub fn tank(unknowns: usize) -> Model<2> {
    let depth = ((unknowns / 2) as f64).sqrt().round() as usize;
    Model::new([2 * depth, depth], |_| true, 0.4, 3)
}

/// A collapsed column: a ragged surface with tongues, drops and holes.
pub fn dam_break(unknowns: usize) -> Model<2> {
    let size = (unknowns as f64 * 1.6).sqrt();
    let inside = move |p: &Vector<2>| {
        let (x, y) = (p[0] / size, p[1] / size);
        let height = 0.15 + 0.5 * (1.0 - x).max(0.0).powi(2) + 0.1 * (9.0 * x).sin() * (31.0 * x).sin().abs();
        let hole = (x - 0.3).hypot(y - 0.2) < 0.07 || (x - 0.8).hypot(y - 0.1) < 0.04;
        let drop = (8.0 * x).sin() * (11.0 * y).cos() > 0.9 && y > 0.5;
        let jet = (x - 1.4).abs() < 0.02;
        ((y < height || jet) && !hole) || drop
    };
    Model::new([(1.5 * size) as usize, size as usize], inside, 0.4, 3)
}

/// A cube of water of about `unknowns` particles.
pub fn cube(unknowns: usize) -> Model<3> {
    let size = (unknowns as f64).cbrt().round() as usize;
    Model::new([size; 3], |_| true, 0.4, 3)
}
