//! Surroundings of an imported file: buildings, land, trees and signs of OpenStreetMap and OpenDRIVE. In: the file, and
//! the network made from it. Out: the map's file of surroundings, and lines for the report. SUMO's own polyconvert places those of
//! OpenStreetMap in the network's frame.

use super::{
    netconvert::{self, ImportOptions},
    netconvert_attempts::MadeNetwork,
    osm_rings, sign_nodes,
    source_format::SourceFormat,
};
use crate::{
    map::{
        MapError,
        limits::MOST_IMPORT_BYTES,
        surroundings::{self, SURROUNDINGS, Surroundings, open_drive},
    },
    private,
};
use std::path::Path;

/// File that polyconvert writes, in the map's folder.
const POLYGONS: &str = "polygons.xml";
/// File for polyconvert with the areas that are relations of ways, in the map's folder.
const AREAS: &str = "areas.osm";

/// Writes the surroundings that a file states beside the network in a map's folder. Returns lines for the report, none without any; a map can
/// be driven without them, so that a fault of theirs is said there, too.
///
/// # Errors
/// The user stopped the import.
pub(super) fn write(
    folder: &Path,
    netconvert: &Path,
    (file, format): (&Path, SourceFormat),
    made: &MadeNetwork,
    options: &ImportOptions,
) -> Result<Vec<String>, MapError> {
    let mut notes = Vec::new();
    let found = match format {
        SourceFormat::OpenStreetMap => {
            of_open_street_map(folder, netconvert, file, options).and_then(|(found, holes)| {
                let signs = sign_nodes::read(folder, netconvert, file, made, options)?;
                notes = signs.notes;
                notes.extend((holes > 0).then(|| format!("holes          {holes} in buildings and land")));
                Ok(Surroundings { signs: signs.signs, ..found })
            })
        }
        SourceFormat::OpenDrive => open_drive::read(file).map(|mut found| {
            found.move_by(made.network.offset());
            found
        }),
        SourceFormat::Sumo => Ok(Surroundings::default()),
    };
    let written = found.and_then(|found| {
        let failed = |source| MapError::Io { file: folder.join(SURROUNDINGS), source };
        if !found.is_empty() {
            private::replace(&folder.join(SURROUNDINGS), found.text().as_bytes()).map_err(failed)?;
        }
        let counts = [
            ("buildings", found.buildings.len()),
            ("land", found.areas.len()),
            ("trees", found.trees.len()),
            ("signs", found.signs.len()),
        ];
        Ok(counts.into_iter().filter(|(_, count)| *count > 0))
    });
    match written {
        Ok(counts) => Ok(counts.map(|(what, count)| format!("{what:<14} {count}")).chain(notes).collect()),
        Err(MapError::Interrupted { file }) => Err(MapError::Interrupted { file }),
        Err(why) => Ok(vec![format!("surroundings   none: {}", why.to_string().lines().next().unwrap_or_default())]),
    }
}

