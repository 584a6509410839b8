//! Places and words of mistakes, and all mistakes of a text in one report.

use super::*;

const TEXT: &str = "title = \"t\"\n[idm]\n  T = 1.5\n[[segment]]\nkind = \"text\"\n[[segment]]\n\tset = { hold_sec = 2, policy = \"x\" }\n";

#[test]
fn the_mark_is_under_the_key_or_the_value() {
    let place = |key, part| at(TEXT, "a.toml", key, part, "wrong");
    assert_eq!(place("idm.T", KeyPart::Value), "a.toml:3:7: wrong\n  |\n3 |   T = 1.5\n  |       ^^^");
    assert_eq!(place("idm.T", KeyPart::Key), "a.toml:3:3: wrong\n  |\n3 |   T = 1.5\n  |   ^");
    // A tab is as wide as four blanks.
    let set = "  |\n7 |     set = { hold_sec = 2, policy = \"x\" }\n  |             ";
    assert_eq!(place("segment.1.set.hold_sec", KeyPart::Key), format!("a.toml:7:10: wrong\n{set}^^^^^^^^"));
    let policy = place("segment.1.set.policy", KeyPart::Value);
    assert!(policy.starts_with("a.toml:7:33: wrong") && policy.ends_with(" ^^^"), "{policy}");
}

/// Sheet with keys of all kinds.
#[derive(Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Sheet {
    title: String,
    count: u32,
    #[serde(default)]
    is_on: bool,
    wheel: Wheel,
    #[serde(default)]
    part: Vec<Part>,
}

#[derive(Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Wheel {
    left: i32,
    right: i32,
}

#[derive(Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Part {
    kind: Kind,
    size: f64,
    #[serde(default)]
    acts: Vec<Act>,
}

#[derive(Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Bend,
    Straight,
}

#[derive(Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Act {
    Brake { force: f64 },
    Speak { text: String },
}

/// Returns line and first line of the message of each mistake of a sheet.
fn found(text: &str) -> Vec<(usize, String)> {
    let report = parse::<Sheet>(text, "s.toml").unwrap_err();
    let first = |mistake: &TomlMistake| mistake.message.lines().next().unwrap_or_default().to_owned();
    report.mistakes.iter().map(|mistake| (mistake.line, first(mistake))).collect()
}

fn expected(list: &[(usize, &str)]) -> Vec<(usize, String)> {
    list.iter().map(|(line, message)| (*line, (*message).to_owned())).collect()
}

const GOOD: &str = "title = \"a\"\ncount = 1\nwheel = { left = 1, right = 2 }\n[[part]]\nkind = \"bend\"\nsize = 1\n[[part]]\nkind = \"straight\"\nsize = 2\nacts = [{ brake = { force = 1 } }, { speak = { text = \"x\" } }]\n";

#[test]
fn all_mistakes_of_a_text_are_in_one_report_in_the_order_of_its_lines() {
    assert!(parse::<Sheet>(GOOD, "s.toml").is_ok());
    let text = "title = 5\ncount = \"3\"\ncolour = 1\nwheel = { left = 1.5, rigth = 2 }\n[[part]]\nkind = \"bent\"\nsize = 1\n\
                [[part]]\nkind = \"straight\"\nacts = [{ brak = { force = 1 } }, { speak = { text = true } }]\n";
    let wanted = [
        (1, "invalid type: integer `5`; allowed: a text in quotation marks"),
        (2, "invalid type: string \"3\"; allowed: a whole number from 0"),
        (3, "unknown key `colour`; allowed: `title`, `count`, `is_on`, `wheel`, `part`"),
        (4, "invalid type: floating point `1.5`; allowed: a whole number"),
        (4, "unknown key `rigth`; did you mean `right`? allowed: `left`, `right`"),
        (6, "unknown value `bent`; did you mean `bend`? allowed: `bend`, `straight`"),
        (8, "missing key `size`"),
        (10, "unknown value `brak`; did you mean `brake`? allowed: `brake`, `speak`"),
        (10, "invalid type: boolean `true`; allowed: a text in quotation marks"),
    ];
    assert_eq!(found(text), expected(&wanted));
}

#[test]
fn each_missing_key_is_named_once_even_where_tables_are_missing() {
    let missing = [(1, "missing key `title`"), (1, "missing key `count`"), (1, "missing key `wheel`")];
    assert_eq!(found("is_on = true\n"), expected(&missing));
    // A key with a slip is not missing, too.
    assert_eq!(found(&GOOD.replace("count", "cuont")).len(), 1);
    assert_eq!(found(&GOOD.replace("left = 1", "lfet = 1")).len(), 1);
}

