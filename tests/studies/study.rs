//! A study file is checked as a whole before anything starts, and its plan is balanced.

use codrive::study::{PlanItem, Questionnaire, Study, questions::Answers};
use serde_json::{Value, json};
use std::{collections::BTreeMap, path::Path};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn shipped() -> Study {
    load("congestion")
}

pub fn load(name: &str) -> Study {
    Study::load(&root().join(format!("assets/studies/{name}.toml"))).unwrap_or_else(|e| panic!("{e}"))
}

fn questionnaire(name: &str) -> Questionnaire {
    Questionnaire::find(name, Path::new(".")).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns the message about a valid study in which `from` is replaced by `to`.
fn fault(from: &str, to: &str) -> String {
    let good = r#"title = "t"
participants = 4
[base]
traffic = "native"
duration_s = 10.0
[[condition]]
name = "a"
set = { range_mph = 1.0 }
[[condition]]
name = "b"
set = { hold_s = 5.0, idm = { T = 1.5 } }
[[segment]]
kind = "trials"
name = "trial"
[[segment]]
kind = "questions"
name = "tlx"
questionnaire = "raw-tlx"
"#;
    assert!(good.contains(from), "{from}");
    let path = Path::new("trial.toml");
    Study::parse(good.to_owned(), path).unwrap_or_else(|e| panic!("{e}"));
    Study::parse(good.replacen(from, to, 1), path).expect_err("a mistake").0
}

/// A dial that followed each trial's traffic would be a second factor: here it would end at 25 mph with 22 cars, at 80 with 5.
#[test]
fn all_trials_have_one_full_scale_of_the_speedometer() {
    let study = |more: &str| {
        let text = format!(
            "title = \"t\"\nparticipants = 2\n[base]\ntraffic = \"native\"\nduration_s = 10.0\n{more}\n[[condition]]\nname = \
             \"dense\"\n[[condition]]\nname = \"loose\"\nset = {{ vehicles = 5 }}\n[[segment]]\nkind = \"drive\"\nname = \
             \"practice\"\n[[segment]]\nkind = \"trials\"\nname = \"trial\"\n"
        );
        Study::parse(text, Path::new("dial.toml")).unwrap_or_else(|e| panic!("{e}"))
    };
    let scales = |more: &str| -> Vec<f64> {
        let full = |item: PlanItem| {
            if let PlanItem::Drive { scenario, .. } = item { Some(scenario.display.dial_full) } else { None }
        };
        study(more).plan(0).items.into_iter().filter_map(|planned| full(planned.item)).collect()
    };
    // The practice keeps its automatic dial. The trials' dial ends 15 % above 2.2 times the even flow of five cars, at most the speed
    // limit.
    let [practice, first, second] = scales("")[..] else { panic!("three drives") };
    assert_eq!((practice, first), (0.0, second));
    assert!(first >= 60.0, "{first} mph: five cars on 250 m flow at 15 m/s and more");
    let kmh = scales("units = \"kmh\"")[1];
    assert!(kmh > first && scales("units = \"kmh\"")[2] == kmh, "{kmh} km/h");
    assert_eq!(scales("dial_full = 30.0"), [30.0; 3], "a study may name its own");
}

#[test]
fn factors_make_all_combinations() {
    let text = r#"title = "t"
participants = 4
[base]
traffic = "native"
[factors]
density = [{ name = "dense" }, { name = "loose", set = { vehicles = 18 } }]
range = [{ name = "narrow", set = { range_mph = 0.5 } }, { name = "wide", set = { range_mph = 2.0 } }]
[[segment]]
kind = "trials"
name = "trial"
rest_s = 30
"#;
    let study = Study::parse(text.into(), Path::new("x.toml")).unwrap_or_else(|e| panic!("{e}"));
    let names: Vec<&str> = study.conditions.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["dense+narrow", "dense+wide", "loose+narrow", "loose+wide"]);
    let plan = study.plan(0);
    assert_eq!(plan.items.iter().filter(|p| matches!(p.item, PlanItem::Break(s) if s == 30.0)).count(), 3);
    for planned in &plan.items {
        let PlanItem::Drive { scenario, levels, .. } = &planned.item else { continue };
        assert_eq!(scenario.vehicles, if levels["density"] == "loose" { 18 } else { 22 });
        assert_eq!(scenario.range_mph, if levels["range"] == "wide" { 2.0 } else { 0.5 });
    }
}

