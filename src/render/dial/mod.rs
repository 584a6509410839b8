//! The speedometer, drawn. In: a [`DialView`] and where it is to stand. Out: shapes of egui's painter, put over the picture
//! by a pass of its own, so that what a participant sees never depends on the experimenter's panel.

mod brush;
mod fixed;

use egui::{Color32, Painter, Pos2, Rect, pos2, vec2};

use super::{
    device::cost::PassCost,
    post::ui_pass::{OverlayTarget, UiPass},
};
use crate::{
    controls::Indicator,
    hud::{DialView, Palette, lettering},
    scene::{BONNET_EDGE, CLUSTER_M, CLUSTER_RADIUS_M, Camera, View, ViewKind},
};
use brush::{DialBrush, black, opaque, shade};
use fixed::FixedParts;
use glam::Vec3;

/// Radii, lengths and heights as shares of the instrument's radius (half its rectangle), from the outside in.
pub mod layout {
    /// Edge of the face; the shadow lies outside.
    pub const FACE: f32 = 0.955;
    /// Outer and inner end of the red line.
    pub const TARGET: (f32, f32) = (0.945, 0.765);
    /// Outer and inner edge of the green band.
    pub const BAND: (f32, f32) = (0.915, 0.835);
    /// Outer end of all ticks.
    pub const MARKS: f32 = 0.818;
    /// Inner ends of numbered, half and other ticks.
    pub const MARKS_INNER: (f32, f32, f32) = (0.720, 0.752, 0.774);
    /// Tip and root of the needle: it points from between numerals and ticks to the band and hides no numeral.
    pub const NEEDLE: (f32, f32) = (0.822, 0.630);
    /// Where the outer corners of the numerals end, and their height up to 99 and from 100 up.
    pub const NUMERALS: (f32, f32, f32) = (0.612, 0.102, 0.088);
    /// Edge of the hub, on which number and unit stand.
    pub const HUB: f32 = 0.43;
    /// Height of the number up to 99, of one of three digits, and how far its middle lies above the axle.
    pub const NUMBER: (f32, f32, f32) = (0.42, 0.30, 0.05);
    /// Height of the unit, and how far its middle lies below the axle.
    pub const UNIT: (f32, f32) = (0.085, 0.305);
    /// Height of the R, and how far its middle lies below the axle.
    pub const REVERSE: (f32, f32) = (0.13, 0.69);
    /// The arrows of the indicators: where their tips are beside the axle and below it, their length and half their height.
    pub const INDICATOR: (f32, f32, f32, f32) = (0.46, 0.69, 0.24, 0.095);
}

/// Where the instrument stands, at the bottom of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DialPlace {
    /// Across the picture: 0 at the left margin, 0.5 in the middle, 1 at the right margin.
    pub across: f32,
    /// Diameter as a share of the picture's height.
    pub diameter_share: f32,
    /// Free space below as a share of the picture's height.
    pub margin_share: f32,
}

/// Least diameter of an instrument below the bonnet's far edge: on a 55-inch television (0.69 m high) its number is then
/// 36 mm high, 2 degrees at 1 m. In a wider picture there is less room, and it stands at the side.
const LEAST_SHARE: f32 = 0.25;
/// Free space under an instrument that takes what the bonnet leaves it.
const LEAST_MARGIN: f32 = 0.006;
/// Most of the picture's width that it takes: at the right margin it begins where a leader two metres ahead has ended.
const MOST_OF_WIDTH: f32 = 0.1925;

impl Default for DialPlace {
    /// A third of the picture: on a 55-inch television (0.69 m high) the number is 49 mm high, 1.4 degrees at 2 m.
    fn default() -> Self {
        Self { across: 0.5, diameter_share: 0.34, margin_share: 0.015 }
    }
}

