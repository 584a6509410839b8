//! Reader of OpenSCENARIO files. In: the scenes of the tests with their roads and their catalog, and changes of them. Out: whether they were read.

use super::{
    mutate,
    readers::{Reader, with_file},
};
use codrive::scenario::openscenario::{OpenScenario, ParticipantChoice};
use std::{fs, path::Path};

/// Scenes of the tests; each is read with its own road.
const SCENES: [&str; 3] = ["cut-in", "pedestrian", "traffic-light"];

/// Returns the reader; roads and catalogs go into `folder`.
pub fn reader(folder: &Path) -> Reader {
    let (root, folder) = (Path::new(env!("CARGO_MANIFEST_DIR")), folder.join("scenes"));
    let scenes = root.join("tests/data/openscenario");
    fs::create_dir_all(folder.join("catalogs")).expect("a folder");
    for file in ["straight.xodr", "bend.xodr", "crossing.xodr", "catalogs/vehicles.xosc"] {
        fs::copy(scenes.join(file), folder.join(file)).expect("a file of the tests");
    }
    let net = root.join("maps/ring-250/net.xml").to_string_lossy().into_owned();
    Reader {
        name: "openscenario",
        good: SCENES.map(|name| fs::read(scenes.join(name).with_extension("xosc")).expect("a scene")).into(),
        change: mutate::text,
        share: 300,
        read: with_file(folder.join("fuzz.xosc"), move |file| {
            OpenScenario::read(file).is_ok_and(|scenario| {
                // The ring is not its road: most of its places lie far from the path.
                let _ = scenario.on(&net, &ParticipantChoice::None);
                true
            })
        }),
    }
}
