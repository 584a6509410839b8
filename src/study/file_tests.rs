//! Tests of a study file: limits of numbers, and the keys of each kind of segment.

use super::*;

const GOOD: &str = r#"title = "t"
participants = 4
[base]
traffic = "native"
duration_s = 10.0
[[segment]]
kind = "drive"
name = "practice"
[[segment]]
kind = "break"
name = "pause"
rest_s = 5.0
[[segment]]
kind = "text"
name = "hello"
text = "Hello"
[[segment]]
kind = "questions"
name = "tlx"
questionnaire = "raw-tlx"
"#;

/// Parses the file with `to` in place of `from`.
fn parse_changed(from: &str, to: &str) -> Result<(), String> {
    assert!(GOOD.contains(from), "{from}");
    Study::parse(GOOD.replacen(from, to, 1), Path::new("t.toml")).map(|_| ()).map_err(|e| e.0)
}

#[track_caller]
fn assert_refused(from: &str, to: &str, has: &str) {
    let fault = parse_changed(from, to).expect_err(to);
    assert!(fault.contains(has), "{to}: {fault}");
}

#[test]
fn all_mistakes_of_a_study_are_in_one_report() {
    let text = GOOD
        .replace("participants = 4", "participants = 0\nauthor = \"A\"")
        .replace("duration_s = 10.0", "duration_s = \"long\"\nhold = 3")
        .replace("name = \"practice\"", "name = \"Practice drive\"\nset = { vehicles = 1 }")
        .replace("rest_s = 5.0", "rest_s = -1.0")
        .replace("kind = \"text\"", "kind = \"txt\"")
        .replace("\"raw-tlx\"", "\"raw-tlxx\"");
    let report = Study::parse(text, Path::new("t.toml")).unwrap_err().0;
    let places: Vec<&str> = report.lines().filter_map(|line| line.strip_prefix("t.toml:")).collect();
    let wanted = [
        "2:16: participants is 0",
        "3:1: unknown key `author`; did you mean `authors`?",
        "6:14: duration_s is \"long\"",
        "7:1: unknown key `hold`; did you mean `hold_s`?",
        "10:8: the name \"Practice drive\" cannot be used",
        "11:20: vehicles is 1",
        "15:10: rest_s is -1",
        "17:8: unknown value `txt`; did you mean `text`?",
        "23:17: ",
    ];
    assert!(
        places.len() == wanted.len() && places.iter().zip(wanted).all(|(one, begin)| one.starts_with(begin)),
        "{report}"
    );
}

#[test]
fn numbers_are_allowed_to_the_ends_of_their_limits() {
    for (key, allowed, refused) in [
        (
            "participants = 4",
            vec!["participants = 1", "participants = 1000"],
            vec!["participants = 0", "participants = 1001"],
        ),
        (
            "participants = 4",
            vec!["participants = 4\ncountdown_s = 0.0", "participants = 4\ncountdown_s = 60.0"],
            vec!["participants = 4\ncountdown_s = -0.1", "participants = 4\ncountdown_s = 60.1"],
        ),
        (
            "rest_s = 5.0",
            vec!["rest_s = 0.0", "rest_s = 3600.0"],
            vec!["rest_s = -1.0", "rest_s = 3600.5", "rest_s = nan"],
        ),
        (
            "name = \"practice\"",
            vec!["name = \"practice\"\nuntil_in_range_s = 1.0", "name = \"practice\"\nuntil_in_range_s = 3600.0"],
            vec!["name = \"practice\"\nuntil_in_range_s = 0.9", "name = \"practice\"\nuntil_in_range_s = 3601.0"],
        ),
    ] {
        allowed.iter().for_each(|to| assert_eq!(parse_changed(key, to), Ok(()), "{to}"));
        refused.iter().for_each(|to| assert_refused(key, to, "allowed: "));
    }
}

#[test]
fn keys_left_out_have_their_documented_defaults() {
    let study = Study::parse(GOOD.to_owned(), Path::new("t.toml")).unwrap_or_else(|e| panic!("{e}"));
    let file = &study.file;
    assert_eq!((file.countdown_s, file.seed, file.order), (3.0, 0, order::OrderDesign::Williams));
    assert_eq!((&file.texts, &file.font, &study.font), (&ParticipantTexts::default(), &None, &None));
    assert!(study.conditions.is_empty() && study.questionnaires.contains_key("raw-tlx"));
}

