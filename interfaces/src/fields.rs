//! Arrays that travel: one flat array a port.

use crate::port::{Direction, Exchange, Port};
use pulp::NullaryFnOnce;
use std::mem::MaybeUninit;
use thiserror::Error;

/// The arrays of one direction of a participant, one a port, each `points × components` doubles, point by
/// point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    ports: Vec<Port>,
    arrays: Vec<Vec<f64>>,
}

/// A field that must not cross a boundary.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FieldError {
    /// Not a number, or infinite.
    #[error("field `{port}` is not finite: component {component} at point {point} is {value}")]
    NotFinite {
        /// Port of the field.
        port: String,
        /// Interface point of the first such value.
        point: usize,
        /// Its component.
        component: usize,
        /// The value.
        value: f64,
    },
    /// An array of the wrong length.
    #[error(
        "field `{port}` has {found} values where {expected} belong ({points} points of {components} components)"
    )]
    WrongLength {
        /// Port of the field.
        port: String,
        /// Values that came.
        found: usize,
        /// Values that belong there.
        expected: usize,
        /// Interface points.
        points: usize,
        /// Doubles a point.
        components: usize,
    },
}

impl Fields {
    /// Zeroed arrays for those of `ports` that have the direction, in their order; `points` stands in where a
    /// port names no number.
    pub fn new(ports: &[Port], direction: Direction, points: usize) -> Self {
        let ports: Vec<Port> = ports
            .iter()
            .filter(|p| p.direction == direction)
            .map(|p| Port { points: Some(p.points.unwrap_or(points)), ..p.clone() })
            .collect();
        let arrays = ports.iter().map(|p| vec![0.0; length(p)]).collect();
        Self { ports, arrays }
    }

    /// The ports, in order; every one names its number of points.
    pub fn ports(&self) -> &[Port] {
        &self.ports
    }

    /// The array of the port of that name.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.index(name).map(|i| self.arrays[i].as_slice())
    }

    /// The array of the port of that name, to write.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut [f64]> {
        self.index(name).map(|i| self.arrays[i].as_mut_slice())
    }

    /// Ports with their arrays, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&Port, &[f64])> {
        self.ports.iter().zip(self.arrays.iter().map(Vec::as_slice))
    }

    /// Ports with their arrays, in order, to write.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&Port, &mut [f64])> {
        self.ports.iter().zip(self.arrays.iter_mut().map(Vec::as_mut_slice))
    }

    /// Copies from `other` every field whose name stands on both sides and whose port is `wanted`; lengths
    /// must agree.
    pub fn copy_from(&mut self, other: &Self, wanted: impl Fn(&Port) -> bool) -> Result<(), FieldError> {
        for (port, array) in self.ports.iter().zip(&mut self.arrays) {
            if !wanted(port) {
                continue;
            }
            if let Some(source) = other.get(&port.name) {
                if source.len() != array.len() {
                    return Err(wrong_length(port, source.len()));
                }
                array.copy_from_slice(source);
            }
        }
        Ok(())
    }

    /// Exchanges the array of the port of that name with `values`, which are as many; says whether there is
    /// such a port.
    ///
    /// A field that is already where it belongs is lent for a call in this way, and nothing is copied.
    pub fn swap(&mut self, name: &str, values: &mut Vec<f64>) -> bool {
        let Some(index) = self.index(name) else { return false };
        let array = &mut self.arrays[index];
        assert_eq!(
            array.len(),
            values.len(),
            "an array that is exchanged for another keeps its port's length"
        );
        std::mem::swap(array, values);
        true
    }

    /// Refuses values that are not finite, naming the first.
    pub fn check_finite(&self) -> Result<(), FieldError> {
        self.iter()
            .try_for_each(|(port, array)| if all_finite(array) { Ok(()) } else { not_finite(port, array) })
    }

    /// Doubles in all arrays that `exchange` admits.
    pub fn total(&self, exchange: impl Fn(Exchange) -> bool) -> usize {
        self.iter().filter(|(p, _)| exchange(p.exchange)).map(|(_, a)| a.len()).sum()
    }

    fn index(&self, name: &str) -> Option<usize> {
        self.ports.iter().position(|p| p.name == name)
    }
}