impl DialPlace {
    /// In the instrument cluster, if the car has one. Else in the middle, as HC22 has it, below the far edge of the bonnet, which hides whatever an instrument there would hide
    /// of the leader. Where there is no bonnet or too little room below it, and in the chase view, at the right, beside ego
    /// and leader.
    pub fn of(view: &View, size: [u32; 2]) -> Self {
        let aspect = size[0] as f32 / size[1].max(1) as f32;
        let beside = Self { across: 1.0, ..Self::default() };
        let Some(seat) = view.seat.filter(|_| view.kind == ViewKind::Driver) else { return beside };
        if seat.steering_wheel_rad.is_some() {
            return Self::in_cluster(&seat.look, aspect).unwrap_or(beside);
        }
        let edge = seat.look.eye + Vec3::X - BONNET_EDGE * Vec3::Z;
        let Some(edge) = seat.look.project(edge, aspect) else { return beside };
        let room = 1.0 - edge.y - LEAST_MARGIN;
        let most = Self::default().diameter_share;
        match room {
            room if room < LEAST_SHARE => beside,
            room if room < most => Self { across: 0.5, diameter_share: room, margin_share: LEAST_MARGIN },
            _ => Self::default(),
        }
    }

    /// On the face of the instrument cluster; in a picture that ends above its lower edge as much higher as it needs.
    fn in_cluster(look: &Camera, aspect: f32) -> Option<Self> {
        let middle = look.project(CLUSTER_M, aspect)?;
        let radius = (look.project(CLUSTER_M + Vec3::Y * CLUSTER_RADIUS_M, aspect)?.x - middle.x).abs() * aspect;
        let margin_share = (1.0 - middle.y - radius).max(LEAST_MARGIN);
        Some(Self { across: 0.5, diameter_share: (2.0 * radius).min(1.0 - 2.0 * LEAST_MARGIN), margin_share })
    }

    /// The instrument's square in a picture of `size` pixels.
    pub fn rect(&self, size: [u32; 2]) -> Rect {
        let [width, height] = size.map(|side| side as f32);
        let most = if self.across == 0.5 { width } else { MOST_OF_WIDTH * width };
        let diameter = (self.diameter_share * height).min(most);
        let margin = self.margin_share * height;
        let free = (width - diameter - 2.0 * margin).max(0.0);
        let left = if free > 0.0 { margin + self.across * free } else { (width - diameter) / 2.0 };
        let centre = pos2(left + diameter / 2.0, height - margin - diameter / 2.0);
        Rect::from_center_size(centre, vec2(diameter, diameter))
    }
}

/// Side of the square for a photodiode, as a share of the picture's height: 48 mm on a 55-inch television.
pub const PATCH_SHARE: f32 = 0.07;

/// Draws the speedometer over a picture.
#[derive(Debug)]
pub struct DialPass {
    ctx: egui::Context,
    ui: UiPass,
    format: wgpu::TextureFormat,
    fixed: FixedParts,
    /// Where the instrument stands.
    pub place: DialPlace,
    /// Its colours.
    pub palette: Palette,
}

impl DialPass {
    /// A pass onto targets of `format`, a plain `Unorm` format.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let ctx = egui::Context::default();
        // Discs from the font atlas would be filtered; drawn as polygons they are exact at every size.
        ctx.tessellation_options_mut(|options| options.prerasterized_discs = false);
        Self {
            ctx,
            ui: UiPass::new(device, format),
            format,
            fixed: FixedParts::default(),
            place: DialPlace::default(),
            palette: Palette::default(),
        }
    }

    /// Appends the instrument to the picture, and the square for a photodiode: `patch` is whether it is white. Once a
    /// submission (see [`UiPass::draw`]).
    pub fn draw(&mut self, target: OverlayTarget<'_>, dial: Option<&DialView>, patch: Option<bool>) {
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(target.size[0] as f32, target.size[1] as f32));
        let rect = self.place.rect(target.size);
        let palette = self.palette;
        let Self { ctx, ui, format, fixed, .. } = self;
        let fixed = dial.map(|dial| {
            let what = (rect, dial, &palette);
            fixed.of((target.device, target.queue), *format, (ctx, ui), what, |painter, rect| {
                paint_fixed(painter, rect, dial, &palette);
            })
        });
        let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
        let output = ctx.run_pass(input, |ctx| {
            let painter = ctx.layer_painter(egui::LayerId::background());
            if let (Some(dial), Some((texture, place))) = (dial, fixed) {
                let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
                painter.image(texture, place, whole, Color32::WHITE);
                paint_moving(&painter, rect, dial, &palette);
            }
            if let Some(white) = patch {
                let side = (PATCH_SHARE * screen.height()).round();
                let square = Rect::from_min_size(Pos2::ZERO, vec2(side, side));
                painter.rect_filled(square, 0.0, if white { Color32::WHITE } else { Color32::BLACK });
            }
        });
        ui.draw(target, ctx, output);
    }

    /// As [`UiPass::take_cost`].
    pub fn take_cost(&mut self) -> (PassCost, u64) {
        self.ui.take_cost()
    }
}

