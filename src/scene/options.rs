//! Options of the picture, and values derived from them: the angle of view, the sun, the paints. In: settings, metres and
//! degrees. Out: [`ViewOptions`], which `view` reads.

use super::{MirrorOptions, ViewKind};
use crate::hud::Palette;
use crate::scenario::CockpitView;
use crate::snapshot::Weather;
use crate::traffic::{EGO, VehicleId};
use glam::Vec3;
use std::collections::BTreeMap;

/// Options of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewOptions {
    /// Driver's eye in the body's frame (x forward, y left, z up from the ground under the centre), metres.
    pub eye: Vec3,
    /// Width of the screen, metres.
    pub screen_width_m: f32,
    /// Distance from the participant's eye to the screen, metres.
    pub eye_distance_m: f32,
    /// Share of the body's pitch and roll that the driver's camera follows, 0..1; less reduces motion sickness.
    pub body_motion: f32,
    /// Parts of the ego that are visible in the driver's view.
    pub cockpit: CockpitView,
    /// Colours of the speedometer.
    pub palette: Palette,
    pub mirror: MirrorOptions,
    /// Direction of the sun: compass degrees, 0 north, clockwise.
    pub sun_azimuth_deg: f32,
    /// Height of the sun above the horizon, degrees.
    pub sun_elevation_deg: f32,
    /// Distance at which haze leaves 2 % of a contrast without rain, metres.
    pub visibility_m: f32,
    /// Intensity of the rain, mm/h; 0 is dry.
    pub rain_mmph: f32,
    /// Speed of the wind in trees, m/s.
    pub wind_mps: f32,
    /// The ego's paint, linear.
    pub ego_paint: [f32; 3],
    /// Linear paint of the others from above, and in every view if `ordinary_paints` is off.
    pub traffic_paint: [f32; 3],
    /// True if the others have ordinary paints, never red, in views from the road.
    pub ordinary_paints: bool,
    /// Linear paint of single vehicles in every view; takes precedence over all other rules.
    pub paint_overrides: BTreeMap<VehicleId, [f32; 3]>,
    /// Half the width that the bird's-eye view shows around the ego, metres; `None` shows the whole scene, and in a wide
    /// scene, such as a town, the ego with its surroundings.
    pub birdseye_follow_m: Option<f32>,
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self {
            eye: Vec3::new(0.10, 0.36, 1.18),
            // A 55-inch television, 16:9, at a distance of one metre: 63 degrees (docs/references.md: display).
            screen_width_m: 1.2176,
            eye_distance_m: 1.0,
            body_motion: 0.3,
            cockpit: CockpitView::default(),
            palette: Palette::default(),
            mirror: MirrorOptions::default(),
            sun_azimuth_deg: 130.0,
            sun_elevation_deg: 42.0,
            visibility_m: 30_000.0,
            rain_mmph: 0.0,
            wind_mps: 2.5,
            ego_paint: [0.479, 0.008, 0.006],
            traffic_paint: [0.030, 0.36, 0.060],
            ordinary_paints: true,
            paint_overrides: BTreeMap::new(),
            birdseye_follow_m: None,
        }
    }
}

impl ViewOptions {
    /// Returns the horizontal angle of view of the driver's picture, radians: the angle of the screen at the eye's distance, so
    /// that the picture's scale is 1.
    pub fn fov_x_rad(&self) -> f32 {
        2.0 * (self.screen_width_m / 2.0 / self.eye_distance_m).atan()
    }

    /// Returns the unit direction towards the sun.
    pub fn to_sun(&self) -> Vec3 {
        let (sin_a, cos_a) = self.sun_azimuth_deg.to_radians().sin_cos();
        let (sin_e, cos_e) = self.sun_elevation_deg.to_radians().sin_cos();
        Vec3::new(sin_a * cos_e, cos_a * cos_e, sin_e)
    }

    /// Returns the distance at which air and rain leave 2 % of a contrast, metres.
    pub fn sight_m(&self) -> f32 {
        // Extinction by rain, 1/km (docs/references.md: rain).
        let rain_per_m = 0.21e-3 * self.rain_mmph.powf(0.63);
        1.0 / (1.0 / self.visibility_m + rain_per_m / 3.912)
    }

