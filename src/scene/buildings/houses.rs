//! Models of buildings: houses in gardens, houses of flats, rows with shops. In: a [`Plot`] and its plan. Out: a mesh in the building's own frame.
//! Metres; x to the right along the front as seen from the street, y inwards, z up from the ground floor.

use super::{
    facade::Facade,
    shell::{PitchedRoof, Shell, WallPlan},
};
use crate::{
    roadside::{
        footprint_places::STOREY_M,
        house_plans::{
            self, BOARD_M, BOARDS_M, BRICKS, FenceKind, FencePiece, GroundFloor, HousePlan, PLASTERS, POST_M, RoofPlan,
            TRIMS, WindowKind,
        },
        plots::{Plot, PlotKind},
    },
    scene::{Mesh, colours::shade},
};
use glam::{Vec2, Vec3};

/// Depth of walls below the ground floor, metres: down into any ground.
pub(super) const CELLAR_M: f32 = 3.0;
/// Height of the ground floor over the ground, metres.
pub(super) const PLINTH_M: f32 = 0.35;

/// Colours of plaster, linear albedo.
pub(super) const PLASTER: [[f32; 3]; PLASTERS] = [
    [0.64, 0.60, 0.52],
    [0.68, 0.66, 0.62],
    [0.60, 0.50, 0.34],
    [0.56, 0.42, 0.30],
    [0.52, 0.53, 0.50],
    [0.62, 0.55, 0.45],
    [0.46, 0.50, 0.52],
    [0.55, 0.36, 0.28],
    [0.66, 0.60, 0.42],
];
/// Colours of brick, linear albedo.
pub(super) const BRICK: [[f32; 3]; BRICKS] = [[0.27, 0.105, 0.070], [0.33, 0.155, 0.095], [0.40, 0.30, 0.20]];
/// Colours of roof tiles, linear albedo.
const TILES: [[f32; 3]; house_plans::TILES] =
    [[0.26, 0.085, 0.045], [0.22, 0.095, 0.060], [0.070, 0.066, 0.068], [0.15, 0.085, 0.060], [0.10, 0.098, 0.10]];
/// Colours of boards and frames, linear albedo.
const TRIM: [[f32; 3]; TRIMS] = [[0.62, 0.61, 0.58], [0.16, 0.095, 0.055], [0.30, 0.30, 0.30], [0.55, 0.50, 0.42]];
/// Rise of a dormer's roof, metres.
const RISE_M: f32 = 0.6;
pub(super) const STONE: [f32; 3] = [0.34, 0.33, 0.31];
/// Distances of the sides of a garden wall's coping from the pavement, metres.
const COPING_M: [f32; 2] = [0.12, 0.40];
const DARK_METAL: [f32; 3] = [0.06, 0.062, 0.066];
/// Colour of hedges, linear albedo.
const HEDGE: [f32; 3] = [0.040, 0.072, 0.022];

/// Looks of a building.
struct Look {
    walls: WallPlan,
    wall: [f32; 3],
    facade: Facade,
    /// Wanted width of a bay, metres.
    bay_m: f32,
    trim: [f32; 3],
    tiles: [f32; 3],
}

impl Look {
    fn of(plot: &Plot, plan: &HousePlan) -> Self {
        let HousePlan { storeys, windows, is_brick, ground, bay_m, .. } = *plan;
        let (wall, light) = plan.wall;
        let (tiles, tiles_light) = plan.tiles;
        let half_m = plot.width_m / 2.0;
        Self {
            walls: WallPlan { low: Vec2::new(-half_m, 0.0), high: Vec2::new(half_m, plot.depth_m) },
            wall: shade(if is_brick { BRICK[wall] } else { PLASTER[wall] }, light),
            facade: Facade { bay_m: 0.0, storeys, windows, is_brick, ground, seed: plan.facade_seed },
            bay_m,
            trim: TRIM[plan.trim],
            tiles: shade(TILES[tiles], tiles_light),
        }
    }

    /// Returns the roof with these slopes and overhangs.
    fn roof(&self, plan: &RoofPlan, overhang_m: [f32; 2]) -> PitchedRoof {
        let RoofPlan { slope, is_along, is_hipped, .. } = *plan;
        let (eaves_m, tiles, trim) = (self.facade.height_m(), self.tiles, self.trim);
        PitchedRoof { eaves_m, slope, overhang_m, is_along, is_hipped, tiles, trim }
    }

