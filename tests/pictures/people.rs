//! Tests of people between two phases of their gait: the picture and the shadow of a blended posture.

use crate::{pixels::difference, place::*};
use codrive::{
    render::{OFFSCREEN, Quality, Renderer},
    scene::{Camera, Lens, Mesh, StaticScene, ViewKind, ViewOptions},
};
use glam::Vec3;
use image::RgbaImage;

const SIZE: [u32; 2] = [240, 180];

#[test]
fn a_blended_posture_is_drawn_with_its_shadow_where_its_model_is() {
    let bare = StaticScene { posts: Mesh::default(), tuft_places: Vec::new(), ..static_scene(false).clone() };
    let mut drawing = Renderer::new(gpu(), &bare, OFFSCREEN, Quality { msaa: 4, fine: true, ..Quality::LOW });
    let pose = on_lane(40.0, 0.0);
    let mut picture = |style: usize, shares: [u16; 2]| -> RgbaImage {
        let mut view = view(&snapshot(vec![car(1, pose)]), ViewKind::Chase, &ViewOptions::default());
        view.cars.retain(|car| !car.is_ego);
        let person = &mut view.cars[0];
        // `shaders/posture.wgsl`: share of the next phase, and 256 times that of standing.
        (person.style, person.plate) = (style, shares[0] + 256 * shares[1]);
        let forward = Vec3::new(0.8, -0.5, -0.3).normalize();
        let eye = person.position + Vec3::Z - forward * 5.0;
        view.camera = Camera { eye, forward, up: Vec3::Z, lens: Lens::Perspective { fov_x_rad: 0.7 } };
        draw_with(&mut drawing, &view, SIZE)
    };
    let differing =
        |a: &RgbaImage, b: &RgbaImage| a.pixels().zip(b.pixels()).filter(|(a, b)| difference(a, b) > 3).count();
    let standing: Vec<usize> = (0..bare.cars.len()).filter(|&s| bare.cars[s].postures == Some([s, s])).collect();
    // A bicycle and four builds on foot.
    assert_eq!(standing.len(), 5);
    for first in [standing[0], standing[2]] {
        let at = first + 2;
        let [next, stands] = bare.cars[at].postures.expect("a person");
        assert_eq!((next, stands), (at + 1, first));
        let [here, after, still] = [at, next, first].map(|style| picture(style, [0, 0]));
        assert!(differing(&here, &after) > 100 && differing(&here, &still) > 300, "postures differ");
        assert_eq!(differing(&picture(at, [255, 0]), &after), 0, "the whole way to the next phase");
        assert_eq!(differing(&picture(at, [100, 255]), &still), 0, "standing");
        let between = picture(at, [128, 0]);
        assert!(differing(&between, &here) > 30 && differing(&between, &after) > 30, "half of the way");
    }
}
