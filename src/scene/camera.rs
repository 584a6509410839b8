//! Cameras of the driver, the mirror, the bird's-eye view and the chase view, and the projection of the world into their
//! pictures, shared by renderer, overlays and tests. In: the ego, a [`Camera`] and the picture's aspect (width / height). Out:
//! cameras, and matrices with depth 0..1, **reversed**: 1 at the near plane, 0 at infinity (or at the parallel lens's far plane),
//! which keeps float depth exact to the horizon.

use super::{Camera, Lens, StaticScene, ViewOptions, view::EgoAt};
use crate::{scenario::CockpitView, space::Pose};
use glam::camera::rh::{proj::directx, view::look_to_mat4};
use glam::{Mat4, Quat, Vec2, Vec3};

/// Near plane of perspective lenses, metres: closer than any part of a car comes to a camera.
pub const NEAR_M: f32 = 0.1;
/// Depth range of a parallel lens, metres from the eye.
pub const PARALLEL_DEPTH_M: f32 = 2000.0;

impl Camera {
    /// Returns the transform from world to camera: x right, y up, looking along -z.
    pub fn view(&self) -> Mat4 {
        look_to_mat4(self.eye, self.forward, self.up)
    }

    /// Returns the projection from camera to clip space, with reversed depth, for a picture of `aspect` (width / height).
    pub fn proj(&self, aspect: f32) -> Mat4 {
        match self.lens {
            Lens::Perspective { .. } => {
                let half = self.half_size(aspect);
                directx::perspective_infinite_reverse(2.0 * half.y.atan(), aspect, NEAR_M)
            }
            Lens::Parallel { .. } => {
                let half = self.half_size(aspect);
                // The near and far planes are swapped, which reverses the depth.
                directx::orthographic(-half.x, half.x, -half.y, half.y, PARALLEL_DEPTH_M, 0.0)
            }
        }
    }

    /// Returns the transform from world to clip space.
    pub fn view_proj(&self, aspect: f32) -> Mat4 {
        self.proj(aspect) * self.view()
    }

    /// Projects `point` into the picture: 0..1 from left to right and from **top to bottom**, outside that range beside the
    /// picture. `None` for points outside the depth range, such as those before the near plane.
    pub fn project(&self, point: Vec3, aspect: f32) -> Option<Vec2> {
        let clip = self.view_proj(aspect) * point.extend(1.0);
        if clip.w <= 0.0 || clip.z < 0.0 || clip.z > clip.w {
            return None;
        }
        Some(Vec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w))
    }

    /// Returns the ray through a point of the picture (0..1, y down): its start and unit direction.
    pub fn ray(&self, picture: Vec2, aspect: f32) -> (Vec3, Vec3) {
        let half = self.half_size(aspect);
        let right = self.forward.cross(self.up).normalize();
        let up = right.cross(self.forward).normalize();
        let across = right * ((2.0 * picture.x - 1.0) * half.x) + up * ((1.0 - 2.0 * picture.y) * half.y);
        match self.lens {
            Lens::Perspective { .. } => (self.eye, (self.forward + across).normalize()),
            Lens::Parallel { .. } => (self.eye + across, self.forward),
        }
    }

    /// Checks whether a sphere may be in the picture, for culling.
    pub fn sees(&self, centre: Vec3, radius_m: f32, aspect: f32) -> bool {
        let p = self.view().transform_point3(centre);
        let half = self.half_size(aspect);
        match self.lens {
            Lens::Perspective { .. } => {
                // Distance outside a side plane through the eye with slope `half`.
                let outside = |across: f32, slope: f32| (across.abs() + p.z * slope) / slope.hypot(1.0);
                -p.z + radius_m > NEAR_M && outside(p.x, half.x) < radius_m && outside(p.y, half.y) < radius_m
            }
            Lens::Parallel { .. } => {
                p.x.abs() < half.x + radius_m
                    && p.y.abs() < half.y + radius_m
                    && -p.z > -radius_m
                    && -p.z < PARALLEL_DEPTH_M + radius_m
            }
        }
    }

    /// Returns half of the picture's width and height: tangents of the half angles, or metres for a parallel lens.
    fn half_size(&self, aspect: f32) -> Vec2 {
        match self.lens {
            Lens::Perspective { fov_x_rad } => {
                let x = (fov_x_rad / 2.0).tan();
                Vec2::new(x, x / aspect)
            }
            Lens::Parallel { half_extent_m } if aspect >= 1.0 => Vec2::new(half_extent_m * aspect, half_extent_m),
            Lens::Parallel { half_extent_m } => Vec2::new(half_extent_m, half_extent_m / aspect),
        }
    }
}

