//! What may meet what: made once from the particles, and listed anew as they move.

use crate::contact::options::ContactOptions;
use crate::contact::search::{Lists, Row, Rules, distance};
use crate::contact::surface::Surface;
use crate::contact::walls::{Part, Wall, parts};
use crate::particles::Particles;
use crate::state::Stick;
use sph::Vector;
use words::rigid::Pose;

/// What a contact that is not deep may add to the square of the largest frequency: it rises by 7 % at most,
/// which `SAFETY` of the sub-step (10 %) holds.
const FREQUENCY_SHARE: f64 = 0.15;

/// Least margin of the lists (spacings of the finest body).
const MARGIN: f64 = 1.5;

/// Parts of a body do not meet where they are nearer than this (spacings) in the reference configuration.
const APART: f64 = 2.5;

/// Contact begins so much later (fraction of the thickness) than faces touch: what just touches has no force,
/// whatever the round-off.
const LATE: f64 = 1e-6;

/// Nodes near a clamp that are so much (half thicknesses) farther from a wall than their half thickness stand
/// on it: cells are not as wide along all axes.
const ON: f64 = 0.5;

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
    pub(super) surface: Surface,
    /// Reference positions (m) of the nodes, and whether they are fixed.
    pub(super) reference: Vec<Vector<D>>,
    pub(super) fixed: Vec<bool>,
    pub(super) bodies: usize,
    /// Distance (m) at which two bodies meet, and stiffness (N/m) of a node of the one on the other.
    pub(super) thickness: Vec<f64>,
    pub(super) stiffness: Vec<f64>,
    pub(super) apart: Vec<f64>,
    pub(super) least_margin: f64,
    pub(super) margin: f64,
    pub(super) friction: f64,
    pub(super) walls: Vec<Wall<D>>,
    pub(super) wall_parts: Vec<Vec<(Part<D>, f64)>>,
    /// Distance (m) at which a body's nodes meet a wall, and their stiffness (N/m).
    pub(super) half: Vec<f64>,
    pub(super) wall_stiffness: Vec<f64>,
    /// Nodes that were nearer to a wall at the start, by node and wall, and where they meet it (m); 0 where
    /// never.
    pub(super) begun: Vec<((u32, u32), f64)>,
    pub(super) lists: Lists,
    /// Where all was when the lists were made.
    pub(super) listed_at: Vec<Vector<D>>,
    pub(super) listed_poses: Vec<Option<Pose<D>>>,
    /// Nodes in the lists.
    pub(super) involved: Vec<u32>,
    /// Springs of the rows (m).
    pub(super) springs: Vec<Vector<D>>,
    /// Positions (m) and time (s) at the start of the sub-step.
    pub(super) began: Vec<Vector<D>>,
    pub(super) began_poses: Vec<Option<Pose<D>>>,
    pub(super) poses: Vec<Option<Pose<D>>>,
    pub(super) at: Vec<Vector<D>>,
    pub(super) forces: Vec<Vector<D>>,
    pub(super) kept: Vec<Stick<D>>,
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
    pub(super) fn meeting(&self, row: &Row) -> (f64, f64) {
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

    pub(super) fn pose_walls(&mut self, time: f64) {
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
