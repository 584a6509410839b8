//! Indicator stalk. In: a key or button for one side, and the steering wheel's angle, radians. Out: the indicators that
//! are on. As in a car, the stalk stays where it was put and returns by itself when the wheel comes back from a turn.

use crate::controls::Indicator;

/// Wheel angle towards the stalk's side from which the wheel counts as turned, rad.
const TURNED_RAD: f32 = 60.0 * std::f32::consts::PI / 180.0;
/// Wheel angle towards the stalk's side below which a turned wheel counts as back, rad.
const BACK_RAD: f32 = 20.0 * std::f32::consts::PI / 180.0;

/// Position of the stalk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stalk {
    at: Indicator,
    has_turned: bool,
}

impl Stalk {
    /// Pushes the stalk to a side; a push to the side where it is puts it back to the middle.
    pub fn push(&mut self, side: Indicator) {
        *self = Self { at: if self.at == side { Indicator::Off } else { side }, has_turned: false };
    }

    /// Applies the angle of the steering wheel, positive to the left, and returns the position of the stalk.
    pub fn steered(&mut self, wheel_rad: f32) -> Indicator {
        let towards_rad = match self.at {
            Indicator::Off => return Indicator::Off,
            Indicator::Left => wheel_rad,
            Indicator::Right => -wheel_rad,
        };
        self.has_turned |= towards_rad > TURNED_RAD;
        if self.has_turned && towards_rad < BACK_RAD {
            *self = Self::default();
        }
        self.at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wheel(stalk: &mut Stalk, degrees: &[f32]) -> Vec<Indicator> {
        degrees.iter().map(|degrees| stalk.steered(degrees.to_radians())).collect()
    }

    #[test]
    fn the_stalk_stays_until_it_is_put_back() {
        use Indicator::{Left, Off, Right};
        let mut stalk = Stalk::default();
        assert_eq!(wheel(&mut stalk, &[0.0, 100.0, 0.0]), [Off; 3]);
        stalk.push(Left);
        // A change of lanes needs only small wheel angles.
        assert_eq!(wheel(&mut stalk, &[0.0, 15.0, 0.0, -15.0, 0.0]), [Left; 5]);
        stalk.push(Right);
        assert_eq!(wheel(&mut stalk, &[0.0]), [Right]);
        stalk.push(Right);
        assert_eq!(wheel(&mut stalk, &[0.0]), [Off]);
    }

    #[test]
    fn the_stalk_returns_when_the_wheel_comes_back_from_a_turn() {
        use Indicator::{Left, Off, Right};
        for (side, sign) in [(Left, 1.0), (Right, -1.0)] {
            let mut stalk = Stalk::default();
            stalk.push(side);
            // The wheel swings out against the turn, is held in the turn, and comes back.
            let way = [0.0, -70.0, 0.0, 30.0, 120.0, 90.0, 30.0, 10.0, 90.0].map(|degrees: f32| sign * degrees);
            let expected = [side, side, side, side, side, side, side, Off, Off];
            assert_eq!(wheel(&mut stalk, &way), expected);
        }
    }
}