/// Downward pitch of the driver's camera in the full cockpit, radians: 6 degrees. With a level camera a picture 38 degrees high
/// would end where the instruments begin.
const LOOK_DOWN_RAD: f32 = 0.105;

/// Returns the driver's camera in the body's frame.
pub(super) fn driver_look(options: &ViewOptions) -> Camera {
    let down = if options.cockpit == CockpitView::Full { LOOK_DOWN_RAD } else { 0.0 };
    let look = Quat::from_rotation_y(down);
    let lens = Lens::Perspective { fov_x_rad: options.fov_x_rad() };
    Camera { eye: options.eye, forward: look * Vec3::X, up: look * Vec3::Z, lens }
}

/// Returns the driver's camera.
pub(super) fn driver_camera(ego: &EgoAt, options: &ViewOptions) -> Camera {
    let rotation = ego.steadied(options.body_motion);
    let look = driver_look(options);
    Camera { eye: ego.position + rotation * look.eye, forward: rotation * look.forward, up: rotation * look.up, ..look }
}

/// Returns the camera of the rear-view mirror.
pub(super) fn mirror_camera(ego: &EgoAt, options: &ViewOptions) -> Camera {
    let rotation = ego.steadied(options.body_motion);
    let (yaw, pitch) = (options.mirror.yaw_deg.to_radians(), options.mirror.pitch_deg.to_radians());
    // Backwards, tilted up by `pitch`, then turned towards the left side of the road behind by `yaw`.
    let turned = rotation * Quat::from_rotation_z(-yaw) * Quat::from_rotation_y(pitch);
    Camera {
        eye: ego.position + rotation * options.mirror.position,
        forward: turned * Vec3::NEG_X,
        up: turned * Vec3::Z,
        lens: Lens::Perspective { fov_x_rad: options.mirror.fov_x_deg.to_radians() },
    }
}

/// Height of the bird's-eye camera above the highest road, metres: above hills and trees near the road.
const BIRDSEYE_HEIGHT_M: f32 = 400.0;

/// Half the width of the widest scene that the bird's-eye view shows whole, metres: a car then has 12 of 720 lines.
const WIDEST_SCENE_M: f32 = 138.0;
/// Half the width of the widest circuit without branches that it shows whole, metres: a wave is seen as a whole there, with 6 of 720 lines for a car.
const WIDEST_CIRCUIT_M: f32 = 300.0;
/// Half the width that it shows around the ego in wider scenes, such as towns, metres: a car has 18 of 720 lines.
const FOLLOWED_M: f32 = 100.0;

/// Returns the camera above the whole scene, or above the ego, if there is one, where the options say so or the scene is too wide.
pub(super) fn birdseye_camera(ego: Option<&EgoAt>, options: &ViewOptions, static_scene: &StaticScene) -> Camera {
    let whole_m = static_scene.radius_m * 1.06 + 4.0;
    let network = &static_scene.network;
    let branches = || network.lane_ids().any(|lane| network.connections_from(lane).len() > 1);
    let is_too_wide = whole_m > WIDEST_CIRCUIT_M || whole_m > WIDEST_SCENE_M && branches();
    let followed_m = options.birdseye_follow_m.or(is_too_wide.then_some(FOLLOWED_M));
    let (centre, half_extent_m) = match ego.zip(followed_m) {
        Some((ego, half_extent_m)) => (ego.position.truncate(), half_extent_m),
        None => (static_scene.centre, whole_m),
    };
    Camera {
        eye: centre.extend(BIRDSEYE_HEIGHT_M + static_scene.highest_m),
        forward: -Vec3::Z,
        up: Vec3::Y,
        lens: Lens::Parallel { half_extent_m },
    }
}

/// Time by which the chase camera lags behind a turning car, seconds, so that it does not swing rigidly with the car.
const CHASE_LAG_S: f32 = 0.25;

