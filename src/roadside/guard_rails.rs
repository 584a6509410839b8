//! Guard rails on both sides of fast roads with several lanes a direction. In: a network, its paved surfaces. Out: their posts, metres. Places
//! are the project's own (`docs/references.md: roads`).

use super::road_surfaces::RoadSurfaces;
use crate::map::{
    SHOULDER_M,
    network::{EdgeId, EdgeKind, LaneId, LanePosition, Network, Side},
};
use glam::{DVec2, Vec3};

/// Speed limit above which a road has guard rails, m/s: 80 km/h.
const GUARDED_MPS: f64 = 22.5;
/// Distance of a rail from the asphalt, metres: behind reflector posts.
const BESIDE_M: f64 = 0.95;
/// Distance between posts, metres.
const EVERY_M: f64 = 4.0;
/// Least distance of a post from any asphalt, metres.
const FREE_M: f32 = 0.6;

/// Point of a rail at a post: the point of the road's height under it, the unit vectors along the road and towards it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RailPost {
    pub foot: Vec3,
    pub along: Vec3,
    pub to_road: Vec3,
}

/// Guard rail without a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardRail {
    pub posts: Vec<RailPost>,
    /// True for the first and the last post if the rail is led into the ground there.
    pub into_ground: [bool; 2],
}

/// Returns all guard rails of a network.
pub fn guard_rails(net: &Network, surfaces: &RoadSurfaces) -> Vec<GuardRail> {
    let mut rails = Vec::new();
    for lane in net.lane_ids().filter(|lane| is_guarded(net, *lane)) {
        for side in [Side::Right, Side::Left].into_iter().filter(|side| net.neighbour(lane, *side).is_none()) {
            let posts = beside(net, lane, side);
            let is_free =
                |post: &RailPost| surfaces.border_m(post.foot.truncate()) > FREE_M && !surfaces.is_on_bridge(post.foot);
            let last = posts.len() - 1;
            let mut start = 0;
            while start <= last {
                let length = posts[start..].iter().take_while(|post| is_free(post)).count();
                if length > 1 {
                    let end = start + length - 1;
                    rails.push(GuardRail { posts: posts[start..=end].to_vec(), into_ground: [start > 0, end < last] });
                }
                start += length + 1;
            }
        }
    }
    rails
}

/// Checks whether a lane belongs to a fast road with several lanes a direction; inside junctions, whether it leads on from one.
fn is_guarded(net: &Network, lane: LaneId) -> bool {
    let is_wide = |edge: EdgeId| net.edge(edge).lanes().filter(|lane| net.is_driven(*lane)).count() > 1;
    let of = net.lane(lane);
    let is_road = match net.edge(of.edge).kind {
        EdgeKind::Internal => net.predecessors(lane).iter().any(|before| is_wide(net.lane(*before).edge)),
        _ => net.is_driven(lane) && is_wide(of.edge),
    };
    is_road && of.admits_cars() && of.speed_limit_mps > GUARDED_MPS
}

/// Returns the places of posts beside a lane, the first and the last at its ends.
fn beside(net: &Network, lane: LaneId, side: Side) -> Vec<RailPost> {
    let of = net.lane(lane);
    let leftwards = if side == Side::Left { 1.0 } else { -1.0 };
    let offset_m = leftwards * (of.half_width_m() + SHOULDER_M + BESIDE_M);
    let count = (of.line.drawn_m() / EVERY_M).ceil().max(1.0);
    let post = |k: usize| {
        let at = net.pose(LanePosition { lane, s_m: of.length_m * k as f64 / count, offset_m });
        let ahead = DVec2::from_angle(at.yaw_rad);
        let to_road = (ahead.perp() * -leftwards).as_vec2().extend(0.0);
        RailPost { foot: at.position.as_vec3(), along: ahead.as_vec2().extend(0.0), to_road }
    };
    (0..=count as usize).map(post).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rails_line_a_motorway_and_leave_its_ramps_free() {
        let net = Network::load("motorway").expect("a shipped map");
        let surfaces = RoadSurfaces::of(&net);
        let rails = guard_rails(&net, &surfaces);
        for post in rails.iter().flat_map(|rail| &rail.posts) {
            let beside_m = surfaces.border_m(post.foot.truncate());
            assert!((FREE_M..1.5).contains(&beside_m), "{post:?} is {beside_m} m from the asphalt");
        }
        let spans = rails.iter().flat_map(|rail| rail.posts.windows(2));
        let length_m: f32 = spans.map(|pair| pair[0].foot.distance(pair[1].foot)).sum();
        let streets = net.edge_ids().filter(|edge| net.edge(*edge).kind.is_street());
        let wide = streets.filter_map(|edge| net.edge(edge).lanes().find(|lane| is_guarded(&net, *lane)));
        let both_sides_m: f64 = wide.map(|lane| 2.0 * net.lane(lane).line.drawn_m()).sum();
        let share = f64::from(length_m) / both_sides_m;
        assert!((0.9..1.02).contains(&share), "{length_m} m of rails for {both_sides_m} m");
    }

    #[test]
    fn towns_and_circuits_have_no_rails() {
        for name in ["town", "grid", "ring-250", "practice", "figure-eight"] {
            let net = Network::load(name).expect("a shipped map");
            assert!(guard_rails(&net, &RoadSurfaces::of(&net)).is_empty(), "{name}");
        }
    }
}
