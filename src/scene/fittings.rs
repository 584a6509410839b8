//! What is fixed to a body: mirrors, handles, plates, grille, third brake lamp; and what is seen through its windows:
//! seats, dashboard, a driver. In: the body's lines. Out: loose triangles in the body's frame, metres. Nothing here
//! reaches beyond the body's 5.00 m.

use super::Material;
use super::car::{BRAKE, CHROME, DARK, GLASS, LAMP, Level, PAINT, TRIM, WHEELBASE_M};
use super::mesh::{Finish, Soup};
use super::shape::{self, ARCH_RADIUS_M, Lines};
use glam::Vec3;

const PLATE: Finish = Finish::grey(Material::Matt, 0.70);
const SEAT: Finish = Finish::grey(Material::Matt, 0.045);
const CLOTH: Finish = Finish::new(Material::Matt, [0.055, 0.065, 0.095]);
const SKIN: Finish = Finish::new(Material::Matt, [0.30, 0.19, 0.14]);

/// Parts on the outside.
pub(super) fn outside(lines: &Lines, level: Level) -> Soup {
    let mut all = Soup::default();
    let left = side(level);
    all.append(left.mirrored());
    all.append(left);
    all.append(middle(lines, level));
    all
}

/// Parts that stand on both sides, left ones.
fn side(level: Level) -> Soup {
    let mut parts = Soup::default();
    // Mirror: the housing in the car's colour, its back dark as glass; a foot on the door.
    let fine = match level {
        Level::Near => [10, 16],
        Level::Mid => [6, 8],
        Level::Far => [3, 4],
    };
    parts.ellipsoid(Vec3::new(0.74, 0.905, 0.985), Vec3::new(0.075, 0.085, 0.062), fine, |outwards| {
        if outwards.x < -0.6 { GLASS } else { PAINT }
    });
    if level == Level::Far {
        return parts;
    }
    parts.cuboid(Vec3::new(0.76, 0.835, 0.945), Vec3::new(0.03, 0.035, 0.014), TRIM);
    for x in [0.12, -0.82] {
        parts.cuboid(Vec3::new(x, 0.893, 0.80), Vec3::new(0.085, 0.009, 0.011), PAINT);
    }
    if level == Level::Near {
        // Reflector in the bumper, exhaust, fog lamp, sill strip.
        let red = Finish::new(Material::Matt, [0.20, 0.008, 0.008]);
        parts.cuboid(Vec3::new(-2.493, 0.60, 0.455), Vec3::new(0.006, 0.075, 0.014), red);
        parts.cuboid(Vec3::new(-2.465, 0.46, 0.335), Vec3::new(0.03, 0.060, 0.022), CHROME);
        parts.cuboid(Vec3::new(-2.489, 0.46, 0.335), Vec3::new(0.008, 0.050, 0.015), DARK);
        parts.cuboid(Vec3::new(0.0, 0.866, 0.215), Vec3::new(0.95, 0.012, 0.012), TRIM);
        // White reversing lamp at the inner end of the rear cluster.
        parts.cuboid(Vec3::new(-2.500, 0.43, 0.785), Vec3::new(0.003, 0.028, 0.030), LAMP);
        // The upright shut lines of the boot lid.
        parts.cuboid(Vec3::new(-2.4995, 0.395, 0.74), Vec3::new(0.002, 0.003, 0.145), DARK);
    }
    parts
}