/// Paints what does not move into `rect`, a square.
fn paint_fixed(painter: &Painter, rect: Rect, dial: &DialView, palette: &Palette) {
    let brush = DialBrush { painter, centre: rect.center(), radius: rect.width() / 2.0 };
    face(&brush, palette);
    groove(&brush, dial);
    scale(&brush, dial, palette);
    hub(&brush, dial, palette);
}

/// Paints what moves over that. Needle and red line end where the hub begins and lie over ticks.
fn paint_moving(painter: &Painter, rect: Rect, dial: &DialView, palette: &Palette) {
    let brush = DialBrush { painter, centre: rect.center(), radius: rect.width() / 2.0 };
    band(&brush, dial, palette);
    target_line(&brush, dial, palette);
    needle(&brush, dial, palette);
    number(&brush, dial, palette);
    indicator(&brush, dial, palette);
}

/// What parts needle and red line from what lies below them.
const EDGE: Color32 = Color32::from_rgb(8, 9, 11);

/// Bright metal under so much light.
fn metal(light: f32) -> Color32 {
    shade([200, 208, 218], light, 255)
}

/// The face with rim and shadow: dark enough for white numerals over a white sky, translucent enough to belong.
fn face(brush: &DialBrush<'_>, palette: &Palette) {
    let below = DialBrush { centre: brush.centre + vec2(0.0, 0.012 * brush.radius), ..*brush };
    below.disc(&[(0.90, black(150)), (0.955, black(92)), (0.975, black(36)), (0.988, black(8))]);

    let fill = |light: f32| shade(palette.plate, light, palette.plate_alpha);
    // From under the hub on, which is opaque.
    brush.disc(&[
        (layout::HUB - 0.03, fill(1.8)),
        (0.55, fill(1.7)),
        (0.80, fill(1.0)),
        (layout::FACE - 0.01, fill(0.7)),
    ]);

    // A turned rim, lit from above: bright at the top, dark at the bottom, with a thin line of light inside.
    brush.ring(layout::FACE - 0.022, layout::FACE, |angle| metal(0.37 + 0.21 * angle.cos()));
    brush.ring(layout::FACE - 0.032, layout::FACE - 0.022, |angle| metal(0.12 - 0.07 * angle.cos()));
}

/// The groove of the whole scale.
fn groove(brush: &DialBrush<'_>, dial: &DialView) {
    let (zero, full) = (dial.angle_rad(0.0), dial.angle_rad(dial.full_scale));
    brush.arc(layout::BAND, (zero, full), Color32::from_rgb(40, 44, 51));
}

/// The green band in it.
fn band(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    if let Some(range) = dial.band_rad() {
        brush.arc(layout::BAND, range, opaque(palette.band));
    }
}

