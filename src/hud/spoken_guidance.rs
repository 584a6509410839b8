//! Guidance in words: sentences before each manoeuvre of the path, as navigation devices say them. In: the next manoeuvre and the speed, tick
//! by tick. Out: a sentence when it is time for one.

use super::guidance::distance_text;
use crate::{
    map::{Manoeuvre, NextManoeuvre},
    units::SpeedUnit,
};

/// Times before a manoeuvre at which it is announced, s, each with the least distance, metres. The first is for fast roads alone: it is left
/// out where it would be nearer.
const ANNOUNCED: [(f64, f64); 3] = [(60.0, 1000.0), (20.0, 120.0), (4.0, 25.0)];
/// Increase of the distance that means another manoeuvre, metres.
const OTHER_M: f64 = 15.0;
/// Largest difference of an exit's direction from straight on, and from a turn, degrees.
const STRAIGHT_DEG: i16 = 45;
const TURN_DEG: i16 = 135;

/// Announcements of a drive.
#[derive(Clone, Copy, Debug)]
pub struct SpokenGuidance {
    unit: SpeedUnit,
    /// Manoeuvre of the last tick, and the number of its announcements that are over.
    last: Option<(NextManoeuvre, usize)>,
}

impl SpokenGuidance {
    /// Returns the announcements of a drive whose dial has this unit.
    pub fn new(unit: SpeedUnit) -> Self {
        Self { unit, last: None }
    }

    /// Returns the sentence that is due at a tick. Of several announcements that are due at once, only the last is made.
    pub fn tick(&mut self, next: Option<NextManoeuvre>, speed_mps: f64) -> Option<String> {
        let Some(next) = next else {
            self.last = None;
            return None;
        };
        let is_same = |last: NextManoeuvre| last.manoeuvre == next.manoeuvre && next.ahead_m <= last.ahead_m + OTHER_M;
        let over = self.last.filter(|(last, _)| is_same(*last)).map_or(0, |(_, over)| over);
        let is_due = |(k, (time_s, least_m)): (usize, &(f64, f64))| {
            let by_time_m = time_s * speed_mps;
            next.ahead_m <= if k == 0 && by_time_m < *least_m { 0.0 } else { by_time_m.max(*least_m) }
        };
        let due = ANNOUNCED.iter().enumerate().filter(|announced| is_due(*announced)).map(|(k, _)| k + 1).max();
        let due = due.filter(|due| *due > over && next.ahead_m > 0.0);
        self.last = Some((next, due.unwrap_or(over)));
        Some(self.sentence(next, due? == ANNOUNCED.len()))
    }

    fn sentence(self, next: NextManoeuvre, is_now: bool) -> String {
        let what = words(next.manoeuvre);
        if is_now {
            return format!("{}{}.", what[..1].to_uppercase(), &what[1..]);
        }
        let distance = distance_text(next.ahead_m, self.unit);
        let (number, unit) = distance.split_once(' ').unwrap_or((&distance, ""));
        let unit = match unit {
            "m" => "metres",
            "km" => "kilometres",
            "ft" => "feet",
            _ => "miles",
        };
        format!("In {number} {unit}, {what}.")
    }
}

fn words(manoeuvre: Manoeuvre) -> &'static str {
    match manoeuvre {
        Manoeuvre::Left => "turn left",
        Manoeuvre::Right => "turn right",
        Manoeuvre::KeepLeft => "keep left",
        Manoeuvre::KeepRight => "keep right",
        Manoeuvre::TurnAround => "turn around",
        Manoeuvre::Roundabout { exit_deg, .. } => match exit_deg {
            deg if deg.abs() <= STRAIGHT_DEG => "go straight on at the roundabout",
            deg if deg.abs() > TURN_DEG => "turn around at the roundabout",
            deg if deg > 0 => "turn left at the roundabout",
            _ => "turn right at the roundabout",
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns what is said on the way to a manoeuvre at a constant speed, each sentence with the distance, metres.
    fn said(manoeuvre: Manoeuvre, from_m: f64, speed_mps: f64, unit: SpeedUnit) -> Vec<(f64, String)> {
        let mut guidance = SpokenGuidance::new(unit);
        let steps = (0..=from_m as usize).map(|step| from_m - step as f64);
        let next = |ahead_m: f64| NextManoeuvre { manoeuvre, ahead_m };
        steps.filter_map(|ahead_m| Some((ahead_m, guidance.tick(Some(next(ahead_m)), speed_mps)?))).collect()
    }

    #[test]
    fn a_manoeuvre_is_announced_in_time_for_its_speed_and_at_its_place() {
        // 20 s and 4 s at 10 m/s.
        let at_10 = said(Manoeuvre::Left, 900.0, 10.0, SpeedUnit::Kmh);
        assert_eq!(at_10, [(200.0, "In 200 metres, turn left.".to_owned()), (40.0, "Turn left.".to_owned())]);
        // 60 s, 20 s and 4 s at 30 m/s.
        let at_30 = said(Manoeuvre::KeepRight, 3000.0, 30.0, SpeedUnit::Mph);
        let expected =
            [(1800.0, "In 1.1 miles, keep right."), (600.0, "In 0.4 miles, keep right."), (120.0, "Keep right.")];
        assert_eq!(at_30, expected.map(|(ahead_m, sentence)| (ahead_m, sentence.to_owned())));
        // A manoeuvre that is near at once is announced once.
        assert_eq!(said(Manoeuvre::Right, 20.0, 10.0, SpeedUnit::Kmh), [(20.0, "Turn right.".to_owned())]);
    }

    #[test]
    fn each_manoeuvre_of_a_path_is_announced_and_none_within_a_junction() {
        let mut guidance = SpokenGuidance::new(SpeedUnit::Kmh);
        let mut tick = |manoeuvre, ahead_m| guidance.tick(Some(NextManoeuvre { manoeuvre, ahead_m }), 10.0);
        assert_eq!(tick(Manoeuvre::Left, 30.0).as_deref(), Some("Turn left."));
        assert_eq!(tick(Manoeuvre::Left, 0.0), None);
        // Two left turns, one after the other.
        assert_eq!(tick(Manoeuvre::Left, 150.0).as_deref(), Some("In 150 metres, turn left."));
        assert_eq!(tick(Manoeuvre::Left, 149.0), None);
        assert_eq!(guidance.tick(None, 10.0), None);
        let round = |exit_deg| words(Manoeuvre::Roundabout { exit_deg, is_clockwise: false });
        let ways = [(-90, "turn right"), (10, "go straight on"), (90, "turn left"), (178, "turn around")];
        ways.iter().for_each(|(deg, way)| assert_eq!(round(*deg), format!("{way} at the roundabout")));
    }
}
