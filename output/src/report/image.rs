//! A small canvas of RGB pixels: discs, rectangles, text, PNG.

use super::letters;

/// Red, green and blue.
pub(crate) type Rgb = [u8; 3];

pub(crate) struct Image {
    pub width: usize,
    pub height: usize,
    /// Three bytes a pixel, row by row from the top.
    pub pixels: Vec<u8>,
}

impl Image {
    pub fn new(width: usize, height: usize, background: Rgb) -> Self {
        Self { width, height, pixels: background.repeat(width * height) }
    }

    /// Mixes `colour` over the pixel by `coverage` (0 to 1).
    fn blend(&mut self, x: usize, y: usize, colour: Rgb, coverage: f64) {
        let pixel = &mut self.pixels[3 * (y * self.width + x)..][..3];
        for (old, new) in pixel.iter_mut().zip(colour) {
            *old = (f64::from(*old) + (f64::from(new) - f64::from(*old)) * coverage).round() as u8;
        }
    }

    /// A disc with soft edges, cut to `clip`.
    pub fn disc(&mut self, (x, y): (f64, f64), radius: f64, colour: Rgb, clip: Rectangle) {
        let reach = radius + 0.5;
        let columns = span(x - reach, x + reach, clip.left, clip.right);
        for row in span(y - reach, y + reach, clip.top, clip.bottom) {
            for column in columns.clone() {
                // Pixel centres lie at half numbers; the edge falls off over one pixel.
                let distance = (column as f64 + 0.5 - x).hypot(row as f64 + 0.5 - y);
                let coverage = (reach - distance).clamp(0.0, 1.0);
                if coverage > 0.0 {
                    self.blend(column, row, colour, coverage);
                }
            }
        }
    }

    pub fn fill(&mut self, area: Rectangle, colour: Rgb) {
        for y in area.top..area.bottom.min(self.height) {
            for x in area.left..area.right.min(self.width) {
                self.blend(x, y, colour, 1.0);
            }
        }
    }

    /// The frame one pixel wide just outside `area`.
    pub fn outline(&mut self, area: Rectangle, colour: Rgb) {
        let Rectangle { left, top, right, bottom } = area;
        self.fill(Rectangle { left: left - 1, top: top - 1, right: right + 1, bottom: top }, colour);
        self.fill(Rectangle { left: left - 1, top: bottom, right: right + 1, bottom: bottom + 1 }, colour);
        self.fill(Rectangle { left: left - 1, top, right: left, bottom }, colour);
        self.fill(Rectangle { left: right, top, right: right + 1, bottom }, colour);
    }

    /// A line of text from the column `left` on, its capitals about the row `middle`; `size` pixels are from
    /// the top of its tallest letters to the foot of its lowest.
    pub fn text(&mut self, text: &str, left: f32, middle: f32, size: f32, colour: Rgb) {
        let (width, height) = (self.width as i32, self.height as i32);
        letters::draw(text, left, middle, size, |x, y, coverage| {
            if (0..width).contains(&x) && (0..height).contains(&y) {
                self.blend(x as usize, y as usize, colour, f64::from(coverage.min(1.0)));
            }
        });
    }

    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(&self.pixels))
            .expect("a picture with a pixel for every place is written to memory, which cannot fail");
        bytes
    }
}

/// Pixels `left..right` by `top..bottom`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rectangle {
    pub left: usize,
    pub top: usize,
    pub right: usize,
    pub bottom: usize,
}

/// The pixels from `low` to `high` within `first..end`.
fn span(low: f64, high: f64, first: usize, end: usize) -> std::ops::Range<usize> {
    // A cast saturates, so that far outside becomes an empty span at the edge.
    let start = (low.floor().max(0.0) as usize).clamp(first, end);
    start..(high.ceil().max(0.0) as usize).clamp(start, end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_covers_its_area_and_nothing_outside_the_clip() {
        let mut image = Image::new(40, 40, [0; 3]);
        let all = Rectangle { left: 0, top: 0, right: 40, bottom: 40 };
        image.disc((20.0, 20.0), 10.0, [255; 3], all);
        let covered: f64 = image.pixels.iter().step_by(3).map(|&v| f64::from(v) / 255.0).sum();
        // The soft edge integrates to the area up to the curvature of the edge within one pixel: below 1 %
        // here.
        assert!((covered / (std::f64::consts::PI * 100.0) - 1.0).abs() < 0.01, "{covered}");
        let mut clipped = Image::new(40, 40, [0; 3]);
        clipped.disc((20.0, 20.0), 10.0, [255; 3], Rectangle { left: 20, ..all });
        assert!((0..40).all(|y| (0..20).all(|x| clipped.pixels[3 * (y * 40 + x)] == 0)));
        // Far outside and not finite: nothing happens.
        clipped.disc((-1e12, 1e300), 10.0, [255; 3], all);
    }
}
