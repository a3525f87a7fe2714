//! The potential of contact, its forces and their powers, from positions of a surface's particles.

use crate::contact::distance::nearest;
use crate::contact::friction::{Under, cut, squareness};
use crate::contact::options::ContactOptions;
use crate::contact::search::{Lists, Near, Row, Rules, distance};
use crate::contact::surface::Surface;
use crate::contact::walls::{Part, Wall, parts};
use crate::particles::Particles;
use crate::state::Stick;
use sph::Vector;
use words::rigid::Pose;

/// What a contact that is not deep may add to the square of the largest frequency: it rises by 7 % at most,
/// which `SAFETY` of the sub-step (10 %) holds.
const FREQUENCY_SHARE: f64 = 0.15;

/// Tangential over normal stiffness.
const TANGENTIAL: f64 = 0.5;

/// Least margin of the lists (spacings of the finest body).
const MARGIN: f64 = 1.5;

/// Parts of a body do not meet where they are nearer than this (spacings) in the reference configuration.
const APART: f64 = 2.5;

/// How much the energy is raised where a node has gone all of the thickness.
const STIFFENING: f64 = 1.0;

/// Contact begins so much later (fraction of the thickness) than faces touch: what just touches has no force,
/// whatever the round-off.
const LATE: f64 = 1e-6;

/// Nodes near a clamp that are so much (half thicknesses) farther from a wall than their half thickness stand
/// on it: cells are not as wide along all axes.
const ON: f64 = 0.5;

/// A node that is nearer to a surface than this (fraction of the thickness) is about to pass.
const PASSING: f64 = 0.05;

/// What the search goes by.
macro_rules! rules {
    ($contact:expr) => {
        Rules {
            surface: &$contact.surface,
            reference: &$contact.reference,
            thickness: &$contact.thickness,
            bodies: $contact.bodies,
            apart: &$contact.apart,
            margin: $contact.margin,
        }
    };
}

/// Contact of a structure. Nothing of it but scratch changes in a run.
#[derive(Clone, Debug)]
pub(crate) struct Contact<const D: usize> {
    surface: Surface,
    /// Reference positions (m) of the nodes, and whether they are fixed.
    reference: Vec<Vector<D>>,
    fixed: Vec<bool>,
    bodies: usize,
    /// Distance (m) at which two bodies meet, and stiffness (N/m) of a node of the one on the other.
    thickness: Vec<f64>,
    stiffness: Vec<f64>,
    apart: Vec<f64>,
    least_margin: f64,
    margin: f64,
    friction: f64,
    walls: Vec<Wall<D>>,
    wall_parts: Vec<Vec<(Part<D>, f64)>>,
    /// Distance (m) at which a body's nodes meet a wall, and their stiffness (N/m).
    half: Vec<f64>,
    wall_stiffness: Vec<f64>,
    /// Nodes that were nearer to a wall at the start, by node and wall, and where they meet it (m); 0 where
    /// never.
    begun: Vec<((u32, u32), f64)>,
    lists: Lists,
    /// Where all was when the lists were made.
    listed_at: Vec<Vector<D>>,
    listed_poses: Vec<Option<Pose<D>>>,
    /// Nodes in the lists.
    involved: Vec<u32>,
    /// Springs of the rows (m).
    springs: Vec<Vector<D>>,
    /// Positions (m) and time (s) at the start of the sub-step.
    began: Vec<Vector<D>>,
    began_poses: Vec<Option<Pose<D>>>,
    poses: Vec<Option<Pose<D>>>,
    at: Vec<Vector<D>>,
    forces: Vec<Vector<D>>,
    kept: Vec<Stick<D>>,
}

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

/// A node that is about to pass through a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Passed {
    pub particle: usize,
    pub position: Vec<f64>,
    pub body: usize,
    /// Body, or after all bodies wall.
    pub partner: usize,
}

