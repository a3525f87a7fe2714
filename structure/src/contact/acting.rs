//! What contact does: forces and their powers at a stage, springs and energies at the ends of sub-steps.

use crate::contact::friction::cut;
use crate::contact::meeting::{Met, Passed};
use crate::contact::pairing::Contact;
use crate::contact::search::Row;
use crate::contact::surface::Surface;
use sph::Vector;

/// Tangential over normal stiffness.
const TANGENTIAL: f64 = 0.5;

/// Powers (W) of the forces of contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Power {
    /// On free particles.
    pub on_free: f64,
    /// Of clamps that move, and of walls, on the structure.
    pub clamps: f64,
    pub walls: f64,
    /// That friction takes, its springs among it.
    pub friction: f64,
}

impl<const D: usize> Contact<D> {
    /// Forces of contact at a time (s) on the particles where they are; none where nothing touches.
    ///
    /// # Errors
    /// A node that is about to pass through a surface.
    pub fn act(
        &mut self,
        time: f64,
        position: impl Fn(usize) -> Vector<D>,
        velocity: impl Fn(usize) -> Vector<D>,
    ) -> Result<Option<Power>, Passed> {
        self.see(time, position);
        for &node in &self.involved {
            self.forces[node as usize] = Vector::zeros();
        }
        let mut touching = false;
        let mut power = Power::default();
        let velocity_of = |surface: &Surface, node: usize| velocity(surface.particles[node] as usize);
        for r in 0..self.lists.rows.len() {
            let row = self.lists.rows[r];
            let Some(met) = self.meet(&row)? else { continue };
            touching = true;
            let node = row.node as usize;
            let mut force = met.force;
            self.push_back(&row);
            let rubs = self.friction > 0.0 && met.normal_force > 0.0;
            let twist = self.twist(&row, time);
            if rubs {
                let stiffness = TANGENTIAL * self.meeting(&row).1;
                let spring = self.springs[r] + self.slip(&row, &met);
                let spring = cut(&spring, &met.normal, stiffness, self.friction * met.normal_force);
                let rubbing = spring * -stiffness;
                let carried = match (&twist, met.under) {
                    (Some(twist), _) => *twist,
                    (None, None) => Vector::zeros(),
                    (None, Some(found)) => {
                        let points = self.points(found.corners);
                        let under = self.under(&found, &points);
                        let surface = &self.surface;
                        let forces = &mut self.forces;
                        under.share(&met.normal, &rubbing, |corner, given| forces[corner] += given);
                        under.carried(&met.normal, |corner| velocity_of(surface, corner))
                    }
                };
                power.friction -= rubbing.dot(&(velocity_of(&self.surface, node) - carried));
                force += rubbing;
            }
            if let Some(twist) = twist {
                power.walls += force.dot(&twist);
            }
            self.forces[node] += force;
        }
        if !touching {
            return Ok(None);
        }
        for &node in &self.involved {
            let node = node as usize;
            let given = self.forces[node].dot(&velocity_of(&self.surface, node));
            if self.fixed[node] { power.clamps -= given } else { power.on_free += given }
        }
        Ok(Some(power))
    }

