//! Chains of lanes. In: lanes that follow each other, open or closed. Out: a [`Path`] with one measure along all of them. Declared
//! metres.

use super::{LaneId, LanePosition, Network};

/// Why lanes are no path.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PathError {
    /// There is none.
    #[error("a path has at least one lane")]
    Empty,
    /// Two that do not follow each other.
    #[error("lane \"{before}\" does not lead to lane \"{after}\"{known}")]
    Gap {
        /// SUMO's id of the first.
        before: String,
        /// SUMO's id of the second.
        after: String,
        /// Where the first does lead.
        known: String,
    },
}

/// Lanes that follow each other, insides of junctions included.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    lanes: Vec<LaneId>,
    starts_m: Vec<f64>,
    length_m: f64,
    closed: bool,
    /// Places in `lanes` in the order of the lanes' ids, for looking up.
    by_lane: Vec<u32>,
}

impl Path {
    /// Chains lanes, each of which leads to the next at once; a closed path leads from the last to the first.
    ///
    /// # Errors
    /// If there is none, or two do not follow each other; the message names them.
    pub fn new(net: &Network, lanes: Vec<LaneId>, closed: bool) -> Result<Self, PathError> {
        let Some((&first, &last)) = lanes.first().zip(lanes.last()) else { return Err(PathError::Empty) };
        let closing = closed.then_some((last, first));
        for (before, after) in lanes.windows(2).map(|pair| (pair[0], pair[1])).chain(closing) {
            if !net.successors(before).any(|next| next == after) {
                return Err(gap(net, before, after));
            }
        }
        let mut length_m = 0.0;
        let mut starts_m = Vec::with_capacity(lanes.len());
        for lane in &lanes {
            starts_m.push(length_m);
            length_m += net.lane(*lane).length_m;
        }
        let mut by_lane: Vec<u32> = (0..lanes.len() as u32).collect();
        by_lane.sort_by_key(|k| lanes[*k as usize]);
        Ok(Self { lanes, starts_m, length_m, closed, by_lane })
    }

    /// The path over lanes of streets: the insides of the junctions between them are put in.
    ///
    /// # Errors
    /// As [`Path::new`].
    pub fn through(net: &Network, streets: &[LaneId], closed: bool) -> Result<Self, PathError> {
        let mut lanes = Vec::new();
        for (k, &lane) in streets.iter().enumerate() {
            lanes.push(lane);
            let Some(&next) = streets.get(k + 1).or_else(|| streets.first().filter(|_| closed)) else { break };
            let mut at = lane;
            // netconvert makes two or three lanes inside a junction; a network that leads in circles there is not followed.
            for _ in 0..16 {
                let way = net.connections_from(at).iter().find(|connection| connection.to == next);
                at = way.ok_or_else(|| gap(net, lane, next))?.next();
                if at == next {
                    break;
                }
                lanes.push(at);
            }
        }
        Self::new(net, lanes, closed)
    }

    /// Its lanes in driving order.
    pub fn lanes(&self) -> &[LaneId] {
        &self.lanes
    }

    /// Its length, metres: the declared lengths together.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// True if its end is its start.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// A position brought into the path: one of a closed path is wrapped into `0..length_m`, one beyond the ends of an open path
    /// is none.
    pub fn within(&self, position_m: f64) -> Option<f64> {
        if (0.0..self.length_m).contains(&position_m) || (!self.closed && position_m == self.length_m) {
            return Some(position_m);
        }
        if !self.closed || !position_m.is_finite() {
            return None;
        }
        let wrapped = position_m.rem_euclid(self.length_m);
        Some(if wrapped < self.length_m { wrapped } else { 0.0 })
    }

    /// The place in a lane at a position of the path; `None` beyond the ends of an open one.
    pub fn lane_position(&self, position_m: f64, offset_m: f64) -> Option<LanePosition> {
        let position_m = self.within(position_m)?;
        let k = self.starts_m.partition_point(|start| *start <= position_m) - 1;
        Some(LanePosition { lane: self.lanes[k], s_m: position_m - self.starts_m[k], offset_m })
    }

    /// The position on the path of a place in a lane; `None` if the path does not go over that lane. A path that goes over it more
    /// than once is at the position nearest to `near_m`, the first of two that are as near.
    pub fn position_of(&self, at: LanePosition, near_m: f64) -> Option<f64> {
        let first = self.by_lane.partition_point(|k| self.lanes[*k as usize] < at.lane);
        let same = self.by_lane[first..].iter().map(|k| *k as usize).take_while(|k| self.lanes[*k] == at.lane);
        let positions = same.filter_map(|k| self.within(self.starts_m[k] + at.s_m));
        positions.min_by(|a, b| self.apart_m(*a, near_m).total_cmp(&self.apart_m(*b, near_m)))
    }

    /// Distance between two positions along the path, metres; on a closed path the shorter way.
    pub fn apart_m(&self, a_m: f64, b_m: f64) -> f64 {
        let straight_m = (a_m - b_m).abs();
        if !self.closed {
            return straight_m;
        }
        let round_m = straight_m.rem_euclid(self.length_m);
        round_m.min(self.length_m - round_m)
    }
}

fn gap(net: &Network, before: LaneId, after: LaneId) -> PathError {
    let next: Vec<&str> = net.successors(before).map(|lane| net.lane(lane).id.as_str()).collect();
    let known = match next.is_empty() {
        true => "; it is the end of a road".to_owned(),
        false => format!("; it leads to: {}", crate::map::listed(&next)),
    };
    PathError::Gap { before: net.lane(before).id.clone(), after: net.lane(after).id.clone(), known }
}
