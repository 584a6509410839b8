//! Tests of light and passes by numbers: a grey card in daylight as the literature gives it, shadows that stay on the ground, lamps, and no
//! new resources while driving. In: small scenes and cameras for each question. Out: properties of the pixels.

use super::{pixels::difference, place::*};
use codrive::{
    render::{OFFSCREEN, Quality, Renderer, sky::atmosphere::Sky},
    scene::{Camera, CarModel, Lens, Mesh, StaticScene, Vertex, View, ViewKind, ViewOptions},
};
use glam::{Quat, Vec3};
use image::RgbaImage;
use std::sync::Arc;

/// Returns the light of a pixel before the tone curve and after exposure: the inverse of `tonemap.wgsl`.
fn light_of(pixel: [f32; 3]) -> Vec3 {
    let (spill, taken_back, steep, middle) = (0.020, 0.016, 1.08, 0.26);
    let seen = Vec3::from(pixel);
    let curved = seen * (1.0 - 3.0 * taken_back) + taken_back * seen.element_sum();
    let mixed = curved.to_array().map(|y| middle * (y / (1.0 - y)).powf(1.0 / steep));
    // Forward, each colour kept all but two shares of itself and took one share of each of the other two.
    let sum: f32 = mixed.iter().sum();
    Vec3::from(mixed.map(|m| (m - spill * sum) / (1.0 - 3.0 * spill)))
}

/// Returns the mean light in a square of `2 * half + 1` pixels around a point of the world.
pub fn light_at(image: &RgbaImage, view: &View, point: Vec3, half: i32) -> Vec3 {
    let (width, height) = (image.width() as f32, image.height() as f32);
    let at = view.camera.project(point, width / height).expect("in the picture");
    let (cx, cy) = ((at.x * width) as i32, (at.y * height) as i32);
    let mut sum = Vec3::ZERO;
    for y in cy - half..=cy + half {
        for x in cx - half..=cx + half {
            sum += light_of([0, 1, 2].map(|i| f32::from(image.get_pixel(x as u32, y as u32).0[i]) / 255.0));
        }
    }
    sum / ((2 * half + 1) * (2 * half + 1)) as f32
}

/// Adds a level, upward-facing square of matt grey.
fn card(mesh: &mut Mesh, centre: Vec3, half_m: f32, grey: f32) {
    let first = mesh.vertices.len() as u32;
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        mesh.vertices.push(Vertex {
            position: (centre + Vec3::new(x, y, 0.0) * half_m).to_array(),
            normal: [0.0, 0.0, 1.0],
            colour: [grey; 3],
            ..Default::default()
        });
    }
    mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
}

/// Sets the camera to a plan of 16 m around `at`, from 3 m above it.
fn from_above(view: &mut View, at: Vec3) {
    view.camera = Camera {
        eye: at + Vec3::Z * 3.0,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        lens: Lens::Parallel { half_extent_m: 8.0 },
    };
}

/// Luminance of linear red, green and blue (Rec. 709).
pub const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Light on a level white sheet by closed forms of the literature, in units of radiance.
struct Daylight {
    sun: Vec3,
    sky: Vec3,
}