#[cfg(feature = "desktop")]
#[test]
fn a_font_beside_the_study_is_read_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let own = egui::FontDefinitions::default();
    let bytes = own.font_data.values().next().unwrap().font.as_ref().as_ref().to_vec();
    std::fs::write(folder.path().join("letters.ttf"), &bytes).unwrap();
    let path = folder.path().join("trial.toml");
    let text = std::fs::read_to_string(root().join("assets/studies/congestion.toml")).unwrap();
    let study = Study::parse(format!("font = \"letters.ttf\"\n{text}"), &path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(study.font.as_deref(), Some(bytes.as_slice()));
    assert!(shipped().font.is_none());
}

#[test]
fn every_mistake_is_named_with_its_place() {
    for (from, to, begins, has) in [
        ("participants = 4", "particpants = 4", "trial.toml:2:1: ", "unknown key `particpants`"),
        ("participants = 4", "participants = 0", "trial.toml:2:16: ", "allowed: 1 to 1000"),
        (
            "participants = 4",
            "participants = 4\ncountdown_s = 61.0",
            "trial.toml:3:15: ",
            "allowed: a number from 0 to 60 s",
        ),
        ("participants = 4", "participants = 4\nfont = \"no.ttf\"", "trial.toml:3:8: ", "no.ttf cannot be read"),
        (
            "participants = 4",
            "participants = 4\nfont = \"Cargo.toml\"",
            "trial.toml:3:8: ",
            "is not a font; allowed: a TTF",
        ),
        ("range_mph = 1.0", "range_mph = 99", "trial.toml:8:21: ", "0.1 to 50 mph"),
        ("range_mph = 1.0", "rnge_mph = 1", "trial.toml:8:9: ", "unknown key `rnge_mph`; did you mean `range_mph`?\n"),
        ("T = 1.5", "T = 99", "trial.toml:11:35: ", "idm.T is 99"),
        ("T = 1.5", "tau = 99", "trial.toml:11:31: ", "unknown key `idm.tau`; allowed: "),
        ("hold_s = 5.0", "hold_s = 0.25", "trial.toml:11:18: ", "whole number of steps"),
        (
            "hold_s = 5.0",
            "hold_sec = 5",
            "trial.toml:11:9: ",
            "did you mean `hold_s`?\n   |\n11 | set = { hold_sec = 5,",
        ),
        ("hold_s = 5.0", "hold_sec = 5", "trial.toml:11:9: ", "\n   |         ^^^^^^^^"),
        ("name = \"b\"", "name = \"a\"", "trial.toml:10:8: ", "occurs twice"),
        ("name = \"b\"", "name = \"B b\"", "trial.toml:10:8: ", "small letters"),
        ("kind = \"trials\"", "kind = \"trial\"", "trial.toml:13:8: ", "unknown value `trial`; did you mean `trials`?"),
        ("kind = \"trials\"", "kind = \"break\"", "trial.toml:13:8: ", "needs `rest_s`"),
        (
            "\"raw-tlx\"",
            "\"tlx\"",
            "trial.toml:18:17: ",
            "one of acceptance, consent, driving-experience, nasa-tlx, raw-tlx, sample, screening, ssq, trust, van-der-laan",
        ),
        // A fault that stops a drive from starting is reported where it was set, whichever drive reveals it.
        ("traffic = \"native\"", "map = \"nowhere\"", "trial.toml:4:7: ", "nowhere"),
        ("traffic = \"native\"", "vehicles = 900", "trial.toml:4:12: ", "do not fit"),
        ("traffic = \"native\"", "policy = \"wisdom\"", "trial.toml:4:10: ", "wisdom"),
        ("traffic = \"native\"", "driver = \"folow\"", "trial.toml:4:10: ", "no driver is called"),
        ("traffic = \"native\"", "traffic = \"sumoo\"", "trial.toml:4:11: ", "sumoo"),
        ("range_mph = 1.0", "policy = \"wisdom\"", "trial.toml:8:18: ", "\n  |                  ^^^^^^^^"),
        ("name = \"trial\"", "name = \"trial\"\nset = { policy = \"x\" }", "trial.toml:15:18: ", "\"x\""),
        ("duration_s = 10.0", "duration_s = 0.0", "trial.toml:5:14: ", "needs an end"),
        ("name = \"trial\"", "nam = \"trial\"", "trial.toml:14:1: ", "did you mean `name`?"),
        ("name = \"trial\"\n", "", "trial.toml:12:1: ", "missing key `name`"),
        ("title = \"t\"", "title = ", "trial.toml:1:", "\n1 | title = "),
    ] {
        let message = fault(from, to);
        assert!(message.starts_with(begins) && message.contains(has), "{from} -> {to}: {message}");
    }
}

