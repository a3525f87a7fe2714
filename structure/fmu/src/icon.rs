//! The unit's icon: a plate of particles, bent.

/// Pixels along each side.
const SIZE: usize = 128;

/// The icon as PNG.
pub fn png() -> Vec<u8> {
    let mut pixels = vec![255_u8; 3 * SIZE * SIZE];
    let mut disc = |x: f64, y: f64, radius: f64, colour: [u8; 3]| {
        for row in 0..SIZE {
            for column in 0..SIZE {
                let (dx, dy) = (column as f64 + 0.5 - x, row as f64 + 0.5 - y);
                if dx * dx + dy * dy < radius * radius {
                    let at = 3 * (row * SIZE + column);
                    pixels[at..at + 3].copy_from_slice(&colour);
                }
            }
        }
    };
    for n in 0..10 {
        // Along the bent plate: a parabola, the layers along its normal.
        let s = f64::from(n) / 9.0;
        let (x, y, slope) = (16.0 + 88.0 * s, 36.0 + 48.0 * s * s, 96.0 / 88.0 * s);
        let length = (1.0 + slope * slope).sqrt();
        for layer in 0..3 {
            let across = 11.0 * (f64::from(layer) - 1.0);
            let blue = (90.0 + 130.0 * s) as u8;
            disc(x - across * slope / length, y + across / length, 4.8, [40, 70, blue]);
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIZE as u32, SIZE as u32);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("memory takes everything");
    writer.write_image_data(&pixels).expect("the image has the size said");
    writer.finish().expect("memory takes everything");
    bytes
}
