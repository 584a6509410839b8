//! Written files are readable by the user only, contain no paths of the machine that made them, and can be driven again elsewhere.

use assert_cmd::Command;
use codrive::record::{TableReader, tables};
use std::{
    fs,
    path::{Path, PathBuf},
};

fn codrive(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Returns the paths of all files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Returns the text of a file: its bytes, and for a table also the texts of all columns, which are compressed.
fn printed(path: &Path) -> String {
    let mut printed = String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
    if path.extension().is_some_and(|kind| kind == "parquet") {
        let table = TableReader::parquet(path).unwrap();
        let names = tables::EVENTS.iter().map(|column| column.name);
        let names = names.chain(tables::EGO.iter().map(|column| column.name));
        names.for_each(|name| printed += &table.words(name).join("\n"));
    }
    printed
}

/// A home with a map and a policy, from which a study, a recording and a rehearsal can be made.
struct Author {
    scratch: tempfile::TempDir,
}

impl Author {
    fn new() -> Self {
        let scratch = tempfile::tempdir().unwrap();
        let author = Self { scratch };
        let home = author.at("ann");
        fs::create_dir(&home).unwrap();
        author.run(&["map", "ring", "--circumference", "251", "--out", text(&home.join("own ring"))]);
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/policies/ring-250-speed/policy.toml");
        fs::copy(shipped, home.join("calm.toml")).unwrap();
        author
    }

    fn at(&self, name: &str) -> PathBuf {
        self.scratch.path().canonicalize().unwrap().join(name)
    }

    /// Runs the program in the author's home.
    fn run(&self, arguments: &[&str]) {
        codrive(arguments).env("HOME", self.at("ann")).current_dir(self.at("ann")).assert().success();
    }

    /// Records a drive on the author's map with the author's policy.
    fn record(&self) -> PathBuf {
        let (map, policy, recording) = (self.at("ann/own ring"), self.at("ann/calm.toml"), self.at("recording"));
        let drive = ["run", "--traffic", "native", "--duration", "3"];
        let from = ["--map", text(&map), "--policy", text(&policy), "--out", text(&recording)];
        self.run(&[&drive[..], &from].concat());
        recording
    }
}

#[test]
fn no_written_file_contains_a_path_of_its_author() {
    let author = Author::new();
    let recording = author.record();
    let policy = format!("policy={}", text(&author.at("ann/calm.toml")));
    author.run(&["replay", text(&recording), "--what-if", &policy]);
    author.run(&["analyse", text(&recording)]);
    let study = format!(
        "title = \"Short\"\nparticipants = 1\n[base]\ntraffic = \"native\"\nduration_s = 2.0\nmap = \"{map}\"\n[factors]\n\
         advice = [{{ name = \"own\", set = {{ policy = \"{policy}\" }} }}, {{ name = \"other\" }}]\n[[segment]]\n\
         kind = \"trials\"\nname = \"trial\"\ntext = \"Drive.\"\n[[segment]]\nkind = \"questions\"\nname = \"load\"\n\
         questionnaire = \"raw-tlx\"\n",
        map = text(&author.at("ann/own ring")),
        policy = text(&author.at("ann/calm.toml"))
    );
    let (file, data) = (author.at("ann/short.toml"), author.at("data"));
    fs::write(&file, study).unwrap();
    // The second run recognizes the data set as that of the same study.
    for _ in 0..2 {
        author.run(&["study", "rehearse", text(&file), "--out", text(&data)]);
    }
    author.run(&["analyse", text(&data)]);

    let root = author.at("");
    let mut found: Vec<PathBuf> = fs::read_dir(&root).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.retain(|path| !path.ends_with("ann"));
    assert_eq!(found.len(), 3, "recording, what if and data set: {found:?}");
    let files: Vec<PathBuf> = found.iter().flat_map(|folder| files(folder)).collect();
    assert!(files.len() > 60, "{} files", files.len());
    let secrets = [text(&root).trim_end_matches('/'), "/ann", env!("CARGO_MANIFEST_DIR")];
    for path in &files {
        let printed = printed(path);
        for secret in secrets {
            assert!(!printed.contains(secret), "{} names {secret}", path.display());
            let name = path.strip_prefix(&root).unwrap().to_str().unwrap();
            assert!(!name.contains(&secret.replace('/', "-")), "{name} tells of {secret}");
        }
    }
}

#[test]
fn a_recording_drives_again_without_its_authors_files() {
    let author = Author::new();
    let recording = author.record();
    let elsewhere = author.at("elsewhere");
    fs::create_dir(&elsewhere).unwrap();
    fs::rename(&recording, elsewhere.join("copy")).unwrap();
    fs::rename(author.at("ann"), author.at("gone")).unwrap();
    let same = |arguments: &[&str]| {
        let output = codrive(arguments).current_dir(&elsewhere).output().unwrap();
        let printed = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && printed.contains("all 300 ticks are the same to the bit"), "{printed}");
    };
    same(&["replay", "copy"]);
    codrive(&["replay", "copy", "--what-if", "none"]).current_dir(&elsewhere).assert().success();
    assert!(elsewhere.join("copy-what-if-policy-none-driver-idm/inputs/maps/own ring/net.xml").exists());
    codrive(&["analyse", "copy"]).current_dir(&elsewhere).assert().success();

    // A change to the files that the recording includes is found as in its tables.
    let about = elsewhere.join("copy/inputs/maps/own ring/map.toml");
    let was = fs::read(&about).unwrap();
    fs::write(&about, [&was[..], b"# changed\n"].concat()).unwrap();
    let output = codrive(&["replay", "copy"]).current_dir(&elsewhere).output().unwrap();
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && printed.contains("inputs/maps/own ring/map.toml: is not as it was written"),
        "{printed}"
    );
    fs::write(&about, was).unwrap();
    same(&["replay", "copy"]);
}

