//! The verge beside asphalt: gravel, then grass that dips under the meadow. In: where the asphalt ends. Out: columns of ribbons.

use super::{
    Layer,
    road_surfaces::RoadSurfaces,
    strips::{Column, Ground, Paver},
};
use glam::Vec3;

/// How far the verge begins under the asphalt, metres.
const UNDER_M: f64 = 0.12;
/// Width of its gravel, metres.
const GRAVEL_M: f64 = 0.42;

/// Width and depth of a verge.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct VergeShape {
    width_m: f64,
    foot_m: f32,
    /// Height of the meadow beside roads over them, metres.
    pub meadow_m: f32,
}

impl VergeShape {
    /// On level ground as beside a closed route. Where roads rise, the land follows them in cells of some metres: it lies lower, so that
    /// none of it comes through the asphalt, and the verge reaches down to it.
    pub fn of(surfaces: &RoadSurfaces) -> Self {
        if surfaces.level_m().is_some() {
            Self { width_m: 1.7, foot_m: -0.14, meadow_m: crate::scene::land::BESIDE_ROAD_M }
        } else {
            Self { width_m: 2.6, foot_m: -1.0, meadow_m: -0.35 }
        }
    }

    /// Paves it beside a line: from `edge_m` outwards, on the left or the right.
    pub(super) fn pave(
        self,
        paver: &mut Paver,
        rows: &[f64],
        place: &dyn Fn(f64, f64) -> Vec3,
        edge_m: f64,
        left: bool,
    ) {
        let columns = [
            Column::grown(edge_m - UNDER_M, Layer::Verge.z_m(), -0.5),
            Column::grown(edge_m + GRAVEL_M, Layer::Verge.z_m() - 0.02, 0.3),
            Column::grown(edge_m + self.width_m, self.foot_m, 1.62),
        ];
        for pair in columns.windows(2) {
            let to_side =
                |column: Column| Column { offset_m: if left { column.offset_m } else { -column.offset_m }, ..column };
            let [inner, outer] = [pair[0], pair[1]].map(to_side);
            paver.ribbon(rows, place, if left { [inner, outer] } else { [outer, inner] }, Ground::Grown, None);
        }
    }
}