/// The error for an array of `found` values on `port`.
pub fn wrong_length(port: &Port, found: usize) -> FieldError {
    FieldError::WrongLength {
        port: port.name.clone(),
        found,
        expected: length(port),
        points: port.points.unwrap_or(0),
        components: port.components,
    }
}

/// Copies the array of `port`, and refuses values that are not finite on the way, naming the first. Both are
/// of one length.
pub(crate) fn take_finite(port: &Port, from: &[f64], to: &mut [f64]) -> Result<(), FieldError> {
    let finite = pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            let pairs = from.iter().zip(to);
            pairs.fold(0, |found, (value, place)| {
                *place = *value;
                found | overflown(*value)
            }) >> 63
                == 0
        },
    );
    if finite { Ok(()) } else { not_finite(port, from) }
}

/// [`take_finite`] into memory that holds nothing yet; all of it is written, whatever the values.
pub(crate) fn put_finite(port: &Port, from: &[f64], to: &mut [MaybeUninit<f64>]) -> Result<(), FieldError> {
    assert_eq!(from.len(), to.len(), "a place is laid out for its field");
    let finite = pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            let pairs = from.iter().zip(to);
            pairs.fold(0, |found, (value, place)| {
                place.write(*value);
                found | overflown(*value)
            }) >> 63
                == 0
        },
    );
    if finite { Ok(()) } else { not_finite(port, from) }
}

/// The error for the first value of the array that is not finite; none where all are.
fn not_finite(port: &Port, array: &[f64]) -> Result<(), FieldError> {
    array.iter().position(|value| !value.is_finite()).map_or(Ok(()), |at| {
        Err(FieldError::NotFinite {
            port: port.name.clone(),
            point: at / port.components,
            component: at % port.components,
            value: array[at],
        })
    })
}

/// A field that goes linearly over a window, read at any fraction of it; nothing is stored of what it is
/// there.
#[derive(Clone, Copy, Debug)]
pub struct Linear<'a> {
    start: &'a [f64],
    end: &'a [f64],
}

impl<'a> Linear<'a> {
    /// From its values at the window's start to those at its end, which are as many.
    pub fn new(start: &'a [f64], end: &'a [f64]) -> Self {
        assert_eq!(start.len(), end.len(), "a field has as many values at a window's end as at its start");
        Self { start, end }
    }

    /// The value of that index.
    #[inline]
    pub fn at(&self, index: usize, fraction: f64) -> f64 {
        between(self.start[index], self.end[index], fraction)
    }

    /// The sum of all values.
    pub fn sum(&self, fraction: f64) -> f64 {
        let partial = pulp::Arch::new().dispatch(PartialSums { field: *self, fraction });
        let summed = self.start.len() / LANES * LANES;
        let rest: f64 = (summed..self.start.len()).map(|index| self.at(index, fraction)).sum();
        partial.iter().sum::<f64>() + rest
    }
}

#[inline(always)]
fn between(start: f64, end: f64, fraction: f64) -> f64 {
    start + fraction * (end - start)
}

/// As many partial sums as keep a machine that adds eight numbers at a time from waiting for itself.
const LANES: usize = 64;

/// A structure and no closure, which the compiler may leave outside the code for the machine at hand.
struct PartialSums<'a> {
    field: Linear<'a>,
    fraction: f64,
}

impl NullaryFnOnce for PartialSums<'_> {
    type Output = [f64; LANES];

    #[inline(always)]
    fn call(self) -> [f64; LANES] {
        let Self { field: Linear { start, end }, fraction } = self;
        let mut sums = [0.0; LANES];
        for (start, end) in start.as_chunks::<LANES>().0.iter().zip(end.as_chunks::<LANES>().0) {
            for lane in 0..LANES {
                sums[lane] += between(start[lane], end[lane], fraction);
            }
        }
        sums
    }
}

