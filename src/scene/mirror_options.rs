//! Options of the rear-view mirror. In: metres and degrees. Out: [`MirrorOptions`], by which `camera` places the mirror's camera.

use glam::Vec3;

/// Rear-view mirror: a camera that looks back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorOptions {
    /// Position in the body's frame, metres: the top of the windscreen.
    pub position: Vec3,
    /// Horizontal angle of view of the flat mirror, degrees.
    pub fov_x_deg: f32,
    /// Yaw, degrees: positive turns the mirror to the left side behind.
    pub yaw_deg: f32,
    /// Upward tilt, degrees: -2.5 shows the bonnet of a follower 2 m away.
    pub pitch_deg: f32,
    /// Radius of curvature of the convex glass, metres; 0 is flat.
    pub radius_m: f32,
}

impl MirrorOptions {
    /// Returns the curvature used by the renderer: the eye's distance from the glass over the glass's radius. A ray that meets
    /// the glass at the angle `a` from its middle leaves it at `a + 2 asin(d tan(a) / R)`. There the glass is turned by `asin(x /
    /// R)`, `x = d tan(a)`, and a turned mirror turns the ray twice as far (law of reflection; Hecht, Optics, 5.4).
    pub fn bend(&self, eye: Vec3) -> f32 {
        if self.radius_m > 0.0 { eye.distance(self.position) / self.radius_m } else { 0.0 }
    }
}

impl Default for MirrorOptions {
    fn default() -> Self {
        Self { position: Vec3::new(0.30, 0.0, 1.26), fov_x_deg: 30.0, yaw_deg: 0.0, pitch_deg: -2.5, radius_m: 0.0 }
    }
}
