//! All points move together on a spring and a damper: the structure whose solution is known.

use super::points::{Points, components};
use crate::Model;
use interfaces::{Description, Fields, ParticipantError, Scalar, ScalarKind, SubSteps, TimeWindow};

/// How a window is integrated, the load held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integration {
    /// By the matrix exponential: exact for any window, however many sub-steps are asked for.
    Exact,
    /// By the classical Runge–Kutta method of fourth order in the sub-steps asked for.
    Rk4,
}

/// `m ü + c u̇ + k u = F` in every component, with `m = Σ ρ V` and `F = −Σ V ∇p`.
///
/// Its dry period is `2π √(m/k)` (undamped). State: displacement (m, `D`), velocity (m/s, `D`), work of the load since the start (J).
#[derive(Clone, Debug)]
pub struct SpringMass {
    /// The points.
    pub points: Points,
    /// Spring `k` (N/m).
    pub stiffness: f64,
    /// Damper `c` (N s/m).
    pub damping: f64,
    /// Displacement at the start (m).
    pub displacement: Vec<f64>,
    /// Velocity at the start (m/s).
    pub velocity: Vec<f64>,
    /// How it is solved.
    pub integration: Integration,
}

impl SpringMass {
    /// A mass at rest, undamped, solved exactly.
    pub fn new(points: Points, stiffness: f64) -> Self {
        let zero = vec![0.0; points.dimension];
        Self {
            points,
            stiffness,
            damping: 0.0,
            displacement: zero.clone(),
            velocity: zero,
            integration: Integration::Exact,
        }
    }

    fn sub_steps(&self, window: &TimeWindow) -> u32 {
        match (window.sub_steps, self.integration) {
            (SubSteps::Fixed(count), _) => count.max(1),
            (SubSteps::Stable, Integration::Exact) => 1,
            (SubSteps::Stable, Integration::Rk4) => {
                // |λ| ≤ max(√(k/m), c/m); the stable region of the method holds the left half of the disc of radius 2.5, so 1 has a margin.
                let mass = self.points.mass();
                let fastest = (self.stiffness / mass).sqrt().max(self.damping / mass);
                (window.size * fastest).ceil().max(1.0) as u32
            }
        }
    }

    fn step(&self, u: f64, v: f64, force: f64, window: &TimeWindow) -> (f64, f64) {
        let mass = self.points.mass();
        let [k, c, f] = [self.stiffness / mass, self.damping / mass, force / mass];
        if self.integration == Integration::Exact {
            return exact(u, v, [k, c, f], window.size);
        }
        let count = self.sub_steps(window);
        let dt = window.size / f64::from(count);
        (0..count).fold((u, v), |(u, v), _| rk4(u, v, [k, c, f], dt))
    }
}

/// Displacement and velocity after `dt` (s) of `ü = f − c u̇ − k u` (coefficients divided by the mass, in the order `k, c, f`): the exponential of
/// the system for `(u, dt u̇, 1)` by its series, scaled and squared.
pub fn exact(u: f64, v: f64, [k, c, f]: [f64; 3], dt: f64) -> (f64, f64) {
    let a = [[0.0, 1.0, 0.0], [-k * dt * dt, -c * dt, f * dt * dt], [0.0; 3]];
    // The load's column is in metres: it scales with the answer and does not count for the convergence of the series.
    let norm = a[1][0].abs() + a[1][1].abs() + 1.0;
    let squarings = norm.log2().ceil() as i32 + 1;
    let scale = 0.5_f64.powi(squarings);
    let mut exponential = IDENTITY;
    let mut term = IDENTITY;
    // Norm ≤ ½: the term of order 17 is below 2⁻¹⁷/17! ≈ 2e-20.
    for order in 1..=17 {
        term = product(&term, &a);
        for (sum, value) in exponential.iter_mut().flatten().zip(term.iter_mut().flatten()) {
            *value *= scale / f64::from(order);
            *sum += *value;
        }
    }
    for _ in 0..squarings {
        exponential = product(&exponential, &exponential);
    }
    let y = [u, dt * v, 1.0];
    let row = |i: usize| (0..3).map(|j| exponential[i][j] * y[j]).sum::<f64>();
    (row(0), row(1) / dt)
}

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut c = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = (0..3).map(|l| a[i][l] * b[l][j]).sum();
        }
    }
    c
}

fn rk4(u: f64, v: f64, [k, c, f]: [f64; 3], dt: f64) -> (f64, f64) {
    let rate = |u: f64, v: f64| (v, f - c * v - k * u);
    let (u1, v1) = rate(u, v);
    let (u2, v2) = rate(u + 0.5 * dt * u1, v + 0.5 * dt * v1);
    let (u3, v3) = rate(u + 0.5 * dt * u2, v + 0.5 * dt * v2);
    let (u4, v4) = rate(u + dt * u3, v + dt * v3);
    (u + dt / 6.0 * (u1 + 2.0 * u2 + 2.0 * u3 + u4), v + dt / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4))
}