/// Whether no value is infinite or not a number. Without a branch for each value it runs at the speed of
/// memory, which matters: every field is checked wherever it crosses.
fn all_finite(array: &[f64]) -> bool {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || array.iter().fold(0, |found, value| found | overflown(*value)) >> 63 == 0,
    )
}

/// The highest bit is set where the value is infinite or not a number, and only there. Those have an exponent
/// with all bits set, and adding one to it carries into the sign's place.
#[inline(always)]
fn overflown(value: f64) -> u64 {
    const EXPONENT: u64 = f64::INFINITY.to_bits();
    const ONE: u64 = 1 << (f64::MANTISSA_DIGITS - 1);
    (value.to_bits() & EXPONENT) + ONE
}

fn length(port: &Port) -> usize {
    port.points.unwrap_or(0) * port.components
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::Quantity;

    fn ports() -> Vec<Port> {
        vec![
            Port::new("position", Quantity::Position, 2, Some(3), Direction::Out),
            Port::new("density", Quantity::Density, 2, Some(3), Direction::Out).constant(),
            Port::new("pressure_gradient", Quantity::PressureGradient, 2, None, Direction::In),
        ]
    }

    #[test]
    fn arrays_have_the_ports_shapes() {
        let out = Fields::new(&ports(), Direction::Out, 9);
        assert_eq!((out.get("position").unwrap().len(), out.get("density").unwrap().len()), (6, 3));
        assert_eq!(out.total(|e| e == Exchange::EveryWindow), 6);
        assert_eq!(Fields::new(&ports(), Direction::In, 9).get("pressure_gradient").unwrap().len(), 18);
        assert!(out.get("pressure_gradient").is_none());
    }

    #[test]
    fn the_first_value_that_is_not_finite_is_named() {
        let mut out = Fields::new(&ports(), Direction::Out, 0);
        out.get_mut("position").unwrap()[3] = f64::NAN;
        let message = out.check_finite().unwrap_err().to_string();
        assert_eq!(message, "field `position` is not finite: component 1 at point 1 is NaN");
    }

    #[test]
    fn only_infinite_values_and_those_that_are_no_numbers_are_refused() {
        for finite in [0.0, -0.0, f64::MIN, f64::MAX, f64::MIN_POSITIVE, -5e-324] {
            assert!(all_finite(&[1.0, finite, -2.0]), "{finite}");
        }
        for other in [
            f64::NAN,
            -f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::from_bits(f64::INFINITY.to_bits() + 1),
        ] {
            assert!(!all_finite(&[1.0, other, -2.0]), "{other}");
        }
    }

    #[test]
    fn a_linear_field_is_read_at_any_fraction() {
        // Whole numbers and a half: exact in any order.
        let start: Vec<f64> = (0..200).map(f64::from).collect();
        let end: Vec<f64> = start.iter().map(|x| 3.0 * x).collect();
        let field = Linear::new(&start, &end);
        assert_eq!([field.at(5, 0.0), field.at(5, 0.5), field.at(5, 1.0)], [5.0, 10.0, 15.0]);
        assert_eq!(field.sum(0.5), 2.0 * 199.0 * 200.0 / 2.0);
    }

    #[test]
    fn fields_are_paired_by_name_and_lengths_must_agree() {
        let mut out = Fields::new(&ports(), Direction::Out, 0);
        out.get_mut("position").unwrap()[0] = 7.0;
        let mut taken = Fields::new(
            &[Port::new("position", Quantity::Position, 2, None, Direction::In)],
            Direction::In,
            3,
        );
        taken.copy_from(&out, |_| true).unwrap();
        assert_eq!(taken.get("position").unwrap()[0], 7.0);
        let mut shorter = Fields::new(
            &[Port::new("position", Quantity::Position, 2, Some(2), Direction::In)],
            Direction::In,
            0,
        );
        let message = shorter.copy_from(&out, |_| true).unwrap_err().to_string();
        assert_eq!(message, "field `position` has 6 values where 4 belong (2 points of 2 components)");
    }
}