#[test]
fn a_file_has_all_its_syntax_errors_in_one_report() {
    let text = GOOD.replace("count = 1", "count = = 1").replace("size = 2", "size = 2 3").replace("\"bend\"", "5");
    let lines: Vec<usize> = found(&text).iter().map(|(line, _)| *line).collect();
    assert_eq!(lines, [2, 5, 9], "{:?}", found(&text));
    // A list that is not closed takes in the lines below; they have no errors of their own.
    let open = found("title = \"a\"\nlist = [1,\n[wheel]\nleft = 1\nright = 2\n");
    assert_eq!(open, expected(&[(2, "unclosed array, expected `]`")]));
    assert_eq!(found("title = \"a\"\n[wheel\nleft = 1\n").len(), 1);
}

#[test]
fn a_report_shows_twenty_mistakes_and_counts_the_others() {
    let text = |count: usize| (0..count).fold(GOOD.to_owned(), |text, i| format!("unknown_{i} = {i}\n{text}"));
    let report = |count| parse::<Sheet>(&text(count), "s.toml").unwrap_err();
    assert_eq!((report(20).mistakes.len(), report(20).more), (20, 0));
    assert_eq!((report(27).mistakes.len(), report(27).more), (20, 7));
    let shown = report(27).to_string();
    assert!(shown.starts_with("s.toml:1:1: unknown key `unknown_26`") && shown.ends_with("\nand 7 more"), "{shown}");
    // A file of nothing but mistakes is not read to its end.
    let long = report(20_000);
    assert!(long.is_cut && long.to_string().contains("and at least "), "{}", long.more);
}

#[test]
fn a_reader_adds_only_what_does_not_follow_from_other_mistakes() {
    let text = GOOD.replace("size = 1\n", "size = \"s\"\n").replace("left = 1", "lfet = 1");
    let (sheet, mut mistakes) = read::<Sheet>(&text, "s.toml");
    assert!(sheet.is_some_and(|sheet| sheet.part.len() == 2 && sheet.count == 1));
    let mut add =
        |key: &str, others: &[&str]| mistakes.add_related(key, others, KeyPart::Value, &format!("{key} is bad"));
    add("part.0.size", &[]);
    add("wheel.left", &[]);
    add("part", &[]);
    add("count", &["wheel.left"]);
    add("title", &["count"]);
    add("part.1.size", &[]);
    add("part.1.size", &[]);
    let report = mistakes.finish().unwrap_err();
    let lines: Vec<usize> = report.mistakes.iter().map(|mistake| mistake.line).collect();
    assert_eq!(lines, [1, 3, 6, 9], "{report}");
}

#[test]
fn entries_behind_one_that_is_left_out_keep_their_numbers() {
    let text = GOOD.replace("kind = \"bend\"\nsize = 1\n", "kind = { bend = 1 }\nsize = 1\n");
    let text = text.replace("{ brake = { force = 1 } }, ", "7, { stop = 1 }, ");
    let (sheet, mut mistakes) = read::<Sheet>(&text, "s.toml");
    let sheet = sheet.expect("the other parts are read");
    let last = sheet.part.len() - 1;
    assert_eq!(sheet.part[last].acts, [Act::Speak { text: "x".into() }]);
    mistakes.add(&format!("part.{last}.acts.0.speak.text"), KeyPart::Value, "too short");
    let report = mistakes.finish().unwrap_err().to_string();
    assert!(
        report.contains(&format!("s.toml:10:{}: too short", text.lines().nth(9).unwrap().find("\"x\"").unwrap() + 1)),
        "{report}"
    );
}

#[test]
fn a_missing_key_is_marked_at_its_parent() {
    assert!(at(TEXT, "a", "segment.1.name", KeyPart::Value, "m").starts_with("a:6:1: m"));
    assert!(at(TEXT, "a", "segment.7.name", KeyPart::Value, "m").starts_with("a:4:1: m"));
    assert!(at(TEXT, "a", "nothing", KeyPart::Key, "m").starts_with("a:1:1: m"));
    assert!(at("no = = toml", "a", "no", KeyPart::Key, "m").starts_with("a:1:1: m"));
    assert!(has(TEXT, "idm.T") && has(TEXT, "title") && has(TEXT, "idm"));
    assert!(!has(TEXT, "idm.a") && !has(TEXT, "title.x") && !has("= =", "title"));
}

#[test]
fn a_misspelt_key_and_a_missing_unit_are_recognised() {
    let known = ["hold_s", "range_mph", "map", "vehicles", "T", "a", "b", "duration_s", "warm_up_s", "idm.T", "idm.a"];
    for (word, meant) in [
        ("hold_sec", Some("hold_s")),
        ("range_mhp", Some("range_mph")),
        ("range", Some("range_mph")),
        ("vehicels", Some("vehicles")),
        ("Map", Some("map")),
        ("t", Some("T")),
        ("warm-up", Some("warm_up_s")),
        ("x", None),
        ("tau", None),
        ("idm.tau", None),
        ("idm.t", Some("idm.T")),
        ("idm.x", None),
        ("colour", None),
    ] {
        assert_eq!(nearest(word, &known), meant, "{word}");
    }
}

