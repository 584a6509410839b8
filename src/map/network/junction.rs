//! Junctions and right of way as data. In: the junctions of a net.xml. Out: their area, their rule, and the right of way of each link. A
//! **link** is a connection or a crossing, by its index in the junction's rules.

use super::{ConnectionId, JunctionId, LaneId, named_enum::named_enum};
use glam::{DVec2, DVec3};

named_enum! {
    /// Rule of right of way at a junction.
    JunctionKind {
        /// Signals control the links.
        TrafficLight = "traffic_light",
        /// Signals; no rule applies while they are off.
        TrafficLightUnregulated = "traffic_light_unregulated",
        /// Signals, with right turns on red.
        TrafficLightRightOnRed = "traffic_light_right_on_red",
        /// Edges of higher priority go first.
        Priority = "priority",
        /// As [`JunctionKind::Priority`], and vehicles on other edges stop first.
        PriorityStop = "priority_stop",
        /// Vehicles from the right go first.
        RightBeforeLeft = "right_before_left",
        /// Vehicles from the left go first.
        LeftBeforeRight = "left_before_right",
        /// All vehicles stop, then go in the order of arrival.
        AllwayStop = "allway_stop",
        /// Lanes merge, one vehicle from each in turn.
        Zipper = "zipper",
        /// Railway junction with signals.
        RailSignal = "rail_signal",
        /// Level crossing of a railway and a road.
        RailCrossing = "rail_crossing",
        /// No rule of right of way.
        Unregulated = "unregulated",
        /// Waiting position inside another junction.
        Internal = "internal",
        /// End of a road.
        DeadEnd = "dead_end",
        /// Start and end of a district's traffic.
        District = "district",
        /// No type in the file.
        Unknown = "unknown",
    }
}

impl JunctionKind {
    /// Returns true if road signals control the junction.
    pub fn has_signals(self) -> bool {
        matches!(self, Self::TrafficLight | Self::TrafficLightUnregulated | Self::TrafficLightRightOnRed)
    }
}

/// Set of a junction's links, by index.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LinkSet(Box<[u64]>);

impl LinkSet {
    /// Parses SUMO's row of 0 and 1, whose last letter is link 0.
    pub(super) fn from_bits(bits: &str) -> Self {
        let mut words = vec![0u64; bits.len().div_ceil(64)];
        for (link, bit) in bits.bytes().rev().enumerate() {
            words[link / 64] |= u64::from(bit == b'1') << (link % 64);
        }
        Self(words.into())
    }

    /// Returns true if the link is in the set.
    pub fn contains(&self, link: usize) -> bool {
        self.0.get(link / 64).is_some_and(|word| word & (1 << (link % 64)) != 0)
    }

    /// Returns the links in the set, in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = usize> {
        (0..self.0.len() * 64).filter(|link| self.contains(*link))
    }
}

/// Right of way of one link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkRule {
    /// Links that this link yields to.
    pub yields_to: LinkSet,
    /// Links that this link crosses.
    pub crosses: LinkSet,
    /// True if vehicles may wait inside the junction.
    pub waits_inside: bool,
    /// Connection of this link; `None` if the file does not identify it.
    pub connection: Option<ConnectionId>,
}

/// Junction: an area where lanes meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Junction {
    /// SUMO's id, unique among junctions.
    pub id: String,
    /// Rule of right of way.
    pub kind: JunctionKind,
    /// Position of the junction as the file states it.
    pub position: DVec3,
    /// Outline of the area; may be empty, a point or a line.
    pub shape: Vec<DVec3>,
    /// True if the shape was set by hand.
    pub custom_shape: bool,
    /// Radius of the corners, metres, if the file states it.
    pub radius_m: Option<f64>,
    /// Name of the junction for people, if the file has one.
    pub name: Option<String>,
    /// Lanes that lead into the junction, in the order of the rules.
    pub incoming: Vec<LaneId>,
    /// Internal lanes, one per link; for an internal junction, the lanes whose traffic has priority.
    pub inside: Vec<LaneId>,
    /// Rules of right of way, one per link.
    pub links: Vec<LinkRule>,
    /// Further attributes of the file, as name and value.
    pub(super) other: Vec<(String, String)>,
    /// False if edges name the junction but the file has no such element, as in networks without junctions.
    pub declared: bool,
}

impl Junction {
    /// Returns true if a point of the ground plane lies in the area.
    pub fn covers(&self, point: DVec2) -> bool {
        is_inside(point, &self.shape)
    }
}

/// Returns true if a point lies within a polygon: a ray to the east crosses its outline an odd number of times.
pub(super) fn is_inside(point: DVec2, outline: &[DVec3]) -> bool {
    let mut inside = false;
    for k in 0..outline.len() {
        let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
        if (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}

/// Ring of edges whose traffic has priority.
#[derive(Clone, Debug, PartialEq)]
pub struct Roundabout {
    /// Junctions of the ring.
    pub junctions: Vec<JunctionId>,
    /// Edges of the ring, in the order of the file.
    pub edges: Vec<super::EdgeId>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_letter_of_a_row_is_the_first_link() {
        // 70 links, of which 0, 3 and 69 are in the set.
        let row = format!("1{}1001", "0".repeat(65));
        let set = LinkSet::from_bits(&row);
        assert_eq!(set.iter().collect::<Vec<_>>(), [0, 3, 69]);
        let again: String = (0..70).rev().map(|link| if set.contains(link) { '1' } else { '0' }).collect();
        assert_eq!(again, row);
        assert!(!set.contains(1) && !set.contains(1000));
    }

    #[test]
    fn a_point_inside_an_outline_is_found() {
        let outline: Vec<DVec3> =
            [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 7.0)).into();
        assert_eq!(
            [(1.0, 0.2), (3.9, 3.0), (2.0, 2.0), (5.0, 1.0)].map(|(x, y)| is_inside(DVec2::new(x, y), &outline)),
            [true, true, false, false]
        );
        assert!(!is_inside(DVec2::ZERO, &[]));
    }
}
