//! Tests of the automation's telltales on the speedometer by their pixels.

use super::{hc22, ring_dial};
use codrive::{
    hud::Palette,
    snapshot::{AutomationMode, AutomationState},
};

#[test]
fn the_lamp_of_the_automation_has_the_colour_of_its_state() {
    let palette = Palette::HC22;
    let states = [
        (AutomationMode::Off, false, palette.label),
        (AutomationMode::On, false, palette.indicator),
        (AutomationMode::TakeoverRequest, false, palette.reverse),
        (AutomationMode::TakeoverRequest, true, palette.target),
    ];
    let dial = ring_dial(5.0, None);
    let dark = hc22(&dial);
    for steers in [true, false] {
        for (mode, is_urgent, colour) in states {
            let state = AutomationState { mode, is_urgent, steers, ..AutomationState::default() };
            // At 0 s a blinking lamp is lit. The gauge's arc is 45 pixels long, one of its width without another colour: 40 are nearly all.
            let lit = hc22(&dial.clone().automated(&state, 0.0));
            let more = lit.count(colour).saturating_sub(dark.count(colour));
            assert!(more > 40, "{mode:?}, steers {steers}: {more} pixels of {colour:?}");
        }
    }
}

#[test]
fn each_bar_of_the_time_gap_adds_its_area() {
    let dial = ring_dial(5.0, None);
    let lit = |time_gap_s| {
        let state = AutomationState { mode: AutomationMode::On, time_gap_s, ..AutomationState::default() };
        hc22(&dial.clone().automated(&state, 0.0)).count(Palette::HC22.indicator)
    };
    let [none, one, two, three] = [None, Some(1.0), Some(1.5), Some(2.0)].map(lit);
    // The vehicle, of two rows with 90 % of a bar's width together, is shown with every gap.
    assert!(one - none > two - one, "{none} {one} {two} {three}");
    assert!(two - one > 10 && three - two > 10 && three - two <= two - one, "{none} {one} {two} {three}");
}