#[cfg(unix)]
#[test]
fn only_the_user_can_read_what_a_command_writes() {
    use std::os::unix::fs::PermissionsExt;
    let author = Author::new();
    let recording = author.record();
    let made = author.at("made");
    let at = |name: &str| text(&made.join(name)).to_owned();
    let circuit = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/practice/circuit.toml");
    author.run(&["map", "ring", "--circumference", "251", "--out", &at("ring")]);
    author.run(&["map", "circuit", text(&circuit), "--out", &at("circuit")]);
    author.run(&[
        "train",
        "--iterations",
        "1",
        "--batch",
        "1000",
        "--horizon",
        "20",
        "--warm-up",
        "0",
        "--out",
        &at("train"),
    ]);
    author.run(&["evaluate", "--policy", "none", "--over", "2", "--horizon", "1", "--out", &at("evaluate")]);
    author.run(&["analyse", text(&recording), "--out", &at("analysis")]);
    let picture = ["--size", "64x36", "--png"];
    author.run(&[&["replay", text(&recording), "--at", "1"][..], &picture, &[&at("replay.png")]].concat());
    author.run(&["replay", text(&recording), "--size", "64x36", "--rate", "1", "--frames-dir", &at("frames")]);
    author.run(&["render", "--traffic", "native", "--at", "0", "--size", "64x36", "--out", &at("render.png")]);
    let files = files(&made);
    assert!(files.len() > 30, "{files:?}");
    for path in &files {
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(path), 0o600, "{}", path.display());
        assert_eq!(mode(path.parent().unwrap()), 0o700, "{}", path.parent().unwrap().display());
    }
}