#[test]
fn scores_are_those_of_their_authors() {
    // Symptoms of nausea, oculomotor and disorientation: table 5 of Kennedy, Lane, Berbaum and Lilienthal (1993).
    let ssq = questionnaire("ssq");
    let table = [
        ("general-discomfort", [1, 1, 0]),
        ("fatigue", [0, 1, 0]),
        ("headache", [0, 1, 0]),
        ("eyestrain", [0, 1, 0]),
        ("difficulty-focusing", [0, 1, 1]),
        ("increased-salivation", [1, 0, 0]),
        ("sweating", [1, 0, 0]),
        ("nausea", [1, 0, 1]),
        ("difficulty-concentrating", [1, 1, 0]),
        ("fullness-of-head", [0, 0, 1]),
        ("blurred-vision", [0, 1, 1]),
        ("dizzy-eyes-open", [0, 0, 1]),
        ("dizzy-eyes-closed", [0, 0, 1]),
        ("vertigo", [0, 0, 1]),
        ("stomach-awareness", [1, 0, 0]),
        ("burping", [1, 0, 0]),
    ];
    let asked: Vec<String> =
        ssq.pages.iter().flat_map(|page| &page.elements).flat_map(|element| element.answer_names()).collect();
    // The two pages are one list, as in the questionnaire.
    let name = |symptom: &str| asked.iter().find(|name| name.ends_with(&format!(".{symptom}"))).expect(symptom).clone();
    let names: Vec<String> = table.iter().map(|(symptom, _)| name(symptom)).collect();
    assert_eq!(asked, names);
    let figure = |scores: &[(String, Option<f64>)], name: &str| scores.iter().find(|s| s.0 == name).expect(name).1;
    let answered = |of: &dyn Fn(usize) -> u8| -> Answers {
        names.iter().enumerate().map(|(i, name)| (name.clone(), json!(of(i)))).collect()
    };
    let check = |answers: &Answers, wanted: [f64; 4], what: &str| {
        let scores = ssq.scores(answers);
        for (name, wanted) in ["nausea", "oculomotor", "disorientation", "total"].into_iter().zip(wanted) {
            let found = figure(&scores, name).expect("all answered");
            assert!((found - wanted).abs() < 1e-9, "{what}, {name}: {found}, wanted {wanted}");
        }
    };
    // Each symptom alone, severe: 3 in its scales, with the weights 9.54, 7.58, 13.92, and 3.74 for their sum.
    for (i, (symptom, [n, o, d])) in table.iter().enumerate() {
        let [n, o, d] = [n, o, d].map(|counts| f64::from(3 * counts));
        let wanted = [9.54 * n, 7.58 * o, 13.92 * d, 3.74 * (n + o + d)];
        check(&answered(&|k| if k == i { 3 } else { 0 }), wanted, symptom);
    }
    // Worked by hand: nausea 1 + 3 + 2 + 1 = 7, oculomotor 1 + 2 + 1 + 3 + 1 = 8, disorientation 3 + 2 + 1 + 2 = 8.
    let mixed = [1, 2, 1, 0, 3, 0, 3, 2, 1, 0, 0, 1, 2, 0, 0, 0];
    check(&answered(&|k| mixed[k]), [66.78, 60.64, 111.36, 86.02], "mixed answers");
    // The ends of the published scales: 0, and 200.34, 159.18, 292.32, 235.62.
    check(&answered(&|_| 0), [0.0; 4], "nothing");
    check(&answered(&|_| 3), [200.34, 159.18, 292.32, 235.62], "all severe");
    let mut answers = answered(&|k| mixed[k]);
    answers.remove("symptom.nausea");
    let scores = ssq.scores(&answers);
    assert!(figure(&scores, "nausea").is_none() && figure(&scores, "oculomotor").is_some());

    let tlx = questionnaire("raw-tlx");
    let rated = ["mental", "physical", "temporal", "performance", "effort", "frustration"];
    let answers: Answers = rated.iter().zip([10, 20, 30, 40, 50, 75]).map(|(n, v)| ((*n).into(), json!(v))).collect();
    assert_eq!(figure(&tlx.scores(&answers), "raw-tlx"), Some(37.5));
    assert_eq!(tlx.pages[0].elements[0].rates().len(), 21);
}

