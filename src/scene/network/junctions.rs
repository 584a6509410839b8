//! Areas of junctions, between the lanes that meet there. In: the network's outlines, and the heights of the adjoining lanes. Out: asphalt,
//! with a shoulder and a verge along each side without a lane.

use super::{
    layer::{ASPHALT, Layer, SHOULDER, plain_asphalt, points},
    strips::{Column, Ground, Paver},
    triangulation,
    verge::Roadside,
};
use crate::{
    map::network::{JunctionId, JunctionKind, LanePosition, Network},
    scene::land::noise::shade,
};
use glam::{Vec2, Vec3};

/// Maximum distance along the lane between its end and the middle of a side that it meets, metres.
const MEETS_M: f32 = 0.6;
/// Maximum reach of a shoulder's corner, as a multiple of the shoulder's width.
const MOST_MITRE: f32 = 2.0;

/// Area of a junction.
#[derive(Clone, Debug)]
pub(super) struct JunctionArea {
    /// Corners in world axes, counter-clockwise, metres.
    pub outline: Vec<Vec3>,
    /// The junction in the network.
    junction: JunctionId,
    /// True for each side that a lane meets. Side `k` goes from corner `k` to the next.
    open: Vec<bool>,
}

/// End of a lane: its middle, the direction of the lane, half its width in metres.
type LaneEnd = (Vec3, Vec2, f32);

/// Returns the areas of all junctions whose outline encloses one.
pub(super) fn areas(net: &Network) -> Vec<JunctionArea> {
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
    let round = triangulation::cleaned(&flat);
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

/// Paves an area, and the shoulder and the verge of each side without a lane.
pub(super) fn pave(area: &JunctionArea, paver: &mut Paver, roadside: Roadside) {
    let JunctionArea { outline, open, .. } = area;
    let roadside = roadside.with_pavement(roadside.town.paves_corners(area.junction));
    paver.area(outline, Layer::Junction, plain_asphalt());
    let n = outline.len();
    let outwards = |k: usize| {
        let along = (outline[(k + 1) % n] - outline[k]).truncate().normalize_or_zero();
        Vec2::new(along.y, -along.x)
    };
    // Offset of the shoulder's outer edge at a corner, in shoulder widths: normal to the closed side, or along the bisector of two.
    let way_out = |k: usize| {
        let (before, after) = ((k + n - 1) % n, k);
        let mut ways = [before, after].into_iter().filter(|side| !open[*side]).map(outwards);
        match (ways.next(), ways.next()) {
            (Some(a), Some(b)) => {
                let middle = (a + b).normalize_or(a);
                middle * (1.0 / middle.dot(a).max(1.0 / MOST_MITRE))
            }
            (Some(only), None) => only,
            _ => Vec2::ZERO,
        }
    };
    for side in (0..n).filter(|side| !open[*side]) {
        let ends = [side, (side + 1) % n];
        let ways = ends.map(way_out);
        let rows = [0.0, 1.0];
        // The outline is counter-clockwise, so its outside is on the right.
        let place = |row: f64, offset_m: f64| {
            let k = usize::from(row > 0.5);
            outline[ends[k]] + (ways[k] * -offset_m as f32).extend(0.0)
        };
        let tone = |share: f32| shade(ASPHALT, share);
        let columns =
            [(-SHOULDER, 1.22), (0.05, 1.04)].map(|(at, share)| Column::tarred(at, Layer::Apron, tone(share)));
        paver.ribbon(&rows, &place, columns, Ground::Tarred, None);
        roadside.pave(paver, &rows, &place, SHOULDER, false);
    }
}
