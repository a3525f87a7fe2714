//! A participant that does nothing, to measure what the exchange alone takes. It does not pass the
//! conformance suite: what it gives it either leaves as it is, or takes from the number of the iteration.

use interfaces::fields::Linear;
use interfaces::port::names;
use interfaces::{Description, Direction, Fields, Participant, Port, Quantity, Readiness, Result};
use interfaces::{Role, TimeWindow, WindowReport};

/// A fluid that gives a load, or a structure that gives position and velocity, of which it works out nothing.
pub struct Idle {
    description: Description,
    /// What the fluid gives, one after the other; where there is one, it gives what stands there.
    loads: Vec<Vec<f64>>,
    /// Which of them the solution at hand gives.
    given: usize,
    sub_steps: u32,
    /// Whether each sub-step of a structure reads the load.
    interpolates: bool,
}

/// Loads of a fluid that varies: more than the iterations of a window, and no multiple of them, so that every
/// residual is another.
const LOADS: usize = 7;

impl Idle {
    /// In the plane, with so many points. A fluid that `varies` gives another load at every solution; a
    /// structure that `interpolates` reads the whole load at each of its sub-steps, linear between the
    /// window's start and end.
    pub fn new(role: Role, points: usize, varies: bool, interpolates: bool) -> Self {
        let port = |name: &str, quantity, direction| Port::new(name, quantity, 2, Some(points), direction);
        let (motion, load) = match role {
            Role::Structure => (Direction::Out, Direction::In),
            Role::Fluid => (Direction::In, Direction::Out),
        };
        let mut ports = vec![
            port(names::POSITION, Quantity::Position, motion),
            port(names::VELOCITY, Quantity::Velocity, motion),
            port(names::PRESSURE_GRADIENT, Quantity::PressureGradient, load),
        ];
        if interpolates {
            ports.push(port(names::START_PRESSURE_GRADIENT, Quantity::PressureGradient, load));
        }
        let value = |at: usize| ((at * 2654435761) % 1_000_003) as f64 / 1_000_003.0 - 0.5;
        let load = |number: usize| (0..2 * points).map(|i| value(i + number * 7919)).collect();
        Self {
            description: Description {
                role,
                solver: "mock (idle)".to_owned(),
                dimension: 2,
                ports,
                scalars: vec![],
                saves: true,
                notes: vec![],
            },
            loads: if varies { (0..LOADS).map(load).collect() } else { Vec::new() },
            given: 0,
            sub_steps: 1,
            interpolates,
        }
    }
}

impl Participant for Idle {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, _: f64, _: &Fields, _: &mut Fields) -> Result<Readiness> {
        Ok(Readiness { window_limit: f64::INFINITY, scalars: vec![] })
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        self.given = (window.index as usize * 3 + window.iteration as usize) % LOADS;
        self.sub_steps = window.sub_steps.count().unwrap_or(1);
        let loads = [names::START_PRESSURE_GRADIENT, names::PRESSURE_GRADIENT].map(|name| inputs.get(name));
        if let [Some(start), Some(end)] = loads
            && self.interpolates
        {
            let load = Linear::new(start, end);
            // All points at a sub-step before the next, as whoever solves for points that hang together has
            // to.
            for sub_step in 0..self.sub_steps {
                let middle = (f64::from(sub_step) + 0.5) / f64::from(self.sub_steps);
                std::hint::black_box(load.sum(middle));
            }
        }
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        if let (false, Some(load)) = (self.loads.is_empty(), outputs.get_mut(names::PRESSURE_GRADIENT)) {
            load.copy_from_slice(&self.loads[self.given]);
        }
        Ok(WindowReport {
            sub_steps: self.sub_steps,
            window_limit: f64::INFINITY,
            compute_seconds: 0.0,
            scalars: vec![],
        })
    }

    fn accept(&mut self, _: Option<u64>) -> Result<()> {
        Ok(())
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        Ok(vec![])
    }

    fn restore(&mut self, _: &[u8], _: &mut Fields) -> Result<Readiness> {
        Ok(Readiness { window_limit: f64::INFINITY, scalars: vec![] })
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}
