//! What a case leaves out is what the structure leaves out: two sets of defaults that agree.

use interfaces::case::numerics::{GradientOperator, StructureNumericsKeys};
use structure::{Gradient, Options};

#[test]
fn the_cases_defaults_are_the_structures_own() {
    let defaults = StructureNumericsKeys::default();
    assert_eq!(
        (defaults.gradient, Options::default().gradient),
        (GradientOperator::Quadratic, Gradient::Quadratic)
    );
    for (of_case, gradient) in [
        (GradientOperator::FirstOrder, Gradient::FirstOrder),
        (GradientOperator::Quadratic, Gradient::Quadratic),
    ] {
        let case = StructureNumericsKeys { gradient: of_case, ..defaults.clone() }.resolve();
        let resolved = Options {
            gradient,
            smoothing_ratio: case.smoothing_ratio,
            hourglass: case.hourglass,
            damping: case.damping,
            step_fraction: case.step_fraction,
        };
        assert_eq!(resolved, Options::of(gradient));
    }
}