#[test]
fn a_missing_file_gets_the_nearest_name_in_its_folder_as_suggestion() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("trial.toml"), "").unwrap();
    let suggestion = |name: &str| did_you_mean_file(&folder.path().join(name));
    assert_eq!(suggestion("trail.toml"), " (did you mean trial.toml?)");
    assert_eq!(
        [suggestion("trial.toml"), suggestion("something-else.toml"), suggestion("no/trial.toml")],
        ["", "", ""]
    );
}

#[test]
fn a_file_of_another_kind_is_named_with_the_command_that_reads_it() {
    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code, reason = "only the error counts")]
    struct Drive {
        vehicles: u32,
    }
    let message = |text: &str| parse::<Drive>(text, "a.toml").unwrap_err().mistakes[0].message.clone();
    let study = "unknown key `segment`: the file is a study\n  remedy: codrive study check FILE";
    assert_eq!(
        message(
            "title = \"t\"\n\
        [[segment]]\n\
        kind = \"text\"\n"
        ),
        study
    );
    let wheel = message("[accelerator]\naxis = 1");
    assert_eq!(
        wheel,
        "unknown key `accelerator`: the file is the profile of a wheel\n  remedy: codrive drive --wheel FILE"
    );
    assert!(message("description = \"a ring\"").contains("the file is the description of a map"));
    let fault =
        |text: &str| read_formatted::<Drive>(text, "a.toml").1.finish().unwrap_err().mistakes[0].message.clone();
    assert_eq!(
        fault("format = \"codrive benchmark 1\""),
        "the file is a benchmark\n  remedy: codrive evaluate --benchmark FILE"
    );
    assert!(fault("format = 2").starts_with("the file has format 2; allowed: 1, the format of codrive "));
    assert_eq!(message("vehicle = 2"), "unknown key `vehicle`; did you mean `vehicles`? allowed: `vehicles`");
}

#[test]
fn no_word_is_suggested_where_two_are_equally_near() {
    assert_eq!(did_you_mean("kph", &["mph", "kmh"]), "");
    assert_eq!(did_you_mean("mhp", &["mph", "kmh"]), " (did you mean mph?)");
    assert_eq!(did_you_mean("g290", &["g29", "g920"]), " (did you mean g29?)");
}

#[test]
fn a_wrong_type_is_named_in_plain_words() {
    #[derive(Debug, serde::Deserialize)]
    #[allow(dead_code, reason = "only the error counts")]
    struct Drive {
        vehicles: u32,
        is_on: bool,
        title: String,
    }
    let message = |text: &str| parse::<Drive>(text, "a.toml").unwrap_err().mistakes[0].message.clone();
    let remedy = "invalid type: string \"22\"; allowed: a whole number from 0\n  remedy: 22, without quotation marks";
    assert_eq!(message("vehicles = \"22\""), remedy);
    assert_eq!(message("vehicles = -1"), "invalid value: integer `-1`; allowed: a whole number from 0");
    assert_eq!(message("is_on = \"many\""), "invalid type: string \"many\"; allowed: true or false");
    assert_eq!(message("title = 5"), "invalid type: integer `5`; allowed: a text in quotation marks");
}

#[test]
fn many_keys_are_listed_only_where_none_is_near() {
    let many: Vec<String> = (0..40).map(|i| format!("setting_{i}")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let near = unknown_key("seting_3", &many);
    assert_eq!(near, "unknown key `seting_3`; did you mean `setting_3`?");
    assert!(unknown_key("far_away", &many).contains("allowed: `setting_0`, `setting_1`"));
    let few = unknown_key("hold", &["hold_s", "map"]);
    assert_eq!(few, "unknown key `hold`; did you mean `hold_s`? allowed: `hold_s`, `map`");
}

#[test]
fn another_format_is_refused_and_a_known_one_moves_nothing() {
    assert_eq!(without_format("seed = 2\n").unwrap(), "seed = 2\n");
    let kept = without_format("# A drive.\nformat = 1 # of the first version\nseed = 2\n").unwrap();
    assert_eq!(kept, "# A drive.\n           # of the first version\nseed = 2\n");
    for (text, written) in [("format = 2", "2"), ("\nformat = \"1\"\n", "\"1\"")] {
        let message = read_formatted::<Sheet>(text, "trial.toml").1.finish().unwrap_err().to_string();
        let line = text.lines().count();
        let wanted = format!("trial.toml:{line}:10: the file has format {written}; allowed: 1, the format of codrive");
        assert!(message.starts_with(&wanted) && message.contains("remedy: use the program that wrote it"), "{message}");
    }
}
