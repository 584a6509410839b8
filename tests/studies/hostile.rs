//! A study whose free texts are markup of every format that they are written into. `read_hostile.py` reads each file with a reader of its
//! format and finds the texts unchanged.

use super::{
    bids::root,
    common::{codrive, text},
};
use std::{collections::BTreeMap, fs, path::Path, process::Command};

/// Markup of HTML, SVG, Markdown, CSV, TSV and spreadsheet formulas, on one line.
const HOSTILE: &str =
    r#"=1+1,"q" <hostile onhostile="x">&amp;]]> *hostile* [hostile](http://x) `hostile` | שלום \ ${x}"#;

fn study() -> String {
    let one_line = toml::Value::String(HOSTILE.into());
    let lines = toml::Value::String(format!("{HOSTILE}\n\t# <hostile>\r\nsecond line\u{b}\u{2028}"));
    format!(
        r#"title = {one_line}
authors = [{one_line}, {one_line}]
licence = {one_line}
institution = {one_line}
participants = 2
[analysis]
primary = "mean_speed_mps"
smallest_effect = 0.1
contrasts = [{{ condition = "wide", reference = "narrow" }}]
[base]
traffic = "native"
warm_up_s = 0.0
duration_s = 4.0
[factors]
range = [{{ name = "narrow", set = {{ range_mph = 0.75 }} }}, {{ name = "wide" }}]
[[segment]]
kind = "text"
name = "welcome"
text = {lines}
[[segment]]
kind = "trials"
name = "trial"
text = {lines}
after = ["mine.json"]
stop_text = {one_line}
stop_above = {{ score = "mine.sum", value = 1000.0 }}
fms_every_s = 60.0
"#
    )
}

fn questionnaire() -> String {
    let lines = format!("{HOSTILE}\n\t<hostile>\r\u{b}\u{2028}\u{1b}[31m");
    let choice = |value: i32| serde_json::json!({ "value": value, "text": lines });
    serde_json::json!({
        "title": lines,
        "description": lines,
        "pages": [{ "name": "p", "elements": [
            { "type": "radiogroup", "name": "a", "title": lines, "description": lines, "choices": [choice(1), choice(2)] },
            { "type": "comment", "name": "b", "title": lines },
            { "type": "rating", "name": "c", "title": lines, "rateMin": 1, "rateMax": 5, "minRateDescription": lines },
        ] }],
        "scores": [{ "name": "sum", "method": "sum", "of": ["a", "c"] }],
    })
    .to_string()
}

/// Returns for each kind of file the number read, and the number that hold one of the texts.
fn read(folder: &Path) -> BTreeMap<String, [usize; 2]> {
    let script = root().join("tests/studies/read_hostile.py");
    let output = Command::new("python3").arg(script).arg(folder).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let printed = String::from_utf8(output.stdout).unwrap();
    let kind = |word: &str| {
        let [kind, all, held] = word.split(':').collect::<Vec<_>>()[..] else { panic!("{word}") };
        (kind.to_owned(), [all.parse().unwrap(), held.parse().unwrap()])
    };
    printed.split_whitespace().map(kind).collect()
}

/// Asserts that no file below the folder has `letters` in its name or its bytes, except the list of erased participants.
fn assert_nowhere(folder: &Path, letters: &str) {
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        assert!(!name.to_string_lossy().contains(letters), "{}", path.display());
        if path.is_dir() {
            assert_nowhere(&path, letters);
        } else if name != "erased.tsv" {
            let bytes = fs::read(&path).unwrap();
            let is_there = bytes.windows(letters.len()).any(|part| part == letters.as_bytes());
            assert!(!is_there, "{}", path.display());
        }
    }
}

#[test]
fn free_texts_stay_texts_in_every_file_that_holds_them() {
    let place = tempfile::tempdir().unwrap();
    let all = place.path().join("all");
    fs::create_dir(&all).unwrap();
    fs::write(all.join("mine.json"), questionnaire()).unwrap();
    fs::write(all.join("study.toml"), study()).unwrap();
    let [file, plan, data] = ["study.toml", "plan.md", "data"].map(|name| all.join(name).to_str().unwrap().to_owned());
    let reason = format!("{HOSTILE}\n\t<hostile>\u{1b}[31m");
    for arguments in [
        vec!["study", "preregister", &file, "--out", &plan],
        vec!["study", "rehearse", &file, "--participants", "3", "--out", &data],
        vec!["analyse", &data],
        vec!["study", "exclude", &file, "R01", "--reason", &reason, "--from", &data],
        vec!["study", "erase", &file, "R03", "--reason", &reason, "--from", &data],
        vec!["analyse", &data],
    ] {
        let output = codrive(&arguments, "warn");
        let printed = text(&output);
        assert!(output.status.success(), "{arguments:?}: {printed}");
        assert!(!printed.contains(|c: char| c.is_control() && c != '\n' && c != '\t'), "{printed:?}");
        if arguments.contains(&"erase") {
            assert_nowhere(Path::new(&data), "sub-R03");
        }
    }
    let read = read(&all);
    for kind in ["json", "tsv", "csv", "html", "svg", "md", "toml", "txt"] {
        assert!(read.contains_key(kind), "no {kind} was written: {read:?}");
    }
    for kind in ["json", "tsv", "html", "md", "toml"] {
        assert!(read[kind][1] > 0, "no {kind} holds a text: {read:?}");
    }
}
