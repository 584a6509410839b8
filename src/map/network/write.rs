//! Writing a network. In: a [`Network`]. Out: the text of a net.xml that reads as an equal network, and that netconvert and SUMO accept.
//! Numbers are written with as many digits as they need to be read back exactly.

use super::{
    Connection, ConnectionOptions, Edge, EdgeKind, Junction, Lane, LaneId, LaneSpread, Network, Signal, VehicleClasses,
    read::DEFAULT_WIDTH_M,
};
use glam::DVec3;
use std::fmt::Write;

/// Start tag being written.
struct Tag<'t> {
    text: &'t mut String,
}

impl<'t> Tag<'t> {
    fn new(text: &'t mut String, indent: usize, name: &str) -> Self {
        let _ = write!(text, "{:indent$}<{name}", "", indent = 4 * indent);
        Self { text }
    }

    fn with(self, name: &str, value: &str) -> Self {
        let _ = write!(self.text, " {name}=\"");
        for c in value.chars() {
            match c {
                '&' => self.text.push_str("&amp;"),
                '<' => self.text.push_str("&lt;"),
                '>' => self.text.push_str("&gt;"),
                '"' => self.text.push_str("&quot;"),
                '\n' | '\r' | '\t' => {
                    let _ = write!(self.text, "&#{};", c as u32);
                }
                c => self.text.push(c),
            }
        }
        self.text.push('"');
        self
    }

    fn number(self, name: &str, value: f64) -> Self {
        let _ = write!(self.text, " {name}=\"{value}\"");
        self
    }

    fn some(self, name: &str, value: Option<&str>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    fn some_number(self, name: &str, value: Option<f64>) -> Self {
        match value {
            Some(value) => self.number(name, value),
            None => self,
        }
    }

    /// Writes a flag if it differs from its default `otherwise`.
    fn flag(self, name: &str, value: bool, otherwise: bool) -> Self {
        if value == otherwise { self } else { self.with(name, if value { "1" } else { "0" }) }
    }

    fn points(self, name: &str, points: &[DVec3]) -> Self {
        if points.is_empty() {
            return self;
        }
        let _ = write!(self.text, " {name}=\"");
        for (k, point) in points.iter().enumerate() {
            let space = if k == 0 { "" } else { " " };
            let _ = write!(self.text, "{space}{},{}", point.x, point.y);
            // A height of -0 is written too: only a height that reads back as +0 is left out.
            if point.z.to_bits() != 0 {
                let _ = write!(self.text, ",{}", point.z);
            }
        }
        self.text.push('"');
        self
    }

    fn pairs(self, pairs: &[(String, String)]) -> Self {
        pairs.iter().fold(self, |tag, (name, value)| tag.with(name, value))
    }

    fn close(self) {
        self.text.push_str("/>\n");
    }

    fn open(self) {
        self.text.push_str(">\n");
    }
}

/// Joins ids with spaces.
fn list<'a>(ids: impl Iterator<Item = &'a str>) -> String {
    ids.collect::<Vec<_>>().join(" ")
}

/// Writes `allow` or `disallow`, whichever list is shorter.
fn permissions<'t>(tag: Tag<'t>, classes: VehicleClasses) -> Tag<'t> {
    let refused = VehicleClasses::ALL.without(classes);
    if refused.is_empty() {
        return tag;
    }
    if classes.names().count() > refused.names().count() || classes.is_empty() {
        tag.with("disallow", &refused.list())
    } else {
        tag.with("allow", &classes.list())
    }
}

/// Writes a list of classes, unless it contains all classes.
fn classes<'t>(tag: Tag<'t>, name: &str, classes: VehicleClasses) -> Tag<'t> {
    if classes == VehicleClasses::ALL { tag } else { tag.with(name, &class_list(classes)) }
}

/// Returns SUMO's list of classes. The empty set becomes `none`, which is not a class name: an empty list would mean all classes.
fn class_list(classes: VehicleClasses) -> String {
    if classes.is_empty() { "none".into() } else { classes.list() }
}

