//! What the ego did against the rules of the road. In: the rows of the table of events, in order. Out: counts, and how long it lasted.

use crate::time::Tick;

/// Something that begins and ends, maybe more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lapses {
    /// How often it began.
    pub count: usize,
    /// Ticks of those that are over.
    ticks: u64,
    /// When the one began that is not over.
    since: Option<u64>,
}

impl Lapses {
    fn begin(&mut self, tick: u64) {
        self.count += 1;
        self.since = Some(tick);
    }

    fn end(&mut self, tick: u64) {
        self.ticks += self.since.take().map_or(0, |since| tick.saturating_sub(since));
    }

    /// How long it lasted in all, seconds, in a drive that ends at `end_s`.
    pub fn total_s(&self, end_s: f64) -> f64 {
        let open_s = self.since.map_or(0.0, |since| (end_s - Tick(since).seconds()).max(0.0));
        Tick(self.ticks).seconds() + open_s
    }
}

/// What the ego did against the rules of the road, and how near it came to others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoadEvents {
    /// Red lights that it drove over.
    pub red_lights: usize,
    /// Vehicles with which it would have collided within 1.5 s.
    pub near_misses: usize,
    /// Against the direction of its lane.
    pub wrong_way: Lapses,
    /// Faster than the limit.
    pub speeding: Lapses,
}

impl RoadEvents {
    /// The next event.
    pub fn add(&mut self, tick: u64, kind: &str) {
        match kind {
            "red_light" => self.red_lights += 1,
            "near_miss" => self.near_misses += 1,
            "wrong_way" => self.wrong_way.begin(tick),
            "right_way" => self.wrong_way.end(tick),
            "speeding" => self.speeding.begin(tick),
            "within_limit" => self.speeding.end(tick),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lasts_is_counted_when_it_begins_and_timed_to_its_end_or_that_of_the_drive() {
        let mut events = RoadEvents::default();
        let told = [
            (100, "speeding"),
            (250, "stop_line"),
            (260, "red_light"),
            (300, "within_limit"),
            (400, "near_miss"),
            (900, "speeding"),
            (950, "wrong_way"),
            (960, "right_way"),
            (970, "red_light"),
        ];
        told.iter().for_each(|(tick, kind)| events.add(*tick, kind));
        assert_eq!((events.red_lights, events.near_misses), (2, 1));
        assert_eq!((events.speeding.count, events.wrong_way.count), (2, 1));
        // 1 to 3 s, and from 9 s to the end at 10 s.
        assert!((events.speeding.total_s(10.0) - 3.0).abs() < 1e-9);
        assert!((events.wrong_way.total_s(10.0) - 0.1).abs() < 1e-9);
    }
}
