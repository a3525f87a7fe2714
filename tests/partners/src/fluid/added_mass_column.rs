//! A rigid column of fluid that rides on the structure: all of the added-mass instability, and nothing else.

use super::load::Load;
use crate::Model;
use crate::stand_in::write;
use interfaces::port::names;
use interfaces::{Description, Fields, ParticipantError, Result, Scalar, ScalarKind, TimeWindow};

/// What the column takes the structure for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallModel {
    /// A moving wall: the column follows the velocity given, `v' = v_s`.
    Moving,
    /// A body of its own mass, whose velocity follows the load with the compliance `c`, which depends on what
    /// the velocity given is (see [`GivenVelocity`]): column and structure find their common velocity,
    /// `v' = (m_s u* + c m_a v)/(m_s + c m_a)`, where `u* = v_s + c Δt Σ V ∇p_held·e/m_s` is the structure's
    /// predicted velocity without the load it was predicted under.
    Compliant,
}

/// Which velocity of the structure the coupler gives (`coupling.structure_velocity`), and so how it follows a
/// load held over the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GivenVelocity {
    /// That at the window's end, `Δt F/m_s` by a load `F`: `c = 1`.
    End,
    /// The mean over the window, displacement over `Δt`: half of it, `c = ½`.
    Mean,
}

impl GivenVelocity {
    fn compliance(self) -> f64 {
        match self {
            Self::End => 1.0,
            Self::Mean => 0.5,
        }
    }
}

/// A column of mass `m_a` on the structure's points along an axis `e`: its force on the structure is
/// `F = −m_a ((v' − v)/Δt + g) e`, from the accepted velocity `v` to `v'` at the window's end, spread evenly
/// over the structure's volume, `∇p = −F/Σ V`.
///
/// On a structure of mass `m_s` and stiffness `k`, with `μ = m_a/m_s`, the wet period is
/// `T = 2π √((m_s + m_a)/k)`. The load error of a window that is short against the period grows each window,
/// or each iteration of a window, by a factor:
///
/// - moving wall, load relaxed by `r`: `1 − r (1 + μ)`. Explicit (`r = 1`) it is `−μ`, whatever the window's
///   size: it diverges for `m_a > m_s`. It is stable for `r < 2/(1 + μ)`, and `r = 1/(1 + μ)` is exact, as
///   are Aitken's from the second iteration on.
/// - compliant, end velocity, load relaxed by `r`: the roots of `z² − (1 − r)(1 + β) z + (1 − r) β` with
///   `β = μ/(1 + μ)`, inside the unit circle for every `0 < r ≤ 1` and every `μ`, and zero for `r = 1`. What
///   is left is an error of accuracy. With the wet `ω = 2π/T` and the load held over a structure that is
///   solved exactly, the expansion of the eigenvalue in `ωΔt` gives a damping of the first order, at the rate
///   `½ ω² Δt β (1 − r)/r`, and a period of `T (1 + e (ωΔt)²)`,
///   `e = μ [(12 − 13r) r μ² + (3 − 5r²) μ − 7r² + 18r − 12] / (24 r² (1 + μ)²)`: about
///   `½ μ (1 − r)/r − μ/24` for a heavy column, and `−μ/24` for `r = 1`.
/// - compliant, mean velocity: the roots of `z² − (1 − r + (1 − 2r) b) z + (1 − r) b` with `b = μ/(2 + μ)`,
///   inside the unit circle as well; for `r = 1` they are `0` and `−b`.
///
/// Windows that are long against the *dry* period of the structure, `ω_s = √(k/m_s)`: with the end velocity
/// the coupling grows where `sin ω_s Δt < 0`, for then the structure's end velocity answers a load with the
/// wrong sign; with the mean velocity its answer `(1 − cos ω_s Δt)/(ω_s Δt)²` is never negative and never
/// over the ½ presumed, and nothing grows.
///
/// State: velocity of the column along the axis (m/s), force on the structure along it (N).
#[derive(Clone, Debug)]
pub struct AddedMassColumn {
    /// How it is given.
    pub load: Load,
    /// Mass `m_a` (kg).
    pub mass: f64,
    /// Unit vector `e` out of the structure into the column.
    pub axis: Vec<f64>,
    /// Gravity against the axis `g` (m/s²).
    pub gravity: f64,
    /// Area over which the force is a pressure (m²).
    pub area: f64,
    /// What it takes the structure for.
    pub wall: WallModel,
    /// What the velocity given is, for a compliant wall.
    pub velocity: GivenVelocity,
    /// Density of the partner's points (kg/m³), taken at initialisation.
    pub densities: Vec<f64>,
}

