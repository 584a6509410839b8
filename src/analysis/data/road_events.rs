//! Violations of traffic rules by the ego. In: the rows of the table of events, in order. Out: counts and durations.

use crate::time::Tick;

/// Episodes of one kind of violation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViolationSpans {
    /// Number of episodes that began.
    pub count: usize,
    /// Length of the episodes that are over, ticks.
    ticks: u64,
    /// Start of the open episode, tick.
    since: Option<u64>,
}

impl ViolationSpans {
    fn begin(&mut self, tick: u64) {
        self.count += 1;
        self.since = Some(tick);
    }

    fn end(&mut self, tick: u64) {
        self.ticks += self.since.take().map_or(0, |since| tick.saturating_sub(since));
    }

    /// Returns the total duration, seconds, in a drive that ends at `end_s`.
    pub fn total_s(&self, end_s: f64) -> f64 {
        let open_s = self.since.map_or(0.0, |since| (end_s - Tick(since).seconds()).max(0.0));
        Tick(self.ticks).seconds() + open_s
    }
}

/// Violations of traffic rules by the ego, its contacts with fixed objects and its near misses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoadEvents {
    /// Red lights that the ego drove over.
    pub red_lights: usize,
    /// Contacts with fixed objects beside the road.
    pub object_contacts: usize,
    /// Vehicles with which the ego would have collided within 1.5 s.
    pub near_misses: usize,
    /// Drives against the direction of the lane.
    pub wrong_way: ViolationSpans,
    /// Times on other streets than those of the path.
    pub off_path: ViolationSpans,
    /// Drives faster than the speed limit.
    pub speeding: ViolationSpans,
}

impl RoadEvents {
    /// Adds the next event; other kinds have no effect.
    pub fn add(&mut self, tick: u64, kind: &str) {
        match kind {
            "red_light" => self.red_lights += 1,
            "object_contact" => self.object_contacts += 1,
            "near_miss" => self.near_misses += 1,
            "wrong_way" => self.wrong_way.begin(tick),
            "right_way" => self.wrong_way.end(tick),
            "left_path" => self.off_path.begin(tick),
            "back_on_path" => self.off_path.end(tick),
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
    fn episodes_are_counted_at_their_start_and_timed_to_their_end() {
        let mut events = RoadEvents::default();
        let rows = [
            (100, "speeding"),
            (250, "stop_line"),
            (260, "red_light"),
            (300, "within_limit"),
            (400, "near_miss"),
            (700, "object_contact"),
            (900, "speeding"),
            (910, "left_path"),
            (930, "back_on_path"),
            (950, "wrong_way"),
            (960, "right_way"),
            (970, "red_light"),
        ];
        rows.iter().for_each(|(tick, kind)| events.add(*tick, kind));
        assert_eq!((events.red_lights, events.near_misses, events.object_contacts), (2, 1, 1));
        assert_eq!((events.speeding.count, events.wrong_way.count, events.off_path.count), (2, 1, 1));
        assert!((events.off_path.total_s(10.0) - 0.2).abs() < 1e-9);
        // 1 to 3 s, and from 9 s to the end at 10 s.
        assert!((events.speeding.total_s(10.0) - 3.0).abs() < 1e-9);
        assert!((events.wrong_way.total_s(10.0) - 0.1).abs() < 1e-9);
    }
}
