//! Coulomb's friction with true sticking: a tangential spring for each node and partner, kept in the state.
//!
//! A spring is stretched by what the node has slipped over the partner's surface since they met, in the plane
//! across the normal force `N`; its force `k_t ξ` is `μ N` at most, and where it would be more the spring is
//! cut down to that: the node slides. In a sub-step the force is a function of positions and of the spring
//! at the sub-step's start (a return mapping, as of plasticity; Wriggers 2006, "Computational contact
//! mechanics", §6.3), so that a node which sticks goes nowhere, however long. What forces of friction take
//! and springs do not hold is lost.
//!
//! A surface that turns takes along what rests on it: the slip counts from the point of the surface under the
//! node, raised rigidly to the node. Its transpose, weights of the surface's nodes and a couple along the
//! normal, keeps the moment of momentum.

use crate::contact::distance::gradients;
use sph::Vector;

/// The partner's surface under a node, for bodies.
pub(crate) struct Under<'a, const D: usize> {
    /// Nodes of the element that is nearest, and where they are (m).
    pub corners: &'a [u32],
    pub points: &'a [Vector<D>],
    /// Weights of the nearest point.
    pub weights: [f64; 3],
    /// Distance (m) of the node from it.
    pub distance: f64,
}

impl<const D: usize> Under<'_, D> {
    /// What a vector field on nodes is at the surface, raised to the node along `normal`.
    pub fn carried(&self, normal: &Vector<D>, of: impl Fn(usize) -> Vector<D>) -> Vector<D> {
        let slopes = self.slopes(normal);
        let mut carried = Vector::zeros();
        for (k, &corner) in self.corners.iter().enumerate() {
            let value = of(corner as usize);
            carried += value * self.weights[k] - slopes[k] * (self.distance * normal.dot(&value));
        }
        carried
    }

    /// Slopes (1/m) of the weights, so that normal forces by them are the couple of a force at the node.
    /// Beyond an edge, where the normal is not square to the element, they lean: `∇λ − w (∇λ·n)/w²` with `w`
    /// what of `n` is square to it.
    fn slopes(&self, normal: &Vector<D>) -> [Vector<D>; 3] {
        let mut slopes = gradients(self.points);
        let w = square_part(self.points, normal);
        let square = w.norm_squared();
        if square > LEAST_SQUARENESS {
            slopes.iter_mut().for_each(|slope| *slope -= w * (slope.dot(normal) / square));
        }
        slopes
    }

    /// The transpose: what a force on the node is on the surface's nodes, with the opposite sign.
    pub fn share(&self, normal: &Vector<D>, force: &Vector<D>, mut give: impl FnMut(usize, Vector<D>)) {
        let slopes = self.slopes(normal);
        for (k, &corner) in self.corners.iter().enumerate() {
            let along = normal * (self.distance * slopes[k].dot(force));
            give(corner as usize, along - force * self.weights[k]);
        }
    }
}

/// Least square of what of a normal is square to the element that leans for it: 0.3².
const LEAST_SQUARENESS: f64 = 0.09;

/// What of a vector is square to an element.
fn square_part<const D: usize>(points: &[Vector<D>], vector: &Vector<D>) -> Vector<D> {
    let slopes = gradients(points);
    points.iter().zip(slopes).fold(*vector, |rest, (point, slope)| rest - point * slope.dot(vector))
}

/// How squarely a unit vector stands on an element: 1 is right across, 0 along it.
pub(crate) fn squareness<const D: usize>(points: &[Vector<D>], normal: &Vector<D>) -> f64 {
    square_part(points, normal).norm()
}

/// The spring `ξ` (m) in the plane across `normal`, cut down to what `limit` (N) allows.
pub(crate) fn cut<const D: usize>(
    spring: &Vector<D>,
    normal: &Vector<D>,
    stiffness: f64,
    limit: f64,
) -> Vector<D> {
    let across = spring - normal * normal.dot(spring);
    let force = stiffness * across.norm();
    if force > limit { across * (limit / force) } else { across }
}