impl Daylight {
    /// Returns the daylight with the sun at `to_sun`, in air that leaves 2 % of a contrast at `visibility_m`. Red, green and blue stand for
    /// 680, 550 and 440 nm.
    fn of_the_books(to_sun: Vec3, visibility_m: f32) -> Self {
        // Light on a sheet that faces the sun above the atmosphere, on the scale of this scene.
        const ABOVE: Vec3 = Vec3::new(1.56, 1.70, 1.86);
        // Ozone of 300 Dobson units. Haze as in this scene: colour, scattered share, and scale height in km.
        const OZONE: Vec3 = Vec3::new(0.011, 0.027, 0.001);
        const HAZE: Vec3 = Vec3::new(0.95, 1.0, 1.06);
        const SCATTERED: f32 = 0.92;
        let haze_km = 1.2 * (visibility_m / 12_000.0).clamp(0.2, 1.0);
        // Optical depth of clean air (Hansen and Travis 1974, Light scattering in planetary atmospheres, equation 2.30, at 1013 hPa). Haze
        // by Koschmieder 1924: the extinction of all air at the ground is 3.912 over the visibility, of which clean air is 0.0116 per
        // kilometre, its depth at 550 nm over its scale height of 8.4 km.
        let clean = Vec3::from([0.68f32, 0.55, 0.44].map(|um| {
            let per = um.powi(-2);
            0.008_569 * per * per * (1.0 + 0.0113 * per + 0.000_13 * per * per)
        }));
        let haze = HAZE * ((3.912 / (visibility_m / 1000.0) - 0.0116) * haze_km);
        // Air mass by Kasten and Young 1989 (Applied Optics 28, 4735, equation 3).
        let zenith_deg = 90.0 - to_sun.z.asin().to_degrees();
        let mass = 1.0 / (to_sun.z + 0.505_72 * (96.079_95 - zenith_deg).powf(-1.6364));
        let through = |depth: Vec3| (-depth * mass).exp();
        let sun = ABOVE * to_sun.z * through(clean + haze + OZONE);
        // Half of the light scattered by clean air comes down. Of the light scattered by haze, the share that comes down falls with the sun
        // (Davies and Hay 1979, as in Bird and Hulstrom 1981, SERI/TR-642-761; the shares are Robinson's of 1962). The table lists that
        // share by the sun's zenith angle in degrees.
        const DOWN: [(f32, f32); 10] = [
            (0.0, 0.92),
            (25.8, 0.91),
            (36.9, 0.89),
            (45.6, 0.86),
            (53.1, 0.83),
            (60.0, 0.78),
            (66.4, 0.71),
            (72.5, 0.67),
            (78.5, 0.60),
            (90.0, 0.60),
        ];
        let next = DOWN.iter().position(|(deg, _)| *deg > zenith_deg).expect("the sun is up");
        let [(low, from), (high, to)] = [DOWN[next - 1], DOWN[next]];
        let down = from + (to - from) * (zenith_deg - low) / (high - low);
        let by_air = 0.5 * (1.0 - through(clean)) * through(haze);
        let by_haze = SCATTERED * down * (1.0 - through(haze)) * through(clean);
        let sky = ABOVE * to_sun.z * through(OZONE) * (by_air + by_haze);
        // The sky returns part of the light reflected by the land, repeatedly: clean air 0.0685 of it, haze the share that it scatters
        // upwards (the same model).
        let land = Vec3::new(0.115, 0.135, 0.065);
        let returned = land * (0.0685 + SCATTERED * (1.0 - down) * (1.0 - through(haze)));
        Self { sun, sky: sky + (sun + sky) * returned / (1.0 - returned) }
    }

    /// Returns the exposure of a plan, which leaves some of the evening's darkness: 1.908 over the luminance of daylight to the power of
    /// 0.85.
    fn exposure(&self) -> f32 {
        1.908 * (self.sun + self.sky).dot(LUMINANCE).powf(-0.85)
    }
}

