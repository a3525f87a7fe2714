//! Whether two participants fit together: their ports, paired by name.

use crate::port::names;
use crate::{Description, Direction, Port};

/// Ports that the coupler fills.
const FROM_COUPLER: [&str; 2] = [names::HELD_PRESSURE_GRADIENT, names::START_PRESSURE_GRADIENT];

/// What does not fit between two participants, one line each with both sides' values; empty where they fit.
///
/// Every port that one takes is paired with the port of that name which the other gives. A required port that
/// nobody gives is a mismatch; `held_pressure_gradient` and `start_pressure_gradient` are given by the
/// coupler. What is given and not taken is no mismatch: the coupler may want it.
pub fn compare(a: &Description, b: &Description) -> Vec<String> {
    let mut mismatches = Vec::new();
    if a.dimension != b.dimension {
        mismatches.push(format!(
            "dimension: the {} has {}, the {} has {}",
            a.role, a.dimension, b.role, b.dimension
        ));
    }
    for (taker, giver) in [(a, b), (b, a)] {
        for taken in ports(taker, Direction::In) {
            match ports(giver, Direction::Out).find(|given| given.name == taken.name) {
                Some(given) => compare_ports(taker, taken, giver, given, &mut mismatches),
                None if taken.required && !FROM_COUPLER.contains(&taken.name.as_str()) => {
                    let given: Vec<_> =
                        ports(giver, Direction::Out).map(|p| format!("`{}`", p.name)).collect();
                    let given = if given.is_empty() { "nothing".to_owned() } else { given.join(", ") };
                    mismatches.push(format!(
                        "port `{}`: the {} needs it, the {} gives {given}",
                        taken.name, taker.role, giver.role
                    ));
                }
                None => {}
            }
        }
    }
    mismatches
}

fn ports(of: &Description, direction: Direction) -> impl Iterator<Item = &Port> {
    of.ports.iter().filter(move |port| port.direction == direction)
}

fn compare_ports(
    taker: &Description,
    taken: &Port,
    giver: &Description,
    given: &Port,
    mismatches: &mut Vec<String>,
) {
    let mut compare = |what: &str, takes: String, gives: String| {
        if takes != gives {
            mismatches.push(format!(
                "{what} of port `{}`: the {} takes {takes}, the {} gives {gives}",
                taken.name, taker.role, giver.role
            ));
        }
    };
    compare("quantity", taken.quantity.to_string(), given.quantity.to_string());
    compare("unit", taken.unit.clone(), given.unit.clone());
    compare("components", taken.components.to_string(), given.components.to_string());
    if let (Some(takes), Some(gives)) = (taken.points, given.points) {
        compare("number of points", takes.to_string(), gives.to_string());
    }
    compare("exchange", format!("{:?}", taken.exchange), format!("{:?}", given.exchange));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Quantity, Role};

    fn description(role: Role, ports: Vec<Port>) -> Description {
        Description {
            role,
            solver: format!("{role} of a test"),
            dimension: 2,
            ports,
            scalars: vec![],
            saves: false,
            notes: vec![],
        }
    }

    fn pair() -> (Description, Description) {
        let structure = vec![
            Port::new("position", Quantity::Position, 2, Some(5), Direction::Out),
            Port::new("density", Quantity::Density, 2, Some(5), Direction::Out).constant(),
            Port::new("pressure_gradient", Quantity::PressureGradient, 2, Some(5), Direction::In),
        ];
        let fluid = vec![
            Port::new("position", Quantity::Position, 2, None, Direction::In),
            Port::new("density", Quantity::Density, 2, None, Direction::In).constant(),
            Port::new("held_pressure_gradient", Quantity::PressureGradient, 2, None, Direction::In),
            Port::new("pressure_gradient", Quantity::PressureGradient, 2, None, Direction::Out),
            Port::new("normal", Quantity::Normal, 2, None, Direction::Out),
        ];
        (description(Role::Structure, structure), description(Role::Fluid, fluid))
    }

    #[test]
    fn a_pair_that_fits_has_no_mismatch() {
        let (structure, fluid) = pair();
        assert!(compare(&structure, &fluid).is_empty());
        assert!(compare(&fluid, &structure).is_empty());
    }

    #[test]
    fn every_mismatch_is_named_with_both_values() {
        let (mut structure, mut fluid) = pair();
        fluid.dimension = 3;
        fluid.ports[0].components = 3;
        fluid.ports[0].unit = "mm".into();
        fluid.ports[0].points = Some(4);
        structure.ports[1] = Port::new("density", Quantity::Pressure, 2, Some(5), Direction::Out);
        structure.ports[2].name = "traction".into();
        assert_eq!(
            compare(&structure, &fluid),
            [
                "dimension: the structure has 2, the fluid has 3",
                "port `traction`: the structure needs it, the fluid gives `pressure_gradient`, `normal`",
                "unit of port `position`: the fluid takes mm, the structure gives m",
                "components of port `position`: the fluid takes 3, the structure gives 2",
                "number of points of port `position`: the fluid takes 4, the structure gives 5",
                "quantity of port `density`: the fluid takes density, the structure gives pressure",
                "unit of port `density`: the fluid takes kg/m3, the structure gives Pa",
                "exchange of port `density`: the fluid takes Constant, the structure gives EveryWindow",
            ]
        );
    }

    #[test]
    fn what_is_optional_or_comes_from_the_coupler_may_be_missing() {
        let (structure, mut fluid) = pair();
        fluid.ports.push(Port::new("velocity", Quantity::Velocity, 2, None, Direction::In).optional());
        assert!(compare(&structure, &fluid).is_empty());
        fluid.ports.last_mut().unwrap().required = true;
        assert_eq!(
            compare(&structure, &fluid),
            ["port `velocity`: the fluid needs it, the structure gives `position`, `density`"]
        );
    }
}
