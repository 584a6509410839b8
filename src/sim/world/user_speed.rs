//! Speed of a road user that events move. In: an action, the speeds and places of other vehicles. Out: the speed a tick later. Metres, m/s, seconds.

use crate::{
    scenario::scripted_event::{ChangeShape, Meeting, SpeedChange},
    time::TICK_S,
};

/// Speed at which a vehicle stands, m/s, and distance at which it is at its place, m.
const STANDS_MPS: f64 = 1e-6;
const THERE_M: f64 = 0.01;
/// Speed difference at which the speed on the way to a meeting goes evenly to the last one, m/s.
const NEARLY_MPS: f64 = 0.1;

/// Vehicle as a road user sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenVehicle {
    /// Front on the route, m.
    pub front_m: f64,
    /// Speed along the route, m/s, positive in its direction.
    pub along_mps: f64,
    pub speed_mps: f64,
}

/// Other vehicles by name, where a tick begins; `None` for one that is not there.
pub(super) type SeenVehicles<'a> = &'a dyn Fn(&str) -> Option<SeenVehicle>;

/// Control of the speed of a road user.
pub(super) enum UserSpeed {
    /// Speed that stays as it is.
    Keeps,
    /// Speed that changes over a time.
    Changes(SpeedRamp),
    /// Speed of another vehicle until another action replaces this one, with the number of the event and the largest acceleration and deceleration,
    /// m/s2.
    Follows(usize, Target, [f64; 2]),
    /// Speed for a meeting, to which these distances were left a tick ago, m.
    Meets(usize, Meeting, Option<[f64; 2]>),
}

/// Change of the speed over a time.
pub(super) struct SpeedRamp {
    event: usize,
    from_mps: f64,
    to: Target,
    extent: Extent,
    shape: ChangeShape,
    passed_s: f64,
    /// Time for which the last speed is kept before the action is over.
    keep_s: f64,
    /// True to follow the other vehicle's speed after the change.
    follows: bool,
    /// Largest acceleration and deceleration, m/s2.
    most_mps2: [f64; 2],
}

/// Speed at the end of a change.
#[derive(Clone)]
pub(super) enum Target {
    Fixed(f64),
    /// Speed of the vehicle of this name, multiplied by the first number and increased by the second, m/s.
    Like(String, f64, f64),
}

#[derive(Clone, Copy)]
enum Extent {
    Seconds(f64),
    /// Steepest change, m/s2.
    Rate(f64),
}

impl UserSpeed {
    /// Begins a change of the speed, with at most these accelerations and decelerations, m/s2. One that takes no time is done at once.
    pub fn change(
        event: usize,
        change: &SpeedChange,
        most_mps2: [f64; 2],
        (speed_mps, others): (&mut f64, SeenVehicles),
    ) -> Self {
        let to = match &change.like {
            Some(like) => Target::Like(like.clone(), change.times, change.plus_mps),
            None => Target::Fixed(change.to_mps.unwrap_or(0.0)),
        };
        let to_mps = to.speed_mps(others).unwrap_or(*speed_mps);
        let extent = match (change.rate_mps2, change.in_m) {
            (Some(rate_mps2), _) => Extent::Rate(rate_mps2),
            // All shapes cover a distance with the mean of both speeds.
            (None, Some(in_m)) => Extent::Seconds(2.0 * in_m / (*speed_mps + to_mps).max(STANDS_MPS)),
            (None, None) => Extent::Seconds(change.in_s.unwrap_or(0.0)),
        };
        let (shape, follows) = (change.shape, change.keeps);
        let from_mps = *speed_mps;
        let ramp = SpeedRamp { event, from_mps, to, extent, shape, passed_s: 0.0, keep_s: 0.0, follows, most_mps2 };
        if ramp.lasts_s(to_mps) <= 0.0 {
            *speed_mps = to_mps;
        }
        Self::Changes(ramp)
    }

    /// Begins an even change of the speed at a rate, after which it is kept for a time.
    pub fn evenly(event: usize, from_mps: f64, to_mps: f64, rate_mps2: f64, keep_s: f64) -> Self {
        Self::Changes(SpeedRamp {
            event,
            from_mps,
            to: Target::Fixed(to_mps),
            extent: Extent::Rate(rate_mps2),
            shape: ChangeShape::Linear,
            passed_s: 0.0,
            keep_s,
            follows: false,
            most_mps2: [f64::INFINITY; 2],
        })
    }

