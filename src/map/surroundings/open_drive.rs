//! Buildings, trees and bushes among the objects of an OpenDRIVE file, and signs among its signals. In: the file. Out:
//! [`Surroundings`] in the file's coordinates, metres.
//!
//! Objects whose numbers are missing or out of range are left out: a road can be driven without them.

use super::{
    BuildingUse, Footprint, LandArea, LandUse, MOST_KEPT, StatedSign, StatedSignKind, StatedTree, Surroundings,
    doubled_area_m2, footprint::HIGHEST_M, road_sign::older_limit,
};
use crate::{
    map::{
        MapError,
        limits::MOST_BYTES,
        reference_line::{ReferenceLine, number},
    },
    sumo_xml::document,
};
use glam::{DVec2, dvec2};
use roxmltree::Node;
use std::{f64::consts::PI, path::Path};

/// Least distance between repeated objects, and distance between the corners of a strip along a road, metres.
const LEAST_M: f64 = 0.5;
const CORNER_EVERY_M: f64 = 5.0;
/// Width of a hedge of which the file states none, metres.
const HEDGE_M: f64 = 1.0;

/// Reads the objects of an OpenDRIVE file of at most 48 MiB.
///
/// # Errors
/// The file cannot be read or is no XML.
pub fn read(file: &Path) -> Result<Surroundings, MapError> {
    let text = document::read_text(file, MOST_BYTES).map_err(|source| MapError::Io { file: file.into(), source })?;
    let tree = super::tree_of(file, &text)?;
    let mut found = Surroundings::default();
    for road in tree.root_element().children().filter(|node| node.has_tag_name("road")) {
        let line = ReferenceLine::of(road);
        let objects = road.children().filter(|node| node.has_tag_name("objects"));
        for object in objects.flat_map(|objects| objects.children().filter(|node| node.has_tag_name("object"))) {
            let left = MOST_KEPT.saturating_sub(found.count());
            RoadObject { object, line: &line }.add_to(&mut found, left);
        }
        let signals = road.children().filter(|node| node.has_tag_name("signals"));
        let signals = signals.flat_map(|signals| signals.children().filter(|node| node.has_tag_name("signal")));
        let left = MOST_KEPT.saturating_sub(found.count());
        found.signs.extend(signals.filter_map(|signal| sign(signal, &line)).take(left));
    }
    Ok(found)
}

/// Returns the sign of a static signal; `None` for lights, and for signs other than those of [`StatedSignKind`]. OpenDRIVE numbers its own
/// signs as Germany does.
fn sign(signal: Node, line: &ReferenceLine) -> Option<StatedSign> {
    let of = |name: &str| signal.attribute(name).unwrap_or_default();
    let country = of("country").to_ascii_lowercase();
    if of("dynamic") == "yes" || !["", "de", "ger", "germany", "opendrive"].contains(&country.as_str()) {
        return None;
    }
    let of_subtype = || number(signal, "subtype").and_then(older_limit);
    let shown = number(signal, "value").filter(|value| *value > 0.0).or_else(of_subtype);
    let kind = StatedSignKind::of(of("type"), shown)?;
    let (s_m, t_m) = (number(signal, "s")?, number(signal, "t")?);
    let (_, heading_rad) = line.at(s_m)?;
    // A sign for those who drive along the line faces against it.
    let facing_rad = if of("orientation") == "-" { heading_rad } else { heading_rad + PI };
    Some(StatedSign { position: line.beside(s_m, t_m)?, facing_rad, kind })
}

/// Object beside a road.
#[derive(Clone, Copy)]
struct RoadObject<'a, 'input> {
    object: Node<'a, 'input>,
    line: &'a ReferenceLine,
}

