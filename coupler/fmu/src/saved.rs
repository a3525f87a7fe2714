//! The bytes of a unit's state in an envelope: units need not look at what they are given, and read past the
//! end of what is cut short.

use words::bytes::{Error, Reader, Writer};

/// Starts every saved state: what it is, and the version of the envelope.
const MAGIC: &[u8; 8] = b"mnscenv2";

/// The envelope of a unit's state: the unit's token, the times (s) of the snapshots so far, and the state.
pub fn seal(token: &str, times: &[f64], state: &[u8]) -> Vec<u8> {
    let mut sealed = Writer::new(MAGIC);
    sealed.text(token);
    sealed.f64s(times);
    sealed.bytes(state);
    sealed.finish()
}

/// The times of snapshots and the state in an envelope.
///
/// # Errors
/// An envelope that is not whole, or of another unit than the one with that token.
pub fn open<'a>(token: &str, sealed: &'a [u8]) -> Result<(Vec<f64>, &'a [u8]), Error> {
    let mut sealed = Reader::new("unit's saved state", MAGIC, sealed)?;
    let of = sealed.text("token")?;
    if of != token {
        return Err(sealed.refuse("token", of));
    }
    let opened = (sealed.f64s("times of snapshots", None)?, sealed.bytes("state")?);
    sealed.finish()?;
    Ok(opened)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_opens_whole_and_for_its_unit_alone() {
        let sealed = seal("mine", &[0.5], &[1, 2, 3]);
        assert_eq!(open("mine", &sealed), Ok((vec![0.5], [1, 2, 3].as_slice())));
        assert!(open("yours", &sealed).is_err());
        for length in 0..sealed.len() {
            assert!(open("mine", &sealed[..length]).is_err(), "{length}");
        }
        assert!(open("mine", &[&sealed[..], &[0]].concat()).is_err());
        // A length that no memory has.
        let mut long = sealed.clone();
        long[8..16].fill(0xff);
        assert!(open("mine", &long).is_err());
    }
}
