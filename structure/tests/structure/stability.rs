//! The stable step of the whole method.

use sph::Vector;
use structure::{Body, Gradient, Law, Load, Material, Options, Plane, Setup, Side, Solid, TotalLagrangian};

fn grows(gradient: Gradient, factor: f64) -> bool {
    let material = Material::new(Law::StVenantKirchhoff, 1e6, 0.3, Plane::Strain);
    let ratio = gradient.default_smoothing_ratio();
    let body = Body::block(Vector::from([0.0, 0.0]), Vector::from([1.2, 0.4]), 0.1, material, 1000.0).clamp(
        0,
        Side::Low,
        gradient,
        ratio,
    );
    let mut setup = Setup::new(vec![body]);
    setup.options = Options::of(gradient);
    let mut structure = TotalLagrangian::new(setup).unwrap();
    let mut from = structure.state_at_rest(0.0);
    let step = factor * from.stability.step;
    from.stability.step = f64::INFINITY;
    // Rough velocities, so small that all stays linear.
    let rough = |k: usize| 1e-7 * (1.7 * (k * k) as f64).sin();
    for (i, velocity) in from.velocities.iter_mut().enumerate() {
        *velocity = Vector::from([rough(2 * i), rough(2 * i + 1)]);
    }
    structure.evaluate(&mut from).unwrap();
    let mut to = from.clone();
    // Beyond the limit by 1.17 the amplification a step is about 2, so 400 steps overflow all bounds.
    match structure.advance(&from, &mut to, 400.0 * step, 400, &Load::None) {
        Ok(_) => to.energy.balance() > from.energy.balance() * (1.0 + 1e-12),
        Err(_) => true,
    }
}

#[test]
fn the_stable_step_is_stable_and_a_third_more_is_not() {
    for gradient in [Gradient::FirstOrder, Gradient::Quadratic] {
        assert!(!grows(gradient, 1.0), "{gradient:?}");
        assert!(grows(gradient, 1.3), "{gradient:?}");
    }
}
