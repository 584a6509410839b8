//! Model of a vehicle or a person as it is built, before it is stored at the size of a car. In: triangles. Out: [`Model`] and its [`Shape`],
//! metres, in a body's frame: x forward, y left, z up, origin on the ground under the centre.

use crate::scene::mesh::{SurfaceFinish, TriangleList};
use glam::Vec3;

/// Model of a kind as built, at its usual size.
pub(super) struct Model {
    pub triangles: TriangleList,
    pub shape: Shape,
}

/// Positions of a model's wheels and lamps, at its usual size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// Length, width and height, metres.
    pub size: Vec3,
    /// Front and rear axle, metres ahead of the centre.
    pub axles: [f32; 2],
    /// Distance of a wheel's middle to the left of the centre, metres; 0 for vehicles with one track.
    pub track_half: f32,
    /// Radius and width of a wheel, metres.
    pub wheel: [f32; 2],
    /// Positions of the left front and left rear indicator, metres.
    pub indicators: [Vec3; 2],
    /// Radius of an indicator, metres.
    pub indicator_radius: f32,
}

/// Adds a box between two corners.
pub(super) fn block(triangles: &mut TriangleList, low: [f32; 3], high: [f32; 3], finish: SurfaceFinish) {
    let (low, high) = (Vec3::from(low), Vec3::from(high));
    triangles.cuboid((low + high) / 2.0, (high - low) / 2.0, finish);
}
