//! Maps on this machine. In: a name or a path. Out: a [`RoadMap`], or the error. A map is a folder `maps/<name>/` with `net.xml` and
//! `map.toml`, in the program's data or in the user's. An optional `demand.rou.xml` defines its traffic demand.

use super::{
    MapError, RoadMap,
    edge_path::along_edges,
    limits::MOST_BYTES,
    loop_search::{ChosenEdges, route_of},
    network::{LaneId, Network},
    shipped::SHIPPED,
    surroundings::{self, SURROUNDINGS},
};
use crate::{
    data_folders,
    file::{SETTINGS_BYTES, read_bounded, read_text},
    sumo_xml::document,
    toml_text,
};
use serde::Deserialize;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Map in a folder `maps/`.
#[derive(Clone, Debug, PartialEq)]
pub struct MapInfo {
    /// Name of the map's folder.
    pub name: String,
    /// Title in one line.
    pub title: String,
    /// Purpose of the map, or the error if its `map.toml` is broken.
    pub description: String,
    /// Folder of the map.
    pub folder: PathBuf,
}

/// Content of `map.toml`.
#[derive(Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapFile {
    /// Title in one line.
    title: String,
    /// Purpose of the map.
    #[serde(default)]
    description: String,
    /// Edges of the route in order; found by the program if absent.
    route: Option<Vec<String>>,
    /// False if the last edge of `route` does not lead to the first.
    #[serde(default = "yes")]
    closed: bool,
}

fn yes() -> bool {
    true
}

/// Returns the folders that contain maps: the program's own, and the user's.
fn folders() -> impl Iterator<Item = PathBuf> {
    [data_folders::root().join(MAPS)].into_iter().chain(own_folder())
}

/// Returns the folder of the user's own maps; `None` without a home folder.
pub fn own_folder() -> Option<PathBuf> {
    data_folders::user().map(|folder| folder.join(MAPS))
}

/// Name of the folders that contain maps.
const MAPS: &str = "maps";
/// File name of a map's own demand.
const DEMAND: &str = "demand.rou.xml";
/// File name of the scenario with which a map is driven best.
const SCENARIO: &str = "scenario.toml";

