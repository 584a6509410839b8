//! Places on the roads of an OpenDRIVE file, by road, lane and distance. In: the file. Out: [`OpenDriveRoads`], with points and headings in the
//! file's coordinates, metres and radians. [`import()`](crate::map::import()) makes the network of such a file; scenarios of other programs name places on
//! its roads.

use super::{
    MapError,
    limits::MOST_BYTES,
    reference_line::{ReferenceLine, number},
    surroundings::tree_of,
};
use crate::sumo_xml::document;
use glam::DVec2;
use roxmltree::Node;
use std::path::Path;

/// Roads of an OpenDRIVE file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenDriveRoads {
    roads: Vec<OpenDriveRoad>,
}

/// Road of an OpenDRIVE file: a reference line with lanes beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenDriveRoad {
    /// Name by which other elements refer to the road.
    pub id: String,
    /// Length along the reference line, m.
    pub length_m: f64,
    /// True where vehicles drive on the left.
    pub is_left_hand: bool,
    /// Lights and signs beside the road.
    pub signals: Vec<OpenDriveSignal>,
    line: ReferenceLine,
    /// Offset of the middle lane from the reference line, by the distance from which each applies.
    lane_offsets: Vec<Cubic>,
    /// Sections of lanes, ascending by their start.
    sections: Vec<LaneSection>,
}

/// Light or sign beside a road.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenDriveSignal {
    /// Name by which scenarios refer to the signal.
    pub id: String,
    /// Number of the kind in the list of its country; 1000001 is a light for vehicles with three lamps, 1000002 one for people on foot.
    pub kind: String,
    /// Distance along the road, m.
    pub s_m: f64,
    /// Distance to the left of the reference line, m.
    pub t_m: f64,
    /// True for one that rules those along the reference line, false for those against it; `None` for both.
    pub is_along: Option<bool>,
}

/// Cubic polynomial that applies from a distance on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cubic {
    start_m: f64,
    coefficients: [f64; 4],
}

/// Lanes side by side from a distance on.
#[derive(Clone, Debug, PartialEq)]
struct LaneSection {
    start_m: f64,
    /// Lanes to the left of the middle, and those to the right, each from the middle outwards.
    sides: [Vec<OpenDriveLane>; 2],
}

#[derive(Clone, Debug, PartialEq)]
struct OpenDriveLane {
    id: i32,
    /// Widths, or distances of the outer border from the middle lane.
    edges: Vec<Cubic>,
    is_by_border: bool,
    /// Type of the lane, such as `driving` or `shoulder`.
    kind: String,
}

impl Cubic {
    /// Reads a polynomial that starts at the attribute `start`.
    fn of(node: Node, start: &str) -> Option<Self> {
        let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| number(node, name));
        Some(Self { start_m: number(node, start)?, coefficients: [a?, b?, c?, d?] })
    }

    /// Returns the value of the polynomial that applies at a distance; `None` before the first one.
    fn at(list: &[Self], s_m: f64) -> Option<f64> {
        let before = list.iter().rev().find(|cubic| cubic.start_m <= s_m)?;
        let ([a, b, c, d], m) = (before.coefficients, s_m - before.start_m);
        Some(a + m * (b + m * (c + m * d)))
    }

    /// Reads all children with this name, ascending by their start.
    fn all(node: Node, name: &str, start: &str) -> Vec<Self> {
        let named = node.children().filter(|child| child.has_tag_name(name));
        let mut list: Vec<Self> = named.filter_map(|child| Self::of(child, start)).collect();
        list.sort_by(|a, b| a.start_m.total_cmp(&b.start_m));
        list
    }
}

impl LaneSection {
    fn of(node: Node) -> Option<Self> {
        let side = |name: &str| {
            let groups = node.children().filter(|child| child.has_tag_name(name));
            let lanes = groups.flat_map(|group| group.children().filter(|child| child.has_tag_name("lane")));
            let mut lanes: Vec<OpenDriveLane> = lanes.filter_map(OpenDriveLane::of).collect();
            lanes.sort_by_key(|lane| lane.id.unsigned_abs());
            lanes
        };
        Some(Self { start_m: number(node, "s")?, sides: [side("left"), side("right")] })
    }

    /// Returns the distances of the inner and the outer border of a lane from the middle lane, both positive, m.
    fn borders_m(&self, lane: i32, s_m: f64) -> Option<[f64; 2]> {
        let along_m = (s_m - self.start_m).max(0.0);
        let mut inner_m = 0.0;
        for of_side in &self.sides[usize::from(lane < 0)] {
            let value_m = Cubic::at(&of_side.edges, along_m)?.abs();
            let outer_m = if of_side.is_by_border { value_m } else { inner_m + value_m };
            if of_side.id == lane {
                return Some([inner_m, outer_m]);
            }
            inner_m = outer_m;
        }
        None
    }
}