impl<'a, 'input> RoadObject<'a, 'input> {
    /// Adds what is drawn of the object, at most `left` things.
    fn add_to(self, found: &mut Surroundings, left: usize) {
        let is_of = |kind: &str| self.object.attribute("type").is_some_and(|of| of.eq_ignore_ascii_case(kind));
        let name = self.object.attribute("name").unwrap_or_default().to_lowercase();
        let places = self.places().into_iter().take(left);
        if is_of("building") || name.starts_with("building") {
            let outlines = places.filter_map(|place| self.outline(place));
            found.buildings.extend(outlines.map(|outline| {
                let kind = BuildingUse::of("yes", doubled_area_m2(&outline) / 2.0);
                Footprint { outline, kind, height_m: self.height_m() }
            }));
        } else if is_of("tree") {
            let is_conifer = ["conifer", "spruce", "pine", "fir"].iter().any(|kind| name.contains(kind));
            let trees = places.filter_map(|[s_m, t_m]| self.line.beside(s_m, t_m));
            found.trees.extend(trees.map(|position| StatedTree { position, is_conifer }));
        } else if is_of("vegetation") {
            let strips = self.repeats().filter_map(|repeat| self.strip(repeat));
            let areas = places.filter_map(|place| self.outline(place)).chain(strips).take(left);
            found.areas.extend(areas.map(|outline| LandArea { outline, land_use: LandUse::Scrub }));
        }
    }

    fn of(self, name: &str) -> Option<f64> {
        number(self.object, name)
    }

    fn repeats(self) -> impl Iterator<Item = Node<'a, 'input>> {
        self.object.children().filter(|node| node.has_tag_name("repeat"))
    }

    /// Returns the places of the object along the road and to the left of its line: its own, or those of its repetitions.
    fn places(self) -> Vec<[f64; 2]> {
        if self.repeats().next().is_none() {
            return self.of("s").zip(self.of("t")).map(|(s_m, t_m)| [s_m, t_m]).into_iter().collect();
        }
        let places = self.repeats().flat_map(|repeat| {
            let value = |name: &str| number(repeat, name);
            let (from_m, length_m) = (value("s").unwrap_or(0.0), value("length").unwrap_or(0.0).max(0.0));
            let [start_m, end_m] = [value("tStart"), value("tEnd")].map(|t_m| t_m.or(self.of("t")).unwrap_or(0.0));
            // Without a distance it is one object along the whole length.
            let every_m = value("distance").filter(|every_m| *every_m > 0.0).map(|every_m| every_m.max(LEAST_M));
            let count = every_m.map_or(0, |every_m| (length_m / every_m).min(MOST_KEPT as f64) as usize + 1);
            let every_m = every_m.unwrap_or(0.0);
            (0..count).map(move |k| {
                let along_m = k as f64 * every_m;
                [from_m + along_m, start_m + (end_m - start_m) * along_m / length_m.max(1e-6)]
            })
        });
        places.take(MOST_KEPT).collect()
    }