impl Network {
    /// Returns the text of a net.xml of the network.
    pub fn to_net_xml(&self) -> String {
        let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        Tag::new(&mut text, 0, "net").pairs(&self.header).open();
        if !self.location.is_empty() {
            Tag::new(&mut text, 1, "location").pairs(&self.location).close();
        }
        // netconvert's order: internal edges first, then streets.
        self.edges.iter().for_each(|edge| self.write_edge(&mut text, edge));
        self.signals.iter().for_each(|signal| write_signal(&mut text, signal));
        self.junctions
            .iter()
            .filter(|junction| junction.declared)
            .for_each(|junction| self.write_junction(&mut text, junction));
        self.connections.iter().for_each(|connection| self.write_connection(&mut text, connection));
        for roundabout in &self.roundabouts {
            let junctions = list(roundabout.junctions.iter().map(|junction| self.junction(*junction).id.as_str()));
            let edges = list(roundabout.edges.iter().map(|edge| self.edge(*edge).id.as_str()));
            Tag::new(&mut text, 1, "roundabout").with("nodes", &junctions).with("edges", &edges).close();
        }
        text + "</net>\n"
    }

    fn write_edge(&self, text: &mut String, edge: &Edge) {
        let junction = |id: Option<super::JunctionId>| id.map(|id| self.junction(id).id.as_str());
        let mut tag = Tag::new(text, 1, "edge").with("id", &edge.id);
        if edge.kind != EdgeKind::Normal {
            tag = tag.with("function", edge.kind.name());
        }
        tag = tag.some("from", junction(edge.from)).some("to", junction(edge.to)).some("name", edge.name.as_deref());
        tag = tag.some("priority", edge.priority.map(|priority| priority.to_string()).as_deref());
        tag = tag.some("type", edge.road_type.as_deref());
        if edge.spread != LaneSpread::Right {
            tag = tag.with("spreadType", edge.spread.name());
        }
        tag = tag.some_number("length", edge.length_m).points("shape", &edge.shape);
        tag = tag.some_number("distance", edge.distance_m).some("bidi", edge.bidi.map(|id| self.edge(id).id.as_str()));
        if !edge.crosses.is_empty() {
            tag = tag.with("crossingEdges", &list(edge.crosses.iter().map(|id| self.edge(*id).id.as_str())));
        }
        tag.open();
        edge.lanes().for_each(|lane| self.write_lane(text, lane));
        text.push_str("    </edge>\n");
    }

    fn write_lane(&self, text: &mut String, id: LaneId) {
        let lane: &Lane = self.lane(id);
        let index = self.index_in_edge(id).to_string();
        let mut tag = Tag::new(text, 2, "lane").with("id", &lane.id).with("index", &index);
        tag = permissions(tag, lane.permissions)
            .number("speed", lane.speed_limit_mps)
            .some_number("friction", lane.friction);
        tag = tag.number("length", lane.length_m);
        if lane.end_offset_m != 0.0 {
            tag = tag.number("endOffset", lane.end_offset_m);
        }
        if lane.width_m != DEFAULT_WIDTH_M {
            tag = tag.number("width", lane.width_m);
        }
        tag = tag.flag("acceleration", lane.acceleration, false).flag("customShape", lane.custom_shape, false);
        tag = classes(tag, "changeLeft", lane.change_left);
        tag = classes(tag, "changeRight", lane.change_right);
        tag = tag
            .points("shape", lane.shape())
            .some("type", lane.lane_type.as_deref())
            .points("outlineShape", &lane.outline);
        match lane.opposite {
            None => tag.close(),
            Some(opposite) => {
                tag.open();
                Tag::new(text, 3, "neigh").with("lane", &self.lane(opposite).id).close();
                text.push_str("        </lane>\n");
            }
        }
    }

