//! Condition (46) of the paper: along the normals, what the structure receives is what the fluid gave.
//!
//! `∇p_{f→s} · n_f = −∇p_{s→f} · n_s`. The fluid sends, for each interface particle of reference volume `V`,
//! the pressure gradient `g` at the structure (the load; force `−V g`), what it received itself from that
//! particle, the pair reaction `R` (force on the fluid `+V R`), and the normal `n`. Action and reaction along
//! the normal ask `g · n = R · n`, particle by particle.
//!
//! A fluid whose load is the transpose of its divergence fulfils this by construction; one that evaluates Eq.
//! (48) does not, because the fluid particles were moved by another sum than the structure particle.
//! [`enforce`] replaces the normal part of the load by what the fluid gave: force and moment of the normal
//! parts then agree for every particle, and so in total.

use pulp::NullaryFnOnce;

/// The fields of one solution that condition (46) speaks of, point by point, `components` doubles a vector.
#[derive(Clone, Copy, Debug)]
pub struct Interface<'a> {
    /// Components of a vector: the dimension.
    pub components: usize,
    /// Reference volumes `V` (m³).
    pub volume: &'a [f64],
    /// Positions (m).
    pub position: &'a [f64],
    /// Velocities (m/s): over a window, the mean ones.
    pub velocity: &'a [f64],
    /// What the fluid received; a fluid that does not tell is taken at its word: `R = g`.
    pub reaction: Option<Reaction<'a>>,
}

/// What the fluid received, and along what.
#[derive(Clone, Copy, Debug)]
pub struct Reaction<'a> {
    /// Pair reactions `R` (Pa/m).
    pub pair_reaction: &'a [f64],
    /// Unit normals out of the structure, or zero.
    pub normal: &'a [f64],
}

/// Resultants of a load field `g` over the interface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resultant {
    /// Total force on the structure `−Σ V g` (N); unused components are zero.
    pub force: [f64; 3],
    /// Total moment about the origin `−Σ r × V g` (N m); in two dimensions only the last component.
    pub moment: [f64; 3],
    /// Power given to the structure `−Σ V g · u` (W).
    pub power: f64,
}

/// What condition (46) found in one window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Condition46 {
    /// `√(Σ V ((g − R)·n)²) / √(Σ V (R·n)²)` of the load as the fluid sent it; zero where the fluid touches
    /// nothing.
    pub residual_before: f64,
    /// The same of the load as passed on.
    pub residual_after: f64,
    /// Resultant of what the fluid gave: its load were `g = R`.
    pub given: Resultant,
    /// Resultant of the load as the fluid sent it.
    pub before: Resultant,
    /// Resultant of the load as passed on.
    pub after: Resultant,
}

/// Replaces the normal part of the load `g` by that of what the fluid received. Says whether there was
/// anything to replace it by.
pub fn enforce(interface: &Interface, load: &mut [f64]) -> bool {
    let Some(Reaction { pair_reaction, normal }) = interface.reaction else { return false };
    let d = interface.components;
    for point in 0..interface.volume.len() {
        let at = point * d..(point + 1) * d;
        let normal = &normal[at.clone()];
        let load = &mut load[at.clone()];
        let missing = dot(&pair_reaction[at], normal) - dot(load, normal);
        for (g, n) in load.iter_mut().zip(normal) {
            *g += missing * n;
        }
    }
    true
}

/// Measures the condition for the load as `sent`, and as `passed` on; they are the same where it was not
/// enforced. The second resultant is that of the load `applied`.
pub fn measure(
    interface: &Interface,
    sent: &[f64],
    passed: Option<&[f64]>,
    applied: &[f64],
) -> (Condition46, Resultant) {
    let Some(reaction) = &interface.reaction else {
        let [before, applied] = resultants(interface, [sent, applied]);
        return (Condition46 { given: before, before, after: before, ..Condition46::default() }, applied);
    };
    let passed = passed.unwrap_or(sent);
    let [before, after, given, applied] =
        resultants(interface, [sent, passed, reaction.pair_reaction, applied]);
    let residual = |load| residual(interface.components, interface.volume, reaction, load);
    let (residual_before, residual_after) = (residual(sent), residual(passed));
    (Condition46 { residual_before, residual_after, given, before, after }, applied)
}

/// Resultants of load fields `g` (Pa/m).
pub fn resultants<const K: usize>(interface: &Interface, loads: [&[f64]; K]) -> [Resultant; K] {
    match interface.components {
        2 => resultants_in_plane(interface, loads),
        _ => loads.map(|load| resultant_in_space(interface, load)),
    }
}

