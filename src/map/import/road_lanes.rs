//! Speed limits of the lanes of an OpenDRIVE road, a lane's own, else those of the road's types; and lanes that netconvert would leave out
//! though lanes with traffic lie outside of them, which would move inwards. In: the parts of a road. Out: for each lane the elements that
//! name its limits, all in m/s, and whether it is such a gap. Metres.

use super::open_drive::{attribute, has_limit, has_traffic, name_of};
use quick_xml::events::{BytesStart, Event};

/// Speed of a road that has expressly no limit, m/s: netconvert's own for such roads of OpenStreetMap, 142 km/h.
const NO_LIMIT_MPS: f64 = 142.0 / 3.6;
/// Speed where no limit is known, m/s: netconvert's default, 50 km/h.
const UNKNOWN_MPS: f64 = 13.89;
/// Shortest stretch with a limit of its own, metres: netconvert makes an edge of each.
const SHORTEST_M: f64 = 1.0;

/// Limit as a file names it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SpeedLimit {
    Mps(f64),
    /// `no limit`.
    None,
    /// Absent, `undefined`, or no positive number.
    Unknown,
}

impl SpeedLimit {
    fn of(speed: &BytesStart) -> Self {
        let max = attribute(speed, "max").unwrap_or_default();
        let factor = match attribute(speed, "unit").as_deref() {
            Some("km/h") => 1.0 / 3.6,
            Some("mph") => crate::units::MPS_PER_MPH,
            _ => 1.0,
        };
        match max.trim().parse::<f64>() {
            Ok(limit) if limit > 0.0 && limit.is_finite() => Self::Mps(limit * factor),
            _ if max.trim() == "no limit" => Self::None,
            _ => Self::Unknown,
        }
    }
}

/// Numbers of roads whose cars have no limit by the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LimitCounts {
    /// Roads that expressly have no limit.
    pub unlimited: usize,
    /// Roads that name no limit for some stretch.
    pub unknown: usize,
}

impl LimitCounts {
    /// Returns the lines for the report.
    pub fn notes(self) -> Vec<String> {
        let row = |n: usize, words: &str, kmh: &str| match n {
            0 => None,
            1 => Some(format!("limits         {kmh} km/h for 1 road that has {words}")),
            n => Some(format!("limits         {kmh} km/h for {n} roads that have {words}")),
        };
        let rows = [row(self.unknown, "none in the file", "50"), row(self.unlimited, "\"no limit\"", "142")];
        rows.into_iter().flatten().collect()
    }
}

/// Limits from a place on, metres.
type FromPlace = (f64, SpeedLimit);

/// Lane of a road, with its own limits.
struct RoadLane {
    /// Index of its section.
    section: usize,
    /// Number of the lane, outwards from the centre; positive on the left.
    number: i64,
    has_limit: bool,
    has_traffic: bool,
    own: Vec<FromPlace>,
}

/// Lanes of a road, with the limits of its types.
#[derive(Default)]
struct RoadLanes {
    length_m: f64,
    /// True for a road inside a junction.
    is_inside: bool,
    types: Vec<FromPlace>,
    sections_m: Vec<f64>,
    lanes: Vec<RoadLane>,
}

impl RoadLanes {
    fn of(events: &[Event]) -> Self {
        let mut road = Self::default();
        let mut open: Vec<String> = Vec::new();
        for event in events {
            match event {
                Event::Start(tag) => {
                    road.look(tag, &open);
                    open.push(name_of(tag).to_owned());
                }
                Event::Empty(tag) => road.look(tag, &open),
                Event::End(_) => drop(open.pop()),
                _ => {}
            }
        }
        road.types.sort_by(|a, b| a.0.total_cmp(&b.0));
        road
    }

