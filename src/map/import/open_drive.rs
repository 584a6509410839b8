//! Preparation of OpenDRIVE files for netconvert, which ignores speed limits of roads, knows only some kinds of lanes, reads all traffic as
//! right-hand, and refuses ids with spaces. In: the text of a file. Out: a copy of it in which lanes carry the limits of their road, roads
//! of left-hand traffic are mirrored as netconvert wants them, and ids are plain; and the lines for the report. Metres, m/s.

use super::{
    driving_side::DrivingSide,
    plain_ids::PlainIds,
    road_lanes::{self, LaneChanges},
};
use quick_xml::{
    Reader,
    escape::{escape, unescape},
    events::{BytesStart, Event},
};
use std::collections::BTreeMap;

/// Copy of a file, as netconvert reads it.
#[derive(Debug, PartialEq)]
pub(super) struct OpenDriveCopy {
    pub text: String,
    pub side: DrivingSide,
    /// Lines for the report.
    pub notes: Vec<String>,
}

/// Part of a file that contradicts another part.
#[derive(Debug, PartialEq)]
pub(super) struct OpenDriveFault {
    /// Line number, counted from 1.
    pub line: u32,
    /// Element with its id.
    pub element: String,
    pub problem: String,
}

/// Lane types for cars; "bidirectional" becomes a lane of one direction. One without a limit of its own or of its road gets 50 km/h.
const CAR_LANES: [&str; 10] = [
    "driving",
    "entry",
    "exit",
    "offRamp",
    "onRamp",
    "connectingRamp",
    "slipLane",
    "mwyEntry",
    "mwyExit",
    "bidirectional",
];
/// Permissions of netconvert's own lane type "driving".
const FOR_CARS: &str = "speed=\"13.89\" disallow=\"pedestrian rail rail_urban rail_electric rail_fast tram drone aircraft scooter container \
                        wheelchair subway cable_car ship\"";
/// Lane types for other vehicles than cars, or for none. Speeds of those without a limit are netconvert's own.
const OTHER_LANES: [(&str, &str); 13] = [
    ("bus", "speed=\"13.89\" allow=\"bus coach\""),
    ("taxi", "speed=\"13.89\" allow=\"taxi\""),
    ("HOV", "speed=\"13.89\" allow=\"hov bus coach motorcycle\""),
    ("stop", "speed=\"13.89\" allow=\"emergency authority\""),
    ("tram", "speed=\"13.89\" allow=\"tram\""),
    ("rail", "speed=\"33.33\" allow=\"rail rail_urban rail_electric rail_fast\""),
    ("roadWorks", "speed=\"1.39\" allow=\"authority\""),
    ("parking", "speed=\"1.39\" disallow=\"all\""),
    ("restricted", "speed=\"1.39\" disallow=\"all\""),
    ("biking", "speed=\"5.56\" allow=\"bicycle\""),
    ("sidewalk", "speed=\"2.78\" allow=\"pedestrian\""),
    ("walking", "speed=\"2.78\" allow=\"pedestrian\""),
    ("shared", "speed=\"2.78\" allow=\"pedestrian bicycle\""),
];
/// Type, in the copy, of lanes without traffic that keep their place.
const GAP: &str = "gap";

/// Returns the text of netconvert's `--type-files`. Lane types that are not in it have no traffic and are left out.
pub(super) fn lane_types() -> String {
    let for_cars = CAR_LANES.iter().map(|name| (*name, FOR_CARS));
    let rows = for_cars.chain(OTHER_LANES).chain([(GAP, "speed=\"1.39\" disallow=\"all\"")]);
    let rows = rows.map(|(name, text)| format!("<type id=\"{name}\" priority=\"1\" width=\"3.65\" {text}/>\n"));
    let without = "none shoulder border median curb special1 special2 special3".split(' ');
    let without = without.map(|name| format!("<type id=\"{name}\" disallow=\"all\" discard=\"true\"/>\n"));
    format!("<types>\n{}{}</types>\n", rows.collect::<String>(), without.collect::<String>())
}

