//! Tests of the driver's window on a texture instead of the screen: the overlay over the picture or over black, the
//! picture above a free area.

use super::*;
use crate::render::{OFFSCREEN, offscreen::read_back};
use egui::{Color32, Pos2, RawInput, Rect, vec2};

const SIZE: [u32; 2] = [40, 20];
const RED: wgpu::Color = wgpu::Color { r: 1.0, g: 0.0, b: 0.0, a: 1.0 };

fn gpu() -> &'static Gpu {
    Gpu::shared().expect("a graphics adapter is needed")
}

/// Returns a canvas of one colour.
fn painted(pass: &PreviewPass, size: [u32; 2], colour: wgpu::Color) -> wgpu::TextureView {
    let canvas = pass.canvas(&gpu().device, size);
    paint(&canvas, colour);
    canvas
}

fn paint(canvas: &wgpu::TextureView, colour: wgpu::Color) {
    let mut encoder = gpu().device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: canvas,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(colour), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
    gpu().queue.submit([encoder.finish()]);
}

/// Returns a function that reads red, green, blue of the pixel at column x, row y.
fn pixels(canvas: &wgpu::TextureView) -> impl Fn(u32, u32) -> [u8; 3] {
    let (width, bytes) = (canvas.texture().width(), read_back(gpu(), canvas.texture(), 4).unwrap());
    move |x, y| {
        let i = 4 * (y * width + x) as usize;
        [bytes[i], bytes[i + 1], bytes[i + 2]]
    }
}

/// Draws a green egui rectangle from (10, 5) to (30, 15).
fn overlay(ctx: &Context) -> FullOutput {
    let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(SIZE[0] as f32, SIZE[1] as f32)));
    ctx.run_ui(RawInput { screen_rect, ..Default::default() }, |ui| {
        let place = Rect::from_min_max(egui::pos2(10.0, 5.0), egui::pos2(30.0, 15.0));
        ui.ctx().layer_painter(egui::LayerId::background()).rect_filled(place, 0.0, Color32::from_rgb(0, 255, 0));
    })
}

#[test]
fn an_overlay_lies_over_the_picture_or_over_black_without_one() {
    let pass = PreviewPass::new(&gpu().device, OFFSCREEN);
    for (clear, behind) in [(None, [255, 0, 0]), (Some(wgpu::Color::BLACK), [0, 0, 0])] {
        let screen = painted(&pass, SIZE, RED);
        let (ctx, mut ui_pass) = (Context::default(), UiPass::new(&gpu().device, OFFSCREEN));
        let output = overlay(&ctx);
        put_on(&gpu().device, &gpu().queue, &mut ui_pass, &ctx, output, &screen, SIZE, clear);
        let at = pixels(&screen);
        assert_eq!((at(20, 10), at(11, 6), at(28, 13)), ([0, 255, 0], [0, 255, 0], [0, 255, 0]), "{clear:?}");
        assert_eq!((at(5, 10), at(35, 10), at(20, 2), at(20, 17)), (behind, behind, behind, behind), "{clear:?}");
    }
}

#[test]
fn the_picture_is_whole_above_a_free_foot() {
    let pass = PreviewPass::new(&gpu().device, OFFSCREEN);
    let mut foot = FooterArea { pass: PreviewPass::new(&gpu().device, OFFSCREEN), height: 8, canvas: None };
    // A picture of the size that it is asked for: its lower right pixel is just above the free area.
    for (size, width) in [([40, 20], 40), ([64, 20], 64)] {
        let screen = painted(&pass, size, RED);
        let mut asked = Vec::new();
        foot.draw(gpu(), [size[0], size[1] - foot.height], &screen, |canvas, size| {
            asked.push((size, [canvas.texture().width(), canvas.texture().height()]));
            paint(canvas, wgpu::Color { r: 0.0, g: 0.0, b: 1.0, a: 1.0 });
        });
        assert_eq!(asked, [([width, 12], [width, 12])], "drawn once, at its own size");
        let at = pixels(&screen);
        let (blue, free) = ([0, 0, 255], [0, 0, 0]);
        assert_eq!((at(0, 0), at(width - 1, 11)), (blue, blue));
        assert_eq!((at(0, 12), at(width - 1, 19)), (free, free));
    }
}
