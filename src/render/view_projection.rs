//! View and projection of a camera. In: a scene camera, the picture's size. Out: projections, visibility, sizes in
//! pixels.

use crate::scene::{Camera, Lens};
use glam::{Mat4, Vec3};

/// Camera with the size of its picture.
#[derive(Clone, Copy, Debug)]
pub struct ViewFrustum {
    /// Camera in the scene.
    pub camera: Camera,
    size: [u32; 2],
    /// Vectors to the picture's right and upper edge, m at a distance of 1 m (at any distance, if parallel).
    edges: [Vec3; 2],
}

impl ViewFrustum {
    /// Computes the frustum of `camera` for a picture of `size` pixels.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let size = size.map(|side| side.max(1));
        let projection = camera.proj(size[0] as f32 / size[1] as f32);
        let right = camera.forward.cross(camera.up).normalize();
        let up = right.cross(camera.forward);
        // The projection's scale is 1 over half the picture, for any lens.
        let edges = [right / projection.x_axis.x, up / projection.y_axis.y];
        Self { camera: *camera, size, edges }
    }

    fn aspect(&self) -> f32 {
        self.size[0] as f32 / self.size[1] as f32
    }

    /// Returns the transform from world to clip space, reversed depth.
    pub fn clip_from_world(&self) -> Mat4 {
        self.camera.view_proj(self.aspect())
    }

    /// Returns the vectors to the picture's right and upper edge at a distance of 1 m; zero for a parallel lens, whose
    /// rays do not spread.
    pub fn spread(&self) -> [Vec3; 2] {
        if self.parallel_m().is_some() { [Vec3::ZERO; 2] } else { self.edges }
    }

    /// Returns half the longer side of a parallel picture, m; `None` for a perspective lens.
    pub fn parallel_m(&self) -> Option<f32> {
        match self.camera.lens {
            Lens::Perspective { .. } => None,
            Lens::Parallel { .. } => Some(self.edges[0].length().max(self.edges[1].length())),
        }
    }

    /// Returns true for a parallel picture taken from above.
    pub fn from_above(&self) -> bool {
        self.parallel_m().is_some() && self.camera.forward.z < -0.8
    }

    /// Returns false if no part of the sphere can be in the picture.
    pub fn sees(&self, centre: Vec3, radius_m: f32) -> bool {
        self.camera.sees(centre, radius_m, self.aspect())
    }

    /// Returns the radius of a sphere in the picture, pixels.
    pub fn pixels(&self, centre: Vec3, radius_m: f32) -> f32 {
        let distance = if self.parallel_m().is_some() { 1.0 } else { self.camera.eye.distance(centre).max(0.1) };
        radius_m / (distance * self.edges[0].length()) * self.size[0] as f32 / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frustum(lens: Lens) -> ViewFrustum {
        let camera = Camera { eye: Vec3::new(3.0, 2.0, 1.2), forward: Vec3::X, up: Vec3::Z, lens };
        ViewFrustum::new(&camera, [320, 180])
    }

    #[test]
    fn the_edges_are_where_the_camera_projects_them() {
        let frustum = frustum(Lens::Perspective { fov_x_rad: 1.1 });
        let [right, up] = frustum.spread();
        let corner = frustum.camera.eye + 20.0 * (frustum.camera.forward + right + up);
        let at = frustum.camera.project(corner, 320.0 / 180.0).expect("in front");
        assert!((at.x - 1.0).abs() < 1e-4 && at.y.abs() < 1e-4, "{at}");
        assert_eq!(frustum.parallel_m(), None);
    }

    #[test]
    fn a_sphere_has_the_pixels_that_the_projection_gives_it() {
        let perspective = frustum(Lens::Perspective { fov_x_rad: 1.1 });
        let centre = perspective.camera.eye + Vec3::X * 30.0;
        let edge = perspective.camera.project(centre - Vec3::Y * 2.0, 320.0 / 180.0).expect("in front");
        assert!((perspective.pixels(centre, 2.0) - (edge.x - 0.5) * 320.0).abs() < 0.05);
        let plan = frustum(Lens::Parallel { half_extent_m: 45.0 });
        assert!((plan.pixels(centre, 2.0) - 4.0).abs() < 1e-3, "180 pixels show 90 m");
        assert_eq!(plan.parallel_m(), Some(80.0));
        assert_eq!(plan.spread(), [Vec3::ZERO; 2]);
    }
}
