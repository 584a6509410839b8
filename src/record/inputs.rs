//! Input files of a drive, copied into its recording. In: a scenario whose map, policy, population, demand or log is the user's own. Out: copies
//! in `inputs/`, and the scenario with paths to these copies. Network and demand are copied in the canonical form that SUMO has
//! read, with all files that a demand includes. So the drive can be driven again on another machine, and the scenario does not
//! reveal the user's folders. Shipped maps and policies keep their names.

use super::{RecordError, files, streams};
use crate::{
    file::read_bounded,
    map::{self, limits::MOST_BYTES},
    policy,
    scenario::Scenario,
    settings::SettingsError,
    sim::World,
    sumo_xml::stream,
    traffic::{Demand, EngineChoice, is_population_path},
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Folder of the copies, in the recording.
pub const INPUTS: &str = "inputs";

/// Returns the scenario as a recording keeps it.
pub fn portable(world: &World) -> Scenario {
    let scenario = world.scenario();
    let map = if map::is_own(&scenario.map) { map_place(world) } else { scenario.map.clone() };
    let policy = match &scenario.policy {
        path if policy::is_path(path) => format!("{INPUTS}/policies/{}", last(path)),
        // A name such as `auto` may resolve to another policy elsewhere.
        _ => world.policy().name.clone(),
    };
    let traffic_drivers = match &scenario.traffic_drivers {
        path if is_population_path(path) => format!("{INPUTS}/populations/{}", last(path)),
        name => name.clone(),
    };
    let traffic = match &scenario.traffic {
        EngineChoice::Log(file) => EngineChoice::Log(format!("{INPUTS}/traffic/{}", last(file))),
        engine => engine.clone(),
    };
    let mut kept = Scenario { map, policy, traffic, traffic_drivers, ..scenario.clone() };
    for (k, file) in kept.demand.input_files_mut().enumerate() {
        *file = demand_place(k, file);
    }
    kept
}

/// Returns the path of the `k`-th file of a demand in a recording; the number separates files of the same name.
fn demand_place(k: usize, file: &Path) -> PathBuf {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let name = name.trim_end_matches(".gz");
    Path::new(INPUTS).join("demand").join(format!("{k}-{name}"))
}

fn map_place(world: &World) -> String {
    format!("{INPUTS}/maps/{}", last(&world.map().name))
}

/// Copies into a recording the files that its scenario names by path.
///
/// # Errors
/// A file can no longer be read, or an I/O error.
pub fn carry(recording: &Path, world: &World) -> Result<(), RecordError> {
    let scenario = world.scenario();
    let copy_up_to = |most_bytes: u64, from: &Path, to: &Path| {
        files::new_dir_within(recording, to.parent().unwrap_or(recording))?;
        files::write_new(to, &read_bounded(from, most_bytes).map_err(RecordError::file(from))?)
    };
    // A network is the largest input: everything loaded before the drive is within its limit, except files of demand.
    let copy = |from: &Path, to: &Path| copy_up_to(MOST_BYTES, from, to);
    if map::is_own(&scenario.map) {
        let (net, folder) = (&world.map().net_file, recording.join(map_place(world)));
        files::new_dir_within(recording, &folder)?;
        files::write_new(&folder.join("net.xml"), world.map().network.sumo_text().as_str().as_bytes())?;
        // The folder of a map also holds its title and its route.
        let about = net.with_file_name("map.toml");
        if net.ends_with("net.xml") && about.is_file() {
            copy(&about, &folder.join("map.toml"))?;
        }
    }
    let copies = world.demand().into_iter().flat_map(Demand::input_files);
    for (k, (file, copied)) in scenario.demand.input_files().zip(copies).enumerate() {
        copy_up_to(stream::MOST_BYTES, copied, &recording.join(demand_place(k, file)))?;
    }
    if is_population_path(&scenario.traffic_drivers) {
        copy(Path::new(&scenario.traffic_drivers), &recording.join(portable(world).traffic_drivers))?;
    }
    if let Some(file) = scenario.traffic.log_file() {
        copy(file, &recording.join(portable(world).traffic.to_string()))?;
    }
    if policy::is_path(&scenario.policy) {
        let (own, place) = (Path::new(&scenario.policy), recording.join(portable(world).policy));
        let home = own.parent().unwrap_or(Path::new(""));
        // The network's file and the files it depends on, at their relative paths.
        for file in policy::files_of(own) {
            let to = file.strip_prefix(home).map_or(place.clone(), |within| place.with_file_name("").join(within));
            copy(&file, &to)?;
        }
    }
    Ok(())
}

/// Returns the sorted names of a recording's inputs and device streams, relative to its folder.
pub(super) fn carried(recording: &Path) -> Result<Vec<String>, RecordError> {
    let (mut names, mut folders) = (Vec::new(), vec![INPUTS.to_owned(), streams::FOLDER.to_owned()]);
    while let Some(folder) = folders.pop() {
        let path = recording.join(&folder);
        if !files::is_there(&path)? {
            continue;
        }
        for entry in fs::read_dir(&path).map_err(RecordError::file(&path))? {
            let entry = entry.map_err(RecordError::file(&path))?;
            let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() { folders.push(name) } else { names.push(name) }
        }
    }
    names.sort();
    Ok(names)
}

/// Reads the scenario of a recording. Paths to its inputs are resolved relative to the recording's folder.
///
/// # Errors
/// The scenario cannot be read, or is not as this program writes it.
pub fn scenario(recording: &Path) -> Result<Scenario, SettingsError> {
    Scenario::from_file(&recording.join(SCENARIO))
}

/// File name of the scenario.
pub const SCENARIO: &str = "scenario.toml";

/// Returns the last part of a name or path, to be shown in place of the whole.
pub fn last(name: &str) -> &str {
    name.trim_end_matches(['/', '\\']).rsplit(['/', '\\']).next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data_folders;

    /// Makes a user's own map: the shipped ring under another name, as a folder or as a bare network.
    fn own_map(folder: &Path, net: &str) -> PathBuf {
        let shipped = data_folders::root().join("maps/ring-250");
        fs::create_dir_all(folder).expect("a folder");
        fs::copy(shipped.join("net.xml"), folder.join(net)).expect("copied");
        fs::copy(shipped.join("map.toml"), folder.join("map.toml")).expect("copied");
        if net == "net.xml" { folder.into() } else { folder.join(net) }
    }

    fn world(map: &Path, policy: &str) -> World {
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            map: map.to_str().expect("a name").into(),
            policy: policy.into(),
            ..Scenario::default()
        };
        World::new(&scenario).unwrap_or_else(|e| panic!("{e}"))
    }

    fn kept(map: &Path, policy: &str) -> [String; 2] {
        let Scenario { map, policy, .. } = portable(&world(map, policy));
        [map, policy]
    }

    #[test]
    fn shipped_inputs_keep_their_names_and_own_inputs_get_recording_paths() {
        let home = tempfile::tempdir().expect("a folder");
        let (shipped, own) = (Path::new("ring-250"), own_map(&home.path().join("mine"), "net.xml"));
        let calm = home.path().join("calm.toml");
        fs::copy(data_folders::root().join("assets/policies/ring-250-speed/policy.toml"), &calm).expect("copied");
        let calm = calm.to_str().expect("a name");
        // A name such as `auto` may resolve to another policy elsewhere.
        assert_eq!(kept(shipped, "auto"), ["ring-250", "ring-250-speed"]);
        assert_eq!(kept(shipped, "pi"), ["ring-250", "pi"]);
        assert_eq!(kept(shipped, calm), ["ring-250", "inputs/policies/calm.toml"]);
        assert_eq!(kept(&own, "pi"), ["inputs/maps/mine", "pi"]);
        let road = map::RoadMap::load(own.to_str().expect("a name")).expect("a map");
        let chosen = policy::resolve("auto", &road).name;
        assert!(chosen != "auto" && kept(&own, "auto") == ["inputs/maps/mine", &chosen], "{chosen}");
        assert_eq!(kept(&own, calm), ["inputs/maps/mine", "inputs/policies/calm.toml"]);
    }

    #[test]
    fn a_network_is_copied_with_the_title_of_its_own_map_only() {
        let home = tempfile::tempdir().expect("a folder");
        let carried_of = |map: &Path, policy: &str, to: &str| {
            let recording = home.path().join(to);
            fs::create_dir(&recording).expect("a folder");
            carry(&recording, &world(map, policy)).expect("room");
            carried(&recording).expect("readable")
        };
        assert!(carried_of(Path::new("ring-250"), "pi", "a").is_empty(), "nothing of the author's");
        let whole = own_map(&home.path().join("mine"), "net.xml");
        assert_eq!(carried_of(&whole, "pi", "b"), ["inputs/maps/mine/map.toml", "inputs/maps/mine/net.xml"]);
        fs::remove_file(whole.join("map.toml")).expect("there");
        assert_eq!(carried_of(&whole, "pi", "c"), ["inputs/maps/mine/net.xml"]);
        // A map.toml beside a bare network belongs to another map.
        let bare = own_map(&home.path().join("nets"), "other.net.xml");
        let names = carried_of(&bare, "pi", "d");
        assert!(names.len() == 1 && names[0].ends_with("/net.xml"), "{names:?}");
        let copy = fs::read(home.path().join("b/inputs/maps/mine/net.xml")).expect("carried");
        assert_eq!(copy, fs::read(whole.join("net.xml")).expect("there"));
    }

    #[test]
    fn a_foreign_policy_network_is_copied_with_its_description() {
        let home = tempfile::tempdir().expect("a folder");
        let data = data_folders::root().join("tests/data");
        for name in ["torch-legacy.onnx", "torch-legacy.onnx.toml"] {
            fs::copy(data.join(name), home.path().join(name)).expect("copied");
        }
        let policy = home.path().join("torch-legacy.onnx");
        let recording = home.path().join("drive");
        fs::create_dir(&recording).expect("a folder");
        carry(&recording, &world(Path::new("ring-250"), policy.to_str().expect("a name"))).expect("room");
        let names = carried(&recording).expect("readable");
        assert_eq!(names, ["inputs/policies/torch-legacy.onnx", "inputs/policies/torch-legacy.onnx.toml"]);
        // The policy works from the copy alone.
        world(Path::new("ring-250"), recording.join(&names[0]).to_str().expect("a name"));
    }

    #[test]
    fn paths_in_a_recording_start_at_its_folder_and_names_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let here = |map: &str, policy: &str| {
            let text = format!("map = \"{map}\"\npolicy = \"{policy}\"\n");
            fs::write(folder.path().join(SCENARIO), text).expect("written");
            let Scenario { map, policy, .. } = scenario(folder.path()).unwrap_or_else(|e| panic!("{e}"));
            [map, policy]
        };
        let within = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
        assert_eq!(here("ring-250", "pi"), ["ring-250", "pi"]);
        assert_eq!(
            here("inputs/maps/mine", "inputs/policies/calm.toml"),
            [within("inputs/maps/mine"), within("inputs/policies/calm.toml")]
        );
        assert_eq!(here("/inputs/maps/mine", "inputsmap"), ["/inputs/maps/mine", "inputsmap"]);
    }

    #[test]
    fn paths_of_any_system_are_shortened_to_their_last_name() {
        for (path, name) in
            [("ring-250", "ring-250"), ("/home/ann/ring/", "ring"), ("C:\\maps\\x.xml", "x.xml"), ("a\\b\\", "b")]
        {
            assert_eq!(last(path), name);
        }
    }
}