    /// Adds the four walls: the front with its ground floor, sides without windows where another building adjoins.
    fn walls(&self, shell: &mut Shell, [left, right]: [bool; 2]) {
        let WallPlan { low, high } = self.walls;
        let corners = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
        let heights = [-CELLAR_M - PLINTH_M, self.facade.height_m()];
        for k in 0..4 {
            let ends = [corners[k], corners[(k + 1) % 4]];
            let plain = Facade { ground: GroundFloor::Windows, ..self.facade };
            let of_side = match k {
                0 => self.facade,
                1 if right => self.facade.blank(),
                3 if left => self.facade.blank(),
                1 | 3 => Facade { windows: WindowKind::Small, seed: plain.seed.wrapping_add(k as u8), ..plain },
                _ => Facade { seed: plain.seed.wrapping_add(k as u8), ..plain },
            };
            let bay_m = if k % 2 == 1 { self.bay_m * 1.35 } else { self.bay_m };
            shell.wall(ends, heights, self.wall, of_side.along(ends[0].distance(ends[1]), bay_m));
        }
    }
}

/// Returns the mesh of a plot's building.
pub(super) fn model(plot: &Plot) -> Mesh {
    let plan = HousePlan::of(plot);
    let look = Look::of(plot, &plan);
    let mut shell = Shell::default();
    look.walls(&mut shell, plot.adjoins);
    match plot.kind {
        PlotKind::House => house(&mut shell, &plan, &look),
        PlotKind::Flats => flats(&mut shell, plot, &plan, &look),
        PlotKind::Shops => shops(&mut shell, plot, &plan, &look),
    }
    let door_m = plan.door_m(plot);
    if look.facade.ground == GroundFloor::Door {
        door_step(&mut shell, door_m, plot.kind != PlotKind::Shops);
    }
    match plot.kind {
        PlotKind::House | PlotKind::Flats => front_garden(&mut shell, plot, &plan, &look),
        PlotKind::Shops => downpipe(&mut shell, &look),
    }
    shell.mesh
}

fn house(shell: &mut Shell, plan: &HousePlan, look: &Look) {
    let Some(of) = &plan.roof else { return };
    let roof = look.roof(of, [0.45, 0.3]);
    shell.pitched(look.walls, roof, look.wall, look.facade);
    if !roof.is_hipped {
        attic_windows(shell, look, &roof);
        dormers(shell, look, &roof, of.dormers);
    }
    chimney(shell, look, &roof, of.chimney);
}

fn flats(shell: &mut Shell, plot: &Plot, plan: &HousePlan, look: &Look) {
    let storeys = plan.storeys;
    let (facade, along_m) = look.facade.along(plot.width_m, look.bay_m);
    match &plan.roof {
        None => shell.flat(look.walls, facade.height_m(), look.wall, look.facade),
        Some(of) => {
            let roof = look.roof(of, [0.5, 0.3]);
            shell.pitched(look.walls, roof, look.wall, look.facade);
            chimney(shell, look, &roof, of.chimney);
        }
    }
    // Balconies in every other bay, above the ground floor.
    let (bay_m, bays) = (facade.bay_m * plot.width_m / along_m, (along_m / facade.bay_m).round() as usize);
    let rail = shade(look.trim, 0.8);
    for bay in (2..bays).step_by(2) {
        for storey in 1..storeys {
            let x = -plot.width_m / 2.0 + (bay as f32 + 0.5) * bay_m;
            let z = storey as f32 * STOREY_M;
            let half_m = (bay_m / 2.0 - 0.15).min(1.5);
            shell.plain_box(Vec3::new(x - half_m, -1.2, z - 0.16), Vec3::new(x + half_m, 0.0, z), STONE);
            shell.underside(Vec3::new(x - half_m, -1.2, z - 0.16), Vec3::new(x + half_m, 0.0, z), STONE);
            let bars = [
                (-half_m, half_m, -1.2, -1.16),
                (-half_m, -half_m + 0.04, -1.16, 0.0),
                (half_m - 0.04, half_m, -1.16, 0.0),
            ];
            for (left, right, outer, inner) in bars {
                shell.plain_box(Vec3::new(x + left, outer, z), Vec3::new(x + right, inner, z + 0.95), rail);
            }
        }
    }
}

