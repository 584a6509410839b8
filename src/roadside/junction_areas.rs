//! Areas of junctions, between the lanes that meet there. In: the network's outlines, and the heights of the adjoining lanes. Out: outlines
//! with the sides that lanes meet, metres.

use super::{outlines, road_surfaces::points};
use crate::map::network::{JunctionId, JunctionKind, LanePosition, Network};
use glam::{Vec2, Vec3};

/// Maximum distance along the lane between its end and the middle of a side that it meets, metres.
const MEETS_M: f32 = 0.6;

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
        let middle = (outline[k] + outline[(k + 1) % outline.len()]).truncate() / 2.0;
        ends.iter().any(|(end, along, half_m)| {
            let off = middle - end.truncate();
            off.dot(*along).abs() < MEETS_M && along.perp_dot(off).abs() < half_m + 0.1
        })
    };
    let open = (0..outline.len()).map(leads_on).collect();
    (!outline.is_empty()).then_some(JunctionArea { outline, junction, open })
}