    /// Returns true if vehicles have their headlamps on: from shortly before sunset to shortly after sunrise, in fog, and in rain.
    pub fn headlamps_lit(&self) -> bool {
        const LOW_SUN_DEG: f32 = 3.0;
        const FOG_M: f32 = 400.0;
        self.sun_elevation_deg < LOW_SUN_DEG || self.visibility_m < FOG_M || self.rain_mmph > 0.0
    }

    /// Returns the options in another weather, at another time of day.
    pub(super) fn in_weather(&self, weather: &Weather) -> Self {
        let (visibility_m, rain_mmph) = ((1000.0 * weather.visibility_km) as f32, weather.rain_mmph as f32);
        Self { visibility_m, rain_mmph, ..self.clone() }.at_hour(weather.time_h as f32)
    }

    /// Returns the options with the sun's position at a solar hour (12 is its highest) late in August at 48 degrees north: 43
    /// degrees high in the south-east at 9.75 h.
    #[must_use]
    pub fn at_hour(self, time_h: f32) -> Self {
        let (latitude, declination) = (48f32.to_radians(), 10f32.to_radians());
        let hour = (15.0 * (time_h - 12.0)).to_radians();
        // Axes: east, north, up.
        let east = -declination.cos() * hour.sin();
        let south = declination.cos() * hour.cos() * latitude.sin() - declination.sin() * latitude.cos();
        let up = declination.cos() * hour.cos() * latitude.cos() + declination.sin() * latitude.sin();
        Self { sun_azimuth_deg: east.atan2(-south).to_degrees(), sun_elevation_deg: up.asin().to_degrees(), ..self }
    }

    /// Returns the linear paint of a vehicle in a view.
    pub fn paint(&self, id: VehicleId, kind: ViewKind) -> [f32; 3] {
        if let Some(paint) = self.paint_overrides.get(&id) {
            return *paint;
        }
        match kind {
            _ if id == EGO => self.ego_paint,
            ViewKind::Birdseye => self.traffic_paint,
            _ if self.ordinary_paints => ordinary_paint(id),
            _ => self.traffic_paint,
        }
    }
}

/// Ordinary paints (most are white, grey and black), linear. No reds: red is the ego's.
const PAINTS: [[f32; 3]; 10] = [
    [0.72, 0.72, 0.70],
    [0.38, 0.40, 0.42],
    [0.115, 0.120, 0.130],
    [0.012, 0.012, 0.014],
    [0.025, 0.075, 0.230],
    [0.72, 0.72, 0.70],
    [0.020, 0.085, 0.048],
    [0.205, 0.215, 0.225],
    [0.400, 0.340, 0.245],
    [0.055, 0.135, 0.260],
];

