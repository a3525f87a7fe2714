//! Letters inside pictures: DejaVu Sans, drawn by ab_glyph.

use ab_glyph::{Font as _, FontRef, GlyphId, PxScale, ScaleFont as _, point};
use std::sync::LazyLock;

static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    FontRef::try_from_slice(include_bytes!("../../assets/dejavu/DejaVuSans-subset.ttf"))
        .expect("the embedded file is a font")
});

/// Half the height of a capital over a line's height (ascender to descender): 0.729 em of 1.164 em in DejaVu
/// Sans.
const HALF_CAPITAL: f32 = 0.313;

/// Width of `text` in pixels, for lines of `size` pixels.
pub(crate) fn width(text: &str, size: f32) -> f32 {
    text.chars().map(|letter| FONT.as_scaled(size).h_advance(glyph(letter))).sum()
}

/// Calls `dot` with column, row and coverage (0 to 1) of each pixel of `text`, which starts at the column
/// `left`; `middle` is the row at half the height of its capitals.
pub(crate) fn draw(text: &str, left: f32, middle: f32, size: f32, mut dot: impl FnMut(i32, i32, f32)) {
    let mut pen = left;
    for letter in text.chars() {
        let glyph = glyph(letter);
        let placed =
            glyph.with_scale_and_position(PxScale::from(size), point(pen, middle + HALF_CAPITAL * size));
        if let Some(outline) = FONT.outline_glyph(placed) {
            let corner = outline.px_bounds().min;
            outline
                .draw(|x, y, coverage| dot(corner.x as i32 + x as i32, corner.y as i32 + y as i32, coverage));
        }
        pen += FONT.as_scaled(size).h_advance(glyph);
    }
}

/// A box for a letter that the font has not.
fn glyph(letter: char) -> GlyphId {
    FONT.glyph_id(letter)
}
