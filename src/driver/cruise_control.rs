//! Adaptive cruise control. In: own speed, set speed and the vehicle ahead. Out: the wanted acceleration. The laws are those that SUMO's model ACC has
//! after Milanés and Shladover (docs/references.md: automation): a constant time gap, and a law each for keeping, closing and opening the gap.
//! Metres, m/s, m/s².

use super::SeenLeader;

/// Gain from the error of the speed to acceleration, 1/s.
const SPEED_GAIN: f64 = 0.4;
/// Gains from the error of the gap, 1/s², and from the difference of the speeds, 1/s: in the gap, above it and below it.
const KEEPING: [f64; 2] = [0.23, 0.07];
const CLOSING: [f64; 2] = [0.04, 0.8];
const OPENING: [f64; 2] = [0.8, 0.23];
/// Errors of gap, m, and speed, m/s, within which the gap is kept.
const IN_GAP: [f64; 2] = [0.2, 0.1];
/// Gap from which a vehicle ahead does not count, m.
const REACH_M: f64 = 120.0;
/// Gap at a standstill, m.
const STANDSTILL_M: f64 = 2.0;
/// Largest acceleration, m/s². ISO 15622 allows it at every speed, and 4 m/s² below 5 m/s.
const ACCEL_MPS2: f64 = 2.0;
/// Largest decelerations, m/s², and the speeds up to which and from which they hold, m/s; linear between them (ISO 15622).
const SLOW_DECEL: [f64; 2] = [5.0, 5.0];
const FAST_DECEL: [f64; 2] = [3.5, 20.0];

/// Returns the wanted acceleration for a set speed and a time gap.
pub(super) fn wanted_mps2(speed_mps: f64, set_mps: f64, time_gap_s: f64, leader: Option<SeenLeader>) -> f64 {
    let free_mps2 = SPEED_GAIN * (set_mps - speed_mps);
    let behind_mps2 = leader.filter(|leader| leader.gap_m < REACH_M).map_or(f64::INFINITY, |leader| {
        let error_m = leader.gap_m - STANDSTILL_M - time_gap_s * speed_mps.max(0.0);
        let faster_mps = leader.speed_mps - speed_mps;
        let by = |[per_m, per_mps]: [f64; 2]| per_m * error_m + per_mps * faster_mps;
        match error_m {
            _ if error_m.abs() < IN_GAP[0] && faster_mps.abs() < IN_GAP[1] => by(KEEPING),
            // The smaller of both, so that the brake is not released where the gap becomes too short.
            _ if error_m < 0.0 => by(OPENING).min(by(CLOSING)),
            _ => by(CLOSING),
        }
    });
    free_mps2.min(behind_mps2).clamp(-strongest_mps2(speed_mps), ACCEL_MPS2)
}

/// Returns the largest deceleration at a speed.
fn strongest_mps2(speed_mps: f64) -> f64 {
    let share = ((speed_mps - SLOW_DECEL[1]) / (FAST_DECEL[1] - SLOW_DECEL[1])).clamp(0.0, 1.0);
    SLOW_DECEL[0] + share * (FAST_DECEL[0] - SLOW_DECEL[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Follows a leader with this speed at each time for `seconds`, from a speed and a gap; returns speed, gap and the smallest gap.
    fn follow(start: [f64; 2], time_gap_s: f64, seconds: f64, leader_mps: impl Fn(f64) -> f64) -> [f64; 3] {
        const STEP_S: f64 = 0.01;
        let [mut speed_mps, mut gap_m] = start;
        let mut least_m = gap_m;
        for k in 0..(seconds / STEP_S) as u32 {
            let ahead_mps = leader_mps(f64::from(k) * STEP_S);
            let leader = Some(SeenLeader { gap_m, speed_mps: ahead_mps });
            let accel_mps2 = wanted_mps2(speed_mps, 30.0, time_gap_s, leader);
            speed_mps = (speed_mps + accel_mps2 * STEP_S).max(0.0);
            gap_m += (ahead_mps - speed_mps) * STEP_S;
            least_m = least_m.min(gap_m);
        }
        [speed_mps, gap_m, least_m]
    }

    #[test]
    fn a_free_road_is_driven_at_the_set_speed() {
        // 0.4 of the difference, at most 2 m/s².
        assert_eq!(wanted_mps2(28.0, 30.0, 1.5, None), 0.8);
        assert_eq!(wanted_mps2(10.0, 30.0, 1.5, None), 2.0);
        assert_eq!(wanted_mps2(30.0, 30.0, 1.5, Some(SeenLeader { gap_m: 121.0, speed_mps: 0.0 })), 0.0);
    }

    #[test]
    fn the_gap_settles_at_the_time_gap_beside_the_standstill_distance() {
        for (time_gap_s, from_m) in [(0.8, 60.0), (1.5, 20.0), (2.2, 100.0)] {
            let [speed_mps, gap_m, _] = follow([20.0, from_m], time_gap_s, 300.0, |_| 20.0);
            // 2 m and 20 m/s for the time gap.
            let expected_m = 2.0 + 20.0 * time_gap_s;
            assert!((speed_mps - 20.0).abs() < 0.02 && (gap_m - expected_m).abs() < 0.25, "{speed_mps} {gap_m}");
        }
    }

    #[test]
    fn it_stops_behind_a_leader_that_stops_and_goes_when_it_goes() {
        // The leader brakes with 3 m/s² from 20 m/s, stands until 30 s, and drives at 10 m/s.
        let leader = |time_s: f64| if time_s < 30.0 { (20.0 - 3.0 * time_s).max(0.0) } else { 10.0 };
        let [speed_mps, gap_m, least_m] = follow([20.0, 32.0], 1.5, 30.0, leader);
        // The law that closes the gap covers its last metres with a time constant of 0.8 / 0.04 = 20 s.
        assert!(speed_mps < 0.1 && least_m > 2.0 && gap_m < 4.0, "{speed_mps} {gap_m} {least_m}");
        let [speed_mps, gap_m, _] = follow([20.0, 32.0], 1.5, 330.0, leader);
        assert!((speed_mps - 10.0).abs() < 0.05 && (gap_m - 17.0).abs() < 0.3, "{speed_mps} {gap_m}");
    }

    #[test]
    fn braking_has_the_bounds_of_the_standard() {
        let wall = Some(SeenLeader { gap_m: 1.0, speed_mps: 0.0 });
        for (speed_mps, bound_mps2) in [(3.0, 5.0), (5.0, 5.0), (12.5, 4.25), (20.0, 3.5), (30.0, 3.5)] {
            assert_eq!(wanted_mps2(speed_mps, 30.0, 1.5, wall), -bound_mps2, "at {speed_mps} m/s");
        }
    }
}
