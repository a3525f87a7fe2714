//! Wave gauges: where the water ends along a line.
//!
//! How much of the space around a point is water is told by the kernel: `c = Σ V W` over the fluid, over `1 −
//! Σ V W` over walls and structure, which no water can fill. On a flat surface it is a half, beside a wall,
//! too, and half a spacing beyond the last row of a lattice; so the surface is found between particles. A
//! drop alone has a quarter, and is none.

use sph::Vector;
use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use std::borrow::Cow;

/// Share of water from which on a place is in it.
const WET: f64 = 0.5;
/// Least share of space that is left to the fluid: with less, a place is in a solid.
const ROOM: f64 = 0.25;
/// Places looked at in a spacing along the line.
const LOOKS: f64 = 4.0;

/// What may be met along a line.
pub struct Gauge<'a, const D: usize> {
    kernel: CubicSpline<D>,
    /// Particle spacing (m).
    spacing: f64,
    fluid: Cloud<'a, D>,
    solids: Vec<Cloud<'a, D>>,
}

/// Points with their volumes, binned.
pub struct Cloud<'a, const D: usize> {
    positions: &'a [Vector<D>],
    volumes: Cow<'a, [f64]>,
    grid: CellGrid<D>,
}

impl<'a, const D: usize> Gauge<'a, D> {
    /// Fluid particles of one volume (m³), `spacing` (m) apart, among solids of given volumes (m³), seen
    /// through the kernel of a smoothing length (m).
    pub fn new(
        (positions, volume): (&'a [Vector<D>], f64),
        solids: &[(&'a [Vector<D>], &'a [f64])],
        spacing: f64,
        smoothing_length: f64,
    ) -> Self {
        let kernel = CubicSpline::new(smoothing_length);
        let cloud = |positions: &'a [Vector<D>], volumes: Cow<'a, [f64]>| Cloud {
            positions,
            volumes,
            grid: CellGrid::new(positions, kernel.support()),
        };
        let fluid = cloud(positions, Cow::Owned(vec![volume]));
        let solids = solids.iter().filter(|(positions, _)| !positions.is_empty());
        let solids = solids.map(|(positions, volumes)| cloud(positions, Cow::Borrowed(volumes))).collect();
        Self { spacing, fluid, solids, kernel }
    }

    /// Heights (m) above `at` (m) of the water along a unit vector, as far as `length` (m): where the water
    /// ends that is contiguous from the point on, bubbles of a spacing left out of account, and where the
    /// last of it ends; zero where there is none.
    pub fn heights(&self, at: &Vector<D>, along: &Vector<D>, length: f64) -> [f64; 2] {
        let step = self.spacing / LOOKS;
        let looks = (length / step).ceil() as usize;
        let share = |s: f64| self.share(&(at + along * s));
        let (mut first, mut last) = (None, 0.0);
        // Where the water began in which the line is, and where the water before it ended.
        let (mut began, mut before) = (None, share(0.0));
        if before >= WET {
            began = Some(0.0);
        }
        let mut contiguous = |from: f64, to: f64| {
            let reached = *first.get_or_insert(0.0);
            if from - reached <= self.spacing {
                first = Some(to);
            }
        };
        for look in 1..=looks {
            let (from, to) = (step * (look - 1) as f64, (step * look as f64).min(length));
            let now = share(to);
            if (before < WET) != (now < WET) {
                let at = from + (to - from) * (WET - before) / (now - before);
                match began.take() {
                    None => began = Some(at),
                    Some(start) => {
                        contiguous(start, at);
                        last = at;
                    }
                }
            }
            before = now;
        }
        if let Some(start) = began {
            contiguous(start, length);
            last = length;
        }
        [first.unwrap_or(0.0), last]
    }

    /// Share of the space around a point (m), less what solids fill, that is water.
    fn share(&self, at: &Vector<D>) -> f64 {
        // The grid leaves out a point that coincides with the one it is asked for.
        let at = &at.add_scalar(1e-9 * self.spacing);
        let sum = |cloud: &Cloud<'_, D>| {
            let mut sum = 0.0;
            cloud.grid.for_each_near(at, cloud.positions, |b| {
                let b = b as usize;
                let volume = cloud.volumes.get(b).unwrap_or(&cloud.volumes[0]);
                sum += volume * self.kernel.value((cloud.positions[b] - at).norm());
            });
            sum
        };
        let room = 1.0 - self.solids.iter().map(sum).sum::<f64>();
        sum(&self.fluid) / room.max(ROOM)
    }
}

