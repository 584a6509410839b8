//! Beams of the headlamps in a picture. In: the vehicles of a view, a camera. Out: the ego's and the nearest beams for the shaders, each with
//! the vehicle that stands in it.

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

/// Share of the distance to the first beam that is left out over which the last ones fade.
const FADING: f32 = 0.25;

/// Number of beams that the programs of a quality read.
pub(super) fn most_beams(quality: &Quality) -> usize {
    // On software rendering six beams add half to the cost of a picture.
    if quality.fine { MOST_BEAMS } else { 6 }
}

/// Returns the beams that light the picture, the ego's and then the nearest; the others are dark.
pub(super) fn beams(view: &View, frustum: &ViewFrustum, most: usize) -> [HeadlampBeam; MOST_BEAMS] {
    nearest(&view.headlamps, &view.cars, frustum, most)
}

fn nearest(
    headlamps: &[Headlamps],
    cars: &[CarInstance],
    frustum: &ViewFrustum,
    most: usize,
) -> [HeadlampBeam; MOST_BEAMS] {
    let eye = frustum.camera.eye;
    let found = headlamps.iter().enumerate().filter_map(|(k, lamps)| {
        let pool = lamps.position + lamps.ahead * POOL_M[0];
        // The ego's own, the first, are never left out.
        let distance_m = if k == 0 { 0.0 } else { pool.distance(eye) };
        frustum.sees(pool, POOL_M[1]).then_some((distance_m, lamps))
    });
    let mut near: Vec<(f32, &Headlamps)> = found.collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A beam that is about to be left out has already faded, so that no light appears or vanishes at once.
    let end_m = near.get(most).map_or(f32::INFINITY, |(distance_m, _)| *distance_m);
    let share = |distance_m: f32| ((1.0 - distance_m / end_m) / FADING).clamp(0.0, 1.0);
    // Without a share of its light a beam lights nothing.
    let mut beams = [HeadlampBeam::default(); MOST_BEAMS];
    for (beam, (away_m, lamps)) in beams.iter_mut().zip(near.into_iter().take(most)) {
        let [distance_m, bearing, half] = shading(lamps, cars).unwrap_or([SHADING_M, 0.0, 0.0]);
        *beam = HeadlampBeam {
            place: lamps.position.extend(distance_m).to_array(),
            ahead: lamps.ahead.extend(bearing).to_array(),
            inner: lamps.inner.extend(half).to_array(),
            share: [share(away_m), f32::from(u8::from(lamps.is_main)), 0.0, 0.0],
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Lens};

    #[test]
    fn the_egos_and_the_nearest_beams_are_lit_and_the_last_have_faded() {
        let camera = Camera {
            eye: Vec3::new(-POOL_M[0], 0.0, 1.2),
            forward: Vec3::X,
            up: Vec3::Z,
            lens: Lens::Perspective { fov_x_rad: 1.0 },
        };
        let frustum = ViewFrustum::new(&camera, [320, 180]);
        let away_m = |k: usize| 10.0 * k as f32;
        let lamps = |k: usize| Headlamps {
            position: Vec3::new(away_m(k), 0.0, 0.7),
            ahead: Vec3::X,
            inner: Vec3::Y,
            is_main: false,
        };
        // In no order but for the ego's.
        let all: Vec<Headlamps> = [9, 5, 1, 7, 3, 8, 2, 6, 4].map(lamps).to_vec();
        let places =
            |headlamps: &[Headlamps]| nearest(headlamps, &[], &frustum, 6).map(|beam| (beam.place[0], beam.share[0]));
        let lit = places(&all);
        assert_eq!(lit[0], (away_m(9), 1.0), "the ego's own");
        for (k, (x_m, share)) in lit.into_iter().enumerate().take(6).skip(1) {
            assert_eq!(x_m, away_m(k));
            // Pools lie 50 m further from the eye than their lamps from 0; the first that is left out is the sixth.
            let wanted = ((1.0 - (50.0 + x_m) / (50.0 + away_m(6))) / FADING).clamp(0.0, 1.0);
            assert!((share - wanted).abs() < 1e-2, "{k}: {share}, not {wanted}");
        }
        assert!(lit[1].1 == 1.0 && lit[5].1 < 0.4, "{lit:?}");
        assert!(lit[6..].iter().all(|(_, share)| *share == 0.0), "{lit:?}");
        assert!(places(&all[..6])[..6].iter().all(|(_, share)| *share == 1.0), "nothing is left out");
    }
}
