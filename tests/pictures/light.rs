//! Tests of light: shadows point away from the sun, lamps shine, no pixel is broken, the picture is reproducible to the bit.

use crate::{pixels::*, place::*};
use codrive::{
    hud::DialView,
    render::{Quality, dial::DialPlace},
    scene::{Camera, Lens, View, ViewKind, ViewOptions},
    units::SpeedUnit,
};
use glam::{DVec2, Vec3};

const SIZE: [u32; 2] = [320, 180];
const KINDS: [ViewKind; 4] = [ViewKind::Driver, ViewKind::Mirror, ViewKind::Birdseye, ViewKind::Chase];

#[test]
fn shadows_fall_away_from_the_sun() {
    // On the meadow beside the road, where the ground is flat and of one colour.
    let pose = on_lane(40.0, 8.0);
    for sun_azimuth_deg in [0.0, 90.0, 130.0, 225.0, 310.0] {
        let options = ViewOptions { sun_azimuth_deg, sun_elevation_deg: 35.0, ..Default::default() };
        let mut view = view(&snapshot(vec![car(1, pose)]), ViewKind::Birdseye, &options);
        view.camera = Camera {
            eye: pose.position.as_vec2().extend(100.0),
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            lens: Lens::Parallel { half_extent_m: 8.0 },
        };
        let image = draw(&view, false, [160, 160]);
        let sun = options.to_sun().truncate().normalize().as_dvec2();
        // The point half a metre outside the car's outline, on the line from its centre towards the sun; the shadow is 2 m long.
        let leaves = (2.5 / sun.dot(pose.forward()).abs()).min(0.9 / sun.dot(pose.left()).abs());
        let at = |side: f64| {
            let point: DVec2 = pose.position + sun * side * (leaves + 0.5);
            let place = view.camera.project(point.as_vec2().extend(0.0), 1.0).expect("in the picture");
            brightness(&image, [place.x, place.y], 2)
        };
        let (sunny, shady) = (at(1.0), at(-1.0));
        assert!(shady < 0.75 * sunny, "sun from {sun_azimuth_deg}: {shady} away from it, {sunny} towards it");
    }
}

#[test]
fn shadows_drawn_in_parts_equal_shadows_drawn_at_once() {
    let mut driving = renderer(true, Quality::LOW);
    let mut differ = Vec::new();
    // The shadow maps of trees follow the camera in steps of 12 and 36 m.
    for metre in 0..60 {
        let mut view = view(&full_ring(), ViewKind::Chase, &Default::default());
        view.camera.eye += view.camera.forward.with_z(0.0).normalize() * metre as f32;
        let there = draw_with(&mut driving, &view, SIZE);
        if metre % 20 == 19 {
            let fresh = draw_with(&mut renderer(true, Quality::LOW), &view, SIZE);
            differ.push(there.pixels().zip(fresh.pixels()).filter(|(a, b)| difference(a, b) > 8).count());
        }
    }
    // A few texels at the edges of a map may differ.
    assert!(differ.iter().all(|count| *count < 40), "{differ:?}");
}

#[test]
fn lit_brake_lamps_are_brighter_and_redder() {
    let red = |braking: bool| {
        let mut leader = car(1, on_lane(5.0 + 6.0, 0.0));
        leader.lamps.brake = braking;
        let image = draw(&view(&snapshot(vec![leader]), ViewKind::Driver, &Default::default()), false, SIZE);
        pixels(&image, |[r, g, b]| r > 0.85 && r > 2.0 * g && r > 2.0 * b).len()
    };
    let (dark, lit) = (red(false), red(true));
    assert!(lit > 30 && dark == 0, "bright red pixels: {dark} unlit, {lit} lit");
}

#[test]
fn more_samples_change_edges_only() {
    let view = view(&full_ring(), ViewKind::Driver, &Default::default());
    let one = draw(&view, false, SIZE);
    let quality = Quality { msaa: 4, ..Quality::LOW };
    let four = draw_with(&mut renderer(false, quality), &view, SIZE);
    let mut changed = 0;
    for (x, y, pixel) in one.enumerate_pixels() {
        if difference(pixel, four.get_pixel(x, y)) <= 24 {
            continue;
        }
        changed += 1;
        let (xs, ys) = (x.saturating_sub(1)..(x + 2).min(SIZE[0]), y.saturating_sub(1)..(y + 2).min(SIZE[1]));
        let around = xs.flat_map(|x| ys.clone().map(move |y| [x, y]));
        // An edge in either picture: one sample may miss a thin object.
        let step =
            |image: &image::RgbaImage, [i, j]: [u32; 2]| difference(image.get_pixel(x, y), image.get_pixel(i, j));
        let contrast = around.map(|at| step(&one, at).max(step(&four, at))).max().unwrap_or(0);
        assert!(contrast > 12, "({x}, {y}) changed in the middle of a surface");
    }
    let share = changed as f32 / (SIZE[0] * SIZE[1]) as f32;
    assert!(share > 0.001 && share < 0.05, "{changed} pixels changed");
}

