//! Who surrounds whom, and the kernel sums that every stage stands on.

use crate::boundaries::period::Period;
use crate::boundaries::ties::Tie;
use crate::particles::rows::for_each_row;
use rayon::prelude::*;
use sph::kernel::CubicSpline;
use sph::neighbours::{CellGrid, NeighbourList};
use sph::{Matrix, Vector, tensor};

/// A pair of particles, seen from the first.
///
/// Stored in single precision, because the solves read little else and memory is what they wait for. Nothing
/// is lost by it: `V_b ∇W_ab` and `V_a ∇W_ba` are rounded alike, so the two stay exact opposites, and every
/// sum over neighbours is made of the rounded values, in double precision: divergence and gradient stay exact
/// transposes and corrected gradients exact for linear fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<const D: usize> {
    gradient: [f32; D],
    stiffness: f32,
}

impl<const D: usize> Pair<D> {
    /// A pair of gradient `V_b ∇W_ab` (1/m) and stiffness `−2 V_b W'/|r_ab|` (1/m²), both rounded.
    #[inline]
    pub fn new(gradient: &Vector<D>, stiffness: f64) -> Self {
        Self { gradient: std::array::from_fn(|i| gradient[i] as f32), stiffness: stiffness as f32 }
    }

    /// `V_b ∇W_ab` (1/m).
    #[inline]
    pub fn gradient(&self) -> Vector<D> {
        Vector::from_fn(|i, _| f64::from(self.gradient[i]))
    }

    /// `−2 V_b W'/|r_ab|` (1/m²): the compact Laplacian's coefficient, `∇²f ≈ Σ stiffness (f_b − f_a)`.
    #[inline]
    pub fn stiffness(&self) -> f64 {
        f64::from(self.stiffness)
    }
}

/// Kernel sums over everything around a fluid particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings<const D: usize> {
    /// `Σ V_b W_ab`, the particle itself included (1).
    pub concentration: f64,
    /// `Σ V_b ∇W_ab ⊗ (r_b − r_a)`, the inverse of `B` of Eq. (5), over everything; its trace is `∇·r`.
    pub moment: Matrix<D>,
    /// The part of `moment` that walls and structure give.
    pub boundary_moment: Matrix<D>,
    /// `Σ V_b ∇W_ab` over fluid (1/m).
    pub fluid_gradient: Vector<D>,
    /// `Σ V_b ∇W_ab` over walls and structure (1/m).
    pub boundary_gradient: Vector<D>,
    /// `Σ V_b (1 + 0.2 (W/W(Δx))⁴) ∇W_ab` over everything (1/m): where it crowds (Lind et al. 2012).
    pub crowding: Vector<D>,
}

impl<const D: usize> Default for Pair<D> {
    fn default() -> Self {
        Self { gradient: [0.0; D], stiffness: 0.0 }
    }
}

impl<const D: usize> Default for Surroundings<D> {
    fn default() -> Self {
        Self {
            concentration: 0.0,
            moment: Matrix::zeros(),
            boundary_moment: Matrix::zeros(),
            fluid_gradient: Vector::zeros(),
            boundary_gradient: Vector::zeros(),
            crowding: Vector::zeros(),
        }
    }
}

