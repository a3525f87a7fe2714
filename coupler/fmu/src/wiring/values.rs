//! Where the values of one port are: an array, a list or a pattern of scalars, or one value for all points.

use super::{Plan, Sourced, Values, ports_of};
use crate::description::{Causality, Dimension, Type, Variable};
use interfaces::case::unit::{ParameterValue, Source};
use interfaces::participant::MOST_VALUES;
use interfaces::port::names;
use interfaces::{Direction, Exchange};

impl Plan<'_> {
    /// Values of a port for which the case names variables.
    pub(super) fn said(
        &mut self,
        port: &str,
        source: &Source,
        components: usize,
        direction: Direction,
        exchange: Exchange,
    ) -> Option<Sourced> {
        let key = self.key(&format!("variables.{port}"));
        let names = match source {
            Source::Number(number) => {
                if exchange == Exchange::Constant && direction == Direction::Out {
                    return Some(Sourced { values: Values::Number(*number), points: None, factor: 1.0 });
                }
                self.mismatches.push(format!("{key} = {number}: a number stands for what a {} gives once, and `{port}` is none of these; name variables", self.role));
                return None;
            }
            Source::Name(name) if name.contains("{point}") => match self.pattern(name, components) {
                Ok(names) => names,
                Err(what) => {
                    self.mismatches.push(format!("{key} = \"{name}\": {what}"));
                    return None;
                }
            },
            Source::Name(name) => {
                let variable = self.variable(&key, name)?;
                return self.one(&key, &variable, components, direction, exchange);
            }
            Source::Names(names) => names.clone(),
        };
        let variables: Option<Vec<Variable>> = names.iter().map(|name| self.variable(&key, name)).collect();
        let variables = variables?;
        if variables.is_empty() || !variables.len().is_multiple_of(components) {
            let count = variables.len();
            self.mismatches.push(format!("{key}: {count} variables are named, and a point has {components}"));
            return None;
        }
        let odd = variables.iter().find(|variable| !variable.dimensions.is_empty());
        if let Some(odd) = odd {
            self.mismatches.push(format!("{key}: `{}` is an array in a list of scalars", odd.name));
            return None;
        }
        if !variables.iter().all(|variable| self.may(&key, variable, direction)) {
            return None;
        }
        let points = variables.len() / components;
        let factor = self.factor(&key, port, &variables[0])?;
        if variables.iter().any(|variable| variable.unit != variables[0].unit) {
            self.mismatches.push(format!("{key}: the variables are in different units"));
            return None;
        }
        let values = Values::Variables(variables.iter().map(|variable| variable.reference).collect());
        Some(Sourced { values, points: Some(points), factor })
    }

    /// Values of a port for which the case says nothing: the variable of its own name, where that fits.
    pub(super) fn of_own_name(
        &mut self,
        port: &str,
        components: usize,
        direction: Direction,
        exchange: Exchange,
    ) -> Option<Sourced> {
        // Our own unit has the density as a parameter, and that of each particle, 0 where one is held.
        let of_each = (port == names::DENSITY).then(|| self.description.variable("interface_density"));
        let Some(variable) = of_each.flatten().or_else(|| self.description.variable(port)).cloned() else {
            // The scalars of a unit that meniscus exported as FMI 2.0.
            let names = self.pattern(&format!("point[{{point}}].{port}.{{axis}}"), components).ok()?;
            return self.said(port, &Source::Names(names), components, direction, exchange);
        };
        let key = self.key(&format!("variables.{port}"));
        // A variable that only happens to have the name is none of the interface's.
        let scalar_of_many = variable.dimensions.is_empty()
            && !(exchange == Exchange::Constant && direction == Direction::Out && components == 1);
        if variable.kind != Type::Float64 || scalar_of_many {
            return None;
        }
        self.one(&key, &variable, components, direction, exchange)
    }

    /// One variable for a whole port.
    fn one(
        &mut self,
        key: &str,
        variable: &Variable,
        components: usize,
        direction: Direction,
        exchange: Exchange,
    ) -> Option<Sourced> {
        if !self.may(key, variable, direction) {
            return None;
        }
        let factor = self.factor(key, key.rsplit('.').next().unwrap_or(key), variable)?;
        let name = &variable.name;
        if variable.dimensions.is_empty() {
            if exchange == Exchange::Constant && direction == Direction::Out && components == 1 {
                return Some(Sourced { values: Values::Same(variable.reference), points: None, factor });
            }
            if components > 1 {
                self.mismatches.push(format!("{key}: `{name}` is a scalar; name an array, a list, or a pattern with {{point}} and {{axis}}"));
                return None;
            }
            let values = Values::Variables(vec![variable.reference]);
            return Some(Sourced { values, points: Some(1), factor });
        }
        let mut lengths = Vec::new();
        for dimension in &variable.dimensions {
            match self.length(*dimension) {
                Some(length) => lengths.push(length),
                None => {
                    self.mismatches.push(format!("{key}: the size of `{name}` is not known"));
                    return None;
                }
            }
        }
        let product = lengths.iter().try_fold(1_usize, |total, length| total.checked_mul(*length));
        let Some(total) = product.filter(|total| *total <= MOST_VALUES) else {
            let what = format!(
                "{key}: `{name}` is an array of {lengths:?}, and {MOST_VALUES} values are taken at most"
            );
            self.mismatches.push(what);
            return None;
        };
        let by_point = lengths.len() == 1 || lengths.last() == Some(&components) || components == 1;
        if total == 0 || !total.is_multiple_of(components) || !by_point {
            self.mismatches.push(format!(
                "{key}: `{name}` is an array of {lengths:?}; one of points × {components} belongs here"
            ));
            return None;
        }
        let values = Values::Variables(vec![variable.reference]);
        Some(Sourced { values, points: Some(total / components), factor })
    }

    /// Names of scalars, point by point, as far as there are variables of that name.
    fn pattern(&self, pattern: &str, components: usize) -> Result<Vec<String>, String> {
        const AXES: [&str; 3] = ["x", "y", "z"];
        if components > 1 && !pattern.contains("{axis}") && !pattern.contains("{component}") {
            return Err(format!(
                "a point has {components} components; add {{axis}} (x, y, z) or {{component}} (1, 2, 3)"
            ));
        }
        let of = |point: usize| -> Vec<String> {
            (0..components)
                .map(|c| {
                    let name = pattern.replace("{point}", &point.to_string()).replace("{axis}", AXES[c]);
                    name.replace("{component}", &(c + 1).to_string())
                })
                .collect()
        };
        let there = |point: &usize| of(*point).iter().any(|name| self.description.variable(name).is_some());
        let first = usize::from(!there(&0));
        let names: Vec<String> = (first..).take_while(there).flat_map(of).collect();
        if names.is_empty() {
            return Err(format!("there is neither `{}` nor that of point 0", of(1)[0]));
        }
        Ok(names)
    }

    pub(super) fn variable(&mut self, key: &str, name: &str) -> Option<Variable> {
        let found = self.description.variable(name).cloned();
        if found.is_none() {
            let remedy = self.nearest(name).map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            self.mismatches.push(format!("{key}: there is no variable `{name}`{remedy}"));
        }
        found
    }

    /// The name nearest to one that is none: the same but for case or one sign, or one that it is part of.
    fn nearest(&self, name: &str) -> Option<&str> {
        let letters = |text: &str| -> String {
            text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
        };
        let wanted = letters(name);
        let all = || self.description.variables.iter().map(|variable| variable.name.as_str());
        all().find(|other| letters(other) == wanted).or_else(|| {
            all().filter(|other| letters(other).contains(&wanted)).min_by_key(|other| other.len())
        })
    }

    /// Whether a variable can be set or read as the port asks.
    fn may(&mut self, key: &str, variable: &Variable, direction: Direction) -> bool {
        let name = &variable.name;
        if variable.kind != Type::Float64 {
            self.mismatches.push(format!(
                "{key}: `{name}` is of type {:?}; a field is Float64 (FMI 2.0: Real)",
                variable.kind
            ));
            return false;
        }
        let settable = matches!(variable.causality, Causality::Input | Causality::Parameter);
        if direction == Direction::In && !settable {
            self.mismatches.push(format!("{key}: `{name}` is no input"));
            return false;
        }
        if direction == Direction::Out && variable.causality == Causality::Input {
            self.mismatches.push(format!("{key}: `{name}` is an input, and the {} gives this", self.role));
            return false;
        }
        true
    }

    /// What the port's variable has to be multiplied by to be in the port's unit. One of which nothing is
    /// said is taken to be in it; one that is in another unit, and does not say what that is, is refused.
    fn factor(&mut self, key: &str, port: &str, variable: &Variable) -> Option<f64> {
        let quantity = ports_of(self.role).into_iter().find(|(name, ..)| *name == port).map(|(_, q, ..)| q);
        let Some(quantity) = quantity else { return Some(1.0) };
        let found = self.factor_to(quantity.unit(), variable);
        found.map_err(|what| self.mismatches.push(format!("{key}: {what}"))).ok()
    }

    /// What a variable has to be multiplied by to be in the SI unit `wanted`, which is noted where it is not
    /// 1; why it cannot be.
    pub(super) fn factor_to(&mut self, wanted: &str, variable: &Variable) -> Result<f64, String> {
        let (name, Some(unit)) = (&variable.name, &variable.unit) else { return Ok(1.0) };
        let plain =
            |unit: &str| unit.replace(['^', '\u{b2}'], "").replace('\u{b3}', "3").replace("N/m3", "Pa/m");
        if plain(unit) == wanted {
            return Ok(1.0);
        }
        match self.description.units.get(unit).map(|base| (base, base.factor_to(wanted))) {
            Some((_, Some(factor))) => {
                if factor != 1.0 {
                    self.notes
                        .push(format!("`{name}` is in `{unit}`: its numbers are taken {factor:e} times"));
                }
                Ok(factor)
            }
            Some((base, None)) => {
                Err(format!("`{name}` is in `{unit}`, which is {base}; {wanted} belongs here"))
            }
            None => Err(format!(
                "`{name}` is in `{unit}`, of which the unit does not say what it is in SI units; {wanted} belongs here"
            )),
        }
    }

    fn length(&self, dimension: Dimension) -> Option<usize> {
        let reference = match dimension {
            Dimension::Fixed(length) => return Some(length),
            Dimension::Of(reference) => reference,
        };
        let variable = self.description.variables.iter().find(|variable| variable.reference == reference)?;
        match self.unit.parameters.get(&variable.name) {
            Some(ParameterValue::Number(number)) => Some(*number as usize),
            _ => variable.start.as_ref()?.parse().ok(),
        }
    }
}
