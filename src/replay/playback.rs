//! Time and speed of playback of a recording. In: wall time, keys, and the time up to which the recording has been driven again.
//! Out: the time to show.

/// Playback speeds, as multiples of real time.
pub const SPEEDS: [f64; 7] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// Time and speed of playback.
#[derive(Clone, Debug, PartialEq)]
pub struct Playback {
    /// Time to show, s.
    pub time_s: f64,
    /// End of the recording, s.
    pub end_s: f64,
    /// True while it plays.
    pub playing: bool,
    speed: usize,
}

impl Playback {
    /// Starts playback at time zero and real-time speed.
    pub fn new(end_s: f64) -> Self {
        Self { time_s: 0.0, end_s, playing: true, speed: 2 }
    }

    /// Returns the playback speed as a multiple of real time.
    pub fn speed(&self) -> f64 {
        SPEEDS[self.speed]
    }

    /// Advances by `elapsed_s` of wall time; playback waits at `known_s`, the end of the timeline.
    pub fn advance(&mut self, elapsed_s: f64, known_s: f64) {
        if self.playing && self.time_s <= known_s {
            self.time_s = (self.time_s + elapsed_s * self.speed()).min(known_s.max(self.time_s)).min(self.end_s);
        }
        if self.time_s >= self.end_s - 1e-9 {
            self.playing = false;
        }
    }

    /// Checks whether the time to show has not been driven again yet.
    pub fn waits(&self, known_s: f64) -> bool {
        self.time_s > known_s + 1e-9
    }

    /// Plays or pauses; at the end it plays from the start.
    pub fn toggle(&mut self) {
        if !self.playing && self.time_s >= self.end_s - 1e-9 {
            self.time_s = 0.0;
        }
        self.playing = !self.playing;
    }

    /// Goes to a time, rounded to a whole tick and clamped to the recording.
    pub fn seek(&mut self, time_s: f64) {
        self.time_s = ((time_s * 100.0).round() / 100.0).clamp(0.0, self.end_s);
    }

    /// Pauses, and goes forward by `ticks`, or back if negative.
    pub fn tick(&mut self, ticks: i64) {
        self.playing = false;
        self.seek(self.time_s + ticks as f64 * crate::time::TICK_S);
    }

    /// Changes to the next faster or slower speed.
    pub fn change_speed(&mut self, faster: bool) {
        self.speed = if faster { (self.speed + 1).min(SPEEDS.len() - 1) } else { self.speed.saturating_sub(1) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn playback_keeps_its_speed_waits_for_the_timeline_and_stops_at_the_end() {
        let mut playback = Playback::new(10.0);
        playback.advance(1.0, 5.0);
        assert_eq!(playback.time_s, 1.0);
        (0..9).for_each(|_| playback.change_speed(true));
        assert_eq!(playback.speed(), 16.0);
        playback.advance(1.0, 5.0);
        assert_eq!(playback.time_s, 5.0, "no further than the film");
        playback.seek(8.0);
        assert!(playback.waits(5.0));
        playback.advance(1.0, 5.5);
        assert_eq!(playback.time_s, 8.0, "it stays where it was sent to");
        playback.advance(1.0, 10.0);
        assert!((playback.time_s - 10.0).abs() < 1e-9 && !playback.playing);
        playback.toggle();
        assert!(playback.playing && playback.time_s == 0.0, "again from the start");
        (0..9).for_each(|_| playback.change_speed(false));
        assert_eq!(playback.speed(), 0.25);
        playback.tick(3);
        assert!(!playback.playing && playback.time_s == 0.03);
        playback.tick(-9);
        assert_eq!(playback.time_s, 0.0);
    }
}
