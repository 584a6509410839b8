//! Plans of the buildings on plots: storeys, windows, roof, and the fence along the pavement. In: a [`Plot`]. Out: a [`HousePlan`], from which the
//! picture is drawn. Metres; x to the right along the front as seen from the street, y inwards.

use super::plots::{FENCE_BEYOND_M, Plot, PlotKind};
use crate::rng::{self, Stream};

/// Numbers of colours of plaster, brick, roof tiles, and of boards and frames.
pub const PLASTERS: usize = 9;
pub const BRICKS: usize = 3;
pub const TILES: usize = 5;
pub const TRIMS: usize = 4;
/// Step of the width of a bay, metres.
pub const BAY_STEP_M: f32 = 0.1;
/// Distance of a fence's boards from the pavement, thickness of boards and of posts behind them, metres.
pub const BOARDS_M: f32 = 0.2;
pub const BOARD_M: f32 = 0.03;
pub const POST_M: f32 = 0.09;
/// Distances of the sides of a hedge and of a garden wall from the pavement, metres.
pub const HEDGE_M: [f32; 2] = [0.25, 0.95];
pub const GARDEN_WALL_M: [f32; 2] = [0.15, 0.37];
/// Half the width of the gap in a fence at the door, and length of its shortest piece, metres.
const GATE_M: f32 = 0.9;
const SHORTEST_FENCE_M: f32 = 0.6;
/// Distance of a fence's end from the corner of a house with a drive, metres.
const BEFORE_DRIVE_M: f32 = 0.2;

/// Use of a wall's ground floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundFloor {
    /// As in the storeys above.
    Windows = 0,
    /// Windows, and a door in the second bay.
    Door = 1,
    /// Shop windows under a sign.
    Shops = 2,
    /// No openings at all, as in walls between houses.
    Blank = 3,
}

/// Kind of a building's windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowKind {
    /// Two wings with a post between them.
    Casement = 0,
    /// Broad, of three panes.
    Broad = 1,
    /// Tall, in a frame of stone.
    Tall = 2,
    /// Pane without a post, as in gables and dormers.
    Small = 3,
}

/// Plan of a building.
#[derive(Clone, Debug, PartialEq)]
pub struct HousePlan {
    pub storeys: u32,
    pub windows: WindowKind,
    pub ground: GroundFloor,
    /// True for brick, false for plaster.
    pub is_brick: bool,
    /// Index of the wall's colour among those of brick or plaster, and its brightness.
    pub wall: (usize, f32),
    /// Number from which curtains, shutters and lit windows are drawn.
    pub facade_seed: u8,
    /// Wanted width of a bay, metres.
    pub bay_m: f32,
    /// Index of the colour of boards and frames.
    pub trim: usize,
    /// Index of the tiles' colour, and its brightness.
    pub tiles: (usize, f32),
    /// Roof with slopes; `None` for a flat one.
    pub roof: Option<RoofPlan>,
    /// Pieces of the fence along the pavement.
    pub fence: Vec<FencePiece>,
}

/// Plan of a roof with slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoofPlan {
    /// Rise over the horizontal distance.
    pub slope: f32,
    /// True if the ridge runs along the front.
    pub is_along: bool,
    /// True if all four sides slope.
    pub is_hipped: bool,
    /// Number of dormers on either side.
    pub dormers: usize,
    /// Place of the chimney along the ridge, from the middle, in lengths of the house.
    pub chimney: f32,
}

/// Kind of a fence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FenceKind {
    /// Hedge of this height over the ground floor's foot, metres.
    Hedge(f32),
    GardenWall,
    /// Boards nailed to posts.
    Boards,
}

impl FenceKind {
    /// Returns the distances of its sides from the pavement, metres.
    pub fn sides_m(self) -> [f32; 2] {
        match self {
            Self::Hedge(_) => HEDGE_M,
            Self::GardenWall => GARDEN_WALL_M,
            Self::Boards => [BOARDS_M - BOARD_M, BOARDS_M + POST_M],
        }
    }
}

/// Fence from the gate to one end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FencePiece {
    pub kind: FenceKind,
    pub left_m: f32,
    pub right_m: f32,
}

/// Returns the width of the bays along a wall, nearly `wanted_m`, and the wall's length in its bays.
pub fn bays(length_m: f32, wanted_m: f32) -> (f32, f32) {
    let bays = (length_m / wanted_m).round().max(1.0);
    let bay_m = (length_m / bays / BAY_STEP_M).round().clamp(1.0, 63.0) * BAY_STEP_M;
    (bay_m, bay_m * bays)
}

impl HousePlan {
    /// Draws the plan of a plot's building.
    pub fn of(plot: &Plot) -> Self {
        let mut random = rng::stream(plot.seed, "building");
        match plot.kind {
            PlotKind::House => Self::house(plot, &mut random),
            PlotKind::Flats => Self::flats(plot, &mut random),
            PlotKind::Shops => Self::shops(plot, &mut random),
        }
    }