fn resultants_in_plane<const K: usize>(interface: &Interface, loads: [&[f64]; K]) -> [Resultant; K] {
    pulp::Arch::new().dispatch(InPlane { interface, loads }).map(|sums| sums.resultant())
}

/// The sums in the plane, four points at once in sums of their own, so that a machine that adds eight numbers
/// at a time can. (A structure and no closure for the reason that [`crate::flat`] names.)
struct InPlane<'a, const K: usize> {
    interface: &'a Interface<'a>,
    loads: [&'a [f64]; K],
}

impl<const K: usize> NullaryFnOnce for InPlane<'_, K> {
    type Output = [Sums; K];

    #[inline(always)]
    fn call(self) -> [Sums; K] {
        let Interface { volume, position, velocity, .. } = *self.interface;
        let mut sums = [Sums::default(); K];
        // What stands beside a component of the load: minus the volume, and the other component of the
        // position. They are laid out first, so that the sums are over numbers one beside the other.
        let (mut weight, mut arm) = ([0.0; 2 * PIECE], [0.0; 2 * PIECE]);
        for (at, volume) in volume.chunks(PIECE).enumerate() {
            let piece = 2 * at * PIECE..2 * (at * PIECE + volume.len());
            for (pair, volume) in weight.as_chunks_mut::<2>().0.iter_mut().zip(volume) {
                *pair = [-volume; 2];
            }
            for (pair, x) in
                arm.as_chunks_mut::<2>().0.iter_mut().zip(position[piece.clone()].as_chunks::<2>().0)
            {
                *pair = [x[1], x[0]];
            }
            let (weight, arm) = (&weight[..piece.len()], &arm[..piece.len()]);
            let loads = self.loads.map(|load| &load[piece.clone()]);
            add(&mut sums, loads, [weight, arm, &velocity[piece.clone()]]);
        }
        sums
    }
}

/// Points of which the sums are taken at a time: some kilobytes.
const PIECE: usize = 256;

/// Sums over every fourth point, x and y in turn.
#[derive(Clone, Copy, Default)]
struct Sums {
    force: [f64; 8],
    /// `y F_x` and `x F_y`.
    moment: [f64; 8],
    power: [f64; 8],
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, load: &[f64; 8], [weight, arm, velocity]: [&[f64; 8]; 3]) {
        for i in 0..8 {
            let pushed = weight[i] * load[i];
            self.force[i] += pushed;
            self.moment[i] += arm[i] * pushed;
            self.power[i] += pushed * velocity[i];
        }
    }

    fn resultant(&self) -> Resultant {
        let of = |lanes: &[f64; 8], axis: usize| {
            (lanes[axis] + lanes[axis + 4]) + (lanes[axis + 2] + lanes[axis + 6])
        };
        Resultant {
            force: [of(&self.force, 0), of(&self.force, 1), 0.0],
            moment: [0.0, 0.0, of(&self.moment, 1) - of(&self.moment, 0)],
            power: of(&self.power, 0) + of(&self.power, 1),
        }
    }
}

/// Adds a piece of each load to its sums, all block by block: sums that do not wait for each other.
#[inline(always)]
fn add<const K: usize>(sums: &mut [Sums; K], loads: [&[f64]; K], beside: [&[f64]; 3]) {
    let length = beside[2].len();
    let blocks = |field| <[f64]>::as_chunks::<8>(field).0;
    // What is left is a block with weights of zero.
    let rest = |field: &[f64]| {
        let mut block = [0.0; 8];
        let rest = &field[length / 8 * 8..];
        block[..rest.len()].copy_from_slice(rest);
        block
    };
    let (load_blocks, beside_blocks) = (loads.map(blocks), beside.map(blocks));
    let mut own = *sums;
    for at in 0..length / 8 {
        for k in 0..K {
            own[k].add(&load_blocks[k][at], beside_blocks.map(|field| &field[at]));
        }
    }
    let (loads, beside) = (loads.map(rest), beside.map(rest));
    for k in 0..K {
        own[k].add(&loads[k], beside.each_ref());
    }
    *sums = own;
}

fn resultant_in_space(interface: &Interface, load: &[f64]) -> Resultant {
    let d = interface.components;
    let mut sum = Resultant::default();
    for (point, volume) in interface.volume.iter().enumerate() {
        let mut force = [0.0; 3];
        let mut position = [0.0; 3];
        for i in 0..d {
            let at = point * d + i;
            force[i] = -volume * load[at];
            position[i] = interface.position[at];
            sum.force[i] += force[i];
            sum.power += force[i] * interface.velocity[at];
        }
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            sum.moment[i] += position[j] * force[k] - position[k] * force[j];
        }
    }
    sum
}