impl AddedMassColumn {
    /// A column without weight on an area of one square metre, along axis number `axis`, that is given mean
    /// velocities.
    pub fn new(dimension: usize, mass: f64, axis: usize, wall: WallModel) -> Self {
        let mut e = vec![0.0; dimension];
        e[axis] = 1.0;
        Self {
            load: Load::new(dimension),
            mass,
            axis: e,
            gravity: 0.0,
            area: 1.0,
            wall,
            velocity: GivenVelocity::Mean,
            densities: Vec::new(),
        }
    }

    fn along(&self, vector: &[f64]) -> f64 {
        vector.iter().zip(&self.axis).map(|(x, e)| x * e).sum()
    }

    /// Velocity of the structure's centre of mass along the axis (m/s), its mass (kg), and `Σ V ∇p_held·e`
    /// (N).
    fn structure(&self, inputs: &Fields) -> (f64, f64, f64) {
        let d = self.load.dimension;
        let velocity = inputs.get(names::VELOCITY).unwrap_or(&[]);
        let held = inputs.get(names::HELD_PRESSURE_GRADIENT).unwrap_or(&[]);
        let (mut momentum, mut mass, mut load) = (0.0, 0.0, 0.0);
        for (point, (volume, density)) in self.load.volumes.iter().zip(&self.densities).enumerate() {
            let at = point * d..(point + 1) * d;
            momentum += volume * density * self.along(&velocity[at.clone()]);
            mass += volume * density;
            load += volume * self.along(&held[at]);
        }
        (momentum / mass, mass, load)
    }
}

impl Model for AddedMassColumn {
    fn description(&self) -> Description {
        let scalar = |name: &str, unit: &str| Scalar::new(name, unit, ScalarKind::Balance);
        let (solver, held): (_, &[&str]) = match self.wall {
            WallModel::Moving => ("mock fluid (added-mass column, moving wall)", &[]),
            WallModel::Compliant => {
                ("mock fluid (added-mass column, compliant wall)", &[names::HELD_PRESSURE_GRADIENT])
            }
        };
        let required = [&[names::VELOCITY, names::REFERENCE_VOLUME, names::DENSITY], held].concat();
        let scalars = vec![scalar("velocity", "m/s"), scalar("force", "N"), scalar("kinetic_energy", "J")];
        self.load.description(solver, &required, scalars)
    }

    fn initial(&mut self, _start: f64, inputs: &Fields) -> Result<Vec<f64>> {
        self.load.take_volumes(inputs);
        self.densities = inputs.get(names::DENSITY).unwrap_or(&[]).to_vec();
        let (velocity, mass, _) = self.structure(inputs);
        if !(mass > 0.0 && velocity.is_finite()) {
            let what = format!(
                "the structure's mass is {mass} kg: reference volumes and densities must be positive"
            );
            return Err(ParticipantError::Failed(what));
        }
        Ok(vec![velocity, -self.mass * self.gravity])
    }

    fn constants(&self, _outputs: &mut Fields) {}

    fn advance(&self, accepted: &[f64], window: &TimeWindow, inputs: &Fields) -> Result<(Vec<f64>, u32)> {
        let (predicted, mass, held) = self.structure(inputs);
        let velocity = match self.wall {
            WallModel::Moving => predicted,
            WallModel::Compliant => {
                let compliance = self.velocity.compliance();
                let unloaded = predicted + compliance * window.size * held / mass;
                let falling = accepted[0] - window.size * self.gravity;
                let carried = compliance * self.mass;
                (mass * unloaded + carried * falling) / (mass + carried)
            }
        };
        let force = -self.mass * ((velocity - accepted[0]) / window.size + self.gravity);
        Ok((vec![velocity, force], 1))
    }

    fn outputs(&self, state: &[f64], outputs: &mut Fields) {
        let n = self.load.volumes.len();
        let strength = -state[1] / self.load.volumes.iter().sum::<f64>();
        let gradient: Vec<f64> = self.axis.iter().map(|e| strength * e).collect();
        self.load.write(&gradient.repeat(n), &vec![-state[1] / self.area; n], outputs);
        // A column that pulls for a while is still on the same side.
        write(outputs, names::NORMAL, &self.axis.repeat(n));
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        vec![state[0], state[1], 0.5 * self.mass * state[0] * state[0]]
    }
}
