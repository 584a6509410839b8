//! Edges and lanes as data, as SUMO's net.xml has them. Metres, m/s, world axes.

use super::{CentreLine, EdgeId, JunctionId, LaneId, VehicleClasses, words::word_enum};
use glam::DVec3;
use std::ops::Range;

word_enum! {
    /// What an edge is for.
    EdgeKind {
        /// A street from a junction to a junction.
        Normal = "normal",
        /// The inside of a junction.
        Internal = "internal",
        /// A connection between parts of a network, not drawn.
        Connector = "connector",
        /// People cross a street here; its line goes across.
        Crossing = "crossing",
        /// People walk here in any direction; the shape of its lane is an outline, not a line.
        WalkingArea = "walkingarea",
        /// Part of a roundabout, in networks of old.
        RoundaboutEdge = "roundabout_edge",
    }
}

impl EdgeKind {
    /// True of a street between junctions.
    pub fn is_street(self) -> bool {
        matches!(self, Self::Normal | Self::Connector | Self::RoundaboutEdge)
    }
}

word_enum! {
    /// Where an edge's lanes lie beside its line.
    LaneSpread {
        /// On the right of it (of left-hand traffic: on the left): the line is between both directions.
        Right = "right",
        /// On both sides of it: a road of one direction.
        Center = "center",
        /// On both sides of the line of both directions together.
        RoadCenter = "roadCenter",
    }
}

/// Lanes side by side in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// SUMO's id.
    pub id: String,
    /// What it is for.
    pub kind: EdgeKind,
    /// Where a street begins; `None` inside junctions.
    pub from: Option<JunctionId>,
    /// Where a street ends; `None` inside junctions.
    pub to: Option<JunctionId>,
    /// The junction that an inside, a crossing or a walking area belongs to.
    pub junction: Option<JunctionId>,
    /// Places of its lanes in the network's list.
    pub(super) lanes: Range<u32>,
    /// The street's name.
    pub name: Option<String>,
    /// SUMO's type of road, such as `highway.residential`.
    pub road_type: Option<String>,
    /// Which of two edges at a junction has priority: the higher.
    pub priority: Option<i32>,
    /// Where its lanes lie beside its line.
    pub spread: LaneSpread,
    /// Its line, where the file has one; empty otherwise.
    pub shape: Vec<DVec3>,
    /// Its stated length, metres, where it differs from the line's.
    pub length_m: Option<f64>,
    /// Kilometrage of its start, metres.
    pub distance_m: Option<f64>,
    /// The same track the other way.
    pub bidi: Option<EdgeId>,
    /// The streets that a crossing crosses.
    pub crosses: Vec<EdgeId>,
}

impl Edge {
    /// Its lanes in SUMO's order: the outermost first, which is the right-most, or with left-hand traffic the left-most.
    pub fn lanes(&self) -> impl DoubleEndedIterator<Item = LaneId> + ExactSizeIterator {
        (self.lanes.start as usize..self.lanes.end as usize).map(LaneId::from_index)
    }
}

/// A lane: a centre line with width, limit and permissions.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    /// SUMO's id: the edge's, an underscore and the index.
    pub id: String,
    /// Its edge.
    pub edge: EdgeId,
    /// Declared length, metres: positions of vehicles count in it. May differ from the length of the line.
    pub length_m: f64,
    /// Speed limit, m/s.
    pub speed_limit_mps: f64,
    /// Width, metres; 3.2 where the file has none.
    pub width_m: f64,
    /// Its centre line.
    pub line: CentreLine,
    /// The shape as the file has it, where the line leaves points of it out.
    pub(super) drawn: Option<Box<[DVec3]>>,
    /// Who may drive here.
    pub permissions: VehicleClasses,
    /// Who may change from here to the left.
    pub change_left: VehicleClasses,
    /// Who may change from here to the right.
    pub change_right: VehicleClasses,
    /// The lane of the opposite direction that may be used to overtake.
    pub opposite: Option<LaneId>,
    /// How far before the end of the line vehicles stop, metres.
    pub end_offset_m: f64,
    /// True of a lane to speed up on before a merge.
    pub acceleration: bool,
    /// True if a person drew the shape.
    pub custom_shape: bool,
    /// SUMO's type of lane.
    pub lane_type: Option<String>,
    /// Outline of a crossing that is no rectangle; empty otherwise.
    pub outline: Vec<DVec3>,
    /// Grip of the surface as a share of a dry road's, where the file has it.
    pub friction: Option<f64>,
}

impl Lane {
    /// The shape as the file has it: at least two points, some of which may be the same.
    pub fn shape(&self) -> &[DVec3] {
        self.drawn.as_deref().unwrap_or(self.line.points())
    }

    /// Half its width, metres.
    pub fn half_width_m(&self) -> f64 {
        self.width_m / 2.0
    }

    /// True if passenger cars may drive here.
    pub fn admits_cars(&self) -> bool {
        self.permissions.contains(VehicleClasses::PASSENGER)
    }
    /// True where people walk and nobody drives.
    pub fn is_footway(&self) -> bool {
        self.permissions.intersects(VehicleClasses::PEDESTRIAN)
            && !self.permissions.intersects(VehicleClasses::ROAD_MOTOR)
            && !self.permissions.intersects(VehicleClasses::BICYCLE)
            && !self.permissions.intersects(VehicleClasses::RAIL)
    }

    /// True of a track on which nothing but trains and trams runs.
    pub fn is_railway(&self) -> bool {
        self.permissions.intersects(VehicleClasses::RAIL)
            && !self.permissions.intersects(VehicleClasses::ROAD_MOTOR)
            && !self.permissions.intersects(VehicleClasses::BICYCLE)
    }
}
