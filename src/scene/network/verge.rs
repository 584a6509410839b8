//! Roadsides. On the ground, a verge: gravel, then grass that dips under the meadow. On a bridge, a parapet, and the side and underside of
//! the deck. In: the edge of the asphalt, the height of the ground. Out: ribbons.

use super::{
    layer::Layer,
    road_surfaces::RoadSurfaces,
    strips::{Column, Ground, Paver},
    verge_shape::VergeShape,
};
use glam::Vec3;

/// Overlap of the verge under the asphalt, metres.
const UNDER_M: f64 = 0.12;
/// Width of the verge's gravel, metres.
const GRAVEL_M: f64 = 0.42;
/// Height above the ground from which a road is on a bridge, metres. Lower ground is out of the verge's reach.
const BRIDGE_M: f32 = 1.5;
/// Depth of a deck's underside below the road, metres.
const DECK_M: f32 = 0.9;
const PARAPET_M: f32 = 0.9;
const PARAPET_WIDE_M: f64 = 0.25;
const CONCRETE: [f32; 3] = [0.30, 0.295, 0.28];

/// Function from metres along a line and metres to its left to a point in world axes.
pub(super) type SurfacePoint<'a> = &'a dyn Fn(f64, f64) -> Vec3;

/// Builder of verges, parapets and decks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roadside<'a> {
    shape: VergeShape,
    /// Paved surfaces of the network.
    pub surfaces: &'a RoadSurfaces,
}

impl<'a> Roadside<'a> {
    /// Returns the builder for a network's roads.
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
                // The parapet's inner face, top and outer face, down to the underside of the deck.
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
        // Decided at the middle of each interval between two rows.
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