/// Returns true for a lane type that the network has.
pub(super) fn has_traffic(kind: &str) -> bool {
    CAR_LANES.contains(&kind) || OTHER_LANES.iter().any(|(name, _)| *name == kind)
}

/// Returns true for a lane type that has a speed limit.
pub(super) fn has_limit(kind: &str) -> bool {
    CAR_LANES.contains(&kind) || ["bus", "taxi", "HOV", "stop", "tram"].contains(&kind)
}

/// Prepares a file; `chosen` is the side of traffic that the user named. `None` if the text is not XML: netconvert says where.
///
/// # Errors
/// Some roads have left-hand traffic and others right-hand traffic.
pub(super) fn prepare(text: &str, chosen: Option<DrivingSide>) -> Option<Result<OpenDriveCopy, OpenDriveFault>> {
    let scan = Scan::of(text)?;
    let sides = match scan.sides() {
        Ok(of_file) => (chosen.or(of_file).unwrap_or(DrivingSide::Right), of_file),
        Err(fault) => return Some(Err(fault)),
    };
    let mut copy = Copy {
        ids: PlainIds::of(scan.ids),
        is_mirrored: sides.0 == DrivingSide::Left,
        text: String::with_capacity(text.len() + text.len() / 8),
        limits: road_lanes::LimitCounts::default(),
        kinds: BTreeMap::new(),
        is_gap: false,
    };
    copy.document(text)?;
    Some(Ok(copy.done(sides)))
}

/// Returns the value of an attribute.
pub(super) fn attribute(tag: &BytesStart, name: &str) -> Option<String> {
    let found = tag.try_get_attribute(name).ok()??;
    let text = std::str::from_utf8(&found.value).ok()?;
    Some(unescape(text).ok()?.into_owned())
}

/// Returns the name of a tag.
pub(super) fn name_of<'t>(tag: &'t BytesStart) -> &'t str {
    std::str::from_utf8(tag.name().into_inner()).unwrap_or_default()
}

/// Ids and sides of a file, read before it is copied.
#[derive(Default)]
struct Scan {
    /// Ids to which other elements refer.
    ids: Vec<String>,
    /// First road of each explicit `rule`: id and line.
    left: Option<(String, u32)>,
    right: Option<(String, u32)>,
}

impl Scan {
    fn of(text: &str) -> Option<Self> {
        let mut scan = Self::default();
        let mut reader = Reader::from_str(text);
        loop {
            match reader.read_event().ok()? {
                Event::Start(tag) | Event::Empty(tag)
                    if ["road", "junction", "signal", "controller"].contains(&name_of(&tag)) =>
                {
                    let id = attribute(&tag, "id").unwrap_or_default();
                    let first = match attribute(&tag, "rule").as_deref() {
                        Some("LHT") if name_of(&tag) == "road" => Some(&mut scan.left),
                        Some("RHT") if name_of(&tag) == "road" => Some(&mut scan.right),
                        _ => None,
                    };
                    if let Some(first @ None) = first {
                        let before = &text.as_bytes()[..reader.buffer_position() as usize];
                        *first = Some((id.clone(), 1 + before.iter().filter(|byte| **byte == b'\n').count() as u32));
                    }
                    scan.ids.push(id);
                }
                Event::Eof => return Some(scan),
                _ => {}
            }
        }
    }

    /// Returns the side that the roads name, if any.
    fn sides(&self) -> Result<Option<DrivingSide>, OpenDriveFault> {
        match (&self.left, &self.right) {
            (Some((left, line)), Some((right, other))) => Err(OpenDriveFault {
                line: *line,
                element: format!("road \"{left}\""),
                problem: format!(
                    "rule is \"LHT\" (left-hand traffic), and road \"{right}\" in line {other} has \"RHT\"; allowed: one side \
                     of traffic in a network\n  remedy: import the two parts as two maps"
                ),
            }),
            (Some(_), None) => Ok(Some(DrivingSide::Left)),
            (None, Some(_)) => Ok(Some(DrivingSide::Right)),
            (None, None) => Ok(None),
        }
    }
}