    fn look(&mut self, tag: &BytesStart, open: &[String]) {
        let number = |name: &str| attribute(tag, name).and_then(|text| text.trim().parse::<f64>().ok()).unwrap_or(0.0);
        let around = open.last().map_or("", String::as_str);
        match (name_of(tag), around) {
            ("road", "") => {
                self.length_m = number("length");
                self.is_inside = attribute(tag, "junction").is_some_and(|junction| junction != "-1");
            }
            ("type", "road") => self.types.push((number("s"), SpeedLimit::Unknown)),
            ("speed", "type") => {
                if let Some((_, limit)) = self.types.last_mut() {
                    *limit = SpeedLimit::of(tag);
                }
            }
            ("laneSection", _) => self.sections_m.push(number("s")),
            ("lane", _) => {
                let is_a = |test: fn(&str) -> bool| {
                    attribute(tag, "type").is_some_and(|kind| around != "center" && test(&kind))
                };
                self.lanes.push(RoadLane {
                    section: self.sections_m.len().saturating_sub(1),
                    number: attribute(tag, "id").and_then(|id| id.trim().parse().ok()).unwrap_or(0),
                    has_limit: is_a(has_limit),
                    has_traffic: is_a(has_traffic),
                    own: Vec::new(),
                });
            }
            ("speed", "lane") => {
                if let Some(lane) = self.lanes.last_mut() {
                    lane.own.push((number("sOffset"), SpeedLimit::of(tag)));
                    lane.own.sort_by(|a, b| a.0.total_cmp(&b.0));
                }
            }
            _ => {}
        }
    }

    fn is_gap(&self, lane: &RoadLane) -> bool {
        let is_outside = |other: &RoadLane| {
            other.section == lane.section
                && other.number.signum() == lane.number.signum()
                && other.number.abs() > lane.number.abs()
        };
        lane.number != 0 && !lane.has_traffic && self.lanes.iter().any(|other| other.has_traffic && is_outside(other))
    }

    /// Returns the limits of a lane from its section's start on; neighbours differ.
    fn of_lane(&self, lane: &RoadLane) -> Vec<FromPlace> {
        let begin_m = self.sections_m.get(lane.section).copied().unwrap_or(0.0);
        let end_m = self.sections_m.get(lane.section + 1).copied().unwrap_or(self.length_m);
        let at = |limits: &[FromPlace], s_m: f64| {
            limits
                .iter()
                .rev()
                .find(|(from_m, _)| *from_m <= s_m + 1e-6)
                .map_or(SpeedLimit::Unknown, |(_, limit)| *limit)
        };
        let of_types = self.types.iter().map(|(s_m, _)| s_m - begin_m);
        let mut places: Vec<f64> = lane.own.iter().map(|(s_m, _)| *s_m).chain(of_types).collect();
        places.retain(|s_m| (SHORTEST_M..end_m - begin_m - SHORTEST_M).contains(s_m));
        places.push(0.0);
        places.sort_by(f64::total_cmp);
        let mut limits: Vec<FromPlace> = Vec::new();
        for s_m in places {
            let limit = match at(&lane.own, s_m) {
                SpeedLimit::Unknown => at(&self.types, begin_m + s_m),
                own => own,
            };
            if limits.last().is_none_or(|(_, last)| *last != limit) {
                limits.push((s_m, limit));
            }
        }
        limits
    }
}

/// Changes to a lane for netconvert.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LaneChanges {
    /// Elements `<speed>` in place of the lane's own; `None` keeps those.
    pub speeds: Option<String>,
    /// True for a lane without traffic that keeps its place, because lanes with traffic lie outside of it.
    pub is_gap: bool,
}

/// Returns the changes to the lanes of a road, in their order.
pub(super) fn of_road(events: &[Event], counts: &mut LimitCounts) -> Vec<LaneChanges> {
    let road = RoadLanes::of(events);
    let limits: Vec<Option<Vec<FromPlace>>> =
        road.lanes.iter().map(|lane| lane.has_limit.then(|| road.of_lane(lane))).collect();
    let any = |wanted| limits.iter().flatten().flatten().any(|(_, limit)| *limit == wanted);
    counts.unlimited += usize::from(any(SpeedLimit::None));
    // Roads inside junctions have limits of the roads that they join.
    counts.unknown += usize::from(any(SpeedLimit::Unknown) && !road.is_inside);
    let is_known = |limits: &Vec<FromPlace>| limits.iter().any(|(_, limit)| *limit != SpeedLimit::Unknown);
    let text = |limits: Vec<FromPlace>| limits.into_iter().map(element).collect();
    let changes = road
        .lanes
        .iter()
        .zip(limits)
        .map(|(lane, limits)| LaneChanges { speeds: limits.filter(is_known).map(text), is_gap: road.is_gap(lane) });
    changes.collect()
}

fn element((from_m, limit): FromPlace) -> String {
    let mps = match limit {
        SpeedLimit::Mps(mps) => mps,
        SpeedLimit::None => NO_LIMIT_MPS,
        SpeedLimit::Unknown => UNKNOWN_MPS,
    };
    format!("<speed sOffset=\"{from_m}\" max=\"{mps:.9}\" unit=\"m/s\"/>")
}