impl OpenDriveLane {
    fn of(node: Node) -> Option<Self> {
        let widths = Cubic::all(node, "width", "sOffset");
        let is_by_border = widths.is_empty();
        let edges = if is_by_border { Cubic::all(node, "border", "sOffset") } else { widths };
        let (id, kind) = (node.attribute("id")?.trim().parse().ok()?, node.attribute("type").unwrap_or("none"));
        Some(Self { id, edges, is_by_border, kind: kind.to_owned() })
    }
}

impl OpenDriveRoads {
    /// Reads the roads of an OpenDRIVE file of at most 48 MiB. Roads, lanes and signals without their numbers are left out.
    ///
    /// # Errors
    /// The file cannot be read or is no XML.
    pub fn read(file: &Path) -> Result<Self, MapError> {
        let text =
            document::read_text(file, MOST_BYTES).map_err(|source| MapError::Io { file: file.into(), source })?;
        let tree = tree_of(file, &text)?;
        let roads = tree.root_element().children().filter(|node| node.has_tag_name("road"));
        Ok(Self { roads: roads.filter_map(OpenDriveRoad::of).collect() })
    }

    /// Returns all roads in the order of the file.
    pub fn roads(&self) -> &[OpenDriveRoad] {
        &self.roads
    }

    /// Returns the road with this id.
    pub fn road(&self, id: &str) -> Option<&OpenDriveRoad> {
        self.roads.iter().find(|road| road.id == id)
    }
}

impl OpenDriveRoad {
    fn of(node: Node) -> Option<Self> {
        let lanes = node.children().find(|child| child.has_tag_name("lanes"));
        let sections = lanes.into_iter().flat_map(|lanes| lanes.children());
        let mut sections: Vec<LaneSection> =
            sections.filter(|child| child.has_tag_name("laneSection")).filter_map(LaneSection::of).collect();
        sections.sort_by(|a, b| a.start_m.total_cmp(&b.start_m));
        let signals = node.children().filter(|child| child.has_tag_name("signals"));
        let signals = signals.flat_map(|signals| signals.children().filter(|child| child.has_tag_name("signal")));
        Some(Self {
            id: node.attribute("id")?.to_owned(),
            length_m: number(node, "length")?,
            is_left_hand: node.attribute("rule") == Some("LHT"),
            signals: signals.filter_map(OpenDriveSignal::of).collect(),
            line: ReferenceLine::of(node),
            lane_offsets: lanes.map(|lanes| Cubic::all(lanes, "laneOffset", "s")).unwrap_or_default(),
            sections,
        })
    }

    fn section(&self, s_m: f64) -> Option<&LaneSection> {
        self.sections.iter().rev().find(|section| section.start_m <= s_m).or(self.sections.first())
    }

    /// Returns the ids of the lanes at a distance, from the left to the right of the reference line, without the middle lane 0.
    pub fn lanes_at(&self, s_m: f64) -> Vec<i32> {
        let Some(LaneSection { sides: [left, right], .. }) = self.section(s_m) else { return Vec::new() };
        left.iter().rev().chain(right).map(|lane| lane.id).collect()
    }

    /// Returns the distance of a lane's middle to the left of the reference line, m; `None` without such a lane.
    pub fn lane_middle_m(&self, lane: i32, s_m: f64) -> Option<f64> {
        let offset_m = Cubic::at(&self.lane_offsets, s_m).unwrap_or(0.0);
        if lane == 0 {
            return Some(offset_m);
        }
        let [inner_m, outer_m] = self.section(s_m)?.borders_m(lane, s_m)?;
        Some(offset_m + f64::from(lane.signum()) * (inner_m + outer_m) / 2.0)
    }

    /// Returns the width of the strip beside the lanes for cars that is still road, such as a shoulder or a pavement, m: the wider one of both sides.
    /// `None` where the road has no lane for cars.
    pub fn beside_driving_m(&self, s_m: f64) -> Option<f64> {
        let section = self.section(s_m)?;
        let border_m = |side: &[OpenDriveLane], is_in: &dyn Fn(&str) -> bool| {
            let outermost = side.iter().rev().find(|lane| is_in(&lane.kind))?;
            section.borders_m(outermost.id, s_m).map(|[_, outer_m]| outer_m)
        };
        let of_side = |side: &Vec<OpenDriveLane>| {
            Some(border_m(side, &|kind| kind != "none")? - border_m(side, &|kind| kind == "driving")?)
        };
        section.sides.iter().filter_map(of_side).reduce(f64::max)
    }

    /// Returns the lane at a distance to the left of the reference line; `None` beside all lanes.
    pub fn lane_under(&self, s_m: f64, t_m: f64) -> Option<i32> {
        let beside_m = t_m - Cubic::at(&self.lane_offsets, s_m).unwrap_or(0.0);
        let section = self.section(s_m)?;
        let is_under = |lane: &i32| {
            let borders_m = section.borders_m(*lane, s_m);
            let is_side = f64::from(lane.signum()) * beside_m >= 0.0;
            is_side && borders_m.is_some_and(|[inner_m, outer_m]| (inner_m..=outer_m).contains(&beside_m.abs()))
        };
        self.lanes_at(s_m).into_iter().find(is_under)
    }

