//! The added-mass instability on partners whose amplification is known, through a coupling loop that is only
//! as long as it must be.

use interfaces::port::names;
use interfaces::{Description, Direction, Exchange, Fields, Guarded, Participant, SubSteps, TimeWindow};
use partners::build;
use std::f64::consts::PI;

/// Mass of the structure (kg): ten points of 0.1 m × 0.1 m × 1 m at 100 kg/m³.
const MASS: f64 = 10.0;
const STIFFNESS: f64 = 4e3;
const STRUCTURE: &str = "spring-mass points=10 spacing=0.1 density=100 stiffness=4e3";

/// Two participants and the load the structure is under.
struct Pair {
    structure: Guarded<Box<dyn Participant>>,
    fluid: Guarded<Box<dyn Participant>>,
    load: Fields,
    motion: Fields,
    answer: Fields,
    relaxation: f64,
    size: f64,
    window: u64,
}

impl Pair {
    fn new(structure: &str, fluid: &str, relaxation: f64, size: f64) -> Self {
        let mut structure = Guarded::new(build(structure).expect("a structure"));
        let mut fluid = Guarded::new(build(fluid).expect("a fluid"));
        let (load, mut motion) = both(structure.describe(), 0);
        let points = motion.get(names::DENSITY).expect("given").len();
        let (mut taken, mut answer) = both(fluid.describe(), points);
        structure.initialize(0.0, &load, &mut motion).expect("a structure that starts");
        taken.copy_from(&motion, |_| true).expect("lengths that agree");
        fluid.initialize(0.0, &taken, &mut answer).expect("a fluid that starts");
        let mut pair = Self { structure, fluid, load, motion: taken, answer, relaxation, size, window: 0 };
        pair.load.copy_from(&pair.answer, |_| true).expect("lengths that agree");
        pair
    }

    /// One window, `solutions` times: the structure under the held load, the fluid under the structure's
    /// motion, the load relaxed. With `correct` the structure runs once more under the new load. Gives the
    /// force on the structure (N) and its height over rest (m).
    fn advance(&mut self, solutions: u32, correct: bool) -> (f64, f64) {
        for iteration in 0..solutions {
            self.structure(iteration);
            let window = self.window_at(iteration);
            self.fluid.start(&window, &self.motion).expect("a fluid that solves");
            self.fluid.finish(&mut self.answer).expect("a fluid that solves");
            let new = self.answer.get(names::PRESSURE_GRADIENT).expect("given");
            let held = self.load.get_mut(names::PRESSURE_GRADIENT).expect("taken");
            for (held, new) in held.iter_mut().zip(new) {
                *held = self.relaxation * new + (1.0 - self.relaxation) * *held;
            }
        }
        if correct {
            self.structure(solutions);
        }
        self.structure.accept(None).expect("a solved window");
        self.fluid.accept(None).expect("a solved window");
        self.window += 1;
        let force = -self.load.get(names::PRESSURE_GRADIENT).expect("taken")[1] * 0.1;
        (force, self.motion.get(names::POSITION).expect("taken")[1])
    }

    fn structure(&mut self, iteration: u32) {
        let window = self.window_at(iteration);
        let (_, mut moved) = both(self.structure.describe(), 0);
        self.structure.start(&window, &self.load).expect("a structure that solves");
        self.structure.finish(&mut moved).expect("a structure that solves");
        self.motion
            .copy_from(&moved, |port| port.exchange == Exchange::EveryWindow)
            .expect("lengths that agree");
        if let Some(held) = self.motion.get_mut(names::HELD_PRESSURE_GRADIENT) {
            held.copy_from_slice(self.load.get(names::PRESSURE_GRADIENT).expect("taken"));
        }
    }

    fn window_at(&self, iteration: u32) -> TimeWindow {
        TimeWindow {
            index: self.window,
            iteration,
            start: self.window as f64 * self.size,
            size: self.size,
            sub_steps: SubSteps::Stable,
        }
    }
}

fn both(description: &Description, points: usize) -> (Fields, Fields) {
    (description.fields(Direction::In, points), description.fields(Direction::Out, points))
}