#[test]
fn questions_appear_by_earlier_answers_and_required_ones_are_missed() {
    let experience = questionnaire("driving-experience");
    let page = &experience.pages[0];
    let names = |answers: &Answers| -> Vec<String> { page.visible_elements(answers).map(|e| e.name.clone()).collect() };
    let mut answers: Answers = BTreeMap::new();
    assert_eq!(names(&answers), ["licence"]);
    answers.insert("licence".into(), Value::Bool(true));
    assert_eq!(names(&answers), ["licence", "licence-years"]);
    assert_eq!(page.missing(&answers), ["licence-years"]);
    let pages = |answers: &Answers| experience.visible_pages(answers).count();
    assert_eq!((pages(&answers), pages(&BTreeMap::new())), (5, 4), "how far one drives is asked of drivers");
    let years = page.elements.iter().find(|e| e.name == "licence-years").expect("there");
    assert!(years.accepts(&json!("3-10")) && !years.accepts(&json!("3")) && !years.accepts(&json!(3)));
}

#[test]
fn a_mistake_in_a_questionnaire_is_named() {
    let good = r#"{"title":"q","pages":[{"elements":[{"type":"rating","name":"a","title":"A?","visibleIf":"{b} = 1"},{"type":"text","name":"b"}]}],"scores":[{"name":"s","method":"sum","of":["a"]}]}"#;
    Questionnaire::parse(good, "q.json").unwrap_or_else(|e| panic!("{e}"));
    for (from, to, has) in [
        ("\"rating\"", "\"slider\"", "unknown value `slider`"),
        ("\"title\":\"A?\"", "\"titel\":\"A?\"", "unknown key `titel`"),
        ("{b} = 1", "b == 1", "visibleIf has"),
        ("{b} = 1", "{c} = 1", "visibleIf names \"c\""),
        ("\"of\":[\"a\"]", "\"of\":[\"z\"]", "uses \"z\""),
        ("\"name\":\"b\"", "\"name\":\"a\"", "occurs twice"),
        ("\"type\":\"rating\"", "\"type\":\"radiogroup\"", "has no choices"),
        ("\"title\":\"A?\"", "\"rateStep\":0.3", "whole steps"),
        ("]}]}", "]}", "q.json:1:"),
    ] {
        assert!(good.contains(from), "{from}");
        let message = Questionnaire::parse(&good.replacen(from, to, 1), "q.json").expect_err(to).0;
        assert!(message.starts_with("q.json:") && message.contains(has), "{from} -> {to}: {message}");
    }
}

