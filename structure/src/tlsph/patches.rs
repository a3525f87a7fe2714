//! Change of volume averaged over patches of particles: what frees nearly incompressible bodies of locking.
//!
//! A pressure for each particle is too many constraints for four layers of particles to bend under: at
//! `ν = 0.49` they are 17 % too stiff, at 0.4999 nine tenths. So the greater part of `λ` acts on the change
//! of volume `f` projected on linear fields over patches of about four particles along each axis, with the
//! energy
//!
//! `½ λ_p Σ_a V_a f̄_a²`, `f̄_a = Σ_k q_ak Σ_b q_bk V_b f_b`,
//!
//! `q_k` the constant and the linear fields of a patch, orthonormal in the sum over volumes. A projection is
//! its own transpose, so the force is that of the law with `λ_p f̄_a` in place of `λ_p f_a`, and momentum,
//! angular momentum and energy are kept as they were. It is the discontinuous linear pressure of the
//! Q2–P1 element (Brezzi and Fortin 1991, §VI.3), on patches of particles. `f` is what the law calls change
//! of volume: [`ConstitutiveLaw::dilatation`](crate::materials::ConstitutiveLaw::dilatation).

use crate::bodies::Body;
use crate::lanes::{LANES, Lanes};
use nalgebra::{DMatrix, DVector};
use sph::Vector;
use sph::neighbours::{CellGrid, NeighbourList};

/// Particles along an edge of a patch. Four layers of one patch and eight of two bend within 1.5 % at
/// `ν` from 0.45 to 0.4999; patches of three are two across five layers, which lock by 5 %.
const EDGE: f64 = 4.0;

/// The patches of one body.
#[derive(Clone, Debug)]
pub(crate) struct Patches {
    /// First member of each patch, and one past the last member of all.
    starts: Vec<u32>,
    /// Members by patch, in the body's part of the internal order.
    members: Vec<u32>,
    /// `q_bk V_b` of each member, the fields `k` together.
    weights: Vec<f64>,
    /// The patch of each particle; one past the last patch for those in none.
    patch: Vec<[u32; LANES]>,
    /// `q_ak` of each particle, field after field.
    fields: Vec<f64>,
    /// `f_a`, filled by the method.
    pub dilatations: Vec<f64>,
    /// `Σ_b q_bk V_b f_b` of each patch, field after field, and zero for no patch.
    means: Vec<f64>,
    modes: usize,
}

impl Patches {
    /// The patches of a body whose particle `members[a]` has the place `a` in the internal order.
    pub fn new<const D: usize>(body: &Body<D>, members: &[Option<usize>]) -> Self {
        let modes = D + 1;
        let patch_of = partition(body);
        let count = patch_of.iter().flatten().max().map_or(0, |last| last + 1);
        let mut by_patch = vec![Vec::new(); count];
        for (a, member) in members.iter().enumerate() {
            if let Some(patch) = member.and_then(|m| patch_of[m]) {
                by_patch[patch].push(a as u32);
            }
        }
        let mut patches = Self {
            starts: vec![0],
            members: Vec::new(),
            weights: Vec::new(),
            patch: vec![[count as u32; LANES]; members.len() / LANES],
            fields: vec![0.0; modes * members.len()],
            dilatations: vec![0.0; members.len()],
            means: vec![0.0; modes * (count + 1)],
            modes,
        };
        for (index, inside) in by_patch.iter().enumerate() {
            let of = |a: u32| members[a as usize].expect("patches have members of the body alone");
            let volumes: Vec<f64> = inside.iter().map(|&a| body.volumes[of(a)]).collect();
            let places: Vec<Vector<D>> =
                inside.iter().map(|&a| body.positions[of(a)] + body.shape(of(a)).0).collect();
            let q = linear_fields(&places, &volumes, body.spacing());
            for (n, &a) in inside.iter().enumerate() {
                patches.patch[a as usize / LANES][a as usize % LANES] = index as u32;
                for k in 0..modes {
                    patches.weights.push(q[(n, k)] * volumes[n]);
                    patches.fields[k * members.len() + a as usize] = q[(n, k)];
                }
            }
            patches.members.extend(inside);
            patches.starts.push(patches.members.len() as u32);
        }
        patches
    }

    /// Projects the dilatations.
    pub fn average(&mut self) {
        let stride = self.means.len() / self.modes;
        for (patch, range) in self.starts.windows(2).enumerate() {
            let range = range[0] as usize..range[1] as usize;
            for k in 0..self.modes {
                let terms = range
                    .clone()
                    .map(|n| self.weights[n * self.modes + k] * self.dilatations[self.members[n] as usize]);
                self.means[k * stride + patch] = terms.sum();
            }
        }
    }

    /// `f̄` at the particles of a slice of the body.
    #[inline(always)]
    pub fn mean(&self, slice: usize) -> Lanes {
        let (stride, count) = (self.means.len() / self.modes, self.dilatations.len());
        let mut sum = Lanes::ZERO;
        for k in 0..self.modes {
            let own = Lanes::load(&self.fields, k * count + slice * LANES);
            sum += own * Lanes::gather(&self.means[k * stride..], &self.patch[slice]);
        }
        sum
    }
}

