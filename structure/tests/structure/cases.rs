//! Benchmarks, coarse: the paper's oscillating plate and cantilever, and beams held against finite- and
//! spectral-element references.

use sph::Vector;
use structure::{
    Body, DeadLoad, Gradient, History, Law, Load, Material, MaterialPoint, Options, Plane, Setup, Side,
    Solid, State, TotalLagrangian,
};

type V = Vector<2>;

fn clamped_beam(
    length: f64,
    thickness: f64,
    layers: usize,
    material: Material,
    density: f64,
    gradient: Gradient,
    smoothing_ratio: f64,
) -> Setup<2> {
    let body =
        Body::block(V::zeros(), V::from([length, thickness]), thickness / layers as f64, material, density)
            .clamp(0, Side::Low, gradient, smoothing_ratio);
    let mut setup = Setup::new(vec![body]);
    setup.options = Options::of(gradient);
    setup.options.smoothing_ratio = smoothing_ratio;
    setup
}

fn free_positions(setup: &Setup<2>) -> Vec<V> {
    // Clamps are appended after the free particles, so indices agree with those of all particles.
    let body = &setup.bodies[0];
    body.positions.iter().zip(&body.clamped).filter(|(_, clamped)| !**clamped).map(|(p, _)| *p).collect()
}

/// Advances in windows with as many sub-steps as stability asks and calls
/// `see(time, displacement of the point)`.
fn run(
    structure: &mut TotalLagrangian<2>,
    mut state: State<2>,
    end: f64,
    windows: usize,
    point: &MaterialPoint<2>,
    mut see: impl FnMut(f64, V),
) -> State<2> {
    let dt = end / windows as f64;

    let mut next = state.clone();
    for w in 1..=windows {
        let sub_steps = state.stable_sub_steps(dt);
        structure.advance(&state, &mut next, dt, sub_steps, &Load::None).unwrap();
        std::mem::swap(&mut state, &mut next);
        see(w as f64 * dt, point.value(&state.positions) - point.reference);
    }
    state
}

/// Period `T c₀/L` and amplitude `A/L` of the oscillating plate of the paper's section 3.1 (Gray et al.
/// 2001).
fn oscillating_plate(layers: usize, gradient: Gradient, smoothing_ratio: f64) -> (f64, f64) {
    let (bulk, nu, density): (f64, f64, f64) = (3.25e6, 0.3975, 1000.0);
    let material = Material::new(Law::AlmansiHooke, 3.0 * bulk * (1.0 - 2.0 * nu), nu, Plane::Strain);
    let setup = clamped_beam(0.2, 0.02, layers, material, density, gradient, smoothing_ratio);
    let mut structure = TotalLagrangian::new(setup).unwrap();
    let c0 = (bulk / density).sqrt();
    let (kl, k) = (1.875_f64, 1.875 / 0.2);
    // Eq. (52)
    let f = |x: f64| {
        (kl.cos() + kl.cosh()) * ((k * x).cosh() - (k * x).cos())
            + (kl.sin() - kl.sinh()) * ((k * x).sinh() - (k * x).sin())
    };
    let mut state = structure.state_at_rest(0.0);
    for i in 0..structure.particles().len() {
        let x = structure.particles().reference_positions[i].x;
        state.velocities[i] = V::from([0.0, 0.01 * c0 * f(x) / f(0.2)]);
    }
    let tip = MaterialPoint::new(
        V::from([0.2, 0.01]),
        &structure.particles().reference_positions,
        0.02 / layers as f64,
    )
    .unwrap();
    let (mut period, mut amplitude, mut before) = (0.0, 0.0_f64, (0.0, 0.0));
    run(&mut structure, state, 0.29, 580, &tip, |t, u| {
        if before.1 < 0.0 && u.y >= 0.0 && period == 0.0 {
            period = before.0 - before.1 * (t - before.0) / (u.y - before.1);
        }
        amplitude = amplitude.max(u.y);
        before = (t, u.y);
    });
    (period * c0 / 0.2, amplitude / 0.2)
}

/// Paper, Table 3, T/Δx = 10: 77.50 and 0.123. Two per cent, as differences of clamp and probe allow;
/// amplitude three.
#[test]
fn the_first_order_gradient_gives_the_papers_table_3() {
    let (period, amplitude) = oscillating_plate(10, Gradient::FirstOrder, 1.2);
    assert!((period / 77.50 - 1.0).abs() < 0.02, "{period}");
    assert!((amplitude / 0.123 - 1.0).abs() < 0.03, "{amplitude}");
}

