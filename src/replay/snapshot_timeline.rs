//! Snapshots of a replay by time, to be looked at in any order. In: a [`Snapshot`] a step, in order. Out: the world at any
//! time between the first and the last, so that a seek back is at once and drives nothing again.
//!
//! A simulation cannot be taken back (neither SUMO nor the physics give up their state), but a picture needs only where
//! everything is. A step of 22 cars takes 4.6 kB: five minutes 14 MB, an hour 166 MB. At [`MOST_BYTES`], after two hours of 22
//! cars, every second step is let go, at twice the length every second of these, so that a film of days or of a thousand cars
//! takes no more.

use crate::sim::{Snapshot, VehicleSnapshot};

/// The most that a film holds, bytes.
pub const MOST_BYTES: usize = 320 << 20;
/// Between snapshots further apart than so many steps nothing is guessed: on a ring cars would leave the road.
const GUESSED: f64 = 20.0;

/// Snapshots, one a step or a few, from the start of the drive on.
#[derive(Debug)]
pub struct SnapshotTimeline {
    step_s: f64,
    steps: Vec<Snapshot>,
    /// The newest one, where it is not kept for long.
    newest: Option<Snapshot>,
    pushed: usize,
    /// One of so many is kept.
    stride: usize,
    /// So many are kept at the most.
    room: usize,
}

impl SnapshotTimeline {
    /// A film that begins with `first`, at time zero.
    pub fn new(first: Snapshot, step_s: f64) -> Self {
        let room = room(&first);
        Self { step_s, steps: vec![first], newest: None, pushed: 0, stride: 1, room }
    }

    /// The next step, or what the last one of the drive is cut down to.
    pub fn push(&mut self, snapshot: Snapshot) {
        self.pushed += 1;
        if !self.pushed.is_multiple_of(self.stride) {
            self.newest = Some(snapshot);
            return;
        }
        self.newest = None;
        // As if all steps had as many vehicles as the one with the most.
        self.room = self.room.min(room(&snapshot));
        self.steps.push(snapshot);
        // The first and every second after it: with an odd number the newest stays, too.
        if self.steps.len() > self.room {
            let mut keep = [false, true].into_iter().cycle();
            self.steps.retain(|_| keep.next() == Some(false));
            self.stride *= 2;
        }
    }

    fn get(&self, at: usize) -> &Snapshot {
        self.steps.get(at).or(self.newest.as_ref()).unwrap_or(&self.steps[self.steps.len() - 1])
    }

    /// How far it reaches, seconds.
    pub fn end_s(&self) -> f64 {
        self.newest.as_ref().or(self.steps.last()).map_or(0.0, |snapshot| snapshot.tick.seconds())
    }

    /// The world at `time_s`, or at the nearest time that there is: a snapshot whose `before` is the step before, and how far
    /// the moment lies between the two, 0 to 1, as [`scene::view`](crate::scene::view()) wants it.
    pub fn at(&self, time_s: f64) -> (Snapshot, f32) {
        let time_s = time_s.clamp(0.0, self.end_s());
        let after = self.steps.partition_point(|snapshot| snapshot.tick.seconds() < time_s - 1e-9);
        let mut now = self.get(after).clone();
        let near = |before: &&Snapshot| now.tick.seconds() - before.tick.seconds() <= GUESSED * self.step_s;
        let Some(before) = after.checked_sub(1).map(|i| self.get(i)).filter(near) else {
            now.ego_before = now.ego;
            return (now, 1.0);
        };
        let (from_s, to_s) = (before.tick.seconds(), now.tick.seconds());
        let share = if to_s > from_s { ((time_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0) } else { 1.0 };
        now.ego_before = before.ego;
        now.ego.speed_mps = before.ego.speed_mps + (now.ego.speed_mps - before.ego.speed_mps) * share;
        for car in &mut now.cars {
            // Vehicles may have come and gone between.
            if let Ok(at) = before.cars.binary_search_by_key(&car.id, |earlier| earlier.id) {
                let earlier = &before.cars[at];
                car.pose_before = earlier.pose;
                car.speed_mps = earlier.speed_mps + (car.speed_mps - earlier.speed_mps) * share;
            }
        }
        // Advice is shown from its issue on.
        if now.advice.is_some_and(|advice| advice.issued.seconds() > time_s + 1e-9) {
            now.advice = before.advice;
        }
        (now, share as f32)
    }
}

/// How many steps like this one there is room for.
fn room(snapshot: &Snapshot) -> usize {
    MOST_BYTES / (size_of::<Snapshot>() + snapshot.cars.len() * size_of::<VehicleSnapshot>())
}

/// Speeds at which a replay plays.
pub const SPEEDS: [f64; 7] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// Where a replay is looked at, and how fast it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Playback {
    /// The moment that is wanted, seconds.
    pub time_s: f64,
    /// End of the recording, seconds.
    pub end_s: f64,
    /// True while it plays.
    pub playing: bool,
    speed: usize,
}