fn shops(shell: &mut Shell, plot: &Plot, plan: &HousePlan, look: &Look) {
    let eaves_m = look.facade.height_m();
    match &plan.roof {
        None => shell.flat(look.walls, eaves_m, look.wall, look.facade),
        Some(of) => {
            let roof = look.roof(of, [0.35, 0.0]);
            shell.pitched(look.walls, roof, look.wall, look.facade);
            if roof.is_along {
                dormers(shell, look, &roof, of.dormers);
            } else {
                attic_windows(shell, look, &roof);
            }
            chimney(shell, look, &roof, of.chimney);
        }
    }
    // A cornice under the eaves, and a ledge over the ground floor.
    let half_m = plot.width_m / 2.0;
    let first_m = eaves_m - (plan.storeys as f32 - 1.0) * STOREY_M;
    for (top_m, high_m, out_m) in [(eaves_m - 0.06, 0.22, 0.14), (first_m + 0.06, 0.18, 0.10)] {
        let (low, high) = (Vec3::new(-half_m, -out_m, top_m - high_m), Vec3::new(half_m, 0.0, top_m));
        shell.plain_box(low, high, shade(look.trim, 0.95));
        shell.underside(low, high, shade(look.trim, 0.7));
    }
}

/// Returns the facade of a wall with a single window.
fn one_window(facade: Facade) -> Facade {
    Facade { storeys: 1, windows: WindowKind::Small, ground: GroundFloor::Windows, ..facade }
}

/// Half the width of a small window's sill, and the height of the sill's lower and the window's upper edge over the floor, metres
/// (`WINDOWS` in `building.wgsl`).
pub(super) const ATTIC_WINDOW_M: [f32; 3] = [0.54, 0.78, 1.92];

/// Adds a window in the middle of each gable: no more than its opening and sill, as the wall around it would differ from the gable.
fn attic_windows(shell: &mut Shell, look: &Look, roof: &PitchedRoof) {
    let [half_m, sill_m, top_m] = ATTIC_WINDOW_M;
    let floor_m = roof.eaves_m + 0.1;
    let (low, high) = (floor_m + sill_m, floor_m + top_m);
    if roof.ridge_m(look.walls) < floor_m + 3.4 {
        return;
    }
    let middle = (look.walls.low + look.walls.high) / 2.0;
    let (facade, bay_m) = one_window(look.facade).along(1.6, 1.6);
    let u = [0.5 * bay_m - half_m, 0.5 * bay_m + half_m];
    for side in [-1.0, 1.0f32] {
        let (at, along) = if roof.is_along {
            (
                Vec2::new(if side > 0.0 { look.walls.high.x } else { look.walls.low.x } + 0.012 * side, middle.y),
                Vec2::Y * side,
            )
        } else {
            (
                Vec2::new(middle.x, if side > 0.0 { look.walls.high.y } else { look.walls.low.y } + 0.012 * side),
                Vec2::X * -side,
            )
        };
        // Its height counts from its own floor, as in the storeys below.
        let corner = |off: f32, u: f32, z: f32| ((at + along * off).extend(z), Vec2::new(u, z - floor_m));
        let corners = [
            corner(-half_m, u[0], low),
            corner(half_m, u[1], low),
            corner(half_m, u[1], high),
            corner(-half_m, u[0], high),
        ];
        shell.polygon(&corners, look.wall, facade.material());
    }
}

/// Adds dormers to both sides of a roof with its ridge along the street.
fn dormers(shell: &mut Shell, look: &Look, roof: &PitchedRoof, count: usize) {
    let WallPlan { low, high } = look.walls;
    let (half_m, floor_m) = (0.8, roof.eaves_m + 0.35);
    let top_m = floor_m + 2.1;
    // Where the roof is as high as the dormer's floor and top.
    let run = |z: f32| (z - roof.eaves_m) / roof.slope;
    if run(top_m + RISE_M) > (high.y - low.y) / 2.0 {
        return;
    }
    let facade = Facade { is_brick: false, ..one_window(look.facade) };
    let facade = facade.along(2.0 * half_m, 2.0 * half_m);
    for k in 0..count {
        let x = low.x + (high.x - low.x) * (k as f32 + 0.5) / count as f32;
        for side in [-1.0, 1.0f32] {
            let y = |run_m: f32| if side < 0.0 { low.y + run_m } else { high.y - run_m };
            let (front, back) = (y(run(floor_m)), y(run(top_m)));
            let along = -side;
            let (left, right) = (x - half_m * along, x + half_m * along);
            let corner = |x: f32, u: f32, z: f32| (Vec3::new(x, front, z), Vec2::new(u, z - floor_m - 0.1));
            let corners = [
                corner(left, 0.0, floor_m),
                corner(right, facade.1, floor_m),
                corner(right, facade.1, top_m),
                corner(left, 0.0, top_m),
            ];
            shell.polygon(&corners, look.wall, facade.0.material());
            let over = 0.18 * along;
            let out = side * 0.2;
            let at = Vec3::new;
            shell.plain(&[at(right, front, floor_m), at(right, back, top_m), at(right, front, top_m)], look.wall);
            shell.plain(&[at(left, front, top_m), at(left, back, top_m), at(left, front, floor_m)], look.wall);
            // A lean-to roof from the dormer's front up to the main roof.
            let ridge_m = top_m + RISE_M;
            let rear = y(run(ridge_m));
            let low_edge = [at(left - over, front + out, top_m), at(right + over, front + out, top_m)];
            shell.slope(low_edge, &[at(right + over, rear, ridge_m), at(left - over, rear, ridge_m)], look.tiles);
            let below = |at: Vec3| at - Vec3::Z * 0.12;
            shell.plain(&[below(low_edge[0]), below(low_edge[1]), low_edge[1], low_edge[0]], look.trim);
        }
    }
}

