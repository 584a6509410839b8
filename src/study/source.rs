//! The copy of a study file that its data set keeps. In: the file as its author wrote it. Out: the same text without the folders of
//! absolute paths: they reveal the author and exist on no other machine.

use crate::record::inputs;
use toml::{Spanned, de::DeValue};

/// Returns the text with each absolute path replaced by its last part. Text that is not TOML stays unchanged.
pub fn portable(text: &str) -> String {
    let Ok(document) = toml::de::DeTable::parse(text) else { return text.into() };
    let mut places = Vec::new();
    document.get_ref().values().for_each(|value| absolute(value, &mut places));
    places.sort_by_key(|(start, ..)| *start);
    let (mut out, mut at) = (String::new(), 0);
    for (start, end, name) in places {
        out += &text[at..start];
        out += &toml::Value::String(name).to_string();
        at = end;
    }
    out + &text[at..]
}

/// Returns true if two files are of one study. They may differ only in the plan of the analysis, of which a data set keeps both versions.
pub fn is_same_study(was: &str, now: &str) -> bool {
    let (was, now) = (portable(was), portable(now));
    let rest = |text: &str| -> Option<toml::Table> {
        let mut table: toml::Table = text.parse().ok()?;
        table.remove("analysis");
        Some(table)
    };
    // Without a plan of the analysis, the texts must be identical.
    let has_plan = |text: &str| text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("analysis"));
    was == now || ((has_plan(&was) || has_plan(&now)) && rest(&was).is_some() && rest(&was) == rest(&now))
}

/// Collects start, end and last part of absolute paths.
fn absolute(value: &Spanned<DeValue>, places: &mut Vec<(usize, usize, String)>) {
    match value.get_ref() {
        DeValue::String(text) => {
            let drive = text.as_bytes().get(1..3).is_some_and(|two| two == b":\\" || two == b":/");
            let one_line = !text.trim_end().contains('\n');
            if one_line && (text.starts_with('/') || text.starts_with("~/") || text.starts_with("\\\\") || drive) {
                places.push((value.span().start, value.span().end, inputs::last(text).to_owned()));
            }
        }
        DeValue::Array(list) => list.iter().for_each(|value| absolute(value, places)),
        DeValue::Table(table) => table.values().for_each(|value| absolute(value, places)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_absolute_paths_lose_their_folders() {
        let text = "title = \"a / b\"  # /home/ann\nfont = \"/home/ann/fonts/big.ttf\"\n[base]\nmap = '~/maps/ring/'\n\
                    policy = \"policies/calm.onnx\"\n[factors]\nway = [{ name = \"x\", set = { map = \"C:\\\\maps\\\\x.xml\" } }]\n\
                    [[segment]]\ntext = \"\"\"\n/ is read as or.\nTwo lines.\"\"\"\n";
        let kept = "title = \"a / b\"  # /home/ann\nfont = \"big.ttf\"\n[base]\nmap = \"ring\"\n\
                    policy = \"policies/calm.onnx\"\n[factors]\nway = [{ name = \"x\", set = { map = \"x.xml\" } }]\n\
                    [[segment]]\ntext = \"\"\"\n/ is read as or.\nTwo lines.\"\"\"\n";
        assert_eq!(portable(text), kept);
        assert_eq!(portable(kept), kept);
        assert_eq!(portable("no = toml = /home"), "no = toml = /home");
    }

    #[test]
    fn files_of_one_study_may_differ_only_in_the_plan_of_the_analysis() {
        let study = "title = \"a\"\nseed = 1\n";
        let plan = |effect: &str| format!("{study}[analysis]\nsmallest_effect = {effect}\n");
        assert!(
            is_same_study(study, study) && is_same_study(&plan("1"), &plan("2")) && is_same_study(study, &plan("1"))
        );
        for other in
            ["title = \"a\"\nseed = 2\n".to_owned(), plan("1").replace("seed = 1", "seed = 2"), format!("{study}# x")]
        {
            assert!(!is_same_study(study, &other), "{other}");
        }
    }

    #[test]
    fn absolute_paths_of_all_systems_are_recognised() {
        let kept = |path: &str| portable(&format!("a = [1, '{path}']\n"));
        for (path, name) in [
            ("/x/y.xml", "y.xml"),
            ("~/x/y.xml", "y.xml"),
            ("C:/x/y.xml", "y.xml"),
            ("d:\\x\\y.xml", "y.xml"),
            ("\\\\lab\\x\\y.xml", "y.xml"),
        ] {
            assert_eq!(kept(path), format!("a = [1, \"{name}\"]\n"), "{path}");
        }
        for other in ["x/y.xml", "C:y.xml", "~x/y.xml", "\\x\\y.xml", "12:30", ""] {
            assert_eq!(kept(other), format!("a = [1, '{other}']\n"), "{other}");
        }
    }
}
