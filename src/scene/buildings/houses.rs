//! Models of buildings: houses in gardens, houses of flats, rows with shops. In: a [`Plot`]. Out: a mesh in the building's own frame.
//! Metres; x to the right along the front as seen from the street, y inwards, z up from the ground floor.

use super::{
    facade::{Facade, GroundFloor, WindowKind},
    shell::{PitchedRoof, Shell, WallPlan},
};
use crate::{
    rng::{self, Stream},
    roadside::{
        footprint_places::STOREY_M,
        plots::{DRIVE_M, FENCE_BEYOND_M, Plot, PlotKind},
    },
    scene::{Mesh, land::noise::shade},
};
use glam::{Vec2, Vec3};

/// Depth of walls below the ground floor, metres: down into any ground.
pub(super) const CELLAR_M: f32 = 3.0;
/// Height of paths and drives over the ground, which is not quite level, metres.
pub(super) const DRIVE_UP_M: f32 = 0.03;
/// Height of the ground floor over the ground, metres.
pub(super) const PLINTH_M: f32 = 0.35;

/// Colours of plaster, linear albedo.
pub(super) const PLASTER: [[f32; 3]; 9] = [
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
pub(super) const BRICK: [[f32; 3]; 3] = [[0.27, 0.105, 0.070], [0.33, 0.155, 0.095], [0.40, 0.30, 0.20]];
/// Colours of roof tiles, linear albedo.
const TILES: [[f32; 3]; 5] =
    [[0.26, 0.085, 0.045], [0.22, 0.095, 0.060], [0.070, 0.066, 0.068], [0.15, 0.085, 0.060], [0.10, 0.098, 0.10]];
/// Colours of boards and frames, linear albedo.
const TRIM: [[f32; 3]; 4] = [[0.62, 0.61, 0.58], [0.16, 0.095, 0.055], [0.30, 0.30, 0.30], [0.55, 0.50, 0.42]];
/// Rise of a dormer's roof, metres.
const RISE_M: f32 = 0.6;
const STONE: [f32; 3] = [0.34, 0.33, 0.31];
const DARK_METAL: [f32; 3] = [0.06, 0.062, 0.066];
/// Colour of hedges, linear albedo.
const HEDGE: [f32; 3] = [0.040, 0.072, 0.022];

fn draw(random: &mut Stream, low: f32, high: f32) -> f32 {
    random.uniform(f64::from(low), f64::from(high)) as f32
}

pub(super) fn pick<T: Copy, const N: usize>(random: &mut Stream, of: &[T; N]) -> T {
    of[random.index(N)]
}

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
    fn of(plot: &Plot, storeys: u32, windows: WindowKind, ground: GroundFloor, random: &mut Stream) -> Self {
        let is_brick = random.uniform(0.0, 1.0) < 0.28;
        let wall = if is_brick { pick(random, &BRICK) } else { pick(random, &PLASTER) };
        let wall = shade(wall, draw(random, 0.9, 1.08));
        let seed = random.index(256) as u8;
        let half_m = plot.width_m / 2.0;
        Self {
            walls: WallPlan { low: Vec2::new(-half_m, 0.0), high: Vec2::new(half_m, plot.depth_m) },
            wall,
            facade: Facade { bay_m: 0.0, storeys, windows, is_brick, ground, seed },
            bay_m: match windows {
                WindowKind::Broad => 3.6,
                WindowKind::Tall => 2.3,
                _ => 2.8,
            } * draw(random, 0.92, 1.08),
            trim: pick(random, &TRIM),
            tiles: shade(pick(random, &TILES), draw(random, 0.85, 1.15)),
        }
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
    let mut random = rng::stream(plot.seed, "building");
    match plot.kind {
        PlotKind::House => house(plot, &mut random),
        PlotKind::Flats => flats(plot, &mut random),
        PlotKind::Shops => shops(plot, &mut random),
    }
}

fn house(plot: &Plot, random: &mut Stream) -> Mesh {
    let mut shell = Shell::default();
    let usual = if random.uniform(0.0, 1.0) < 0.45 { 1 } else { 2 };
    let storeys = plot.storeys.unwrap_or(usual);
    let windows = pick(random, &[WindowKind::Casement, WindowKind::Casement, WindowKind::Broad]);
    let look = Look::of(plot, storeys, windows, GroundFloor::Door, random);
    look.walls(&mut shell, plot.adjoins);
    let is_hipped = storeys == 2 && random.uniform(0.0, 1.0) < 0.3;
    let roof = PitchedRoof {
        eaves_m: look.facade.height_m(),
        slope: if is_hipped { draw(random, 0.45, 0.6) } else { draw(random, 0.75, 1.05) },
        overhang_m: [0.45, 0.3],
        is_along: if is_hipped { plot.width_m >= plot.depth_m } else { random.uniform(0.0, 1.0) < 0.6 },
        is_hipped,
        tiles: look.tiles,
        trim: look.trim,
    };
    shell.pitched(look.walls, roof, look.wall, look.facade);
    if !is_hipped {
        attic_windows(&mut shell, &look, &roof);
        if roof.is_along {
            dormers(&mut shell, &look, &roof, random.index(3));
        }
    }
    chimney(&mut shell, &look, &roof, random);
    door_step(&mut shell, &look, true);
    front_garden(&mut shell, plot, &look, random);
    shell.mesh
}

fn flats(plot: &Plot, random: &mut Stream) -> Mesh {
    let mut shell = Shell::default();
    let usual = 3 + random.index(2) as u32;
    let storeys = plot.storeys.unwrap_or(usual);
    let windows = pick(random, &[WindowKind::Broad, WindowKind::Casement]);
    let look = Look::of(plot, storeys, windows, GroundFloor::Door, random);
    look.walls(&mut shell, plot.adjoins);
    let (facade, along_m) = look.facade.along(plot.width_m, look.bay_m);
    if random.uniform(0.0, 1.0) < 0.55 {
        shell.flat(look.walls, facade.height_m(), look.wall, look.facade);
    } else {
        let roof = PitchedRoof {
            eaves_m: facade.height_m(),
            slope: draw(random, 0.5, 0.75),
            overhang_m: [0.5, 0.3],
            is_along: true,
            is_hipped: random.uniform(0.0, 1.0) < 0.5,
            tiles: look.tiles,
            trim: look.trim,
        };
        shell.pitched(look.walls, roof, look.wall, look.facade);
        chimney(&mut shell, &look, &roof, random);
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
    door_step(&mut shell, &look, true);
    front_garden(&mut shell, plot, &look, random);
    shell.mesh
}

fn shops(plot: &Plot, random: &mut Stream) -> Mesh {
    let mut shell = Shell::default();
    let usual = 2 + random.index(3) as u32;
    let storeys = plot.storeys.unwrap_or(usual);
    let windows = pick(random, &[WindowKind::Tall, WindowKind::Tall, WindowKind::Casement, WindowKind::Broad]);
    let ground = if random.uniform(0.0, 1.0) < 0.7 { GroundFloor::Shops } else { GroundFloor::Door };
    let look = Look::of(plot, storeys, windows, ground, random);
    look.walls(&mut shell, plot.adjoins);
    let eaves_m = look.facade.height_m();
    if random.uniform(0.0, 1.0) < 0.3 {
        shell.flat(look.walls, eaves_m, look.wall, look.facade);
    } else {
        let roof = PitchedRoof {
            eaves_m,
            slope: draw(random, 0.8, 1.1),
            overhang_m: [0.35, 0.0],
            is_along: random.uniform(0.0, 1.0) < 0.8,
            is_hipped: false,
            tiles: look.tiles,
            trim: look.trim,
        };
        shell.pitched(look.walls, roof, look.wall, look.facade);
        if roof.is_along {
            dormers(&mut shell, &look, &roof, 2 + random.index(3));
        } else {
            attic_windows(&mut shell, &look, &roof);
        }
        chimney(&mut shell, &look, &roof, random);
    }
    // A cornice under the eaves, and a ledge over the ground floor.
    let half_m = plot.width_m / 2.0;
    let first_m = eaves_m - (storeys as f32 - 1.0) * STOREY_M;
    for (top_m, high_m, out_m) in [(eaves_m - 0.06, 0.22, 0.14), (first_m + 0.06, 0.18, 0.10)] {
        let (low, high) = (Vec3::new(-half_m, -out_m, top_m - high_m), Vec3::new(half_m, 0.0, top_m));
        shell.plain_box(low, high, shade(look.trim, 0.95));
        shell.underside(low, high, shade(look.trim, 0.7));
    }
    if look.facade.ground == GroundFloor::Door {
        door_step(&mut shell, &look, false);
    }
    downpipe(&mut shell, &look);
    shell.mesh
}

/// Returns the facade of a wall with a single window.
fn one_window(facade: Facade) -> Facade {
    Facade { storeys: 1, windows: WindowKind::Small, ground: GroundFloor::Windows, ..facade }
}

/// Adds a window in the middle of each gable.
fn attic_windows(shell: &mut Shell, look: &Look, roof: &PitchedRoof) {
    let half_m = 0.8;
    let (low, high) = (roof.eaves_m + 0.1, roof.eaves_m + 2.6);
    if roof.ridge_m(look.walls) < high + 0.9 {
        return;
    }
    let middle = (look.walls.low + look.walls.high) / 2.0;
    let facade = one_window(look.facade).along(2.0 * half_m, 2.0 * half_m);
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
        let corner = |off: f32, u: f32, z: f32| ((at + along * off).extend(z), Vec2::new(u, z - low));
        let corners = [
            corner(-half_m, 0.0, low),
            corner(half_m, facade.1, low),
            corner(half_m, facade.1, high),
            corner(-half_m, 0.0, high),
        ];
        shell.polygon(&corners, look.wall, facade.0.material());
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

fn chimney(shell: &mut Shell, look: &Look, roof: &PitchedRoof, random: &mut Stream) {
    let middle = (look.walls.low + look.walls.high) / 2.0;
    let along = draw(random, -0.3, 0.3) * (look.walls.high - look.walls.low);
    let at = if roof.is_along { middle + Vec2::new(along.x, 0.9) } else { middle + Vec2::new(0.9, along.y) };
    let top_m = roof.ridge_m(look.walls) + 0.9;
    let half = Vec3::new(0.3, 0.3, 0.0);
    let colour = if look.facade.is_brick { look.wall } else { BRICK[0] };
    shell.plain_box(at.extend(roof.eaves_m) - half, at.extend(top_m) + half, colour);
    let half = Vec3::new(0.36, 0.36, 0.0);
    shell.plain_box(at.extend(top_m) - half, at.extend(top_m + 0.1) + half, STONE);
}

/// Adds the step before the door, in the front's second bay, and a canopy over it.
fn door_step(shell: &mut Shell, look: &Look, has_canopy: bool) {
    let x = door_m(look);
    shell.plain_box(Vec3::new(x - 0.8, -0.9, -PLINTH_M - 0.3), Vec3::new(x + 0.8, 0.0, -0.18), STONE);
    shell.plain_box(Vec3::new(x - 0.7, -0.45, -0.18), Vec3::new(x + 0.7, 0.0, 0.0), STONE);
    if has_canopy {
        let (low, high) = (Vec3::new(x - 0.9, -1.0, 2.36), Vec3::new(x + 0.9, 0.0, 2.46));
        shell.plain_box(low, high, DARK_METAL);
        shell.underside(low, high, DARK_METAL);
    }
}

/// Returns the position of the door along the front, metres.
fn door_m(look: &Look) -> f32 {
    let width_m = look.walls.high.x - look.walls.low.x;
    let (facade, along_m) = look.facade.along(width_m, look.bay_m);
    look.walls.low.x + 1.5 * facade.bay_m * width_m / along_m
}

fn downpipe(shell: &mut Shell, look: &Look) {
    let x = look.walls.high.x - 0.25;
    shell.plain_box(Vec3::new(x, -0.14, -PLINTH_M - 0.2), Vec3::new(x + 0.1, -0.04, look.facade.height_m()), [0.15; 3]);
}

/// Adds the path to the door, the drive, and a hedge, a wall or a fence along the pavement.
fn front_garden(shell: &mut Shell, plot: &Plot, look: &Look, random: &mut Stream) {
    let x = door_m(look);
    let (edge, foot) = (-plot.garden_m, -PLINTH_M - 0.35);
    shell.plain_box(
        Vec3::new(x - 0.65, edge, foot),
        Vec3::new(x + 0.65, -0.85, -PLINTH_M + DRIVE_UP_M),
        shade(STONE, 0.8),
    );
    if let Some(side) = plot.drive {
        let (near, far) = (plot.width_m / 2.0 + 0.4, plot.width_m / 2.0 + 3.2);
        let [left, right] = if side > 0.0 { [near, far] } else { [-far, -near] };
        shell.plain_box(
            Vec3::new(left, edge, foot),
            Vec3::new(right, DRIVE_M, -PLINTH_M + DRIVE_UP_M),
            shade(STONE, 0.7),
        );
    }
    let kind = random.index(4);
    if !plot.has_fence {
        return;
    }
    // The fence ends at a drive.
    let half_m = |side: f32| plot.width_m / 2.0 + if plot.drive == Some(side) { 0.2 } else { FENCE_BEYOND_M };
    for (left, right) in [(-half_m(-1.0), x - 0.9), (x + 0.9, half_m(1.0))] {
        if right - left < 0.6 {
            continue;
        }
        let span = |low_y: f32, high_y: f32, top: f32| {
            (Vec3::new(left, edge + low_y, foot), Vec3::new(right, edge + high_y, -PLINTH_M + top))
        };
        match kind {
            0 | 1 => {
                let (low, high) = span(0.25, 0.95, draw(random, 0.8, 1.3));
                shell.hedge(low, high, HEDGE);
            }
            2 => {
                let (low, high) = span(0.15, 0.37, 0.7);
                shell.plain_box(low, high, shade(look.wall, 0.8));
                let (low, high) = span(0.12, 0.40, 0.78);
                shell.plain_box(low + Vec3::Z * (0.7 + 0.35), high, STONE);
            }
            _ => fence(shell, [left, right], edge + 0.2, look.trim),
        }
    }
}

/// Adds a fence of boards between posts.
fn fence(shell: &mut Shell, [left, right]: [f32; 2], y: f32, colour: [f32; 3]) {
    let count = ((right - left) / 2.0).round().max(1.0);
    for k in 0..=count as usize {
        let x = left + (right - left - 0.09) * k as f32 / count;
        shell.plain_box(Vec3::new(x, y, -PLINTH_M - 0.3), Vec3::new(x + 0.09, y + 0.09, -PLINTH_M + 1.0), colour);
    }
    for z in [0.15, 0.45, 0.75] {
        let (low, high) = (Vec3::new(left, y - 0.03, z - PLINTH_M), Vec3::new(right, y, z + 0.17 - PLINTH_M));
        shell.plain_box(low, high, colour);
        shell.underside(low, high, colour);
    }
}