impl<const D: usize> Contact<D> {
    /// Contact of these particles, whose largest frequency is `omega` (rad/s); none where nothing may meet.
    pub fn new(particles: &Particles<D>, omega: f64) -> Option<Self> {
        let setup = &particles.setup;
        let ContactOptions { friction, walls, bodies, itself } = setup.contact.options;
        let count = setup.bodies.len();
        if !setup.contact.acts(count) {
            return None;
        }
        let walls = if walls { setup.contact.walls.clone() } else { Vec::new() };
        let surface = Surface::new(&setup.bodies);
        let reference: Vec<Vector<D>> =
            surface.particles.iter().map(|&p| particles.reference_positions[p as usize]).collect();
        let fixed: Vec<bool> = surface.particles.iter().map(|&p| particles.clamped[p as usize]).collect();
        let half: Vec<f64> = setup.bodies.iter().map(|body| 0.5 * body.cell.min()).collect();
        let mut masses = vec![f64::INFINITY; count];
        for (node, &particle) in surface.particles.iter().enumerate() {
            let mass = &mut masses[surface.bodies[node] as usize];
            *mass = mass.min(particles.masses[particle as usize]);
        }
        let (mut thickness, mut stiffness) = (vec![0.0; count * count], vec![0.0; count * count]);
        for a in 0..count {
            for b in 0..count {
                if if a == b { itself } else { bodies } {
                    thickness[a * count + b] = (half[a] + half[b]) * (1.0 - LATE);
                }
                // Two nodes that face each other have both their springs: ½ k each, so that the frequency of
                // the lighter rises by k (1/m + 1/m), whatever the masses.
                let mass = masses[a] * masses[b] / (masses[a] + masses[b]);
                stiffness[a * count + b] = 0.5 * FREQUENCY_SHARE * omega * omega * mass;
            }
        }
        let wall_stiffness = masses.iter().map(|mass| FREQUENCY_SHARE * omega * omega * mass).collect();
        let finest = setup.bodies.iter().map(crate::Body::spacing).fold(f64::INFINITY, f64::min);
        let nodes = surface.particles.len();
        let mut contact = Self {
            apart: setup.bodies.iter().map(|body| APART * body.spacing()).collect(),
            wall_parts: walls.iter().map(|wall| parts(&wall.shape)).collect(),
            bodies: count,
            least_margin: MARGIN * finest,
            margin: MARGIN * finest,
            lists: Lists::default(),
            listed_at: Vec::new(),
            listed_poses: Vec::new(),
            involved: Vec::new(),
            springs: Vec::new(),
            began: reference.clone(),
            began_poses: Vec::new(),
            poses: Vec::new(),
            at: reference.clone(),
            forces: vec![Vector::zeros(); nodes],
            kept: Vec::new(),
            begun: Vec::new(),
            surface,
            reference,
            fixed,
            thickness,
            stiffness,
            friction,
            walls,
            half,
            wall_stiffness,
        };
        contact.let_touching_rest(particles);
        Some(contact)
    }

    /// What touches or overlaps at the start does so without force: bodies meet where they are then, nodes
    /// and walls too, and nodes near a clamp do not meet a wall that they stand in or on.
    fn let_touching_rest(&mut self, particles: &Particles<D>) {
        let count = self.bodies;
        let mut at = self.reference.clone();
        particles.follow_clamps(0.0, |particle, displacement, _| {
            if let Ok(node) = self.surface.particles.binary_search(&(particle as u32)) {
                at[node] += displacement;
            }
        });
        self.lists.of_bodies(&rules!(self), &at);
        for row in &self.lists.rows {
            let (own, other) = (self.surface.bodies[row.node as usize] as usize, row.partner as usize);
            for near in &self.lists.near[row.parts.0 as usize..row.parts.1 as usize] {
                let corners = &near.corners[..near.count as usize];
                let gap = distance(&at[row.node as usize], corners, &at) * (1.0 - LATE);
                if own != other && gap < self.thickness[own * count + other] {
                    // What lies in each other at the start never meets.
                    let least = 0.25 * (self.half[own] + self.half[other]);
                    let meet = if gap < least { 0.0 } else { gap };
                    let before = self.thickness[own * count + other];
                    (self.thickness[own * count + other], self.thickness[other * count + own]) =
                        (meet.min(before), meet.min(before));
                }
            }
        }
        for wall in 0..self.walls.len() {
            let pose = self.walls[wall].pose(0.0);
            for node in 0..at.len() {
                let body = self.surface.bodies[node] as usize;
                let rest = pose.map_or(at[node], |pose| pose.at_rest(&at[node]));
                let parts = self.wall_parts[wall].iter();
                let gap = parts.map(|(part, _)| (rest - part.nearest(&rest)).norm());
                let gap = gap.fold(f64::INFINITY, f64::min);
                if self.fixed[node] || gap > self.half[body] * (1.0 + ON) {
                    continue;
                }
                let held = is_near_clamp(particles, self.surface.particles[node] as usize, body);
                let meets = if held { 0.0 } else { gap.min(self.half[body]) * (1.0 - LATE) };
                self.begun.push(((node as u32, wall as u32), meets));
            }
        }
        self.begun.sort_unstable_by_key(|(key, _)| *key);
    }