    /// Returns the position of the door along the front, in its second bay, metres.
    pub fn door_m(&self, plot: &Plot) -> f32 {
        let (bay_m, along_m) = bays(plot.width_m, self.bay_m);
        -plot.width_m / 2.0 + 1.5 * bay_m * plot.width_m / along_m
    }

    fn house(plot: &Plot, random: &mut Stream) -> Self {
        let usual = if random.uniform(0.0, 1.0) < 0.45 { 1 } else { 2 };
        let windows = pick(random, &[WindowKind::Casement, WindowKind::Casement, WindowKind::Broad]);
        let mut plan = Self::walls(plot, usual, windows, GroundFloor::Door, random);
        let is_hipped = plan.storeys == 2 && random.uniform(0.0, 1.0) < 0.3;
        let slope = if is_hipped { random.uniform_f32(0.45, 0.6) } else { random.uniform_f32(0.75, 1.05) };
        let is_along = if is_hipped { plot.width_m >= plot.depth_m } else { random.uniform(0.0, 1.0) < 0.6 };
        let dormers = if !is_hipped && is_along { random.index(3) } else { 0 };
        plan.roof = Some(RoofPlan { slope, is_along, is_hipped, dormers, chimney: chimney(random) });
        plan.enclose(plot, random);
        plan
    }

    fn flats(plot: &Plot, random: &mut Stream) -> Self {
        let usual = 3 + random.index(2) as u32;
        let windows = pick(random, &[WindowKind::Broad, WindowKind::Casement]);
        let mut plan = Self::walls(plot, usual, windows, GroundFloor::Door, random);
        let is_flat = random.uniform(0.0, 1.0) < 0.55;
        if !is_flat {
            let slope = random.uniform_f32(0.5, 0.75);
            let is_hipped = random.uniform(0.0, 1.0) < 0.5;
            plan.roof = Some(RoofPlan { slope, is_along: true, is_hipped, dormers: 0, chimney: chimney(random) });
        }
        plan.enclose(plot, random);
        plan
    }

    fn shops(plot: &Plot, random: &mut Stream) -> Self {
        let usual = 2 + random.index(3) as u32;
        let windows = pick(random, &[WindowKind::Tall, WindowKind::Tall, WindowKind::Casement, WindowKind::Broad]);
        let ground = if random.uniform(0.0, 1.0) < 0.7 { GroundFloor::Shops } else { GroundFloor::Door };
        let mut plan = Self::walls(plot, usual, windows, ground, random);
        let is_flat = random.uniform(0.0, 1.0) < 0.3;
        if !is_flat {
            let slope = random.uniform_f32(0.8, 1.1);
            let is_along = random.uniform(0.0, 1.0) < 0.8;
            let dormers = if is_along { 2 + random.index(3) } else { 0 };
            plan.roof = Some(RoofPlan { slope, is_along, is_hipped: false, dormers, chimney: chimney(random) });
        }
        plan
    }

    /// Draws the walls and the colours of a building that has yet neither roof nor fence.
    fn walls(plot: &Plot, usual: u32, windows: WindowKind, ground: GroundFloor, random: &mut Stream) -> Self {
        let is_brick = random.uniform(0.0, 1.0) < 0.28;
        let wall = random.index(if is_brick { BRICKS } else { PLASTERS });
        let wall = (wall, random.uniform_f32(0.9, 1.08));
        let facade_seed = random.index(256) as u8;
        let usual_m = match windows {
            WindowKind::Broad => 3.6,
            WindowKind::Tall => 2.3,
            _ => 2.8,
        };
        let bay_m = usual_m * random.uniform_f32(0.92, 1.08);
        let trim = random.index(TRIMS);
        let tiles = random.index(TILES);
        let tiles = (tiles, random.uniform_f32(0.85, 1.15));
        let storeys = plot.storeys.unwrap_or(usual);
        let (roof, fence) = (None, Vec::new());
        Self { storeys, windows, ground, is_brick, wall, facade_seed, bay_m, trim, tiles, roof, fence }
    }

    /// Adds a hedge, a wall or a fence along the pavement.
    fn enclose(&mut self, plot: &Plot, random: &mut Stream) {
        let number = random.index(4);
        if !plot.has_fence {
            return;
        }
        let door_m = self.door_m(plot);
        // The fence ends at a drive.
        let half_m =
            |side: f32| plot.width_m / 2.0 + if plot.drive == Some(side) { BEFORE_DRIVE_M } else { FENCE_BEYOND_M };
        for (left_m, right_m) in [(-half_m(-1.0), door_m - GATE_M), (door_m + GATE_M, half_m(1.0))] {
            if right_m - left_m < SHORTEST_FENCE_M {
                continue;
            }
            let kind = match number {
                0 | 1 => FenceKind::Hedge(random.uniform_f32(0.8, 1.3)),
                2 => FenceKind::GardenWall,
                _ => FenceKind::Boards,
            };
            self.fence.push(FencePiece { kind, left_m, right_m });
        }
    }
}

/// Draws one of some values.
pub fn pick<T: Copy, const N: usize>(random: &mut Stream, of: &[T; N]) -> T {
    of[random.index(N)]
}

fn chimney(random: &mut Stream) -> f32 {
    random.uniform_f32(-0.3, 0.3)
}
