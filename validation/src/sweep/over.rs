//! Keys with several values, and their combinations.

use super::MOST;

/// A key of the case and the values that it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Over {
    /// The key: `structure.material.youngs_modulus`.
    pub key: String,
    /// Its values, as the case file has them.
    pub values: Vec<String>,
}

impl std::str::FromStr for Over {
    type Err = String;

    /// `key=value,value,…`; a comma inside of brackets, braces or quotes belongs to a value.
    fn from_str(text: &str) -> Result<Self, String> {
        let (key, values) = text.split_once('=').ok_or("write KEY=VALUE,VALUE,…")?;
        let (key, values) = (key.trim().to_owned(), split(values));
        if key.is_empty() || values.iter().any(String::is_empty) {
            return Err("a key or a value is empty; write KEY=VALUE,VALUE,…".to_owned());
        }
        match (1..values.len()).find(|&i| values[..i].contains(&values[i])) {
            Some(twice) => Err(format!("{} is there twice", values[twice])),
            None => Ok(Self { key, values }),
        }
    }
}

fn split(text: &str) -> Vec<String> {
    let (mut values, mut depth, mut quote) = (vec![String::new()], 0_usize, None);
    for c in text.chars() {
        match (c, quote) {
            (',', None) if depth == 0 => {
                values.push(String::new());
                continue;
            }
            ('"' | '\'', None) => quote = Some(c),
            (c, Some(open)) if c == open => quote = None,
            ('[' | '{', None) => depth += 1,
            (']' | '}', None) => depth = depth.saturating_sub(1),
            _ => {}
        }
        values.last_mut().expect("there is one from the start").push(c);
    }
    values.iter().map(|value| value.trim().to_owned()).collect()
}

/// The keys of a sweep.
#[derive(Clone, Debug)]
pub struct Overs(Vec<Over>);

impl Overs {
    /// Of these keys.
    ///
    /// # Errors
    /// A key that is there twice, more than [`MOST`] members; in words.
    pub fn new(overs: Vec<Over>) -> Result<Self, String> {
        if let Some(twice) = (1..overs.len()).find(|&i| overs[..i].iter().any(|o| o.key == overs[i].key)) {
            return Err(format!("--over {}: the key is there twice; list all values once", overs[twice].key));
        }
        let count = overs.iter().try_fold(1_usize, |count, over| count.checked_mul(over.values.len()));
        match count {
            Some(count) if count <= MOST => Ok(Self(overs)),
            _ => Err(format!("--over makes more than {MOST} members; take fewer values")),
        }
    }

    /// The keys.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|over| over.key.as_str())
    }

    /// Every combination of values; the last key's change first.
    pub fn combinations(&self) -> Vec<Vec<String>> {
        self.0.iter().fold(vec![Vec::new()], |before, over| {
            let with = |values: &Vec<String>| {
                let values = values.clone();
                over.values.iter().map(move |value| [values.as_slice(), std::slice::from_ref(value)].concat())
            };
            before.iter().flat_map(with).collect()
        })
    }

    /// The overrides that make a member of its values.
    pub fn overrides(&self, values: &[String]) -> Vec<String> {
        self.keys().zip(values).map(|(key, value)| format!("{key}={value}")).collect()
    }

    /// A member in words, its keys as short as they are different: `youngs_modulus = 1e6, scheme = …`.
    pub fn label(&self, values: &[String]) -> String {
        let words: Vec<String> =
            self.keys().zip(values).map(|(key, value)| format!("{} = {value}", self.short(key))).collect();
        words.join(", ")
    }

    /// The name of a member's folder, of letters that are safe in a path, and short; what is left out of it
    /// is in a number made of all.
    pub fn folder(&self, values: &[String]) -> String {
        const LONGEST: usize = 80;
        let safe = |c: char| if c.is_ascii_alphanumeric() || "+-.".contains(c) { c } else { '_' };
        let words: Vec<String> =
            self.keys().zip(values).map(|(key, value)| format!("{}-{value}", self.short(key))).collect();
        let whole = words.join("_");
        let name: String =
            whole.chars().map(safe).collect::<String>().trim_start_matches(['.', '-']).to_owned();
        if name == whole && name.len() <= LONGEST {
            return name;
        }
        let all = self.overrides(values).join("\n");
        // FNV-1a: the same in every build.
        let hash = all.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        let name: String = name.chars().take(LONGEST - 9).collect();
        format!("{name}-{:08x}", hash >> 32)
    }

    /// The last word of a key, or the whole key where another has the same one.
    fn short<'a>(&self, key: &'a str) -> &'a str {
        let last = |key: &'a str| key.rsplit('.').next().unwrap_or(key);
        let same = self.0.iter().filter(|over| over.key.rsplit('.').next() == Some(last(key))).count();
        if same > 1 { key } else { last(key) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Over, Overs};

    fn overs(of: &[&str]) -> Result<Overs, String> {
        Overs::new(of.iter().map(|text| text.parse()).collect::<Result<_, _>>()?)
    }

    #[test]
    fn commas_inside_of_a_value_belong_to_it() {
        let over: Over = "a.b = [1, 2], {c = 3, d = 'x,y'},\"p,q\", 1e6".parse().unwrap();
        assert_eq!(over.key, "a.b");
        assert_eq!(over.values, ["[1, 2]", "{c = 3, d = 'x,y'}", "\"p,q\"", "1e6"]);
        for wrong in ["a", "a=", "a=1,,2", "=1", "a=1,2,1"] {
            assert!(wrong.parse::<Over>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn every_combination_is_a_member_with_a_folder_of_its_own() {
        let overs = overs(&["s.e=1e6,2e6", "t.e=[1]", "x.gap=0.5,0.25"]).unwrap();
        let all = overs.combinations();
        assert_eq!(all.len(), 4);
        assert_eq!(all[1], ["1e6", "[1]", "0.25"]);
        assert_eq!(overs.overrides(&all[1]), ["s.e=1e6", "t.e=[1]", "x.gap=0.25"]);
        // Two keys end alike, so both are written out.
        assert_eq!(overs.label(&all[1]), "s.e = 1e6, t.e = [1], gap = 0.25");
        let folders: std::collections::BTreeSet<_> = all.iter().map(|values| overs.folder(values)).collect();
        assert_eq!(folders.len(), 4);
        assert!(folders.iter().all(|f| f.starts_with("s.e-") && !f.contains(['[', '/'])), "{folders:?}");
        let plain = Overs::new(vec!["a.e=../../x,y".parse().unwrap()]).unwrap();
        assert!(plain.folder(&["../../x".to_owned()]).starts_with("e-.._.._x-"));
        assert_eq!(plain.folder(&["y".to_owned()]), "e-y");
    }

    #[test]
    fn a_key_twice_and_too_many_members_are_refused() {
        assert!(overs(&["a=1,2", "a=3"]).is_err());
        let forty: Vec<String> = (0..40).map(|i| i.to_string()).collect();
        let many = format!("={}", forty.join(","));
        assert!(overs(&[&format!("a{many}"), &format!("b{many}")]).is_err());
    }
}
