//! The speedometer, drawn. In: a [`DialView`] and its place. Out: shapes of egui's painter, drawn over the picture by a
//! pass of its own, so that the participant's picture never depends on the experimenter's panel.

mod automation;
mod brush;
mod fixed;
pub mod layout;
mod pictogram;
mod task;
mod text;

use egui::{Color32, Painter, Pos2, Rect, pos2, vec2};

use super::{
    device::cost::PassCost,
    post::ui_pass::{OverlayTarget, UiPass},
};
use crate::{
    controls::Indicator,
    hud::{DialView, Palette, lettering},
    scene::{BONNET_EDGE, CLUSTER_M, CLUSTER_RADIUS_M, Camera, View, ViewKind},
    snapshot::TaskPicture,
};
use automation::automation_lamp;
use brush::{DialBrush, black, opaque, shade};
use fixed::FixedParts;
use glam::Vec3;
use pictogram::pictogram;
pub use task::paint_search_display;
use task::paint_task;
use text::{message, question};

/// Place of the instrument at the bottom of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DialPlace {
    /// Position across the picture: 0 at the left margin, 0.5 in the middle, 1 at the right margin.
    pub across: f32,
    /// Diameter as a share of the picture's height.
    pub diameter_share: f32,
    /// Free space below as a share of the picture's height.
    pub margin_share: f32,
}

/// Minimum diameter of an instrument below the bonnet's far edge, as a share of the picture's height. On a 55-inch
/// television (0.69 m high) its number is then 36 mm high, 2 degrees at 1 m. A picture with less room has the
/// instrument at the side.
const LEAST_SHARE: f32 = 0.25;
/// Free space below an instrument whose size follows from the room below the bonnet's edge.
const LEAST_MARGIN: f32 = 0.006;
/// Maximum share of the picture's width beside the middle: at the right margin the instrument begins right of a leader
/// two metres ahead.
const MOST_OF_WIDTH: f32 = 0.1925;

impl Default for DialPlace {
    /// A third of the picture: on a 55-inch television (0.69 m high) the number is 49 mm high, 1.4 degrees at 2 m.
    fn default() -> Self {
        Self { across: 0.5, diameter_share: 0.34, margin_share: 0.015 }
    }
}

impl DialPlace {
    /// Returns the place for a view. It is in the instrument cluster, if the ego has one; else in the middle, as in
    /// HC22, below the far edge of the bonnet, where it hides nothing of the leader that the bonnet does not hide.
    /// Without a bonnet, with too little room below its edge, and in the chase view, it is at the right, beside ego and
    /// leader.
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

    /// Returns the place on the face of the instrument cluster, raised as far as needed if the picture ends above its
    /// lower edge.
    fn in_cluster(look: &Camera, aspect: f32) -> Option<Self> {
        let middle = look.project(CLUSTER_M, aspect)?;
        let radius = (look.project(CLUSTER_M + Vec3::Y * CLUSTER_RADIUS_M, aspect)?.x - middle.x).abs() * aspect;
        let margin_share = (1.0 - middle.y - radius).max(LEAST_MARGIN);
        Some(Self { across: 0.5, diameter_share: (2.0 * radius).min(1.0 - 2.0 * LEAST_MARGIN), margin_share })
    }

    /// Returns the instrument's square in a picture of `size` pixels.
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
    /// Place of the instrument.
    pub place: DialPlace,
    /// Colours of the instrument.
    pub palette: Palette,
}

impl DialPass {
    /// Creates a pass onto targets of `format`, a plain `Unorm` format.
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

    /// Draws the instrument over the picture, then the secondary task, and the square for a photodiode, white if `patch` is
    /// true. At most once per submission (see [`UiPass::draw`]).
    pub fn draw(&mut self, target: OverlayTarget<'_>, dial: Option<&DialView>, task: TaskPicture, patch: Option<bool>) {
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
            paint_task(&painter, screen, rect, task);
            if let Some(white) = patch {
                let side = (PATCH_SHARE * screen.height()).round();
                let square = Rect::from_min_size(Pos2::ZERO, vec2(side, side));
                painter.rect_filled(square, 0.0, if white { Color32::WHITE } else { Color32::BLACK });
            }
        });
        ui.draw(target, ctx, output);
    }

    /// Returns the cost, as [`UiPass::take_cost`].
    pub fn take_cost(&mut self) -> (PassCost, u64) {
        self.ui.take_cost()
    }
}

/// Paints the fixed parts into `rect`, a square.
fn paint_fixed(painter: &Painter, rect: Rect, dial: &DialView, palette: &Palette) {
    let brush = DialBrush { painter, centre: rect.center(), radius: rect.width() / 2.0 };
    face(&brush, palette);
    groove(&brush, dial);
    // The hub's shadow must not darken the numerals.
    hub(&brush, dial, palette);
    scale(&brush, dial, palette);
}