#[test]
fn every_kind_of_segment_has_its_own_keys() {
    for (kind, name, allowed) in [
        (
            "drive",
            "practice",
            vec!["set = { hold_s = 5.0 }", "until_in_range_s = 9.0", "skills = [\"start\"]", "text = \"x\""],
        ),
        ("break", "pause", vec!["text = \"x\""]),
        ("text", "hello", vec![]),
        ("questions", "tlx", vec!["text = \"x\""]),
    ] {
        let all = [
            ("set = { hold_s = 5.0 }", "set"),
            ("until_in_range_s = 9.0", "until_in_range_s"),
            ("skills = [\"start\"]", "skills"),
            ("rest_s = 9.0", "rest_s"),
            ("questionnaire = \"raw-tlx\"", "questionnaire"),
            ("text = \"x\"", "text"),
        ];
        for (line, key) in all {
            // Keys that the file has already.
            if [("break", "rest_s"), ("text", "text"), ("questions", "questionnaire")].contains(&(kind, key)) {
                continue;
            }
            let (from, to) = (format!("name = \"{name}\""), format!("name = \"{name}\"\n{line}"));
            if allowed.contains(&line) {
                assert_eq!(parse_changed(&from, &to), Ok(()), "{kind} with {key}");
            } else {
                assert_refused(&from, &to, &format!("a segment of kind \"{kind}\" has no `{key}`"));
            }
        }
    }
    for (from, has) in [
        ("rest_s = 5.0\n", "kind \"break\" needs `rest_s`"),
        ("text = \"Hello\"\n", "kind \"text\" needs `text`"),
        ("questionnaire = \"raw-tlx\"\n", "kind \"questions\" needs `questionnaire`"),
    ] {
        assert_refused(from, "", has);
    }
}

#[test]
fn trials_need_conditions_which_are_factors_or_a_list() {
    let trials = "[[segment]]\nkind = \"trials\"\nname = \"trial\"\n[[segment]]\nkind = \"drive\"";
    let (segment, base) = ("[[segment]]\nkind = \"drive\"", "[base]");
    assert_refused(segment, trials, "there are trials but no [factors] and no [[condition]]");
    let factors = "[factors]\na = [{ name = \"x\" }]\n";
    let list = "[[condition]]\nname = \"y\"\n";
    for fine in [factors, list] {
        assert_eq!(parse_changed(segment, &format!("{fine}{trials}")), Ok(()), "{fine}");
        assert_eq!(parse_changed(segment, &format!("{fine}{segment}")), Ok(()), "nobody has to use them: {fine}");
    }
    assert_refused(segment, &format!("{factors}{list}{segment}"), "either [factors] or [[condition]], not both");
    assert_refused(base, "[factors]\na = []\n[base]", "factors.a has no levels");
    assert_refused(base, "[factors]\na = [{ name = \"x\" }, { name = \"x\" }]\n[base]", "the name \"x\" occurs twice");
    assert_refused("name = \"pause\"", "name = \"practice\"", "the name \"practice\" occurs twice");
}

#[test]
fn conditions_are_all_combinations_and_later_settings_win() {
    let text = format!(
        "{}{}",
        GOOD.replacen("duration_s = 10.0", "duration_s = 10.0\nhold_s = 2.0\nrange_mph = 1.0", 1),
        "[[segment]]\nkind = \"trials\"\nname = \"trial\"\nset = { hold_s = 4.0, range_mph = 3.0 }\n\
         [factors]\na = [{ name = \"x\" }, { name = \"y\", set = { hold_s = 6.0, advised = 3 } }]\nb = [{ name = \"z\", set = { vehicles = 9 } }]\n"
    );
    let study = Study::parse(text, Path::new("t.toml")).unwrap_or_else(|e| panic!("{e}"));
    let names: Vec<&str> = study.conditions.iter().map(|condition| condition.name.as_str()).collect();
    assert_eq!(names, ["x+z", "y+z"]);
    let levels: Vec<(&str, &str)> =
        study.conditions[1].levels.iter().map(|(factor, level)| (factor.as_str(), level.as_str())).collect();
    assert_eq!(levels, [("a", "y"), ("b", "z")]);
    let drive = |segment, condition: Option<usize>| {
        let scenario = study.drive(segment, condition.map(|i| &study.conditions[i])).unwrap();
        (scenario.hold_s, scenario.range_mph, scenario.vehicles)
    };
    assert_eq!(
        study.drive(4, Some(&study.conditions[1])).unwrap().advised,
        crate::scenario::AdvisedVehicles::Count(3),
        "a text may be a number"
    );
    let usual = Scenario::default().vehicles;
    assert_eq!(drive(0, None), (2.0, 1.0, usual), "the base");
    assert_eq!(drive(4, None), (4.0, 3.0, usual), "the segment's own");
    assert_eq!(drive(4, Some(0)), (4.0, 3.0, 9));
    assert_eq!(drive(4, Some(1)), (6.0, 3.0, 9), "the condition's over the segment's");
}

#[test]
fn a_file_that_is_too_large_or_not_a_font_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("big.ttf");
    std::fs::File::create(&path).unwrap().set_len(FONT_BYTES + 1).unwrap();
    assert!(read_font(&path).unwrap_err().to_string().contains("cannot be read"));
    std::fs::write(&path, "no font").unwrap();
    assert!(read_font(&path).unwrap_err().to_string().contains("is not a font; allowed: a TTF or OTF file"));
}

