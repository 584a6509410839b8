//! Fixed parts of the instrument, painted once into a texture: face, groove, ticks, numerals, hub. In: a dial, its
//! square and colours. Out: a texture for egui's painter, unchanged until one of them changes.

use egui::{Context, Pos2, RawInput, Rect, TextureId, vec2};

use crate::hud::{DialView, Palette};
use crate::render::device::targets::target;
use crate::render::post::ui_pass::{OverlayTarget, UiPass};
use crate::units::SpeedUnit;

/// Painted fixed parts, with the values they depend on.
#[derive(Debug, Default)]
pub(super) struct FixedParts {
    painted: Option<FixedPartsKey>,
    texture: Option<TextureId>,
}

/// All values that the fixed parts depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FixedPartsKey {
    rect: Rect,
    palette: Palette,
    unit: SpeedUnit,
    full_scale: f64,
    major_step: f64,
    minor_per_major: u32,
}

impl FixedParts {
    /// Returns the texture and its place in the picture, in whole pixels. If the instrument at `rect` has changed,
    /// `paint` paints it anew, and commands are submitted to the device.
    pub(super) fn of(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        format: wgpu::TextureFormat,
        (ctx, ui): (&Context, &mut UiPass),
        (rect, dial, palette): (Rect, &DialView, &Palette),
        paint: impl Fn(&egui::Painter, Rect),
    ) -> (TextureId, Rect) {
        let look = FixedPartsKey {
            rect,
            palette: *palette,
            unit: dial.unit,
            full_scale: dial.full_scale,
            major_step: dial.major_step,
            minor_per_major: dial.minor_per_major,
        };
        // One pixel more on each side for soft edges.
        let place = Rect::from_min_max((rect.min - vec2(1.0, 1.0)).floor(), (rect.max + vec2(1.0, 1.0)).ceil());
        if let (Some(texture), true) = (self.texture, self.painted == Some(look)) {
            return (texture, place);
        }
        let size = [place.width() as u32, place.height() as u32];
        let view = target(device, "dial", (format, 1), size, wgpu::TextureUsages::TEXTURE_BINDING);
        let input = RawInput { screen_rect: Some(Rect::from_min_size(Pos2::ZERO, place.size())), ..Default::default() };
        let output = ctx.run_pass(input, |ctx| {
            paint(&ctx.layer_painter(egui::LayerId::background()), rect.translate(-place.min.to_vec2()));
        });
        // A new texture is empty and needs no clearing. Submitted here, because egui keeps one set of vertices per
        // submission.
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("dial") });
        ui.draw(OverlayTarget { device, queue, encoder: &mut encoder, view: &view, size, stamps: None }, ctx, output);
        queue.submit([encoder.finish()]);
        let nearest = wgpu::FilterMode::Nearest;
        let id = match self.texture {
            Some(id) => {
                ui.renderer().update_egui_texture_from_wgpu_texture(device, &view, nearest, id);
                id
            }
            None => ui.renderer().register_native_texture(device, &view, nearest),
        };
        (self.texture, self.painted) = (Some(id), Some(look));
        (id, place)
    }
}
