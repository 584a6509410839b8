//! Area that the shadow maps cover. In: the sun's direction, a camera. Out: squares of ground and their projections.

use crate::render::view_projection::ViewFrustum;
use glam::{Mat4, Vec3, camera::rh};

/// Half width of the map of moving objects for a perspective picture, m: 3.1 cm a texel at 2048.
const MOVING_M: f32 = 32.0;
/// Half widths of the near and the far map of static objects, m: 6 cm and 18 cm a texel at 2048.
const STANDING_M: [f32; 2] = [64.0, 184.0];
/// Grids on which the maps of static objects follow the camera, m.
pub(super) const STEP_M: [f32; 2] = [12.0, 36.0];
/// Additional half depth of all maps beyond their half width, m: covers the highest tree's shadow.
const HEIGHT_M: f32 = 40.0;

/// Square of ground that a map covers, seen from the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShadowCover {
    to_sun: Vec3,
    pub(super) centre: Vec3,
    half_m: f32,
}

/// Returns the ground that the maps cover. For a perspective picture: ahead of the eye, and some way behind it for the
/// mirror. For a parallel picture: all of it.
pub(super) fn covers(to_sun: Vec3, frustum: &ViewFrustum) -> [ShadowCover; 3] {
    let ahead = frustum.camera.forward.with_z(0.0).normalize_or_zero();
    let ground = frustum.camera.eye.with_z(0.0);
    match frustum.parallel_m() {
        None => {
            let standing = |i: usize| {
                let (half_m, step_m) = (STANDING_M[i], STEP_M[i]);
                let centre = ((ground + ahead * (0.45 * half_m)) / step_m).round() * step_m;
                ShadowCover { to_sun, centre, half_m }
            };
            let moving = ShadowCover { to_sun, centre: ground + ahead * (0.5 * MOVING_M), half_m: MOVING_M };
            [moving, standing(0), standing(1)]
        }
        Some(half_m) => [ShadowCover { to_sun, centre: ground, half_m: half_m * 1.2 }; 3],
    }
}

impl ShadowCover {
    pub(super) fn view(&self) -> Mat4 {
        let up = if self.to_sun.z.abs() > 0.99 { Vec3::Y } else { Vec3::Z };
        rh::view::look_to_mat4(Vec3::ZERO, -self.to_sun, up)
    }

    pub(super) fn texel_m(&self, size: u32) -> f32 {
        2.0 * self.half_m / size as f32
    }

    /// Returns the transform from world to map.
    pub(super) fn clip_from_world(&self, size: u32) -> Mat4 {
        self.lens(size) * self.view()
    }

    /// Returns the projection from the sun's view to the map. The centre is rounded to a whole texel, so that edges of
    /// shadows do not crawl while driving.
    pub(super) fn lens(&self, size: u32) -> Mat4 {
        let view = self.view();
        let centre = view.transform_point3(self.centre);
        let texel = self.texel_m(size);
        let [x, y] = [centre.x, centre.y].map(|c| (c / texel).round() * texel);
        let h = self.half_m;
        let (near, far) = (-centre.z - h - HEIGHT_M, -centre.z + h + HEIGHT_M);
        rh::proj::directx::orthographic(x - h, x + h, y - h, y + h, near, far)
    }

    /// Checks whether a map of this ground can stand in for `wanted`: same sun, same width, centre at most `most_m`
    /// away.
    pub(super) fn serves(&self, wanted: &Self, most_m: f32) -> bool {
        self.to_sun == wanted.to_sun
            && self.half_m == wanted.half_m
            && self.centre.distance_squared(wanted.centre) <= most_m * most_m
    }

    pub(super) fn touches(&self, centre: Vec3, radius_m: f32) -> bool {
        let view = self.view();
        let off = (view.transform_point3(centre) - view.transform_point3(self.centre)).abs();
        off.x.max(off.y) < self.half_m + radius_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Lens};

    const TO_SUN: Vec3 = Vec3::new(0.48, 0.36, 0.8);

    fn frustum(eye: Vec3, forward: Vec3, lens: Lens) -> ViewFrustum {
        let up = if forward.z.abs() > 0.5 { Vec3::Y } else { Vec3::Z };
        ViewFrustum::new(&Camera { eye, forward, up, lens }, [640, 360])
    }

    #[test]
    fn the_map_moves_by_whole_texels() {
        let lens = Lens::Perspective { fov_x_rad: 1.1 };
        let light = |x: f32| {
            let [moving, ..] = covers(TO_SUN, &frustum(Vec3::new(x, 0.0, 1.2), Vec3::X, lens));
            moving.clip_from_world(1024)
        };
        let still = Vec3::new(20.0, 3.0, 0.0);
        for step in 1..50 {
            let moved = (light(step as f32 * 0.37).project_point3(still) - light(0.0).project_point3(still)) * 512.0;
            for texels in [moved.x, moved.y] {
                assert!((texels - texels.round()).abs() < 0.02, "moved by {texels} texels");
            }
        }
    }

    #[test]
    fn a_picture_from_above_is_covered_whole() {
        let plan = frustum(Vec3::new(10.0, 5.0, 400.0), Vec3::NEG_Z, Lens::Parallel { half_extent_m: 50.0 });
        for cover in covers(TO_SUN, &plan) {
            for corner in [Vec3::new(95.0, 55.0, 0.0), Vec3::new(-75.0, -45.0, 0.0)] {
                let clip = cover.clip_from_world(1024).project_point3(corner);
                assert!(clip.x.abs() <= 1.0 && clip.y.abs() <= 1.0 && (0.0..=1.0).contains(&clip.z), "{clip}");
                assert!(cover.touches(corner, 0.0));
            }
        }
    }

    #[test]
    fn static_shadow_maps_are_redrawn_only_every_few_metres() {
        let lens = Lens::Perspective { fov_x_rad: 1.1 };
        for (layer, most) in [(1, 10), (2, 4)] {
            let mut places: Vec<ShadowCover> = Vec::new();
            for decimetre in 0..1000 {
                let covers = covers(TO_SUN, &frustum(Vec3::new(decimetre as f32 * 0.1, 0.0, 1.2), Vec3::X, lens));
                if places.last() != Some(&covers[layer]) {
                    places.push(covers[layer]);
                }
            }
            assert!(places.len() <= most, "{} maps in 100 m", places.len());
        }
    }
}