impl Playback {
    /// At the start, playing as fast as it was driven.
    pub fn new(end_s: f64) -> Self {
        Self { time_s: 0.0, end_s, playing: true, speed: 2 }
    }

    /// Times the speed of the drive.
    pub fn speed(&self) -> f64 {
        SPEEDS[self.speed]
    }

    /// `elapsed_s` have passed; the film reaches to `known_s`, and play waits there.
    pub fn advance(&mut self, elapsed_s: f64, known_s: f64) {
        if self.playing && self.time_s <= known_s {
            self.time_s = (self.time_s + elapsed_s * self.speed()).min(known_s.max(self.time_s)).min(self.end_s);
        }
        if self.time_s >= self.end_s - 1e-9 {
            self.playing = false;
        }
    }

    /// True while what is wanted is still to be driven.
    pub fn waits(&self, known_s: f64) -> bool {
        self.time_s > known_s + 1e-9
    }

    /// Plays or holds; from the end it plays from the start.
    pub fn toggle(&mut self) {
        if !self.playing && self.time_s >= self.end_s - 1e-9 {
            self.time_s = 0.0;
        }
        self.playing = !self.playing;
    }

    /// Goes to a moment, to a whole tick.
    pub fn seek(&mut self, time_s: f64) {
        self.time_s = ((time_s * 100.0).round() / 100.0).clamp(0.0, self.end_s);
    }

    /// Holds, and goes so many ticks on, or back.
    pub fn tick(&mut self, ticks: i64) {
        self.playing = false;
        self.seek(self.time_s + ticks as f64 * crate::time::TICK_S);
    }

    /// The next faster speed, or the next slower one.
    pub fn change_speed(&mut self, faster: bool) {
        self.speed = if faster { (self.speed + 1).min(SPEEDS.len() - 1) } else { self.speed.saturating_sub(1) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ego::EgoState, time::Tick, traffic::VehicleId};
    use glam::DVec3;

    fn snapshot(tick: u64) -> Snapshot {
        let ego = EgoState {
            position: DVec3::new(tick as f64, 0.0, 0.0),
            speed_mps: tick as f64 / 100.0,
            ..EgoState::default()
        };
        Snapshot { tick: Tick(tick), ego, ego_before: ego, ..Snapshot::default() }
    }

    #[test]
    fn a_moment_between_two_steps_lies_between_their_places() {
        let mut film = SnapshotTimeline::new(snapshot(0), 0.1);
        for step in 1..=10 {
            film.push(snapshot(step * 10));
        }
        // The drive was stopped in the middle of a step.
        film.push(snapshot(104));
        assert_eq!(film.end_s(), 1.04);
        for (time_s, x) in
            [(0.0, 0.0), (0.03, 3.0), (0.1, 10.0), (0.55, 55.0), (1.02, 102.0), (1.04, 104.0), (9.0, 104.0)]
        {
            let (now, fraction) = film.at(time_s);
            let at = now.ego_before.position.lerp(now.ego.position, f64::from(fraction)).x;
            assert!((at - x).abs() < 1e-4, "{time_s}: {at}");
            assert!((now.ego.speed_mps - x / 100.0).abs() < 1e-4, "{time_s}");
        }
    }

    #[test]
    fn a_film_of_many_hours_takes_no_more_than_one_of_two_and_still_shows_every_moment() {
        let mut film = SnapshotTimeline::new(snapshot(0), 0.1);
        film.room = 72_000;
        for step in 1..=200_001 {
            film.push(snapshot(step * 10));
            assert!(film.steps.len() <= 72_000);
        }
        assert_eq!((film.stride, film.end_s()), (4, Tick(2_000_010).seconds()));
        for time_s in [0.0, 0.13, 7_000.27, 19_999.9, 20_000.05, 20_000.1] {
            let (now, fraction) = film.at(time_s);
            let at = now.ego_before.position.lerp(now.ego.position, f64::from(fraction)).x;
            assert!((at - 100.0 * time_s).abs() < 0.1, "{time_s}: {at}");
        }
    }

    #[test]
    fn a_film_holds_two_hours_of_22_cars_and_fewer_steps_of_more_cars() {
        let room = |others: usize| {
            let car = VehicleSnapshot { id: VehicleId(1), ..VehicleSnapshot::default() };
            let first = Snapshot { cars: vec![car; others], ..snapshot(0) };
            SnapshotTimeline::new(first, 0.1).room
        };
        assert!(room(21) >= 72_000, "{}", room(21));
        assert!(room(999) * 1000 * size_of::<VehicleSnapshot>() <= MOST_BYTES + MOST_BYTES / 100 && room(999) > 1000);
    }

    #[test]
    fn a_player_plays_at_its_speed_waits_for_the_film_and_holds_at_the_end() {
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