fn scale(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let (major, half, minor) = layout::MARKS_INNER;
    let (ends, two_digits, three_digits) = layout::NUMERALS;
    let height = if dial.full_scale >= 100.0 { three_digits } else { two_digits };
    for mark in dial.marks() {
        let (inner, width, light) = match mark {
            _ if mark.numbered => (major, 0.022, 1.0),
            _ if mark.half => (half, 0.012, 0.85),
            _ => (minor, 0.008, 0.68),
        };
        let colour = shade(palette.scale, light, 255);
        brush.radial(mark.angle_rad, (layout::MARKS, inner), brush.at_least_px(width, 1.0), colour);
        if mark.numbered {
            let text = format!("{:.0}", mark.value);
            // Each numeral comes as close to its tick as its own width and height allow.
            let (sin, cos) = mark.angle_rad.sin_cos();
            let (pen, width) = (lettering::PEN, lettering::set(&text).width);
            let extent = ((width + pen) * sin.abs() + (1.0 + pen) * cos.abs()) / 2.0;
            brush.text(&text, brush.at(mark.angle_rad, ends - extent * height), height, opaque(palette.scale));
        }
    }
}

/// The red line, across the band and beyond it on both sides, edged in black so that red and green do not touch.
fn target_line(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let Some(angle) = dial.target_rad() else { return };
    let (outer, inner) = layout::TARGET;
    let width = brush.at_least_px(0.034, 2.5);
    brush.radial(angle, (outer, inner), width + brush.at_least_px(0.022, 2.0), EDGE);
    brush.radial(angle, (outer, inner), width, opaque(palette.target));
}

/// A wedge that floats between the numerals and the band, with a dark edge that parts it from the ticks it passes.
fn needle(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let angle = dial.needle_rad();
    let blade = |grow: f32| {
        let across = vec2(angle.cos(), angle.sin()) * brush.radius;
        let (root, tip) = (0.036 + grow, 0.009 + grow);
        let (from, to) = (brush.at(angle, layout::NEEDLE.1 - grow), brush.at(angle, layout::NEEDLE.0 + grow));
        vec![from - across * root, to - across * tip, to + across * tip, from + across * root]
    };
    brush.polygon(blade(0.014), EDGE);
    brush.polygon(blade(0.0), opaque(palette.needle));
}

/// The hub with the unit.
fn hub(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    brush.disc(&[(layout::HUB - 0.02, black(170)), (layout::HUB + 0.025, black(70)), (layout::HUB + 0.06, black(0))]);
    let fill = |light: f32| shade(palette.plate, light, 255);
    brush.disc(&[(0.0, fill(2.1)), (0.30, fill(1.7)), (layout::HUB - 0.005, fill(1.2))]);
    brush.ring(layout::HUB - 0.012, layout::HUB, |angle| metal(0.27 + 0.13 * angle.cos()));
    let (height, down) = layout::UNIT;
    brush.text(dial.unit.label(), brush.below(down), height, opaque(palette.label));
}

/// The number, and R in reverse below it.
fn number(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let colour = if dial.inside { palette.number_inside } else { palette.number_outside };
    let (two_digits, three_digits, up) = layout::NUMBER;
    let height = if dial.full_scale >= 100.0 || dial.number >= 100 { three_digits } else { two_digits };
    brush.text(&dial.number.to_string(), brush.below(-up), height, opaque(colour));
    if dial.reverse {
        let (height, down) = layout::REVERSE;
        brush.text("R", brush.below(down), height, opaque(palette.reverse));
    }
}

/// The telltale of the indicators, an arrow on its side of the lower face, in the gap of the scale.
fn indicator(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let side = match dial.indicator {
        Indicator::Off => return,
        Indicator::Left => -1.0,
        Indicator::Right => 1.0,
    };
    let (tip, down, length, half) = layout::INDICATOR;
    let at = |across: f32, up: f32| brush.centre + vec2(side * across, down - up) * brush.radius;
    let (neck, shaft) = (tip - 0.55 * length, half * 0.45);
    let colour = opaque(palette.indicator);
    brush.polygon(vec![at(tip, 0.0), at(neck, half), at(neck, -half)], colour);
    brush.polygon(vec![at(neck, shaft), at(tip - length, shaft), at(tip - length, -shaft), at(neck, -shaft)], colour);
}