#[test]
fn a_grey_card_has_the_brightness_of_daylight_in_sun_and_shade() {
    const GREY: f32 = 0.18;
    for (time_h, visibility_m) in [(9.75, 30_000.0), (7.0, 30_000.0), (14.0, 8000.0)] {
        let options = ViewOptions { visibility_m, ..ViewOptions::default() }.at_hour(time_h);
        let to_sun = options.to_sun();
        // A card above the bonnet, and above the camera a roof that shades part of the card.
        let mut cards = Mesh::default();
        card(&mut cards, Vec3::Z * 1.2, 6.0, GREY);
        let height = 6.0;
        let pose = on_lane(40.0, 0.0);
        let body_from_world = Quat::from_rotation_z(-pose.yaw_rad as f32);
        card(&mut cards, Vec3::Z * 1.2 + body_from_world * to_sun * (height / to_sun.z), 1.5, GREY);
        let cards = Arc::new(cards);
        let levels = [cards.clone(), cards.clone(), cards.clone()];
        let model = CarModel { levels, glass: Default::default(), plan: cards.clone(), shade: cards, postures: None };
        let static_scene =
            StaticScene { cars: vec![model; static_scene(false).cars.len()], ..static_scene(false).clone() };
        let mut view = view(&snapshot(vec![car(1, pose)]), ViewKind::Birdseye, &options);
        let middle = pose.position.as_vec2().extend(1.2);
        from_above(&mut view, middle);
        let mut renderer = Renderer::new(gpu(), &static_scene, OFFSCREEN, Quality::LOW);
        let image = draw_with(&mut renderer, &view, [160, 160]);

        let sky = Sky::new(to_sun, visibility_m, false);
        // Integrates the upper hemisphere on a fine grid of height and bearing, independently of the renderer's harmonics.
        let mut from_sky = Vec3::ZERO;
        let (n, m) = (60, 90);
        for i in 0..n {
            let z = (i as f32 + 0.5) / n as f32;
            for j in 0..m {
                let (sin, cos) = (std::f32::consts::TAU * j as f32 / m as f32).sin_cos();
                let level = (1.0 - z * z).sqrt();
                from_sky += sky.radiance(Vec3::new(level * cos, level * sin, z)) * z * (2.0 / (n * m) as f32);
            }
        }
        let exposure = sky.plan_exposure();
        let sunny = exposure * GREY * (from_sky + sky.sun * to_sun.z);
        let shady = exposure * GREY * from_sky;
        let away = Vec3::new(-to_sun.y, to_sun.x, 0.0).normalize() * 4.5;
        let books = Daylight::of_the_books(to_sun, visibility_m);
        let places = [(middle + away, sunny, books.sun + books.sky, "sun"), (middle, shady, books.sky, "shade")];
        for (place, handed, level, name) in places {
            let seen = light_at(&image, &view, place, 3);
            // Tolerance for the renderer's use of its own sky: less than the eye can tell apart.
            let error = (seen / handed - 1.0).dot(LUMINANCE);
            assert!(error.abs() < 0.05, "{time_h} h, {name}: {seen}, not {handed}");
            // Tolerance against the literature: a third of a stop, the step of a light meter.
            let wanted = books.exposure() * GREY * level;
            let stops = (seen.dot(LUMINANCE) / wanted.dot(LUMINANCE)).log2();
            println!("{time_h} h, {name}: {seen:.3}, by the books {wanted:.3}, {stops:+.2} stops");
            assert!(stops.abs() < 1.0 / 3.0, "{time_h} h, {name}: {seen}, by the books {wanted}: {stops:+.2} stops");
        }
    }
}

#[test]
fn black_walls_in_fog_fade_as_koschmieders_law_says() {
    const VISIBILITY_M: f32 = 100.0;
    // Walls ahead of the camera, side by side in the picture. The furthest shows nothing but fog.
    const AWAY_M: [f32; 4] = [20.0, 50.0, 100.0, 400.0];
    let walls = [0, 1, 2, 3].map(|k| (Vec3::new(1.0, 0.12 * (k as f32 - 1.5), 0.0) * AWAY_M[k]).with_z(1.5));
    let mut static_scene = static_scene(false).clone();
    (static_scene.road, static_scene.land) = (Mesh::default(), Mesh::default());
    for (middle, away_m) in walls.into_iter().zip(AWAY_M) {
        let first = static_scene.road.vertices.len() as u32;
        card(&mut static_scene.road, middle, 0.05 * away_m, 0.0);
        for v in &mut static_scene.road.vertices[first as usize..] {
            // The level card, set upright and facing the camera.
            let [x, y, z] = v.position;
            v.position = [middle.x, y, z + (x - middle.x)];
            v.normal = [-1.0, 0.0, 0.0];
            v.material = codrive::scene::Material::Paint as u32;
        }
    }
    let options = ViewOptions { visibility_m: VISIBILITY_M, ..ViewOptions::default() };
    let mut view = view(&snapshot(vec![]), ViewKind::Chase, &options);
    view.camera =
        Camera { eye: Vec3::Z * 1.5, forward: Vec3::X, up: Vec3::Z, lens: Lens::Perspective { fov_x_rad: 0.5 } };
    let mut renderer = Renderer::new(gpu(), &static_scene, OFFSCREEN, Quality::LOW);
    let image = draw_with(&mut renderer, &view, [320, 180]);
    let light = walls.map(|wall| light_at(&image, &view, wall, 2).dot(LUMINANCE));
    for (light_there, away_m) in light.into_iter().zip(AWAY_M) {
        let veiled = light_there / light[3];
        // At the visibility 2 % of a contrast is left.
        let expected = 1.0 - 0.02f32.powf(away_m / VISIBILITY_M);
        // The eye tells a contrast of 2 % apart, in the middle of the scale one of the picture's 256 levels is as much.
        assert!((veiled - expected).abs() < 0.03, "{away_m} m: {veiled} of the fog's light, not {expected}");
    }
    // Fog has no horizon: the sky above the furthest wall is lighter only as an overcast sky is (docs/references.md: fog). A contrast below 5 % is
    // not seen by the definition of the meteorological range.
    let up = 0.06;
    let above = light_at(&image, &view, walls[3] + Vec3::Z * up * AWAY_M[3], 2).dot(LUMINANCE);
    assert!((above / light[3] - (1.0 + 2.0 * up)).abs() < 0.05, "{above} above, {} on the wall", light[3]);
}