    /// Returns the number of the event whose action controls the speed.
    pub fn event(&self) -> Option<usize> {
        match self {
            Self::Keeps => None,
            Self::Changes(ramp) => Some(ramp.event),
            Self::Follows(event, ..) | Self::Meets(event, ..) => Some(*event),
        }
    }

    /// Takes the speed on by a tick; `own` is the road user where it begins. Returns the speed at its end, m/s.
    pub fn step(&mut self, own: SeenVehicle, others: SeenVehicles) -> f64 {
        let speed_mps = own.speed_mps;
        let next_mps = match self {
            Self::Keeps => speed_mps,
            Self::Changes(ramp) => {
                ramp.passed_s += TICK_S;
                let to_mps = ramp.to.speed_mps(others).unwrap_or(speed_mps);
                let (lasts_s, passed_s) = (ramp.lasts_s(to_mps), ramp.passed_s + TICK_S / 2.0);
                if passed_s < lasts_s {
                    ramp.from_mps + (to_mps - ramp.from_mps) * ramp.shape.done(ramp.passed_s / lasts_s)
                } else {
                    if passed_s >= lasts_s + ramp.keep_s {
                        *self = match ramp.follows {
                            true => Self::Follows(ramp.event, ramp.to.clone(), ramp.most_mps2),
                            false => Self::Keeps,
                        };
                    }
                    to_mps
                }
            }
            Self::Follows(_, target, [accel_mps2, decel_mps2]) => {
                let change_mps = target.speed_mps(others).unwrap_or(speed_mps) - speed_mps;
                speed_mps + change_mps.clamp(-*decel_mps2 * TICK_S, *accel_mps2 * TICK_S)
            }
            Self::Meets(_, meeting, left_before) => match others(&meeting.with) {
                None => {
                    *self = Self::Keeps;
                    speed_mps
                }
                Some(with) => {
                    let left_m = [meeting.place_m - own.front_m, meeting.with_place_m - with.front_m].map(f64::abs);
                    let has_missed =
                        left_before.is_some_and(|before| (0..2).any(|k| left_m[k] > before[k] + STANDS_MPS));
                    *left_before = Some(left_m);
                    let time_s = left_m[1] / with.along_mps.abs().max(STANDS_MPS);
                    let to_mps = meeting.to_mps;
                    if has_missed || time_s < TICK_S || left_m.iter().any(|m| *m < THERE_M) {
                        *self = Self::Keeps;
                        to_mps.unwrap_or(speed_mps)
                    } else if with.along_mps.abs() <= STANDS_MPS {
                        0.0
                    } else {
                        on_the_way(speed_mps, left_m[0], time_s, to_mps)
                    }
                }
            },
        };
        next_mps.max(0.0)
    }
}

impl Target {
    /// Returns the speed, m/s; `None` if the other vehicle is not there.
    fn speed_mps(&self, others: SeenVehicles) -> Option<f64> {
        match self {
            Self::Fixed(speed_mps) => Some(*speed_mps),
            Self::Like(name, times, plus_mps) => others(name).map(|seen| (seen.speed_mps * times + plus_mps).max(0.0)),
        }
    }
}

impl SpeedRamp {
    /// Returns the duration of the change, s: at a rate, the shape's steepest slope has that rate. It is at most the largest one.
    fn lasts_s(&self, to_mps: f64) -> f64 {
        let change_mps = to_mps - self.from_mps;
        let at_rate_s = |rate_mps2: f64| change_mps.abs() * self.shape.steepest() / rate_mps2;
        let least_s = at_rate_s(self.most_mps2[usize::from(change_mps < 0.0)]);
        match self.extent {
            Extent::Seconds(seconds) => seconds.max(least_s),
            Extent::Rate(rate_mps2) => at_rate_s(rate_mps2).max(least_s),
        }
    }
}

