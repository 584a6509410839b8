//! The road from above with all vehicles. In: the centre line, the streets of a network, a [`Snapshot`]. Out: painted shapes, north up; the
//! ego red, the others green or coloured by their speed, the rest of a path blue.

use super::DriveLog;
use crate::{panel::theme, sim::Snapshot, space::Pose};
use egui::{Color32, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

/// Length and width of a vehicle, m.
const CAR_M: [f64; 2] = [5.0, 1.9];
/// Minimum length of a vehicle, so that it stays visible on a long road: as a share of the field's height, and its limits, points.
const LEAST_SHARE: f32 = 0.03;
const LEAST: [f32; 2] = [4.0, 10.0];
/// Enlargement of the ego, so that it is found at a glance.
const EGO_SIZE: f32 = 1.35;
/// Paint of vehicles as in HC22's bird's-eye view.
const EGO: Color32 = Color32::from_rgb(235, 64, 52);
const OTHERS: Color32 = Color32::from_rgb(70, 180, 90);

/// Land, streets, and a path: its part behind the ego and the one to come.
const GROUND: Color32 = Color32::from_rgb(28, 36, 30);
const ROAD: Color32 = Color32::from_rgb(62, 66, 74);
const DRIVEN: Color32 = Color32::from_rgb(84, 92, 110);
const TO_COME: Color32 = Color32::from_rgb(86, 136, 214);

/// Colour scale from standing to fast, as in the figures of an analysis.
const SHADES: [[u8; 3]; 9] = [
    [0x9c, 0x10, 0x10],
    [0xc8, 0x24, 0x34],
    [0xd6, 0x60, 0x4d],
    [0xf4, 0xa5, 0x82],
    [0xe0, 0xc9, 0x8c],
    [0xa6, 0xd3, 0xa0],
    [0x66, 0xbd, 0x9a],
    [0x32, 0x88, 0xbd],
    [0x3f, 0x66, 0xc4],
];

/// Returns the colour of a speed, given as a share of the speed at the end of the scale; clamped to 0 to 1.
pub fn shade(share: f64) -> Color32 {
    let at = if share.is_finite() { share.clamp(0.0, 1.0) * SHADES.len() as f64 } else { 0.0 };
    let [r, g, b] = SHADES[(at as usize).min(SHADES.len() - 1)];
    Color32::from_rgb(r, g, b)
}

/// Shows the map in a field of `width` by `height` points.
pub fn show(ui: &mut Ui, log: &DriveLog, snapshot: Option<&Snapshot>, by_speed: bool, width: f32, height: f32) {
    let (response, painter) = ui.allocate_painter(vec2(width, height), Sense::hover());
    paint(&painter, response.rect, log, snapshot, by_speed);
    response.on_hover_text(if by_speed {
        "All vehicles from above, north up, red standing to blue flowing; white edge: the participant"
    } else {
        "All vehicles from above, north up; red: the participant"
    });
}

/// Paints the map into a field.
pub fn paint(painter: &Painter, field: Rect, log: &DriveLog, snapshot: Option<&Snapshot>, by_speed: bool) {
    painter.rect_filled(field, 4.0, GROUND);
    let points = || log.road.iter().chain(log.streets.iter().flatten());
    let Some(place) = placing(points, log.road_width_m, field) else { return };
    let width = (log.road_width_m as f32 * place.points_a_m).max(3.0);
    let line = |points: &[[f64; 2]]| points.iter().map(|point| place.of(*point)).collect::<Vec<Pos2>>();
    let thin = Stroke::new(width.min(2.5), ROAD);
    painter.extend(log.streets.iter().map(|street| Shape::line(line(street), thin)));
    if log.is_closed {
        painter.add(Shape::closed_line(line(&log.road), Stroke::new(width, ROAD)));
    } else {
        // The path is drawn over the streets, and what is left of it over that.
        let to_come = log.road_to_come(snapshot.map_or(0.0, |now| now.ego_s_m));
        painter.add(Shape::line(line(&log.road), Stroke::new(width, DRIVEN)));
        painter.add(Shape::line(line(to_come), Stroke::new(width, TO_COME)));
    }
    let Some(now) = snapshot else { return };
    for car in &now.cars {
        let fill = if by_speed { shade(car.speed_mps / log.top_mps) } else { OTHERS };
        painter.add(car_shape(&place, &car.pose, 1.0, fill, Stroke::NONE));
    }
    painter.add(car_shape(&place, &now.ego.pose(), EGO_SIZE, EGO, Stroke::new(1.0, Color32::WHITE)));
}

/// Shows the key to the colours in one line.
pub fn key(ui: &mut Ui, top_mps: f64) {
    let small = |text: String| egui::RichText::new(text).color(theme::DIM).size(11.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.label(small("0 ".into()));
        for i in 0..SHADES.len() {
            let (_, rect) = ui.allocate_space(vec2(13.0, 8.0));
            ui.painter().rect_filled(rect, 0.0, shade((i as f64 + 0.5) / SHADES.len() as f64));
        }
        ui.label(small(format!(" {top_mps:.0} m/s")));
    });
}