#[test]
fn a_car_200_m_away_in_fog_of_60_m_cannot_be_told_from_the_fog() {
    // Of its contrast 2 % to the power of 200 over 60 is left, two millionths (Koschmieder 1924).
    let options = ViewOptions { visibility_m: 60.0, ..ViewOptions::default() };
    let pose = on_lane(60.0, 0.0);
    let mut with = view(&snapshot(vec![car(1, pose)]), ViewKind::Chase, &options);
    // A long lens shows the car so large that it has panes to look through. A metre above the windows it looks down a little.
    let middle = pose.position.as_vec2().extend(1.0);
    let forward = (pose.forward().as_vec2().extend(-0.005)).normalize();
    let lens = Lens::Perspective { fov_x_rad: 0.02 };
    with.camera = Camera { eye: middle - forward * 200.0, forward, up: Vec3::Z, lens };
    let clear = View { visibility_m: 30_000.0, ..with.clone() };
    for fine in [false, true] {
        let quality = Quality { fine, ..Quality::LOW };
        let mut renderer = Renderer::new(gpu(), static_scene(false), OFFSCREEN, quality);
        let mut differing = |with: &View, least: u8| {
            let without = View { cars: Vec::new(), ..with.clone() };
            let [with, without] = [with, &without].map(|view| draw_with(&mut renderer, view, [320, 180]));
            with.pixels().zip(without.pixels()).filter(|(a, b)| difference(a, b) > least).count()
        };
        assert!(differing(&clear, 20) > 3000, "the car is in the picture");
        // One of the picture's 256 levels, for rounding.
        assert_eq!(differing(&with, 1), 0, "pixels of the car in fog, fine: {fine}");
    }
}

#[test]
fn edges_of_shadows_stay_on_the_ground_while_the_camera_drives() {
    // A parked car on uniform grey ground, the sun from the side, and a camera that drives towards the car and weaves.
    let pose = on_lane(40.0, 0.0);
    let (along, left) = (pose.forward().as_vec2().extend(0.0), pose.left().as_vec2().extend(0.0));
    let to_sun = (left * 0.75 + Vec3::Z).normalize();
    let mut static_scene = static_scene(false).clone();
    let middle = pose.position.as_vec2().extend(0.0);
    static_scene.road = Mesh::default();
    static_scene.land = Mesh::default();
    card(&mut static_scene.road, middle, 90.0, 0.18);
    for v in &mut static_scene.road.vertices {
        v.material = codrive::scene::Material::Paint as u32;
    }
    let mut renderer = Renderer::new(gpu(), &static_scene, OFFSCREEN, Quality::MEDIUM);
    let size = [480, 270];
    let mut edges = Vec::new();
    for frame in 0..60 {
        let mut view = view(&snapshot(vec![car(1, pose)]), ViewKind::Chase, &ViewOptions::default());
        let step = frame as f32;
        let eye = middle - along * (13.0 - 0.071 * step) + left * (0.3 * (0.2 * step).sin() - 1.2) + Vec3::Z * 2.2;
        let forward = (middle - left * 1.2 - eye).normalize();
        view.camera = Camera { eye, forward, up: Vec3::Z, lens: Lens::Perspective { fov_x_rad: 0.5 } };
        view.to_sun = to_sun;
        let image = draw_with(&mut renderer, &view, size);
        // From the shadowed side of the car outwards: the place where the light is half way from shade to sun.
        let at = |out: f32| middle - left * out;
        let light = |out: f32| light_at(&image, &view, at(out), 0).y;
        let (shade, sun) = (light(1.3), light(2.9));
        assert!(shade < 0.6 * sun, "frame {frame}: {shade} {sun}");
        let half = 0.5 * (shade + sun);
        let steps: Vec<f32> = (0..=160).map(|k| 1.3 + 0.01 * k as f32).collect();
        let edge = steps.iter().find(|out| light(**out) > half).expect("an edge");
        edges.push(*edge);
    }
    let mean = edges.iter().sum::<f32>() / 60.0;
    let worst = edges.iter().map(|edge| (edge - mean).abs()).fold(0.0, f32::max);
    // At the edge a pixel is 1.4 cm wide and a texel of the shadow map 3.1 cm.
    assert!(worst < 0.03, "the edge at {mean} m wanders by {worst} m: {edges:?}");
}