impl Model for SpringMass {
    fn description(&self) -> Description {
        let energy =
            |name: &str| Scalar { name: name.to_owned(), unit: "J".to_owned(), kind: ScalarKind::Balance };
        let mut scalars = components("displacement", "m", ScalarKind::Probe, self.points.dimension);
        scalars.extend(["kinetic_energy", "elastic_energy", "load_work"].map(energy));
        self.points.description("mock structure (spring and mass)", true, scalars)
    }

    fn initial(&mut self, _start: f64, _inputs: &Fields) -> Result<Vec<f64>, ParticipantError> {
        Ok([&self.displacement[..], &self.velocity, &[0.0]].concat())
    }

    fn constants(&self, outputs: &mut Fields) {
        self.points.constants(outputs);
    }

    fn advance(
        &self,
        accepted: &[f64],
        window: &TimeWindow,
        inputs: &Fields,
    ) -> Result<(Vec<f64>, u32), ParticipantError> {
        let d = self.points.dimension;
        let mut state = accepted.to_vec();
        for (axis, force) in self.points.force(inputs).into_iter().enumerate() {
            let (u, v) = self.step(accepted[axis], accepted[d + axis], force, window);
            (state[axis], state[d + axis]) = (u, v);
            state[2 * d] += force * (u - accepted[axis]);
        }
        Ok((state, self.sub_steps(window)))
    }

    fn outputs(&self, state: &[f64], outputs: &mut Fields) {
        let d = self.points.dimension;
        self.points.translated(&state[..d], &state[d..2 * d], outputs);
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        let d = self.points.dimension;
        let square = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>();
        let kinetic = 0.5 * self.points.mass() * square(&state[d..2 * d]);
        let elastic = 0.5 * self.stiffness * square(&state[..d]);
        [&state[..d], &[kinetic, elastic, state[2 * d]]].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under-damped solution with a held load, by its closed form.
    fn closed(u: f64, v: f64, [k, c, f]: [f64; 3], t: f64) -> (f64, f64) {
        let (rest, gamma) = (f / k, 0.5 * c);
        let omega = (k - gamma * gamma).sqrt();
        let (a, b) = (u - rest, (v + gamma * (u - rest)) / omega);
        let (sin, cos) = (omega * t).sin_cos();
        let decay = (-gamma * t).exp();
        let position = rest + decay * (a * cos + b * sin);
        let velocity = decay * (omega * (b * cos - a * sin) - gamma * (a * cos + b * sin));
        (position, velocity)
    }

    #[test]
    fn the_exponential_is_the_closed_form() {
        for (coefficients, t) in
            [([40.0, 0.0, 3.0], 0.01), ([40.0, 0.7, -2.0], 1.3), ([1e4, 5.0, 100.0], 0.4)]
        {
            let ((u, v), (eu, ev)) = (exact(0.3, -0.2, coefficients, t), closed(0.3, -0.2, coefficients, t));
            // Each of up to 13 squarings may double the round-off of 1e-16 relative to amplitude and amplitude·ω.
            let omega = coefficients[0].sqrt();
            assert!((u - eu).abs() < 1e-12 && (v - ev).abs() < 1e-12 * omega, "{u} {eu} {v} {ev}");
        }
        // No spring, no damper: u = u₀ + v t + f t²/2.
        let (u, v) = exact(0.0, 1.0, [0.0, 0.0, 2.0], 0.5);
        assert!((u - 0.75).abs() < 1e-15 && (v - 2.0).abs() < 1e-15);
        // Critically damped, k = 4, c = 4: u = (u₀ + (v₀ + 2u₀) t) e^{−2t}.
        let (u, _) = exact(0.5, 0.0, [4.0, 4.0, 0.0], 0.5);
        assert!((u - (-1.0_f64).exp()).abs() < 1e-15);
    }

    #[test]
    fn runge_kutta_is_of_fourth_order() {
        let coefficients = [40.0, 0.7, -2.0];
        let (exact_u, exact_v) = exact(0.3, -0.2, coefficients, 1.0);
        let error = |n: u32| {
            let dt = 1.0 / f64::from(n);
            let (u, v) = (0..n).fold((0.3, -0.2), |(u, v), _| rk4(u, v, coefficients, dt));
            // In the phase plane: a component alone may pass through zero.
            (u - exact_u).hypot((v - exact_v) / coefficients[0].sqrt())
        };
        // Halving the step divides the error by 2⁴ up to the next order's share, which is about ω Δt = 0.1.
        let ratio = error(64) / error(128);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }
}