/// Transform from metres to points.
struct MapTransform {
    middle_m: [f64; 2],
    middle: Pos2,
    points_a_m: f32,
    /// Minimum length of a vehicle, points.
    least: f32,
}

impl MapTransform {
    fn of(&self, [x, y]: [f64; 2]) -> Pos2 {
        let dx = (x - self.middle_m[0]) as f32 * self.points_a_m;
        let dy = (y - self.middle_m[1]) as f32 * self.points_a_m;
        pos2(self.middle.x + dx, self.middle.y - dy)
    }
}

/// Returns the transform that fits all these points into the field with a margin; `None` without points or room.
fn placing<'a, I>(points: impl Fn() -> I, width_m: f64, field: Rect) -> Option<MapTransform>
where
    I: Iterator<Item = &'a [f64; 2]>,
{
    let first = points().next()?;
    let (mut low, mut high) = (*first, *first);
    for point in points() {
        for axis in 0..2 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let span = [0, 1].map(|axis| (high[axis] - low[axis] + width_m).max(10.0) as f32);
    let room = field.shrink(10.0);
    let points_a_m = (room.width() / span[0]).min(room.height() / span[1]);
    let middle_m = [0, 1].map(|axis| (low[axis] + high[axis]) / 2.0);
    let least = (LEAST_SHARE * field.height()).clamp(LEAST[0], LEAST[1]);
    (points_a_m > 0.0).then_some(MapTransform { middle_m, middle: field.center(), points_a_m, least })
}

/// Returns a vehicle's outline: a box with a pointed nose that shows its heading.
fn car_shape(place: &MapTransform, pose: &Pose, size: f32, fill: Color32, edge: Stroke) -> Shape {
    let middle = place.of(pose.position.to_array());
    let length = size * (CAR_M[0] as f32 * place.points_a_m).max(place.least);
    let half = 0.5 * size * (CAR_M[1] as f32 * place.points_a_m).max(0.45 * place.least);
    let (sin, cos) = (pose.yaw_rad as f32).sin_cos();
    let at = |along: f32, left: f32| middle + vec2(along * cos - left * sin, -(along * sin + left * cos));
    let (nose, shoulder) = (length / 2.0, length / 6.0);
    let outline = vec![at(-nose, half), at(shoulder, half), at(nose, 0.0), at(shoulder, -half), at(-nose, -half)];
    Shape::convex_polygon(outline, fill, edge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn the_road_fits_the_field_north_up_and_vehicles_point_ahead() {
        let road: Vec<[f64; 2]> = (0..100)
            .map(|i| f64::from(i) / 100.0 * std::f64::consts::TAU)
            .map(|angle| [100.0 + 40.0 * angle.cos(), 40.0 * angle.sin()])
            .collect();
        let field = Rect::from_min_size(pos2(10.0, 20.0), vec2(200.0, 120.0));
        let place = placing(|| road.iter(), 4.0, field).unwrap();
        assert!(road.iter().all(|point| field.contains(place.of(*point))));
        assert!((place.points_a_m - 100.0 / 84.0).abs() < 1e-3, "{}", place.points_a_m);
        assert!(place.of([100.0, 40.0]).y < place.of([100.0, -40.0]).y, "north is up");
        let pose = Pose::new(DVec2::new(100.0, 0.0), std::f64::consts::FRAC_PI_2);
        let Shape::Path(path) = car_shape(&place, &pose, 1.0, EGO, Stroke::NONE) else { panic!() };
        let nose = path.points[2];
        assert!(path.points.iter().all(|point| point.y >= nose.y), "heading north, the nose is on top");
    }

    #[test]
    fn standing_is_red_flowing_is_blue_and_speeds_beyond_the_scale_clamp() {
        assert_eq!(shade(0.0), shade(-1.0));
        assert_eq!(shade(1.0), shade(9.0));
        assert_eq!(shade(f64::NAN), shade(0.0));
        assert!(shade(0.0).r() > shade(0.0).b() && shade(1.0).b() > shade(1.0).r());
    }
}
