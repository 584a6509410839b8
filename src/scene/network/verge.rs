//! Roadsides. On the ground, a verge: gravel, then grass that dips under the meadow; in towns a kerb and a pavement. On a bridge, a parapet,
//! and the side and underside of the deck. In: the edge of the asphalt, the height of the ground. Out: ribbons.

use super::{
    layer::{KERB, Layer, PAVING},
    strips::{Column, Ground, Paver},
};
use crate::roadside::{
    road_surfaces::RoadSurfaces,
    town::{PAVEMENT_FREE_M, PAVEMENT_M, Town},
    verge_shape::VergeShape,
};
use glam::Vec3;

/// Overlap of the verge under the asphalt, metres.
const UNDER_M: f64 = 0.12;
/// Width of the verge's gravel, metres.
const GRAVEL_M: f64 = 0.42;
/// Depth of a deck's underside below the road, metres.
const DECK_M: f32 = 0.9;
const PARAPET_M: f32 = 0.9;
const PARAPET_WIDE_M: f64 = 0.25;
/// Width of a kerb stone, metres.
const KERB_M: f64 = 0.15;
const CONCRETE: [f32; 3] = [0.30, 0.295, 0.28];

/// Function from metres along a line and metres to its left to a point in world axes.
pub(super) type SurfacePoint<'a> = &'a dyn Fn(f64, f64) -> Vec3;

/// Kind of a roadside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RoadsideKind {
    Verge,
    Pavement,
    Bridge,
}

/// Builder of verges, pavements, parapets and decks.
#[derive(Clone, Copy, Debug)]
pub(super) struct VergePaver<'a> {
    shape: VergeShape,
    /// Paved surfaces of the network.
    pub surfaces: &'a RoadSurfaces,
    /// Streets of the town.
    pub town: &'a Town,
    has_pavement: bool,
}

impl<'a> VergePaver<'a> {
    /// Returns the builder for a network's roads.
    pub fn new(surfaces: &'a RoadSurfaces, town: &'a Town) -> Self {
        Self { shape: VergeShape::of(surfaces), surfaces, town, has_pavement: false }
    }

    /// Returns the builder for a road with kerbs and pavements, or without.
    pub fn with_pavement(self, has_pavement: bool) -> Self {
        Self { has_pavement, ..self }
    }

    /// Beside a line: from `edge_m` outwards, on the left or the right.
    pub fn pave(&self, paver: &mut Paver, rows: &[f64], surface_point: SurfacePoint, edge_m: f64, left: bool) {
        let outer_m = edge_m + f64::from(PAVEMENT_M);
        for (rows, kind) in self.runs(rows, surface_point, if left { outer_m } else { -outer_m }) {
            let edge =
                |beyond_m: f64, z_m: f32| Column { z_m, ..Column::tarred(edge_m + beyond_m, Layer::Street, CONCRETE) };
            let wide = PARAPET_WIDE_M;
            let (columns, ground) = match kind {
                RoadsideKind::Bridge => {
                    // The parapet's inner face, top and outer face, down to the underside of the deck.
                    let top = [edge(0.0, PARAPET_M), edge(wide, PARAPET_M)];
                    (vec![edge(0.0, -0.05), top[0], top[1], edge(wide, -DECK_M)], Ground::Even)
                }
                RoadsideKind::Pavement => {
                    let stone = |beyond_m: f64, z_m: f32| Column { colour: KERB, ..edge(beyond_m, z_m) };
                    let slab = |beyond_m: f64, z_m: f32| Column { colour: PAVING, ..edge(beyond_m, z_m) };
                    let (top_m, outer_m) = (Layer::Pavement.z_m(), f64::from(PAVEMENT_M));
                    let kerb = [stone(0.0, Layer::Verge.z_m()), stone(0.0, top_m), stone(KERB_M, top_m)];
                    let slabs = [slab(KERB_M, top_m), slab(outer_m, top_m), slab(outer_m + 0.05, self.shape.foot_m)];
                    (kerb.into_iter().chain(slabs).collect(), Ground::Tarred)
                }
                RoadsideKind::Verge => {
                    let gravel = Column::grown(edge_m + GRAVEL_M, Layer::Verge.z_m() - 0.02, 0.3);
                    let foot = Column::grown(edge_m + self.shape.width_m, self.shape.foot_m, 1.62);
                    (vec![Column::grown(edge_m - UNDER_M, Layer::Verge.z_m(), -0.5), gravel, foot], Ground::Grown)
                }
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
        let runs = self.with_pavement(false).runs(rows, surface_point, 0.0);
        for (rows, _) in runs.into_iter().filter(|(_, kind)| *kind == RoadsideKind::Bridge) {
            let reach_m = half_m + 0.4 + PARAPET_WIDE_M;
            let column = |at: f64| Column { z_m: -DECK_M, ..Column::tarred(at, Layer::Street, CONCRETE) };
            // Seen from below, the left is on the right.
            paver.ribbon(rows, surface_point, [column(reach_m), column(-reach_m)], Ground::Even, None);
        }
    }

    /// Runs of rows with one kind of roadside; each begins where the one before it ends. `outer_m` is the offset of a pavement's outer edge.
    fn runs<'r>(&self, rows: &'r [f64], surface_point: SurfacePoint, outer_m: f64) -> Vec<(&'r [f64], RoadsideKind)> {
        let is_level = self.surfaces.level_m().is_some();
        if is_level && !self.has_pavement || rows.len() < 2 {
            return vec![(rows, RoadsideKind::Verge)];
        }
        // Decided at the middle of each interval between two rows.
        let kind = |k: usize| {
            let row = (rows[k] + rows[k + 1]) / 2.0;
            let at = surface_point(row, 0.0);
            if self.surfaces.is_on_bridge(at) {
                RoadsideKind::Bridge
            } else if self.has_pavement
                && self.surfaces.border_m(surface_point(row, outer_m).truncate()) > PAVEMENT_FREE_M
            {
                RoadsideKind::Pavement
            } else {
                RoadsideKind::Verge
            }
        };
        let kinds: Vec<RoadsideKind> = (0..rows.len() - 1).map(kind).collect();
        let mut runs = Vec::new();
        let mut first = 0;
        for run in kinds.chunk_by(|a, b| a == b) {
            runs.push((&rows[first..=first + run.len()], run[0]));
            first += run.len();
        }
        runs
    }
}
