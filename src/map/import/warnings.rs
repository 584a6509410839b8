//! Messages of netconvert, counted by kind. In: its output. Out: kinds of warnings, or of errors that it ignored, each with count and one
//! example, the most frequent first.

/// Warnings, or errors, of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WarningKind {
    /// Number of messages of this kind.
    pub count: usize,
    /// One of the messages, verbatim.
    pub example: String,
}

/// Text by which netconvert marks a line that summarises many messages of a kind.
const TOTAL: &str = " total messages of type:";

/// Prefix of netconvert's warnings.
pub(super) const WARNING: &str = "Warning:";
/// Prefix of netconvert's errors.
pub(super) const ERROR: &str = "Error:";

/// Counts the lines that start with `begin` by kind: lines that differ only in names and numbers are one kind.
pub(super) fn count(words: &str, begin: &str) -> Vec<WarningKind> {
    let mut kinds: Vec<(String, WarningKind)> = Vec::new();
    for line in words.lines().filter_map(|line| line.strip_prefix(begin)).map(str::trim) {
        // After a few messages of a kind netconvert writes their total, with % in place of names and numbers.
        if let Some((total, pattern)) = line.split_once(TOTAL) {
            let total = total.parse().unwrap_or(1);
            let pattern = pattern.trim();
            match kinds.iter_mut().find(|(_, kind)| fits(pattern, &kind.example)) {
                Some((_, kind)) => kind.count = kind.count.max(total),
                None => kinds.push((pattern.to_owned(), WarningKind { count: total, example: pattern.to_owned() })),
            }
            continue;
        }
        let key = without_names(line);
        match kinds.iter_mut().find(|(known, _)| *known == key) {
            Some((_, kind)) => kind.count += 1,
            None => kinds.push((key, WarningKind { count: 1, example: line.to_owned() })),
        }
    }
    let mut kinds: Vec<WarningKind> = kinds.into_iter().map(|(_, kind)| kind).collect();
    kinds.sort_by_key(|kind| std::cmp::Reverse(kind.count));
    kinds
}

/// Returns a warning without the parts that vary within its kind: quoted names, and words with a digit.
fn without_names(line: &str) -> String {
    let outside = line.split('\'').step_by(2).collect::<Vec<_>>().join("'");
    let words =
        outside.split_whitespace().map(|word| if word.contains(|c: char| c.is_ascii_digit()) { "%" } else { word });
    words.collect::<Vec<_>>().join(" ")
}

/// Returns true if a text matches the pattern with any text in place of each %.
fn fits(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('%');
    let Some(mut rest) = parts.next().and_then(|first| text.strip_prefix(first)) else { return false };
    for part in parts {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_that_differ_in_names_and_numbers_are_one_kind() {
        // Output of netconvert 1.28.
        let words = "proj_create: Error -38\nWarning: Edge '-1' has a grade of 12.5%.\nWarning: Edge '7#1' has a grade of 101%.\n\
                     Warning: Edge '3' has no lanes.\nWarning: 25 total messages of type: Edge '%' has a grade of %%.\n\
                     Warning: 4 total messages of type: Never '%' seen.\nSuccess.\n";
        let kinds: Vec<(usize, String)> =
            count(words, WARNING).into_iter().map(|kind| (kind.count, kind.example)).collect();
        let expected = [(25, "Edge '-1' has a grade of 12.5%."), (4, "Never '%' seen."), (1, "Edge '3' has no lanes.")];
        assert_eq!(kinds, expected.map(|(n, text)| (n, text.to_owned())));
        assert_eq!(count("Error: no road '1'\nWarning: x\nError: no road '2'", ERROR)[0].count, 2);
    }
}