/// Paints the moving parts over them. Needle and red line end at the hub and lie over the ticks.
fn paint_moving(painter: &Painter, rect: Rect, dial: &DialView, palette: &Palette) {
    let brush = DialBrush { painter, centre: rect.center(), radius: rect.width() / 2.0 };
    band(&brush, dial, palette);
    target_line(&brush, dial, palette);
    needle(&brush, dial, palette);
    number(&brush, dial, palette);
    indicator(&brush, dial, palette);
    main_beam(&brush, dial, palette);
    automation_lamp(&brush, dial, palette);
    guidance(&brush, dial, palette);
    pictogram(&brush, dial);
    message(&brush, dial, palette);
    question(&brush, dial, palette);
}

/// Dark edge that separates needle and red line from the parts below.
const EDGE: Color32 = Color32::from_rgb(8, 9, 11);

/// Returns the colour of bright metal at this brightness.
fn metal(light: f32) -> Color32 {
    shade([200, 208, 218], light, 255)
}

/// Draws the face with rim and shadow: dark enough for white numerals before a white sky, yet translucent.
fn face(brush: &DialBrush<'_>, palette: &Palette) {
    let below = DialBrush { centre: brush.centre + vec2(0.0, 0.012 * brush.radius), ..*brush };
    below.disc(&[(0.90, black(150)), (0.955, black(92)), (0.975, black(36)), (0.988, black(8))]);

    let fill = |light: f32| shade(palette.plate, light, palette.plate_alpha);
    // Starts below the hub, which is opaque.
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

/// Draws the groove of the whole scale.
fn groove(brush: &DialBrush<'_>, dial: &DialView) {
    let (zero, full) = (dial.angle_rad(0.0), dial.angle_rad(dial.full_scale));
    brush.arc(layout::BAND, (zero, full), Color32::from_rgb(40, 44, 51));
}

/// Draws the green band in the groove.
fn band(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    if let Some(range) = dial.band_rad() {
        brush.arc(layout::BAND, range, opaque(palette.band));
    }
}

/// Numeral of the scale. Lengths are shares of the instrument's radius.
struct ScaleNumeral {
    text: String,
    angle_rad: f32,
    /// Distance of its middle from the centre.
    radius: f32,
    height: f32,
}

/// Returns the numerals of a dial, each as close to its tick as its width and height allow.
fn numerals(dial: &DialView) -> impl Iterator<Item = ScaleNumeral> + '_ {
    let (ends, two_digits, three_digits) = layout::NUMERALS;
    let height = if dial.full_scale >= 100.0 { three_digits } else { two_digits };
    dial.marks().filter(|mark| mark.numbered).map(move |mark| {
        let text = format!("{:.0}", mark.value);
        let (sin, cos) = mark.angle_rad.sin_cos();
        let (pen, width) = (lettering::PEN, lettering::set(&text).width);
        let extent = ((width + pen) * sin.abs() + (1.0 + pen) * cos.abs()) / 2.0;
        ScaleNumeral { text, angle_rad: mark.angle_rad, radius: ends - extent * height, height }
    })
}

fn scale(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let (major, half, minor) = layout::MARKS_INNER;
    for mark in dial.marks() {
        let (inner, width, light) = match mark {
            _ if mark.numbered => (major, 0.022, 1.0),
            _ if mark.half => (half, 0.012, 0.85),
            _ => (minor, 0.008, 0.68),
        };
        let colour = shade(palette.scale, light, 255);
        brush.radial(mark.angle_rad, (layout::MARKS, inner), brush.at_least_px(width, 1.0), colour);
    }
    for numeral in numerals(dial) {
        brush.text(&numeral.text, brush.at(numeral.angle_rad, numeral.radius), numeral.height, opaque(palette.scale));
    }
}

/// Draws the red line across the band and beyond it on both sides, edged in black so that red and green do not touch.
fn target_line(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let Some(angle) = dial.target_rad() else { return };
    let (outer, inner) = layout::TARGET;
    let width = brush.at_least_px(0.034, 2.5);
    brush.radial(angle, (outer, inner), width + brush.at_least_px(0.022, 2.0), EDGE);
    brush.radial(angle, (outer, inner), width, opaque(palette.target));
}

/// Width of the needle's dark edge, as a share of the instrument's radius.
const NEEDLE_EDGE: f32 = 0.014;