#[test]
fn a_lit_brake_lamp_at_60_m_is_several_times_as_bright_as_a_running_one() {
    let red = |braking: bool| {
        // Straight ahead with the ego's heading, whatever the course of the road, so that the rear is in view.
        let ego = on_lane(0.0, 0.0);
        let at = ego.position + ego.forward() * 62.0;
        let mut leader = car(1, codrive::space::Pose::new(at, ego.yaw_rad));
        leader.lamps.brake = braking;
        let view = view(&snapshot(vec![leader]), ViewKind::Driver, &marked_green());
        let image = draw(&view, false, [1280, 720]);
        let centre = view.camera.project(at.as_vec2().extend(0.8), 1280.0 / 720.0).expect("ahead");
        let (cx, cy) = ((centre.x * 1280.0) as i32, (centre.y * 720.0) as i32);
        let mut best = 0f32;
        for y in cy - 20..cy + 20 {
            for x in cx - 30..cx + 30 {
                let p = image.get_pixel(x as u32, y as u32).0.map(|v| f32::from(v) / 255.0);
                let light = light_of([p[0].min(0.995), p[1], p[2]]);
                best = best.max(light.x - light.y);
            }
        }
        best
    };
    let (running, lit) = (red(false), red(true));
    println!("{lit} lit, {running} running");
    // More than the 5 to 1 that UN Regulation 148 (01 series, 2022; Regulation 7 before) requires in 4.8.3.5. The screen's white limits the
    // scale.
    assert!(lit > 6.0 * running, "{lit} lit, {running} running");
}

/// Returns options without red cars: all other vehicles are green.
fn marked_green() -> ViewOptions {
    ViewOptions { ordinary_paints: false, ..Default::default() }
}

#[test]
fn driving_makes_no_more_pipelines_buffers_or_textures() {
    // A separate device, as other tests create resources on the shared one.
    let gpu = codrive::render::Gpu::headless().unwrap_or_else(|e| panic!("{e}"));
    let mut renderer = Renderer::new(&gpu, static_scene(true), OFFSCREEN, Quality::LOW);
    let size = [160, 90];
    let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: OFFSCREEN,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let target = target.create_view(&Default::default());
    let mut drive = |frames: std::ops::Range<u32>| {
        for frame in frames {
            let mut snapshot = full_ring();
            let pose = on_lane(f64::from(frame) * 3.0, 0.0);
            snapshot.ego.position = pose.position.extend(0.0);
            snapshot.ego.rotation = Quat::from_rotation_z(pose.yaw_rad as f32);
            snapshot.ego_before = snapshot.ego;
            let mut view = view(&snapshot, ViewKind::Driver, &ViewOptions::default());
            let unit = codrive::units::SpeedUnit::Mph;
            let (scale, speed) = (codrive::hud::DialView::scale_for(8.0, unit), 4.0 + 0.01 * f64::from(frame));
            view.dial = Some(codrive::hud::DialView::new(speed, Some((4.4, 3.9, 4.8)), unit, scale, false));
            renderer.draw(&view, None, &target, size);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device");
        }
        let report = gpu.instance.generate_report().expect("a native device").hub;
        [
            report.render_pipelines,
            report.shader_modules,
            report.buffers,
            report.textures,
            report.texture_views,
            report.bind_groups,
            report.samplers,
        ]
        .map(|registry| registry.num_kept_from_user)
    };
    let before = drive(0..10);
    // In 240 m every shadow map is redrawn several times.
    assert_eq!(drive(10..90), before, "pipelines, modules, buffers, textures, views, groups, samplers");
}
