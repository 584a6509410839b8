//! Elements of an OpenStreetMap file, one after the other, because the file may be larger than the memory. In: the file's text. Out: nodes,
//! ways and relations with their tags.

use super::open_drive::{attribute, name_of};
use quick_xml::{
    Reader,
    events::{BytesStart, Event},
};
use std::io::{self, BufRead};

/// Kind of an element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ElementKind {
    #[default]
    Node,
    Way,
    Relation,
}

impl ElementKind {
    fn of(name: &str) -> Option<Self> {
        match name {
            "node" => Some(Self::Node),
            "way" => Some(Self::Way),
            "relation" => Some(Self::Relation),
            _ => None,
        }
    }
}

/// Way that is part of the outline of an area, or of a hole in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RingMember {
    pub way: i64,
    pub is_inner: bool,
}

/// Node, way or relation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct OsmElement {
    pub kind: ElementKind,
    pub id: i64,
    /// Latitude and longitude of a node, degrees; 0 for others.
    pub place_deg: [f64; 2],
    /// Nodes of a way, in its direction.
    pub nodes: Vec<i64>,
    /// Ways of a relation around areas and holes.
    pub members: Vec<RingMember>,
    /// Keys and their values, in the order of the file.
    pub tags: Vec<(String, String)>,
}

impl RingMember {
    fn of(tag: &BytesStart) -> Option<Self> {
        let role = attribute(tag, "role")?;
        let is_way = attribute(tag, "type").is_some_and(|kind| kind == "way");
        let is_ring = is_way && (role == "outer" || role == "inner");
        id(tag, "ref").filter(|_| is_ring).map(|way| Self { way, is_inner: role == "inner" })
    }
}

impl OsmElement {
    fn of(kind: ElementKind, tag: &BytesStart) -> Option<Self> {
        let number = |name: &str| attribute(tag, name)?.trim().parse::<f64>().ok().filter(|number| number.is_finite());
        let place_deg = match kind {
            ElementKind::Node => [number("lat")?, number("lon")?],
            ElementKind::Way | ElementKind::Relation => [0.0; 2],
        };
        Some(Self { kind, id: id(tag, "id")?, place_deg, ..Self::default() })
    }

    /// Returns the value of a key.
    pub fn value(&self, key: &str) -> Option<&str> {
        value(&self.tags, key)
    }
}

/// Returns the value of a key among tags.
pub(super) fn value<'tags>(tags: &'tags [(String, String)], key: &str) -> Option<&'tags str> {
    tags.iter().find(|(of, _)| of == key).map(|(_, value)| value.trim())
}

/// Calls a function with each node, way and relation of a file that has an id and, for nodes, a place; what is no XML ends the file.
///
/// # Errors
/// Errors of reading.
pub(super) fn each(from: impl BufRead, mut found: impl FnMut(&OsmElement)) -> io::Result<()> {
    let mut reader = Reader::from_reader(from);
    let mut open: Option<OsmElement> = None;
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer) {
            Ok(Event::Empty(tag)) => match (name_of(&tag), &mut open) {
                ("tag", Some(open)) => open.tags.extend(attribute(&tag, "k").zip(attribute(&tag, "v"))),
                ("nd", Some(open)) => open.nodes.extend(id(&tag, "ref")),
                ("member", Some(open)) => open.members.extend(RingMember::of(&tag)),
                (name, _) => {
                    let element = ElementKind::of(name).and_then(|kind| OsmElement::of(kind, &tag));
                    element.iter().for_each(&mut found);
                }
            },
            Ok(Event::Start(tag)) => {
                if let Some(kind) = ElementKind::of(name_of(&tag)) {
                    open = OsmElement::of(kind, &tag);
                }
            }
            Ok(Event::End(tag)) if [&b"node"[..], b"way", b"relation"].contains(&tag.name().into_inner()) => {
                open.take().iter().for_each(&mut found);
            }
            Ok(Event::Eof) => return Ok(()),
            Ok(_) => {}
            Err(quick_xml::Error::Io(error)) => return Err(io::Error::other(error)),
            Err(_) => return Ok(()),
        }
    }
}

fn id(tag: &BytesStart, name: &str) -> Option<i64> {
    attribute(tag, name)?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_read_with_their_tags_and_places() {
        let text = r#"<osm><node id="1" lat="50.5" lon="8.25"/><node id="2" lat="x" lon="8"/><node id="-3" lat="0" lon="-1">
            <tag k="name" v="A &amp; B"/></node><way id="7"><nd ref="1"/><nd ref="-3"/><tag k="highway" v="road"/></way>
            <relation id="9"><member type="way" ref="7" role="inner"/><member type="node" ref="1" role="outer"/></relation>
            <node id="4" lat="1" lon="2"/></osm><"#;
        let mut found = Vec::new();
        each(text.as_bytes(), |element| found.push(element.clone())).expect("read");
        let ids: Vec<_> = found.iter().map(|of| (of.kind, of.id, of.place_deg)).collect();
        let node = |id, place_deg| (ElementKind::Node, id, place_deg);
        let [way, relation] = [(ElementKind::Way, 7, [0.0; 2]), (ElementKind::Relation, 9, [0.0; 2])];
        assert_eq!(ids, [node(1, [50.5, 8.25]), node(-3, [0.0, -1.0]), way, relation, node(4, [1.0, 2.0])]);
        assert_eq!(found[3].members, [RingMember { way: 7, is_inner: true }]);
        assert_eq!((found[1].value("name"), found[2].value("highway")), (Some("A & B"), Some("road")));
        assert_eq!(found[2].nodes, [1, -3]);
        assert!(found[4].tags.is_empty(), "{found:?}");
    }
}
