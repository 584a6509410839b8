//! Straight open lanes of any length. In: length, speed limit, lane width. Out: a map's folder. The lane begins at the origin and leads
//! east. Metres, m/s.

use super::{
    MapError,
    write::{RoadEdge, open_net_xml, write_folder},
};
use glam::dvec2;
use std::path::Path;

/// Allowed lengths, metres: room for two vehicles, and an hour at 100 km/h.
pub const LENGTH_M: std::ops::RangeInclusive<f64> = 100.0..=100_000.0;
/// Largest length of an edge, metres.
const EDGE_M: f64 = 1000.0;
/// Largest distance of two points of the centre line, metres.
const POINTS_M: f64 = 20.0;

/// Dimensions and speed limit of a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneShape {
    /// Length, metres, in [`LENGTH_M`].
    pub length_m: f64,
    /// Speed limit, m/s, 1 to 100.
    pub speed_limit_mps: f64,
    /// Lane width, metres, 2.5 to 10.
    pub width_m: f64,
}

impl LaneShape {
    /// Returns the text of the lane's `net.xml`; its edges are equally long.
    ///
    /// # Errors
    /// A number is out of range or not finite.
    pub fn net_xml(&self) -> Result<String, MapError> {
        let Self { length_m, speed_limit_mps, width_m } = *self;
        let rows = [
            ("length", length_m, *LENGTH_M.start(), *LENGTH_M.end(), "m"),
            ("speed limit", speed_limit_mps, 1.0, 100.0, "m/s"),
            ("lane width", width_m, 2.5, 10.0, "m"),
        ];
        for (what, value, low, high, unit) in rows {
            if !(low..=high).contains(&value) {
                let allowed = format!("{low} to {high} {unit}");
                return Err(MapError::Parameter { what, value: value.to_string(), allowed });
            }
        }
        let edges = (length_m / EDGE_M).ceil();
        let edge_m = length_m / edges;
        let points = (edge_m / POINTS_M).ceil() as u32;
        let edge = |k: u32| RoadEdge {
            length_m: edge_m,
            speed_limit_mps,
            width_m,
            shape: (0..=points)
                .map(|i| dvec2((f64::from(k) + f64::from(i) / f64::from(points)) * edge_m, 0.0))
                .collect(),
        };
        let road: Vec<RoadEdge> = (0..edges as u32).map(edge).collect();
        let comment = format!(
            "A lane made by codrive: length {length_m} m, speed limit {speed_limit_mps} m/s, width {width_m} m."
        );
        Ok(open_net_xml(&comment, &road))
    }
}

/// Writes a lane as a new map's `folder`.
///
/// # Errors
/// A number is out of range, or the folder exists or cannot be written.
pub fn write(folder: &Path, lane: &LaneShape, title: &str, description: &str) -> Result<(), MapError> {
    write_folder(folder, &lane.net_xml()?, title, description)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;

    #[test]
    fn a_lane_is_an_open_straight_route_of_its_length() {
        for length_m in [100.0, 1000.0, 2500.0, 10_000.0] {
            let lane = LaneShape { length_m, speed_limit_mps: 40.0, width_m: 3.6 };
            let map = RoadMap::read(Path::new("lane.net.xml"), &lane.net_xml().unwrap(), None).unwrap();
            assert!(!map.route.is_closed() && (map.route.length_m() - length_m).abs() < 1e-3, "{length_m}");
            for s_m in [0.0, 33.3, length_m / 2.0, length_m] {
                assert!(map.route.point_at(s_m).distance(dvec2(s_m, 0.0)) < 1e-3, "{s_m}");
            }
            assert_eq!((map.route.speed_limit_mps(50.0), map.route.width_m(50.0)), (40.0, 3.6));
        }
        let message = LaneShape { length_m: 50.0, speed_limit_mps: 40.0, width_m: 3.6 }.net_xml().unwrap_err();
        assert!(message.to_string().contains("length is 50; allowed: 100 to 100000 m"), "{message}");
    }

    #[test]
    fn the_shipped_lane_is_the_generators() {
        let lane = LaneShape { length_m: 10_000.0, speed_limit_mps: 40.0, width_m: 3.6 };
        let shipped = RoadMap::load("lane-10km").unwrap();
        assert!(std::fs::read_to_string(shipped.net_file).unwrap() == lane.net_xml().unwrap());
    }
}