#[test]
fn a_condition_compares_as_surveyjs_says() {
    let holds = |by: &str, answer: Option<Value>| {
        let text = format!(
            r#"{{"title":"q","pages":[{{"elements":[{{"type":"text","name":"b"}},{{"type":"text","name":"a","visibleIf":"{{b}} {by}"}}]}}]}}"#
        );
        let q = Questionnaire::parse(&text, "q.json").unwrap_or_else(|e| panic!("{by}: {e}"));
        let answers: Answers = answer.into_iter().map(|value| ("b".into(), value)).collect();
        q.pages[0].visible_elements(&answers).count() == 2
    };
    // Below, at and above the compared value.
    for (by, expected) in [
        ("= 3", [false, true, false]),
        ("<> 3", [true, false, true]),
        ("< 3", [true, false, false]),
        ("<= 3", [true, true, false]),
        ("> 3", [false, false, true]),
        (">= 3", [false, true, true]),
    ] {
        assert_eq!([2, 3, 4].map(|n| holds(by, Some(json!(n)))), expected, "{by}");
        // A word has no order; a missing response equals nothing.
        assert_eq!(holds(by, Some(json!("three"))), by == "<> 3", "{by} with a word");
        assert_eq!(holds(by, None), by == "<> 3", "{by} without an answer");
    }
    // A whole number and the same value with a decimal point are equal.
    assert!(holds("= 3", Some(json!(3.0))) && !holds("<> 3", Some(json!(3.0))));
    assert!(holds("= 'yes'", Some(json!("yes"))) && !holds("= 'yes'", Some(json!("no"))));
    for (list, expected) in
        [(json!(["bus", "car"]), true), (json!(["bus"]), false), (json!([]), false), (json!("car"), false)]
    {
        assert_eq!(holds("contains 'car'", Some(list.clone())), expected, "{list}");
    }
    // `and` binds stronger than `or`.
    for (n, expected) in [(1, true), (4, false), (6, true), (9, false)] {
        assert_eq!(holds("= 1 or {b} > 5 and {b} < 8", Some(json!(n))), expected, "{n}");
    }
}

#[test]
fn all_orders_are_for_six_conditions_at_most() {
    let study = |conditions: usize, order: &str| {
        let list: String = (0..conditions)
            .map(|i| format!("[[condition]]\nname = \"c{i}\"\nset = {{ hold_s = {}.0 }}\n", i + 1))
            .collect();
        let text = format!(
            "title = \"t\"\nparticipants = 2\norder = \"{order}\"\n[base]\ntraffic = \"native\"\nduration_s = 10.0\n{list}[[segment]]\nkind = \"trials\"\nname = \"trial\"\n"
        );
        Study::parse(text, Path::new("orders.toml")).map_err(|e| e.0)
    };
    assert_eq!(study(6, "full").expect("720 orders").file.order.period(6), 720);
    let error = study(7, "full").expect_err("5040 orders are more than people");
    assert!(error.contains("7 conditions have too many orders; allowed with \"full\": at most 6"), "{error}");
    study(7, "williams").expect("14 orders");
}

#[test]
fn every_drive_has_its_own_seed_and_every_reader_keeps_it() {
    let with_seed = |seed: u64| {
        let text = format!(
            "title = \"t\"\nparticipants = 2\nseed = {seed}\n[base]\ntraffic = \"native\"\nduration_s = 10.0\n[[condition]]\nname = \"a\"\n[[condition]]\nname = \"b\"\nset = {{ hold_s = 5.0 }}\n[[segment]]\nkind = \"trials\"\nname = \"trial\"\n"
        );
        Study::parse(text, Path::new("seeds.toml")).unwrap_or_else(|e| panic!("{e}"))
    };
    let mut seen = std::collections::BTreeSet::new();
    for seed in [1, 2, 999_999, 1_000_001] {
        let study = with_seed(seed);
        for participant in [0, 1, 2, 99, 100, 9_999] {
            for planned in study.plan(participant).items {
                let PlanItem::Drive { scenario, .. } = planned.item else { continue };
                // A double represents whole numbers up to 2^53 exactly.
                assert!(scenario.seed < 1 << 53, "{}", scenario.seed);
                seen.insert((seed % 1_000_000, participant, scenario.seed));
            }
        }
    }
    let seeds: std::collections::BTreeSet<u64> = seen.iter().map(|(_, _, seed)| *seed).collect();
    assert_eq!(seeds.len(), seen.len(), "the study, the participant and the drive make the seed");
}

