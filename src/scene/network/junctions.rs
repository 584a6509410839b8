//! Asphalt of junctions, between the lanes that meet there. In: their areas. Out: asphalt, with a shoulder and a verge along each side without
//! a lane, and up to the end of each lane that does not end along a side.

use super::{
    layer::{ASPHALT, LINE_HALF_M, Layer, SHOULDER, plain_asphalt},
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

/// Length from which a side without a lane has an edge line, metres: along the taper where lanes merge, but not around the corners of a crossing.
const LINED_M: f32 = 25.0;

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
    let is_in_town = verges.town.paves_corners(area.junction);
    let verges = verges.with_pavement(is_in_town);
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
        if !is_in_town && outline[ends[0]].distance(outline[ends[1]]) >= LINED_M {
            let [from, to] = rows.map(|row| place(row, -LINE_HALF_M));
            paver.painted_line(from, to, LINE_HALF_M as f32);
        }
        verges.pave(paver, &rows, &place, SHOULDER, false);
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        map::RoadMap,
        roadside::junction_areas,
        scene::{Material, StaticScene},
    };
    use glam::Vec3;

    #[test]
    fn edge_lines_run_on_along_the_taper_of_a_zipper() {
        let map = RoadMap::load("bottleneck").expect("a shipped map");
        let scene = StaticScene::with_trees(&map, 1, 0);
        let is_paint = |index: &u32| scene.road.vertices[*index as usize].material == Material::Marking as u32;
        let faces = scene.road.indices.as_chunks::<3>().0.iter().filter(|face| face.iter().all(is_paint));
        let paint: Vec<[Vec3; 3]> =
            faces.map(|face| face.map(|index| Vec3::from(scene.road.vertices[index as usize].position))).collect();
        // A line is 12 cm wide and begins and ends at the sides' corners.
        let has_paint = |at: Vec3| {
            paint.iter().any(|[a, b, c]| {
                [a, b, c].into_iter().any(|corner| corner.distance(at) < 0.3)
                    && a.distance(*b).max(b.distance(*c)) > 20.0
            })
        };
        let mut lined = 0;
        for area in junction_areas::areas(&map.network) {
            let n = area.outline.len();
            for side in (0..n).filter(|side| !area.open[*side]) {
                let ends = [area.outline[side], area.outline[(side + 1) % n]];
                if ends[0].distance(ends[1]) > 30.0 {
                    assert!(ends.into_iter().all(has_paint), "no line from {} to {}", ends[0], ends[1]);
                    lined += 1;
                }
            }
        }
        // The road narrows from both sides.
        assert!(lined >= 2, "{lined} sides");
    }
}
