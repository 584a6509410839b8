//! Asphalt of junctions, between the lanes that meet there. In: their areas. Out: asphalt, with a shoulder and a verge along each side without
//! a lane.

use super::{
    layer::{ASPHALT, Layer, SHOULDER, plain_asphalt},
    strips::{Column, Ground, Paver},
    verge::VergePaver,
};
use crate::{roadside::junction_areas::JunctionArea, scene::colours::shade};
use glam::Vec2;

/// Maximum reach of a shoulder's corner, as a multiple of the shoulder's width.
const MOST_MITRE: f32 = 2.0;

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