#[test]
fn the_table_of_a_study_lists_each_participants_drives_and_times() {
    let text = r#"title = "Two holds"
participants = 3
order = "full"
[base]
traffic = "native"
duration_s = 90.0
vehicles = 12
policy = "pi"
range_mph = 1.5
[[condition]]
name = "short"
set = { hold_s = 2.0 }
[[condition]]
name = "long"
set = { hold_s = 20.0 }
[[segment]]
kind = "text"
name = "welcome"
text = "Hello."
[[segment]]
kind = "trials"
name = "trial"
rest_s = 30.0
[[segment]]
kind = "questions"
name = "tlx"
questionnaire = "raw-tlx"
"#;
    let study = Study::parse(text.to_owned(), Path::new("two.toml")).unwrap_or_else(|e| panic!("{e}"));
    // One word at 238 words a minute and 3 s per page; the drives and the rest have their own lengths. The questionnaire has 86 words, six
    // questions of 4 s and 2 pages.
    let questions_s = 86.0 * 60.0 / 238.0 + 6.0 * 4.0 + 2.0 * 3.0;
    let expected = (60.0 / 238.0 + 3.0 + 90.0 + 30.0 + 90.0 + questions_s) / 60.0;
    assert!((study.plan(0).minutes() - expected).abs() < 1e-9, "{}", study.plan(0).minutes());
    let expected = "\
Two holds
3 participants, 2 conditions, order full: balanced after every 2

A session, about 4 min:
   1  welcome                           0.1 min  a page to read
   2  trial-1-short                     1.5 min  90 s on ring-250, 12 vehicles, policy pi, hold 2 s, range ±1.5 mph
   3  trial-rest-1                      0.5 min  rest, 30 s
   4  trial-2-long                      1.5 min  90 s on ring-250, 12 vehicles, policy pi, hold 20 s, range ±1.5 mph
   5  tlx                               0.9 min  questions: raw-tlx

participant   order of conditions
          1   short, long
          2   long, short
          3   short, long

With 3 participants some orders are more frequent than others; with 4 all are equally frequent.
";
    assert_eq!(study.table(3), expected);
    assert!(!study.table(4).contains("more frequent than others"));
}

#[test]
fn a_name_has_at_most_forty_lower_case_letters_digits_and_hyphens() {
    let named = |name: &str| {
        let text = format!(
            "title = \"t\"\nparticipants = 2\n[base]\ntraffic = \"native\"\n[[segment]]\nkind = \"text\"\nname = \"{name}\"\ntext = \"x\"\n"
        );
        Study::parse(text, Path::new("name.toml")).map(|_| ()).map_err(|e| e.0)
    };
    for fine in ["a", "7", "trial-2", &"x".repeat(40)] {
        assert_eq!(named(fine), Ok(()), "{fine}");
    }
    for bad in ["", "Trial", "a b", "a_b", "é", "../a", &"x".repeat(41)] {
        let error = named(bad).expect_err(bad);
        assert!(error.contains("allowed: 1 to 40 small letters, digits and hyphens"), "{error}");
    }
}

#[test]
fn the_schema_knows_every_setting_of_base_and_set_and_no_other() {
    let kind = codrive::cli::schema::KINDS.iter().find(|kind| kind.name == "study").unwrap();
    let schema: serde_json::Value = serde_json::from_str(&kind.text()).unwrap();
    let resolve = |node: &serde_json::Value| -> serde_json::Value {
        let mut node = node.clone();
        let target = |node: &serde_json::Value| {
            let path = node["$ref"].as_str().or(node["allOf"][0]["$ref"].as_str())?;
            path.strip_prefix("#/definitions/").map(str::to_owned)
        };
        while let Some(name) = target(&node) {
            node = schema["definitions"][name].clone();
        }
        node
    };
    let segment = resolve(&schema["definitions"]["StudySegment"]["properties"]["set"]);
    let level = resolve(&schema["definitions"]["ConditionLevel"]["properties"]["set"]);
    for settings in [resolve(&schema["properties"]["base"]), segment, level] {
        assert_eq!(settings["additionalProperties"], false, "an editor marks range_mhp");
        assert!(
            settings["properties"]["range_mph"]["maximum"].is_number() && settings["properties"]["range_mhp"].is_null()
        );
        assert_eq!(settings["required"], serde_json::Value::Null, "each may be left out");
        assert_eq!(resolve(&settings["properties"]["idm"])["additionalProperties"], false);
    }
}
