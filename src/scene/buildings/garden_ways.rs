//! Paths to doors and drives beside houses, on the ground as it slopes. In: plots, the ground. Out: one mesh in world axes. Metres.

use super::{houses::STONE, shell::Shell};
use crate::{
    roadside::{
        house_plans::HousePlan,
        plots::{DRIVE_M, DRIVE_UP_M, Plot, PlotKind},
        relief::Relief,
    },
    scene::{Mesh, colours::shade},
};
use glam::{Vec2, Vec3};

/// Largest distance between rows of a way, metres.
const ROW_M: f32 = 1.5;
/// Depth of its sides below the ground, metres.
const SIDE_M: f32 = 0.3;
/// Distance of the path's end from the front: it ends at the step before the door, metres.
const DOOR_STEP_M: f32 = 0.85;

/// A way as a strip: its edges to the left and to the right of the front's middle, and its end behind the front.
struct GardenWay {
    left_m: f32,
    right_m: f32,
    end_m: f32,
    colour: [f32; 3],
}

/// Returns the ways of all gardens.
pub(super) fn mesh(plots: &[Plot], relief: &Relief) -> Mesh {
    let mut shell = Shell::default();
    for plot in plots.iter().filter(|plot| plot.kind != PlotKind::Shops) {
        ways(plot).iter().for_each(|way| pave(&mut shell, plot, way, relief));
    }
    shell.mesh
}

fn ways(plot: &Plot) -> Vec<GardenWay> {
    let door_m = HousePlan::of(plot).door_m(plot);
    let path =
        GardenWay { left_m: door_m - 0.65, right_m: door_m + 0.65, end_m: -DOOR_STEP_M, colour: shade(STONE, 0.8) };
    let drive = plot.drive.map(|side| {
        let (near, far) = (plot.width_m / 2.0 + 0.4, plot.width_m / 2.0 + 3.2);
        let [left_m, right_m] = if side > 0.0 { [near, far] } else { [-far, -near] };
        GardenWay { left_m, right_m, end_m: DRIVE_M, colour: shade(STONE, 0.7) }
    });
    [path].into_iter().chain(drive).collect()
}

/// Paves a way from the pavement on, but no road: a street may bend towards the garden.
fn pave(shell: &mut Shell, plot: &Plot, way: &GardenWay, relief: &Relief) {
    let GardenWay { left_m, right_m, end_m, colour } = *way;
    let start_m = -plot.garden_m;
    let rows = ((end_m - start_m) / ROW_M).ceil().max(1.0) as usize;
    let at = |right_m: f32, row: usize| plot.point(right_m, start_m + (end_m - start_m) * row as f32 / rows as f32);
    let is_free = |row: &usize| [left_m, right_m].iter().all(|side| relief.roads.border_m(at(*side, *row)) > 0.0);
    let Some(first) = (0..rows).find(is_free) else { return };
    let top = |at: Vec2| at.extend(relief.height_m(at) + DRIVE_UP_M);
    let corners: Vec<[Vec3; 2]> = (first..=rows).map(|row| [left_m, right_m].map(|side| top(at(side, row)))).collect();
    let side = |shell: &mut Shell, [from, to]: [Vec3; 2]| {
        shell.plain(&[from - Vec3::Z * SIDE_M, to - Vec3::Z * SIDE_M, to, from], colour);
    };
    for pair in corners.windows(2) {
        let [[left, right], [left_behind, right_behind]] = [pair[0], pair[1]];
        shell.plain(&[left, right, right_behind, left_behind], colour);
        side(shell, [left_behind, left]);
        side(shell, [right, right_behind]);
    }
    if let (Some([left, right]), Some([left_behind, right_behind])) = (corners.first(), corners.last()) {
        side(shell, [*left, *right]);
        side(shell, [*right_behind, *left_behind]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::RoadMap,
        roadside::Roadside,
        scene::mesh::tests::{check, faces},
    };

    #[test]
    fn ways_lie_on_the_slope_of_the_ground_and_on_no_road() {
        let map = RoadMap::load("town").expect("a shipped map");
        let roadside = Roadside::of(&map.network, &[], 1, 0);
        let relief = roadside.relief();
        let mesh = mesh(&roadside.buildings.plots, &relief);
        check(&mesh, "ways");
        let mut tops = 0;
        for (corners, _) in faces(&mesh).filter(|(_, face)| face.z > 0.0) {
            let corners = corners.map(|corner| Vec3::from(corner.position));
            for corner in corners {
                let (ground_m, road_m) = (relief.height_m(corner.truncate()), relief.roads.border_m(corner.truncate()));
                assert!((corner.z - ground_m - 0.03).abs() < 0.01, "{corner}: ground at {ground_m} m");
                assert!(road_m > 0.0, "{corner} is on a road");
            }
            tops += 1;
        }
        assert!(tops > 1000, "{tops}");
    }
}