    fn write_junction(&self, text: &mut String, junction: &Junction) {
        let lanes = |lanes: &[LaneId]| list(lanes.iter().map(|lane| self.lane(*lane).id.as_str()));
        let mut tag = Tag::new(text, 1, "junction").with("id", &junction.id).with("type", junction.kind.name());
        tag = tag.number("x", junction.position.x).number("y", junction.position.y);
        if junction.position.z.to_bits() != 0 {
            tag = tag.number("z", junction.position.z);
        }
        tag = tag.with("incLanes", &lanes(&junction.incoming)).with("intLanes", &lanes(&junction.inside));
        tag = tag.some_number("radius", junction.radius_m).points("shape", &junction.shape);
        tag = tag.flag("customShape", junction.custom_shape, false).some("name", junction.name.as_deref());
        tag = tag.pairs(&junction.other);
        if junction.links.is_empty() {
            return tag.close();
        }
        tag.open();
        let n = junction.links.len();
        for (k, link) in junction.links.iter().enumerate() {
            Tag::new(text, 2, "request")
                .with("index", &k.to_string())
                .with("response", &link.yields_to.bits(n))
                .with("foes", &link.crosses.bits(n))
                .with("cont", if link.waits_inside { "1" } else { "0" })
                .close();
        }
        text.push_str("    </junction>\n");
    }

    fn write_connection(&self, text: &mut String, connection: &Connection) {
        let end = |lane: LaneId| (self.edge_of(lane).id.as_str(), self.index_in_edge(lane).to_string());
        let ((from, from_lane), (to, to_lane)) = (end(connection.from), end(connection.to));
        let mut tag = Tag::new(text, 1, "connection").with("from", from).with("to", to);
        tag = tag.with("fromLane", &from_lane).with("toLane", &to_lane).flag("keepClear", connection.keep_clear, true);
        if let Some(options) = &connection.options {
            tag = write_options(tag, options);
        }
        tag = tag.some("via", connection.via.map(|lane| self.lane(lane).id.as_str()));
        if let Some(ruled) = connection.signal {
            tag = tag
                .with("tl", &self.signal(ruled.signal).id)
                .with("linkIndex", &ruled.index.map_or("-1".to_owned(), |index| index.to_string()));
            tag = tag.some("linkIndex2", ruled.second.map(|index| index.to_string()).as_deref());
        }
        tag.with("dir", connection.direction.name()).with("state", connection.state.name()).close();
    }
}

fn write_options<'t>(tag: Tag<'t>, options: &ConnectionOptions) -> Tag<'t> {
    let mut tag = tag.flag("pass", options.pass, false).flag("uncontrolled", options.uncontrolled, false);
    tag = tag.some_number("contPos", options.wait_at_m).some_number("visibility", options.visibility_m);
    tag = tag.some_number("speed", options.speed_mps).some_number("length", options.length_m);
    tag = tag.points("shape", &options.shape).flag("indirect", options.indirect, false);
    if let Some(set) = options.permissions {
        tag = if set == VehicleClasses::ALL { tag.with("allow", "all") } else { permissions(tag, set) };
    }
    for (name, set) in [("changeLeft", options.change_left), ("changeRight", options.change_right)] {
        tag = tag.some(name, set.map(class_list).as_deref());
    }
    tag
}

fn write_signal(text: &mut String, signal: &Signal) {
    for program in &signal.programs {
        let offset = program.offset_s.map_or("begin".to_owned(), |offset_s| offset_s.to_string());
        Tag::new(text, 1, "tlLogic")
            .with("id", &signal.id)
            .with("type", program.kind.name())
            .with("programID", &program.id)
            .with("offset", &offset)
            .open();
        for phase in &program.phases {
            let tag = Tag::new(text, 2, "phase").number("duration", phase.duration_s).with("state", &phase.state);
            tag.some_number("minDur", phase.min_s).some_number("maxDur", phase.max_s).pairs(&phase.other).close();
        }
        for (key, value) in &program.parameters {
            Tag::new(text, 2, "param").with("key", key).with("value", value).close();
        }
        text.push_str("    </tlLogic>\n");
    }
}