/// Returns the parts of a road with the lanes of each side in reverse order: netconvert takes those of the right side from the centre
/// outwards, and those of the left side inwards, by their order in the file.
fn with_lanes_reversed(events: Vec<Event>) -> Vec<Event> {
    let mut reversed = Vec::with_capacity(events.len());
    // Lanes of the open side, each with all that belongs to it up to the next one.
    let mut lanes: Option<Vec<Vec<Event>>> = None;
    for event in events {
        let name = match &event {
            Event::Start(tag) | Event::Empty(tag) => name_of(tag).to_owned(),
            _ => String::new(),
        };
        let ends_side =
            matches!(&event, Event::End(tag) if [&b"left"[..], b"right"].contains(&tag.name().into_inner()));
        match &mut lanes {
            Some(open) if ends_side => {
                reversed.extend(open.drain(..).rev().flatten());
                reversed.push(event);
                lanes = None;
            }
            Some(open) if name == "lane" => open.push(vec![event]),
            Some(open) if !open.is_empty() => open.last_mut().into_iter().for_each(|lane| lane.push(event.clone())),
            _ => {
                if matches!(event, Event::Start(_)) && ["left", "right"].contains(&name.as_str()) {
                    lanes = Some(Vec::new());
                }
                reversed.push(event);
            }
        }
    }
    reversed
}

/// Copy in the making.
struct Copy {
    ids: PlainIds,
    /// True if lanes of the left side become lanes of the right side: netconvert mirrors them back.
    is_mirrored: bool,
    text: String,
    limits: road_lanes::LimitCounts,
    /// Number of lanes by type.
    kinds: BTreeMap<String, usize>,
    /// True if the lane that is copied becomes one of type [`GAP`].
    is_gap: bool,
}

impl Copy {
    /// Copies a document, road by road.
    fn document(&mut self, text: &str) -> Option<()> {
        let mut reader = Reader::from_str(text);
        let mut road: Option<Vec<Event>> = None;
        loop {
            let event = reader.read_event().ok()?;
            let ends_road = matches!(&event, Event::End(tag) if tag.name().into_inner() == b"road");
            match (&mut road, event) {
                (_, Event::Eof) => return Some(()),
                (None, event) if matches!(&event, Event::Start(tag) if name_of(tag) == "road") => {
                    road = Some(vec![event]);
                }
                (None, event) => self.event(event, &[]),
                (Some(events), event) => events.push(event),
            }
            if ends_road && let Some(events) = road.take() {
                self.road(if self.is_mirrored { with_lanes_reversed(events) } else { events });
            }
        }
    }

    /// Copies a road, with speed limits for its lanes.
    fn road(&mut self, events: Vec<Event>) {
        let mut changes = road_lanes::of_road(&events, &mut self.limits).into_iter();
        let mut lane = LaneChanges::default();
        let mut open: Vec<String> = Vec::new();
        // Number of elements around a limit that is replaced, while it is read.
        let mut skipped = None;
        for event in events {
            let is_replaced = |tag: &BytesStart, open: &[String]| {
                name_of(tag) == "speed" && lane.speeds.is_some() && open.last().is_some_and(|on| on == "lane")
            };
            match &event {
                Event::Start(tag) => {
                    if is_replaced(tag, &open) && skipped.is_none() {
                        skipped = Some(open.len());
                    }
                    if name_of(tag) == "lane" {
                        lane = changes.next().unwrap_or_default();
                        self.count(tag);
                    }
                    open.push(name_of(tag).to_owned());
                }
                Event::Empty(tag) if is_replaced(tag, &open) => continue,
                Event::Empty(tag) if name_of(tag) == "lane" => lane = changes.next().unwrap_or_default(),
                Event::End(_) => {
                    let ended = open.pop();
                    let speeds = lane.speeds.take_if(|_| ended.as_deref() == Some("lane"));
                    self.text += &speeds.unwrap_or_default();
                }
                _ => {}
            }
            if skipped.is_none() {
                self.is_gap = lane.is_gap;
                self.event(event, &open);
            } else if skipped == Some(open.len()) {
                skipped = None;
            }
        }
    }

