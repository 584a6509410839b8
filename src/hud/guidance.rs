//! Guidance as the dial shows it. In: the next manoeuvre of the path. Out: its arrow, as strokes, and the distance, as text.

use crate::{
    map::{Manoeuvre, NextManoeuvre},
    units::SpeedUnit,
};

/// Largest distance of a manoeuvre that is shown, metres: a minute on a motorway.
const SHOWN_M: f64 = 2000.0;
/// Metres in a foot and in a mile.
const FOOT_M: f64 = 0.3048;
const MILE_M: f64 = 1609.344;

/// Next manoeuvre on the dial.
#[derive(Clone, Debug, PartialEq)]
pub struct DialGuidance {
    pub manoeuvre: Manoeuvre,
    /// Distance with its unit, rounded; empty within the junction.
    pub distance: String,
}

impl DialGuidance {
    /// Returns the guidance to a manoeuvre in the units of a dial; `None` if it is far away.
    pub fn to(next: NextManoeuvre, unit: SpeedUnit) -> Option<Self> {
        (next.ahead_m <= SHOWN_M)
            .then(|| Self { manoeuvre: next.manoeuvre, distance: distance_text(next.ahead_m, unit) })
    }

    /// Returns the line of the arrow from its foot to its tip: x to the right and y up, -1..1.
    pub fn arrow(&self) -> Vec<[f32; 2]> {
        let line: &[[f32; 2]] = match self.manoeuvre {
            Manoeuvre::Left | Manoeuvre::Right => &[[-0.45, -1.0], [-0.45, 0.35], [0.95, 0.35]],
            Manoeuvre::KeepLeft | Manoeuvre::KeepRight => &[[-0.35, -1.0], [-0.35, -0.15], [0.55, 0.95]],
            Manoeuvre::TurnAround => &[[0.5, -1.0], [0.5, 0.6], [-0.5, 0.6], [-0.5, -0.6]],
            Manoeuvre::Roundabout { exit_deg, is_clockwise } => return round_arrow(exit_deg, is_clockwise),
        };
        let is_left = matches!(self.manoeuvre, Manoeuvre::Left | Manoeuvre::KeepLeft);
        line.iter().map(|[x, y]| [if is_left { -x } else { *x }, *y]).collect()
    }
}

/// Returns the line of an arrow around a circle: in from below, out to the exit.
fn round_arrow(exit_deg: i16, is_clockwise: bool) -> Vec<[f32; 2]> {
    const RADIUS: f32 = 0.45;
    /// Beyond this, the exit is the way in, after a whole round.
    const BACK_DEG: f32 = 150.0;
    let exit_deg = f32::from(exit_deg);
    // Angles anticlockwise from the right; the way in is at -90 degrees.
    let out_deg = match is_clockwise {
        false if exit_deg < -BACK_DEG => exit_deg + 450.0,
        false => exit_deg + 90.0,
        true if exit_deg > BACK_DEG => exit_deg - 630.0,
        true => exit_deg - 270.0,
    };
    let at = |degrees: f32, radius: f32| [radius * degrees.to_radians().cos(), radius * degrees.to_radians().sin()];
    let arc = (0..=12).map(|k| at(-90.0 + (out_deg + 90.0) * k as f32 / 12.0, RADIUS));
    [[0.0, -1.0]].into_iter().chain(arc).chain([at(out_deg, 1.0)]).collect()
}

/// Returns a distance as navigation devices show it: in steps of 10, 50 or 100 m, or of 50 feet and tenths of a mile.
pub(super) fn distance_text(distance_m: f64, unit: SpeedUnit) -> String {
    let stepped = |value: f64, step: f64| (value / step).round() * step;
    match unit {
        _ if distance_m <= 0.0 => String::new(),
        SpeedUnit::Kmh if distance_m < 195.0 => format!("{:.0} m", stepped(distance_m, 10.0)),
        SpeedUnit::Kmh if distance_m < 975.0 => format!("{:.0} m", stepped(distance_m, 50.0)),
        SpeedUnit::Kmh => format!("{:.1} km", distance_m / 1000.0),
        SpeedUnit::Mph if distance_m < 975.0 * FOOT_M => format!("{:.0} ft", stepped(distance_m / FOOT_M, 50.0)),
        SpeedUnit::Mph => format!("{:.1} mi", distance_m / MILE_M),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_rounded_as_they_come_nearer() {
        for (distance_m, kmh, mph) in [
            (1840.0, "1.8 km", "1.1 mi"),
            (980.0, "1.0 km", "0.6 mi"),
            (640.0, "650 m", "0.4 mi"),
            (203.0, "200 m", "650 ft"),
            (92.0, "90 m", "300 ft"),
            (0.0, "", ""),
        ] {
            assert_eq!(distance_text(distance_m, SpeedUnit::Kmh), kmh, "{distance_m} m");
            assert_eq!(distance_text(distance_m, SpeedUnit::Mph), mph, "{distance_m} m");
        }
    }

    #[test]
    fn arrows_point_to_their_side_and_far_manoeuvres_are_not_shown() {
        let to = |manoeuvre, ahead_m| DialGuidance::to(NextManoeuvre { manoeuvre, ahead_m }, SpeedUnit::Kmh);
        let tip = |manoeuvre| to(manoeuvre, 50.0).expect("near").arrow().last().copied().expect("a line");
        assert!(tip(Manoeuvre::Left)[0] < -0.5 && tip(Manoeuvre::KeepLeft)[0] < -0.3);
        assert!(tip(Manoeuvre::Right)[0] > 0.5 && tip(Manoeuvre::KeepRight)[0] > 0.3);
        assert!(tip(Manoeuvre::TurnAround)[1] < 0.0, "back");
        let round = |exit_deg, is_clockwise| tip(Manoeuvre::Roundabout { exit_deg, is_clockwise });
        for is_clockwise in [false, true] {
            assert!(round(0, is_clockwise)[1] > 0.9, "straight on");
            assert!(round(-90, is_clockwise)[0] > 0.9 && round(90, is_clockwise)[0] < -0.9, "right and left");
        }
        // With right-hand traffic one keeps to the right on the way to the left.
        let left = to(Manoeuvre::Roundabout { exit_deg: 90, is_clockwise: false }, 50.0).expect("near").arrow();
        assert!(left.iter().any(|[x, _]| *x > 0.4), "{left:?}");
        assert_eq!(to(Manoeuvre::Left, 2001.0), None);
    }
}
