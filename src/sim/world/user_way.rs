//! Way of a road user that events move: across the lanes, or along a line of points. In: an action and the distance of a tick. Out: the lateral place, or the
//! pose on the line. Metres, seconds.

use crate::{
    map::RoadMap,
    scenario::scripted_event::{ChangeShape, LaneChange, OffsetChange, Walk},
    space::{Pose, wrap_angle},
    time::TICK_S,
};
use glam::DVec2;

/// Duration of a change of lanes for which neither time nor distance is stated, s.
const USUAL_CHANGE_S: f64 = 5.0;
/// Way before and after a corner of a line within which the heading turns, m.
const CORNER_M: f64 = 1.0;

/// Control of the lateral place of a road user.
pub(super) enum UserWay {
    /// Place that stays as it is in its lane.
    Keeps,
    /// Shift across the lane, or into another one.
    Shifts(Shift),
    /// Way along a line of points.
    Walks(Line),
}

/// Shift from one offset of the lane to another.
pub(super) struct Shift {
    event: usize,
    from_m: f64,
    to_m: f64,
    /// Time, or distance along the lane.
    over: f64,
    passed: f64,
    is_by_distance: bool,
    shape: ChangeShape,
    /// True where the sideways part is taken from the distance along the road, and a vehicle that stands does not shift.
    is_lane_change: bool,
}

/// Line of points, each with its distance from the first.
pub(super) struct Line {
    event: usize,
    points: Vec<(f64, DVec2)>,
    done_m: f64,
}

impl UserWay {
    /// Begins a change of lanes, from this offset of the lane that it enters to its middle.
    pub fn change_lane(event: usize, change: &LaneChange, from_m: f64) -> Self {
        Self::Shifts(Shift {
            event,
            from_m,
            to_m: 0.0,
            over: change.in_m.or(change.in_s).unwrap_or(USUAL_CHANGE_S),
            passed: 0.0,
            is_by_distance: change.in_m.is_some(),
            shape: change.shape,
            is_lane_change: true,
        })
    }

    /// Begins a shift from this offset; without time or distance it is done at once.
    pub fn shift(event: usize, change: &OffsetChange, from_m: f64) -> Self {
        Self::Shifts(Shift {
            event,
            from_m,
            to_m: change.to_m,
            over: change.in_m.or(change.in_s).unwrap_or(0.0),
            passed: 0.0,
            is_by_distance: change.in_m.is_some(),
            shape: change.shape,
            is_lane_change: false,
        })
    }

    /// Begins a way along the line of points of an action.
    pub fn walk(event: usize, walk: &Walk, map: &RoadMap) -> Self {
        let mut points: Vec<(f64, DVec2)> = Vec::with_capacity(walk.points.len());
        for [s_m, offset_m] in &walk.points {
            let point = beside(map, *s_m, *offset_m);
            let done_m = points.last().map_or(0.0, |(done_m, last)| done_m + last.distance(point));
            points.push((done_m, point));
        }
        Self::Walks(Line { event, points, done_m: 0.0 })
    }

    /// Returns the number of the event whose action controls the lateral place.
    pub fn event(&self) -> Option<usize> {
        match self {
            Self::Keeps => None,
            Self::Shifts(shift) => Some(shift.event),
            Self::Walks(line) => Some(line.event),
        }
    }
}

impl Shift {
    /// Returns the whole way aside, m, positive to the left of the route.
    pub fn aside_m(&self) -> f64 {
        self.to_m - self.from_m
    }

    /// Takes the shift on by a tick in which this distance is moved. Returns the offset from the lane's middle, the part of the distance that is along the
    /// lane, and whether the shift is over.
    pub fn step(&mut self, moved_m: f64) -> (f64, f64, bool) {
        let before_m = self.offset_m();
        if moved_m > 0.0 || !self.is_lane_change {
            self.passed += if self.is_by_distance { self.along_m(moved_m) } else { TICK_S };
        }
        let slack = if self.is_by_distance { 0.0 } else { TICK_S / 2.0 };
        let is_over = self.passed + slack >= self.over;
        if is_over {
            self.passed = self.over;
        }
        let offset_m = self.offset_m();
        let aside_m = if self.is_lane_change { offset_m - before_m } else { 0.0 };
        (offset_m, (moved_m * moved_m - aside_m * aside_m).max(0.0).sqrt(), is_over)
    }

    fn offset_m(&self) -> f64 {
        let share = if self.over > 0.0 { self.passed / self.over } else { 1.0 };
        self.from_m + (self.to_m - self.from_m) * self.shape.done(share)
    }

    /// Returns the distance along the lane that a distance moved covers where the shift is now.
    fn along_m(&self, moved_m: f64) -> f64 {
        let (share, small) = (self.passed / self.over, 1e-4);
        let slope = (self.shape.done(share + small) - self.shape.done(share - small)) / (2.0 * small);
        moved_m / (1.0 + (slope * (self.to_m - self.from_m) / self.over).powi(2)).sqrt()
    }
}

impl Line {
    /// Checks whether the end of the line is reached.
    pub fn is_over(&self) -> bool {
        self.points.last().is_none_or(|(length_m, _)| self.done_m >= *length_m)
    }

