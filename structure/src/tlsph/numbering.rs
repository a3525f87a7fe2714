//! The internal order of particles: rows along the longest axis of each body, so that the neighbours of
//! consecutive particles are consecutive too, and every body filled up to whole slices of [`LANES`].

use crate::bodies::Body;
use crate::lanes::LANES;
use std::ops::Range;

/// Stands for "no particle" in the lanes that fill up a body's last slice.
pub(crate) const NOBODY: u32 = u32::MAX;

/// The internal order. "User" indices run over the bodies' particles, body after body, as given.
#[derive(Clone, Debug)]
pub(crate) struct Numbering {
    /// Internal index of each user index.
    pub internal_of: Vec<u32>,
    /// User index of each internal index, or [`NOBODY`].
    pub user_of: Vec<u32>,
    /// Slices of each body.
    pub slices: Vec<Range<usize>>,
}

impl Numbering {
    /// Orders the particles of all bodies.
    pub fn new<const D: usize>(bodies: &[Body<D>]) -> Self {
        let total = bodies.iter().map(|b| b.positions.len()).sum();
        let mut numbering = Self { internal_of: vec![0; total], user_of: Vec::new(), slices: Vec::new() };
        let mut first_user = 0;
        for body in bodies {
            let first_slice = numbering.user_of.len() / LANES;
            for i in order_of(body) {
                numbering.internal_of[first_user + i] = numbering.user_of.len() as u32;
                numbering.user_of.push((first_user + i) as u32);
            }
            while !numbering.user_of.len().is_multiple_of(LANES) {
                numbering.user_of.push(NOBODY);
            }
            numbering.slices.push(first_slice..numbering.user_of.len() / LANES);
            first_user += body.positions.len();
        }
        numbering
    }

    /// The slices in which particles of these user indices are, ascending.
    pub fn slices_of(&self, users: &[usize]) -> Vec<usize> {
        let mut slices: Vec<usize> =
            users.iter().map(|&user| self.internal_of[user] as usize / LANES).collect();
        slices.sort_unstable();
        slices.dedup();
        slices
    }

    /// The particle of a body, whose first one is `first_user` and which has these slices, at each internal
    /// index from the first slice on; none where fillers are.
    pub fn members(&self, slices: &Range<usize>, first_user: usize) -> Vec<Option<usize>> {
        let own = &self.user_of[slices.start * LANES..slices.end * LANES];
        own.iter().map(|&user| (user != NOBODY).then(|| user as usize - first_user)).collect()
    }

    /// Internal indices, fillers included.
    pub fn count(&self) -> usize {
        self.user_of.len()
    }

    /// `(user, internal)` index of every particle, in internal order.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.user_of
            .iter()
            .enumerate()
            .filter(|&(_, &user)| user != NOBODY)
            .map(|(internal, &user)| (user as usize, internal))
    }
}

/// Particles of a body sorted by rows along its longest axis; ties in the order given.
fn order_of<const D: usize>(body: &Body<D>) -> Vec<usize> {
    let count = body.positions.len();
    let Some(&first) = body.positions.first() else { return Vec::new() };
    let (low, high) = body.positions.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    let extent = high - low;
    let along = extent.imax();
    // Rows half a cell off the lattice's planes, so that round-off or jitter does not scatter a plane over
    // two rows.
    let row =
        |i: usize, axis: usize| ((body.positions[i][axis] - low[axis]) / body.cell[axis]).round() as i64;
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| {
        (0..D)
            .rev()
            .filter(|&axis| axis != along)
            .map(|axis| row(a, axis).cmp(&row(b, axis)))
            .find(|o| o.is_ne())
            .unwrap_or_else(|| body.positions[a][along].total_cmp(&body.positions[b][along]))
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::{Law, Material, Plane};
    use sph::Vector;

    #[test]
    fn a_gate_is_numbered_in_rows_along_its_length_and_filled_up() {
        let material = Material::new(Law::AlmansiHooke, 1.0, 0.3, Plane::Strain);
        let body = Body::block(Vector::from([0.0, 0.0]), Vector::from([2.0, 5.0]), 1.0, material, 1.0);
        let numbering = Numbering::new(&[body.clone(), body]);
        // Lattice order is x first: the column x = 0.5 holds the even ones.
        assert_eq!(numbering.user_of[..10], [0, 2, 4, 6, 8, 1, 3, 5, 7, 9]);
        assert_eq!(numbering.user_of[10], NOBODY);
        assert_eq!(numbering.slices, [0..2, 2..4]);
        assert_eq!(numbering.internal_of[10], 16);
        assert_eq!(numbering.pairs().count(), 20);
    }
}
