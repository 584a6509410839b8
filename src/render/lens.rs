//! From a camera to numbers: what it maps where and what it can see. In: a scene camera and the picture's size. Out:
//! matrices with reversed depth (1 at the eye, 0 far away: 32-bit floats then resolve millimetres near and far) and the
//! planes of the visible space.

use crate::scene::{Camera, Lens};
use glam::{Mat4, Vec3, Vec4, camera::rh};

/// Nearest thing that a perspective lens shows, metres.
const NEAR_M: f32 = 0.2;
/// Depth of what a parallel lens shows, metres.
const PARALLEL_DEPTH_M: f32 = 3000.0;

/// A camera with the shape of its picture.
#[derive(Clone, Copy, Debug)]
pub struct Optics {
    /// World to clip space.
    pub clip_from_world: Mat4,
    /// Eye, metres.
    pub eye: Vec3,
    /// Optical axis.
    pub forward: Vec3,
    /// To the picture's right edge at distance 1; zero for a parallel lens.
    pub right: Vec3,
    /// To its upper edge.
    pub up: Vec3,
    /// For a parallel lens, half the longer side of the picture in metres.
    pub parallel_m: Option<f32>,
    planes: [Vec4; 5],
}

impl Optics {
    /// The optics of `camera` for a picture of `size` pixels.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let aspect = size[0].max(1) as f32 / size[1].max(1) as f32;
        let view = rh::view::look_to_mat4(camera.eye, camera.forward, camera.up);
        let side = camera.forward.cross(camera.up).normalize();
        let over = side.cross(camera.forward);
        let (projection, [half_x, half_y], parallel_m) = match camera.lens {
            Lens::Perspective { fov_x_rad } => {
                let half_x = (fov_x_rad / 2.0).tan();
                let half_y = half_x / aspect;
                let fov_y_rad = 2.0 * half_y.atan();
                (rh::proj::directx::perspective_infinite_reverse(fov_y_rad, aspect, NEAR_M), [half_x, half_y], None)
            }
            Lens::Parallel { half_extent_m } => {
                let [x, y] = [half_extent_m * aspect.max(1.0), half_extent_m / aspect.min(1.0)];
                (rh::proj::directx::orthographic(-x, x, -y, y, PARALLEL_DEPTH_M, 0.0), [0.0, 0.0], Some(x.max(y)))
            }
        };
        let clip_from_world = projection * view;
        let row = |i| clip_from_world.row(i);
        let planes = [row(3) + row(0), row(3) - row(0), row(3) + row(1), row(3) - row(1), row(3) - row(2)];
        Self {
            clip_from_world,
            eye: camera.eye,
            forward: camera.forward,
            right: side * half_x,
            up: over * half_y,
            parallel_m,
            planes: planes.map(|p| p / p.truncate().length()),
        }
    }

    /// False if nothing of the ball can be in the picture.
    pub fn sees(&self, centre: Vec3, radius_m: f32) -> bool {
        self.planes.iter().all(|p| p.dot(centre.extend(1.0)) > -radius_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [320, 180];

    fn camera(lens: Lens) -> Camera {
        Camera { eye: Vec3::new(0.0, 0.0, 1.2), forward: Vec3::X, up: Vec3::Z, lens }
    }

    #[test]
    fn the_horizontal_angle_of_view_is_the_one_asked_for() {
        let optics = Optics::new(&camera(Lens::Perspective { fov_x_rad: 1.1 }), SIZE);
        let edge = Vec3::new(10.0, -10.0 * (0.55_f32).tan(), 1.2);
        let clip = optics.clip_from_world * edge.extend(1.0);
        assert!((clip.x / clip.w - 1.0).abs() < 1e-5, "the right edge is at {}", clip.x / clip.w);
    }

    #[test]
    fn depth_is_one_near_the_eye_and_falls_with_distance() {
        for lens in [Lens::Perspective { fov_x_rad: 1.1 }, Lens::Parallel { half_extent_m: 30.0 }] {
            let optics = Optics::new(&camera(lens), SIZE);
            let depth = |x| {
                let clip = optics.clip_from_world * Vec4::new(x, 0.0, 1.2, 1.0);
                clip.z / clip.w
            };
            assert!(depth(0.3) <= 1.0 && depth(0.3) > depth(10.0) && depth(10.0) > depth(1000.0) && depth(1000.0) > 0.0);
        }
    }

    #[test]
    fn culling_keeps_what_is_in_the_picture_and_drops_what_is_not() {
        let optics = Optics::new(&camera(Lens::Perspective { fov_x_rad: 1.1 }), SIZE);
        assert!(optics.sees(Vec3::new(20.0, 0.0, 1.0), 1.0));
        assert!(!optics.sees(Vec3::new(-20.0, 0.0, 1.0), 1.0), "behind");
        assert!(!optics.sees(Vec3::new(5.0, 20.0, 1.0), 1.0), "far to the left");
        assert!(optics.sees(Vec3::new(5.0, 20.0, 1.0), 30.0), "a ball that reaches in");
        let plan = Optics::new(&camera(Lens::Parallel { half_extent_m: 30.0 }), SIZE);
        assert!(plan.sees(Vec3::new(5.0, 50.0, 1.0), 0.1), "the longer side shows more");
        assert!(!plan.sees(Vec3::new(5.0, 60.0, 1.0), 0.1));
    }
}