/// Returns the speed a tick later on the way to a meeting, so that the distance that is left is covered in the time that is left. Without a speed at the
/// end it changes evenly. With one, it changes evenly to a middle speed, and from there as fast to the last one.
fn on_the_way(speed_mps: f64, left_m: f64, time_s: f64, to_mps: Option<f64>) -> f64 {
    let Some(to_mps) = to_mps else {
        return speed_mps + 2.0 * (left_m / time_s - speed_mps) / time_s * TICK_S;
    };
    // An even change from now on that ends with the last speed.
    let even_mps = 2.0 * left_m / time_s - to_mps;
    if (speed_mps - even_mps).abs() < NEARLY_MPS {
        return even_mps;
    }
    if (to_mps - speed_mps).abs() < STANDS_MPS {
        return speed_mps + 4.0 * (left_m / time_s - speed_mps) / time_s * TICK_S;
    }
    // The middle speed v after the time x, with the same rate a before and after: v = v0 + a x, v1 = v - a (T - x), and the distance is d.
    let (v0, v1, d, t) = (speed_mps, to_mps, left_m, time_s);
    let root = (2.0 * (2.0 * d * d - 2.0 * (v1 + v0) * t * d + (v1 * v1 + v0 * v0) * t * t)).max(0.0).sqrt();
    let ways =
        [-root, root].map(|root| ((root - 2.0 * d + 2.0 * v1 * t) / (2.0 * (v1 - v0)), (2.0 * d + root) / (2.0 * t)));
    let way = ways.into_iter().find(|(x, _)| *x > 0.0 && *x < t);
    speed_mps + way.map_or(0.0, |(x, middle_mps)| (middle_mps - v0) / x) * TICK_S
}

#[cfg(test)]
mod tests {
    use super::*;

    const OTHER: SeenVehicle = SeenVehicle { front_m: 0.0, along_mps: 20.0, speed_mps: 20.0 };

    fn own(front_m: f64, speed_mps: f64) -> SeenVehicle {
        SeenVehicle { front_m, along_mps: speed_mps, speed_mps }
    }

    /// Drives until the speed is free again. Returns way, time and last speed.
    fn driven(control: &mut UserSpeed, from_mps: f64) -> (f64, f64, f64) {
        let (mut speed_mps, mut way_m, mut time_s) = (from_mps, 0.0, 0.0);
        while control.event().is_some() {
            let next_mps = control.step(own(way_m, speed_mps), &|_| Some(OTHER));
            way_m += (speed_mps + next_mps) / 2.0 * TICK_S;
            time_s += TICK_S;
            speed_mps = next_mps;
        }
        (way_m, time_s, speed_mps)
    }

    const FREE: [f64; 2] = [f64::INFINITY; 2];

    fn change(text: &str, from_mps: f64) -> (f64, f64, f64) {
        limited(text, from_mps, FREE)
    }

    fn limited(text: &str, from_mps: f64, most_mps2: [f64; 2]) -> (f64, f64, f64) {
        let change: SpeedChange = toml::from_str(&format!("vehicle = \"a\"\n{text}")).expect("an action");
        let mut speed_mps = from_mps;
        let mut control = UserSpeed::change(7, &change, most_mps2, (&mut speed_mps, &|_| Some(OTHER)));
        assert_eq!(control.event(), Some(7));
        driven(&mut control, speed_mps)
    }

    #[test]
    fn a_change_that_needs_more_than_the_largest_acceleration_takes_longer() {
        // A cubic over 25 m/s is steepest with 1.5 times 25 m/s over its time: at 5 m/s2 after 7.5 s.
        let (_, time_s, end_mps) = limited("to_mps = 25\nin_s = 4\nshape = \"cubic\"", 0.0, [5.0, 9.0]);
        assert!((time_s - 7.5).abs() < 0.011 && end_mps == 25.0, "{time_s} {end_mps}");
        let (_, time_s, _) = limited("to_mps = 0\nin_s = 4\nshape = \"cubic\"", 25.0, [5.0, 15.0]);
        assert!((time_s - 4.0).abs() < 0.011, "{time_s}: braking has a limit of its own");
        let (way_m, time_s, _) = limited("to_mps = 0", 20.0, [5.0, 8.0]);
        assert!(
            (time_s - 2.5).abs() < 0.011 && (way_m - 25.0).abs() < 0.2,
            "{way_m} {time_s}: at once is as fast as possible"
        );
    }