    /// Name of a body, or after all bodies of a wall.
    pub fn name(&self, names: &[String], partner: usize) -> String {
        match partner.checked_sub(self.bodies) {
            Some(wall) => format!("wall \"{}\"", self.walls[wall].name),
            None => names.get(partner).map_or(format!("body {partner}"), |name| format!("body \"{name}\"")),
        }
    }

    /// Distance (m) at which a node meets a partner, and its stiffness (N/m).
    fn meeting(&self, row: &Row) -> (f64, f64) {
        let (own, partner) = (self.surface.bodies[row.node as usize] as usize, row.partner as usize);
        match partner.checked_sub(self.bodies) {
            None => {
                (self.thickness[own * self.bodies + partner], self.stiffness[own * self.bodies + partner])
            }
            Some(wall) => (self.meets_wall(row.node, wall), self.wall_stiffness[own]),
        }
    }

    fn meets_wall(&self, node: u32, wall: usize) -> f64 {
        let begun = self.begun.binary_search_by_key(&(node, wall as u32), |(key, _)| *key);
        let half = self.half[self.surface.bodies[node as usize] as usize] * (1.0 - LATE);
        begun.map_or(half, |n| self.begun[n].1)
    }

    /// Takes the springs of a state, and lists what is near at its time (s), for sub-steps of a length (s).
    pub fn begin(
        &mut self,
        (time, sub_step): (f64, f64),
        sticks: &[Stick<D>],
        position: impl Fn(usize) -> Vector<D>,
        velocity: impl Fn(usize) -> Vector<D>,
    ) {
        let speeds = self.surface.particles.iter().map(|&p| velocity(p as usize).norm_squared());
        let farthest = speeds.fold(0.0, f64::max).sqrt() * sub_step;
        // Powers of two, so that it seldom changes.
        let mut margin = self.least_margin;
        while margin < 5.0 * farthest {
            margin *= 2.0;
        }
        if margin != self.margin {
            self.margin = margin;
            self.listed_at.clear();
        }
        self.kept.clear();
        self.kept.extend_from_slice(sticks);
        self.springs.clear();
        self.look(time, position);
        self.take_springs();
    }

    /// Begins a sub-step at a time (s): lists anew what is near, if something has gone far.
    pub fn follow(&mut self, time: f64, position: impl Fn(usize) -> Vector<D>) {
        if self.look(time, position) {
            self.take_springs();
        }
        if !self.lists.rows.is_empty() {
            self.began.copy_from_slice(&self.at);
            self.began_poses.clone_from(&self.poses);
        }
    }

    /// Whether anything is near.
    pub fn is_near(&self) -> bool {
        !self.lists.rows.is_empty()
    }