#[test]
fn explicit_coupling_to_a_moving_wall_grows_by_minus_the_mass_ratio() {
    for mass_ratio in [0.5, 0.9, 1.1, 3.0] {
        let fluid = format!("added-mass-column mass={}", mass_ratio * MASS);
        // So small a window that the spring does nothing: (ω Δt)² = 4e-8.
        let mut pair = Pair::new(&format!("{STRUCTURE} displacement=0,0.01"), &fluid, 1.0, 1e-5);
        let forces: Vec<f64> = (0..20).map(|_| pair.advance(1, false).0).collect();
        // Force = amplitude · (−μ)ⁿ + a smooth part, whose differences are 8 (ω Δt)² = 3e-7 of the amplitude
        // after 8 windows; those of the other part are 1.5 · 0.5⁸ = 6e-3 of it at least: 5e-5 of the factor.
        let differences: Vec<f64> = forces.windows(2).map(|f| f[1] - f[0]).collect();
        let factor = differences[8] / differences[7];
        assert!((factor + mass_ratio).abs() < 2e-4, "{mass_ratio}: {factor}");
        assert_eq!(forces[19].abs() > forces[0].abs(), mass_ratio > 1.0, "{mass_ratio}: {forces:?}");
    }
}

#[test]
fn iterations_of_a_moving_wall_contract_by_the_relaxation_alone() {
    // Factor 1 − r (1 + μ): μ = 9 diverges at r = 0.3 (−2), halves at r = 0.05 (½), and is exact at r = 0.1.
    for (relaxation, factor) in [(0.3, -2.0), (0.05, 0.5), (0.15, -0.5)] {
        let fluid = format!("added-mass-column mass={}", 9.0 * MASS);
        let force = |solutions| {
            let mut pair = Pair::new(&format!("{STRUCTURE} displacement=0,0.01"), &fluid, relaxation, 1e-4);
            pair.advance(solutions, false).0
        };
        let (first, second, third) = (force(4), force(5), force(6));
        let found = (third - second) / (second - first);
        // The spring changes the factor by (ω Δt)² = 4e-6 of itself; differences of forces of 40 N lose four
        // of sixteen digits.
        assert!((found - factor).abs() < 1e-4, "{relaxation}: {found}");
    }
    // Exact at once: two solutions, and the force stays the common one, −k u m_a/(m_s + m_a) = 36 N at u = 1
    // cm (up to (ω Δt)²).
    let fluid = format!("added-mass-column mass={}", 9.0 * MASS);
    let mut pair = Pair::new(&format!("{STRUCTURE} displacement=0,0.01"), &fluid, 0.1, 1e-4);
    let (force, _) = pair.advance(2, false);
    assert!((force - 36.0).abs() < 36.0 * 1e-4, "{force}");
}

#[test]
fn a_compliant_column_is_stable_for_any_mass_and_relaxation() {
    for mass_ratio in [0.5, 9.0, 100.0] {
        for relaxation in [0.3, 0.5, 1.0] {
            let fluid = format!("added-mass-column wall=compliant velocity=end mass={}", mass_ratio * MASS);
            let wet = 2.0 * PI * (MASS * (1.0 + mass_ratio) / STIFFNESS).sqrt();
            let mut pair =
                Pair::new(&format!("{STRUCTURE} displacement=0,0.01"), &fluid, relaxation, wet / 200.0);
            let heights: Vec<f64> = (0..2000).map(|_| pair.advance(1, true).1).collect();
            let largest = heights.iter().fold(0.0_f64, |m, h| m.max(h.abs()));
            // It starts at its amplitude of 1 cm and the scheme only damps; the first windows, whose load
            // starts from zero, add a few windows' fall: their displacement is of the order (2π/200)² = 1e-3
            // of the amplitude each, times μ.
            let slack = (1.0 + mass_ratio) * (2.0 * PI / 200.0_f64).powi(2) / relaxation;
            assert!(largest < 0.01 * (1.0 + slack), "{mass_ratio} {relaxation}: {largest}");
        }
    }
}

