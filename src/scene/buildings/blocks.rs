//! Models of buildings with any outline. In: a block. Out: a mesh in a frame at its first corner. Metres.

use super::{
    facade::Facade,
    houses::{BRICK, CELLAR_M, PLASTER, PLINTH_M},
    shell::Shell,
};
use crate::{
    map::surroundings::BuildingUse,
    rng,
    roadside::{
        footprint_places::{Block, STOREY_M},
        house_plans::{GroundFloor, WindowKind, pick},
    },
    scene::{Mesh, network::triangulation},
};
use glam::{Vec2, Vec3};

/// Wall that has windows, metres.
const WINDOWED_M: f32 = 2.0;

/// Returns the mesh of a block in a frame at its first corner.
pub(super) fn model(block: &Block) -> Mesh {
    let mut random = rng::stream(block.seed, "block");
    let mut shell = Shell::default();
    let is_brick = random.uniform(0.0, 1.0) < 0.28;
    let wall = if is_brick { pick(&mut random, &BRICK) } else { pick(&mut random, &PLASTER) };
    let ground = match block.kind {
        BuildingUse::Shops => GroundFloor::Shops,
        BuildingUse::Outbuilding => GroundFloor::Blank,
        BuildingUse::House | BuildingUse::Flats => GroundFloor::Windows,
    };
    let windows = pick(&mut random, &[WindowKind::Casement, WindowKind::Broad, WindowKind::Tall]);
    let storeys = ((block.height_m / STOREY_M).round() as u32).clamp(1, 7);
    let seed = random.index(256) as u8;
    let facade = Facade { bay_m: 0.0, storeys, windows, is_brick, ground, seed };
    let base = block.outline[0];
    let outline: Vec<Vec2> = block.outline.iter().map(|corner| *corner - base).collect();
    let heights = [-CELLAR_M - PLINTH_M, block.height_m];
    for (k, from) in outline.iter().enumerate() {
        let to = outline[(k + 1) % outline.len()];
        let length_m = from.distance(to);
        let of_wall = if length_m < WINDOWED_M { facade.blank() } else { facade };
        shell.wall([*from, to], heights, wall, of_wall.along(length_m, 2.9));
    }
    for corners in triangulation::triangles(&outline) {
        let corners: [Vec3; 3] = corners.map(|k| outline[k].extend(block.height_m));
        shell.plain(&corners, [0.20, 0.195, 0.185]);
    }
    shell.mesh
}
