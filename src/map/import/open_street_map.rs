//! Preparation of OpenStreetMap files for netconvert, which reads all traffic as right-hand, and makes two lanes of half a lane's width of a
//! two-way road with one lane. In: the file, tag by tag, because it may be larger than the memory. Out: a copy with two lanes of full
//! width on such roads, the side of traffic by place, the name of the largest place, and lines for the report.

use super::{driving_side::DrivingSide, left_hand_places::is_left_hand};
use quick_xml::{
    Reader, Writer,
    events::{BytesStart, Event},
};
use std::io::{self, BufRead, BufWriter, Write};

/// Result of a copy.
#[derive(Debug, PartialEq)]
pub(super) struct OpenStreetMapCopy {
    pub side: DrivingSide,
    /// Name of the largest place that a node of the file names.
    pub place: Option<String>,
    /// Lines for the report.
    pub notes: Vec<String>,
}

/// Copies a file; `chosen` is the side of traffic that the user named. `None` if the file is not XML: netconvert says where.
///
/// # Errors
/// Errors of reading and writing.
pub(super) fn copy(
    from: impl BufRead,
    to: impl Write,
    chosen: Option<DrivingSide>,
) -> io::Result<Option<OpenStreetMapCopy>> {
    let mut reader = Reader::from_reader(from);
    let mut writer = Writer::new(BufWriter::new(to));
    let mut places = Places::default();
    let mut names = PlaceNames::default();
    let mut narrow = 0;
    let mut way: Option<Vec<Event<'static>>> = None;
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        let event = match reader.read_event_into(&mut buffer) {
            Ok(Event::Eof) => break,
            Ok(event) => event,
            Err(quick_xml::Error::Io(error)) => return Err(io::Error::other(error)),
            Err(_) => return Ok(None),
        };
        match &event {
            Event::Start(tag) | Event::Empty(tag) if tag.name().into_inner() == b"node" => places.count(tag),
            _ => {}
        }
        names.read(&event);
        let ends_way = matches!(&event, Event::End(tag) if tag.name().into_inner() == b"way");
        match &mut way {
            None if matches!(&event, Event::Start(tag) if tag.name().into_inner() == b"way") => {
                way = Some(vec![event.into_owned()]);
            }
            None => writer.write_event(event)?,
            Some(events) => events.push(event.into_owned()),
        }
        if ends_way && let Some(events) = way.take() {
            narrow += usize::from(write_way(events, &mut writer)?);
        }
    }
    writer.into_inner().flush()?;
    Ok(Some(described(chosen, &places, narrow, names.largest.map(|(_, name)| name))))
}

fn described(chosen: Option<DrivingSide>, places: &Places, narrow: usize, place: Option<String>) -> OpenStreetMapCopy {
    let by_place = if places.left > places.right { DrivingSide::Left } else { DrivingSide::Right };
    let side = chosen.unwrap_or(by_place);
    let (left, all) = (places.left, places.left + places.right);
    let why = match (chosen, left) {
        (Some(_), _) => "--driving-side".to_owned(),
        (None, 0) => "no node lies in a country with left-hand traffic; --driving-side left would change it".to_owned(),
        (None, left) => format!(
            "{left} of {all} nodes lie in countries with left-hand traffic; --driving-side {} would change it",
            if side == DrivingSide::Left { "right" } else { "left" }
        ),
    };
    let mut notes = vec![format!("traffic        on the {}: {why}", side.name())];
    if narrow > 0 {
        notes.push(format!(
            "widened        {narrow} two-way roads with one lane: a lane of 3.2 m in each direction, instead of 1.6 m, which is \
             narrower than a car"
        ));
    }
    notes.extend(place.iter().map(|place| format!("place          {place}, the map's title")));
    OpenStreetMapCopy { side, place, notes }
}

/// Kinds of places that have a sign where their streets begin, the largest first.
const PLACES: [&str; 4] = ["city", "town", "village", "hamlet"];
/// Length of the longest name of a place, characters.
const MOST_NAME: usize = 60;

/// Names of places at nodes.
#[derive(Default)]
struct PlaceNames {
    /// Kind, as an index of [`PLACES`], and name of the node that is read.
    node: Option<(Option<usize>, Option<String>)>,
    /// Largest place so far; of equal ones the first.
    largest: Option<(usize, String)>,
}

impl PlaceNames {
    fn read(&mut self, event: &Event) {
        match event {
            Event::Start(tag) if tag.name().into_inner() == b"node" => self.node = Some((None, None)),
            Event::End(tag) if tag.name().into_inner() == b"node" => {
                if let Some((Some(kind), Some(name))) = self.node.take()
                    && self.largest.as_ref().is_none_or(|(largest, _)| kind < *largest)
                {
                    self.largest = Some((kind, name));
                }
            }
            event => {
                let (Some((kind, name)), Some((key, value))) = (&mut self.node, tag_of(event)) else { return };
                match key.as_str() {
                    "place" => *kind = PLACES.iter().position(|place| *place == value),
                    "name" => {
                        let plain = quick_xml::escape::unescape(&value).map(|plain| plain.into_owned()).ok();
                        *name =
                            plain.filter(|name| name.chars().count() <= MOST_NAME && !name.contains(char::is_control));
                    }
                    _ => {}
                }
            }
        }
    }
}

/// Numbers of nodes by side of traffic.
#[derive(Default)]
struct Places {
    left: usize,
    right: usize,
}

impl Places {
    fn count(&mut self, node: &BytesStart) {
        let number = |name: &str| value(node, name)?.trim().parse::<f64>().ok();
        if let (Some(latitude), Some(longitude)) = (number("lat"), number("lon")) {
            match is_left_hand(latitude, longitude) {
                true => self.left += 1,
                false => self.right += 1,
            }
        }
    }
}

fn value(tag: &BytesStart, name: &str) -> Option<String> {
    let found = tag.try_get_attribute(name).ok()??;
    Some(String::from_utf8_lossy(&found.value).into_owned())
}

/// Writes a way, with two lanes if it is a two-way road with one. Returns true if it is.
fn write_way(events: Vec<Event>, writer: &mut Writer<impl Write>) -> io::Result<bool> {
    let is_narrow = {
        let tags: Vec<(String, String)> = events.iter().filter_map(tag_of).collect();
        let is = |key: &str, values: &[&str]| tags.iter().any(|(k, v)| k == key && values.contains(&v.as_str()));
        let has_one_direction = is("oneway", &["yes", "true", "1", "-1", "reverse"])
            || is("junction", &["roundabout", "circular"])
            || is("highway", &["motorway", "motorway_link"]);
        is("lanes", &["1"]) && tags.iter().any(|(key, _)| key == "highway") && !has_one_direction
    };
    for event in events {
        let is_lanes = tag_of(&event).is_some_and(|(key, _)| key == "lanes");
        match event {
            Event::Empty(_) if is_narrow && is_lanes => {
                writer.write_event(Event::Empty(BytesStart::from_content("tag k=\"lanes\" v=\"2\"", 3)))?;
            }
            event => writer.write_event(event)?,
        }
    }
    Ok(is_narrow)
}

/// Returns key and value of a `<tag>`.
fn tag_of(event: &Event) -> Option<(String, String)> {
    match event {
        Event::Empty(tag) | Event::Start(tag) if tag.name().into_inner() == b"tag" => {
            Some((value(tag, "k")?, value(tag, "v")?))
        }
        _ => None,
    }
}
