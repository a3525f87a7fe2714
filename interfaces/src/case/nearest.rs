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
            let edits = edits(&word, &other);
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

/// Optimal string alignment distance.
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<_>, Vec<_>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for (i, row) in rows.iter_mut().enumerate() {
        row[0] = i;
    }
    rows[0] = (0..=b.len()).collect();
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let change = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = change.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = least;
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_of_the_pen_are_counted() {
        assert_eq!(edits("density", "density"), 0);
        assert_eq!(edits("densty", "density"), 1);
        assert_eq!(edits("dnesity", "density"), 1);
        assert_eq!(edits("", "abc"), 3);
    }

    #[test]
    fn the_nearest_is_found_and_the_far_is_not() {
        let keys = ["density", "kinematic_viscosity", "domain"];
        assert_eq!(nearest("densty", keys), Some("density"));
        assert_eq!(nearest("Kinematic-Viscosity", keys), Some("kinematic_viscosity"));
        assert_eq!(nearest("dom", keys), Some("domain"));
        assert_eq!(nearest("temperature", keys), None);
    }
}
