//! The files that a drive was made from, carried in its recording. In: a scenario whose map or policy is the author's own.
//! Out: copies in `inputs/`, and the scenario with their place in the recording instead: it can be driven again on another
//! machine, and does not tell where its author keeps things. Maps and policies that the program brings keep their names.

use super::{RecordError, files};
use crate::{
    file::read_bounded,
    map::{self, limits::MOST_BYTES},
    policy,
    sim::{Scenario, ScenarioError, World},
};
use std::{
    fs,
    path::{Component, Path},
};

/// Folder of the copies.
const INPUTS: &str = "inputs";

/// The scenario as a recording keeps it.
pub fn portable(world: &World) -> Scenario {
    let scenario = world.scenario();
    let map = if map::is_own(&scenario.map) { map_place(world) } else { scenario.map.clone() };
    let policy = match &scenario.policy {
        path if policy::is_path(path) => format!("{INPUTS}/policies/{}", last(path)),
        // The map's name chooses it, and that changes.
        name if map::is_own(&scenario.map) => policy::meant(name, &scenario.map),
        name => name.clone(),
    };
    Scenario { map, policy, ..scenario.clone() }
}

fn map_place(world: &World) -> String {
    format!("{INPUTS}/maps/{}", last(&world.map().name))
}

/// Copies into a recording what its scenario names by path.
///
/// # Errors
/// A file cannot be read any more, or the disk refuses.
pub fn carry(recording: &Path, world: &World) -> Result<(), RecordError> {
    let scenario = world.scenario();
    let copy = |from: &Path, to: &Path| {
        files::new_private_dir(to.parent().unwrap_or(recording))?;
        // A network may be the largest: whatever was loaded before the drive is no larger.
        files::write_new(to, &read_bounded(from, MOST_BYTES).map_err(RecordError::file(from))?)
    };
    if map::is_own(&scenario.map) {
        let (net, folder) = (&world.map().net_file, recording.join(map_place(world)));
        copy(net, &folder.join("net.xml"))?;
        // Of a map's folder, its title and its route.
        let about = net.with_file_name("map.toml");
        if net.ends_with("net.xml") && about.is_file() {
            copy(&about, &folder.join("map.toml"))?;
        }
    }
    if policy::is_path(&scenario.policy) {
        copy(Path::new(&scenario.policy), &recording.join(portable(world).policy))?;
    }
    Ok(())
}

/// Names of what a recording carries, from its folder on, in order.
pub(super) fn carried(recording: &Path) -> Result<Vec<String>, RecordError> {
    let (mut names, mut folders) = (Vec::new(), vec![INPUTS.to_owned()]);
    while let Some(folder) = folders.pop().filter(|_| recording.join(INPUTS).exists()) {
        let path = recording.join(&folder);
        for entry in fs::read_dir(&path).map_err(RecordError::file(&path))? {
            let entry = entry.map_err(RecordError::file(&path))?;
            let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() { folders.push(name) } else { names.push(name) }
        }
    }
    names.sort();
    Ok(names)
}

/// The scenario of a recording, with the place on this machine of what it carries. One that an older program recorded
/// keeps the paths that it names.
///
/// # Errors
/// It cannot be read, or is not as this program writes it.
pub fn scenario(recording: &Path) -> Result<Scenario, ScenarioError> {
    let mut scenario = Scenario::from_file(&recording.join(SCENARIO))?;
    for name in [&mut scenario.map, &mut scenario.policy] {
        let path = Path::new(name.as_str());
        let carried = path.starts_with(INPUTS) && path.components().all(|part| matches!(part, Component::Normal(_)));
        // A recording in the folder of today would be a name otherwise.
        let recording = if recording.as_os_str().is_empty() { Path::new(".") } else { recording };
        if carried {
            *name = recording.join(path).to_string_lossy().into_owned();
        }
    }
    Ok(scenario)
}

/// Its file.
pub const SCENARIO: &str = "scenario.toml";

/// What stands for a name or a path where others read: the name of its file or folder.
pub fn last(name: &str) -> &str {
    name.trim_end_matches(['/', '\\']).rsplit(['/', '\\']).next().unwrap_or(name)
}
