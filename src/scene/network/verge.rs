//! What lies beside asphalt. On the ground the verge: gravel, then grass that dips under the meadow. On a bridge a parapet, and the deck's
//! side and underside. In: where the asphalt ends, how high the ground is. Out: ribbons.

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
/// A road that is so much higher than the ground is on a bridge, metres: the verge reaches down less far.
const BRIDGE_M: f32 = 1.5;
/// Thickness of a deck, height and thickness of a parapet, metres, and their concrete.
const DECK_M: f32 = 0.9;
const PARAPET_M: f32 = 0.9;
const PARAPET_WIDE_M: f64 = 0.25;
const CONCRETE: [f32; 3] = [0.30, 0.295, 0.28];

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
            Self { width_m: 2.4, foot_m: -0.8, meadow_m: -0.25 }
        }
    }
}

/// A line's places, by metres along and to the left.
pub(super) type SurfacePoint<'a> = &'a dyn Fn(f64, f64) -> Vec3;

/// What lies beside the roads of a network.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roadside<'a> {
    shape: VergeShape,
    /// What is paved.
    pub surfaces: &'a RoadSurfaces,
}

impl<'a> Roadside<'a> {
    /// The sides of these roads.
    pub fn new(surfaces: &'a RoadSurfaces) -> Self {
        Self { shape: VergeShape::of(surfaces), surfaces }
    }

    /// Beside a line: from `edge_m` outwards, on the left or the right.
    pub fn pave(&self, paver: &mut Paver, rows: &[f64], surface_point: SurfacePoint, edge_m: f64, left: bool) {
        for (rows, is_bridge) in self.runs(rows, surface_point) {
            let edge =
                |beyond_m: f64, z_m: f32| Column { z_m, ..Column::tarred(edge_m + beyond_m, Layer::Street, CONCRETE) };
            let wide = PARAPET_WIDE_M;
            let (columns, ground) = if is_bridge {
                // Up on the inside, over the top, and down on the outside to the underside of the deck.
                let top = [edge(0.0, PARAPET_M), edge(wide, PARAPET_M)];
                (vec![edge(0.0, -0.05), top[0], top[1], edge(wide, -DECK_M)], Ground::Even)
            } else {
                let gravel = Column::grown(edge_m + GRAVEL_M, Layer::Verge.z_m() - 0.02, 0.3);
                let foot = Column::grown(edge_m + self.shape.width_m, self.shape.foot_m, 1.62);
                (vec![Column::grown(edge_m - UNDER_M, Layer::Verge.z_m(), -0.5), gravel, foot], Ground::Grown)
            };
            for pair in columns.windows(2) {
                let [inner, outer] = [pair[0], pair[1]].map(|column| match left {
                    true => column,
                    false => Column { offset_m: -column.offset_m, ..column },
                });
                paver.ribbon(rows, surface_point, if left { [inner, outer] } else { [outer, inner] }, ground, None);
            }
        }
    }

    /// The underside of a lane on a bridge.
    pub fn pave_deck(&self, paver: &mut Paver, rows: &[f64], surface_point: SurfacePoint, half_m: f64) {
        for (rows, _) in self.runs(rows, surface_point).into_iter().filter(|(_, is_bridge)| *is_bridge) {
            let reach_m = half_m + 0.4 + PARAPET_WIDE_M;
            let column = |at: f64| Column { z_m: -DECK_M, ..Column::tarred(at, Layer::Street, CONCRETE) };
            // Seen from below, the left is on the right.
            paver.ribbon(rows, surface_point, [column(reach_m), column(-reach_m)], Ground::Even, None);
        }
    }

    /// Runs of rows on the ground and on bridges; each begins where the one before it ends.
    fn runs<'r>(&self, rows: &'r [f64], surface_point: SurfacePoint) -> Vec<(&'r [f64], bool)> {
        if self.surfaces.level_m().is_some() || rows.len() < 2 {
            return vec![(rows, false)];
        }
        // Of each stretch from a row to the next.
        let is_bridge = |k: usize| {
            let at = surface_point((rows[k] + rows[k + 1]) / 2.0, 0.0);
            self.surfaces.height_m(at.truncate()) < at.z - BRIDGE_M
        };
        let bridges: Vec<bool> = (0..rows.len() - 1).map(is_bridge).collect();
        let mut runs = Vec::new();
        let mut first = 0;
        for run in bridges.chunk_by(|a, b| a == b) {
            runs.push((&rows[first..=first + run.len()], run[0]));
            first += run.len();
        }
        runs
    }
}
