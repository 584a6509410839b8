//! Edges and lanes as data, as in SUMO's net.xml. Metres, m/s, world axes.

use super::{CentreLine, EdgeId, JunctionId, LaneId, VehicleClasses, named_enum::named_enum};
use glam::DVec3;
use std::ops::Range;

named_enum! {
    /// Function of an edge.
    EdgeKind {
        /// Street from a junction to a junction.
        Normal = "normal",
        /// Inside of a junction.
        Internal = "internal",
        /// Connection between parts of a network, not drawn.
        Connector = "connector",
        /// Crossing for pedestrians; its line runs across the street.
        Crossing = "crossing",
        /// Area where pedestrians walk in any direction; the shape of its lane is an outline, not a line.
        WalkingArea = "walkingarea",
        /// Part of a roundabout, in old networks.
        RoundaboutEdge = "roundabout_edge",
    }
}

impl EdgeKind {
    /// Returns true for a street between junctions.
    pub fn is_street(self) -> bool {
        matches!(self, Self::Normal | Self::Connector | Self::RoundaboutEdge)
    }
}

named_enum! {
    /// Position of an edge's lanes relative to its line.
    LaneSpread {
        /// To the right of the line (with left-hand traffic, to the left): the line separates the two directions.
        Right = "right",
        /// On both sides of the line: a road with one direction.
        Center = "center",
        /// On both sides of the line, which both directions share.
        RoadCenter = "roadCenter",
    }
}

/// Edge: lanes side by side in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// SUMO's id, unique among edges.
    pub id: String,
    /// Function of the edge.
    pub kind: EdgeKind,
    /// Junction where a street begins; `None` inside junctions.
    pub from: Option<JunctionId>,
    /// Junction where a street ends; `None` inside junctions.
    pub to: Option<JunctionId>,
    /// Junction that an internal edge, crossing or walking area belongs to.
    pub junction: Option<JunctionId>,
    /// Range of the lanes in the network's list.
    pub(super) lanes: Range<u32>,
    /// Name of the street, if the file has one.
    pub name: Option<String>,
    /// SUMO's type of road, such as `highway.residential`.
    pub road_type: Option<String>,
    /// Priority at junctions; of two edges the higher value goes first.
    pub priority: Option<i32>,
    /// Position of the lanes relative to the line.
    pub spread: LaneSpread,
    /// Line of the edge; empty if the file has none.
    pub shape: Vec<DVec3>,
    /// Length as the file states it, metres; `None` if it states none.
    pub length_m: Option<f64>,
    /// Kilometrage of the start, metres.
    pub distance_m: Option<f64>,
    /// Edge of the opposite direction on the same track.
    pub bidi: Option<EdgeId>,
    /// Streets that a crossing crosses.
    pub crosses: Vec<EdgeId>,
}

impl Edge {
    /// Returns the lanes in SUMO's order, the outermost first: the right-most, or with left-hand traffic the left-most.
    pub fn lanes(&self) -> impl DoubleEndedIterator<Item = LaneId> + ExactSizeIterator {
        (self.lanes.start as usize..self.lanes.end as usize).map(LaneId::from_index)
    }
}

/// Lane: a centre line with width, speed limit and permissions.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    /// SUMO's id: the id of the edge, an underscore and the index.
    pub id: String,
    /// Edge that the lane belongs to.
    pub edge: EdgeId,
    /// Declared length, metres, in which positions of vehicles count. May differ from the length of the line.
    pub length_m: f64,
    /// Speed limit, m/s.
    pub speed_limit_mps: f64,
    /// Width, metres; 3.2 if the file states none.
    pub width_m: f64,
    /// Centre line in world axes.
    pub line: CentreLine,
    /// Shape of the file, if the centre line omits points of it.
    pub(super) drawn: Option<Box<[DVec3]>>,
    /// Vehicle classes that may drive here.
    pub permissions: VehicleClasses,
    /// Vehicle classes that may change from here to the left.
    pub change_left: VehicleClasses,
    /// Vehicle classes that may change from here to the right.
    pub change_right: VehicleClasses,
    /// Lane of the opposite direction that may be used to overtake.
    pub opposite: Option<LaneId>,
    /// Distance of the stop line before the end of the line, metres.
    pub end_offset_m: f64,
    /// True for an acceleration lane before a merge.
    pub acceleration: bool,
    /// True if the shape was set by hand.
    pub custom_shape: bool,
    /// SUMO's type of the lane, if the file has one.
    pub lane_type: Option<String>,
    /// Outline of a crossing that is not a rectangle; empty otherwise.
    pub outline: Vec<DVec3>,
    /// Friction of the surface as a share of a dry road's, if the file states it.
    pub friction: Option<f64>,
}

impl Lane {
    /// Returns the shape of the file: at least two points, some of which may coincide.
    pub fn shape(&self) -> &[DVec3] {
        self.drawn.as_deref().unwrap_or(self.line.points())
    }

    /// Returns half the width, metres.
    pub fn half_width_m(&self) -> f64 {
        self.width_m / 2.0
    }

    /// Returns true if passenger cars may drive here.
    pub fn admits_cars(&self) -> bool {
        self.permissions.contains(VehicleClasses::PASSENGER)
    }

    /// Returns true if bicycles may use the lane, and no motor vehicles.
    pub fn is_for_bicycles(&self) -> bool {
        self.permissions.contains(VehicleClasses::BICYCLE) && !self.permissions.intersects(VehicleClasses::ROAD_MOTOR)
    }

    /// Returns true if only pedestrians may use the lane: no road vehicles, bicycles or rail vehicles.
    pub fn is_footway(&self) -> bool {
        self.permissions.intersects(VehicleClasses::PEDESTRIAN)
            && !self.permissions.intersects(VehicleClasses::ROAD_MOTOR)
            && !self.permissions.intersects(VehicleClasses::BICYCLE)
            && !self.permissions.intersects(VehicleClasses::RAIL)
    }

    /// Returns true for a track that only rail vehicles use.
    pub fn is_railway(&self) -> bool {
        self.permissions.intersects(VehicleClasses::RAIL)
            && !self.permissions.intersects(VehicleClasses::ROAD_MOTOR)
            && !self.permissions.intersects(VehicleClasses::BICYCLE)
    }
}