/// Returns all maps by name: the program's and the user's own. If a map's `map.toml` is broken, the error is its description.
pub fn list() -> Vec<MapInfo> {
    let entries = folders().flat_map(|folder| std::fs::read_dir(folder).into_iter().flatten().flatten());
    let mut maps: Vec<MapInfo> = entries
        .filter(|entry| entry.path().join("net.xml").is_file())
        .map(|entry| {
            let (folder, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            let (title, description) = match read_map_file(&folder) {
                Ok(Some(file)) => (file.title, file.description),
                Ok(None) => (name.clone(), String::new()),
                Err(error) => (name.clone(), error.to_string()),
            };
            MapInfo { name, title, description, folder }
        })
        .collect();
    // Of two maps with one name the program's is kept: it is the one that the name loads.
    maps.sort_by(|a, b| a.name.cmp(&b.name));
    maps.dedup_by(|b, a| a.name == b.name);
    maps
}

/// Returns the scenario of a map by the map's name; `None` for the path of a file, and if the map has none.
pub fn scenario_file(name_or_path: &Path) -> Option<PathBuf> {
    let name = name_or_path.to_str().filter(|name| !is_path(name) && !name_or_path.exists())?;
    folders().map(|folder| folder.join(name).join(SCENARIO)).find(|file| file.is_file())
}

/// Returns true if a map is not one of [`SHIPPED`]: another machine may lack its name, or have another map under it.
pub fn is_own(name_or_path: &str) -> bool {
    !SHIPPED.contains(&name_or_path)
}

/// Returns the name of a map in `maps/`. A shipped map is recognised by the bytes of its network, also under a path or as a copy. `None`
/// for a map from elsewhere.
pub fn known_as(map: &RoadMap) -> Option<String> {
    let maps = data_folders::root().join(MAPS);
    let own = map.network.sumo_text().as_str().as_bytes();
    let is_own =
        |name: &str| read_bounded(&maps.join(name).join("net.xml"), MOST_BYTES).is_ok_and(|bytes| bytes == own);
    let shipped = SHIPPED.iter().find(|name| is_own(name));
    if let Some(name) = shipped {
        return Some((*name).to_owned());
    }
    // A map that the user has put into one of these folders.
    let lies_in = map.net_file.parent()?.parent()?.canonicalize().ok()?;
    let is_known = folders().any(|folder| folder.canonicalize().is_ok_and(|folder| folder == lies_in));
    (is_known && !SHIPPED.contains(&map.name.as_str())).then(|| map.name.clone())
}

/// Returns true if a map is named by its path, not by the name of its folder in `maps/`.
pub fn is_path(name_or_path: &str) -> bool {
    let ends = [".xml", ".gz", ".xodr", ".osm", ".sumocfg"];
    name_or_path.contains(['/', '\\']) || ends.iter().any(|end| name_or_path.ends_with(end))
}

/// Finds the folder or `net.xml` of a map's name or path.
fn place_of(name_or_path: &str) -> Result<PathBuf, MapError> {
    let (path, is_path) = (Path::new(name_or_path), is_path(name_or_path));
    let of_name = || folders().map(|folder| folder.join(name_or_path)).find(|folder| folder.join("net.xml").exists());
    let place = if is_path { Some(path.to_path_buf()) } else { of_name() };
    let place = place.unwrap_or_else(|| data_folders::root().join(MAPS).join(name_or_path));
    if is_path || place.join("net.xml").exists() {
        return Ok(place);
    }
    let maps = list();
    let known: Vec<&str> = maps.iter().map(|map| map.name.as_str()).collect();
    // A name never means a folder of the working folder: two people would drive different roads by one command.
    let near = if path.join("net.xml").exists() {
        format!("; the map in the folder here is named by its path: ./{name_or_path}")
    } else {
        toml_text::did_you_mean(name_or_path, &known)
    };
    let looked: Vec<String> = folders().map(|folder| folder.display().to_string()).collect();
    let (name, known, looked) = (name_or_path.into(), super::listed(&known), looked.join(", "));
    Err(MapError::UnknownMap { name, near, known, looked })
}

impl Network {
    /// Reads the network of a map, which need not have a closed route; named as for [`RoadMap::load`].
    ///
    /// # Errors
    /// There is no such map, or its network cannot be used; the message names file, line, value and remedy.
    pub fn load(name_or_path: &str) -> Result<Self, MapError> {
        let place = place_of(name_or_path)?;
        let file = if place.is_dir() { place.join("net.xml") } else { place };
        Self::read(&file, &read_network(&file)?)?.with_surroundings_of(&file)
    }

    /// Returns the network with the surroundings of its map, if it is a `net.xml` with a file of them beside it.
    fn with_surroundings_of(self, net_file: &Path) -> Result<Self, MapError> {
        let file = net_file.with_file_name(SURROUNDINGS);
        let is_there = net_file.ends_with("net.xml") && file.is_file();
        if is_there { Ok(self.with_surroundings(surroundings::read(&file)?)) } else { Ok(self) }
    }
}

impl RoadMap {
    /// Loads a map by the name of its folder in `maps/`, or by the path of a `net.xml` or of a folder with one.
    ///
    /// # Errors
    /// There is no such map, or its files cannot be used; the message names file, line, value and remedy.
    pub fn load(name_or_path: &str) -> Result<Self, MapError> {
        let folder = place_of(name_or_path)?;
        match folder.parent() {
            _ if folder.is_dir() => Self::load_folder(&folder),
            // The path of a `net.xml` in a map's folder loads that map, with its title and its route.
            Some(parent) if folder.ends_with("net.xml") && parent.join("map.toml").exists() => {
                Self::load_folder(parent)
            }
            _ => Self::load_file(&folder, None),
        }
    }

    /// Returns the files of a map, named as for [`RoadMap::load`]: its network, and if present its `map.toml`, its demand and its
    /// surroundings.
    ///
    /// # Errors
    /// There is no such map.
    pub fn files(name_or_path: &str) -> Result<Vec<PathBuf>, MapError> {
        let place = place_of(name_or_path)?;
        let net_file = if place.is_dir() { place.join("net.xml") } else { place };
        let beside = ["map.toml", DEMAND, SURROUNDINGS].map(|name| net_file.with_file_name(name));
        let beside =
            beside.into_iter().filter(|file| net_file.ends_with("net.xml") && file.is_file()).collect::<Vec<_>>();
        Ok([vec![net_file], beside].concat())
    }

    /// Loads a map as [`RoadMap::load`] does, with the open route along these edges. Where the first of them is a lane by its id, the route begins
    /// on it.
    ///
    /// # Errors
    /// As for [`RoadMap::load`]; or an edge does not exist, is closed to cars, or does not lead to the next.
    pub fn load_along(name_or_path: &str, edges: &[&str]) -> Result<Self, MapError> {
        let place = place_of(name_or_path)?;
        let (net_file, folder) = if place.is_dir() {
            (place.join("net.xml"), Some(place.as_path()))
        } else {
            (place.clone(), place.parent().filter(|_| place.ends_with("net.xml")))
        };
        let about = folder.map_or(Ok(None), read_map_file)?;
        let network = Network::read(&net_file, &read_network(&net_file)?)?.with_surroundings_of(&net_file)?;
        let named = edges.first().filter(|word| network.edge_named(word).is_none());
        let begins_on =
            named.and_then(|word| network.lane_named(word)).filter(|lane| network.lane(*lane).admits_cars());
        let route = along_edges(&net_file, &network, edges, begins_on)?;
        let stem = || stem_of(&net_file);
        let name = folder.filter(|_| place.is_dir() || about.is_some()).map_or_else(stem, name_of);
        let title = about.map_or_else(|| name.clone(), |file| file.title);
        Ok(Self { name, title, net_file, route, network: Arc::new(network) })
    }

    /// Returns the same map with the open route along these edges that begins on the lane `first`.
    ///
    /// # Errors
    /// As [`RoadMap::load_along`], or the edges cannot be driven from that lane.
    pub fn along(&self, edges: &[&str], first: LaneId) -> Result<Self, MapError> {
        let route = along_edges(&self.net_file, &self.network, edges, Some(first))?;
        let (name, title, net_file) = (self.name.clone(), self.title.clone(), self.net_file.clone());
        Ok(Self { name, title, net_file, route, network: Arc::clone(&self.network) })
    }

    /// Returns the file of the map's own demand, for a `net.xml` in a folder with such a file. A drive uses it unless its scenario names
    /// another.
    pub fn demand_file(&self) -> Option<PathBuf> {
        let file = self.net_file.with_file_name(DEMAND);
        (self.net_file.ends_with("net.xml") && file.is_file()).then_some(file)
    }

    fn load_folder(folder: &Path) -> Result<Self, MapError> {
        let name = name_of(folder);
        let file = read_map_file(folder)?;
        let chosen =
            file.as_ref().and_then(|file| Some(ChosenEdges { edges: file.route.as_deref()?, closed: file.closed }));
        let map = Self::load_file(&folder.join("net.xml"), chosen)?;
        let title = file.map_or_else(|| name.clone(), |file| file.title);
        Ok(Self { name, title, ..map })
    }

    /// Loads a `net.xml` with the chosen edges as its route, or with its default path.
    fn load_file(net_file: &Path, chosen: Option<ChosenEdges>) -> Result<Self, MapError> {
        Self::read(net_file, &read_network(net_file)?, chosen)
    }

    /// Parses the text of a `net.xml`, with the chosen edges as its route, or with its default path.
    pub(super) fn read(net_file: &Path, text: &str, chosen: Option<ChosenEdges>) -> Result<Self, MapError> {
        let network = Network::read(net_file, text)?.with_surroundings_of(net_file)?;
        let route = route_of(net_file, &network, chosen)?;
        let name = stem_of(net_file);
        Ok(Self { title: name.clone(), name, net_file: net_file.into(), route, network: Arc::new(network) })
    }
}

/// Returns the name of a map's folder.
fn name_of(folder: &Path) -> String {
    let name = folder.canonicalize().ok().and_then(|f| Some(f.file_name()?.to_string_lossy().into_owned()));
    name.unwrap_or_else(|| folder.display().to_string())
}

/// Returns the name of a network's file without its extensions.
fn stem_of(net_file: &Path) -> String {
    let name = net_file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    name.trim_end_matches(".gz").trim_end_matches(".xml").trim_end_matches(".net").to_owned()
}

/// Reads the text of a network, which may be compressed (`.gz`).
pub(super) fn read_network(file: &Path) -> Result<String, MapError> {
    document::read_text(file, MOST_BYTES).map_err(|source| unreadable(file, source))
}

/// Reads the text of a file of settings.
pub(super) fn read_settings(file: &Path) -> Result<String, MapError> {
    read_text(file, SETTINGS_BYTES).map_err(|source| unreadable(file, source))
}

fn unreadable(file: &Path, source: std::io::Error) -> MapError {
    match source.kind() {
        std::io::ErrorKind::NotFound => MapError::Missing { file: file.into() },
        std::io::ErrorKind::InvalidData => {
            MapError::NotXml { file: file.into(), line: 1, column: 1, message: source.to_string() }
        }
        _ => MapError::Io { file: file.into(), source },
    }
}

fn read_map_file(folder: &Path) -> Result<Option<MapFile>, MapError> {
    let file = folder.join("map.toml");
    if !file.exists() {
        return Ok(None);
    }
    let text = read_settings(&file)?;
    let parsed = toml_text::parse(&text, &file.display().to_string());
    parsed.map(Some).map_err(|e| MapError::Toml(e.to_string()))
}
