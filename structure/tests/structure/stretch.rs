//! A bar pulled to twice its length and more: stretch over stress by the laws in one dimension, in steps that
//! stay stable as it stiffens.

use sph::Vector;
use structure::{
    Body, DeadLoad, Error, Gradient, History, Law, Load, Material, MaterialPoint, Plane, Setup, Side, Solid,
    TotalLagrangian,
};

type V = Vector<2>;

const LENGTH: f64 = 1.0;
const WIDTH: f64 = 0.2;
const SPACING: f64 = 0.05;
const YOUNGS_MODULUS: f64 = 1e6;

/// The bar, its end pulled by `traction` (Pa of the reference area) from 0.3 s on. With ν = 0 the clamp does
/// not disturb it.
fn pulled(law: Law, traction: f64) -> TotalLagrangian<2> {
    let material = Material::new(law, YOUNGS_MODULUS, 0.0, Plane::Strain);
    let bar = Body::block(V::zeros(), V::from([LENGTH, WIDTH]), SPACING, material, 1000.0);
    let end = MaterialPoint::over_face(
        V::from([LENGTH, 0.0]),
        V::from([LENGTH, WIDTH]),
        8,
        &bar.positions,
        SPACING,
    );
    let end = end.expect("the bar has particles");
    let mut setup = Setup::new(vec![bar.clamp(0, Side::Low, Gradient::Quadratic, 1.0)]);
    setup.dead_loads.push(DeadLoad::at(&end, V::from([traction * WIDTH, 0.0]), History::ramp(0.3)));
    // Near critical for the first mode, π/2 √(E/ρ)/L = 50 1/s.
    setup.options.damping = 80.0;
    TotalLagrangian::new(setup).unwrap()
}

/// The stretch in the middle at 0.6 s, solved in `windows`, and the least stable sub-step on the way over
/// that at rest.
fn stretch(structure: &mut TotalLagrangian<2>, windows: usize) -> Result<(f64, f64), Error> {
    let mut state = structure.state_at_rest(0.0);
    let mut next = state.clone();
    let dt = 0.6 / windows as f64;
    let mut least = f64::INFINITY;
    for _ in 0..windows {
        structure.advance(&state, &mut next, dt, state.stable_sub_steps(dt), &Load::None)?;
        std::mem::swap(&mut state, &mut next);
        least = least.min(state.stability.step);
    }
    let at = |x: f64| {
        let point = MaterialPoint::new(
            V::from([x, 0.5 * WIDTH]),
            &structure.particles().reference_positions,
            SPACING,
        );
        point.expect("the bar has particles").value(&state.positions)
    };
    Ok(((at(0.75) - at(0.25)).x / 0.5, least / structure.stable_time_step()))
}

/// St. Venant and Kirchhoff `P = ½ E (λ³ − λ)`, neo-Hookean `P = ½ E (λ − 1/λ)`, both with ν = 0; what is
/// left is motion, below 1e-3.
#[test]
fn a_bar_is_stretched_as_its_law_says() {
    for (law, traction, expected) in [
        (Law::StVenantKirchhoff, 0.5 * (1.5_f64.powi(3) - 1.5), 1.5),
        (Law::StVenantKirchhoff, 3.0, 2.0),
        (Law::NeoHookean, 0.75, 2.0),
        (Law::NeoHookean, 0.5 * (3.0 - 1.0 / 3.0), 3.0),
        (Law::NeoHookean, -0.15, 0.5 * (-0.3 + (0.09_f64 + 4.0).sqrt())),
    ] {
        let mut structure = pulled(law, traction * YOUNGS_MODULUS);
        let (found, least_step) = stretch(&mut structure, 60).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-3, "{law:?} {traction}: {found} for {expected}");
        if law == Law::StVenantKirchhoff {
            // dP/dλ = ½ E (3λ² − 1). The step is found anew after every 2 % of strain, and the roughest wave
            // runs along the bar.
            let stiffening = (0.5 * (3.0 * expected * expected - 1.0)).sqrt();
            assert!((least_step * stiffening - 1.0).abs() < 0.06, "{expected}: {least_step}, {stiffening}");
        }
    }
}

/// The same in windows so long that the step is not found anew: an error that names the particle and asks for
/// more sub-steps.
#[test]
fn a_step_found_at_rest_is_too_long_for_a_stretched_bar() {
    let mut structure = pulled(Law::StVenantKirchhoff, 3.0 * YOUNGS_MODULUS);
    let error = stretch(&mut structure, 1).unwrap_err();
    assert!(matches!(error, Error::Inverted { .. }), "{error}");
    assert!(error.to_string().contains("more sub-steps"), "{error}");
}
