//! Areas of junctions, between the lanes that meet there. In: the network's outlines, and the heights of the adjoining lanes. Out: outlines
//! with the sides that lanes meet, metres.

use super::{outlines, road_surfaces::points};
use crate::map::network::{JunctionId, JunctionKind, LanePosition, Network};
use glam::{Vec2, Vec3};

/// Maximum distance along the lane between its end and the middle of a side that it meets, metres.
const MEETS_M: f32 = 0.6;

/// Distance outwards from a side at which a lane that meets it is looked for, metres.
const BEYOND_M: f32 = 0.3;

/// Area of a junction.
#[derive(Clone, Debug)]
pub struct JunctionArea {
    /// Corners in world axes, counter-clockwise, metres.
    pub outline: Vec<Vec3>,
    /// The junction in the network.
    pub junction: JunctionId,
    /// True for each side that a lane meets. Side `k` goes from corner `k` to the next.
    pub open: Vec<bool>,
}

/// End of a lane: its middle, the direction of the lane, half its width in metres.
type LaneEnd = (Vec3, Vec2, f32);

/// Returns the areas of all junctions whose outline encloses one.
pub fn areas(net: &Network) -> Vec<JunctionArea> {
    let mut ends: Vec<Vec<LaneEnd>> = vec![Vec::new(); net.junctions().len()];
    for id in net.lane_ids() {
        let (lane, edge) = (net.lane(id), net.edge_of(id));
        let end = |s_m: f64| {
            let pose = net.pose(LanePosition { lane: id, s_m, offset_m: 0.0 });
            (pose.position.as_vec3(), Vec2::from_angle(pose.yaw_rad as f32), lane.half_width_m() as f32)
        };
        for (junction, s_m) in [(edge.to, lane.length_m), (edge.from, 0.0)] {
            if let Some(junction) = junction {
                ends[junction.index()].push(end(s_m));
            }
        }
    }
    let of_roads = net.junctions().iter().zip(&ends).enumerate();
    let of_roads = of_roads.filter(|(_, (junction, _))| junction.kind != JunctionKind::Internal);
    let id = JunctionId::from_index;
    of_roads.filter_map(|(index, (junction, ends))| area(id(index), &points(&junction.shape), ends)).collect()
}

fn area(junction: JunctionId, shape: &[Vec3], ends: &[LaneEnd]) -> Option<JunctionArea> {
    let flat: Vec<Vec2> = shape.iter().map(|point| point.truncate()).collect();
    let round = outlines::cleaned(&flat);
    // SUMO has one height for the whole junction, but the adjoining lanes may end at others: weight those by inverse squared distance.
    let height_m = |point: Vec2| {
        let weights = ends.iter().map(|(end, ..)| (1.0 / (0.01 + end.truncate().distance_squared(point)), end.z));
        let (sum, all) = weights.fold((0.0, 0.0), |(sum, all), (weight, z_m)| (sum + weight * z_m, all + weight));
        (all > 0.0).then_some(sum / all)
    };
    let corner = |&k: &usize| flat[k].extend(height_m(flat[k]).unwrap_or(shape[k].z));
    let outline: Vec<Vec3> = round.iter().map(corner).collect();
    let leads_on = |k: usize| {
        let [from, to] = [outline[k], outline[(k + 1) % outline.len()]].map(Vec3::truncate);
        let middle = (from + to) / 2.0;
        // A short side along a lane's edge is near its end, too, but what is beyond it is no lane.
        let beyond = middle - (to - from).perp().normalize_or_zero() * BEYOND_M;
        ends.iter().any(|(end, along, half_m)| {
            let away_m = (middle - end.truncate()).dot(*along).abs();
            away_m < MEETS_M && along.perp_dot(beyond - end.truncate()).abs() < half_m + 0.1
        })
    };
    let open = (0..outline.len()).map(leads_on).collect();
    (!outline.is_empty()).then_some(JunctionArea { outline, junction, open })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;

    #[test]
    fn no_lane_meets_the_outer_sides_of_a_joint_between_two_edges() {
        // A ring is two edges, and the joints between them are less than a metre long.
        for name in ["two-lane-ring", "ring-250"] {
            let map = RoadMap::load(name).expect("a shipped map");
            let areas = areas(&map.network);
            for JunctionArea { outline, open, .. } in &areas {
                let closed = open.iter().filter(|open| !**open).count();
                assert!(closed >= 2, "{name}: {closed} of the sides of {outline:?}");
                assert!(open.iter().filter(|open| **open).count() >= 2, "{name}: {outline:?}");
            }
        }
    }
}
