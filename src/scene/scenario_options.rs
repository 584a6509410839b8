//! Options of the picture from the scenario. In: a [`Scenario`]. Out: [`ViewOptions`].

use super::{MirrorOptions, ViewOptions};
use crate::{
    hud::Palette,
    scenario::{DialPalette, Scenario, colour},
};

/// Returns the options of the picture that the scenario sets.
pub fn view_options(scenario: &Scenario) -> ViewOptions {
    let usual = ViewOptions::default();
    ViewOptions {
        screen_width_m: scenario.display.screen_width_m as f32,
        eye_distance_m: scenario.display.eye_distance_m as f32,
        ordinary_paints: scenario.display.ordinary_paints,
        cockpit: scenario.display.cockpit,
        palette: match scenario.display.palette {
            DialPalette::Standard => Palette::HC22,
            DialPalette::ColourBlindSafe => Palette::COLOUR_BLIND_SAFE,
        },
        mirror: MirrorOptions {
            yaw_deg: scenario.display.mirror_yaw_deg as f32,
            pitch_deg: scenario.display.mirror_pitch_deg as f32,
            fov_x_deg: scenario.display.mirror_fov_deg as f32,
            radius_m: scenario.display.mirror_radius_m as f32,
            ..usual.mirror
        },
        ego_paint: colour::linear(&scenario.display.ego_colour).unwrap_or(usual.ego_paint),
        traffic_paint: colour::linear(&scenario.display.traffic_colour).unwrap_or(usual.traffic_paint),
        visibility_m: (1000.0 * scenario.display.visibility_km) as f32,
        rain_mmph: scenario.rain_mmph as f32,
        wind_mps: scenario.display.wind_mps as f32,
        ..usual
    }
    .at_hour(scenario.display.time_h as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::CockpitView;
    use crate::scenario::DisplaySettings;

    #[test]
    fn every_picture_setting_of_the_scenario_reaches_the_options() {
        let scenario = Scenario {
            display: DisplaySettings {
                screen_width_m: 1.25,
                eye_distance_m: 0.75,
                ordinary_paints: true,
                cockpit: CockpitView::Off,
                palette: DialPalette::ColourBlindSafe,
                mirror_yaw_deg: 3.0,
                mirror_pitch_deg: -2.0,
                mirror_fov_deg: 24.0,
                mirror_radius_m: 1.5,
                ego_colour: "#ffffff".into(),
                traffic_colour: "#000000".into(),
                visibility_km: 0.5,
                wind_mps: 7.0,
                ..DisplaySettings::default()
            },
            rain_mmph: 2.5,
            ..Scenario::default()
        };
        let options = view_options(&scenario);
        assert_eq!((options.screen_width_m, options.eye_distance_m), (1.25, 0.75));
        assert!(options.ordinary_paints);
        assert_eq!(options.cockpit, CockpitView::Off);
        assert_eq!(options.palette, Palette::COLOUR_BLIND_SAFE);
        let mirror = &options.mirror;
        assert_eq!([mirror.yaw_deg, mirror.pitch_deg, mirror.fov_x_deg, mirror.radius_m], [3.0, -2.0, 24.0, 1.5]);
        // White is 1 in every channel, black 0.
        assert!(options.ego_paint.iter().all(|part| (part - 1.0).abs() < 1e-6), "{:?}", options.ego_paint);
        assert!(options.traffic_paint.iter().all(|part| part.abs() < 1e-6), "{:?}", options.traffic_paint);
        assert_eq!((options.visibility_m, options.rain_mmph, options.wind_mps), (500.0, 2.5, 7.0));
        assert_eq!(view_options(&Scenario::default()).palette, Palette::HC22);
        // The sun is higher at noon than in the evening, and in another direction.
        let [noon, evening] = [12.0, 17.0].map(|time_h| {
            view_options(&Scenario {
                display: DisplaySettings { time_h, ..DisplaySettings::default() },
                ..Scenario::default()
            })
        });
        assert!(noon.sun_elevation_deg > evening.sun_elevation_deg + 10.0, "{noon:?}, {evening:?}");
        assert!((noon.sun_azimuth_deg - evening.sun_azimuth_deg).abs() > 10.0, "{noon:?}, {evening:?}");
    }
}
