//! What a scenario says of the picture. In: a [`Scenario`]. Out: [`ViewOptions`].

use crate::{
    hud::Palette,
    scene::{MirrorOptions, ViewOptions},
    sim::{DialPalette, Scenario, colour},
};

/// What the scenario says of the picture.
pub fn view_options(scenario: &Scenario) -> ViewOptions {
    let usual = ViewOptions::default();
    ViewOptions {
        screen_width_m: scenario.screen_width_m as f32,
        eye_distance_m: scenario.eye_distance_m as f32,
        ordinary_paints: scenario.ordinary_paints,
        cockpit: scenario.cockpit,
        palette: match scenario.palette {
            DialPalette::Standard => Palette::HC22,
            DialPalette::ColourBlindSafe => Palette::COLOUR_BLIND_SAFE,
        },
        mirror: MirrorOptions {
            yaw_deg: scenario.mirror_yaw_deg as f32,
            pitch_deg: scenario.mirror_pitch_deg as f32,
            fov_x_deg: scenario.mirror_fov_deg as f32,
            radius_m: scenario.mirror_radius_m as f32,
            ..usual.mirror
        },
        ego_paint: colour::linear(&scenario.ego_colour).unwrap_or(usual.ego_paint),
        traffic_paint: colour::linear(&scenario.traffic_colour).unwrap_or(usual.traffic_paint),
        visibility_m: (1000.0 * scenario.visibility_km) as f32,
        wind_mps: scenario.wind_mps as f32,
        ..usual
    }
    .at_hour(scenario.time_h as f32)
}