#[test]
fn the_schema_knows_every_key_with_its_limits_and_no_other() {
    let schema = schemars::schema_for!(StudyFile).to_value();
    let keys: Vec<&str> = schema["properties"].as_object().unwrap().keys().map(String::as_str).collect();
    for key in
        ["title", "participants", "seed", "order", "countdown_s", "base", "factors", "condition", "segment", "font"]
    {
        assert!(keys.contains(&key), "{key}: {keys:?}");
    }
    let participants = &schema["properties"]["participants"];
    assert_eq!(
        [&participants["minimum"], &participants["maximum"]].map(serde_json::Value::as_f64),
        [Some(1.0), Some(1000.0)]
    );
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn lab_devices_are_checked_and_leave_the_drives_unchanged() {
    let [lsl, triggers] = ["[lsl]\nwait_s = 0.0\n[base]", "[triggers]\ndevice = \"/dev/ttyS0\"\nbaud = 12\n[base]"];
    assert_refused("[base]", lsl, "wait_s is 0; allowed: a number from 0.1 to 600 s");
    assert_refused("[base]", lsl, "t.toml:4:10");
    assert_refused("[base]", triggers, "baud is 12; allowed: 9600");
    assert_refused("[base]", triggers, "t.toml:5:8");
    assert_refused("[base]", "[lsl]\noutlet = true\n[base]", "outlet");
    let with = GOOD.replacen("[base]", "[lsl]\noutlets = true\nrecord = [\"type='EEG'\"]\n[base]", 1);
    let [plain, with] = [GOOD.to_owned(), with].map(|text| Study::parse(text, Path::new("t.toml")).unwrap());
    assert!(with.file.lsl.outlets && !plain.file.lsl.outlets && plain.file.triggers.is_none());
    assert_eq!(plain.base, with.base, "the scenario does not know of it");
}

#[test]
fn events_are_a_setting_and_those_of_a_segment_replace_those_of_the_base() {
    let event = |name: &str, at_s: f64| {
        format!(
            "event = [{{ name = \"{name}\", trigger = {{ time_s = {at_s} }}, actions = [{{ hide_advice = {{ for_s = 1 }} }}] }}]"
        )
    };
    let base = GOOD.replacen("[base]\n", &format!("[base]\n{}\n", event("of base", 2.0)), 1);
    let drive = "kind = \"drive\"\nname = \"practice\"\n";
    let own = |at_s: f64| base.replacen(drive, &format!("{drive}set = {{ {} }}\n", event("own", at_s)), 1);
    for (text, name) in [(base.clone(), "of base"), (own(3.0), "own")] {
        let study = Study::parse(text, Path::new("t.toml")).unwrap_or_else(|e| panic!("{e}"));
        let names: Vec<_> = study.drive(0, None).expect("a drive").events.into_iter().map(|event| event.name).collect();
        assert_eq!(names, [name]);
    }
    // Lines: 10 is that of `set`. A drive of 10 s ends before 30 s.
    for (at_s, words) in [(-3.0, "time_s is -3; allowed: 0 to 604800"), (30.0, "can never begin: time_s is 30")] {
        let fault = Study::parse(own(at_s), Path::new("t.toml")).unwrap_err().to_string();
        assert!(fault.starts_with("t.toml:10:") && fault.contains(words), "{fault}");
    }
}

#[test]
fn map_paths_start_at_the_folder_of_the_study_file() {
    let home = tempfile::tempdir().unwrap();
    std::fs::create_dir(home.path().join("roads")).unwrap();
    let shipped = crate::data_folders::root().join("maps/ring-250/net.xml");
    std::fs::copy(shipped, home.path().join("roads/own.net.xml")).unwrap();
    let parse = |at: &str, set: &str| {
        let text = GOOD.replacen(at, &format!("{at}{set}"), 1);
        Study::parse(text, &home.path().join("t.toml"))
    };
    let drive = "kind = \"drive\"\nname = \"practice\"\n";
    for (at, set) in [("[base]\n", "map = \"roads/own.net.xml\"\n"), (drive, "set = { map = \"roads/own.net.xml\" }\n")]
    {
        let study = parse(at, set).unwrap_or_else(|e| panic!("{e}"));
        assert!(study.files().any(|file| *file == home.path().join("roads/own.net.xml")));
    }
    let message = parse(drive, "set = { map = \"roads/other.net.xml\" }\n").unwrap_err().to_string();
    assert!(message.contains(home.path().join("roads/other.net.xml").to_str().unwrap()), "{message}");
}

#[test]
fn a_title_is_one_line_without_control_characters() {
    for (bad, message) in
        [("a\\tb", "\\u{9}"), ("a\\u001b[31m", "\\u{1b}"), ("a\\u202eb", "\\u{202e}"), ("a\\nb", "\\u{a}")]
    {
        let with = format!("title = \"{bad}\"");
        assert_refused(
            "title = \"t\"",
            &with,
            &format!("t.toml:1:9: title has the character {message}; allowed: one line"),
        );
    }
    let authors = "title = \"t\"\nauthors = [\"A\", \"B\\u0007\"]";
    assert_refused("title = \"t\"", authors, "authors.1 has the character \\u{7}");
    assert!(parse_changed("title = \"t\"", "title = \"<b> & 'Zürich' שלום\"").is_ok());
}