    /// Sees where nodes and walls are; whether the lists were made anew.
    fn look(&mut self, time: f64, position: impl Fn(usize) -> Vector<D>) -> bool {
        for (at, &particle) in self.at.iter_mut().zip(&self.surface.particles) {
            *at = position(particle as usize);
        }
        self.pose_walls(time);
        // In the sub-step that follows as much again, of both sides.
        let allowed = 0.25 * self.margin;
        let gone = |(a, b): (&Vector<D>, &Vector<D>)| (a - b).norm_squared() > allowed * allowed;
        let stale = self.listed_at.len() != self.at.len()
            || self.at.iter().zip(&self.listed_at).any(gone)
            || (0..self.walls.len()).any(|wall| self.wall_has_gone(wall) > allowed);
        if stale {
            self.keep_springs();
            self.list();
        }
        stale
    }

    fn pose_walls(&mut self, time: f64) {
        self.poses.clear();
        self.poses.extend(self.walls.iter().map(|wall| wall.pose(time)));
    }

    /// Most that a corner of a wall's box has gone (m) since the lists were made.
    fn wall_has_gone(&self, wall: usize) -> f64 {
        let (Some(now), Some(then)) = (self.poses[wall], self.listed_poses[wall]) else { return 0.0 };
        let (low, high) = self.walls[wall].corners();
        let corner = |n: usize| Vector::<D>::from_fn(|i, _| if n >> i & 1 == 1 { high[i] } else { low[i] });
        let gone = |n: usize| (now.moved(&corner(n)) - then.moved(&corner(n))).norm();
        (0..1usize << D).map(gone).fold(0.0, f64::max)
    }

    fn list(&mut self) {
        self.lists.of_bodies(&rules!(self), &self.at);
        for wall in 0..self.walls.len() {
            let (low, high) = self.walls[wall].corners();
            for node in 0..self.at.len() {
                if self.fixed[node] {
                    continue;
                }
                let meets = self.meets_wall(node as u32, wall);
                let rest = self.poses[wall].map_or(self.at[node], |pose| pose.at_rest(&self.at[node]));
                let within = meets + self.margin;
                let clear = (0..D).any(|i| rest[i] < low[i] - within || rest[i] > high[i] + within);
                if meets > 0.0 && !clear {
                    let key = (node as u32, (self.bodies + wall) as u32);
                    self.lists.of_wall(key, &rest, &self.wall_parts[wall], within);
                }
            }
        }
        self.listed_at.clone_from(&self.at);
        self.listed_poses.clone_from(&self.poses);
        self.involved.clear();
        for row in &self.lists.rows {
            self.involved.push(row.node);
            if (row.partner as usize) < self.bodies {
                let near = &self.lists.near[row.parts.0 as usize..row.parts.1 as usize];
                near.iter().for_each(|n| self.involved.extend(&n.corners[..n.count as usize]));
            }
        }
        self.involved.sort_unstable();
        self.involved.dedup();
    }

    /// Springs of the rows to `kept`.
    fn keep_springs(&mut self) {
        if self.springs.len() == self.lists.rows.len() && !self.springs.is_empty() {
            self.kept.clear();
            for (row, spring) in self.lists.rows.iter().zip(&self.springs) {
                if *spring != Vector::<D>::zeros() {
                    let particle = self.surface.particles[row.node as usize];
                    self.kept.push(Stick { particle, partner: row.partner, spring: *spring });
                }
            }
            self.kept.sort_unstable_by_key(|stick| (stick.particle, stick.partner));
        }
    }

    /// Springs of the rows from `kept`.
    fn take_springs(&mut self) {
        self.springs.clear();
        if self.friction == 0.0 {
            return;
        }
        for row in &self.lists.rows {
            let key = (self.surface.particles[row.node as usize], row.partner);
            let found = self.kept.binary_search_by_key(&key, |stick| (stick.particle, stick.partner));
            self.springs.push(found.map_or(Vector::zeros(), |n| self.kept[n].spring));
        }
    }

    /// Springs as a state keeps them.
    pub fn sticks(&mut self) -> &[Stick<D>] {
        self.kept.clear();
        self.keep_springs();
        &self.kept
    }

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

