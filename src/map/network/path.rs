//! Chains of lanes. In: lanes that follow each other, open or closed. Out: a [`Path`] with one coordinate along all of them. Declared
//! metres.

use super::{LaneId, LanePosition, Network};

/// Error for lanes that do not make a path.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PathError {
    /// No lane was given.
    #[error("a path has at least one lane")]
    Empty,
    /// Two lanes that do not follow each other.
    #[error("lane \"{before}\" does not lead to lane \"{after}\"{known}")]
    Gap {
        /// SUMO's id of the first lane.
        before: String,
        /// SUMO's id of the second lane.
        after: String,
        /// Text for the message: the lanes that the first lane leads to.
        known: String,
    },
}

/// Lanes that follow each other, internal lanes included.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    lanes: Vec<LaneId>,
    starts_m: Vec<f64>,
    length_m: f64,
    closed: bool,
    /// Indices into `lanes` in the order of the lanes' ids, for lookup.
    by_lane: Vec<u32>,
}

impl Path {
    /// Chains lanes, each of which leads directly to the next; a closed path also leads from the last to the first.
    ///
    /// # Errors
    /// There is no lane, or two lanes do not follow each other; the message names them.
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

    /// Chains lanes of streets, and inserts the internal lanes of the junctions between them.
    ///
    /// # Errors
    /// As [`Path::new`].
    pub fn through(net: &Network, streets: &[LaneId], closed: bool) -> Result<Self, PathError> {
        let mut lanes = Vec::new();
        for (k, &lane) in streets.iter().enumerate() {
            lanes.push(lane);
            let Some(&next) = streets.get(k + 1).or_else(|| streets.first().filter(|_| closed)) else { break };
            let mut at = lane;
            // netconvert makes two or three lanes inside a junction; internal lanes that form a loop are not followed further.
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

    /// Returns the lanes in driving order.
    pub fn lanes(&self) -> &[LaneId] {
        &self.lanes
    }

    /// Returns the sum of the declared lane lengths, metres.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// Returns true if the path is closed.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Normalises a position: on a closed path it is wrapped into `0..length_m`; beyond the ends of an open path it is `None`.
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

    /// Returns the lane position at a position of the path; `None` beyond the ends of an open path.
    pub fn lane_position(&self, position_m: f64, offset_m: f64) -> Option<LanePosition> {
        let position_m = self.within(position_m)?;
        let k = self.starts_m.partition_point(|start| *start <= position_m) - 1;
        Some(LanePosition { lane: self.lanes[k], s_m: position_m - self.starts_m[k], offset_m })
    }

    /// Returns the position on the path of a lane position; `None` if the path does not use that lane. If the path uses the lane more
    /// than once, the position nearest to `near_m` is returned, the first of two equally near ones.
    pub fn position_of(&self, at: LanePosition, near_m: f64) -> Option<f64> {
        let first = self.by_lane.partition_point(|k| self.lanes[*k as usize] < at.lane);
        let same = self.by_lane[first..].iter().map(|k| *k as usize).take_while(|k| self.lanes[*k] == at.lane);
        let positions = same.filter_map(|k| self.within(self.starts_m[k] + at.s_m));
        positions.min_by(|a, b| self.apart_m(*a, near_m).total_cmp(&self.apart_m(*b, near_m)))
    }

    /// Returns the distance between two positions along the path, metres; on a closed path the shorter way round.
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