#[test]
fn every_view_is_well_exposed_and_opaque() {
    let snapshot = full_ring();
    for kind in KINDS {
        let image = draw(&view(&snapshot, kind, &Default::default()), true, SIZE);
        let light: Vec<f32> = image.pixels().map(|p| luminance(rgb(p))).collect();
        let n = light.len() as f32;
        let mean = light.iter().sum::<f32>() / n;
        let sd = (light.iter().map(|l| (l - mean) * (l - mean)).sum::<f32>() / n).sqrt();
        let share = |is: fn(&f32) -> bool| light.iter().filter(|l| is(l)).count() as f32 / n;
        assert!((0.2..0.7).contains(&mean) && sd > 0.08, "{kind:?}: mean {mean}, sd {sd}");
        assert!(share(|l| *l > 0.98) < 0.02, "{kind:?}: burnt out");
        assert!(share(|l| *l < 0.01) < 0.02, "{kind:?}: black");
        assert!(image.pixels().all(|p| p.0[3] == 255), "{kind:?}: a hole in the picture");
    }
}

#[test]
fn the_picture_of_a_view_does_not_depend_on_earlier_pictures() {
    let snapshot = full_ring();
    let views: Vec<View> = KINDS.map(|kind| view(&snapshot, kind, &Default::default())).into();
    let first: Vec<_> = views.iter().map(|view| draw(view, true, [160, 90])).collect();
    let mut other = renderer(true, Quality::LOW);
    for (view, first) in views.iter().zip(&first).rev() {
        assert!(*first == draw(view, true, [160, 90]), "{:?} changed", view.kind);
        assert!(*first == draw_with(&mut other, view, [160, 90]), "{:?} differs in a new renderer", view.kind);
    }
}

#[test]
fn the_dial_changes_its_own_square_only() {
    let mut view = view(&full_ring(), ViewKind::Driver, &Default::default());
    let without = draw(&view, false, SIZE);
    let unit = SpeedUnit::Mph;
    view.dial = Some(DialView::new(4.2, Some((4.4, 3.9, 4.8)), unit, DialView::scale_for(8.0, unit), false));
    let with = draw(&view, false, SIZE);
    let rect = DialPlace::of(&view, SIZE).rect(SIZE);
    let changed: Vec<_> = without.enumerate_pixels().filter(|(x, y, p)| with.get_pixel(*x, *y) != *p).collect();
    assert!(changed.len() > 500, "{} pixels", changed.len());
    for (x, y, _) in changed {
        assert!(rect.expand(1.0).contains(egui::pos2(x as f32 + 0.5, y as f32 + 0.5)), "({x}, {y})");
    }
}

#[test]
fn a_broken_shader_changes_nothing_and_a_valid_one_takes_effect() {
    let view = view(&full_ring(), ViewKind::Driver, &Default::default());
    let mut renderer = renderer(false, Quality::LOW);
    let before = draw_with(&mut renderer, &view, [160, 90]);
    let folder = tempfile::tempdir().expect("a folder");
    let shaders = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    for file in std::fs::read_dir(shaders).expect("shaders") {
        let file = file.expect("a shader").path();
        std::fs::copy(&file, folder.path().join(file.file_name().expect("a name"))).expect("a copy");
    }
    let sky = folder.path().join("sky.wgsl");
    let text = std::fs::read_to_string(&sky).expect("the sky");
    let change = |new: String| std::fs::write(&sky, new).expect("written");

    change(text.replace("return vec4f(light", "return vec4f(lihgt"));
    let message = renderer.reload_shaders_from(folder.path()).expect_err("broken").to_string();
    let line = text.lines().position(|l| l.contains("return vec4f(light")).expect("the line") + 1;
    assert!(message.starts_with(&format!("shaders/sky.wgsl:{line}: ")), "{message}");
    assert!(before == draw_with(&mut renderer, &view, [160, 90]), "the picture changed");

    change(text.replace("fn fragment", "fn elsewhere"));
    let message = renderer.reload_shaders_from(folder.path()).expect_err("no entry point").to_string();
    assert!(message.contains("fragment"), "{message}");
    assert!(before == draw_with(&mut renderer, &view, [160, 90]), "the picture changed");

    change(text.replace("return vec4f(light", "return vec4f(2.0 * light"));
    renderer.reload_shaders_from(folder.path()).expect("whole");
    assert!(before != draw_with(&mut renderer, &view, [160, 90]), "the new shader is not in use");
    change(text);
    renderer.reload_shaders_from(folder.path()).expect("whole");
    assert!(before == draw_with(&mut renderer, &view, [160, 90]), "the old shader is not back");
}