    /// Force (N) on each free particle that the last [`act`](Self::act) found.
    pub fn forces(&self) -> impl Iterator<Item = (usize, Vector<D>)> + '_ {
        let free = self.involved.iter().map(|&node| node as usize).filter(|&node| !self.fixed[node]);
        free.map(|node| (self.surface.particles[node] as usize, self.forces[node]))
    }

    /// Ends a sub-step at a time (s): springs are what they have become.
    pub fn settle(&mut self, time: f64, position: impl Fn(usize) -> Vector<D>) -> Result<(), Passed> {
        if self.lists.rows.is_empty() {
            return Ok(());
        }
        self.see(time, position);
        for row in &self.lists.rows {
            if self.has_crossed(row) {
                return Err(self.passed(row));
            }
        }
        if self.friction == 0.0 {
            return Ok(());
        }
        for r in 0..self.lists.rows.len() {
            let row = self.lists.rows[r];
            self.springs[r] = match self.meet(&row)? {
                Some(met) if met.normal_force > 0.0 => {
                    let stiffness = TANGENTIAL * self.meeting(&row).1;
                    let spring = self.springs[r] + self.slip(&row, &met);
                    cut(&spring, &met.normal, stiffness, self.friction * met.normal_force)
                }
                _ => Vector::zeros(),
            };
        }
        Ok(())
    }

    /// Energy (J) of the springs of friction.
    pub fn energy_of_springs(&self) -> f64 {
        let rows = self.lists.rows.iter().zip(&self.springs);
        rows.map(|(row, spring)| 0.5 * TANGENTIAL * self.meeting(row).1 * spring.norm_squared()).sum()
    }

    /// Energies (J) of contact and of the springs among it, at a time (s).
    pub fn energy(&mut self, time: f64, position: impl Fn(usize) -> Vector<D>) -> Result<(f64, f64), Passed> {
        if self.lists.rows.is_empty() {
            return Ok((0.0, 0.0));
        }
        self.see(time, position);
        let mut energy = 0.0;
        for row in &self.lists.rows {
            energy += self.meet(row)?.map_or(0.0, |met| met.energy);
        }
        let springs = self.energy_of_springs();
        Ok((energy + springs, springs))
    }

    fn see(&mut self, time: f64, position: impl Fn(usize) -> Vector<D>) {
        for &node in &self.involved {
            self.at[node as usize] = position(self.surface.particles[node as usize] as usize);
        }
        self.pose_walls(time);
    }

    /// Velocity (m/s) of the point of a row's wall that is at its node; none of a body.
    fn twist(&self, row: &Row, time: f64) -> Option<Vector<D>> {
        let wall = (row.partner as usize).checked_sub(self.bodies)?;
        let motion = self.walls[wall].motion.as_ref();
        Some(motion.map_or(Vector::zeros(), |m| m.twist(time).at(&self.at[row.node as usize])))
    }

    /// What a node has slipped (m) over its partner since the sub-step's start.
    fn slip(&self, row: &Row, met: &Met<D>) -> Vector<D> {
        let node = row.node as usize;
        let gone = |node: usize| self.at[node] - self.began[node];
        match (row.partner as usize).checked_sub(self.bodies) {
            Some(wall) => match (self.poses[wall], self.began_poses[wall]) {
                (Some(now), Some(then)) => then.moved(&now.at_rest(&self.at[node])) - self.began[node],
                _ => gone(node),
            },
            None => met.under.map_or(Vector::zeros(), |found| {
                let points = self.points(found.corners);
                gone(node) - self.under(&found, &points).carried(&met.normal, gone)
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::walls::Wall;
    use crate::particles::Particles;
    use crate::{Body, Law, Material, Plane, Setup, WallShape};

    fn material(assumption: Plane) -> Material {
        Material::new(Law::StVenantKirchhoff, 1e6, 0.3, assumption)
    }

    /// A contact of two bodies, and where the second one is brought by a shift and a displacement of all.
    fn two<const D: usize>(
        bodies: Vec<Body<D>>,
        shift: Vector<D>,
        walls: Vec<Wall<D>>,
    ) -> (Contact<D>, Vec<Vector<D>>) {
        let first = bodies[0].positions.len();
        let mut setup = Setup::new(bodies);
        setup.contact.walls = walls;
        let particles = Particles::new(setup).unwrap();
        let contact = Contact::new(&particles, 100.0).unwrap();
        let rough = |n: usize, i: usize| 0.02 * ((n * 7 + i * 3) as f64 * 1.7).sin();
        let at = particles.reference_positions.iter().enumerate().map(|(n, x)| {
            let moved = if n < first { *x } else { x + shift };
            moved + Vector::from_fn(|i, _| rough(n, i))
        });
        (contact, at.collect())
    }

    /// Forces against central differences of the energy, whose error is of the second order in the step;
    /// forces and their moments sum to nothing.
    fn check<const D: usize>((mut contact, at): (Contact<D>, Vec<Vector<D>>), closed: bool) -> usize {
        contact.begin((0.0, 0.0), &[], |p| at[p], |_| Vector::zeros());
        assert!(contact.act(0.0, |p| at[p], |_| Vector::zeros()).unwrap().is_some());
        let forces: Vec<(usize, Vector<D>)> = contact.forces().collect();
        let largest = forces.iter().map(|(_, f)| f.norm()).fold(0.0, f64::max);
        let (mut sum, mut moment, mut acted) = (Vector::<D>::zeros(), Vector::<3>::zeros(), 0);
        for (p, force) in &forces {
            sum += force;
            let x = at[*p];
            for i in 0..D {
                let j = (i + 1) % D;
                moment[i] += x[i] * force[j] - x[j] * force[i];
                let h = 1e-7;
                let mut energy = |sign: f64| {
                    let moved = |q: usize| {
                        if q == *p {
                            at[q] + Vector::from_fn(|k, _| if k == i { sign * h } else { 0.0 })
                        } else {
                            at[q]
                        }
                    };
                    contact.energy(0.0, moved).unwrap().0
                };
                let slope = (energy(1.0) - energy(-1.0)) / (2.0 * h);
                assert!((force[i] + slope).abs() < 1e-5 * largest, "{p} {i}: {} {}", force[i], -slope);
            }
            acted += usize::from(force.norm() > 0.0);
        }
        if closed {
            assert!(sum.norm() < 1e-13 * largest && moment.norm() < 1e-12 * largest, "{sum} {moment}");
        }
        acted
    }

    #[test]
    fn forces_are_the_gradient_of_the_energy_at_faces_edges_and_corners() {
        let flat = |low: [f64; 2], high: [f64; 2]| {
            Body::block(Vector::from(low), Vector::from(high), 1.0, material(Plane::Strain), 1.0)
        };
        // Over a face, past a corner, corner to corner twice.
        for shift in [[-0.3, -1.2], [2.4, -1.2], [4.7, -1.4], [4.5, -1.5]] {
            let bodies = vec![flat([0.0, 0.0], [5.0, 4.0]), flat([0.0, 5.0], [4.0, 9.0])];
            assert!(check(two(bodies, Vector::from(shift), Vec::new()), true) >= 2, "{shift:?}");
        }
        let points = [[0.0, 9.0], [0.0, 0.0], [9.0, 0.0]].map(Vector::from).to_vec();
        let corner = Wall { name: String::new(), shape: WallShape::Polyline(points), motion: None };
        let bodies = vec![flat([9.0, 20.0], [13.0, 24.0]), flat([1.0, 1.0], [5.0, 5.0])];
        assert!(check(two(bodies, Vector::from([-1.1, -1.1]), vec![corner]), false) >= 7);
        let solid = |low: [f64; 3]| {
            let low = Vector::from(low);
            Body::block(low, low + Vector::repeat(3.0), 1.0, material(Plane::ThreeDimensional), 1.0)
        };
        for shift in [[0.3, -1.2, 0.1], [2.5, -1.4, 0.4], [2.5, -1.5, 2.5]] {
            let bodies = vec![solid([0.0; 3]), solid([0.0, 4.0, 0.0])];
            assert!(check(two(bodies, Vector::from(shift), Vec::new()), true) >= 2, "{shift:?}");
        }
    }

    /// Over a flat face the energy is that of one nearest point, wherever over it: no joint is felt.
    #[test]
    fn a_flat_surface_has_no_bumps() {
        let block = |low: [f64; 3], edge: f64| {
            let low = Vector::from(low);
            Body::block(low, low + Vector::repeat(edge), 1.0, material(Plane::ThreeDimensional), 1.0)
        };
        let setup = Setup::new(vec![block([0.0; 3], 6.0), block([1.0, 8.0, 1.0], 3.0)]);
        let particles = Particles::new(setup).unwrap();
        let mut contact = Contact::new(&particles, 100.0).unwrap();
        let mut seen: Option<f64> = None;
        for n in 0..40 {
            let aside = Vector::from([0.03 * f64::from(n), -2.1, 0.017 * f64::from(n)]);
            let at =
                |p: usize| particles.reference_positions[p] + if p < 216 { Vector::zeros() } else { aside };
            contact.begin((0.0, 0.0), &[], at, |_| Vector::zeros());
            let energy = contact.energy(0.0, at).unwrap().0;
            // The nodes of the large face that the small one covers change: those of the small one alone.
            let rows = contact.lists.rows.iter().filter(|row| contact.surface.bodies[row.node as usize] == 1);
            let of_small: f64 =
                rows.map(|row| contact.meet(row).unwrap().map_or(0.0, |met| met.energy)).sum();
            assert!(energy >= of_small && of_small > 0.0);
            let first = *seen.get_or_insert(of_small);
            assert!((of_small / first - 1.0).abs() < 1e-12, "{n}: {of_small} {first}");
        }
    }
}
