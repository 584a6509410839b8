//! Hostile files given to the program: to `run`, to `map import`, and in a recording. Each is refused by name with file, line and remedy
//! before SUMO reads it, and no file of the user changes.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

const NOTES: &str = "what I wrote";

fn codrive(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).current_dir(folder).env("XDG_DATA_HOME", folder.join("data"));
    command.output().unwrap()
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Returns a folder with a file of the user, a network of two consecutive roads, and a scenario with a demand there.
fn home() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("notes.txt"), NOTES).unwrap();
    let net = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/networks/grid-signals.net.xml");
    fs::copy(net, at("town.net.xml")).unwrap();
    let scenario = "map = \"town.net.xml\"\npath = \"A0A1 A1A2\"\nwarm_up_s = 2.0\nduration_s = 2.0\npolicy = \"none\"\n\
                    [demand]\nfiles = [\"demand.rou.xml\"]\n";
    fs::write(at("scenario.toml"), scenario).unwrap();
    folder
}

#[test]
fn a_hostile_demand_is_refused_by_name_and_writes_nothing() {
    let home = home();
    let notes = home.path().join("notes.txt");
    let ssm = format!(
        "<routes>\n<vType id=\"t\"><param key=\"has.ssm.device\" value=\"true\"/>\n<param key=\"device.ssm.file\" value=\"{}\"/></vType>\n\
         <flow id=\"f\" from=\"A0A1\" to=\"A1A2\" begin=\"0\" end=\"100\" vehsPerHour=\"2000\" type=\"t\"/></routes>",
        notes.display()
    );
    let deep = format!("<routes>{}{}</routes>", "<a>".repeat(200_000), "</a>".repeat(200_000));
    for (demand, expected) in [
        (
            ssm.as_str(),
            "demand.rou.xml:2: param \"has.ssm.device\": the parameter names a file, an output or a device of SUMO",
        ),
        (
            "<routes><include href=\"demand.rou.xml\"/></routes>",
            "demand.rou.xml:1: include \"demand.rou.xml\": the file includes itself",
        ),
        (&deep, "demand.rou.xml:1: a: unknown element in a demand"),
        ("<routes><include href=\"/etc/hostname\"/></routes>", "href is not a file of this folder"),
    ] {
        fs::write(home.path().join("demand.rou.xml"), demand).unwrap();
        let output = codrive(home.path(), &["run", "--scenario", "scenario.toml"]);
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(expected) && text.contains("remedy"), "{expected}: {text}");
        assert_eq!(fs::read_to_string(&notes).unwrap(), NOTES);
    }
}

#[test]
fn a_hostile_network_is_refused_by_run_and_import_and_writes_nothing() {
    let home = home();
    let (town, notes) = (home.path().join("town.net.xml"), home.path().join("notes.txt"));
    let text = fs::read_to_string(&town).unwrap();
    let part = format!("<edgeData id=\"x\" freq=\"1\" file=\"{}\"/>\n</net>", notes.display());
    fs::write(&town, text.replace("</net>", &part)).unwrap();
    let line = text.lines().count();
    fs::write(home.path().join("demand.rou.xml"), "<routes/>").unwrap();
    for arguments in [
        &["run", "--scenario", "scenario.toml"][..],
        &["map", "import", "town.net.xml"],
        &["map", "show", "./town.net.xml"],
    ] {
        let output = codrive(home.path(), arguments);
        let text = printed(&output);
        assert!(!output.status.success(), "{arguments:?}: {text}");
        let expected = format!("town.net.xml:{line}: edgeData \"x\": SUMO writes or reads files for this element");
        assert!(text.contains(&expected) && text.contains("remedy: remove it"), "{arguments:?}: {text}");
        assert_eq!(fs::read_to_string(&notes).unwrap(), NOTES);
    }
    assert!(!home.path().join("data/codrive/maps/town").exists());
}

