//! What a driver sees of the own car: the bonnet and the wings, the top of the dashboard with the hood over the
//! instruments, the lower ends of the pillars. Out: one mesh in the body's frame, metres; drawn in the driver's view only.

use super::Material;
use super::Mesh;
use super::car::{CREASE_RAD, DARK, Level, Parts, TRIM};
use super::mesh::{Finish, Soup};
use super::shape::{self, CABIN_FRONT_M, STYLES};
use glam::Vec3;

const PILLAR: Finish = Finish::grey(Material::Matt, 0.06);
/// Half the width of a pillar, metres.
const PILLAR_M: f32 = 0.019;

/// The interior of the ego's style.
pub(super) fn interior() -> Mesh {
    let lines = STYLES[0];
    let parts = Parts::new(lines, Level::Near);
    // What of the body lies before the windscreen or below the side windows and can be seen from above.
    let seen = |p: &Vec3| p.z > 0.66 && (p.x > CABIN_FRONT_M - 0.01 || (p.x > 0.4 && p.z < 0.93));
    let mut all = parts.shell.only(|corners| corners.iter().all(seen));
    dashboard(&mut all);
    for side in [-1.0, 1.0] {
        pillar(&mut all, side);
    }
    all.into_mesh(CREASE_RAD)
}

/// A shelf from the windscreen's foot towards the driver, its edge rolled down; a hood over the instruments.
fn dashboard(all: &mut Soup) {
    // The first row lies under the bonnet's rear edge.
    let rows = [(1.24, 0.0), (1.14, 0.895), (0.98, 0.918), (0.84, 0.930), (0.76, 0.924), (0.72, 0.900), (0.71, 0.80)];
    const COLUMNS: usize = 24;
    let place = |(x, z): (f32, f32), column: usize| {
        let y = 1.66 * (column as f32 / COLUMNS as f32 - 0.5);
        // Lower towards the doors and drawn back there.
        let aside = (y / 0.75) * (y / 0.75);
        if z == 0.0 {
            let at = shape::at(STYLES[0], x);
            let dome = 1.0 - (y / at.belt_y).abs().powf(2.5);
            return Vec3::new(x, y, at.belt_z + (at.top_z - at.belt_z) * dome - 0.006);
        }
        Vec3::new(x - 0.10 * aside * (x - 0.7), y, z - 0.02 * aside)
    };
    for pair in rows.windows(2) {
        for column in 0..COLUMNS {
            let corner = |row: usize, column| place(pair[row], column);
            all.quad([corner(0, column), corner(0, column + 1), corner(1, column + 1), corner(1, column)], TRIM);
        }
    }
    // The doors' upper edges, from the bonnet to beside the eye.
    for side in [-1.0f32, 1.0] {
        for i in 0..14 {
            let edge = |i: usize, z_m: f32, in_m: f32| {
                let x = 1.26 - 0.1 * i as f32;
                let at = shape::at(STYLES[0], x);
                Vec3::new(x, side * (at.belt_y - in_m), at.belt_z + z_m)
            };
            let lines = [(0.002, 0.0), (0.006, 0.03), (-0.02, 0.06), (-0.40, 0.07)];
            for pair in lines.windows(2) {
                let [(z0, in0), (z1, in1)] = [pair[0], pair[1]];
                let mut corners = [edge(i, z0, in0), edge(i, z1, in1), edge(i + 1, z1, in1), edge(i + 1, z0, in0)];
                if side > 0.0 {
                    corners.reverse();
                }
                all.quad(corners, TRIM);
            }
        }
    }
    all.ellipsoid(Vec3::new(0.76, 0.36, 0.915), Vec3::new(0.12, 0.22, 0.055), [14, 18], |_| DARK);
}

/// Along the edge of the windscreen, from the dashboard to the roof.
fn pillar(all: &mut Soup, side: f32) {
    const STEPS: usize = 10;
    let middle = |i: usize| {
        let x = CABIN_FRONT_M + 0.02 - 0.90 * i as f32 / STEPS as f32;
        let at = shape::at(STYLES[0], x.min(CABIN_FRONT_M));
        // Its foot is in the dashboard.
        let foot_m = if i == 0 { 0.07 } else { 0.0 };
        Vec3::new(x + foot_m, side * (at.roof_y + 0.035), at.roof_z - 0.012 - foot_m)
    };
    let ring = |i: usize| {
        let along = (middle((i + 1).min(STEPS)) - middle(i.max(1) - 1)).normalize();
        let across = along.cross(Vec3::Z).normalize();
        let up = across.cross(along);
        std::array::from_fn::<Vec3, 8, _>(|k| {
            let (sin, cos) = (std::f32::consts::TAU * k as f32 / 8.0).sin_cos();
            middle(i) + (across * cos + up * sin) * PILLAR_M
        })
    };
    for i in 0..STEPS {
        let (a, b) = (ring(i), ring(i + 1));
        for k in 0..8 {
            let next = (k + 1) % 8;
            all.quad([a[k], a[next], b[next], b[k]], PILLAR);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::ViewOptions;
    use super::super::mesh::tests::check;
    use super::*;

    #[test]
    fn the_interior_leaves_the_road_free() {
        let mesh = interior();
        check(&mesh, "interior");
        let eye = ViewOptions::default().eye;
        let highest = |ahead: &dyn Fn(Vec3) -> bool| {
            let seen = mesh.vertices.iter().map(|v| Vec3::from(v.position) - eye).filter(|p| ahead(*p));
            seen.map(|p| p.z / p.x).fold(f32::MIN, f32::max)
        };
        // Straight ahead the bonnet ends 9 degrees below the horizon: the asphalt shows from 7.5 m before the eye on,
        // 5 m before the bumper, and of a car 2 m ahead everything above its bumper.
        let bonnet = highest(&|p| p.x > 0.4 && (p.y / p.x).abs() < 0.30);
        assert!((-0.19..-0.14).contains(&bonnet), "{bonnet}");
        // Only the pillars rise above, at the picture's edges.
        assert!(highest(&|p| p.x > 0.2 && (p.y / p.x).abs() < 0.42) < -0.1);
        assert!(mesh.vertices.iter().all(|v| eye.distance(v.position.into()) > 0.25), "clear of the near plane");
    }
}