    /// Moves on along the line. Returns the pose on it; beyond its end straight on.
    pub fn step(&mut self, moved_m: f64) -> Pose {
        self.done_m += moved_m;
        let last = self.points.len() - 2;
        let k = self.points.iter().rposition(|(at_m, _)| *at_m <= self.done_m).unwrap_or(0).min(last);
        let yaw_rad = |k: usize| (self.points[k + 1].1 - self.points[k].1).to_angle();
        let ((from_m, from), to_m, here_rad) = (self.points[k], self.points[k + 1].0, yaw_rad(k));
        let (after_m, before_m) = (self.done_m - from_m, to_m - self.done_m);
        let near_m = ((to_m - from_m) / 2.0).min(CORNER_M);
        // Half of the turn of a corner is before it, half after it.
        let turn_rad =
            |other: usize, corner_m: f64| wrap_angle(yaw_rad(other) - here_rad) / 2.0 * (1.0 - corner_m / near_m);
        let turned_rad = if after_m < near_m && k > 0 {
            turn_rad(k - 1, after_m)
        } else if before_m < near_m && k < last {
            turn_rad(k + 1, before_m)
        } else {
            0.0
        };
        Pose::new(from + DVec2::from_angle(here_rad) * after_m, here_rad + turned_rad)
    }
}

/// Returns the point beside the route at this offset to the left.
pub(super) fn beside(map: &RoadMap, s_m: f64, offset_m: f64) -> DVec2 {
    map.route.point_at(s_m) + DVec2::from_angle(map.route.yaw_at(s_m)).perp() * offset_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_lanes_takes_its_time_and_its_way_sideways() {
        let change: LaneChange = toml::from_str("vehicle = \"a\"\nto_the_left = 1\nin_s = 3").expect("an action");
        let UserWay::Shifts(mut shift) = UserWay::change_lane(0, &change, -3.5) else { panic!("a shift") };
        let (mut along_m, mut ticks, mut middle_m) = (0.0, 0, 0.0);
        loop {
            let (offset_m, along, is_over) = shift.step(0.3);
            (along_m, ticks) = (along_m + along, ticks + 1);
            middle_m = if ticks == 150 { offset_m } else { middle_m };
            if is_over {
                break;
            }
        }
        // Half of it in half of the time. The way of a cosine 3.5 m aside over about 90 m is longer by (pi 3.5)²/(16 · 90) = 0.084 m.
        assert!(ticks == 300 && (middle_m + 1.75).abs() < 1e-9, "{ticks} {middle_m}");
        assert!((90.0 - along_m - 0.084).abs() < 0.001, "{along_m}");
    }

    #[test]
    fn a_change_of_lanes_by_distance_ends_at_its_distance_at_any_speed() {
        let change: LaneChange =
            toml::from_str("vehicle = \"a\"\nto_the_left = 1\nin_m = 40\nshape = \"cubic\"").expect("an action");
        for moved_m in [0.05, 0.2] {
            let UserWay::Shifts(mut shift) = UserWay::change_lane(0, &change, -3.5) else { panic!("a shift") };
            let mut along_m = 0.0;
            while let (_, along, false) = shift.step(moved_m) {
                along_m += along;
            }
            assert!((along_m - 40.0).abs() < 2.0 * moved_m, "{along_m}");
            assert_eq!(shift.step(0.0).0, 0.0, "in the middle of its lane");
        }
    }

    #[test]
    fn a_vehicle_that_stands_does_not_change_lanes_but_shifts() {
        let change: LaneChange = toml::from_str("vehicle = \"a\"\nto_the_left = 1\nin_s = 3").expect("an action");
        let UserWay::Shifts(mut stands) = UserWay::change_lane(0, &change, -3.5) else { panic!("a shift") };
        assert_eq!((0..500).map(|_| stands.step(0.0)).last(), Some((-3.5, 0.0, false)));
        let offset: OffsetChange = toml::from_str("vehicle = \"a\"\nto_m = 1\nin_s = 2").expect("an action");
        let UserWay::Shifts(mut shifts) = UserWay::shift(0, &offset, 0.0) else { panic!("a shift") };
        assert_eq!((0..200).map(|_| shifts.step(0.0)).last(), Some((1.0, 0.0, true)));
    }

    #[test]
    fn a_line_is_walked_to_its_end_and_the_heading_turns_at_its_corner() {
        let points = [(0.0, DVec2::ZERO), (10.0, DVec2::new(10.0, 0.0)), (15.0, DVec2::new(10.0, 5.0))];
        let mut line = Line { event: 0, points: points.to_vec(), done_m: 0.0 };
        let at = [5.0, 4.5, 0.5, 2.0].map(|moved_m| line.step(moved_m));
        assert_eq!(at[0], Pose::new(DVec2::new(5.0, 0.0), 0.0));
        // Half a metre before the corner a quarter of the right angle is done, at the corner half of it.
        assert!((at[1].yaw_rad.to_degrees() - 22.5).abs() < 1e-9, "{:?}", at[1]);
        assert!((at[2].yaw_rad.to_degrees() - 45.0).abs() < 1e-9, "{:?}", at[2]);
        assert!((at[3].yaw_rad.to_degrees() - 90.0).abs() < 1e-9 && at[3].position.y == 2.0, "{:?}", at[3]);
        assert!(!line.is_over());
        line.step(3.0);
        assert!(line.is_over());
    }
}
