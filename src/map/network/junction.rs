//! Junctions and right of way as data. In: what a net.xml says of each junction. Out: its area, its rules, and for each of its
//! links who yields to whom. A **link** is a connection, or a crossing, by its place in the junction's rules.

use super::{ConnectionId, JunctionId, LaneId, words::word_enum};
use glam::{DVec2, DVec3};

word_enum! {
    /// The rule at a junction.
    JunctionKind {
        /// Signals.
        TrafficLight = "traffic_light",
        /// Signals, and no rule while they are off.
        TrafficLightUnregulated = "traffic_light_unregulated",
        /// Signals, with turns to the right on red.
        TrafficLightRightOnRed = "traffic_light_right_on_red",
        /// The edge of higher priority goes first.
        Priority = "priority",
        /// As [`JunctionKind::Priority`], and the others stop.
        PriorityStop = "priority_stop",
        /// Who comes from the right goes first.
        RightBeforeLeft = "right_before_left",
        /// Who comes from the left goes first.
        LeftBeforeRight = "left_before_right",
        /// All stop; who came first goes first.
        AllwayStop = "allway_stop",
        /// Lanes merge one by one.
        Zipper = "zipper",
        /// A signal of a railway.
        RailSignal = "rail_signal",
        /// A level crossing.
        RailCrossing = "rail_crossing",
        /// No rule at all.
        Unregulated = "unregulated",
        /// A place inside a junction where vehicles wait.
        Internal = "internal",
        /// The end of the road.
        DeadEnd = "dead_end",
        /// Where traffic of a district begins and ends.
        District = "district",
        /// None is stated.
        Unknown = "unknown",
    }
}

impl JunctionKind {
    /// True where signals say who goes.
    pub fn has_signals(self) -> bool {
        matches!(self, Self::TrafficLight | Self::TrafficLightUnregulated | Self::TrafficLightRightOnRed)
    }
}

/// A set of a junction's links.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LinkSet(Box<[u64]>);

impl LinkSet {
    /// The set of SUMO's row of 0 and 1, whose last letter is link 0.
    pub(super) fn from_bits(bits: &str) -> Self {
        let mut words = vec![0u64; bits.len().div_ceil(64)];
        for (link, bit) in bits.bytes().rev().enumerate() {
            words[link / 64] |= u64::from(bit == b'1') << (link % 64);
        }
        Self(words.into())
    }

    /// True if the link is in the set.
    pub fn contains(&self, link: usize) -> bool {
        self.0.get(link / 64).is_some_and(|word| word & (1 << (link % 64)) != 0)
    }

    /// The links in the set, lowest first.
    pub fn iter(&self) -> impl Iterator<Item = usize> {
        (0..self.0.len() * 64).filter(|link| self.contains(*link))
    }
}

/// Right of way of one link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkRule {
    /// The links that it yields to.
    pub yields_to: LinkSet,
    /// The links whose way it crosses.
    pub crosses: LinkSet,
    /// True if vehicles may wait inside the junction.
    pub waits_inside: bool,
    /// The connection that this link is; `None` where the file does not tell.
    pub connection: Option<ConnectionId>,
}

/// An area where lanes meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Junction {
    /// SUMO's id.
    pub id: String,
    /// Its rule.
    pub kind: JunctionKind,
    /// Its middle, as the file has it.
    pub position: DVec3,
    /// Outline of its area; may be empty, a point or a line.
    pub shape: Vec<DVec3>,
    /// True if a person drew the shape.
    pub custom_shape: bool,
    /// Radius of its corners, metres, where the file has one.
    pub radius_m: Option<f64>,
    /// Its name.
    pub name: Option<String>,
    /// Lanes that lead into it, in the order of the rules.
    pub incoming: Vec<LaneId>,
    /// Lanes inside it, one a link; of an internal junction those whose traffic is waited for.
    pub inside: Vec<LaneId>,
    /// Right of way, one a link.
    pub links: Vec<LinkRule>,
    /// What else the file says of it, as words.
    pub(super) other: Vec<(String, String)>,
    /// False if edges name it and the file has no such element, as in networks without any junction.
    pub declared: bool,
}

impl Junction {
    /// True of a point of the ground plane in its area.
    pub fn covers(&self, point: DVec2) -> bool {
        is_inside(point, &self.shape)
    }
}

/// True of a point within a polygon: a ray to the east crosses its outline an odd number of times.
fn is_inside(point: DVec2, outline: &[DVec3]) -> bool {
    let mut inside = false;
    for k in 0..outline.len() {
        let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
        if (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}

/// A ring of edges whose traffic has priority.
#[derive(Clone, Debug, PartialEq)]
pub struct Roundabout {
    /// Its junctions.
    pub junctions: Vec<JunctionId>,
    /// Its edges, in the order of the file.
    pub edges: Vec<super::EdgeId>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_letter_of_a_row_is_the_first_link() {
        // 70 links, of which 0, 3 and 69 are in.
        let row = format!("1{}1001", "0".repeat(65));
        let set = LinkSet::from_bits(&row);
        assert_eq!(set.iter().collect::<Vec<_>>(), [0, 3, 69]);
        let again: String = (0..70).rev().map(|link| if set.contains(link) { '1' } else { '0' }).collect();
        assert_eq!(again, row);
        assert!(!set.contains(1) && !set.contains(1000));
    }

    #[test]
    fn a_point_is_inside_an_outline_that_goes_round_it() {
        let outline: Vec<DVec3> =
            [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 7.0)).into();
        assert_eq!(
            [(1.0, 0.2), (3.9, 3.0), (2.0, 2.0), (5.0, 1.0)].map(|(x, y)| is_inside(DVec2::new(x, y), &outline)),
            [true, true, false, false]
        );
        assert!(!is_inside(DVec2::ZERO, &[]));
    }
}