    #[test]
    fn each_shape_takes_the_time_and_the_way_of_its_closed_form() {
        // From 30 to 10 m/s in 4 s: 80 m for every shape, as each is symmetric. At 4 m/s2 at its steepest the cubic takes 1.5, the cosine pi/2 times as
        // long as the even change of 5 s. Over 60 m the mean speed of 20 m/s takes 3 s.
        for (text, way_m, time_s) in [
            ("to_mps = 10\nin_s = 4", 80.0, 4.0),
            ("to_mps = 10\nin_s = 4\nshape = \"cubic\"", 80.0, 4.0),
            ("to_mps = 10\nin_s = 4\nshape = \"sinusoidal\"", 80.0, 4.0),
            ("to_mps = 10\nrate_mps2 = 4", 100.0, 5.0),
            ("to_mps = 10\nrate_mps2 = 4\nshape = \"cubic\"", 150.0, 7.5),
            ("to_mps = 10\nrate_mps2 = 4\nshape = \"sinusoidal\"", 157.08, 7.854),
            ("to_mps = 10\nin_m = 60\nshape = \"cubic\"", 60.0, 3.0),
        ] {
            let (way, time, last_mps) = change(text, 30.0);
            assert!((time - time_s).abs() < 1.01 * TICK_S, "{text}: {time} s");
            // The last tick may be kept at the last speed for a part.
            assert!((way - way_m).abs() < 0.11 && last_mps == 10.0, "{text}: {way} m, {last_mps} m/s");
        }
    }

    #[test]
    fn a_speed_like_another_is_multiplied_and_followed() {
        assert_eq!(change("like = \"ego\"\ntimes = 1.2\nplus_mps = 1", 30.0).2, 25.0);
        let follows: SpeedChange = toml::from_str("vehicle = \"a\"\nlike = \"ego\"\nkeeps = true").expect("an action");
        let mut speed_mps = 3.0;
        let mut control = UserSpeed::change(0, &follows, FREE, (&mut speed_mps, &|_| Some(OTHER)));
        assert_eq!(speed_mps, 20.0, "at once");
        control.step(own(0.0, speed_mps), &|_| Some(OTHER));
        let slower = SeenVehicle { speed_mps: 12.0, ..OTHER };
        assert_eq!(control.step(own(0.0, speed_mps), &|_| Some(slower)), 12.0);
        assert_eq!(control.event(), Some(0), "until another action replaces it");
    }

    #[test]
    fn a_meeting_is_at_its_place_when_the_other_is_at_its_own() {
        for (to_mps, from_mps, place_m) in
            [(None, 10.0, 250.0), (Some(15.0), 10.0, 220.0), (Some(20.0), 20.0, 180.0), (Some(5.0), 25.0, 240.0)]
        {
            let meeting = Meeting { vehicle: "a".into(), place_m, with: "ego".into(), with_place_m: 200.0, to_mps };
            let mut control = UserSpeed::Meets(1, meeting, None);
            let (mut own_m, mut speed_mps, mut tick) = (0.0, from_mps, 0);
            while control.event().is_some() {
                // The other drives 200 m at 20 m/s: 10 s.
                let other = SeenVehicle { front_m: 20.0 * TICK_S * f64::from(tick), ..OTHER };
                let next_mps = control.step(own(own_m, speed_mps), &|_| Some(other));
                if control.event().is_some() {
                    own_m += (speed_mps + next_mps) / 2.0 * TICK_S;
                    tick += 1;
                }
                speed_mps = next_mps;
            }
            let time_s = f64::from(tick) * TICK_S;
            assert!(
                (time_s - 10.0).abs() < 0.1 && (own_m - place_m).abs() < 0.5,
                "{to_mps:?}: {own_m} m at {time_s} s"
            );
            assert!(to_mps.is_none_or(|to_mps| (speed_mps - to_mps).abs() < 0.1), "{to_mps:?}: {speed_mps}");
        }
    }

    #[test]
    fn an_even_change_keeps_its_last_speed_for_a_time() {
        let mut control = UserSpeed::evenly(2, 20.0, 0.0, 4.0, 3.0);
        let (way_m, time_s, last_mps) = driven(&mut control, 20.0);
        // 20²/2·4 = 50 m in 5 s, and 3 s of standstill.
        assert!((way_m - 50.0).abs() < 0.01 && (time_s - 8.0).abs() < 0.02 && last_mps == 0.0, "{way_m} {time_s}");
    }
}
