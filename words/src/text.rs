//! Words from outside (a participant, a unit, a log, a file in a folder), before people read them.

/// Characters of an explanation that a terminal or a page is given at most.
pub const EXPLANATION: usize = 4000;
/// Characters of a name at most.
pub const NAME: usize = 200;

/// The text on lines of its own, without what steers a terminal or turns the reading direction, and with at
/// most so many characters; how many more there are is told.
pub fn tame(text: &str, most: usize) -> String {
    let mut tamed: String = text.chars().take(most).map(|c| if steers(c) { '\u{fffd}' } else { c }).collect();
    let left = text.chars().skip(most).count();
    if left > 0 {
        tamed.push_str(&format!(" … ({left} more characters)"));
    }
    tamed
}

/// Whether this may be the name of something: what a table's header and a terminal show on one line.
pub fn is_name(text: &str) -> bool {
    !text.is_empty()
        && text.chars().count() <= NAME
        && !text.chars().any(|c| steers(c) || c == '\n' || c == '\t')
}

/// Control characters but the ends of lines and tabulators, and those that order bidirectional text.
fn steers(c: char) -> bool {
    let orders = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    orders || (c.is_control() && c != '\n' && c != '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_steers_a_terminal_and_nothing_is_endless() {
        for (text, tamed) in [
            ("plain, with ü and\nlines\tand tabs", "plain, with ü and\nlines\tand tabs"),
            ("\u{1b}[2J\u{1b}]0;title\u{7}", "\u{fffd}[2J\u{fffd}]0;title\u{fffd}"),
            ("a\0b\u{9b}c\r\u{202e}d", "a\u{fffd}b\u{fffd}c\u{fffd}\u{fffd}d"),
            (
                "0123456789012345678901234567890123456789X",
                "0123456789012345678901234567890123456789 … (1 more characters)",
            ),
        ] {
            assert_eq!(tame(text, 40), tamed);
        }
        assert!(is_name("wall.force_x") && !is_name("") && !is_name("a\nb") && !is_name(&"x".repeat(201)));
    }
}
