//! Wall particles behind the structure's face: what they do across it is the structure's.
//!
//! Where a structure stands on a wall, the corner behind both is filled by wall particles. They press on the
//! fluid across the structure's face as well as across the wall's: with them the pressure on the face is
//! carried down to the wall, without them the face lacks a third of a spacing of it, and its velocity ends as
//! much too high.

use sph::Vector;
use sph::neighbours::{CellGrid, NeighbourList};

/// A wall particle that stands for an interface particle in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tie<const D: usize> {
    /// The wall particle.
    pub wall: u32,
    /// The interface particle.
    pub structure: u32,
    /// Across the structure's face and along the wall's; its square is the share of the particle's cell that
    /// lies behind the face.
    pub direction: Vector<D>,
    /// Unit normal out of the wall.
    pub wall_normal: Vector<D>,
}

/// Length below which a face's normal, the wall's taken out, counts as none: the face goes on as the wall.
const ASLANT: f64 = 0.3;

/// Spacings of a wall within which interface particles tell where the face stands on it.
const BESIDE: f64 = 0.75;

/// Ties the walls' particles to the interface particles within `support` (m). `walls` are positions and
/// spacings (m), and the outward normal of the wall at each; `structure` positions, outward normals (zero
/// inside) and spacings (m).
pub fn find<const D: usize>(
    support: f64,
    (walls, wall_spacing, wall_normal): (&[Vector<D>], impl Fn(usize) -> f64, impl Fn(usize) -> Vector<D>),
    (structure, normals, spacings): (&[Vector<D>], &[Vector<D>], &[f64]),
    near: &mut NeighbourList,
    out: &mut Vec<Tie<D>>,
) {
    out.clear();
    if walls.is_empty() || structure.is_empty() {
        return;
    }
    near.rebuild(walls, &CellGrid::new(structure, support), structure);
    for (w, at) in walls.iter().enumerate() {
        let spacing = wall_spacing(w);
        // The last particle of a wall that slides may have no volume.
        if near.of(w).is_empty() || spacing == 0.0 {
            continue;
        }
        let n = wall_normal(w);
        let across = |s: usize| normals[s] - n * n.dot(&normals[s]);
        let offset = |s: usize| structure[s] - at;
        let near = || near.of(w).iter().map(|&s| s as usize);
        let faces = near().filter(|&s| across(s).norm() > ASLANT);
        let nearest = |&s: &usize, &t: &usize| offset(s).norm_squared().total_cmp(&offset(t).norm_squared());
        let Some(nearest) = faces.min_by(nearest) else { continue };
        let direction = across(nearest).normalize();
        // The face is where the outermost particle beside the wall has it.
        let is_beside = |&s: &usize| {
            let r = offset(s);
            let aside = r - direction * direction.dot(&r) - n * n.dot(&r);
            let as_high = n.dot(&(r - offset(nearest))) < BESIDE * spacing;
            s == nearest || (aside.norm() < BESIDE * spacing && as_high)
        };
        let face = |s: usize| offset(s).dot(&direction) + 0.5 * spacings[s];
        let outermost = near().filter(is_beside).max_by(|&s, &t| face(s).total_cmp(&face(t)));
        let structure = outermost.expect("the nearest is beside the wall");
        let behind = (0.5 + face(structure) / spacing).clamp(0.0, 1.0);
        if behind > 0.0 {
            let direction = direction * behind.sqrt();
            out.push(Tie { wall: w as u32, structure: structure as u32, direction, wall_normal: n });
        }
    }
}

/// Takes from the `velocities` (m/s) of pairs of fluid and wall, `walls` particles of it, what ties leave to
/// the structure.
pub fn leave_to_structure<const D: usize>(
    ties: &[Tie<D>],
    walls: usize,
    near: &NeighbourList,
    velocities: &mut [Vector<D>],
) {
    if ties.is_empty() || velocities.is_empty() {
        return;
    }
    let mut tie_of = vec![None; walls];
    ties.iter().for_each(|tie| tie_of[tie.wall as usize] = Some(tie.direction));
    for (u, &w) in velocities.iter_mut().zip(near.indices()) {
        if let Some(direction) = &tie_of[w as usize] {
            *u -= direction * direction.dot(u);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::lattice::Lattice;

    type V = Vector<2>;

    /// A structure from x = 0 on stands on a bed of spacing 1: whatever its own spacing, the particles behind
    /// its face are tied, those before it are not, and one that the face halves is tied by half. A particle
    /// without volume is not tied.
    #[test]
    fn what_lies_behind_the_face_is_tied() {
        let walls = [-1.5, -0.5, 0.0, 0.5, 1.5].map(|x| V::from([x, -0.5]));
        for spacing in [1.0, 0.5, 0.25] {
            let structure = Lattice::fill_box(V::zeros(), V::from([4.0, 8.0]), spacing).positions;
            let normal = |at: &V| {
                let n = V::from([-f64::from(at.x < spacing), -f64::from(at.y < spacing)]);
                n.try_normalize(0.0).unwrap_or(n)
            };
            let normals: Vec<V> = structure.iter().map(normal).collect();
            let spacings = vec![spacing; structure.len()];
            let tied = |of: &[f64; 5]| {
                let mut ties = Vec::new();
                let up = |_| V::from([0.0, 1.0]);
                let faces = (&structure[..], &normals[..], &spacings[..]);
                find(2.4, (&walls, |w| of[w], up), faces, &mut NeighbourList::default(), &mut ties);
                ties.iter().map(|tie| (tie.wall, tie.direction.norm_squared())).collect::<Vec<_>>()
            };
            let expected = [(2, 0.5), (3, 1.0), (4, 1.0)];
            let found = tied(&[1.0; 5]);
            assert_eq!(found.len(), 3, "{spacing}: {found:?}");
            let same = |(found, expected): (&(u32, f64), &(u32, f64))| {
                found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-12
            };
            assert!(found.iter().zip(&expected).all(same), "{spacing}: {found:?}");
            assert_eq!(tied(&[1.0, 1.0, 0.0, 0.0, 1.0]).len(), 1, "{spacing}");
        }
    }
}
