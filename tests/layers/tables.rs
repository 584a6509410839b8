//! Tables in Markdown that come from result files (`scripts/tables`): those of the repository are up to date, and a difference is named with
//! its file and line.

use super::root;
use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

/// Runs `scripts/tables` with these arguments.
fn tables(arguments: &[&str]) -> Output {
    Command::new("python3").arg(root().join("scripts/tables")).args(arguments).output().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn the_tables_of_all_documents_equal_their_result_files() {
    let output = tables(&["--check"]);
    assert!(output.status.success(), "{}", errors(&output));
}

/// Writes a page with one table of a result file. Returns its path and the folder to keep.
fn page(mark: &str) -> (String, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("results.csv");
    let rows = "road,policy,speed,speed_low,speed_high\nring,none,2.0,1.9,2.1\nring,pi,2.5,2.3,2.7\ncross,none,4,4,4\ncross,pi,3,3,3\n";
    fs::write(&csv, rows).unwrap();
    let page = folder.path().join("page.md");
    let text = format!("# Results\n\n<!-- table: {} {mark} -->\n<!-- end of table -->\n\nEnd.\n", csv.display());
    fs::write(&page, text).unwrap();
    (page.to_str().unwrap().to_owned(), folder)
}

/// Fills a page, and returns the lines of its table.
fn filled(mark: &str) -> Vec<String> {
    let (page, _folder) = page(mark);
    let output = tables(&[&page]);
    assert!(output.status.success(), "{}", errors(&output));
    let text = fs::read_to_string(Path::new(&page)).unwrap();
    assert!(text.ends_with("<!-- end of table -->\n\nEnd.\n"), "{text}");
    text.lines().filter(|line| line.starts_with('|')).map(str::to_owned).collect()
}

#[test]
fn a_table_has_means_intervals_or_changes_against_a_row() {
    let mark = "rows=policy columns=road cells=speed digits=1 names=\"none=no advice\"";
    let means = ["| policy | ring | cross |", "|---|---|---|", "| no advice | 2.0 | 4.0 |", "| pi | 2.5 | 3.0 |"];
    assert_eq!(filled(mark), means);
    assert_eq!(filled(&format!("{mark} show=half"))[3], "| pi | 2.5 ± 0.2 | 3.0 ± 0.0 |");
    assert_eq!(filled(&format!("{mark} show=interval"))[3], "| pi | 2.5 [2.3, 2.7] | 3.0 [3.0, 3.0] |");
    // 2.5 of 2 is a quarter more, 3 of 4 a quarter less.
    let changes = filled("rows=policy columns=road cells=speed show=change against=none");
    assert_eq!(changes, ["| policy | ring | cross |", "|---|---|---|", "| pi | +25 % | −25 % |"]);
    let one = filled("rows=road;policy cells=speed show=half where=\"road=ring\" code=policy digits=2");
    assert_eq!(one[2..], ["| ring | `none` | 2.00 ± 0.10 |", "| ring | `pi` | 2.50 ± 0.20 |"]);
    assert_eq!(filled("rows=road cells=speed show=widest")[2..], ["| ring | 0.20 |", "| cross | 0.00 |"]);
}

#[test]
fn a_table_that_differs_is_named_with_file_and_line() {
    let (page, _folder) = page("rows=policy columns=road cells=speed digits=1");
    assert!(tables(&[&page]).status.success());
    assert!(tables(&["--check", &page]).status.success());
    let text = fs::read_to_string(&page).unwrap();
    fs::write(&page, text.replace("| 2.5 |", "| 2.6 |")).unwrap();
    let output = tables(&["--check", &page]);
    // Heading, blank line, mark, head, rule, `none`, and the seventh line is `pi`.
    let place = format!("{page}:7: differs from its result file");
    assert!(!output.status.success() && errors(&output).contains(&place), "{}", errors(&output));
    for (mark, message) in [
        ("rows=policy cells=sped", "there is no column sped"),
        ("rows=policy cells=speed", "a cell has 2 lines of the CSV"),
        ("rows=policy cells=speed colums=road", "unknown key \"colums\""),
        ("rows=policy columns=road cells=speed show=change against=non", "there is no row \"non\""),
    ] {
        let (page, _folder) = self::page(mark);
        let output = tables(&["--check", &page]);
        let place = format!("{page}:3: ");
        let found = errors(&output);
        assert!(!output.status.success() && found.contains(&place) && found.contains(message), "{mark}: {found}");
    }
}