/// How far (m) a line from a point in a box goes along a unit vector until it leaves it.
pub fn length_within<const D: usize>(
    at: &Vector<D>,
    along: &Vector<D>,
    (low, high): &(Vector<D>, Vector<D>),
) -> f64 {
    let of_axis = |i: usize| {
        let far = if along[i] > 0.0 { high[i] } else { low[i] };
        if along[i] == 0.0 { f64::INFINITY } else { (far - at[i]) / along[i] }
    };
    (0..D).map(of_axis).fold(f64::INFINITY, f64::min).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    type V = Vector<2>;

    const SPACING: f64 = 0.02;
    const HIGH: V = V::new(0.0, 1.0);

    /// Particles on a lattice of cells in a tank 1 m wide, below `surface(x)` (m), whose middle is in it; and
    /// the tank's bed and sides, four rows of cells.
    struct Tank {
        fluid: Vec<V>,
        walls: Vec<V>,
        volumes: Vec<f64>,
    }

    impl Tank {
        fn new(surface: impl Fn(f64) -> f64) -> Self {
            let cells = |from: i32, to: i32| (from..to).map(|i| SPACING * (f64::from(i) + 0.5));
            let all: Vec<V> =
                cells(-4, 54).flat_map(|x| cells(-4, 54).map(move |y| V::from([x, y]))).collect();
            let is_wall = |r: &V| r.x < 0.0 || r.x > 1.0 || r.y < 0.0;
            let fluid = all.iter().filter(|r| !is_wall(r) && r.y < surface(r.x)).copied().collect();
            let walls: Vec<V> = all.iter().filter(|r| is_wall(r)).copied().collect();
            let volumes = vec![SPACING * SPACING; walls.len()];
            Self { fluid, walls, volumes }
        }

        fn heights(&self, x: f64, along: V) -> [f64; 2] {
            let solids = [(&self.walls[..], &self.volumes[..])];
            let gauge = Gauge::new((&self.fluid, SPACING * SPACING), &solids, SPACING, 1.3 * SPACING);
            let at = V::from([x, 0.0]);
            gauge.heights(
                &at,
                &along,
                length_within(&at, &along, &(V::from([0.0, 0.0]), V::from([1.0, 1.0]))),
            )
        }
    }

    /// Half a spacing beyond the last row, in the open, at a wall and where the line leans: the kernel's sum
    /// over a lattice is 1 to 2e-3, and falls by one over about two spacings.
    #[test]
    fn a_flat_surface_is_found_between_particles() {
        let tank = Tank::new(|_| 0.4);
        for x in [0.0, 0.003, 0.05, 0.5, 0.513, 1.0] {
            let [height, top] = tank.heights(x, HIGH);
            assert!((height - 0.4).abs() < 0.02 * SPACING, "{height} at {x}");
            assert_eq!(height, top);
        }
        let along = V::from([0.6, 0.8]);
        let [height, _] = tank.heights(0.3, along);
        assert!((height - 0.5).abs() < 0.03 * SPACING, "{height}");
    }

    /// A tilted still surface over rows that lean as it does: to a hundredth of a spacing where the kernel is
    /// whole. At a wall it has one half of the slope, whose mean is 0.65 spacings inwards.
    #[test]
    fn a_tilted_surface_is_found_between_particles() {
        for slope in [0.1, 0.2, 0.3] {
            let surface = |x: f64| 0.4 + slope * (x - 0.5);
            let mut tank = Tank::new(|_| 0.8);
            for r in &mut tank.fluid {
                r.y += surface(r.x) - 0.6;
            }
            tank.fluid.retain(|r| r.y > 0.0 && r.y < surface(r.x));
            for i in 0..=100 {
                let x = 0.01 * f64::from(i);
                let error = (tank.heights(x, HIGH)[0] - surface(x)).abs() / SPACING;
                let bound = if (0.06..0.94).contains(&x) { 0.01 } else { 0.7 * slope };
                assert!(error < bound, "{error} spacings at {x}, slope {slope}");
            }
        }
    }

    /// Steps of a lattice below a slope of one in ten are terraces of ten cells, which is what they are
    /// measured to be.
    #[test]
    fn terraces_are_terraces() {
        let tank = Tank::new(|x| 0.4 + 0.1 * (x - 0.5));
        let worst = (0..=100).map(|i| {
            let x = 0.01 * f64::from(i);
            (tank.heights(x, HIGH)[0] - 0.4 - 0.1 * (x - 0.5)).abs() / SPACING
        });
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 0.6, "{worst} spacings");
    }

    /// A standing wave of 1/20 of the depth, its columns stretched: volumes are kept, and so is the surface
    /// under the kernel, but for its curvature's `κ h²`.
    #[test]
    fn a_standing_wave_is_measured() {
        let wave = |x: f64| 0.02 * (std::f64::consts::TAU * x).cos();
        let mut tank = Tank::new(|_| 0.4);
        for r in &mut tank.fluid {
            r.y *= 1.0 + wave(r.x) / 0.4;
        }
        for i in 0..=50 {
            let x = 0.02 * f64::from(i);
            let [height, _] = tank.heights(x, HIGH);
            let error = (height - 0.4 - wave(x)) / SPACING;
            assert!(error.abs() < 0.06, "{error} spacings at {x}");
        }
    }

    /// A drop that flies alone is none; a sheet over the water is the top, and not the height; a bubble is
    /// left out of account.
    #[test]
    fn drops_sheets_and_bubbles() {
        let mut tank = Tank::new(|_| 0.4);
        tank.fluid.push(V::from([0.5, 0.8]));
        let [height, top] = tank.heights(0.5, HIGH);
        assert_eq!(height, top);
        let sheet =
            (0..60).map(|i| V::from([0.2 + SPACING * f64::from(i % 20), 0.61 + SPACING * f64::from(i / 20)]));
        tank.fluid.extend(sheet);
        let [height, top] = tank.heights(0.4, HIGH);
        assert!((height - 0.4).abs() < 0.02 * SPACING, "{height}");
        assert!((top - 0.66).abs() < 0.05 * SPACING, "{top}");
        tank.fluid.retain(|r| (r - V::from([0.41, 0.21])).norm() > 0.6 * SPACING);
        assert!((tank.heights(0.41, HIGH)[0] - 0.4).abs() < 0.02 * SPACING);
        assert_eq!(Tank::new(|_| 0.0).heights(0.5, HIGH), [0.0, 0.0]);
    }
}
