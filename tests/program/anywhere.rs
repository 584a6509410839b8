//! The program outside its checkout: alone in a folder with spaces and umlauts, called from another folder, by another user without a home,
//! and in a read-only folder.

use std::{
    fs,
    os::unix::fs::{MetadataExt, PermissionsExt},
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// A copy of the program at `bin/codrive` in its own folder, without any other file of the project.
struct Elsewhere {
    folder: tempfile::TempDir,
}

impl Elsewhere {
    fn new() -> Self {
        let folder = tempfile::Builder::new().prefix("Über Räder und Straßen ").tempdir().unwrap();
        for name in ["bin", "home", "work", "tmp"] {
            fs::create_dir(folder.path().join(name)).unwrap();
        }
        let program = folder.path().join("bin/codrive");
        let built = env!("CARGO_BIN_EXE_codrive");
        fs::hard_link(built, &program).or_else(|_| fs::copy(built, &program).map(drop)).unwrap();
        Self { folder }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Returns the program's command, called from `work`, with only a home and a folder for temporary files in its environment.
    fn command(&self) -> Command {
        self.program(Command::new(self.at("bin/codrive")))
    }

    fn program(&self, mut command: Command) -> Command {
        command.env_clear().env("HOME", self.at("home")).env("TMPDIR", self.at("tmp")).current_dir(self.at("work"));
        command
    }

    /// Returns the command as run by another user if the tests run as root, because permissions do not bind root; otherwise as this user.
    fn stranger(&self) -> Command {
        if fs::metadata("/proc/self").unwrap().uid() != 0 {
            return self.command();
        }
        let mut command = Command::new("setpriv");
        command.args(["--reuid", "65534", "--regid", "65534", "--clear-groups"]).arg(self.at("bin/codrive"));
        self.program(command)
    }
}

fn run(command: &mut Command) -> Output {
    command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"))
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// Maps in the folder `maps/` of the project.
const MAPS: [&str; 12] = [
    "bottleneck",
    "figure-eight",
    "grid",
    "lane-10km",
    "merge",
    "motorway",
    "practice",
    "ring-250",
    "ring-260",
    "ring-641",
    "town",
    "two-lane-ring",
];

fn maps(list: &str) -> Vec<&str> {
    list.lines().filter_map(|line| line.split_whitespace().next()).collect()
}

const DRIVE: [&str; 5] = ["run", "--traffic", "native", "--duration", "2"];

#[test]
fn the_file_alone_lists_its_maps_and_drives_with_its_shipped_policy() {
    let elsewhere = Elsewhere::new();
    let listed = run(elsewhere.command().args(["map", "list"]));
    assert!(listed.status.success(), "{}", printed(&listed));
    assert_eq!(maps(&printed(&listed)), MAPS);
    let out = elsewhere.at("work/über alles");
    let drove = run(elsewhere.command().args(DRIVE).arg("--out").arg(&out));
    assert!(drove.status.success() && printed(&drove).contains("policy ring-250-speed (auto"), "{}", printed(&drove));
    let again = run(elsewhere.command().arg("replay").arg(&out));
    assert!(again.status.success() && printed(&again).contains("the same to the bit"), "{}", printed(&again));
    let study = elsewhere.at("study.toml");
    fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/studies/congestion.toml"), &study).unwrap();
    let checked = run(elsewhere.command().args(["study", "check"]).arg(&study));
    assert!(checked.status.success(), "questionnaires are in the program, too: {}", printed(&checked));
}

#[test]
fn every_map_has_a_scenario_that_its_name_drives() {
    let elsewhere = Elsewhere::new();
    let sumo = Path::new(env!("CARGO_MANIFEST_DIR")).join(".sumo/sumo");
    for name in MAPS {
        // On a road that vehicles enter, the ego waits for room; without a warm-up there is some.
        let asked = ["run", "--scenario", name, "--duration", "1", "--warm-up", "0", "--trees", "0"];
        // SUMO opens a file whose path has other letters than ASCII only in a locale that has them.
        let drove = run(elsewhere.command().args(asked).env("CODRIVE_SUMO_HOME", &sumo).env("LC_ALL", "C.UTF-8"));
        assert!(drove.status.success() && printed(&drove).contains(name), "{name}: {}", printed(&drove));
        assert!(!printed(&drove).contains("no effect"), "{name}: {}", printed(&drove));
    }
    let refused = run(elsewhere.command().args(["run", "--scenario", "twon"]));
    assert_eq!(refused.status.code(), Some(2));
    assert!(printed(&refused).contains("did you mean town?"), "{}", printed(&refused));
}

#[test]
fn drives_in_processes_of_their_own_have_the_maps_of_the_named_folder() {
    let elsewhere = Elsewhere::new();
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copied = |from: &str, to: &str| {
        let to = elsewhere.at("named").join("maps").join(to);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(project.join("maps").join(from), to).unwrap();
    };
    copied("ring-250/net.xml", "ring-250/net.xml");
    for file in ["net.xml", "map.toml", "demand.rou.xml"] {
        copied(&format!("merge/{file}"), &format!("slip-road/{file}"));
    }
    let asked = "evaluate --map slip-road --traffic sumo --policy pi --advised 10% --warm-up 0 --horizon 5 --over 2";
    let mut command = elsewhere.command();
    command.args(asked.split(' ')).arg("--data").arg(elsewhere.at("named"));
    let drove = run(command.env("CODRIVE_SUMO_HOME", project.join(".sumo/sumo")).env("LC_ALL", "C.UTF-8"));
    assert!(drove.status.success(), "{}", printed(&drove));
}

#[test]
fn own_maps_are_found_in_the_home_and_without_a_home_a_remedy_is_given() {
    let elsewhere = Elsewhere::new();
    let made = run(elsewhere.command().args(["map", "ring", "--circumference", "300"]));
    assert!(made.status.success() && printed(&made).contains("codrive --map ring-300"), "{}", printed(&made));
    assert!(elsewhere.at("home/.local/share/codrive/maps/ring-300/net.xml").is_file());
    let listed = run(elsewhere.command().args(["map", "list"]));
    // Its own map stands before ring-641.
    assert_eq!(maps(&printed(&listed)), [&MAPS[..9], &["ring-300"], &MAPS[9..]].concat());
    let drove = run(elsewhere.command().args(DRIVE).args(["--map", "ring-300", "--policy", "pi"]));
    assert!(drove.status.success() && printed(&drove).contains("22 vehicles on ring-300"), "{}", printed(&drove));
    let refused = run(elsewhere.command().env_remove("HOME").args(["map", "ring", "--circumference", "300"]));
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        printed(&refused).contains("no home folder is set") && printed(&refused).contains("--out DIR"),
        "{}",
        printed(&refused)
    );
}

#[test]
fn another_user_without_a_home_drives_and_leaves_one_temporary_folder() {
    let elsewhere = Elsewhere::new();
    for name in ["", "bin", "tmp", "work"] {
        fs::set_permissions(elsewhere.at(name), fs::Permissions::from_mode(0o777)).unwrap();
    }
    for _ in 0..2 {
        let drove = run(elsewhere.stranger().env_remove("HOME").args(DRIVE));
        assert!(drove.status.success(), "{}", printed(&drove));
    }
    let left: Vec<PathBuf> = fs::read_dir(elsewhere.at("tmp")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let [own] = &left[..] else { panic!("{left:?}") };
    assert!(own.file_name().unwrap().to_string_lossy().starts_with("codrive-"), "{own:?}");
    assert_eq!(fs::metadata(own).unwrap().mode() & 0o077, 0, "others neither see nor change it");
    // A folder that others can write to is not trusted.
    fs::set_permissions(own, fs::Permissions::from_mode(0o777)).unwrap();
    let refused = run(elsewhere.stranger().env_remove("HOME").args(DRIVE));
    assert!(
        refused.status.code() == Some(2) && printed(&refused).contains("other users can write to it"),
        "{}",
        printed(&refused)
    );
}

#[test]
fn an_installed_program_reads_its_read_only_share_folder() {
    let elsewhere = Elsewhere::new();
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    let share = elsewhere.at("share/codrive");
    for name in ["maps/ring-250/net.xml", "maps/ring-250/map.toml", "assets/policies/ring-250-speed/policy.toml"] {
        let file = share.join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::copy(project.join(name), &file).unwrap();
    }
    let text = fs::read_to_string(share.join("maps/ring-250/map.toml")).unwrap();
    fs::write(share.join("maps/ring-250/map.toml"), text.replacen("title = \"", "title = \"Installed: ", 1)).unwrap();
    for name in ["share", "share/codrive", "share/codrive/maps", "share/codrive/maps/ring-250", "bin", ""] {
        fs::set_permissions(elsewhere.at(name), fs::Permissions::from_mode(0o555)).unwrap();
    }
    for name in ["home", "tmp", "work"] {
        fs::set_permissions(elsewhere.at(name), fs::Permissions::from_mode(0o777)).unwrap();
    }
    let listed = run(elsewhere.stranger().args(["map", "list"]));
    assert!(printed(&listed).contains("Installed: "), "{}", printed(&listed));
    let drove = run(elsewhere.stranger().args(DRIVE));
    assert!(drove.status.success(), "{}", printed(&drove));
    assert!(!elsewhere.at("home/.cache").exists(), "nothing had to be unpacked");
    fs::set_permissions(elsewhere.at(""), fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn a_named_folder_comes_first_and_one_without_data_is_refused_by_name() {
    let elsewhere = Elsewhere::new();
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    let named = elsewhere.at("named");
    fs::create_dir_all(named.join("maps/ring-250")).unwrap();
    fs::copy(project.join("maps/ring-250/net.xml"), named.join("maps/ring-250/net.xml")).unwrap();
    for how in [&["--data", "named"][..], &["map", "list", "--data", "named"]] {
        let mut command = elsewhere.command();
        command.current_dir(elsewhere.at("")).args(how);
        let listed = run(if how.len() == 2 { command.args(["map", "list"]) } else { &mut command });
        assert_eq!(maps(&printed(&listed)), ["ring-250"], "{how:?}");
    }
    let by_environment = run(elsewhere.command().env("CODRIVE_DATA", &named).args(["map", "list"]));
    assert_eq!(maps(&String::from_utf8_lossy(&by_environment.stdout)), ["ring-250"]);
    // A variable may be set and forgotten, so the program prints the folder that it names.
    let line = format!("codrive: maps and policies come from {} (CODRIVE_DATA)\n", named.display());
    assert_eq!(String::from_utf8_lossy(&by_environment.stderr), line);
    let wrong = elsewhere.at("work");
    let refused = run(elsewhere.command().arg("map").arg("list").arg("--data").arg(&wrong));
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        printed(&refused).contains("work, named by --data, does not hold maps/ring-250/net.xml"),
        "{}",
        printed(&refused)
    );
    let refused = run(elsewhere.command().env("CODRIVE_DATA", &wrong).args(DRIVE));
    assert!(
        refused.status.code() == Some(2) && printed(&refused).contains("named by CODRIVE_DATA"),
        "{}",
        printed(&refused)
    );
}

/// Builds a library that creates the file `victim` when it is loaded, and a program that does so when it runs.
fn hostile(elsewhere: &Elsewhere, victim: &Path) {
    let source = elsewhere.at("hostile.c");
    let text = format!(
        "#include <stdio.h>\n__attribute__((constructor)) static void f(void) {{ fclose(fopen(\"{}\", \"w\")); }}\n",
        victim.display()
    );
    fs::write(&source, text).unwrap();
    let library = elsewhere.at("hostile.so");
    let built = Command::new("cc").arg("-shared").arg("-fPIC").arg(&source).arg("-o").arg(&library).output().unwrap();
    assert!(built.status.success(), "{}", printed(&built));
    for folder in [elsewhere.at(""), elsewhere.at("work")] {
        for name in [".sumo/sumo/lib/libsumocpp.so", ".lsl/liblsl.so.2", "libcodrive_sumo.so", "libSDL2-2.0.so.0"] {
            let place = folder.join(name);
            fs::create_dir_all(place.parent().unwrap()).unwrap();
            fs::copy(&library, place).unwrap();
        }
        let converter = folder.join(".sumo/sumo/bin/netconvert");
        fs::create_dir_all(converter.parent().unwrap()).unwrap();
        fs::write(&converter, format!("#!/bin/sh\n: >'{}'\n", victim.display())).unwrap();
        fs::set_permissions(&converter, fs::Permissions::from_mode(0o755)).unwrap();
        for module in
            ["codrive/__init__.py", "codrive_sim/__init__.py", "codrive_sim/sweep.py", "ray.py", "runpy.py", "json.py"]
        {
            let place = folder.join(module);
            fs::create_dir_all(place.parent().unwrap()).unwrap();
            fs::write(place, format!("open({:?}, 'w')\n", victim.display().to_string())).unwrap();
        }
        // The settings file of liblsl may name a file that liblsl writes.
        fs::write(folder.join("lsl_api.cfg"), format!("[log]\nlevel = 9\nfile = {}\n", victim.display())).unwrap();
    }
}

#[test]
fn no_library_or_program_of_the_working_folder_or_above_is_run() {
    let elsewhere = Elsewhere::new();
    let victim = elsewhere.at("victim");
    hostile(&elsewhere, &victim);
    fs::write(elsewhere.at("work/town.osm"), "<osm/>").unwrap();
    let drive = ["run", "--traffic", "sumo", "--duration", "1"];
    let sweep = ["sweep", "plan.toml", "--on", "ray", "--out", "results"];
    for arguments in [&drive[..], &["map", "import", "town.osm"], &["doctor"], &sweep] {
        let ended = run(elsewhere.command().args(arguments));
        assert!(!victim.exists(), "{arguments:?}: {}", printed(&ended));
    }
    let refused = run(elsewhere.command().args(drive));
    assert!(
        refused.status.code() == Some(1) && printed(&refused).contains("SUMO was not found"),
        "{}",
        printed(&refused)
    );
    // The library is a working one: the program loads it from a folder that the user names.
    let home = elsewhere.at("work/.sumo/sumo");
    let loaded = run(elsewhere.command().args(drive).env("CODRIVE_SUMO_HOME", &home));
    assert!(victim.exists(), "{}", printed(&loaded));
}

#[test]
fn maps_of_the_working_folder_or_above_are_not_the_programs() {
    let elsewhere = Elsewhere::new();
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in [elsewhere.at("maps"), elsewhere.at("work/maps")] {
        fs::create_dir_all(folder.join("ring-250")).unwrap();
        fs::create_dir_all(folder.join("surprise")).unwrap();
        for map in ["ring-250", "surprise"] {
            fs::copy(project.join("maps/ring-250/net.xml"), folder.join(map).join("net.xml")).unwrap();
        }
    }
    let listed = run(elsewhere.command().args(["map", "list"]));
    assert_eq!(maps(&printed(&listed)), MAPS);
}
