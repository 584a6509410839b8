//! The committed JSON Schemas: those of the code, named by each shipped file, and judged by taplo, which editors of TOML use.

use codrive::cli::schema::{FOLDER, KINDS};
use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the shipped files of a folder and those below it with this ending.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else if entry.extension().is_some_and(|e| e == ending) {
                found.push(entry);
            }
        }
    }
    found.sort();
    found
}

/// Returns the shipped TOML files that people read and change.
fn shipped() -> Vec<PathBuf> {
    ["assets/studies", "assets/wheels", "assets/populations", "maps", "docs/how-to"]
        .iter()
        .flat_map(|folder| files(folder, "toml"))
        .collect()
}

/// Lints TOML files by the schemas that their first lines name.
fn lint(files: &[PathBuf]) -> Output {
    let taplo = root().join(".test-python/bin/taplo");
    let mut command = Command::new(&taplo);
    command.args(["lint", "--no-auto-config"]).args(files).current_dir(root());
    command.output().unwrap_or_else(|why| panic!("{}: {why}; remedy: scripts/setup --test", taplo.display()))
}

#[test]
fn the_committed_schemas_are_those_of_the_code() {
    let renewed = std::env::var_os("UPDATE_EXPECT").is_some();
    let mut wanted = BTreeSet::new();
    for kind in KINDS {
        let path = root().join(kind.path());
        if renewed {
            fs::write(&path, kind.text()).unwrap();
        }
        let committed = fs::read_to_string(&path).unwrap_or_default();
        assert!(committed == kind.text(), "{} is not up to date; remedy: scripts/schemas", path.display());
        wanted.insert(path);
    }
    assert_eq!(BTreeSet::from_iter(files(FOLDER, "json")), wanted, "no other schema is there");
}

#[test]
fn every_shipped_file_names_its_schema_in_its_first_line() {
    for file in shipped() {
        let text = fs::read_to_string(&file).unwrap();
        let named = text.lines().next().and_then(|line| line.strip_prefix("#:schema "));
        let named = named.unwrap_or_else(|| panic!("{} names no schema", file.display()));
        let schema = file.parent().unwrap().join(named).canonicalize();
        assert!(schema.is_ok_and(|path| path.starts_with(root().join(FOLDER))), "{}: {named}", file.display());
    }
    for file in files("assets/questionnaires", "json") {
        let text: serde_json::Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
        assert_eq!(text["$schema"], "../schemas/questionnaire.schema.json", "{}", file.display());
    }
}

