//! "Did you mean …?"

/// The candidate that a slip of the pen may have turned into `word`: at most one edit (a letter added, lost,
/// changed, or two neighbours swapped) for every three letters, or the one that begins with the word (three
/// letters and more). `-`, `_` and case do not count.
pub(super) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |word: &str| word.replace(['-', '_', ' '], "").to_lowercase();
    let word = plain(word);
    let length = word.chars().count();
    let limit = (length / 3).max(1);
    candidates
        .into_iter()
        .filter_map(|candidate| {
            let other = plain(candidate);
            let edits = strsim::osa_distance(&word, &other);
            let begins = length >= 3 && other.starts_with(&word);
            (edits <= limit || begins).then_some((if begins { edits.min(limit) } else { edits }, candidate))
        })
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
}

/// "did you mean", or what there is.
pub(super) fn remedy_for_name(name: &str, known: &[&str], section: &str) -> String {
    match (nearest(name, known.iter().copied()), known) {
        (Some(meant), _) => format!("did you mean \"{meant}\"?"),
        (None, []) => format!("add a {section} of that name"),
        (None, known) => {
            let known: Vec<_> = known.iter().map(|name| format!("\"{name}\"")).collect();
            format!("there is {}", known.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_found_and_the_far_is_not() {
        let keys = ["density", "kinematic_viscosity", "domain"];
        assert_eq!(nearest("densty", keys), Some("density"));
        assert_eq!(nearest("dnesity", keys), Some("density"));
        assert_eq!(nearest("Kinematic-Viscosity", keys), Some("kinematic_viscosity"));
        assert_eq!(nearest("dom", keys), Some("domain"));
        assert_eq!(nearest("temperature", keys), None);
    }
}