fn chimney(shell: &mut Shell, look: &Look, roof: &PitchedRoof, share: f32) {
    let middle = (look.walls.low + look.walls.high) / 2.0;
    let along = share * (look.walls.high - look.walls.low);
    let at = if roof.is_along { middle + Vec2::new(along.x, 0.9) } else { middle + Vec2::new(0.9, along.y) };
    let top_m = roof.ridge_m(look.walls) + 0.9;
    let half = Vec3::new(0.3, 0.3, 0.0);
    let colour = if look.facade.is_brick { look.wall } else { BRICK[0] };
    shell.plain_box(at.extend(roof.eaves_m) - half, at.extend(top_m) + half, colour);
    let half = Vec3::new(0.36, 0.36, 0.0);
    shell.plain_box(at.extend(top_m) - half, at.extend(top_m + 0.1) + half, STONE);
}

/// Adds the step before the door, in the front's second bay, and a canopy over it.
fn door_step(shell: &mut Shell, x: f32, has_canopy: bool) {
    shell.plain_box(Vec3::new(x - 0.8, -0.9, -PLINTH_M - 0.3), Vec3::new(x + 0.8, 0.0, -0.18), STONE);
    shell.plain_box(Vec3::new(x - 0.7, -0.45, -0.18), Vec3::new(x + 0.7, 0.0, 0.0), STONE);
    if has_canopy {
        let (low, high) = (Vec3::new(x - 0.9, -1.0, 2.36), Vec3::new(x + 0.9, 0.0, 2.46));
        shell.plain_box(low, high, DARK_METAL);
        shell.underside(low, high, DARK_METAL);
    }
}

fn downpipe(shell: &mut Shell, look: &Look) {
    let x = look.walls.high.x - 0.25;
    shell.plain_box(Vec3::new(x, -0.14, -PLINTH_M - 0.2), Vec3::new(x + 0.1, -0.04, look.facade.height_m()), [0.15; 3]);
}

/// Adds a hedge, a wall or a fence along the pavement.
fn front_garden(shell: &mut Shell, plot: &Plot, plan: &HousePlan, look: &Look) {
    let (edge, foot) = (-plot.garden_m, -PLINTH_M - 0.35);
    for &FencePiece { kind, left_m, right_m } in &plan.fence {
        let span = |[low_y, high_y]: [f32; 2], top: f32| {
            (Vec3::new(left_m, edge + low_y, foot), Vec3::new(right_m, edge + high_y, -PLINTH_M + top))
        };
        match kind {
            FenceKind::Hedge(height_m) => {
                let (low, high) = span(kind.sides_m(), height_m);
                shell.hedge(low, high, HEDGE);
            }
            FenceKind::GardenWall => {
                let (low, high) = span(kind.sides_m(), 0.7);
                shell.plain_box(low, high, shade(look.wall, 0.8));
                let (low, high) = span(COPING_M, 0.78);
                shell.plain_box(low + Vec3::Z * (0.7 + 0.35), high, STONE);
            }
            FenceKind::Boards => fence(shell, [left_m, right_m], edge + BOARDS_M, look.trim),
        }
    }
}

/// Adds a fence of boards between posts.
fn fence(shell: &mut Shell, [left, right]: [f32; 2], y: f32, colour: [f32; 3]) {
    let count = ((right - left) / 2.0).round().max(1.0);
    for k in 0..=count as usize {
        let x = left + (right - left - POST_M) * k as f32 / count;
        shell.plain_box(Vec3::new(x, y, -PLINTH_M - 0.3), Vec3::new(x + POST_M, y + POST_M, -PLINTH_M + 1.0), colour);
    }
    for z in [0.15, 0.45, 0.75] {
        let (low, high) = (Vec3::new(left, y - BOARD_M, z - PLINTH_M), Vec3::new(right, y, z + 0.17 - PLINTH_M));
        shell.plain_box(low, high, colour);
        shell.underside(low, high, colour);
    }
}
