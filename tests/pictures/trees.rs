//! Trees change their level of detail without a jump: as much of the picture is leaves before as after, in one colour.

use crate::place::*;
use codrive::{
    render::{OFFSCREEN, Quality, Renderer, crowd::Detail, lens::Optics},
    scene::{Camera, Lens, Mesh, Stage, TreePlace, View, ViewKind, ViewOptions},
};
use glam::Vec3;

const SIZE: [u32; 2] = [320, 320];

/// The share of the picture that a tree covers over the square of its radius in it, and its mean colour.
fn measured(renderer: &mut Renderer, bare: &mut Renderer, view: &View, radius_px: f32) -> (f32, Vec3) {
    let (with, without) = (draw_with(renderer, view, SIZE), draw_with(bare, view, SIZE));
    let (mut count, mut sum) = (0.0, Vec3::ZERO);
    for (a, b) in with.pixels().zip(without.pixels()) {
        if crate::pixels::difference(a, b) > 12 {
            count += 1.0;
            sum += Vec3::from(crate::pixels::rgb(a));
        }
    }
    (count / (radius_px * radius_px), sum / count)
}

#[test]
fn a_tree_covers_as_much_in_the_same_colour_on_both_sides_of_a_switch_of_detail() {
    let bare = Stage { tree_places: Vec::new(), far_tree_places: Vec::new(), ..stage(true).clone() };
    let bare =
        Stage { road: Mesh::default(), land: Mesh::default(), tuft_places: Vec::new(), posts: Mesh::default(), ..bare };
    let quality = Quality { msaa: 4, fine: true, ..Quality::LOW };
    let mut empty = Renderer::new(gpu(), &bare, OFFSCREEN, quality);
    for kind in 0..bare.trees.len() {
        let (position, tint) = (Vec3::new(300.0, 0.0, 0.0), [1.0; 3]);
        let place = TreePlace { position, yaw_rad: 0.0, scale: 1.0, tint, kind };
        let one = Stage { tree_places: vec![place], tree_grounds: vec![Vec3::Z], ..bare.clone() };
        let mut renderer = Renderer::new(gpu(), &one, OFFSCREEN, quality);
        let (centre, radius_m) = one.trees[kind].bounding_sphere();
        let seen = |radius_px: f32| {
            let mut view =
                view(&snapshot(Vec::new()), ViewKind::Chase, &ViewOptions { wind_mps: 0.0, ..Default::default() });
            view.cars.clear();
            let lens = Lens::Perspective { fov_x_rad: 0.7 };
            let camera = |d: f32| Camera {
                eye: position + centre - Vec3::new(0.7, 0.3, 0.0).normalize() * d,
                forward: Vec3::new(0.7, 0.3, 0.0).normalize(),
                up: Vec3::Z,
                lens,
            };
            let at_1 = Optics::new(&camera(1.0), SIZE).pixels(position + centre, radius_m);
            view.camera = camera(at_1 / radius_px);
            view
        };
        let mut level = |radius_px: f32| {
            let [one, other] = Detail::shares(radius_px);
            assert!(other.is_none(), "{radius_px} px is between two levels");
            (one.expect("a level").0, measured(&mut renderer, &mut empty, &seen(radius_px), radius_px))
        };
        for switch_px in [85.0, 36.0] {
            let (finer, (cover, colour)) = level(switch_px * 1.12);
            let (coarser, (cover_after, colour_after)) = level(switch_px * 0.88);
            assert_ne!(finer, coarser);
            println!("kind {kind}: {finer:?} {cover:.3} {colour:.3}, {coarser:?} {cover_after:.3} {colour_after:.3}");
            let more = cover_after / cover;
            assert!((0.80..1.25).contains(&more), "kind {kind}, {finer:?} to {coarser:?}: {more} times the cover");
            let jump = (colour_after - colour).abs().max_element();
            assert!(jump < 0.05, "kind {kind}, {finer:?} to {coarser:?}: {colour} to {colour_after}");
        }
    }
}

#[test]
fn from_above_at_noon_crowns_are_as_bright_as_the_meadow_and_their_shade_is_not_black() {
    let options = ViewOptions { wind_mps: 0.0, ..Default::default() }.at_hour(12.0);
    let quality = Quality { msaa: 4, fine: true, ..Quality::LOW };
    let land = Stage { tree_places: Vec::new(), far_tree_places: Vec::new(), ..stage(true).clone() };
    let land = Stage { tuft_places: Vec::new(), posts: Mesh::default(), ..land };
    let bare = Stage { road: Mesh::default(), land: Mesh::default(), ..land.clone() };
    // In the ring's middle, 10 m apart; the shade falls northwards, as long as the tree is high.
    let centre = stage(true).centre;
    let mut empty = Renderer::new(gpu(), &bare, OFFSCREEN, quality);
    let mut meadow = Renderer::new(gpu(), &land, OFFSCREEN, quality);
    // An oak, and a spruce, which is darker.
    for (kind, least) in [(0, 0.66), (3, 0.56)] {
        let (position, tint) = (centre.extend(0.0), [1.0; 3]);
        let place = TreePlace { position, yaw_rad: 0.0, scale: 1.0, tint, kind };
        let with = |stage: &Stage| {
            let one = Stage { tree_places: vec![place], tree_grounds: vec![Vec3::Z], ..stage.clone() };
            Renderer::new(gpu(), &one, OFFSCREEN, quality)
        };
        let (mut alone, mut standing) = (with(&bare), with(&land));
        // Near, mid, and the picture from above.
        for half_m in [9.0, 24.0, 60.0] {
            let mut view = view(&snapshot(Vec::new()), ViewKind::Birdseye, &options);
            view.cars.clear();
            view.camera.lens = Lens::Parallel { half_extent_m: half_m };
            view.camera.eye = centre.extend(400.0);
            let crown = (draw_with(&mut alone, &view, SIZE), draw_with(&mut empty, &view, SIZE));
            let ground = (draw_with(&mut standing, &view, SIZE), draw_with(&mut meadow, &view, SIZE));
            let (mut on_crown, mut on_shade, mut in_sun) = (Vec::new(), Vec::new(), Vec::new());
            for (x, y, p) in ground.0.enumerate_pixels() {
                let light = crate::pixels::luminance(crate::pixels::rgb(p));
                let differs = |pair: &(image::RgbaImage, image::RgbaImage)| {
                    crate::pixels::difference(pair.0.get_pixel(x, y), pair.1.get_pixel(x, y)) > 12
                };
                match (differs(&crown), differs(&ground)) {
                    (true, _) => on_crown.push(light),
                    (false, true) => on_shade.push(light),
                    (false, false) => in_sun.push(light),
                }
            }
            let mean = |all: &[f32]| all.iter().sum::<f32>() / all.len() as f32;
            on_crown.sort_by(f32::total_cmp);
            let sunny = mean(&on_crown[on_crown.len() / 2..]);
            let [crown, shade, grass] = [&on_crown, &on_shade, &in_sun].map(|all| mean(all));
            println!("kind {kind}, {half_m} m: crown {crown:.3}, sunny {sunny:.3}, shade {shade:.3}, grass {grass:.3}");
            // On the screen's scale: 0.85 of it is 0.7 of the light.
            assert!(crown > least * grass, "kind {kind}, {half_m} m: a crown of {crown} over grass of {grass}");
            assert!(sunny > (least + 0.17) * grass, "kind {kind}, {half_m} m: {sunny} in the sun, grass {grass}");
            assert!((0.38..0.65).contains(&(shade / grass)), "kind {kind}, {half_m} m: shade {shade}, grass {grass}");
        }
    }
}
