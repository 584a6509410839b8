//! Asphalt of junctions, between the lanes that meet there. In: their areas. Out: asphalt, with a shoulder and a verge along each side without
//! a lane, and up to the end of each lane that does not end along a side.

use super::{
    layer::{ASPHALT, Layer, SHOULDER, plain_asphalt},
    strips::{Column, Ground, Paver},
    verge::VergePaver,
};
use crate::{
    roadside::{junction_areas::JunctionArea, outlines::contains},
    scene::colours::shade,
};
use glam::{Vec2, Vec3};

/// Maximum reach of a shoulder's corner, as a multiple of the shoulder's width.
const MOST_MITRE: f32 = 2.0;

/// Largest gap between the end of a lane's edge and the area that it leads to, metres: of a lane 5 m wide at an angle of 40 degrees.
const MOST_GAP_M: f32 = 4.0;
/// Overlap of what fills such a gap with the lane and the area, metres.
const OVERLAP_M: f32 = 0.3;

/// Paves the wedge between the end of a lane and the area of its junction: a lane ends square, but a side of the area may lie at an angle to it.
/// Without one the strip closes the step from the area to the higher lane, through which one would see the ground.
/// `edges` are the ends of the lane's right and left edge, `ahead` is the unit direction into the area.
pub(super) fn pave_up_to(area: &JunctionArea, edges: [Vec3; 2], ahead: Vec2, paver: &mut Paver) {
    let outline: Vec<Vec2> = area.outline.iter().map(|corner| corner.truncate()).collect();
    let n = outline.len();
    let gap_m = |from: Vec2| {
        if contains(&area.outline, from) {
            return 0.0;
        }
        let to_side = |k: usize| {
            let (side, start) = (outline[(k + 1) % n] - outline[k], outline[k] - from);
            let across = ahead.perp_dot(side);
            let (along_m, share) = (start.perp_dot(side) / across, start.perp_dot(ahead) / across);
            (across.abs() > 1e-6 && along_m > 0.0 && (0.0..=1.0).contains(&share)).then_some(along_m)
        };
        (0..n).filter_map(to_side).fold(f32::INFINITY, f32::min)
    };
    let gaps = edges.map(|edge| Some(gap_m(edge.truncate())).filter(|gap| *gap < MOST_GAP_M).unwrap_or_default());
    let [right, left] = edges;
    let at = |edge: Vec3, along_m: f32| edge + (ahead * along_m).extend(0.0);
    let corners =
        [at(right, -OVERLAP_M), at(right, gaps[0] + OVERLAP_M), at(left, gaps[1] + OVERLAP_M), at(left, -OVERLAP_M)];
    paver.area(&corners, Layer::Apron, plain_asphalt());
}

/// Paves an area, and the shoulder and the verge of each side without a lane.
pub(super) fn pave(area: &JunctionArea, paver: &mut Paver, verges: VergePaver) {
    let JunctionArea { outline, open, .. } = area;
    let verges = verges.with_pavement(verges.town.paves_corners(area.junction));
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
        verges.pave(paver, &rows, &place, SHOULDER, false);
    }
}