    fn count(&mut self, lane: &BytesStart) {
        if attribute(lane, "id").is_some_and(|id| id.trim() != "0") {
            *self.kinds.entry(attribute(lane, "type").unwrap_or_default()).or_default() += 1;
        }
    }

    /// Copies a part; `open` are the names of the elements around it in its road, its own included.
    fn event(&mut self, event: Event, open: &[String]) {
        match event {
            Event::Start(tag) => self.tag(&tag, open.len().checked_sub(2).map_or("", |k| &open[k]), ">"),
            Event::Empty(tag) => self.tag(&tag, open.last().map_or("", String::as_str), "/>"),
            Event::End(tag) => {
                let name = String::from_utf8_lossy(tag.name().into_inner()).into_owned();
                self.text += &format!("</{}>", self.side_of(&name, open.last().map_or("", String::as_str)));
            }
            // The copy is UTF-8. Texts, which are descriptions, and comments are not needed, but lines are: netconvert's messages name them.
            Event::Text(text) => {
                let lines = text.iter().filter(|byte| **byte == b'\n').count();
                self.text.extend(std::iter::repeat_n('\n', lines));
            }
            _ => {}
        }
    }

    /// Returns the name of an element, with left and right exchanged in a mirrored road.
    fn side_of<'n>(&self, name: &'n str, around: &str) -> &'n str {
        match name {
            "left" if self.is_mirrored && around == "laneSection" => "right",
            "right" if self.is_mirrored && around == "laneSection" => "left",
            _ => name,
        }
    }

    fn tag(&mut self, tag: &BytesStart, around: &str, end: &str) {
        let name = name_of(tag);
        self.text += &format!("<{}", self.side_of(name, around));
        let is_lane = match name {
            "lane" => ["left", "right"].contains(&around),
            "laneLink" | "validity" => true,
            _ => false,
        };
        for found in tag.attributes().with_checks(false).flatten() {
            let key = String::from_utf8_lossy(found.key.into_inner()).into_owned();
            let raw = String::from_utf8_lossy(&found.value).into_owned();
            let value = unescape(&raw).map_or_else(|_| raw.clone(), |text| text.into_owned());
            let is_number = match key.as_str() {
                "id" => is_lane || self.in_lane_link(name, tag),
                "from" | "to" | "fromLane" | "toLane" => is_lane,
                _ => false,
            };
            let value = match value.trim().parse::<i64>() {
                _ if key == "type" && name == "lane" && self.is_gap => GAP.to_owned(),
                Ok(lane) if is_number && self.is_mirrored => (-lane).to_string(),
                _ if is_number => value,
                _ => self.ids.plain(&key, value),
            };
            self.text += &format!(" {key}=\"{}\"", escape(&value));
        }
        self.text += end;
    }

    /// Returns true for the link of a lane: that of a road names its element.
    fn in_lane_link(&self, name: &str, tag: &BytesStart) -> bool {
        ["predecessor", "successor"].contains(&name) && attribute(tag, "elementId").is_none()
    }

    fn done(self, (side, of_file): (DrivingSide, Option<DrivingSide>)) -> OpenDriveCopy {
        let why = match of_file {
            Some(of_file) if of_file != side => "--driving-side; the file says otherwise",
            Some(DrivingSide::Left) => "rule=\"LHT\" of the roads",
            Some(DrivingSide::Right) => "rule=\"RHT\" of the roads",
            None if side == DrivingSide::Left => "--driving-side",
            None => "the roads name no rule; --driving-side left would change it",
        };
        let mut notes = vec![format!("traffic        on the {}: {why}", side.name())];
        let kinds: Vec<String> = self.kinds.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
        notes.push(format!("lane types     {}", kinds.join(", ")));
        if self.kinds.contains_key("bidirectional") {
            notes.push("               lanes of type bidirectional are driven in one direction".to_owned());
        }
        notes.extend(self.limits.notes());
        notes.extend(self.ids.notes());
        OpenDriveCopy { text: self.text, side, notes }
    }
}
