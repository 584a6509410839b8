//! Road signs that a map states, by the numbers of German signs. In: the type of a point, such as `traffic_sign.DE:274-50`, or a signal of
//! OpenDRIVE. Out: a [`StatedSign`].

use glam::DVec2;
use std::f64::consts::FRAC_PI_2;

/// Beginning of a sign's type, before its number.
pub(super) const SIGN: &str = "traffic_sign.DE:";
/// Largest speed limit on a sign.
const MOST_LIMIT: f64 = 200.0;
/// Distance between the pole of a sign or signal and the edge of the outermost lane, metres: beyond the shoulder.
pub const BESIDE_M: f64 = 0.95;

/// Road sign at a stated place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedSign {
    pub position: DVec2,
    /// Direction in which it faces, towards those for whom it holds, radians counter-clockwise from east.
    pub facing_rad: f64,
    pub kind: StatedSignKind,
}

impl StatedSign {
    /// Returns the compass direction in which it faces, degrees clockwise from north.
    pub(super) fn angle_deg(&self) -> f64 {
        (FRAC_PI_2 - self.facing_rad).to_degrees().rem_euclid(360.0)
    }

    /// Returns the direction of a compass angle, radians counter-clockwise from east.
    pub(in crate::map) fn facing_rad(angle_deg: f64) -> f64 {
        FRAC_PI_2 - angle_deg.to_radians()
    }
}

/// Kind of a stated sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatedSignKind {
    Stop,
    Yield,
    Roundabout,
    Priority,
    Zebra,
    /// Name of the place, where its streets begin.
    PlaceName,
    /// Speed limit, km/h or mph.
    SpeedLimit(u32),
}

impl StatedSignKind {
    /// Returns the kind of a German sign by its number and the number that it shows; `None` for all others.
    pub(in crate::map) fn of(number: &str, shown: Option<f64>) -> Option<Self> {
        Some(match number {
            "205" => Self::Yield,
            "206" => Self::Stop,
            "215" => Self::Roundabout,
            "274" => Self::SpeedLimit(shown.filter(|limit| (1.0..=MOST_LIMIT).contains(limit))?.round() as u32),
            "301" | "306" => Self::Priority,
            "310" => Self::PlaceName,
            "350" => Self::Zebra,
            _ => return None,
        })
    }

    /// Returns the kind by what follows [`SIGN`] in a type: the number, and behind a dash what the sign shows.
    pub(super) fn of_code(code: &str) -> Option<Self> {
        let (number, shown) = code.split_once('-').map_or((code, None), |(number, shown)| (number, shown.parse().ok()));
        Self::of(number, shown)
    }

    /// Returns the code that is read as this kind.
    pub(super) fn code(self) -> String {
        match self {
            Self::Yield => "205".into(),
            Self::Stop => "206".into(),
            Self::Roundabout => "215".into(),
            Self::SpeedLimit(limit) => format!("274-{limit}"),
            Self::Priority => "306".into(),
            Self::PlaceName => "310".into(),
            Self::Zebra => "350".into(),
        }
    }
}

/// Returns the limit of sign 274 by what follows its number in the older numbering: 51 to 63 are 10 to 130 km/h.
pub(in crate::map) fn older_limit(shown: f64) -> Option<f64> {
    (51.0..=63.0).contains(&shown).then_some((shown - 50.0) * 10.0)
}
