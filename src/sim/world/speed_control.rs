//! Change of the speed of a vehicle by an event. In: its speed, the vehicle ahead, where a step begins. Out: its motion in that step. Metres, m/s.

use crate::{
    idm::IdmParams,
    sim::Leader,
    time::Tick,
    traffic::{GUARD, LaneMotion, VehicleId},
};

/// Speed difference at which a vehicle has the speed of its event, m/s.
const REACHED_MPS: f64 = 1e-6;
/// Driver who keeps a vehicle from running into the one ahead, at any speed of an event.
pub(super) const KEEPER: IdmParams = IdmParams { v0: 70.0, ..GUARD };

/// Control of the speed of a vehicle.
#[derive(Debug)]
pub(super) struct SpeedControl {
    /// Number of the event.
    pub event: usize,
    pub id: VehicleId,
    pub to_mps: f64,
    /// Change of speed per time, m/s2, positive.
    pub rate_mps2: f64,
    /// Time for which the vehicle keeps the speed, s.
    pub keep_s: f64,
    /// Tick from which the vehicle has that speed.
    pub since: Option<Tick>,
    /// True for a vehicle that has its hazard lights on.
    pub is_broken_down: bool,
}

impl SpeedControl {
    /// Takes the speed where a step begins. Returns true once the speed has been kept for its time.
    pub fn is_over(&mut self, speed_mps: f64, now: Tick) -> bool {
        if (speed_mps - self.to_mps).abs() < REACHED_MPS {
            self.since.get_or_insert(now);
        }
        self.since.is_some_and(|since| now >= Tick::at_seconds(since.seconds() + self.keep_s))
    }

    /// Returns the motion in the step that begins.
    pub fn motion(&self, speed_mps: f64, leader: Option<Leader>, step_s: f64) -> LaneMotion {
        let rate_mps2 = if speed_mps > self.to_mps { -self.rate_mps2 } else { self.rate_mps2 };
        let wanted = changed(speed_mps, self.to_mps, rate_mps2, step_s);
        let bound = leader.map(|leader| behind(&KEEPER, speed_mps, &leader, step_s));
        let [end_mps, mean_mps] = bound.filter(|bound| bound[0] < wanted[0]).unwrap_or(wanted);
        LaneMotion { id: self.id, mean_mps, end_mps }
    }
}

/// Returns the speed at the end of a step and the mean speed in it of a vehicle with this model behind a leader.
pub(super) fn behind(model: &IdmParams, speed_mps: f64, leader: &Leader, step_s: f64) -> [f64; 2] {
    let accel_mps2 = model.acceleration(speed_mps, leader.speed_mps, leader.gap_m);
    changed(speed_mps, if accel_mps2 < 0.0 { 0.0 } else { f64::INFINITY }, accel_mps2, step_s)
}

/// Returns the speed at the end of a step and the mean speed in it of a vehicle that accelerates evenly until it has the speed `to_mps`.
fn changed(speed_mps: f64, to_mps: f64, accel_mps2: f64, step_s: f64) -> [f64; 2] {
    let needed_s = if accel_mps2 == 0.0 { f64::INFINITY } else { (to_mps - speed_mps) / accel_mps2 };
    let changing_s = needed_s.clamp(0.0, step_s);
    let end_mps = if needed_s <= step_s { to_mps } else { speed_mps + accel_mps2 * step_s };
    let way_m = (speed_mps + end_mps) / 2.0 * changing_s + end_mps * (step_s - changing_s);
    [end_mps, way_m / step_s]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn control(to_mps: f64, rate_mps2: f64) -> SpeedControl {
        SpeedControl { event: 0, id: VehicleId(3), to_mps, rate_mps2, keep_s: 1.0, since: None, is_broken_down: false }
    }

    /// Returns the way to the target speed, metres, and the number of steps.
    fn way_m(from_mps: f64, control: &SpeedControl, step_s: f64) -> (f64, u32) {
        let (mut speed_mps, mut way_m, mut steps) = (from_mps, 0.0, 0);
        while (speed_mps - control.to_mps).abs() > 1e-9 {
            let motion = control.motion(speed_mps, None, step_s);
            (speed_mps, way_m, steps) = (motion.end_mps, way_m + motion.mean_mps * step_s, steps + 1);
        }
        (way_m, steps)
    }

    #[test]
    fn a_vehicle_stops_in_the_way_of_even_braking() {
        // v²/2b: 15² / (2 · 4) = 28.125 m, in 3.75 s, for steps that divide that time and for others.
        for (step_s, steps) in [(0.05, 75), (0.1, 38), (0.4, 10)] {
            let (way, taken) = way_m(15.0, &control(0.0, 4.0), step_s);
            // In the last step it stands for the rest of the time.
            assert!((way - 28.125).abs() < 1e-9 && taken == steps, "{step_s}: {way} in {taken}");
        }
        // From 10 to 20 m/s with 2 m/s²: 5 s, 75 m.
        let (way, taken) = way_m(10.0, &control(20.0, 2.0), 0.1);
        assert!((way - 75.0).abs() < 1e-6 && taken == 50, "{way} in {taken}");
    }

    #[test]
    fn an_accelerating_vehicle_does_not_run_into_the_one_ahead() {
        let (mut speed_mps, mut gap_m) = (10.0, 40.0);
        for _ in 0..600 {
            let leader = Leader { id: VehicleId(4), gap_m, speed_mps: 5.0 };
            let motion = control(30.0, 3.0).motion(speed_mps, Some(leader), 0.1);
            gap_m += (5.0 - motion.mean_mps) * 0.1;
            speed_mps = motion.end_mps;
            assert!(gap_m > 0.5, "{gap_m}");
        }
        assert!((speed_mps - 5.0).abs() < 0.1, "{speed_mps}");
    }

    #[test]
    fn the_speed_is_kept_for_its_time() {
        let mut control = control(5.0, 2.0);
        assert!(!control.is_over(6.0, Tick(100)));
        assert!(!control.is_over(5.0, Tick(110)) && !control.is_over(5.0, Tick(209)));
        assert!(control.is_over(5.0, Tick(210)), "a second later");
    }
}
