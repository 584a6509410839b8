//! Tests of the network on the small networks of `tests/data/networks`, the two of `tests/data` and the shipped maps. Expected values
//! come from SUMO's own library and programs, from a brute-force search, or are counted by hand.

mod faults;
mod gate;
mod geometry;
mod large;
mod sumo;

use super::*;
use std::{
    fs,
    path::{Path as FilePath, PathBuf},
};

fn root() -> &'static FilePath {
    FilePath::new(env!("CODRIVE_ROOT"))
}

fn networks_folder() -> PathBuf {
    root().join("tests/data/networks")
}

/// Returns the files of all test networks: seventeen small ones, two made by netconvert, and the shipped maps.
fn files() -> Vec<PathBuf> {
    let entries = fs::read_dir(networks_folder()).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(|file| file.to_string_lossy().ends_with(".net.xml")).collect();
    files.sort();
    assert_eq!(files.len(), 17);
    files.extend(["junctions-inside", "junctions-none"].map(|name| root().join(format!("tests/data/{name}.net.xml"))));
    files.extend(crate::map::SHIPPED.map(|name| root().join("maps").join(name).join("net.xml")));
    files
}

fn read(file: &FilePath) -> Network {
    Network::read(file, &fs::read_to_string(file).unwrap()).unwrap_or_else(|error| panic!("{error}"))
}

fn named(name: &str) -> Network {
    read(&networks_folder().join(format!("{name}.net.xml")))
}

fn lane(net: &Network, id: &str) -> LaneId {
    net.lane_named(id).unwrap_or_else(|| panic!("no lane {id}"))
}
