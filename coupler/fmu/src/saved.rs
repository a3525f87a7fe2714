//! The bytes of a unit's state in an envelope: units need not look at what they are given, and read past the
//! end of what is cut short.

/// Starts every saved state: what it is, and the version of the envelope.
const MAGIC: &[u8; 8] = b"mnscfmu1";

/// The envelope of a unit's state: magic, length and text of the unit's token, length and bytes of the state.
pub fn seal(token: &str, state: &[u8]) -> Vec<u8> {
    let mut sealed = MAGIC.to_vec();
    for part in [token.as_bytes(), state] {
        sealed.extend((part.len() as u64).to_le_bytes());
        sealed.extend(part);
    }
    sealed
}

/// The state in an envelope; none where it is not whole, or not of the unit with that token.
pub fn open<'a>(token: &str, sealed: &'a [u8]) -> Option<&'a [u8]> {
    let rest = sealed.strip_prefix(MAGIC)?;
    let (of, rest) = part(rest)?;
    let (state, rest) = part(rest)?;
    (of == token.as_bytes() && rest.is_empty()).then_some(state)
}

fn part(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<8>()?;
    rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_opens_whole_and_for_its_unit_alone() {
        let sealed = seal("mine", &[1, 2, 3]);
        assert_eq!(open("mine", &sealed), Some([1, 2, 3].as_slice()));
        assert_eq!(open("yours", &sealed), None);
        for length in 0..sealed.len() {
            assert_eq!(open("mine", &sealed[..length]), None, "{length}");
        }
        assert_eq!(open("mine", &[&sealed[..], &[0]].concat()), None);
        // A length that no memory has.
        let mut long = sealed.clone();
        long[8..16].fill(0xff);
        assert_eq!(open("mine", &long), None);
    }
}
