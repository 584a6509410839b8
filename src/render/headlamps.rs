//! Beams of the headlamps in a picture. In: the vehicles of a view, a camera. Out: the nearest beams for the shaders, each with the vehicle
//! that stands in it.

use super::{
    device::layout::{HeadlampBeam, MOST_BEAMS},
    quality::Quality,
    view_projection::ViewFrustum,
};
use crate::scene::{CarInstance, Headlamps, View};
use glam::Vec3;

/// Distance ahead of the lamps, and radius, of what a beam lights visibly, m.
const POOL_M: [f32; 2] = [25.0, 40.0];
/// Distance beyond which a vehicle in a beam shades nothing that is seen, m.
const SHADING_M: f32 = 60.0;

/// Number of beams that the programs of a quality read.
pub(super) fn most_beams(quality: &Quality) -> usize {
    // On software rendering six beams add half to the cost of a picture.
    if quality.fine { MOST_BEAMS } else { 6 }
}

/// Returns the beams that light the picture, the nearest first; the others are dark.
pub(super) fn beams(view: &View, frustum: &ViewFrustum, most: usize) -> [HeadlampBeam; MOST_BEAMS] {
    let pool = |lamps: &Headlamps| lamps.position + lamps.ahead * POOL_M[0];
    let eye = frustum.camera.eye;
    let mut near: Vec<&Headlamps> =
        view.headlamps.iter().filter(|lamps| frustum.sees(pool(lamps), POOL_M[1])).collect();
    near.sort_by(|a, b| pool(a).distance_squared(eye).total_cmp(&pool(b).distance_squared(eye)));
    // A beam far below everything lights nothing.
    let mut beams = [HeadlampBeam { place: [0.0, 0.0, 1e4, 0.0], ..Default::default() }; MOST_BEAMS];
    for (beam, lamps) in beams.iter_mut().zip(near.into_iter().take(most)) {
        let [distance_m, bearing, half] = shading(lamps, &view.cars).unwrap_or([SHADING_M, 0.0, 0.0]);
        *beam = HeadlampBeam {
            place: lamps.position.extend(distance_m).to_array(),
            ahead: lamps.ahead.extend(bearing).to_array(),
            inner: lamps.inner.extend(half).to_array(),
        };
    }
    beams
}

/// Returns the nearest vehicle in a beam: its distance in metres, and the tangents of its bearing and of half of the angle that it takes.
fn shading(lamps: &Headlamps, cars: &[CarInstance]) -> Option<[f32; 3]> {
    /// Half of a car's length and width, m.
    const HALF_M: [f32; 2] = [2.5, 0.9];
    let found = cars.iter().filter_map(|car| {
        let way = car.position - lamps.position;
        let distance_m = way.dot(lamps.ahead) - HALF_M[0] * car.scale.x;
        let aside_m = way.dot(lamps.inner);
        let is_in_beam = (0.2..SHADING_M).contains(&distance_m) && aside_m.abs() < 0.6 * distance_m + 1.0;
        (is_in_beam && way.dot(Vec3::Z).abs() < 3.0).then_some([
            distance_m,
            aside_m / distance_m,
            HALF_M[1] * car.scale.y / distance_m,
        ])
    });
    found.min_by(|a, b| a[0].total_cmp(&b[0]))
}
