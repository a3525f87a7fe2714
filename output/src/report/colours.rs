//! Colour maps for the pictures: perceptually ordered, one for the fluid and another for the structure, so
//! that the two are told apart where they touch.

use super::image::Rgb;

/// A colour for each fraction from 0 to 1, linear between its entries.
pub(crate) type ColourMap = &'static [Rgb];

/// Viridis (van der Walt and Smith 2015, CC0), every sixteenth of its range: dark blue over green to yellow.
pub(crate) const VIRIDIS: ColourMap = &[
    [68, 1, 84],
    [72, 24, 106],
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];

/// Pale rose to dark red: lightness falls evenly, and no colour of [`VIRIDIS`] is in it.
pub(crate) const REDS: ColourMap = &[
    [250, 200, 180],
    [250, 160, 132],
    [246, 118, 88],
    [230, 72, 56],
    [196, 32, 38],
    [150, 12, 28],
    [96, 0, 16],
];

/// Colour of what is no number.
pub(crate) const BROKEN: Rgb = [255, 0, 255];

/// Colour of `fraction`, held at the ends; [`BROKEN`] for what is no number.
pub(crate) fn colour(map: ColourMap, fraction: f64) -> Rgb {
    if fraction.is_nan() {
        return BROKEN;
    }
    let place = fraction.clamp(0.0, 1.0) * (map.len() - 1) as f64;
    let index = (place as usize).min(map.len() - 2);
    let part = place - index as f64;
    let mix = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * part).round() as u8;
    let (a, b) = (map[index], map[index + 1]);
    [mix(a[0], b[0]), mix(a[1], b[1]), mix(a[2], b[2])]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance up to its gamma, enough for an order.
    fn lightness(c: Rgb) -> f64 {
        0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2])
    }

    #[test]
    fn maps_are_ordered_by_lightness() {
        for step in 0..100 {
            let (a, b) = (f64::from(step) / 100.0, f64::from(step + 1) / 100.0);
            assert!(lightness(colour(VIRIDIS, a)) < lightness(colour(VIRIDIS, b)) + 1.0);
            assert!(lightness(colour(REDS, a)) > lightness(colour(REDS, b)) - 1.0);
        }
        assert_eq!(colour(VIRIDIS, -3.0), VIRIDIS[0]);
        assert_eq!(colour(VIRIDIS, 1.0), VIRIDIS[16]);
        assert_eq!(colour(REDS, f64::NAN), BROKEN);
    }
}
