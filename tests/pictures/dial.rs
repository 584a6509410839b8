//! Tests of the speedometer by its pixels: the participant reads the values of the simulation.

#[path = "dial_automation.rs"]
mod automation;

use codrive::{
    hud::{DialView, Palette, Rgb},
    map::{Manoeuvre, NextManoeuvre},
    render::{
        Gpu, OFFSCREEN,
        dial::{DialPass, DialPlace, layout},
        post::ui_pass::{OverlayTarget, UiPass},
    },
    snapshot::TaskPicture,
    units::SpeedUnit,
};

const FORMAT: wgpu::TextureFormat = OFFSCREEN;

fn headless() -> &'static Gpu {
    Gpu::shared().expect("an adapter")
}

/// Square picture that the dial fills, on a uniform background.
struct Picture {
    side: u32,
    rgba: Vec<u8>,
}

const BACKGROUND: wgpu::Color = wgpu::Color { r: 0.45, g: 0.55, b: 0.65, a: 1.0 };

fn draw(dial: &DialView, palette: Palette, side: u32) -> Picture {
    draw_all(Some(dial), TaskPicture::None, None, palette, side)
}

/// Draws the dial, the secondary task and the square for a photodiode, each if given.
fn draw_all(dial: Option<&DialView>, task: TaskPicture, patch: Option<bool>, palette: Palette, side: u32) -> Picture {
    let Gpu { device, queue, .. } = headless();
    let size = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(BACKGROUND), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
    let mut pass = DialPass::new(device, FORMAT);
    pass.place = DialPlace { across: 0.5, diameter_share: 1.0, margin_share: 0.0 };
    pass.palette = palette;
    let target = OverlayTarget { device, queue, encoder: &mut encoder, view: &view, size: [side, side], stamps: None };
    pass.draw(target, dial, task, patch);

    let bytes_per_row = (side * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(bytes_per_row * side),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        size,
    );
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("polled");
    let mapped = buffer.get_mapped_range(..).expect("a range");
    let rgba = mapped.chunks(bytes_per_row as usize).flat_map(|row| row[..side as usize * 4].to_vec()).collect();
    Picture { side, rgba }
}