/// Lists of neighbours with their kernel gradients; fluid rows unless it says otherwise.
#[derive(Clone, Debug, Default)]
pub struct Neighbourhood<const D: usize> {
    /// Periodic sides, through which fluid meets fluid.
    pub period: Period<D>,
    /// Fluid around fluid.
    pub fluid: NeighbourList,
    /// Its pairs.
    pub fluid_pairs: Vec<Pair<D>>,
    /// Wall particles around fluid.
    pub walls: NeighbourList,
    /// `V_w ∇W_aw` (1/m).
    pub wall_gradients: Vec<Vector<D>>,
    /// `r_w − r_a` (m).
    pub wall_offsets: Vec<Vector<D>>,
    /// Structure around fluid, and behind it in each row what is tied to it ([`tie`](Self::tie)).
    pub structure: NeighbourList,
    /// `V_s ∇W_as` (1/m).
    pub structure_gradients: Vec<Vector<D>>,
    /// `r_s − r_a` (m).
    pub structure_offsets: Vec<Vector<D>>,
    /// Fluid around structure: rows are interface particles. Ties as in `structure`.
    pub fluid_of_structure: NeighbourList,
    /// `V ∇W_sa` (1/m).
    pub fluid_of_structure_gradients: Vec<Vector<D>>,
    /// `r_s − r_a` (m).
    pub fluid_of_structure_offsets: Vec<Vector<D>>,
    /// Of ties in `structure` and in `fluid_of_structure` the unit normal out of the wall, zero of others.
    pub structure_ties: Vec<Vector<D>>,
    /// The same of `fluid_of_structure`.
    pub fluid_of_structure_ties: Vec<Vector<D>>,
    /// Sums over all of these.
    pub surroundings: Vec<Surroundings<D>>,
    /// Pairs of fluid and wall whose force is the structure's.
    pub tied: Vec<TiedPair<D>>,
    /// Fluid around ties.
    fluid_of_ties: NeighbourList,
    /// Particles and their ghost images (m), where space repeats.
    images: Vec<Vector<D>>,
    /// The particle that each of them is.
    owners: Vec<u32>,
}

/// What of a pair of fluid and wall is the structure's.
#[derive(Clone, Copy, Debug)]
pub struct TiedPair<const D: usize> {
    /// The wall particle.
    pub wall: u32,
    /// The fluid particle.
    pub particle: u32,
    /// `d (d·V_w ∇W_aw)` (1/m), `d` the tie's direction.
    pub gradient: Vector<D>,
    /// Its place among the pairs of fluid and walls.
    pub pair: u32,
}

/// Bodies that do not change their number or volume: walls, and the structure's particles where they stand
/// now.
#[derive(Clone, Copy)]
pub struct Bodies<'a, const D: usize> {
    /// Wall positions (m).
    pub wall_positions: &'a [Vector<D>],
    /// Wall volumes (m³).
    pub wall_volumes: &'a [f64],
    /// Walls binned.
    pub wall_grid: &'a CellGrid<D>,
    /// Structure positions (m).
    pub structure_positions: &'a [Vector<D>],
    /// Structure volumes (m³).
    pub structure_volumes: &'a [f64],
}