/// Constant and linear fields at places, orthonormal in the sum over volumes; zero where the places do not
/// span them.
fn linear_fields<const D: usize>(places: &[Vector<D>], volumes: &[f64], spacing: f64) -> DMatrix<f64> {
    let total: f64 = volumes.iter().sum();
    let centre = places.iter().zip(volumes).fold(Vector::zeros(), |sum, (x, v)| sum + x * *v) / total;
    let mut q = DMatrix::zeros(places.len(), D + 1);
    for k in 0..=D {
        let mut field =
            DVector::from_fn(
                places.len(),
                |n, _| {
                    if k == 0 { 1.0 } else { (places[n] - centre)[k - 1] / spacing }
                },
            );
        let product = |a: &DVector<f64>, b: &DVector<f64>| -> f64 {
            (0..places.len()).map(|n| a[n] * b[n] * volumes[n]).sum()
        };
        for earlier in 0..k {
            let other: DVector<f64> = q.column(earlier).into_owned();
            field -= &other * product(&field, &other);
        }
        let norm = product(&field, &field).sqrt();
        // A row of particles has no field across it.
        if norm > 1e-3 * total.sqrt() {
            q.set_column(k, &(field / norm));
        }
    }
    q
}

/// The patch of each particle with a volume: boxes of about [`EDGE`] cells that divide the body's extent
/// evenly, their parts that do not touch apart, and parts too small for a linear field joined to what they
/// touch most.
fn partition<const D: usize>(body: &Body<D>) -> Vec<Option<usize>> {
    let solid: Vec<usize> = (0..body.positions.len()).filter(|&i| body.volumes[i] > 0.0).collect();
    let places: Vec<Vector<D>> = solid.iter().map(|&i| body.positions[i]).collect();
    let Some(&first) = places.first() else { return vec![None; body.positions.len()] };
    let (low, high) = places.iter().fold((first, first), |(l, h), x| (l.inf(x), h.sup(x)));
    let layers = (high - low).component_div(&body.cell).add_scalar(1.0);
    let box_of = |x: &Vector<D>| -> [i64; D] {
        std::array::from_fn(|k| {
            let boxes = (layers[k] / EDGE).round().max(1.0);
            let along = (x[k] - low[k]) / body.cell[k] + 0.5;
            (along / layers[k] * boxes).floor() as i64
        })
    };
    let boxes: Vec<[i64; D]> = places.iter().map(box_of).collect();
    let reach = 1.5 * body.spacing();
    let mut touching = NeighbourList::default();
    touching.rebuild(&places, &CellGrid::new(&places, reach), &places);

    let mut part = vec![usize::MAX; places.len()];
    let mut sizes: Vec<usize> = Vec::new();
    for start in 0..places.len() {
        if part[start] != usize::MAX {
            continue;
        }
        let (own, mut open) = (sizes.len(), vec![start]);
        part[start] = own;
        sizes.push(0);
        while let Some(i) = open.pop() {
            sizes[own] += 1;
            for &j in touching.of(i) {
                let j = j as usize;
                if part[j] == usize::MAX && boxes[j] == boxes[i] {
                    part[j] = own;
                    open.push(j);
                }
            }
        }
    }
    join_small_parts(&mut part, &mut sizes, &touching, 2 * (D + 1));

    let mut names = vec![None; sizes.len()];
    let mut count = 0;
    let mut patch_of = vec![None; body.positions.len()];
    for (n, &i) in solid.iter().enumerate() {
        let name = *names[part[n]].get_or_insert_with(|| {
            count += 1;
            count - 1
        });
        patch_of[i] = Some(name);
    }
    patch_of
}

/// Gives each part of fewer than `least` particles, the smallest first, to the one that it touches most.
fn join_small_parts(part: &mut [usize], sizes: &mut [usize], touching: &NeighbourList, least: usize) {
    let mut alone = vec![false; sizes.len()];
    loop {
        let small = (0..sizes.len()).filter(|&p| sizes[p] > 0 && sizes[p] < least && !alone[p]);
        let Some(small) = small.min_by_key(|&p| sizes[p]) else { return };
        let mut contacts = vec![0_usize; sizes.len()];
        for i in (0..part.len()).filter(|&i| part[i] == small) {
            for &j in touching.of(i) {
                if part[j as usize] != small {
                    contacts[part[j as usize]] += 1;
                }
            }
        }
        let most = contacts.iter().copied().max().unwrap_or(0);
        if most == 0 {
            alone[small] = true;
            continue;
        }
        let to = contacts.iter().position(|&c| c == most).expect("the largest is among them");
        sizes[to] += std::mem::take(&mut sizes[small]);
        part.iter_mut().filter(|p| **p == small).for_each(|p| *p = to);
    }
}
