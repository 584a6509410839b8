//! Dimensions, finishes and levels of detail that the parts of a car share. Metres; colours are linear albedo.

use crate::scene::{Material, mesh::SurfaceFinish};

/// Distance between the axles, metres.
pub const WHEELBASE_M: f32 = 2.8;
/// Distance between the middles of the tyres of one axle, metres.
pub const TRACK_M: f32 = 1.55;
/// Radius of a wheel, and height of its hub, metres.
pub const WHEEL_RADIUS_M: f32 = 0.33;
/// Radius of a wheel arch around the hub, metres: 4.8 cm beyond the tyre.
pub(in crate::scene) const ARCH_RADIUS_M: f32 = WHEEL_RADIUS_M + 0.048;
/// Crease angle of fittings, 48 degrees: keeps their edges sharp and their round parts smooth.
pub(in crate::scene) const CREASE_RAD: f32 = 0.838;

pub(in crate::scene) const PAINT: SurfaceFinish = SurfaceFinish::grey(Material::Paint, 1.0);
pub(in crate::scene) const DARK: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.012);
pub(in crate::scene) const TRIM: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.025);
/// Glossy black plastic: window frames, lamp housings.
pub(in crate::scene) const GLOSS: SurfaceFinish = SurfaceFinish::grey(Material::Lamp, 0.010);
pub(in crate::scene) const GLASS: SurfaceFinish = SurfaceFinish::new(Material::Glass, [0.020, 0.024, 0.028]);
pub(in crate::scene) const CHROME: SurfaceFinish = SurfaceFinish::grey(Material::Metal, 0.55);
/// Brake lamp: its red; green and blue hold the share of the lamp's light given while running and while braking.
pub(in crate::scene) const BRAKE: SurfaceFinish = SurfaceFinish::new(Material::BrakeLamp, [0.30, 0.25, 1.0]);

/// Third brake lamp, which is no tail lamp: dark unless the vehicle brakes.
pub(in crate::scene) const HIGH_BRAKE: SurfaceFinish = SurfaceFinish::new(Material::BrakeLamp, [0.30, 0.0, 1.0]);

/// Level of detail of a car.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum LampLevel {
    /// For the nearest two or three cars: rounded, with all fittings and lamps with depth.
    Near,
    /// About 8,000 triangles, with transparent glass.
    Mid,
    /// About 2,500 triangles.
    Far,
}