/// Plane-strain continuum (spectral elements): 72.75 and 0.1148. Measured at 4 layers: −0.02 % and −0.3 %.
#[test]
fn the_quadratic_gradient_is_right_in_bending_with_four_layers() {
    let (period, amplitude) = oscillating_plate(4, Gradient::Quadratic, 1.0);
    assert!((period / 72.75 - 1.0).abs() < 0.005, "{period}");
    assert!((amplitude / 0.1148 - 1.0).abs() < 0.01, "{amplitude}");
}

/// Static cantilever of section 3.1, damped, at a dead end load of 1750 N on a width of 1 mm. Geometrically
/// exact beam: 30.38 mm in plane stress, 28.05 mm in plane strain (the paper holds it against the linear
/// 33.59 mm). Issue: 1.5 % at 4 layers.
#[test]
fn a_static_cantilever_with_four_layers() {
    for (plane, expected) in [(Plane::Stress, 30.38e-3), (Plane::Strain, 28.05e-3)] {
        let material = Material::new(Law::StVenantKirchhoff, 210e9, 0.3, plane);
        let mut setup = clamped_beam(0.1, 0.01, 4, material, 7850.0, Gradient::Quadratic, 1.0);
        let face = MaterialPoint::over_face(
            V::from([0.1, 0.0]),
            V::from([0.1, 0.01]),
            8,
            &free_positions(&setup),
            0.0025,
        )
        .unwrap();
        setup.dead_loads.push(DeadLoad::at(&face, V::from([0.0, 1750.0 / 0.001]), History::ramp(1.5e-3)));
        // Near critical for the first mode, 840 Hz: 2 ω is 10,600 1/s; less is enough to rest after 10 ms.
        setup.options.damping = 2500.0;
        let mut structure = TotalLagrangian::new(setup).unwrap();
        let state = structure.state_at_rest(0.0);
        let tip =
            MaterialPoint::new(V::from([0.1, 0.005]), &structure.particles().reference_positions, 0.0025)
                .unwrap();
        let mut deflection = 0.0;
        let end = run(&mut structure, state, 0.01, 100, &tip, |_, u| deflection = u.y);
        assert!((deflection / expected - 1.0).abs() < 0.015, "{plane:?}: {deflection}");
        let reaction = structure.clamp_reaction(&end).unwrap();
        assert!((reaction.y / -1.75e6 - 1.0).abs() < 1e-3, "{reaction}");
        assert!(end.energy.balance().abs() < 1e-4 * end.energy.strain, "{:?}", end.energy);
    }
}

/// Cantilever block in 3-D, 2 × 0.25 × 0.25 with four layers, under its weight, damped. Timoshenko's beam
/// with ν = 0 (no effect of the cross-section's strain): w = ρ g A L⁴/(8 E I) + ρ g L²/(2 k G), k = 5/6.
/// Three per cent: a clamp counts as about 0.15 Δx too far back, 4 · 0.15/32 of the deflection, and 1 % as in
/// 2-D.
#[test]
fn a_cantilever_block_in_three_dimensions() {
    let material = Material::new(Law::StVenantKirchhoff, 1e6, 0.0, Plane::Strain);
    let body = Body::block(Vector::zeros(), Vector::from([2.0, 0.25, 0.25]), 0.0625, material, 1000.0).clamp(
        0,
        Side::Low,
        Gradient::Quadratic,
        1.0,
    );
    let mut setup = Setup::new(vec![body]);
    setup.options = Options::of(Gradient::Quadratic);
    setup.gravity = Vector::from([0.0, 0.0, -0.001]);
    // Near critical: twice the first mode's 2.0 rad/s.
    setup.options.damping = 4.0;
    let mut structure = TotalLagrangian::<3>::new(setup).unwrap();
    let tip = MaterialPoint::new(
        Vector::from([2.0, 0.125, 0.125]),
        &structure.particles().reference_positions,
        0.0625,
    )
    .unwrap();
    let from = structure.state_at_rest(0.0);
    let mut to = from.clone();
    let sub_steps = from.stable_sub_steps(5.0);
    structure.advance(&from, &mut to, 5.0, sub_steps, &Load::None).unwrap();
    let deflection = tip.reference.z - tip.value(&to.positions).z;
    let (length, area, second_moment) = (2.0_f64, 0.0625, 0.25_f64.powi(4) / 12.0);
    let weight = 1000.0 * 0.001 * area;
    let expected = weight * length.powi(4) / (8.0 * 1e6 * second_moment)
        + weight * length.powi(2) / (2.0 * 5.0 / 6.0 * 0.5e6 * area);
    assert!((deflection / expected - 1.0).abs() < 0.03, "{deflection} {expected}");
}