fn residual(components: usize, volume: &[f64], reaction: &Reaction, load: &[f64]) -> f64 {
    let (mut mismatch, mut scale) = (0.0, 0.0);
    for (point, volume) in volume.iter().enumerate() {
        let at = point * components..(point + 1) * components;
        let normal = &reaction.normal[at.clone()];
        let given = dot(&reaction.pair_reaction[at.clone()], normal);
        let received = dot(&load[at], normal);
        mismatch += volume * (received - given).powi(2);
        scale += volume * given * given;
    }
    if mismatch == 0.0 { 0.0 } else { (mismatch / scale).sqrt() }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const VOLUME: [f64; 2] = [2.0, 0.5];
    const POSITION: [f64; 4] = [0.0, 1.0, 3.0, 0.0];
    const VELOCITY: [f64; 4] = [1.0, 0.0, 0.0, 2.0];
    const REACTION: [f64; 4] = [10.0, 0.0, 0.0, 4.0];
    const NORMAL: [f64; 4] = [-1.0, 0.0, 0.0, -1.0];

    fn interface<'a>() -> Interface<'a> {
        Interface {
            components: 2,
            volume: &VOLUME,
            position: &POSITION,
            velocity: &VELOCITY,
            reaction: Some(Reaction { pair_reaction: &REACTION, normal: &NORMAL }),
        }
    }

    fn enforced(load: &mut [f64]) -> Condition46 {
        let sent = load.to_vec();
        assert!(enforce(&interface(), load));
        measure(&interface(), &sent, Some(load), load).0
    }

    #[test]
    fn resultants_by_hand() {
        let [sum] = resultants(&interface(), [&REACTION]);
        assert_eq!(sum.force, [-20.0, -2.0, 0.0]);
        // r × f: (0, 1) × (−20, 0) = 20; (3, 0) × (0, −2) = −6.
        assert_eq!(sum.moment, [0.0, 0.0, 14.0]);
        assert_eq!(sum.power, -24.0);
    }

    #[test]
    fn enforcing_mends_the_normal_part_and_keeps_the_tangential_one() {
        let mut load = [13.0, 7.0, -1.0, 4.0];
        let found = enforced(&mut load);
        assert_eq!(load, [10.0, 7.0, -1.0, 4.0]);
        // √(2·3²) / √(2·10² + 0.5·4²)
        assert!((found.residual_before - (18.0f64 / 208.0).sqrt()).abs() < 1e-15);
        assert_eq!(found.residual_after, 0.0);
        assert_eq!(found.given.force, [-20.0, -2.0, 0.0]);
        assert_eq!(found.before.force, [-25.5, -16.0, 0.0]);
        assert_eq!(found.after.force, [-19.5, -16.0, 0.0]);
    }

    #[test]
    fn measuring_alone_changes_nothing_and_an_untouched_interface_has_no_residual() {
        let load = [13.0, 7.0, -1.0, 4.0];
        let (found, applied) = measure(&interface(), &load, None, &load);
        assert_eq!(applied, found.before);
        assert_eq!((found.residual_before, found.before), (found.residual_after, found.after));
        let dry = Reaction { pair_reaction: &[0.0; 4], normal: &NORMAL };
        let dry = Interface { reaction: Some(dry), ..interface() };
        assert_eq!(measure(&dry, &[0.0; 4], None, &[0.0; 4]).0.residual_before, 0.0);
        let taciturn = Interface { reaction: None, ..interface() };
        let (found, _) = measure(&taciturn, &load, None, &load);
        assert_eq!((found.residual_before, found.given), (0.0, found.before));
        assert!(!enforce(&taciturn, &mut [0.0; 4]));
    }

    /// Blocks of four points and what is left of them, against the plain sum: numbers of few bits, whose sums
    /// are exact in any order.
    #[test]
    fn points_by_four_are_as_points_one_by_one() {
        for points in [1, 4, 7, 12, 13] {
            let field = |seed: usize, length: usize| -> Vec<f64> {
                (0..length).map(|i| ((i * 7 + seed) % 11) as f64 - 5.0).collect()
            };
            let (volume, position, velocity) = (field(1, points), field(2, 2 * points), field(3, 2 * points));
            let interface = Interface {
                components: 2,
                volume: &volume,
                position: &position,
                velocity: &velocity,
                reaction: None,
            };
            let loads = [field(4, 2 * points), field(5, 2 * points)];
            let found = resultants_in_plane(&interface, [&loads[0], &loads[1]]);
            assert_eq!(found, [0, 1].map(|k| resultant_in_space(&interface, &loads[k])));
        }
    }
}
