//! Rings of any length. In: circumference, speed limit, lane width. Out: a map's folder. The ring has one lane, runs counter-clockwise
//! around the origin and starts in the east; its centre line lies on the circle of that circumference. Metres, m/s.

use super::{
    MapError,
    write::{RoadEdge, net_xml, write_folder},
};
use glam::DVec2;
use std::{f64::consts::TAU, path::Path};

/// Allowed circumferences, metres. Below, a driver sees little but the bend; above, the numbers still work but a drive makes no sense.
pub const CIRCUMFERENCE_M: std::ops::RangeInclusive<f64> = 150.0..=5000.0;
/// Circumference above which the ring has eight edges instead of four, metres.
const LONG_M: f64 = 2000.0;
/// Largest deviation of a chord of the centre line from the circle, metres.
const SAG_M: f64 = 0.0035;

/// Dimensions and speed limit of a ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingShape {
    /// Length of one lap, metres, in [`CIRCUMFERENCE_M`].
    pub circumference_m: f64,
    /// Speed limit, m/s, 1 to 100.
    pub speed_limit_mps: f64,
    /// Lane width, metres, 2.5 to 10.
    pub width_m: f64,
}

impl RingShape {
    fn check(&self) -> Result<(), MapError> {
        let rows = [
            ("circumference", self.circumference_m, *CIRCUMFERENCE_M.start(), *CIRCUMFERENCE_M.end(), "m"),
            ("speed limit", self.speed_limit_mps, 1.0, 100.0, "m/s"),
            ("lane width", self.width_m, 2.5, 10.0, "m"),
        ];
        for (what, value, low, high, unit) in rows {
            if !(low..=high).contains(&value) {
                let allowed = format!("{low} to {high} {unit}");
                return Err(MapError::Parameter { what, value: value.to_string(), allowed });
            }
        }
        Ok(())
    }

    /// Returns the text of the ring's `net.xml`: lane lengths add up to the circumference within 8 um, and points lie at most 1 m apart.
    ///
    /// # Errors
    /// A number is out of range or not finite.
    pub fn net_xml(&self) -> Result<String, MapError> {
        self.check()?;
        let length_m = self.circumference_m;
        let radius_m = length_m / TAU;
        let edges = if length_m > LONG_M { 8 } else { 4 };
        // A chord c sags c^2 / (8 r) from its circle: 3.1 mm for 1 m on the ring of 250 m.
        let chord_m = (8.0 * radius_m * SAG_M).sqrt().min(1.0);
        let chords = (length_m / f64::from(edges) / chord_m).ceil() as u32;
        let point = |edge: u32, chord: u32| {
            let fraction = f64::from(edge * chords + chord) / f64::from(edges * chords);
            // The last point equals the first to the last bit.
            DVec2::from_angle(TAU * fraction.fract()) * radius_m
        };
        let road: Vec<RoadEdge> = (0..edges)
            .map(|edge| RoadEdge {
                length_m: length_m / f64::from(edges),
                speed_limit_mps: self.speed_limit_mps,
                width_m: self.width_m,
                shape: (0..=chords).map(|chord| point(edge, chord)).collect(),
            })
            .collect();
        let comment = format!(
            "A ring made by codrive: circumference {length_m} m, speed limit {} m/s, lane width {} m.",
            self.speed_limit_mps, self.width_m
        );
        Ok(net_xml(&comment, &road))
    }
}

/// Writes a ring as a new map's `folder`.
///
/// # Errors
/// A number is out of range, or the folder exists or cannot be written.
pub fn write(folder: &Path, ring: &RingShape, title: &str, description: &str) -> Result<(), MapError> {
    let net = ring.net_xml()?;
    write_folder(folder, &net, title, description)
}