/// Parts in the middle.
fn middle(lines: &Lines, level: Level) -> Soup {
    let mut parts = Soup::default();
    // Nothing stands out of the end planes, which would exceed 5.00 m, by more than 4 mm.
    for (x, z) in [(-2.4995, 0.70), (2.4995, 0.375)] {
        parts.cuboid(Vec3::new(x, 0.0, z), Vec3::new(0.004, 0.26, 0.056), PLATE);
        if level == Level::Near {
            // Letters: seven dark strokes.
            for k in [-3.0f32, -2.0, -0.6, 0.3, 1.2, 2.1, 3.0] {
                let half = Vec3::new(0.001, 0.014, 0.028);
                parts.cuboid(Vec3::new(x + 0.0036 * x.signum(), k * 0.066, z), half, TRIM);
            }
        }
    }
    let lamp_x = lines.rear_glass[1] + 0.03;
    let lamp_z = shape::at(lines, lamp_x).top_z - 0.003;
    parts.cuboid(Vec3::new(lamp_x, 0.0, lamp_z), Vec3::new(0.018, 0.15, 0.009), BRAKE);
    // Nobody sees through the wheel arches to the other side.
    for hub in [-WHEELBASE_M / 2.0, WHEELBASE_M / 2.0] {
        parts.cuboid(Vec3::new(hub, 0.0, 0.45), Vec3::new(ARCH_RADIUS_M - 0.01, 0.55, 0.25), DARK);
    }
    if level == Level::Far {
        return parts;
    }
    parts.cuboid(Vec3::new(-2.4985, 0.0, 0.80), Vec3::new(0.005, 0.42, 0.010), CHROME);
    // The bumper's upper edge.
    parts.cuboid(Vec3::new(-2.4985, 0.0, 0.575), Vec3::new(0.003, 0.62, 0.004), DARK);
    // Grille: bars over the dark opening, a badge.
    for z in [0.462, 0.490, 0.518, 0.546] {
        parts.cuboid(Vec3::new(2.4985, 0.0, z), Vec3::new(0.0035, 0.33, 0.005), CHROME);
    }
    parts.ellipsoid(Vec3::new(2.498, 0.0, 0.508), Vec3::new(0.006, 0.050, 0.034), [6, 10], |_| CHROME);
    if level == Level::Near {
        // Wipers lie along the foot of the windscreen; an aerial on the roof.
        for y in [-0.38, 0.22] {
            let z = shape::at(lines, 1.08).top_z + 0.004;
            parts.cuboid(Vec3::new(1.08, y, z), Vec3::new(0.010, 0.27, 0.006), DARK);
        }
        let x = lines.rear_glass[1] + 0.22;
        let z = shape::at(lines, x).top_z - 0.01;
        parts.ellipsoid(Vec3::new(x, 0.0, z), Vec3::new(0.075, 0.016, 0.022), [6, 8], |_| PAINT);
    }
    parts
}

/// What is seen through the windows; closed below by a dark floor.
pub(super) fn cabin(lines: &Lines) -> Soup {
    let mut all = Soup::default();
    let (rear, front) = (lines.cabin_rear_m + 0.05, 1.05);
    let floor = Vec3::new((rear + front) / 2.0, 0.0, 0.78);
    all.cuboid(floor, Vec3::new((front - rear) / 2.0, 0.80, 0.02), DARK);
    // Dashboard and parcel shelf.
    all.cuboid(Vec3::new(0.86, 0.0, 0.86), Vec3::new(0.16, 0.72, 0.06), TRIM);
    all.cuboid(Vec3::new(-1.42, 0.0, 0.88), Vec3::new(0.22, 0.62, 0.05), TRIM);
    for y in [-0.36, 0.36] {
        seat(&mut all, Vec3::new(-0.16, y, 0.0));
    }
    for y in [-0.40, 0.0, 0.40] {
        seat(&mut all, Vec3::new(-1.05, y, -0.05));
    }
    // The driver, and the wheel in front.
    all.ellipsoid(Vec3::new(0.02, 0.36, 0.98), Vec3::new(0.13, 0.21, 0.20), [8, 10], |_| CLOTH);
    all.ellipsoid(Vec3::new(0.05, 0.36, 1.25), Vec3::new(0.095, 0.078, 0.115), [8, 10], |out| {
        if out.y > 0.3 || out.x < -0.2 { Finish::new(Material::Matt, [0.03, 0.02, 0.015]) } else { SKIN }
    });
    for k in 0..12 {
        let (sin, cos) = (k as f32 * std::f32::consts::TAU / 12.0).sin_cos();
        let at = Vec3::new(0.55 - 0.07 * sin, 0.36 + 0.17 * cos, 0.95 + 0.16 * sin);
        all.ellipsoid(at, Vec3::new(0.018, 0.05, 0.05), [3, 4], |_| DARK);
    }
    all
}

/// Back and headrest; cushions are below the windows.
fn seat(all: &mut Soup, at: Vec3) {
    all.ellipsoid(at + Vec3::new(-0.05, 0.0, 0.90), Vec3::new(0.09, 0.23, 0.24), [6, 10], |_| SEAT);
    all.ellipsoid(at + Vec3::new(-0.11, 0.0, 1.20), Vec3::new(0.05, 0.12, 0.075), [6, 8], |_| SEAT);
}
