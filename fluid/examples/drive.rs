//! Drives the fluid through small cases for measurements: `drive CASE WIDTH_IN_SPACINGS END_TIME [key=value…]`.
//!
//! Cases: `tank`, `dam`, `swing` (a gate that opens by a prescribed law), `piston` (spring-mass plate under water).

use fluid::*;
use sph::Vector;
use std::io::Write;
type V = Vector<2>;

fn v(x: f64, y: f64) -> V {
    V::from([x, y])
}

struct Random(u64);
impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    }
}

fn wall(name: &str, low: V, high: V) -> WallPart<2> {
    WallPart { name: name.into(), shape: WallShape::Box { low, high }, velocity: V::zeros() }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let case = arguments[1].as_str();
    let cells: f64 = arguments[2].parse().unwrap();
    let end: f64 = arguments[3].parse().unwrap();
    let mut options = Options::default();
    let (mut jitter, mut seed, mut frames, mut out, mut layers) =
        (0.0, 1u64, 0usize, String::from("/tmp/drive"), 4.0);
    let (mut relax, mut every, mut capdt) = (0.5, 0.05, f64::INFINITY);
    for pair in &arguments[4..] {
        let (key, value) = pair.split_once('=').unwrap();
        let number = || value.parse::<f64>().unwrap();
        let flag = || value.parse::<bool>().unwrap();
        match key {
            "jitter" => jitter = number(),
            "seed" => seed = number() as u64,
            "frames" => frames = number() as usize,
            "out" => out = value.into(),
            "layers" => layers = number(),
            "relax" => relax = number(),
            "every" => every = number(),
            "dt" => capdt = number(),
            "scheme" => {
                if value == "paper" {
                    options = Options::paper();
                }
            }
            "offset" => options.surface_offset = flag(),
            "share" => options.laplacian_share = number(),
            "blend" => options.corrected_gradient = flag(),
            "visc" => options.approach_viscosity = number(),
            "tol" => options.pressure_tolerance = number(),
            "ptol" => options.position_tolerance = number(),
            "posproj" => options.position_projection = flag(),
            "shift" => options.shifting_coefficient = number(),
            "contact" => options.contact_distance = number(),
            "courant" => options.courant = number(),
            "compliance" => options.compliance = flag(),
            "taylor" => options.taylor_correction = flag(),
            "sps" => options.smagorinsky = number(),
            "kappa" => options.regularisation = number(),
            "mg" => {
                options.preconditioner =
                    if flag() { Preconditioner::Multigrid } else { Preconditioner::Jacobi }
            }
            "ishift" => options.interface_shifting = flag(),
            _ => panic!("unknown {key}"),
        }
    }
    let mut random = Random(seed);
    let (width, height, tank, top) = match case {
        "tank" => (0.5, 1.0, 0.5, 1.5),
        "dam" => (1.0, 2.0, 4.0, 3.0),
        "swing" => (0.1, 0.14, 0.3, 0.3),
        "piston" => (1.0, 1.0, 1.0, 1.5),
        _ => panic!("no such case"),
    };
    let dx = width / cells;
    let thick = 4.0 * dx;
    let mut parts = vec![
        wall("bed", v(-thick, -thick), v(tank + thick, 0.0)),
        wall("left", v(-thick, 0.0), v(0.0, top)),
        wall("right", v(tank, 0.0), v(tank + thick, top)),
    ];
    let mut structure: Vec<V> = Vec::new();
    let gate_thick: f64 = 0.005;
    let mut dxs = dx;
    if case == "swing" {
        parts[2] = wall("right", v(tank, -0.0), v(tank + thick, 0.02));
        parts.push(wall("above", v(0.1, 0.079), v(0.1 + gate_thick.max(thick), 0.2)));
        dxs = gate_thick / layers;
        structure =
            sph::lattice::Lattice::<2>::fill_box(v(0.1, 0.0), v(0.1 + gate_thick, 0.079), dxs).positions;
    }
    if case == "piston" {
        parts[0] = wall("far", v(-thick, -1.0 - thick), v(tank + thick, -1.0));
        dxs = dx;
        structure = sph::lattice::Lattice::<2>::fill_box(v(0.0, -4.0 * dx), v(tank, 0.0), dx).positions;
        parts[1] = wall("left", v(-thick, -1.0), v(0.0, top));
        parts[2] = wall("right", v(tank, -1.0), v(tank + thick, top));
    }
    let walls = Walls::new(parts, dx, 2.0 * 1.2 * dx).unwrap();
    let lattice = sph::lattice::Lattice::<2>::fill_box(v(0.0, 0.0), v(width, height), dx);
    let volume = lattice.cell_volume();
    let positions: Vec<V> =
        lattice.positions.iter().map(|p| p + v(random.next(), random.next()) * (2.0 * jitter * dx)).collect();
    let n = positions.len();
    let g = 9.81;
    let properties = FluidProperties {
        density: 1000.0,
        kinematic_viscosity: 1e-6,
        gravity: v(0.0, -g),
        spacing: dx,
        particle_volume: volume,
        domain: (v(-1.0, -1.5), v(tank + if case == "swing" { 0.0 } else { 1.0 }, 10.0)),
    };
    let mut state = State::new(positions, vec![V::zeros(); n]);
    // Piston: water 1 x 1 on a plate whose mass makes the added-mass ratio 9 (water column mass 1000 over plate mass).
    let plate_mass = 1000.0 / 9.0;
    let rho_s = if case == "piston" { plate_mass / (structure.len() as f64 * dxs * dxs) } else { 1100.0 };
    let interface = InterfaceParticles {
        volumes: vec![dxs * dxs; structure.len()],
        densities: vec![rho_s; structure.len()],
    };
    let mut fluid = Fluid::new(properties.clone(), options, walls, interface, &state).unwrap();
    let mut trial = State::default();
    let (mut time, mut steps, mut rises, mut iterations, mut piterations, mut worst_rise) =
        (0.0, 0usize, 0, 0, 0, 0.0f64);
    let started = std::time::Instant::now();
    let (mut next_print, mut frame) = (0.0, 0usize);
    let reference = structure.clone();
    let mut held = vec![V::zeros(); structure.len()];
    let (mut plate_y, mut plate_u) = (0.0, 0.0);
    let stiffness = (plate_mass + 1000.0) * (2.0 * std::f64::consts::PI / 0.5f64).powi(2);
    let mut crossings: Vec<f64> = Vec::new();
    let mut initial_energy = f64::NAN;
    let mut works = [0.0f64; 4];
    let (mut peak_p, mut max_density, mut cum_w) = (0.0f64, 0.0f64, 0.0);
    // The rest of the time in equal steps: a last step much shorter than those before would divide what divergence they left by its length.
    let fit = |dt: f64, time: f64| (end - time) / ((end - time) / dt).ceil().max(1.0) * (1.0 + 1e-12);
    let mut log = std::fs::File::create(format!("{out}.csv")).unwrap();
    let swing = |t: f64| {
        // angle and rate of the gate about its upper end: smooth to 0.6 rad in 0.15 s
        let s = (t / 0.15).min(1.0);
        let (a, r) = (0.6 * (3.0 * s * s - 2.0 * s * s * s), 0.6 * (6.0 * s - 6.0 * s * s) / 0.15);
        (a, if t < 0.15 { r } else { 0.0 })
    };
    while time < end {
        let mut velocities = vec![V::zeros(); structure.len()];
        let dt;
        if case == "swing" {
            let (angle, _) = swing(time);
            let pivot = v(0.1, 0.079);
            let turn = |p: &V, a: f64| {
                let r = p - pivot;
                pivot + v(a.cos() * r.x - a.sin() * r.y, a.sin() * r.x + a.cos() * r.y)
            };
            let speed = swing(time).1 * 0.08;
            dt = fit(fluid.stable_step(&state, &[v(speed, 0.0)]).min(capdt), time);
            let (angle_end, _) = swing(time + dt);
            for (i, p) in reference.iter().enumerate() {
                structure[i] = turn(p, angle);
                velocities[i] = (turn(p, angle_end) - structure[i]) / dt;
            }
        } else if case == "piston" {
            dt = fluid.stable_step(&state, &[v(0.0, plate_u)]).min(capdt);
            // predicted with the held load over dt: implicit midpoint of the spring
            let load: f64 = held.iter().map(|h| -dxs * dxs * h.y).sum();
            let a = (load - stiffness * (plate_y + 0.5 * dt * plate_u))
                / (plate_mass + 0.25 * dt * dt * stiffness);
            for (i, p) in reference.iter().enumerate() {
                structure[i] = p + v(0.0, plate_y);
                velocities[i] = v(0.0, plate_u + a * dt);
            }
        } else {
            dt = fit(fluid.stable_step(&state, &[]).min(capdt), time);
        }
        let input =
            InterfaceInput { positions: &structure, velocities: &velocities, held_pressure_gradients: &held };
        let report = match fluid.step(&state, time, dt, &input, &mut trial) {
            Ok(report) => report,
            Err(error) => {
                println!("FAILED: {error}");
                break;
            }
        };
        if case == "piston" {
            let before = plate_y;
            for (h, new) in held.iter_mut().zip(&fluid.output.pressure_gradients) {
                *h = *h * (1.0 - relax) + new * relax;
            }
            let load: f64 = held.iter().map(|h| -dxs * dxs * h.y).sum();
            let a = (load - stiffness * (plate_y + 0.5 * dt * plate_u))
                / (plate_mass + 0.25 * dt * dt * stiffness);
            let u_new = plate_u + a * dt;
            plate_y += 0.5 * dt * (plate_u + u_new);
            plate_u = u_new;
            let mean = -1000.0 * g / stiffness;
            if before > mean && plate_y <= mean {
                crossings.push(time + dt);
            }
        }
        std::mem::swap(&mut state, &mut trial);
        time += dt;
        steps += 1;
        iterations += report.pressure_solve.iterations;
        piterations += report.position_solve.iterations;
        let energy = report.kinetic_energy + report.potential_energy;
        if initial_energy.is_nan() {
            initial_energy = energy - report.energy_change;
        }
        cum_w += report.structure_work + report.contact_structure_work;
        for (w, x) in works.iter_mut().zip([
            report.projection_work,
            report.displacement_work,
            report.viscous_work,
            report.contact_work,
        ]) {
            *w += x / initial_energy;
        }
        let rise =
            report.energy_change - report.structure_work - report.wall_work - report.contact_structure_work;
        if rise > 1e-9 * initial_energy.abs() {
            rises += 1;
            worst_rise = worst_rise.max(rise / initial_energy.abs());
        }
        let p_max = state.pressures.iter().copied().fold(0.0, f64::max);
        if time > 0.005 {
            peak_p = peak_p.max(p_max);
        }
        max_density = max_density.max(report.mean_density_error.abs());
        let front = state.positions.iter().map(|r| r.x).fold(0.0, f64::max);
        let centroid = state.positions.iter().map(|r| r.y).sum::<f64>() / state.len() as f64;
        writeln!(
            log,
            "{time},{dt},{energy},{},{front},{centroid},{},{},{p_max},{},{plate_y},{plate_u},{rise}",
            report.kinetic_energy,
            report.pressure_solve.iterations,
            report.position_solve.iterations,
            report.mean_density_error
        )
        .unwrap();
        if time >= next_print || time >= end {
            next_print += every;
            let mut error = 0.0;
            let mut p_count = 0;
            for (r, p) in state.positions.iter().zip(&state.pressures) {
                error += (p - 1000.0 * g * (height - r.y)).powi(2);
                p_count += 1;
            }
            let rms = (error / p_count as f64).sqrt() / (1000.0 * g * height);
            println!(
                "t {time:.4} step {steps} dt {dt:.2e} it {}/{} theta {:.3} u {:.4} E {:.5} K {:.3e} front {front:.4} cen {centroid:.5} rms {rms:.4} pmax {p_max:.0} n {:+.2e}/{:.3} left {} lost {} rises {rises} ({worst_rise:.1e}) pocket {} splash {} y {plate_y:.5} W {cum_w:.4} works {works:.5?}",
                report.pressure_solve.iterations,
                report.position_solve.iterations,
                report.gradient_share,
                report.max_speed,
                energy / initial_energy,
                report.kinetic_energy,
                report.mean_density_error,
                report.largest_density_error,
                report.left,
                report.lost,
                report.pocket_particles,
                report.splashes,
            );
        }
        if frames > 0 && time >= end * frame as f64 / frames as f64 {
            let mut f = std::fs::File::create(format!("{out}_{frame}.csv")).unwrap();
            for i in 0..state.len() {
                let (r, u) = (state.positions[i], state.velocities[i]);
                writeln!(
                    f,
                    "{},{},{},{},{},{}",
                    r.x, r.y, u.x, u.y, state.pressures[i], state.classes[i] as u8
                )
                .unwrap();
            }
            for (i, s) in structure.iter().enumerate() {
                let g = fluid.output.pressure_gradients[i];
                writeln!(f, "{},{},{},{},{},9", s.x, s.y, g.x, g.y, fluid.output.pressures[i]).unwrap();
            }
            frame += 1;
        }
    }
    let wall_time = started.elapsed().as_secs_f64();
    println!(
        "{n} particles, {steps} steps, {wall_time:.1} s, {:.2} us a particle and step, iterations {:.1}/{:.1}, peak p {peak_p:.0}, rises {rises} worst {worst_rise:.2e}, mean density error at most {max_density:.2e}, lost {}",
        wall_time * 1e6 / (steps as f64 * n as f64),
        iterations as f64 / steps as f64,
        piterations as f64 / steps as f64,
        state.lost,
    );
    if crossings.len() > 1 {
        let periods: Vec<f64> = crossings.windows(2).map(|w| w[1] - w[0]).collect();
        println!("periods {periods:?}, theory 0.5");
    }
}