    /// Returns the outline of the object at a place, counter-clockwise; `None` if it has no area.
    fn outline(self, [s_m, t_m]: [f64; 2]) -> Option<Vec<DVec2>> {
        let (on_line, heading_rad) = self.line.at(s_m)?;
        let middle = on_line + DVec2::from_angle(heading_rad).perp() * t_m;
        let turn = DVec2::from_angle(heading_rad + self.of("hdg").unwrap_or(0.0));
        let local = |u: f64, v: f64| middle + turn.rotate(dvec2(u, v));
        let outline = self.object.descendants().find(|node| node.has_tag_name("outline"));
        let corners: Vec<DVec2> = match outline {
            Some(outline) if outline.attribute("closed") == Some("false") => return None,
            Some(outline) => {
                let corner = |node: Node| match node.tag_name().name() {
                    "cornerLocal" => Some(local(number(node, "u")?, number(node, "v")?)),
                    "cornerRoad" => self.line.beside(number(node, "s")?, number(node, "t")?),
                    _ => None,
                };
                outline.children().filter_map(corner).collect()
            }
            None => {
                let (length_m, width_m) = match self.of("radius") {
                    Some(radius_m) => (2.0 * radius_m, 2.0 * radius_m),
                    None => (self.of("length")?, self.of("width")?),
                };
                let half = dvec2(length_m, width_m) / 2.0;
                [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .map(|(u, v)| local(u * half.x, v * half.y))
                    .to_vec()
            }
        };
        super::closed(corners, super::MOST_WALLS)
    }

    /// Returns the outline of a strip along the road, such as a hedge; `None` for single objects.
    fn strip(self, repeat: Node) -> Option<Vec<DVec2>> {
        let value = |name: &str| number(repeat, name);
        let (from_m, length_m) = (value("s")?, value("length")?);
        if value("distance").is_some_and(|every_m| every_m > 0.0) || length_m <= 0.0 {
            return None;
        }
        let half_m = value("widthStart").or(self.of("width")).unwrap_or(HEDGE_M) / 2.0;
        let (start_m, end_m) = (value("tStart")?, value("tEnd")?);
        let count = (length_m / CORNER_EVERY_M).ceil().min(200.0);
        let side = |aside_m: f64| {
            (0..=count as usize).filter_map(move |k| {
                let share = k as f64 / count;
                self.line.beside(from_m + length_m * share, start_m + (end_m - start_m) * share + aside_m)
            })
        };
        let right: Vec<DVec2> = side(-half_m).collect();
        let mut left: Vec<DVec2> = side(half_m).collect();
        left.reverse();
        super::closed([right, left].concat(), super::MOST_CORNERS)
    }

    /// Returns the height of a building, metres: its own, or that of its highest corner.
    fn height_m(self) -> Option<f64> {
        let corners = self.object.descendants().filter(|node| node.tag_name().name().starts_with("corner"));
        let of_corners =
            corners.filter_map(|node| number(node, "height")).fold(None, |highest: Option<f64>, height_m| {
                Some(highest.map_or(height_m, |highest| highest.max(height_m)))
            });
        of_corners.or(self.of("height")).filter(|height_m| *height_m > 0.0 && *height_m <= HIGHEST_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the surroundings of a road of 400 m to the north from (100, 50) with these objects.
    fn of(objects: &str) -> Surroundings {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("road.xodr");
        let text = format!(
            "<OpenDRIVE><road id=\"1\" length=\"400\"><planView><geometry s=\"0\" x=\"100\" y=\"50\" hdg=\"1.5707963267948966\" \
             length=\"400\"><line/></geometry></planView><objects>{objects}</objects></road></OpenDRIVE>"
        );
        std::fs::write(&file, text).expect("written");
        read(&file).expect("objects")
    }

    #[test]
    fn signs_face_those_for_whom_they_hold() {
        let found = of("</objects><signals>\
             <signal s=\"100\" t=\"-5\" dynamic=\"no\" orientation=\"+\" country=\"DE\" type=\"206\"/>\
             <signal s=\"200\" t=\"5\" dynamic=\"no\" orientation=\"-\" country=\"OpenDRIVE\" type=\"274\" subtype=\"57\"/>\
             <signal s=\"300\" t=\"-5\" orientation=\"+\" country=\"de\" type=\"274\" value=\"50\" unit=\"km/h\"/>\
             <signal s=\"10\" t=\"4\" dynamic=\"yes\" orientation=\"+\" country=\"OpenDRIVE\" type=\"1000001\"/>\
             <signal s=\"20\" t=\"4\" dynamic=\"no\" orientation=\"+\" country=\"se\" type=\"206\"/>\
             <signal s=\"30\" t=\"4\" dynamic=\"no\" orientation=\"+\" country=\"DE\" type=\"274\"/>\
             <signal s=\"inf\" t=\"4\" dynamic=\"no\" orientation=\"+\" country=\"DE\" type=\"205\"/>\
             </signals><objects>");
        // The road leads north from (100, 50): along it, signs face south and stand in the east.
        let looks = |sign: &StatedSign| {
            (sign.position.round().to_array(), DVec2::from_angle(sign.facing_rad).y.round(), sign.kind)
        };
        let expected = [
            ([105.0, 150.0], -1.0, StatedSignKind::Stop),
            ([95.0, 250.0], 1.0, StatedSignKind::SpeedLimit(70)),
            ([105.0, 350.0], -1.0, StatedSignKind::SpeedLimit(50)),
        ];
        assert_eq!(found.signs.iter().map(looks).collect::<Vec<_>>(), expected);
    }

    fn assert_corners(outline: &[DVec2], wanted: &[[f64; 2]]) {
        assert_eq!(outline.len(), wanted.len(), "{outline:?}");
        let is_there = |at: &[f64; 2]| outline.iter().any(|corner| corner.distance(DVec2::from(*at)) < 1e-6);
        assert!(wanted.iter().all(is_there) && doubled_area_m2(outline) > 0.0, "{outline:?}");
    }

    #[test]
    fn buildings_stand_by_box_or_outline_in_the_roads_frame() {
        let found = of(
            "<object type=\"building\" id=\"1\" s=\"20\" t=\"-7\" length=\"10\" width=\"4\" height=\"9\" hdg=\"0\"/>\
             <object type=\"none\" name=\"Building2\" id=\"2\" s=\"200\" t=\"15\" height=\"8\" hdg=\"-1.5707963267948966\"><outlines><outline closed=\"true\">\
             <cornerLocal u=\"0\" v=\"0\" height=\"3\"/><cornerLocal u=\"12\" v=\"0\" height=\"5\"/><cornerLocal u=\"12\" v=\"9\"/><cornerLocal u=\"0\" v=\"9\"/>\
             </outline></outlines></object>\
             <object type=\"building\" s=\"300\" t=\"20\"><outline><cornerRoad s=\"300\" t=\"10\"/><cornerRoad s=\"320\" t=\"10\"/><cornerRoad s=\"320\" t=\"25\"/></outline></object>\
             <object type=\"barrier\" s=\"1\" t=\"2\" length=\"9\" width=\"1\"/>",
        );
        let [box_, turned, by_road] = &found.buildings[..] else { panic!("{found:?}") };
        // The road leads north: its right is east.
        assert_corners(&box_.outline, &[[105.0, 65.0], [109.0, 65.0], [109.0, 75.0], [105.0, 75.0]]);
        assert_eq!((box_.height_m, turned.height_m, by_road.height_m), (Some(9.0), Some(5.0), None));
        // Turned by a right angle to the right, its length leads east.
        assert_corners(&turned.outline, &[[85.0, 250.0], [97.0, 250.0], [97.0, 259.0], [85.0, 259.0]]);
        assert_corners(&by_road.outline, &[[90.0, 350.0], [90.0, 370.0], [75.0, 370.0]]);
        assert!(found.areas.is_empty() && found.trees.is_empty());
    }

    #[test]
    fn trees_and_hedges_are_repeated_along_the_road() {
        let found = of(
            "<object type=\"tree\" name=\"spruce\" s=\"0\" t=\"0\"><repeat s=\"100\" length=\"40\" distance=\"20\" tStart=\"6\" tEnd=\"8\"/></object>\
             <object type=\"tree\" s=\"10\" t=\"5\"/>\
             <object type=\"vegetation\" s=\"0\" t=\"0\"><repeat s=\"200\" length=\"50\" distance=\"0\" tStart=\"-6\" tEnd=\"-6\"/></object>\
             <object type=\"tree\" s=\"NaN\" t=\"5\"/><object type=\"tree\" t=\"5\"/>",
        );
        let trees: Vec<_> =
            found.trees.iter().map(|tree| (tree.position.round().to_array(), tree.is_conifer)).collect();
        let row = [([94.0, 150.0], true), ([93.0, 170.0], true), ([92.0, 190.0], true)];
        assert_eq!(trees, [row[0], row[1], row[2], ([95.0, 60.0], false)]);
        let [hedge] = &found.areas[..] else { panic!("{found:?}") };
        assert_eq!((hedge.land_use, hedge.area_m2().round()), (LandUse::Scrub, 50.0));
    }
}