/// Period and logarithmic decrement of the column, from the zeros and extremes of `heights`, `size` (s)
/// apart.
fn oscillation(heights: &[f64], size: f64) -> (f64, f64) {
    let mut zeros = Vec::new();
    for i in 1..heights.len() {
        if heights[i - 1] > 0.0 && heights[i] <= 0.0 {
            zeros.push(size * (i as f64 - heights[i] / (heights[i] - heights[i - 1])));
        }
    }
    let periods = zeros.len() - 1;
    let peak = |from: f64, to: f64| {
        let range = (from / size) as usize..(to / size) as usize;
        heights[range].iter().fold(0.0_f64, |m, h| m.max(*h))
    };
    let period = (zeros[periods] - zeros[0]) / periods as f64;
    let last = zeros[periods - 1];
    (period, (peak(zeros[0], zeros[1]) / peak(last, last + period)).ln() / (periods - 1) as f64)
}

#[test]
fn the_wet_period_errs_by_the_second_order_and_the_damping_by_the_first() {
    for (mass_ratio, relaxation, windows) in
        [(2.0, 0.5, 200.0), (2.0, 0.5, 400.0), (9.0, 0.4, 400.0), (9.0, 1.0, 400.0)]
    {
        let (mu, r): (f64, f64) = (mass_ratio, relaxation);
        let omega = (STIFFNESS / (MASS * (1.0 + mu))).sqrt();
        let (wet, lag) = (2.0 * PI / omega, (1.0 - r) / r);
        let size = wet / windows;
        let fluid = format!("added-mass-column wall=compliant velocity=end mass={}", mu * MASS);
        let mut pair = Pair::new(&format!("{STRUCTURE} displacement=0,0.01"), &fluid, r, size);
        let heights: Vec<f64> = (0..(6.0 * windows) as usize).map(|_| pair.advance(1, true).1).collect();
        let (period, decrement) = oscillation(&heights, size);
        let second =
            (12.0 - 13.0 * r) * r * mu * mu + (3.0 - 5.0 * r * r) * mu - 7.0 * r * r + 18.0 * r - 12.0;
        let expected = mu * second / (24.0 * (r * (1.0 + mu)).powi(2)) * (omega * size).powi(2);
        let error = period / wet - 1.0;
        println!(
            "μ {mu}, r {r}, {windows} windows a period: error {error:.4e}, expected {expected:.4e}, decrement {decrement:.4e}"
        );
        // The next even order's share is a few times μ (ω Δt)², at most 9 · 2.5e-4 here.
        assert!((error - expected).abs() < 0.02 * expected.abs(), "{mu} {r} {windows}: {error} {expected}");
        // The recipe's estimate, (ω Δt)² μ (1 − r)/r, bounds it where there is a lag.
        assert!(r == 1.0 || error.abs() < (omega * size).powi(2) * mu * lag);
        // Rate ½ ω² Δt β (1 − r)/r over a period 2π/ω.
        let damping = PI * omega * size * mu / (1.0 + mu) * lag;
        // Peaks stand on windows: (ω Δt)²/8 of a peak at most is missed, over four periods.
        let missed = (omega * size).powi(2) / 8.0;
        assert!(
            (decrement - damping).abs() < 0.02 * damping + missed,
            "{mu} {r} {windows}: {decrement} {damping}"
        );
    }
}

#[test]
fn a_column_at_rest_weighs_on_the_spring() {
    let fluid = "added-mass-column wall=compliant velocity=end mass=20 gravity=9.81";
    let mut pair = Pair::new(&format!("{STRUCTURE} damping=600"), fluid, 0.5, 1e-3);
    let (force, height) = (0..3000).map(|_| pair.advance(1, true)).last().expect("windows");
    // 20 kg · 9.81 m/s² = 196.2 N, 4.905 cm at 4 kN/m; the damping leaves e^{−30} after 3 s.
    assert!((force + 196.2).abs() < 1e-6 && (height + 196.2 / STIFFNESS).abs() < 1e-9, "{force} {height}");
}
