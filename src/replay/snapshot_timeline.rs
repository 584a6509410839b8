//! Snapshots of a replay by time, in any order. In: a [`Snapshot`] of each step, in order. Out: the world at any time between
//! the first and the last, so that a seek back is immediate and drives nothing again.
//!
//! A simulation cannot be reversed: neither SUMO nor the physics give out their state. A picture, however, needs positions
//! only. A step of 22 vehicles takes 5.6 kB: five minutes 17 MB, an hour 203 MB. At [`MOST_BYTES`], after two hours of 22
//! vehicles, every second step is dropped; at twice the length every second of the rest. So days of driving, or a thousand
//! vehicles, take no more memory.

use crate::sim::{Snapshot, VehicleSnapshot};

/// Maximum memory of a timeline, bytes.
pub const MOST_BYTES: usize = 400 << 20;
/// Maximum distance between interpolated snapshots, in steps: farther apart, vehicles on a ring would leave the road.
const GUESSED: f64 = 20.0;

/// Snapshots from the start of the drive, one for each step or for several.
#[derive(Debug)]
pub struct SnapshotTimeline {
    step_s: f64,
    steps: Vec<Snapshot>,
    /// Newest snapshot, if it is not among the kept ones.
    newest: Option<Snapshot>,
    pushed: usize,
    /// Number of steps for each kept snapshot.
    stride: usize,
    /// Maximum number of kept snapshots.
    room: usize,
}

impl SnapshotTimeline {
    /// Makes a timeline that begins with `first`, at time zero.
    pub fn new(first: Snapshot, step_s: f64) -> Self {
        let room = room(&first);
        Self { step_s, steps: vec![first], newest: None, pushed: 0, stride: 1, room }
    }

    /// Adds the snapshot of the next step; the last step of a drive may be shorter.
    pub fn push(&mut self, snapshot: Snapshot) {
        self.pushed += 1;
        if !self.pushed.is_multiple_of(self.stride) {
            self.newest = Some(snapshot);
            return;
        }
        self.newest = None;
        // Memory is bounded as if all steps had as many vehicles as the largest.
        self.room = self.room.min(room(&snapshot));
        self.steps.push(snapshot);
        // Keeps the first and every second after it; with an odd number the newest stays, too.
        if self.steps.len() > self.room {
            let mut keep = [false, true].into_iter().cycle();
            self.steps.retain(|_| keep.next() == Some(false));
            self.stride *= 2;
        }
    }

    fn get(&self, at: usize) -> &Snapshot {
        self.steps.get(at).or(self.newest.as_ref()).unwrap_or(&self.steps[self.steps.len() - 1])
    }

    /// Returns the time of the newest snapshot, s.
    pub fn end_s(&self) -> f64 {
        self.newest.as_ref().or(self.steps.last()).map_or(0.0, |snapshot| snapshot.tick.seconds())
    }

    /// Returns the world at `time_s`, clamped to the known times. The snapshot's earlier state is that of the previous kept
    /// step. The number, 0 to 1, is the share of the way between the two, as in [`scene::view`](crate::scene::view()).
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
            // Vehicles may have entered and left between the snapshots.
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

/// Returns the number of steps of this size that fit into [`MOST_BYTES`].
fn room(snapshot: &Snapshot) -> usize {
    MOST_BYTES / (size_of::<Snapshot>() + snapshot.cars.len() * size_of::<VehicleSnapshot>())
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
    fn a_time_between_two_steps_interpolates_their_positions() {
        let mut timeline = SnapshotTimeline::new(snapshot(0), 0.1);
        for step in 1..=10 {
            timeline.push(snapshot(step * 10));
        }
        // The drive was stopped within a step.
        timeline.push(snapshot(104));
        assert_eq!(timeline.end_s(), 1.04);
        for (time_s, x) in
            [(0.0, 0.0), (0.03, 3.0), (0.1, 10.0), (0.55, 55.0), (1.02, 102.0), (1.04, 104.0), (9.0, 104.0)]
        {
            let (now, fraction) = timeline.at(time_s);
            let at = now.ego_before.position.lerp(now.ego.position, f64::from(fraction)).x;
            assert!((at - x).abs() < 1e-4, "{time_s}: {at}");
            assert!((now.ego.speed_mps - x / 100.0).abs() < 1e-4, "{time_s}");
        }
    }

    #[test]
    fn a_timeline_of_many_hours_is_bounded_and_shows_every_moment() {
        let mut timeline = SnapshotTimeline::new(snapshot(0), 0.1);
        timeline.room = 72_000;
        for step in 1..=200_001 {
            timeline.push(snapshot(step * 10));
            assert!(timeline.steps.len() <= 72_000);
        }
        assert_eq!((timeline.stride, timeline.end_s()), (4, Tick(2_000_010).seconds()));
        for time_s in [0.0, 0.13, 7_000.27, 19_999.9, 20_000.05, 20_000.1] {
            let (now, fraction) = timeline.at(time_s);
            let at = now.ego_before.position.lerp(now.ego.position, f64::from(fraction)).x;
            assert!((at - 100.0 * time_s).abs() < 0.1, "{time_s}: {at}");
        }
    }

    #[test]
    fn a_timeline_holds_two_hours_of_22_vehicles() {
        let room = |others: usize| {
            let car = VehicleSnapshot { id: VehicleId(1), ..VehicleSnapshot::default() };
            let first = Snapshot { cars: vec![car; others], ..snapshot(0) };
            SnapshotTimeline::new(first, 0.1).room
        };
        assert!(room(21) >= 72_000, "{}", room(21));
        assert!(room(999) * 1000 * size_of::<VehicleSnapshot>() <= MOST_BYTES + MOST_BYTES / 100 && room(999) > 1000);
    }
}
