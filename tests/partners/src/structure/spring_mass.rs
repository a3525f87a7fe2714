//! All points move together on a spring and a damper: the structure whose solution is known.

use super::points::{Points, components};
use crate::Model;
use interfaces::port::names;
use interfaces::{Description, Fields, Result, Scalar, ScalarKind, SubSteps, TimeWindow};

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
/// Its dry period is `2π √(m/k)` (undamped). State: displacement (m, `D`), velocity (m/s, `D`), work of the
/// load since the start (J).
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
    /// Whether the load goes linearly over a window, from what the coupler says of its start; else it is
    /// held.
    pub linear: bool,
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
            linear: false,
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

    /// From `u`, `v` under a force that goes from `forces[0]` to `forces[1]` (N).
    fn step(&self, u: f64, v: f64, forces: [f64; 2], window: &TimeWindow) -> (f64, f64) {
        let mass = self.points.mass();
        let [k, c] = [self.stiffness / mass, self.damping / mass];
        let [start, end] = forces.map(|force| force / mass);
        if self.integration == Integration::Exact {
            return exact(u, v, [k, c], [start, end], window.size);
        }
        let count = self.sub_steps(window);
        let dt = window.size / f64::from(count);
        let at = |step: u32| start + (end - start) * f64::from(step) / f64::from(count);
        (0..count).fold((u, v), |(u, v), step| rk4(u, v, [k, c], [at(step), at(step + 1)], dt))
    }
}

/// Displacement and velocity after `dt` (s) of `ü = f − c u̇ − k u` (coefficients divided by the mass, in the
/// order `k, c`), with `f` going linearly from `forces[0]` to `forces[1]`: the exponential of the system for
/// `(u, dt u̇, 1, t/dt)` by its series, scaled and squared.
pub fn exact(u: f64, v: f64, [k, c]: [f64; 2], [start, end]: [f64; 2], dt: f64) -> (f64, f64) {
    let rate = [-k * dt * dt, -c * dt, start * dt * dt, (end - start) * dt * dt];
    let a = [[0.0, 1.0, 0.0, 0.0], rate, [0.0; 4], [0.0, 0.0, 1.0, 0.0]];
    // The load's columns are in metres: they scale with the answer and do not count for the convergence of
    // the series.
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
    let y = [u, dt * v, 1.0, 0.0];
    let row = |i: usize| (0..4).map(|j| exponential[i][j] * y[j]).sum::<f64>();
    (row(0), row(1) / dt)
}

const IDENTITY: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn product(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let mut c = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            c[i][j] = (0..4).map(|l| a[i][l] * b[l][j]).sum();
        }
    }
    c
}

fn rk4(u: f64, v: f64, [k, c]: [f64; 2], [start, end]: [f64; 2], dt: f64) -> (f64, f64) {
    let rate = |u: f64, v: f64, f: f64| (v, f - c * v - k * u);
    let middle = 0.5 * (start + end);
    let (u1, v1) = rate(u, v, start);
    let (u2, v2) = rate(u + 0.5 * dt * u1, v + 0.5 * dt * v1, middle);
    let (u3, v3) = rate(u + 0.5 * dt * u2, v + 0.5 * dt * v2, middle);
    let (u4, v4) = rate(u + dt * u3, v + dt * v3, end);
    (u + dt / 6.0 * (u1 + 2.0 * u2 + 2.0 * u3 + u4), v + dt / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4))
}

impl Model for SpringMass {
    fn description(&self) -> Description {
        let energy = |name: &str| Scalar::new(name, "J", ScalarKind::Balance);
        let mut scalars = components("displacement", "m", ScalarKind::Probe, self.points.dimension);
        scalars.extend(["kinetic_energy", "elastic_energy", "load_work"].map(energy));
        let mut description = self.points.description("mock structure (spring and mass)", true, scalars);
        if self.linear {
            description.ports.push(self.points.start_load());
        }
        description
    }

    fn initial(&mut self, _start: f64, _inputs: &Fields) -> Result<Vec<f64>> {
        Ok([&self.displacement[..], &self.velocity, &[0.0]].concat())
    }

    fn constants(&self, outputs: &mut Fields) {
        self.points.constants(outputs);
    }

    fn advance(&self, accepted: &[f64], window: &TimeWindow, inputs: &Fields) -> Result<(Vec<f64>, u32)> {
        let d = self.points.dimension;
        let mut state = accepted.to_vec();
        let end = self.points.force(inputs, names::PRESSURE_GRADIENT);
        let start =
            if self.linear { self.points.force(inputs, names::START_PRESSURE_GRADIENT) } else { end.clone() };
        for (axis, forces) in start.into_iter().zip(end).enumerate() {
            let forces = [forces.0, forces.1];
            let (u, v) = self.step(accepted[axis], accepted[d + axis], forces, window);
            (state[axis], state[d + axis]) = (u, v);
            state[2 * d] += 0.5 * (forces[0] + forces[1]) * (u - accepted[axis]);
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
            let [k, c, f] = coefficients;
            let ((u, v), (eu, ev)) =
                (exact(0.3, -0.2, [k, c], [f; 2], t), closed(0.3, -0.2, coefficients, t));
            // Each of up to 13 squarings may double the round-off of 1e-16 relative to amplitude and
            // amplitude·ω.
            let omega = coefficients[0].sqrt();
            assert!((u - eu).abs() < 1e-12 && (v - ev).abs() < 1e-12 * omega, "{u} {eu} {v} {ev}");
        }
        // No spring, no damper: u = u₀ + v t + f t²/2.
        let (u, v) = exact(0.0, 1.0, [0.0, 0.0], [2.0; 2], 0.5);
        assert!((u - 0.75).abs() < 1e-15 && (v - 2.0).abs() < 1e-15);
        // Critically damped, k = 4, c = 4: u = (u₀ + (v₀ + 2u₀) t) e^{−2t}.
        let (u, _) = exact(0.5, 0.0, [4.0, 4.0], [0.0; 2], 0.5);
        assert!((u - (-1.0_f64).exp()).abs() < 1e-15);
        // No spring, a force that rises from 0 to 6 in a second: u = t³, v = 3 t².
        let (u, v) = exact(0.0, 0.0, [0.0, 0.0], [0.0, 6.0], 1.0);
        assert!((u - 1.0).abs() < 1e-15 && (v - 3.0).abs() < 1e-15, "{u} {v}");
    }

    #[test]
    fn runge_kutta_is_of_fourth_order() {
        let (coefficients, forces) = ([40.0, 0.7], |t: f64| -2.0 + 5.0 * t);
        let (exact_u, exact_v) = exact(0.3, -0.2, coefficients, [forces(0.0), forces(1.0)], 1.0);
        let error = |n: u32| {
            let dt = 1.0 / f64::from(n);
            let at = |step: u32| forces(f64::from(step) * dt);
            let (u, v) = (0..n)
                .fold((0.3, -0.2), |(u, v), step| rk4(u, v, coefficients, [at(step), at(step + 1)], dt));
            // In the phase plane: a component alone may pass through zero.
            (u - exact_u).hypot((v - exact_v) / coefficients[0].sqrt())
        };
        // Halving the step divides the error by 2⁴ up to the next order's share, which is about ω Δt = 0.1.
        let ratio = error(64) / error(128);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }
}