impl Picture {
    /// Returns the interpolated colour at an angle (degrees clockwise from 12 o'clock) and a share of the dial's radius.
    fn polar(&self, angle_deg: f64, radius: f64) -> [f64; 3] {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let middle = f64::from(self.side) / 2.0;
        // Centres of pixels lie at halves.
        let (x, y) = (middle + radius * middle * sin - 0.5, middle - radius * middle * cos - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let mut sum = [0.0; 3];
        for (dx, dy, weight) in
            [(0, 0, (1.0 - fx) * (1.0 - fy)), (1, 0, fx * (1.0 - fy)), (0, 1, (1.0 - fx) * fy), (1, 1, fx * fy)]
        {
            let i = ((y as usize + dy) * self.side as usize + x as usize + dx) * 4;
            for (part, sum) in sum.iter_mut().enumerate() {
                *sum += weight * f64::from(self.rgba[i + part]);
            }
        }
        sum
    }

    /// Returns the mean of a measure of colour between two radii, at one angle.
    fn along(&self, angle_deg: f64, (outer, inner): (f32, f32), measure: impl Fn([f64; 3]) -> f64) -> f64 {
        let radii = (0..=20).map(|i| f64::from(inner) + f64::from(outer - inner) * f64::from(i) / 20.0);
        radii.map(|radius| measure(self.polar(angle_deg, radius))).sum::<f64>() / 21.0
    }

    /// Returns the angle of the pixels that the measure selects between two radii: their centre of gravity over the whole turn, degrees.
    fn angle_of(&self, radii: (f32, f32), measure: impl Fn([f64; 3]) -> f64) -> Option<f64> {
        let weights = sweep().map(|angle| (angle, self.along(angle, radii, &measure)));
        let (weight, moment) = weights.fold((0.0, 0.0), |(sum, moment), (angle, w)| (sum + w, moment + w * angle));
        (weight > 1.0).then_some(moment / weight)
    }

    /// Counts the pixels of exactly this colour.
    fn count(&self, colour: Rgb) -> usize {
        self.rgba.chunks(4).filter(|pixel| pixel[..3] == colour).count()
    }

    /// Counts the pixels of exactly this colour on the hub, which shows the number.
    fn count_on_hub(&self, colour: Rgb) -> usize {
        let side = self.side as usize;
        let on_hub = |i: usize| {
            let [dx, dy] = [i % side, i / side].map(|at| (2.0 * at as f32 + 1.0) / side as f32 - 1.0);
            dx.hypot(dy) < layout::HUB - 0.02
        };
        let lit = self.rgba.chunks(4).enumerate().filter(|(_, pixel)| pixel[..3] == colour);
        lit.filter(|&(i, _)| on_hub(i)).count()
    }

    /// Writes the picture to the folder in `CODRIVE_PICTURES`, if set, for visual inspection.
    fn save(&self, name: &str) {
        if let Ok(folder) = std::env::var("CODRIVE_PICTURES") {
            let path = std::path::Path::new(&folder).join(name);
            let colour = image::ExtendedColorType::Rgba8;
            image::save_buffer(path, &self.rgba, self.side, self.side, colour).expect("saved");
        }
    }
}

/// Returns the angles of the whole turn from 6 o'clock to 6 o'clock in steps of 0.1 degrees.
fn sweep() -> impl Iterator<Item = f64> {
    (-1800..1800).map(|tenth| f64::from(tenth) / 10.0)
}

/// Returns the share of white, 0 to 1. Outside the hub only the needle is white; numerals are slightly darker and do not count.
fn white([r, g, b]: [f64; 3]) -> f64 {
    ((r.min(g).min(b) - 210.0) / 45.0).max(0.0)
}

/// Returns the share of red, 0 to 1.
fn red([r, g, b]: [f64; 3]) -> f64 {
    ((r - g.max(b)) / 207.0).max(0.0)
}

/// Returns the share of green, 0 to 1.
fn green([r, g, b]: [f64; 3]) -> f64 {
    ((g - r.max(b)) / 102.0).max(0.0)
}

const SIDE: u32 = 240;
/// Radii at which only the needle is white, inside the ticks, as shares of the dial's radius.
const NEEDLE_RING: (f32, f32) = (0.70, layout::NEEDLE.1 + 0.015);
/// Radii outside the band, which only the red line reaches, as shares of the dial's radius.
const LINE_RING: (f32, f32) = (layout::TARGET.0 - 0.005, layout::BAND.0 + 0.01);

/// Returns the dial of the 250 m ring, as its scenarios show it.
fn ring_dial(speed_mps: f64, advice: Option<(f64, f64, f64)>) -> DialView {
    DialView::new(speed_mps, advice, SpeedUnit::Mph, DialView::scale_for(9.6, SpeedUnit::Mph), false)
}

fn hc22(dial: &DialView) -> Picture {
    draw(dial, Palette::HC22, SIDE)
}

#[test]
fn the_needles_angle_is_linear_in_speed() {
    let mut worst = 0.0_f64;
    for i in 0..=12 {
        // 0 to 26 mph: the last speed is beyond full scale.
        let speed_mph = f64::from(i) * 26.0 / 12.0;
        let picture = hc22(&ring_dial(SpeedUnit::Mph.to_mps(speed_mph), None));
        let angle = picture.angle_of(NEEDLE_RING, white).expect("a needle");
        let wanted = -135.0 + 270.0 * (speed_mph / 25.0).min(1.0);
        worst = worst.max((angle - wanted).abs());
        assert!((angle - wanted).abs() < 1.0, "{speed_mph} mph: needle at {angle:.2}, not {wanted:.2} degrees");
    }
    println!("needle: at most {worst:.3} degrees off");
}

#[test]
fn the_needle_hides_no_numeral() {
    // The numerals lie between the hub and the needle's root and must look the same at every speed.
    let ring = |picture: &Picture| -> Vec<[f64; 3]> {
        let radii = (0..12).map(|i| {
            let share = f64::from(i) / 11.0;
            f64::from(layout::HUB) + 0.07 + share * f64::from(layout::NEEDLE.1 - 0.030 - layout::HUB - 0.07)
        });
        radii
            .flat_map(|radius| (0..720).map(move |k| (f64::from(k) / 2.0, radius)))
            .map(|(a, r)| picture.polar(a, r))
            .collect()
    };
    let resting = ring(&hc22(&ring_dial(0.0, None)));
    assert!(resting.iter().filter(|c| c[1] > 150.0).count() > 200, "numerals are seen");
    for speed_mph in [5.0, 10.0, 12.5, 20.0, 25.0] {
        let other = ring(&hc22(&ring_dial(SpeedUnit::Mph.to_mps(speed_mph), None)));
        let off =
            resting.iter().zip(&other).flat_map(|(a, b)| (0..3).map(move |i| (a[i] - b[i]).abs())).fold(0.0, f64::max);
        assert!(off < 2.0, "{speed_mph} mph changes the numerals by {off}");
    }
}

#[test]
fn the_arrow_of_the_guidance_points_to_its_side_in_the_gap_of_the_scale() {
    let shown = |next: Option<(Manoeuvre, f64)>| {
        let next = next.map(|(manoeuvre, ahead_m)| NextManoeuvre { manoeuvre, ahead_m });
        hc22(&ring_dial(2.0, None).guiding(next))
    };
    // White below the hub on a side of the middle: arrows and text lie within 20 degrees of 6 o'clock.
    let sides = |picture: &Picture| {
        [160.0_f64, 181.0].map(|from| {
            let angles = (0..38).map(|k| from + f64::from(k) / 2.0);
            let radii = (0..16).map(|k| 0.52 + 0.012 * f64::from(k));
            let points = radii.flat_map(|radius| angles.clone().map(move |angle| (angle, radius)));
            points.map(|(angle, radius)| white(picture.polar(angle, radius))).sum::<f64>()
        })
    };
    let [right, left] = sides(&shown(None));
    assert!(right + left < 1.0, "nothing without a manoeuvre: {right} {left}");
    // Angles are clockwise from 12 o'clock: the right side comes before 180 degrees. The foot stands on the other side.
    for manoeuvre in [Manoeuvre::Right, Manoeuvre::Left, Manoeuvre::KeepRight, Manoeuvre::KeepLeft] {
        let is_right = matches!(manoeuvre, Manoeuvre::Right | Manoeuvre::KeepRight);
        // Degrees from 6 o'clock, and radius, of the tips of a turn and of a fork.
        let is_turn = matches!(manoeuvre, Manoeuvre::Right | Manoeuvre::Left);
        let (from, radius) = if is_turn { (8, 0.585) } else { (4, 0.54) };
        let side = if is_right { -1.0 } else { 1.0 };
        let tip = |picture: &Picture| {
            (from..from + 4).map(|k| white(picture.polar(180.0 + side * f64::from(k), radius))).sum::<f64>()
        };
        let mirrored = match manoeuvre {
            Manoeuvre::Right => Manoeuvre::Left,
            Manoeuvre::Left => Manoeuvre::Right,
            Manoeuvre::KeepRight => Manoeuvre::KeepLeft,
            _ => Manoeuvre::KeepRight,
        };
        let [own, other] = [manoeuvre, mirrored].map(|to| tip(&shown(Some((to, 120.0)))));
        assert!(own > 1.5 * other && own > 1.0, "{manoeuvre:?}: {own} at its tip, {other} with the opposite");
    }
    assert!(shown(Some((Manoeuvre::Left, 5000.0))).polar(189.0, 0.585) == shown(None).polar(189.0, 0.585), "far away");
}

#[test]
fn the_red_line_is_at_the_target() {
    let mut worst = 0.0_f64;
    for target_mph in [0.0, 2.0, 5.0, 9.76, 12.5, 17.0, 25.0] {
        let target = SpeedUnit::Mph.to_mps(target_mph);
        let picture = hc22(&ring_dial(3.0, Some((target, (target - 0.5).max(0.0), target + 0.5))));
        let wanted = -135.0 + 270.0 * target_mph / 25.0;
        for ring in [LINE_RING, (layout::BAND.1 - 0.01, layout::TARGET.1 + 0.005)] {
            let angle = picture.angle_of(ring, red).expect("a red line, beyond the band on both sides");
            worst = worst.max((angle - wanted).abs());
            assert!((angle - wanted).abs() < 1.0, "target {target_mph}: line at {angle:.2}, not {wanted:.2}");
        }
    }
    println!("red line: at most {worst:.3} degrees off");
}

/// Returns the lowest and highest angle at which the band is more than half green, degrees.
fn band_edges(picture: &Picture) -> (f64, f64) {
    let ring = (layout::BAND.0 - 0.02, layout::BAND.1 + 0.02);
    let lit: Vec<f64> = sweep().filter(|&angle| picture.along(angle, ring, green) > 0.5).collect();
    (lit[0], lit[lit.len() - 1])
}

#[test]
fn the_green_band_spans_the_range_exactly() {
    let mut worst = 0.0_f64;
    for (low_mph, high_mph) in [(0.0, 5.0), (3.0, 4.0), (8.76, 10.76), (12.0, 22.0), (20.0, 25.0)] {
        let [low, high] = [low_mph, high_mph].map(|speed| SpeedUnit::Mph.to_mps(speed));
        let picture = hc22(&ring_dial(1.0, Some(((low + high) / 2.0, low, high))));
        let (from, to) = band_edges(&picture);
        for (edge, wanted) in [(from, low_mph), (to, high_mph)].map(|(e, mph)| (e, -135.0 + 270.0 * mph / 25.0)) {
            worst = worst.max((edge - wanted).abs());
            assert!((edge - wanted).abs() < 1.0, "{low_mph} to {high_mph} mph: edge at {edge:.2}, not {wanted:.2}");
        }
    }
    println!("band: edges at most {worst:.3} degrees off");
}

#[test]
fn the_number_is_green_inside_the_range_and_white_outside_at_both_edges() {
    let range = (4.0, 3.5, 4.5);
    for palette in [Palette::HC22, Palette::COLOUR_BLIND_SAFE] {
        for (speed, inside) in [
            (3.5, true),
            (3.5_f64.next_down(), false),
            (3.5_f64.next_up(), true),
            (4.0, true),
            (4.5_f64.next_down(), true),
            (4.5, true),
            (4.5_f64.next_up(), false),
            (0.0, false),
            (9.0, false),
        ] {
            let picture = draw(&ring_dial(speed, Some(range)), palette, SIDE);
            let green = picture.count_on_hub(palette.number_inside);
            let white = picture.count_on_hub(palette.number_outside);
            let (lit, other) = if inside { (green, white) } else { (white, green) };
            assert!(lit > 300 && other == 0, "{speed} m/s: {green} pixels as inside, {white} as outside");
        }
    }
}

#[test]
fn without_advice_there_is_no_red_and_no_green() {
    let picture = hc22(&ring_dial(4.0, None));
    for pixel in picture.rgba.chunks(4) {
        let colour = [f64::from(pixel[0]), f64::from(pixel[1]), f64::from(pixel[2])];
        assert!(red(colour) < 0.05 && green(colour) < 0.05, "{pixel:?}");
    }
}

#[test]
fn mph_and_kmh_dials_show_a_speed_at_its_own_number() {
    for unit in [SpeedUnit::Mph, SpeedUnit::Kmh] {
        let scale = DialView::scale_for(17.88, unit);
        let dial = DialView::new(10.0, Some((12.0, 11.0, 13.0)), unit, scale, false);
        assert_eq!(dial.number, if unit == SpeedUnit::Mph { 22 } else { 36 });
        let picture = hc22(&dial);
        let degrees = |speed_mps: f64| -135.0 + 270.0 * unit.from_mps(speed_mps) / scale.full;
        let needle = picture.angle_of(NEEDLE_RING, white).expect("a needle");
        assert!((needle - degrees(10.0)).abs() < 1.0, "{unit:?}: {needle}");
        let line = picture.angle_of(LINE_RING, red).expect("a line");
        assert!((line - degrees(12.0)).abs() < 1.0, "{unit:?}: {line}");
        let (from, to) = band_edges(&picture);
        assert!((from - degrees(11.0)).abs() < 1.0 && (to - degrees(13.0)).abs() < 1.0, "{unit:?}: {from} {to}");
    }
}

#[test]
fn reverse_shows_an_r() {
    let scale = DialView::scale_for(9.6, SpeedUnit::Mph);
    let [forwards, reverse] =
        [false, true].map(|reverse| hc22(&DialView::new(-1.0, None, SpeedUnit::Mph, scale, reverse)));
    assert_eq!(forwards.count(Palette::HC22.reverse), 0);
    assert!(reverse.count(Palette::HC22.reverse) > 30);
}

#[test]
fn the_dial_is_at_the_bottom_centre_and_leaves_the_picture_unchanged() {
    let rect = DialPlace::default().rect([1920, 1080]);
    assert!((rect.center().x - 960.0).abs() < 0.01 && rect.bottom() < 1080.0 && rect.bottom() > 1050.0);
    assert!((rect.width() - 0.34 * 1080.0).abs() < 0.01);
    assert!(DialPlace::default().rect([100, 1080]).width() <= 100.0);
    // The corners of the dial's square show the unchanged background.
    let picture = hc22(&ring_dial(4.0, None));
    let corner = &picture.rgba[..4];
    assert_eq!(corner, [115, 140, 166, 255]);
}

#[test]
fn two_drawings_are_identical_to_the_bit() {
    let dial = ring_dial(4.4, Some((4.362, 3.9, 4.8)));
    assert!(hc22(&dial).rgba == hc22(&dial).rgba);
}

#[test]
fn a_texture_that_egui_drops_lives_until_its_last_frame_is_submitted() {
    let Gpu { device, queue, .. } = headless();
    let ctx = egui::Context::default();
    let mut pass = UiPass::new(device, FORMAT);
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 64, height: 64, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = target.create_view(&Default::default());
    let image = egui::ColorImage::filled([8, 8], egui::Color32::WHITE);
    let mut picture = Some(ctx.load_texture("white", image, Default::default()));
    for _ in 0..4 {
        let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(64.0, 64.0));
        let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
        // The image is shown in the frame in which it is dropped. A command that reads a destroyed texture panics on submit.
        let output = ctx.run_ui(input, |ui| {
            if let Some(picture) = picture.take() {
                ui.image(&picture);
            }
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        pass.draw(
            OverlayTarget { device, queue, encoder: &mut encoder, view: &view, size: [64, 64], stamps: None },
            &ctx,
            output,
        );
        queue.submit([encoder.finish()]);
    }
}

#[test]
fn example_dials_are_drawn_for_visual_inspection() {
    let mph = |speed: f64| SpeedUnit::Mph.to_mps(speed);
    let successor = DialView::scale_for(17.88, SpeedUnit::Mph);
    let metric = DialView::scale_for(17.88, SpeedUnit::Kmh);
    let road = DialView::scale_for(45.0, SpeedUnit::Mph);
    let dials = [
        ("ring", ring_dial(4.5, Some((4.362, 3.9, 4.85))), Palette::HC22),
        (
            "hc22",
            DialView::new(2.0, Some((mph(17.0), mph(12.0), mph(22.0))), SpeedUnit::Mph, successor, false),
            Palette::HC22,
        ),
        ("kmh", DialView::new(8.9, Some((8.7, 7.9, 9.5)), SpeedUnit::Kmh, metric, false), Palette::COLOUR_BLIND_SAFE),
        ("reverse", DialView::new(-1.2, None, SpeedUnit::Kmh, metric, true), Palette::HC22),
        ("road", DialView::new(55.0, None, SpeedUnit::Mph, road, false), Palette::HC22),
    ];
    for (name, dial, palette) in dials {
        for side in [SIDE, 720] {
            let picture = draw(&dial, palette, side);
            assert!(picture.count(palette.needle) > 50, "{name} at {side}");
            picture.save(&format!("dial-{name}-{side}.png"));
        }
    }
}

#[test]
fn the_photodiode_square_is_black_or_white_and_changes_nothing_else() {
    let side = 200;
    let square = (0.07 * side as f32).round() as u32;
    let at = |picture: &Picture, x: u32, y: u32| -> [u8; 3] {
        let i = 4 * (y * side + x) as usize;
        [picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]]
    };
    let background = at(&draw_all(None, TaskPicture::None, None, Palette::HC22, side), 0, 0);
    for (white, level) in [(true, 255), (false, 0)] {
        let picture = draw_all(None, TaskPicture::None, Some(white), Palette::HC22, side);
        for (x, y) in [(0, 0), (square - 1, 0), (0, square - 1), (square / 2, square / 2)] {
            assert_eq!(at(&picture, x, y), [level; 3], "at {x}, {y}");
        }
        for (x, y) in [(square + 1, 0), (0, square + 1), (side / 2, side / 2)] {
            assert_eq!(at(&picture, x, y), background, "at {x}, {y}");
        }
    }
}

#[test]
fn the_secondary_task_has_its_place_and_the_shutter_covers_all() {
    let side = 400;
    let picture = |task: TaskPicture| draw_all(None, task, None, Palette::default(), side);
    let pixel = |picture: &Picture, [x, y]: [usize; 2]| -> [u8; 3] {
        let at = (y * side as usize + x) * 4;
        [0, 1, 2].map(|part| picture.rgba[at + part])
    };
    let none = picture(TaskPicture::None);
    // The signal is a disc at a tenth of the width and 24 % of the height, 3.5 % of the height wide.
    let signal = picture(TaskPicture::Signal);
    let [red, green, blue] = pixel(&signal, [40, 96]);
    assert!(red > 240 && green < 40 && blue < 40, "{red} {green} {blue}");
    let changed = signal.rgba.chunks(4).zip(none.rgba.chunks(4)).filter(|(with, without)| with != without).count();
    let area = std::f64::consts::PI * 7.0 * 7.0;
    assert!((changed as f64 / area - 1.0).abs() < 0.4, "{changed} pixels of {area}");
    // A closed shutter has one colour in the whole picture.
    let closed = picture(TaskPicture::Closed { opens_on_press: false });
    let first = pixel(&closed, [0, 0]);
    assert!(closed.rgba.chunks(4).all(|pixel| pixel[..3] == first) && first != pixel(&none, [0, 0]));
    // The band of the cursor moves from column to column, and nothing else does.
    let search =
        |cursor| picture(TaskPicture::Search { seed: 3, columns: 6, target_column: 2, cursor, size_ratio: 1.4 });
    let [left, right] = [0, 5].map(search);
    let differs = |i: &usize| left.rgba[4 * i..4 * i + 4] != right.rgba[4 * i..4 * i + 4];
    let columns: Vec<usize> = (0..(side * side) as usize).filter(differs).map(|i| i % side as usize).collect();
    // Six columns of 2 x 4.2 % of the height, from 4 % on: the first ends at 49.6 pixels, the last begins at 184.
    assert!(!columns.is_empty() && columns.iter().all(|x| *x < 51 || *x > 182), "{columns:?}");
}