    fn points(&self, corners: [u32; 3]) -> [Vector<D>; 3] {
        corners.map(|corner| self.at[corner as usize])
    }

    fn under<'a>(&self, found: &'a Found, points: &'a [Vector<D>; 3]) -> Under<'a, D> {
        let Found { corners, weights, distance, .. } = found;
        Under { corners: &corners[..D], points: &points[..D], weights: *weights, distance: *distance }
    }

    /// The force of a row on its node and its energy; none where they do not touch.
    fn meet(&self, row: &Row) -> Result<Option<Met<D>>, Passed> {
        let (meets, stiffness) = self.meeting(row);
        let (mut force, mut energy, mut touching) = (Vector::zeros(), 0.0, false);
        let mut least = f64::INFINITY;
        let mut under = None;
        self.each_part(row, meets, |near, weights, away, distance| {
            touching = true;
            let (energy_of, force_of) = response(stiffness * near.sign, meets, distance);
            energy += energy_of;
            force += away * (force_of / distance);
            if near.sign > 0.0 && distance < least {
                least = distance;
            }
            if (row.partner as usize) < self.bodies && near.count as usize == D {
                let squareness = squareness(&self.points(near.corners)[..D], &(away / distance));
                let nearer = under.is_none_or(|found: Found| {
                    let tie = (distance - found.distance).abs() <= 1e-9 * meets;
                    if tie { squareness > found.squareness } else { distance < found.distance }
                });
                if nearer {
                    under = Some(Found { corners: near.corners, weights, distance, squareness });
                }
            }
        });
        if !touching {
            return Ok(None);
        }
        if least <= PASSING * meets {
            return Err(self.passed(row));
        }
        let normal_force = force.norm();
        let normal = if normal_force > 0.0 { force / normal_force } else { Vector::zeros() };
        Ok(Some(Met { force, energy, normal_force, normal, under }))
    }

    fn passed(&self, row: &Row) -> Passed {
        Passed {
            particle: self.surface.particles[row.node as usize] as usize,
            position: self.at[row.node as usize].as_slice().to_vec(),
            body: self.surface.bodies[row.node as usize] as usize,
            partner: row.partner as usize,
        }
    }

    /// Whether a row's node was before a part of its partner when the sub-step began, and is now before its
    /// other side.
    fn has_crossed(&self, row: &Row) -> bool {
        if self.meeting(row).0 == 0.0 {
            return false;
        }
        let wall = (row.partner as usize).checked_sub(self.bodies);
        let node = row.node as usize;
        self.lists.near[row.parts.0 as usize..row.parts.1 as usize].iter().any(|near| match wall {
            None => {
                near.count as usize == D && {
                    let nodes = &near.corners[..D];
                    let before = side(&self.began[node], nodes.iter().map(|&n| self.began[n as usize]));
                    let now = side(&self.at[node], nodes.iter().map(|&n| self.at[n as usize]));
                    before * now < 0.0
                }
            }
            Some(wall) => {
                let Part::Segment(a, b) = self.wall_parts[wall][near.corners[0] as usize].0 else {
                    return false;
                };
                let rest = |pose: Option<Pose<D>>, x: Vector<D>| pose.map_or(x, |pose| pose.at_rest(&x));
                let before = side(&rest(self.began_poses[wall], self.began[node]), [a, b].into_iter());
                before * side(&rest(self.poses[wall], self.at[node]), [a, b].into_iter()) < 0.0
            }
        })
    }

    /// Gives a body's nodes the opposite of what they do to a row's node.
    fn push_back(&mut self, row: &Row) {
        if row.partner as usize >= self.bodies {
            return;
        }
        let (meets, stiffness) = self.meeting(row);
        let mut forces = std::mem::take(&mut self.forces);
        self.each_part(row, meets, |near, weights, away, distance| {
            let force = away * (response(stiffness * near.sign, meets, distance).1 / distance);
            for (&corner, weight) in near.corners[..near.count as usize].iter().zip(weights) {
                forces[corner as usize] -= force * weight;
            }
        });
        self.forces = forces;
    }

