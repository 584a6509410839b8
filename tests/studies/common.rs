//! Helpers of the tests of rehearsed studies. In: lengths of the drives, and the last questionnaire. Out: the text of a small study, the
//! program's output, tables keyed by column name.

use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    process::{Command, Output},
};

/// Returns the text of a study on the native engine with a factor of three levels, a practice, and trials in every order. `last` names the
/// segment of the last questionnaire and the questionnaire.
pub fn study(duration_s: f64, practice_s: f64, last: [&str; 2]) -> String {
    let [name, questionnaire] = last;
    format!(
        r#"title = "Short"
participants = 6
seed = 7
[base]
traffic = "native"
warm_up_s = 5.0
duration_s = {duration_s:?}
hold_s = 2.0
[factors]
range = [{{ name = "narrow", set = {{ range_mph = 0.75 }} }}, {{ name = "middle" }}, {{ name = "wide", set = {{ range_mph = 2.0 }} }}]
[[segment]]
kind = "text"
name = "welcome"
text = "Hello"
[[segment]]
kind = "questions"
name = "ssq-before"
questionnaire = "ssq"
[[segment]]
kind = "drive"
name = "practice"
set = {{ duration_s = {practice_s:?}, policy = "constant", warm_up_s = 0.0 }}
until_in_range_s = 1.0
[[segment]]
kind = "trials"
name = "trial"
rest_s = 10.0
text = "Drive on the ring."
[[segment]]
kind = "questions"
name = "{name}"
questionnaire = "{questionnaire}"
"#
    )
}

/// Runs the program, logging from this level on.
pub fn codrive(arguments: &[&str], log: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_codrive")).args(arguments).env("RUST_LOG", log).output().unwrap()
}

/// Returns standard output and standard error of a program.
pub fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// Reads a table; rows are keyed by column name. Every row must have every cell, and a TSV must have no empty cell.
pub fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let separator = if path.extension().is_some_and(|e| e == "csv") { ',' } else { '\t' };
    let mut lines = text.lines().map(|line| line.split(separator).map(str::to_owned).collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let row = |cells: Vec<String>| {
        assert_eq!(cells.len(), head.len(), "{}: {cells:?}", path.display());
        assert!(separator == ',' || cells.iter().all(|cell| !cell.is_empty()), "{}: {cells:?}", path.display());
        head.iter().cloned().zip(cells).collect()
    };
    lines.map(row).collect()
}