#[test]
fn a_recording_carries_what_its_demand_includes_and_replays_elsewhere() {
    let home = home();
    let at = |name: &str| home.path().join(name);
    fs::write(at("types.xml"), "<additional><vType id=\"mine\" maxSpeed=\"9\" colour=\"sky\"/></additional>").unwrap();
    let demand = "<routes><include href=\"types.xml\"/><trip id=\"a\" type=\"mine\" depart=\"1\" from=\"A0A1\" to=\"A1A2\"/></routes>";
    fs::write(at("demand.rou.xml"), demand).unwrap();
    let drive = codrive(home.path(), &["run", "--scenario", "scenario.toml", "--out", "drive"]);
    assert!(drive.status.success(), "{}", printed(&drive));
    let warnings = printed(&drive);
    assert_eq!(warnings.matches("not passed to SUMO").count(), 1, "{warnings}");
    assert!(
        warnings.contains("demand.rou.xml: not passed to SUMO, because codrive does not use it: 1 x colour of vType"),
        "{warnings}"
    );
    let kept = fs::read_to_string(at("drive/inputs/demand/0-demand.rou.xml")).unwrap();
    let expected = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<routes>\n    <vType id=\"mine\" maxSpeed=\"9\"/>\n    \
                    <trip id=\"a\" type=\"mine\" depart=\"1\" from=\"A0A1\" to=\"A1A2\"/>\n</routes>\n";
    assert_eq!(kept, expected);
    let net = fs::read_to_string(at("drive/inputs/maps/town/net.xml")).unwrap();
    assert!(
        !net.contains("<!--") && net.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<net "),
        "{}",
        &net[..200]
    );
    let elsewhere = tempfile::tempdir().unwrap();
    fs::rename(at("drive"), elsewhere.path().join("moved")).unwrap();
    drop(home);
    let replay = codrive(elsewhere.path(), &["replay", "moved"]);
    let text = String::from_utf8_lossy(&replay.stdout).into_owned() + &printed(&replay);
    assert!(replay.status.success() && text.contains("the same"), "{text}");
    for name in ["inputs/demand/0-demand.rou.xml", "inputs/maps/town/net.xml"] {
        let is_proven = text.lines().any(|line| line.split_whitespace().eq([name, "driving"]));
        assert!(is_proven, "{name} was driven with: {text}");
    }
    // The copy is canonical, so nothing is left out.
    assert!(!text.contains("not passed to SUMO"), "{text}");
}

#[test]
fn a_foreign_recording_passes_the_gate_before_its_replay() {
    let home = home();
    let at = |name: &str| home.path().join(name);
    fs::write(at("demand.rou.xml"), "<routes><trip id=\"a\" depart=\"1\" from=\"A0A1\" to=\"A1A2\"/></routes>")
        .unwrap();
    let drive = codrive(home.path(), &["run", "--scenario", "scenario.toml", "--out", "drive"]);
    assert!(drive.status.success(), "{}", printed(&drive));
    let notes = at("notes.txt").display().to_string();
    let ssm = format!("<vType id=\"t\"><param key=\"device.ssm.file\" value=\"{notes}\"/></vType>\n</routes>");
    let data = format!("<edgeData id=\"x\" freq=\"1\" file=\"{notes}\"/>\n</net>");
    for (name, end, part, expected) in [
        (
            "drive/inputs/demand/0-demand.rou.xml",
            "</routes>",
            ssm,
            "param \"device.ssm.file\": the parameter names a file, an output",
        ),
        (
            "drive/inputs/maps/town/net.xml",
            "</net>",
            data,
            "edgeData \"x\": SUMO writes or reads files for this element",
        ),
    ] {
        let whole = fs::read_to_string(at(name)).unwrap();
        fs::write(at(name), whole.replace(end, &part)).unwrap();
        let replay = codrive(home.path(), &["replay", "drive"]);
        assert!(!replay.status.success() && printed(&replay).contains(expected), "{name}: {}", printed(&replay));
        assert_eq!(fs::read_to_string(at("notes.txt")).unwrap(), NOTES);
        fs::write(at(name), whole).unwrap();
    }
}