/// Returns the paint of a vehicle, which is constant; vehicles with neighbouring ids differ.
pub(super) fn ordinary_paint(id: VehicleId) -> [f32; 3] {
    // 7 and 10 share no factor, so ten vehicles in a row have ten different paints; each group of ten begins one further.
    let n = PAINTS.len() as u32;
    PAINTS[((id.0 * 7 + id.0 / n) % n) as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_of_view_is_that_of_the_screen_from_the_eye() {
        let tv = ViewOptions::default();
        // docs/references.md: display: 55 inches at 1.0 m is 63 degrees.
        assert!((tv.fov_x_rad().to_degrees() - 63.0).abs() < 0.5, "{}", tv.fov_x_rad().to_degrees());
        let square = ViewOptions { screen_width_m: 2.0, eye_distance_m: 1.0, ..tv };
        assert!((square.fov_x_rad().to_degrees() - 90.0).abs() < 1e-4);
    }

    #[test]
    fn the_sun_is_at_its_compass_bearing() {
        let sun = ViewOptions { sun_azimuth_deg: 90.0, sun_elevation_deg: 0.0, ..ViewOptions::default() }.to_sun();
        assert!(sun.distance(Vec3::X) < 1e-6, "east: {sun}");
        let sun = ViewOptions::default().to_sun();
        assert!(sun.x > 0.0 && sun.y < 0.0 && sun.z > 0.6 && (sun.length() - 1.0).abs() < 1e-6, "south-east: {sun}");
    }

    #[test]
    fn the_sun_rises_in_the_east_and_is_highest_in_the_south_at_noon() {
        let at = |time_h| ViewOptions::default().at_hour(time_h);
        let (morning, noon, evening) = (at(6.5), at(12.0), at(17.5));
        assert!((noon.sun_azimuth_deg.abs() - 180.0).abs() < 0.1, "{}", noon.sun_azimuth_deg);
        assert!((noon.sun_elevation_deg - 52.0).abs() < 0.1, "{}", noon.sun_elevation_deg);
        assert!((60.0..110.0).contains(&morning.sun_azimuth_deg), "{}", morning.sun_azimuth_deg);
        assert!((-110.0..-60.0).contains(&evening.sun_azimuth_deg), "{}", evening.sun_azimuth_deg);
        assert!((5.0..20.0).contains(&morning.sun_elevation_deg), "{}", morning.sun_elevation_deg);
    }

    #[test]
    fn the_sun_sets_in_the_evening_and_headlamps_are_on_until_it_rises() {
        let at = |time_h| ViewOptions::default().at_hour(time_h);
        // cos H = -tan(48) tan(10): 6.76 h after noon.
        for (time_h, is_up) in [(18.7, true), (18.8, false), (24.0, false), (0.0, false), (5.2, false), (5.3, true)] {
            assert_eq!(at(time_h).sun_elevation_deg > 0.0, is_up, "{time_h} h");
        }
        for (time_h, lit) in
            [(3.0, true), (5.4, true), (6.0, false), (12.0, false), (18.0, false), (18.6, true), (23.0, true)]
        {
            assert_eq!(at(time_h).headlamps_lit(), lit, "{time_h} h");
        }
        let fog = ViewOptions { visibility_m: 200.0, ..ViewOptions::default() };
        assert!(fog.headlamps_lit());
        assert!(ViewOptions { rain_mmph: 0.5, ..ViewOptions::default() }.headlamps_lit());
    }

    #[test]
    fn rain_shortens_the_sight() {
        let sight_m =
            |rain_mmph, visibility_m| ViewOptions { rain_mmph, visibility_m, ..ViewOptions::default() }.sight_m();
        assert_eq!(sight_m(0.0, 30_000.0), 30_000.0);
        // By hand: 3.912 / (0.21 x 10^0.63) = 4.37 km in the clearest air, less where the air is hazy already.
        assert!((sight_m(10.0, 1e9) - 4370.0).abs() < 5.0, "{}", sight_m(10.0, 1e9));
        assert!((1.0 / sight_m(10.0, 5000.0) - (1.0 / 4370.0 + 1.0 / 5000.0)).abs() < 1e-6);
    }

    #[test]
    fn from_above_the_ego_is_red_and_all_others_are_green() {
        let options = ViewOptions::default();
        assert_eq!(options.paint(EGO, ViewKind::Birdseye), options.ego_paint);
        for id in 1..40 {
            assert_eq!(options.paint(VehicleId(id), ViewKind::Birdseye), options.traffic_paint);
        }
        let [r, g, b] = options.traffic_paint;
        assert!(g > 4.0 * r && g > 4.0 * b);
        let [r, g, b] = options.ego_paint;
        assert!(r > 10.0 * g && r > 10.0 * b);
    }

    #[test]
    fn paints_on_the_road_are_mixed_and_red_only_on_request() {
        let mut options = ViewOptions::default();
        let paints: Vec<_> = (1..=21).map(|id| options.paint(VehicleId(id), ViewKind::Driver)).collect();
        assert!(paints.iter().all(|[r, g, b]| *r < 1.5 * g.max(*b)), "no reds");
        assert!(paints.windows(2).all(|p| p[0] != p[1]), "neighbours differ");
        let mut kinds = paints.clone();
        kinds.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
        kinds.dedup();
        assert!(kinds.len() >= 8, "{}", kinds.len());
        options.paint_overrides.insert(VehicleId(21), [0.6, 0.0, 0.0]);
        assert_eq!(options.paint(VehicleId(21), ViewKind::Mirror), [0.6, 0.0, 0.0]);
        options.ordinary_paints = false;
        assert_eq!(options.paint(VehicleId(3), ViewKind::Driver), options.traffic_paint);
    }
}
