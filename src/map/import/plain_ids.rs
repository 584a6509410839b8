//! Ids that SUMO can hold. In: the ids of an OpenDRIVE file. Out: ids of letters, digits and signs that SUMO takes, each the plain form of
//! one id of the file.

use std::collections::{BTreeMap, BTreeSet};

/// Attributes that hold an id, or refer to one.
const REFERENCES: [&str; 8] =
    ["id", "junction", "elementId", "incomingRoad", "connectingRoad", "linkedRoad", "mainRoad", "signalId"];
/// Letters with a usual spelling in ASCII.
const SPELLINGS: [(char, &str); 12] = [
    ('ä', "ae"),
    ('ö', "oe"),
    ('ü', "ue"),
    ('Ä', "Ae"),
    ('Ö', "Oe"),
    ('Ü', "Ue"),
    ('ß', "ss"),
    ('é', "e"),
    ('è', "e"),
    ('å', "a"),
    ('ø', "o"),
    ('ñ', "n"),
];
/// Number of renamed ids that the report lists.
const LISTED: usize = 10;

/// Plain forms of the ids that SUMO cannot hold.
pub(super) struct PlainIds {
    plain_of: BTreeMap<String, String>,
}

impl PlainIds {
    /// Finds a plain form, which no other id has, for each id that needs one.
    pub fn of(ids: Vec<String>) -> Self {
        let mut taken: BTreeSet<String> = ids.iter().cloned().collect();
        let mut plain_of = BTreeMap::new();
        for id in ids.into_iter().filter(|id| !is_plain(id)) {
            if plain_of.contains_key(&id) {
                continue;
            }
            let form = plain(&id);
            let numbered = (2..).map(|k| format!("{form}_{k}"));
            let free =
                std::iter::once(form.clone()).chain(numbered).find(|form| !taken.contains(form)).unwrap_or_default();
            taken.insert(free.clone());
            plain_of.insert(id, free);
        }
        Self { plain_of }
    }

    /// Returns the value of an attribute with a plain id in place of one that SUMO cannot hold.
    pub fn plain(&self, attribute: &str, value: String) -> String {
        let is_reference = !self.plain_of.is_empty() && REFERENCES.contains(&attribute);
        self.plain_of.get(&value).filter(|_| is_reference).cloned().unwrap_or(value)
    }

    /// Returns the lines for the report.
    pub fn notes(&self) -> Vec<String> {
        let n = self.plain_of.len();
        let first = (n > 0).then(|| format!("ids            {n} with spaces or other letters, renamed for SUMO:"));
        let listed = self.plain_of.iter().take(LISTED).map(|(id, plain)| format!("               \"{id}\" is {plain}"));
        let more = (n > LISTED).then(|| format!("               and {} more", n - LISTED));
        first.into_iter().chain(listed).chain(more).collect()
    }
}

/// Returns true for an id that netconvert and SUMO take.
fn is_plain(id: &str) -> bool {
    let is_bad = |c: char| !c.is_ascii_graphic() || "|\\'\";,<>&*?!".contains(c);
    !id.contains(is_bad) && !id.starts_with(':')
}

fn plain(id: &str) -> String {
    let spelling = |c: char| SPELLINGS.iter().find(|(of, _)| *of == c).map(|(_, text)| (*text).to_owned());
    let letter = |c: char| match c {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '.' | '#' => c.to_string(),
        _ => spelling(c).unwrap_or_else(|| "_".to_owned()),
    };
    id.chars().map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_with_spaces_and_umlauts_get_plain_forms_that_no_other_id_has() {
        let ids = ["Straße 1", "Strasse_1", "7", "a b", "a_b", "a\tb", ":x"].map(str::to_owned).to_vec();
        let ids = PlainIds::of(ids);
        let plain = |attribute: &str, id: &str| ids.plain(attribute, id.to_owned());
        assert_eq!(plain("elementId", "Straße 1"), "Strasse_1_2");
        assert_eq!((plain("id", "a b"), plain("junction", "a\tb")), ("a_b_2".into(), "a_b_3".into()));
        assert_eq!(
            (plain("id", "7"), plain("id", ":x"), plain("name", "a b")),
            ("7".into(), "_x".into(), "a b".into())
        );
        assert_eq!(ids.notes()[0], "ids            4 with spaces or other letters, renamed for SUMO:");
        assert!(ids.notes().contains(&"               \"Straße 1\" is Strasse_1_2".to_owned()));
    }
}