#[cfg(unix)]
#[test]
fn no_command_writes_through_a_planted_link() {
    use std::os::unix::fs::symlink;
    let author = Author::new();
    let recording = author.record();
    let [victim, link, sound] = ["victim", "planted.png", "planted.wav"].map(|name| author.at(name));
    let refused = |arguments: &[&str]| {
        let output = codrive(arguments).current_dir(author.at("")).output().unwrap();
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{arguments:?}");
        printed
    };
    for there in [true, false] {
        if there {
            fs::write(&victim, "mine").unwrap();
        } else {
            fs::remove_file(&victim).unwrap();
        }
        symlink(&victim, &link).unwrap();
        symlink(&victim, &sound).unwrap();
        let small = ["--size", "64x36"];
        let printed = refused(&[&["replay", text(&recording), "--at", "1", "--png", text(&link)][..], &small].concat());
        assert!(printed.contains("planted.png") && printed.contains("symbolic link"), "{printed}");
        let drive = ["render", "--traffic", "native", "--at", "0", "--out", text(&link)];
        assert!(refused(&[&drive[..], &small].concat()).contains("symbolic link"));
        for (option, link) in [("--frames-dir", &link), ("--video", &link), ("--wav", &sound)] {
            let printed = refused(&[&["replay", text(&recording), option, text(link)][..], &small].concat());
            assert!(printed.contains("planted."), "{option}: {printed}");
        }
        assert_eq!(fs::read_to_string(&victim).unwrap_or_default(), if there { "mine" } else { "" });
        fs::remove_file(&link).unwrap();
        fs::remove_file(&sound).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_participants_folder_that_is_a_link_is_refused() {
    use std::os::unix::fs::symlink;
    let author = Author::new();
    let (study, data, elsewhere) = (author.at("study.toml"), author.at("data"), author.at("elsewhere"));
    let drive = "title = \"Short\"\nparticipants = 2\n[base]\ntraffic = \"native\"\nduration_s = 1.0\n[[segment]]\n\
                 kind = \"drive\"\nname = \"drive\"\ntext = \"Drive.\"\n";
    fs::write(&study, drive).unwrap();
    fs::create_dir(&elsewhere).unwrap();
    let rehearse = |participants: &str| {
        codrive(&["study", "rehearse", text(&study), "--participants", participants, "--out", text(&data)])
    };
    rehearse("1").assert().success();
    for name in ["sourcedata/sub-R02", "sub-R02"] {
        symlink(&elsewhere, data.join(name)).unwrap();
        let output = rehearse("2").output().unwrap();
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{printed}");
        assert!(printed.contains(name) && printed.contains("symbolic link") && printed.contains("remedy"), "{printed}");
        assert_eq!(fs::read_dir(&elsewhere).unwrap().count(), 0, "nothing was written through it");
        fs::remove_file(data.join(name)).unwrap();
    }
    rehearse("2").assert().success();
}

#[test]
fn a_recording_includes_the_authors_own_map_but_not_shipped_maps() {
    // A data folder of the program as on another machine, with one more map.
    let author = Author::new();
    let (project, root) = (Path::new(env!("CARGO_MANIFEST_DIR")), author.at("program"));
    for name in codrive::map::SHIPPED {
        let folder = root.join("maps").join(name);
        fs::create_dir_all(&folder).unwrap();
        for file in fs::read_dir(project.join("maps").join(name)).unwrap().map(|entry| entry.unwrap().path()) {
            fs::copy(&file, folder.join(file.file_name().unwrap())).unwrap();
        }
    }
    let own = root.join("maps/own");
    author.run(&["map", "ring", "--circumference", "252", "--out", text(&own)]);
    for (map, carried) in [("own", true), ("practice", false)] {
        let recording = author.at(map);
        let drive = ["run", "--traffic", "native", "--vehicles", "12", "--duration", "2", "--map", map];
        let mut command = codrive(&[&drive[..], &["--out", text(&recording)]].concat());
        command.env("CODRIVE_DATA", &root).assert().success();
        assert_eq!(recording.join("inputs").exists(), carried);
        fs::rename(&own, root.join("gone")).unwrap();
        codrive(&["replay", text(&recording)]).env("CODRIVE_DATA", &root).assert().success();
        fs::rename(root.join("gone"), &own).unwrap();
    }
}