#[test]
fn an_editor_accepts_every_shipped_file() {
    let files = shipped();
    assert!(files.len() > 40, "{files:?}");
    let output = lint(&files);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Wrong files: a kind, and a text with one mistake.
const WRONG: [(&str, &str); 26] = [
    ("scenario", "vehicels = 12"),
    ("scenario", "vehicles = \"many\""),
    ("scenario", "vehicles = 1"),
    ("scenario", "hold_s = 601"),
    ("scenario", "units = \"knots\""),
    ("scenario", "[idm]\ntau = 1"),
    ("scenario", "format = 2"),
    ("scenario", "[[road_user]]\nplace_m = 30"),
    ("scenario", "[demand]\nflows = [{ from = \"a\", to = \"b\" }]"),
    ("events", "[[evnt]]\nname = \"a\""),
    ("events", "[[event]]\nname = \"a\"\ntrigger = { tim_s = 3 }\nactions = []"),
    ("events", "[[event]]\nname = \"a\"\ntrigger = { time_s = -1 }\nactions = []"),
    ("events", "[[event]]\nname = \"a\"\ntrigger = { time_s = 1 }\nactions = [{ brake = { vehicle = \"leader\" } }]"),
    ("events", "[[event]]\nname = \"a\"\nprobability = 2\ntrigger = { time_s = 1 }\nactions = []"),
    (
        "events",
        "[[event]]\nname = \"a\"\ntrigger = { time_s = 1 }\nactions = [{ takeover_request = { lead_s = 700 } }]",
    ),
    ("study", "title = \"a\"\nsegment = []"),
    ("study", "title = \"a\"\nparticipants = 0\nsegment = []"),
    ("study", "title = \"a\"\nparticipants = 1\n[[segment]]\nkind = \"txt\"\nname = \"a\""),
    ("study", "title = \"a\"\nparticipants = 1\nsegment = []\n[base]\nrange_mhp = 3"),
    ("population", "title = \"a\"\nsource = \"b\"\nmodel = \"krauss\"\nparameters = {}"),
    ("circuit", "title = \"a\"\ndescription = \"b\"\nwidth_m = 1\nspeed_limit_mps = 20\npiece = []"),
    ("circuit", "title = \"a\"\ndescription = \"b\"\nwidth_m = 4\nspeed_limit_mps = 20\n[[piece]]\nradios_m = 50"),
    ("map", "description = \"a\""),
    ("sweep", "[[drive]]\nname = \"a\""),
    ("sweep", "[[drives]]\n[drives.each]\nhold_s = 3"),
    ("train", "rings = \"all\""),
];

/// Wrong profiles of wheels: a line of the profile of the G29, and another one in its place.
const WRONG_WHEELS: [[&str; 2]; 3] = [
    ["name = \"Logitech G29\"", ""],
    ["products = [\"046d:c24f\"]", "products = [\"G29\"]"],
    ["[accelerator]", "[accelerator]\ncurve = 9"],
];

#[test]
fn an_editor_rejects_each_wrong_file() {
    let folder = tempfile::tempdir().unwrap();
    let wheel = fs::read_to_string(root().join("assets/wheels/g29.toml")).unwrap();
    let wheels = WRONG_WHEELS.map(|[from, to]| {
        assert!(wheel.contains(from), "{from}");
        let curve = wheel.replacen("curve = ", "# curve = ", 1);
        ("wheel", curve.replacen(from, to, 1))
    });
    let all = WRONG.map(|(kind, text)| (kind, text.to_owned()));
    let mut accepted = Vec::new();
    for (number, (kind, text)) in all.into_iter().chain(wheels).enumerate() {
        let schema = root().join(FOLDER).join(format!("{kind}.schema.json"));
        let body: String =
            text.lines().filter(|line| !line.starts_with("#:")).map(|line| format!("{line}\n")).collect();
        let file = folder.path().join(format!("{number}.toml"));
        fs::write(&file, format!("#:schema file://{}\n{body}", schema.display())).unwrap();
        let output = lint(&[file]);
        let said = String::from_utf8_lossy(&output.stderr);
        // A schema that taplo cannot read or a text that is not TOML would be rejected, too.
        let is_judged = said.contains("error: ") && !said.contains("invalid TOML");
        assert!(output.status.success() || is_judged, "{text}\n{said}");
        if output.status.success() {
            accepted.push(text);
        }
    }
    assert!(accepted.is_empty(), "an editor accepts:\n{}", accepted.join("\n---\n"));
}

/// Validates the JSON files among the arguments by the schema that is the first; prints those that it rejects.
const VALIDATE: &str = "
import json, pathlib, sys
import jsonschema
schema, *files = (json.loads(pathlib.Path(name).read_text()) for name in sys.argv[1:])
validator = jsonschema.Draft7Validator(schema)
print([name for name, file in zip(sys.argv[2:], files) if not validator.is_valid(file)])
";

/// Wrong questionnaires, each with one mistake.
const WRONG_QUESTIONNAIRES: [&str; 4] = [
    r#"{ "pages": [] }"#,
    r#"{ "title": "a", "pages": [], "colour": 1 }"#,
    r#"{ "title": "a", "pages": [{ "elements": [{ "type": "slider", "name": "b" }] }] }"#,
    r#"{ "title": "a", "pages": [{ "elements": [{ "type": "text", "name": "b", "isRequired": "yes" }] }] }"#,
];

#[test]
fn questionnaires_are_valid_by_their_schema_and_wrong_ones_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let wrong: Vec<PathBuf> =
        (0..WRONG_QUESTIONNAIRES.len()).map(|i| folder.path().join(format!("{i}.json"))).collect();
    wrong.iter().zip(WRONG_QUESTIONNAIRES).for_each(|(file, text)| fs::write(file, text).unwrap());
    let mut command = Command::new("python3");
    command.args(["-c", VALIDATE]).arg(root().join(FOLDER).join("questionnaire.schema.json"));
    command.args(files("assets/questionnaires", "json")).args(&wrong).env("PYTHONPATH", root().join(".test-python"));
    let output = command.output().unwrap();
    let rejected: Vec<String> = wrong.iter().map(|file| format!("'{}'", file.display())).collect();
    let printed = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    assert_eq!(printed, format!("[{}]", rejected.join(", ")), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Returns a schema that asks for no key: a text may show a part of a file.
fn without_required(mut schema: serde_json::Value) -> serde_json::Value {
    match &mut schema {
        serde_json::Value::Object(map) => {
            map.retain(|key, value| key != "required" || !value.is_array());
            map.values_mut().for_each(|value| *value = without_required(value.take()));
        }
        serde_json::Value::Array(list) => list.iter_mut().for_each(|value| *value = without_required(value.take())),
        _ => {}
    }
    schema
}

/// Returns the TOML blocks of a page with the lines at which they begin.
fn blocks(page: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut block = None;
    for (number, line) in page.lines().enumerate() {
        match (line.strip_prefix("```"), block) {
            (Some(kind), None) => {
                block = Some(kind.starts_with("toml"));
                if block == Some(true) {
                    found.push((number + 1, String::new()));
                }
            }
            (Some(_), Some(_)) => block = None,
            (None, Some(true)) => found.last_mut().expect("a block has begun").1 += &format!("{line}\n"),
            _ => {}
        }
    }
    found
}

#[test]
fn every_file_that_the_documents_show_is_of_a_kind() {
    let folder = tempfile::tempdir().unwrap();
    for kind in KINDS {
        let schema = without_required(serde_json::from_str(&kind.text()).unwrap());
        fs::write(folder.path().join(format!("{}.json", kind.name)), schema.to_string()).unwrap();
    }
    let mut seen = 0;
    for page in files("docs", "md") {
        for (line, text) in blocks(&fs::read_to_string(&page).unwrap()) {
            // Controllers and policies have no schema: one key says which parameters there are.
            if text.contains("format = \"codrive controller 1\"") {
                continue;
            }
            seen += 1;
            let is_of = |kind: &str| {
                let file = folder.path().join("block.toml");
                fs::write(&file, format!("#:schema file://{}\n{text}", folder.path().join(kind).display())).unwrap();
                lint(&[file])
            };
            let fits = KINDS.iter().any(|kind| is_of(&format!("{}.json", kind.name)).status.success());
            let why = String::from_utf8_lossy(&is_of("scenario.json").stderr).into_owned();
            assert!(fits, "{}:{line} is of no kind; as a scenario: {why}", page.display());
        }
    }
    // A test that finds no blocks would pass, too.
    assert!(seen >= 20, "{seen}");
}
