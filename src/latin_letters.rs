//! Letters of Latin alphabets, as names of streets and places have them. In: a text. Out: its letters as base letters A to Z, a to z and ß with
//! their accents, or the answer that the text has letters of another script.

/// Mark above, below or through a base letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accent {
    Acute,
    Grave,
    Circumflex,
    Caron,
    Tilde,
    Diaeresis,
    Ring,
    Breve,
    Macron,
    DotAbove,
    DoubleAcute,
    /// Cedilla, ogonek or comma below.
    Below,
    /// Bar through the letter: ø, đ, ł.
    Stroke,
}

/// Accents with the letters that have them, their base letters in the same order, and the combining characters of Unicode.
const ACCENTED: [(Accent, &str, &str, &str); 13] = [
    (Accent::Acute, "ÁÉÍÓÚÝĆĹŃŔŚŹáéíóúýćĺńŕśź", "AEIOUYCLNRSZaeiouyclnrsz", "\u{301}"),
    (Accent::Grave, "ÀÈÌÒÙẀỲàèìòùẁỳ", "AEIOUWYaeiouwy", "\u{300}"),
    (Accent::Circumflex, "ÂÊÎÔÛĈĜĤĴŜŴŶâêîôûĉĝĥĵŝŵŷ", "AEIOUCGHJSWYaeioucghjswy", "\u{302}"),
    (Accent::Caron, "ČĎĚŇŘŠŤŽǍčďěľňřšťžǎĽ", "CDENRSTZAcdelnrstzaL", "\u{30c}"),
    (Accent::Tilde, "ÃÑÕĨŨãñõĩũ", "ANOIUanoiu", "\u{303}"),
    (Accent::Diaeresis, "ÄËÏÖÜŸäëïöüÿ", "AEIOUYaeiouy", "\u{308}"),
    (Accent::Ring, "ÅŮåů", "AUau", "\u{30a}"),
    (Accent::Breve, "ĂĔĞĬŎŬăĕğĭŏŭ", "AEGIOUaegiou", "\u{306}"),
    (Accent::Macron, "ĀĒĪŌŪāēīōū", "AEIOUaeiou", "\u{304}"),
    (Accent::DotAbove, "ĊĖĠİŻċėġż", "CEGIZcegz", "\u{307}"),
    (Accent::DoubleAcute, "ŐŰőű", "OUou", "\u{30b}"),
    (Accent::Below, "ÇĢĶĻŅŖŞŢĄĘĮŲȘȚçģķļņŗşţąęįųșț", "CGKLNRSTAEIUSTcgklnrstaeiust", "\u{326}\u{327}\u{328}"),
    (Accent::Stroke, "ØĐŁĦÐøđłħ", "ODLHDodlh", "\u{335}\u{337}\u{338}"),
];

/// Letters that are set as others, without an accent.
const REPLACED: [(char, &str); 10] = [
    ('Æ', "AE"),
    ('æ', "ae"),
    ('Œ', "OE"),
    ('œ', "oe"),
    ('Þ', "Th"),
    ('þ', "th"),
    ('ð', "d"),
    ('ı', "i"),
    ('ŋ', "ng"),
    ('ẞ', "ß"),
];

/// Part of a text: a character, and its accent if it is a letter with one.
pub type Letter = (char, Option<Accent>);

/// Returns the letters of a text by base letter and accent. Characters that are no letters of a Latin alphabet stay as they are; of several
/// accents a letter has the first.
pub fn decomposed(text: &str) -> Vec<Letter> {
    let mut letters: Vec<Letter> = Vec::new();
    for sign in text.chars() {
        if let Some((accent, ..)) = ACCENTED.iter().find(|(.., combining)| combining.contains(sign)) {
            if let Some((_, accent_before @ None)) = letters.last_mut() {
                *accent_before = Some(*accent);
            }
            continue;
        }
        let with_accent = ACCENTED.iter().find_map(|(accent, composed, bases, _)| {
            let place = composed.chars().position(|one| one == sign)?;
            Some((bases.chars().nth(place)?, Some(*accent)))
        });
        match (with_accent, REPLACED.iter().find(|(one, _)| *one == sign)) {
            (Some(letter), _) => letters.push(letter),
            (None, Some((_, others))) => letters.extend(others.chars().map(|other| (other, None))),
            (None, None) => letters.push((sign, None)),
        }
    }
    letters
}

/// Checks whether all letters and digits of a text are those of a Latin alphabet and 0 to 9, and there is one at all.
pub fn is_latin(text: &str) -> bool {
    let letters = decomposed(text);
    let is_letter = |(base, _): &&Letter| base.is_alphanumeric();
    letters.iter().any(|letter| is_letter(&letter))
        && letters.iter().filter(is_letter).all(|(base, _)| base.is_ascii_alphanumeric() || *base == 'ß')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_accented_letter_has_one_base_letter() {
        for (accent, composed, bases, _) in ACCENTED {
            assert_eq!(composed.chars().count(), bases.chars().count(), "{accent:?}");
            for (letter, base) in composed.chars().zip(bases.chars()) {
                assert_eq!(letter.is_uppercase(), base.is_uppercase(), "{letter} {base}");
                assert_eq!(decomposed(&letter.to_string()), [(base, Some(accent))]);
            }
        }
    }

    #[test]
    fn names_in_latin_letters_are_told_from_others() {
        for name in
            ["Sonnenallee", "Rue de l'Église", "Łódzka 7", "Straße des 17. Juni", "A\u{308}ndern", "Bjørnvej", "Ærø"]
        {
            assert!(is_latin(name), "{name}");
        }
        for name in ["中山路", "Невский проспект", "Main Street 中", "- / .", "", "شارع"] {
            assert!(!is_latin(name), "{name}");
        }
        assert_eq!(decomposed("A\u{308}"), decomposed("Ä"));
    }
}
