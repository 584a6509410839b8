//! Pictures that lit signal lamps show: a full disc, an arrow, a walking or a standing person, a bicycle. In: whom a head is for. Out: discs of
//! light on the lens, as the diodes of real lamps. Metres.

use super::signals::LAMP_M;
use crate::map::network::{LaneId, Network, SignalId, SignalLight, TurnDirection};
use glam::Vec2;

/// Radius of a lamp for those who walk or cycle.
pub(super) const SMALL_LAMP_M: f32 = 0.1;
/// Radius of one disc of an arrow, of a person, and of a bicycle.
const ARROW_DISC_M: f32 = 0.031;
const PERSON_DISC_M: f32 = 0.022;
const BICYCLE_DISC_M: f32 = 0.01;
/// Arrow up: its shaft, then its head.
const ARROW: [[f32; 2]; 9] = [
    [0.0, -0.105],
    [0.0, -0.06],
    [0.0, -0.015],
    [0.0, 0.03],
    [0.0, 0.085],
    [-0.045, 0.045],
    [0.045, 0.045],
    [-0.088, 0.0],
    [0.088, 0.0],
];
/// Person who stands, and person who walks to the left.
const STANDING: [[f32; 2]; 6] =
    [[0.0, 0.068], [-0.02, 0.022], [0.02, 0.022], [0.0, -0.015], [-0.014, -0.06], [0.014, -0.06]];
const WALKING: [[f32; 2]; 7] =
    [[-0.008, 0.068], [0.0, 0.022], [-0.036, 0.008], [0.036, 0.012], [0.004, -0.02], [-0.034, -0.062], [0.036, -0.058]];

/// Bicycle that goes to the left: two wheels, then frame, saddle and handlebar.
const BICYCLE: [[f32; 2]; 25] = [
    [-0.017, -0.010],
    [-0.034, 0.007],
    [-0.058, 0.007],
    [-0.075, -0.010],
    [-0.075, -0.034],
    [-0.058, -0.051],
    [-0.034, -0.051],
    [-0.017, -0.034],
    [0.075, -0.010],
    [0.058, 0.007],
    [0.034, 0.007],
    [0.017, -0.010],
    [0.017, -0.034],
    [0.034, -0.051],
    [0.058, -0.051],
    [0.075, -0.034],
    [-0.038, 0.012],
    [-0.030, 0.040],
    [-0.042, 0.050],
    [-0.008, 0.030],
    [0.014, 0.028],
    [-0.016, 0.004],
    [0.002, -0.018],
    [0.024, 0.050],
    [0.024, -0.020],
];

/// Picture on the lamps of a head.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SignalFace {
    /// Full discs: for all who leave the lane.
    Full,
    /// Arrows, by their angle from straight up to the left, radians: the head rules this turn alone, and on green no other way crosses it.
    Arrow(f32),
    /// Persons: for those who walk across the road.
    Walkers,
    /// Bicycles: for a lane without motor vehicles.
    Bicycles,
}

impl SignalFace {
    /// Returns the face for a lane of which a connection with this direction is shown.
    pub(super) fn of(net: &Network, lane: LaneId, (shown, signal, link): (TurnDirection, SignalId, u32)) -> Self {
        if net.lane(lane).is_for_bicycles() {
            return Self::Bicycles;
        }
        let Some(turn_rad) = turn_rad(shown) else { return Self::Full };
        let ways = || net.connections_from(lane).iter().filter(|way| !way.is_turnaround());
        let has_one_turn = ways().all(|way| way.direction == shown);
        // On a permissive green, those who turn give way to others: that is a full disc.
        let programs = &net.signal(signal).programs;
        let lights = || programs.iter().flat_map(|program| &program.phases).filter_map(|phase| phase.light(link));
        let is_protected = lights().any(|light| light == SignalLight::GreenMajor)
            && !lights().any(|light| light == SignalLight::GreenMinor);
        if has_one_turn && is_protected { Self::Arrow(turn_rad) } else { Self::Full }
    }

    /// Returns the discs of lamp `lamp`, 0 to 2 from the top, to the right and up from its middle as seen by those for whom it shines; and
    /// their radius.
    pub(super) fn discs(self, lamp: usize) -> (impl Iterator<Item = Vec2>, f32) {
        let (discs, radius_m, turn_rad): (&[[f32; 2]], f32, f32) = match self {
            Self::Full => (&[[0.0, 0.0]], LAMP_M, 0.0),
            Self::Arrow(turn_rad) => (&ARROW, ARROW_DISC_M, turn_rad),
            Self::Walkers if lamp == 0 => (&STANDING, PERSON_DISC_M, 0.0),
            Self::Walkers => (&WALKING, PERSON_DISC_M, 0.0),
            Self::Bicycles => (&BICYCLE, BICYCLE_DISC_M, 0.0),
        };
        let turn = Vec2::from_angle(turn_rad);
        (discs.iter().map(move |disc| turn.rotate(Vec2::from(*disc))), radius_m)
    }
}

/// Returns the angle of an arrow for a turn, from straight up to the left, radians; `None` for the way straight on, and back.
fn turn_rad(direction: TurnDirection) -> Option<f32> {
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
    match direction {
        TurnDirection::Left => Some(FRAC_PI_2),
        TurnDirection::PartLeft => Some(FRAC_PI_4),
        TurnDirection::Right => Some(-FRAC_PI_2),
        TurnDirection::PartRight => Some(-FRAC_PI_4),
        _ => None,
    }
}
