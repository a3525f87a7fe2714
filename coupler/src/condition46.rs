//! Condition (46) of the paper: along the normals, what the structure receives is what the fluid gave.
//!
//! `∇p_{f→s} · n_f = −∇p_{s→f} · n_s`. The fluid sends, for each interface particle of reference volume `V`, the pressure gradient
//! `g` at the structure (the load; force `−V g`), what it received itself from that particle, the pair reaction `R` (force on the
//! fluid `+V R`), and the normal `n`. Action and reaction along the normal ask `g · n = R · n`, particle by particle.
//!
//! A fluid whose load is the transpose of its divergence fulfils this by construction; one that evaluates Eq. (48) does not, because the
//! fluid particles were moved by another sum than the structure particle. [`enforce`] replaces the normal part of the load by what the fluid
//! gave: force and moment of the normal parts then agree for every particle, and so in total.

/// The fields of one solution that condition (46) speaks of, point by point, `components` doubles a vector.
#[derive(Clone, Copy, Debug)]
pub struct Interface<'a> {
    /// Components of a vector: the dimension.
    pub components: usize,
    /// Reference volumes `V` (m³).
    pub volume: &'a [f64],
    /// Positions (m).
    pub position: &'a [f64],
    /// Velocities (m/s).
    pub velocity: &'a [f64],
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
    /// `√(Σ V ((g − R)·n)²) / √(Σ V (R·n)²)` of the load as the fluid sent it; zero where the fluid touches nothing.
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

/// Measures the condition for the load `pressure_gradient`, and enforces it there if told to.
pub fn enforce(interface: &Interface, pressure_gradient: &mut [f64], enforced: bool) -> Condition46 {
    let given = resultant(interface, interface.pair_reaction);
    let before = resultant(interface, pressure_gradient);
    let residual_before = residual(interface, pressure_gradient);
    if enforced {
        let d = interface.components;
        for point in 0..interface.volume.len() {
            let at = point * d..(point + 1) * d;
            let normal = &interface.normal[at.clone()];
            let load = &mut pressure_gradient[at.clone()];
            let missing = dot(&interface.pair_reaction[at], normal) - dot(load, normal);
            for (g, n) in load.iter_mut().zip(normal) {
                *g += missing * n;
            }
        }
    }
    Condition46 {
        residual_before,
        residual_after: residual(interface, pressure_gradient),
        given,
        before,
        after: resultant(interface, pressure_gradient),
    }
}

/// Resultants of the load field `g` (Pa/m).
pub fn resultant(interface: &Interface, load: &[f64]) -> Resultant {
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

fn residual(interface: &Interface, load: &[f64]) -> f64 {
    let d = interface.components;
    let (mut mismatch, mut scale) = (0.0, 0.0);
    for (point, volume) in interface.volume.iter().enumerate() {
        let at = point * d..(point + 1) * d;
        let normal = &interface.normal[at.clone()];
        let given = dot(&interface.pair_reaction[at.clone()], normal);
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
            pair_reaction: &REACTION,
            normal: &NORMAL,
        }
    }

    #[test]
    fn resultants_by_hand() {
        let sum = resultant(&interface(), &REACTION);
        assert_eq!(sum.force, [-20.0, -2.0, 0.0]);
        // r × f: (0, 1) × (−20, 0) = 20; (3, 0) × (0, −2) = −6.
        assert_eq!(sum.moment, [0.0, 0.0, 14.0]);
        assert_eq!(sum.power, -24.0);
    }

    #[test]
    fn enforcing_mends_the_normal_part_and_keeps_the_tangential_one() {
        let mut load = [13.0, 7.0, -1.0, 4.0];
        let found = enforce(&interface(), &mut load, true);
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
        let mut load = [13.0, 7.0, -1.0, 4.0];
        let found = enforce(&interface(), &mut load, false);
        assert_eq!(load, [13.0, 7.0, -1.0, 4.0]);
        assert_eq!(found.residual_before, found.residual_after);
        let dry = Interface { pair_reaction: &[0.0; 4], ..interface() };
        assert_eq!(enforce(&dry, &mut [0.0; 4], true).residual_before, 0.0);
    }
}