    /// Returns true if vehicles on a lane drive along the reference line, false if they drive against it.
    pub fn drives_along(&self, lane: i32) -> bool {
        (lane < 0) != self.is_left_hand
    }

    /// Returns the point at a distance along the road and to the left of its line, and the heading of the line there, rad.
    pub fn place(&self, s_m: f64, t_m: f64) -> Option<(DVec2, f64)> {
        let (_, heading_rad) = self.line.at(s_m)?;
        Some((self.line.beside(s_m, t_m)?, heading_rad))
    }
}

impl OpenDriveSignal {
    fn of(node: Node) -> Option<Self> {
        let text = |name: &str| node.attribute(name).map(str::to_owned);
        Some(Self {
            id: text("id")?,
            kind: text("type").unwrap_or_default(),
            s_m: number(node, "s")?,
            t_m: number(node, "t")?,
            is_along: match node.attribute("orientation") {
                Some("+") => Some(true),
                Some("-") => Some(false),
                _ => None,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    /// Returns a road of 200 m to the north from (10, 20) with these lanes.
    fn road(lanes: &str) -> OpenDriveRoad {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("road.xodr");
        let text = format!(
            "<OpenDRIVE><road id=\"7\" length=\"200\"><planView><geometry s=\"0\" x=\"10\" y=\"20\" hdg=\"1.5707963267948966\" \
             length=\"200\"><line/></geometry></planView><lanes>{lanes}</lanes><signals><signal id=\"9\" s=\"150\" t=\"-4\" \
             type=\"1000001\"/></signals></road></OpenDRIVE>"
        );
        std::fs::write(&file, text).expect("written");
        OpenDriveRoads::read(&file).expect("roads").road("7").expect("the road").clone()
    }

    fn lane(id: i32, edges: &str) -> String {
        format!("<lane id=\"{id}\" type=\"driving\">{edges}</lane>")
    }

    fn width(from_m: f64, width_m: f64, slope: f64) -> String {
        format!("<width sOffset=\"{from_m}\" a=\"{width_m}\" b=\"{slope}\" c=\"0\" d=\"0\"/>")
    }

    #[test]
    fn lane_middles_add_up_the_widths_inside_and_the_offset() {
        let left = lane(2, &width(0.0, 3.0, 0.0)) + &lane(1, &width(0.0, 2.0, 0.0));
        let right = lane(-1, &width(0.0, 3.0, 0.0)) + &lane(-2, &(width(0.0, 4.0, 0.0) + &width(50.0, 4.0, 0.02)));
        let section = |s_m: f64| {
            format!(
                "<laneSection s=\"{s_m}\"><left>{left}</left><center/>\
                                  <right>{right}</right></laneSection>"
            )
        };
        let offset = "<laneOffset s=\"100\" a=\"1\" b=\"0\" c=\"0.0001\" d=\"0\"/>";
        let road = road(&(offset.to_owned() + &section(0.0) + &section(100.0)));
        assert_eq!(road.lanes_at(20.0), [2, 1, -1, -2]);
        let near = |found: Option<f64>, wanted_m: f64| {
            assert!(found.is_some_and(|found_m| (found_m - wanted_m).abs() < 1e-9), "{found:?} {wanted_m}");
        };
        // Before 100 m there is no offset.
        near(road.lane_middle_m(2, 20.0), 2.0 + 1.5);
        // At 160 m the second section is 60 m old: width 4 + 0.02 · 10 = 4.2; offset 1 + 0.0001 · 60² = 1.36.
        near(road.lane_middle_m(-2, 160.0), 1.36 - 3.0 - 2.1);
        assert_eq!(road.lane_under(160.0, 1.36 - 6.9), Some(-2));
        assert_eq!((road.lane_under(160.0, 1.5), road.lane_under(160.0, -9.0)), (Some(1), None));
        assert_eq!((road.lane_middle_m(3, 20.0), road.lane_middle_m(-3, 20.0)), (None, None));
        // The road leads north, its left is west.
        let (point, heading_rad) = road.place(150.0, -4.0).expect("a place");
        assert!(point.distance(dvec2(14.0, 170.0)) < 1e-9 && (heading_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
        assert_eq!((road.signals[0].id.as_str(), road.signals[0].s_m), ("9", 150.0));
    }

    #[test]
    fn lanes_by_their_borders_lie_between_them() {
        let border = |outer_m: f64| format!("<border sOffset=\"0\" a=\"{outer_m}\" b=\"0\" c=\"0\" d=\"0\"/>");
        let right = lane(-1, &border(-3.0)) + &lane(-2, &border(-7.0));
        let road = road(&format!("<laneSection s=\"0\"><right>{right}</right></laneSection>"));
        assert_eq!((road.lane_middle_m(-1, 5.0), road.lane_middle_m(-2, 5.0)), (Some(-1.5), Some(-5.0)));
        assert!(road.drives_along(-1) && !road.drives_along(1));
    }
}