/// Draws the needle: a wedge between the numerals and the band, with a dark edge that separates it from the ticks.
fn needle(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let angle = dial.needle_rad();
    let blade = |grow: f32| {
        let across = vec2(angle.cos(), angle.sin()) * brush.radius;
        let (root, tip) = (0.036 + grow, 0.009 + grow);
        let (from, to) = (brush.at(angle, layout::NEEDLE.1 - grow), brush.at(angle, layout::NEEDLE.0 + grow));
        vec![from - across * root, to - across * tip, to + across * tip, from + across * root]
    };
    brush.polygon(blade(NEEDLE_EDGE), EDGE);
    brush.polygon(blade(0.0), opaque(palette.needle));
}

/// Draws the hub with the unit.
fn hub(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    brush.disc(&[(layout::HUB - 0.02, black(170)), (layout::HUB + 0.025, black(70)), (layout::HUB + 0.06, black(0))]);
    let fill = |light: f32| shade(palette.plate, light, 255);
    brush.disc(&[(0.0, fill(2.1)), (0.30, fill(1.7)), (layout::HUB - 0.005, fill(1.2))]);
    brush.ring(layout::HUB - 0.012, layout::HUB, |angle| metal(0.27 + 0.13 * angle.cos()));
    let (height, down) = layout::UNIT;
    brush.text(dial.unit.label(), brush.below(down), height, opaque(palette.label));
}

/// Draws the number and, in reverse, an R below it.
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

/// Draws the telltale of the indicators: an arrow on its side of the lower face, in the gap of the scale.
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

/// Draws the telltale of the main beam: a lamp that faces left, with five level rays, as on other instruments.
fn main_beam(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    if !dial.main_beam {
        return;
    }
    let (above, half) = layout::MAIN_BEAM;
    let at = |x: f32, y: f32| brush.centre + vec2(x * half, y * half - above) * brush.radius;
    let colour = opaque(palette.main_beam);
    // The lens is flat and the reflector is half of an ellipse.
    let bow = (0..=12).map(|k| f32::from(k as u8) / 12.0 * std::f32::consts::PI - std::f32::consts::FRAC_PI_2);
    brush.polygon(bow.map(|angle| at(0.2 + 1.1 * angle.cos(), angle.sin())).collect(), colour);
    let stroke = egui::Stroke::new(brush.at_least_px(0.018, 1.0) * brush.radius, colour);
    for ray in [-0.8, -0.4, 0.0, 0.4, 0.8] {
        brush.painter.line(vec![at(-0.1, ray), at(-1.3, ray)], stroke);
    }
}

/// Draws the guidance in the gap of the scale: an arrow, and the distance below it. In reverse the R stands there.
fn guidance(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let Some(guidance) = dial.guidance.as_ref().filter(|_| !dial.reverse) else { return };
    let (down, half, width) = layout::GUIDANCE;
    let colour = opaque(palette.needle);
    let points: Vec<Pos2> =
        guidance.arrow().iter().map(|[x, y]| brush.centre + vec2(x * half, down - y * half) * brush.radius).collect();
    let [.., before, tip] = &points[..] else { return };
    let along = (*tip - *before).normalized();
    let head = brush.radius * half;
    let neck = *tip - along * (0.55 * head);
    let across = along.rot90() * (0.42 * head);
    let shaft = points[..points.len() - 1].iter().copied().chain([neck]).collect();
    brush.painter.line(shaft, egui::Stroke::new(brush.at_least_px(width, 2.0) * brush.radius, colour));
    brush.polygon(vec![*tip, neck + across, neck - across], colour);
    let (height, down) = layout::GUIDANCE_DISTANCE;
    brush.text(&guidance.distance, brush.below(down), height, colour);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{hud::SpeedometerScale, units::SpeedUnit};
    use glam::Vec2;

    #[test]
    fn every_numeral_lies_between_the_hub_and_the_needle() {
        for full in [10.0, 15.0, 50.0, 80.0, 100.0, 120.0, 140.0, 160.0, 200.0, 240.0] {
            let dial = DialView::new(0.0, None, SpeedUnit::Kmh, SpeedometerScale::up_to(full), false);
            for ScaleNumeral { text, angle_rad, radius, height } in numerals(&dial) {
                let middle = Vec2::from_angle(angle_rad - std::f32::consts::FRAC_PI_2) * radius;
                let ink = lettering::set(&text).strokes.into_iter().flatten();
                let away = ink.map(|point| (middle + Vec2::from(point) * height).length()).collect::<Vec<f32>>();
                let [nearest, furthest] =
                    [away.iter().fold(1.0, |a: f32, b| a.min(*b)), away.iter().fold(0.0, |a: f32, b| a.max(*b))];
                let pen = lettering::PEN * height / 2.0;
                assert!(nearest - pen > layout::HUB, "{text} of {full}: {nearest}");
                assert!(furthest + pen < layout::NEEDLE.1 - NEEDLE_EDGE, "{text} of {full}: {furthest}");
            }
        }
    }
}