impl<const D: usize> Neighbourhood<D> {
    /// Finds the neighbours of `positions` (m), all of volume `volume` (m³), and sums over them.
    pub fn update(
        &mut self,
        kernel: &CubicSpline<D>,
        spacing: f64,
        volume: f64,
        positions: &[Vector<D>],
        bodies: &Bodies<'_, D>,
    ) {
        let grid = CellGrid::new(positions, kernel.support());
        let period = self.period;
        if period.is_none() {
            self.fluid.rebuild(positions, &grid, positions);
        } else {
            self.images.clear();
            self.images.extend_from_slice(positions);
            period.add_images(&mut self.images, kernel.support(), &mut self.owners);
            self.fluid.rebuild(positions, &CellGrid::new(&self.images, kernel.support()), &self.images);
            self.fluid.rename(&self.owners);
        }
        self.walls.rebuild(positions, bodies.wall_grid, bodies.wall_positions);
        let structure_grid = CellGrid::new(bodies.structure_positions, kernel.support());
        self.structure.rebuild(positions, &structure_grid, bodies.structure_positions);
        self.fluid_of_structure.rebuild(bodies.structure_positions, &grid, positions);

        self.fluid_pairs.resize(self.fluid.pairs(), Pair::default());
        self.wall_gradients.resize(self.walls.pairs(), Vector::zeros());
        self.structure_gradients.resize(self.structure.pairs(), Vector::zeros());
        self.fluid_of_structure_gradients.resize(self.fluid_of_structure.pairs(), Vector::zeros());
        self.surroundings.resize(positions.len(), Surroundings::default());

        let weight = Weight { kernel, crowded: 1.0 / kernel.value(spacing) };
        for_each_row(&self.fluid, &mut self.fluid_pairs, &mut self.surroundings, |a, pairs, sums| {
            *sums = Surroundings { concentration: volume * kernel.value(0.0), ..Surroundings::default() };
            for (pair, &b) in pairs.iter_mut().zip(self.fluid.of(a)) {
                let r = period.nearest(positions[a] - positions[b as usize]);
                let kernel = weight.at(&r, volume);
                *pair = Pair::new(&(r * kernel.slope_over_distance), -2.0 * kernel.slope_over_distance);
                let gradient = pair.gradient();
                kernel.add(sums, &r, &gradient);
                sums.fluid_gradient += gradient;
            }
        });
        let mut boundary =
            |list: &NeighbourList, gradients: &mut [Vector<D>], points: &[Vector<D>], volumes: &[f64]| {
                for_each_row(list, gradients, &mut self.surroundings, |a, gradients, sums| {
                    let before = sums.moment;
                    for (stored, &b) in gradients.iter_mut().zip(list.of(a)) {
                        let r = positions[a] - points[b as usize];
                        let kernel = weight.at(&r, volumes[b as usize]);
                        let gradient = r * kernel.slope_over_distance;
                        kernel.add(sums, &r, &gradient);
                        sums.boundary_gradient += gradient;
                        *stored = gradient;
                    }
                    if !gradients.is_empty() {
                        sums.boundary_moment += sums.moment - before;
                    }
                });
            };
        boundary(&self.walls, &mut self.wall_gradients, bodies.wall_positions, bodies.wall_volumes);
        boundary(
            &self.structure,
            &mut self.structure_gradients,
            bodies.structure_positions,
            bodies.structure_volumes,
        );
        offsets(&self.walls, positions, bodies.wall_positions, &mut self.wall_offsets);
        offsets(&self.structure, positions, bodies.structure_positions, &mut self.structure_offsets);
        let backwards = &mut self.fluid_of_structure_offsets;
        offsets(&self.fluid_of_structure, bodies.structure_positions, positions, backwards);
        backwards.iter_mut().for_each(|r| *r = -*r);
        for (ties, list) in [
            (&mut self.structure_ties, &self.structure),
            (&mut self.fluid_of_structure_ties, &self.fluid_of_structure),
        ] {
            ties.clear();
            ties.resize(list.pairs(), Vector::zeros());
        }
        let mut nothing = vec![(); bodies.structure_positions.len()];
        for_each_row(
            &self.fluid_of_structure,
            &mut self.fluid_of_structure_gradients,
            &mut nothing,
            |s, gradients, ()| {
                for (stored, &a) in gradients.iter_mut().zip(self.fluid_of_structure.of(s)) {
                    let r = bodies.structure_positions[s] - positions[a as usize];
                    *stored = kernel.gradient(&r) * volume;
                }
            },
        );
    }

    /// Adds pairs of fluid and wall particles to those of fluid and structure, each with what its gradient
    /// has along the tie. The sums over all neighbours know these wall particles already.
    pub fn tie(
        &mut self,
        ties: &[Tie<D>],
        kernel: &CubicSpline<D>,
        volume: f64,
        positions: &[Vector<D>],
        bodies: &Bodies<'_, D>,
    ) {
        self.tied.clear();
        if ties.is_empty() {
            return;
        }
        let points: Vec<Vector<D>> = ties.iter().map(|t| bodies.wall_positions[t.wall as usize]).collect();
        self.fluid_of_ties.rebuild(&points, &CellGrid::new(positions, kernel.support()), positions);
        let (mut of_fluid, mut of_structure) = (Vec::new(), Vec::new());
        for (i, (tie, at)) in ties.iter().zip(&points).enumerate() {
            let (wall_volume, own) = (bodies.wall_volumes[tie.wall as usize], tie.structure);
            let ratio = volume * wall_volume / bodies.structure_volumes[own as usize];
            for &a in self.fluid_of_ties.of(i) {
                let offset = at - positions[a as usize];
                let gradient = tie.direction * tie.direction.dot(&kernel.gradient(&offset));
                let of_pair = gradient * -wall_volume;
                let place = self.walls.of(a as usize).iter().position(|&w| w == tie.wall);
                // Both lists hold what is nearer than the kernel's support, to rounding.
                let Some(place) = place else { continue };
                let pair = (self.walls.range(a as usize).start + place) as u32;
                self.tied.push(TiedPair { wall: tie.wall, particle: a, gradient: of_pair, pair });
                of_fluid.push((a, own, [of_pair, offset, tie.wall_normal]));
                of_structure.push((own, a, [gradient * ratio, offset, tie.wall_normal]));
            }
        }
        append(
            &mut self.structure,
            of_fluid,
            [&mut self.structure_gradients, &mut self.structure_offsets, &mut self.structure_ties],
        );
        append(
            &mut self.fluid_of_structure,
            of_structure,
            [
                &mut self.fluid_of_structure_gradients,
                &mut self.fluid_of_structure_offsets,
                &mut self.fluid_of_structure_ties,
            ],
        );
    }