    /// Calls `visit(part, weights of its corners, from its nearest point to the node, distance)` for the
    /// parts of a row that are nearer than `meets` (m).
    fn each_part(&self, row: &Row, meets: f64, mut visit: impl FnMut(&Near, [f64; 3], Vector<D>, f64)) {
        let x = self.at[row.node as usize];
        let wall = (row.partner as usize).checked_sub(self.bodies);
        for near in &self.lists.near[row.parts.0 as usize..row.parts.1 as usize] {
            let (weights, away) = match wall {
                None => {
                    let points =
                        self.points(near.corners.map(|c| if c == u32::MAX { near.corners[0] } else { c }));
                    let points = &points[..near.count as usize];
                    let weights = nearest(&x, points);
                    (weights, points.iter().zip(weights).fold(x, |sum, (p, w)| sum - p * w))
                }
                Some(wall) => {
                    let part = &self.wall_parts[wall][near.corners[0] as usize].0;
                    (
                        [1.0, 0.0, 0.0],
                        match &self.poses[wall] {
                            None => x - part.nearest(&x),
                            Some(pose) => {
                                let rest = pose.at_rest(&x);
                                pose.turned(&(rest - part.nearest(&rest)))
                            }
                        },
                    )
                }
            };
            let distance = away.norm();
            if distance < meets {
                visit(near, weights, away, distance);
            }
        }
    }
}

/// A node that touches.
#[derive(Clone, Copy)]
struct Met<const D: usize> {
    force: Vector<D>,
    energy: f64,
    normal_force: f64,
    normal: Vector<D>,
    /// Nearest element of a body.
    under: Option<Found>,
}

/// An element near a node.
#[derive(Clone, Copy)]
struct Found {
    corners: [u32; 3],
    weights: [f64; 3],
    distance: f64,
    /// How squarely the node stands before it.
    squareness: f64,
}

/// Energy (J) and force (N) at a distance (m) of a surface that is met at `meets` (m).
fn response(stiffness: f64, meets: f64, distance: f64) -> (f64, f64) {
    let depth = meets - distance;
    let square = depth * depth / (meets * meets);
    let (energy, force) = (0.5 + 0.5 * STIFFENING * square, 1.0 + 2.0 * STIFFENING * square);
    (stiffness * depth * depth * energy, stiffness * depth * force)
}

/// The sign of the side of a segment's line, or a triangle's plane, on which `x` is; 0 where the nearest
/// point is on its border.
fn side<const D: usize>(x: &Vector<D>, corners: impl Iterator<Item = Vector<D>>) -> f64 {
    let mut points = [Vector::zeros(); 3];
    points.iter_mut().zip(corners).for_each(|(to, from)| *to = from);
    let points = &points[..D];
    let weights = nearest(x, points);
    if weights[..D].iter().any(|&w| w <= 0.0) {
        return 0.0;
    }
    let (a, r) = (points[1] - points[0], x - points[0]);
    let volume = if D == 2 {
        a[0] * r[1] - a[1] * r[0]
    } else {
        let b = points[2] - points[0];
        (0..3).map(|i| (a[(i + 1) % D] * b[(i + 2) % D] - a[(i + 2) % D] * b[(i + 1) % D]) * r[i]).sum()
    };
    volume.signum()
}

/// Whether a particle is within two smoothing lengths of a fixed one of its body.
fn is_near_clamp<const D: usize>(particles: &Particles<D>, particle: usize, body: usize) -> bool {
    let setup = &particles.setup;
    let first: usize = setup.bodies[..body].iter().map(|b| b.positions.len()).sum();
    let of = &setup.bodies[body];
    let reach = 2.0 * setup.options.smoothing_ratio * of.spacing() * (1.0 + 1e-9);
    let x = particles.reference_positions[particle];
    (0..of.positions.len())
        .any(|n| of.clamped[n] && (particles.reference_positions[first + n] - x).norm() <= reach)
}

#[cfg(test)]
mod tests {
    use super::*;
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