/// Returns the buildings, land and trees of a file, and the number of holes in them.
fn of_open_street_map(
    folder: &Path,
    netconvert: &Path,
    file: &Path,
    options: &ImportOptions,
) -> Result<(Surroundings, usize), MapError> {
    let rings = osm_rings::read(file)?;
    let [polygons, areas] = [POLYGONS, AREAS].map(|name| folder.join(name));
    let mut files = vec![file];
    if let Some(rings) = &rings {
        private::replace(&areas, rings.text.as_bytes())
            .map_err(|source| MapError::Io { file: areas.clone(), source })?;
        files.push(&areas);
    }
    let made = netconvert::polygons(netconvert, &files, &folder.join("net.xml"), &polygons, options)
        .and_then(|()| surroundings::read_within(&polygons, MOST_IMPORT_BYTES));
    for file in [&polygons, &areas] {
        let _ = std::fs::remove_file(file);
    }
    Ok((made?, rings.map_or(0, |rings| rings.holes)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{
        import::import_into,
        network::Network,
        surroundings::{BuildingUse, LandUse},
    };
    use std::sync::atomic::AtomicBool;

    /// Returns a node of OpenStreetMap with the thousandth parts of degrees north of 50 degrees and east of 8 degrees.
    fn node(id: u32, north: f64, east: f64) -> String {
        format!("<node id=\"{id}\" lat=\"{}\" lon=\"{}\"/>", 50.0 + north / 1000.0, 8.0 + east / 1000.0)
    }

    fn way(id: u32, nodes: &[u32], tags: &[[&str; 2]]) -> String {
        let nodes: String = nodes.iter().map(|node| format!("<nd ref=\"{node}\"/>")).collect();
        let tags: String = tags.iter().map(|[k, v]| format!("<tag k=\"{k}\" v=\"{v}\"/>")).collect();
        format!("<way id=\"{id}\">{nodes}{tags}</way>")
    }

    #[test]
    fn surroundings_of_an_open_street_map_file_lie_where_the_file_says() {
        static STOP: AtomicBool = AtomicBool::new(false);
        // A street to the east, and a house 0.15 to 0.25 thousandths of a degree north of it; a wood.
        let places = [
            (1, 0.0, 0.0),
            (2, 0.0, 3.0),
            (3, 2.0, 3.0),
            (11, 0.15, 1.0),
            (12, 0.15, 1.2),
            (13, 0.25, 1.2),
            (14, 0.25, 1.0),
        ];
        let nodes: String = places.iter().map(|(id, north, east)| node(*id, *north, *east)).collect();
        let conifer = node(21, 0.1, 1.0)
            .replace("/>", "><tag k=\"natural\" v=\"tree\"/><tag k=\"leaf_type\" v=\"needleleaved\"/></node>");
        let ways = [
            way(100, &[1, 2, 3], &[["highway", "residential"]]),
            way(200, &[11, 12, 13, 14, 11], &[["building", "detached"], ["building:levels", "2"]]),
            way(201, &[1, 12, 13, 1], &[["landuse", "forest"]]),
        ];
        let text = format!("<osm version=\"0.6\">{nodes}{conifer}{}</osm>", ways.concat());
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("place.osm");
        std::fs::write(&file, text).expect("written");
        let netconvert = Path::new(env!("CODRIVE_ROOT")).join(".sumo/sumo/bin/netconvert");
        let options = ImportOptions { seconds: 60, memory_mib: 1024, stop: &STOP, side: None };
        let made = import_into(&folder.path().join("maps"), &netconvert, &file, "place", &options).expect("imported");
        for line in ["buildings      1", "land           1", "trees          1"] {
            assert!(made.report.notes.iter().any(|note| note == line), "{:?}", made.report.notes);
        }
        assert!(!made.folder.join(POLYGONS).exists() && made.folder.join(SURROUNDINGS).is_file());
        let net = Network::load(&made.folder.join("net.xml").to_string_lossy()).expect("a network");
        let found = net.surroundings();
        let [house] = &found.buildings[..] else { panic!("{found:?}") };
        let [wood] = &found.areas[..] else { panic!("{found:?}") };
        let [tree] = &found.trees[..] else { panic!("{found:?}") };
        assert_eq!((house.kind, house.height_m, house.outline.len()), (BuildingUse::House, Some(6.0), 4));
        // At 50 degrees north a degree has 111,229 m to the north and 71,698 m to the east (WGS 84).
        let area_m2 = 0.2e-3 * 71_698.0 * 0.1e-3 * 111_229.0;
        assert_eq!((wood.land_use, tree.is_conifer), (LandUse::Wood, true));
        // 0.05 thousandths of a degree south of the house's corner.
        let corner =
            house.outline.iter().copied().min_by(|a, b| (a.x + a.y).total_cmp(&(b.x + b.y))).expect("a corner");
        assert!((corner.distance(tree.position) - 0.05e-3 * 111_229.0).abs() < 0.1, "{corner} {}", tree.position);
        assert!((house.area_m2() / area_m2 - 1.0).abs() < 0.01, "{} instead of {area_m2}", house.area_m2());
        let lanes = net.lanes().iter().filter(|lane| lane.admits_cars());
        let points = lanes.flat_map(|lane| lane.line.points().windows(2).map(|pair| [pair[0], pair[1]]));
        let off_m = |corner: glam::DVec2| {
            let to_segment = |[a, b]: [glam::DVec3; 2]| {
                let (a, along) = (a.truncate(), (b - a).truncate());
                let share = ((corner - a).dot(along) / along.length_squared().max(1e-9)).clamp(0.0, 1.0);
                corner.distance(a + along * share)
            };
            points.clone().map(to_segment).fold(f64::INFINITY, f64::min)
        };
        let nearest_m = house.outline.iter().map(|corner| off_m(*corner)).fold(f64::INFINITY, f64::min);
        // 16.7 m from the street's middle, less half a lane of 3.2 m.
        assert!((nearest_m - (0.15e-3 * 111_229.0 - 1.6)).abs() < 0.3, "{nearest_m} m from the lane's middle");
    }

    #[test]
    fn objects_of_an_open_drive_file_lie_beside_its_road() {
        static STOP: AtomicBool = AtomicBool::new(false);
        let lane = "<laneSection s=\"0\"><center><lane id=\"0\" type=\"none\"/></center><right><lane id=\"-1\" type=\"driving\">\
                    <width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/></lane></right></laneSection>";
        let text = format!(
            "<OpenDRIVE><header revMajor=\"1\" revMinor=\"4\"/><road id=\"1\" length=\"300\" junction=\"-1\"><planView>\
             <geometry s=\"0\" x=\"-900\" y=\"40\" hdg=\"0\" length=\"300\"><line/></geometry></planView><lanes>{lane}</lanes><objects>\
             <object type=\"building\" s=\"100\" t=\"-20\" length=\"12\" width=\"8\" height=\"7\"/></objects></road></OpenDRIVE>"
        );
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("place.xodr");
        std::fs::write(&file, text).expect("written");
        let netconvert = Path::new(env!("CODRIVE_ROOT")).join(".sumo/sumo/bin/netconvert");
        let options = ImportOptions { seconds: 60, memory_mib: 1024, stop: &STOP, side: None };
        let made = import_into(&folder.path().join("maps"), &netconvert, &file, "place", &options).expect("imported");
        assert!(made.report.notes.iter().any(|note| note == "buildings      1"), "{:?}", made.report.notes);
        let net = Network::load(&made.folder.join("net.xml").to_string_lossy()).expect("a network");
        let [house] = &net.surroundings().buildings[..] else { panic!("{:?}", net.surroundings()) };
        assert_eq!((house.height_m, house.area_m2().round()), (Some(7.0), 96.0));
        // The lane's middle is 1.75 m to the right of the road's line, the house's nearest wall 16 m, wherever the network begins.
        let lane = net.lanes().iter().find(|lane| lane.admits_cars()).expect("a lane");
        let start = lane.line.points()[0];
        let off_m = |corner: &glam::DVec2| (corner.x - start.x, start.y - corner.y);
        let (along_m, aside_m): (Vec<f64>, Vec<f64>) = house.outline.iter().map(off_m).unzip();
        let least = |of: &[f64]| of.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(
            (least(&along_m) - 94.0).abs() < 0.2 && (least(&aside_m) - 14.25).abs() < 0.2,
            "{along_m:?} {aside_m:?}"
        );
    }
}