    /// `B` of Eq. (5) and the smallest eigenvalue of its inverse, particle by particle; `B` is the identity
    /// where that eigenvalue is below `least` (too few or too one-sided neighbours to correct with).
    pub fn corrections(&self, least: f64, out: &mut Vec<(Matrix<D>, f64)>) {
        out.resize(self.surroundings.len(), (Matrix::identity(), 0.0));
        out.par_iter_mut().with_min_len(256).zip(&self.surroundings).for_each(|(correction, sums)| {
            let smallest = tensor::smallest_eigenvalue(&sums.moment);
            let b = if smallest < least { None } else { tensor::inverse(&sums.moment) };
            *correction = (b.unwrap_or_else(Matrix::identity), smallest);
        });
    }
}

/// From each query point to its neighbours (m).
fn offsets<const D: usize>(
    list: &NeighbourList,
    queries: &[Vector<D>],
    points: &[Vector<D>],
    out: &mut Vec<Vector<D>>,
) {
    out.clear();
    for (i, at) in queries.iter().enumerate() {
        out.extend(list.of(i).iter().map(|&j| points[j as usize] - at));
    }
}

/// Appends pairs, each (row, neighbour, values), behind those that the rows have.
fn append<const D: usize>(
    list: &mut NeighbourList,
    mut pairs: Vec<(u32, u32, [Vector<D>; 3])>,
    values: [&mut Vec<Vector<D>>; 3],
) {
    pairs.sort_by_key(|pair| pair.0);
    let places = list.append(pairs.iter().map(|pair| (pair.0, pair.1)));
    for (of, values) in values.into_iter().enumerate() {
        let mut old = std::mem::take(values).into_iter();
        let mut new = pairs.iter().map(|pair| pair.2[of]);
        values.extend(
            places
                .iter()
                .map(|&is_new| if is_new { new.next() } else { old.next() }.expect("a value per pair")),
        );
    }
}

struct Weight<'a, const D: usize> {
    kernel: &'a CubicSpline<D>,
    crowded: f64,
}

/// The kernel between two particles.
struct KernelBetween {
    /// `V_b W_ab`.
    share: f64,
    /// `V_b W'/|r_ab|` (1/m²).
    slope_over_distance: f64,
    /// `1 + 0.2 (W/W(Δx))⁴`.
    crowding: f64,
}

impl<const D: usize> Weight<'_, D> {
    /// The kernel at `r = r_a − r_b`.
    #[inline]
    fn at(&self, r: &Vector<D>, volume: f64) -> KernelBetween {
        let distance = r.norm();
        let (value, slope) = self.kernel.value_and_slope(distance);
        let ratio = value * self.crowded;
        let squared = ratio * ratio;
        KernelBetween {
            share: volume * value,
            slope_over_distance: volume * slope / distance,
            crowding: 1.0 + 0.2 * squared * squared,
        }
    }
}

impl KernelBetween {
    /// Adds the pair at `r = r_a − r_b` to the sums that all kinds of neighbours share; `gradient` is
    /// `V_b ∇W_ab`.
    #[inline]
    fn add<const D: usize>(&self, sums: &mut Surroundings<D>, r: &Vector<D>, gradient: &Vector<D>) {
        sums.concentration += self.share;
        // In this order, so that B is exact although rounding leaves the gradient not quite parallel to r.
        sums.moment -= tensor::outer(gradient, r);
        sums.crowding += gradient * self.crowding;
    }
}