/// Returns the camera behind the ego.
pub(super) fn chase_camera(ego: &EgoAt, yaw_rate: f32, static_scene: &StaticScene) -> Camera {
    let back = Vec2::from_angle(ego.yaw_rad - (yaw_rate * CHASE_LAG_S).clamp(-0.5, 0.5));
    let at = ego.position.truncate();
    let under = Pose::new(at.as_dvec2(), f64::from(ego.yaw_rad));
    let (road_m, grade) = static_scene.road_at(under, f64::from(ego.position.z)).unwrap_or_default();
    // Behind the ego on the same slope.
    let eye = (at - back * 7.5).extend(2.6 + road_m - 7.5 * grade);
    let target = (at + back * 2.0).extend(0.8 + road_m + 2.0 * grade);
    let forward = (target - eye).normalize();
    let right = forward.cross(Vec3::Z).normalize();
    Camera { eye, forward, up: right.cross(forward), lens: Lens::Perspective { fov_x_rad: 63f32.to_radians() } }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lens(perspective: bool) -> Camera {
        let lens = if perspective {
            Lens::Perspective { fov_x_rad: 63f32.to_radians() }
        } else {
            Lens::Parallel { half_extent_m: 20.0 }
        };
        let forward = Vec3::new(1.0, 2.0, -0.3).normalize();
        Camera { eye: Vec3::new(3.0, -7.0, 1.2), forward, up: Vec3::Z, lens }
    }

    #[test]
    fn a_point_on_the_ray_through_a_picture_point_projects_back_to_it() {
        for camera in [lens(true), lens(false)] {
            for aspect in [16.0 / 9.0, 0.7] {
                for i in 0..50 {
                    let picture = Vec2::new((i % 10) as f32 / 9.0, (i / 10) as f32 / 4.0);
                    let (start, direction) = camera.ray(picture, aspect);
                    let back = camera.project(start + direction * (3.0 + i as f32), aspect).expect("in front");
                    assert!((back - picture).length() < 1e-4, "{picture} {back}");
                }
            }
        }
    }

    #[test]
    fn the_horizontal_angle_of_view_is_the_same_at_every_aspect() {
        let camera = lens(true);
        let right = camera.forward.cross(camera.up).normalize();
        let at = |deg: f32| camera.eye + 50.0 * (camera.forward + right * deg.to_radians().tan());
        for aspect in [2.4, 16.0 / 9.0, 1.0] {
            let x = camera.project(at(31.5), aspect).expect("in front").x;
            assert!((x - 1.0).abs() < 1e-5, "{x}");
        }
    }

    #[test]
    fn depth_is_reversed_and_within_0_and_1() {
        for camera in [lens(true), lens(false)] {
            let depth = |d: f32| {
                let clip = camera.view_proj(1.5) * (camera.eye + camera.forward * d).extend(1.0);
                clip.z / clip.w
            };
            let depths: Vec<f32> = [0.11, 1.0, 10.0, 100.0, 1900.0].map(depth).into();
            assert!(depths.windows(2).all(|d| d[0] > d[1]) && depths[0] <= 1.0 && depths[4] >= 0.0, "{depths:?}");
        }
    }

    #[test]
    fn points_behind_the_camera_are_not_in_the_picture() {
        let camera = lens(true);
        assert_eq!(camera.project(camera.eye - camera.forward * 5.0, 1.0), None);
        assert!(!camera.sees(camera.eye - camera.forward * 5.0, 1.0, 1.0));
        assert!(camera.sees(camera.eye - camera.forward * 5.0, 6.0, 1.0));
    }

    #[test]
    fn a_sphere_is_seen_while_any_of_it_is_in_the_picture() {
        let camera = lens(true);
        let (_, edge) = camera.ray(Vec2::new(1.0, 0.5), 1.5);
        let right = camera.forward.cross(camera.up).normalize();
        let outwards = (right - edge * right.dot(edge)).normalize();
        let on_edge = camera.eye + edge * 30.0;
        assert!(camera.sees(on_edge + outwards * 1.9, 2.0, 1.5));
        assert!(!camera.sees(on_edge + outwards * 2.1, 2.0, 1.5));
    }
}
