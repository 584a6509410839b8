//! Responses of the driver to the events of a scenario, by the names of SAE J2944. In: the moments of the events, and the ego's rows in order. Out: a
//! response for each time that an event was seen. SI units.

use crate::{
    analysis::data::{RecordedTrial, ego_samples::EgoSample, scripted_moments::ScriptedMoment},
    controls::PEDAL_PRESSED,
    time::Tick,
};

/// Time after the end of an event in which it is still responded to, s.
const AFTERWARDS_S: f64 = 5.0;
const PRESSED: f64 = PEDAL_PRESSED as f64;
/// Turn of the steering wheel that counts as steering, radians: 2 degrees, beyond what keeps a car in its lane.
const STEERED_RAD: f64 = 0.035;

/// Response of the driver to an event. Times count from the onset.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScriptedResponse {
    pub moment: ScriptedMoment,
    /// Time from the onset to the end of watching: 5 s after the event's end, the next onset, or the end of the drive, s.
    pub watched_s: f64,
    /// Speed at the onset, m/s.
    pub speed_mps: f64,
    /// Time to the release of an accelerator that was pressed at the onset, s.
    pub release_s: Option<f64>,
    /// Time to the first travel of a brake that was released at the onset, s.
    pub brake_s: Option<f64>,
    /// Time to the first turn of the steering wheel away from its angle at the onset, s.
    pub steering_s: Option<f64>,
    /// Least gap to the leader, m.
    pub min_gap_m: Option<f64>,
    /// Least time to collision with the leader, s.
    pub min_ttc_s: Option<f64>,
    /// True if the brake was released at the onset.
    pub could_brake: bool,
    /// Largest deceleration, m/s2; 0 without one.
    pub max_decel_mps2: f64,
    /// Standard deviation of the lateral offset from the lane's middle, m.
    pub sdlp_m: f64,
    /// Closing speed of the first contact, m/s.
    pub contact_mps: Option<f64>,
}

impl ScriptedResponse {
    /// Returns the perception-response time: the time to the first movement of pedals or steering wheel, s.
    pub fn perception_response_s(&self) -> Option<f64> {
        [self.release_s, self.brake_s, self.steering_s].into_iter().flatten().reduce(f64::min)
    }
}

/// Collector of the responses of a drive.
#[derive(Debug)]
pub struct ScriptedResponses {
    watched: Vec<Watched>,
    /// Times, s, and closing speeds, m/s, of contacts.
    contacts_at: Vec<[f64; 2]>,
}

/// Event that is responded to.
#[derive(Debug)]
struct Watched {
    response: ScriptedResponse,
    /// Last tick that is watched.
    until: u64,
    /// Row at the onset.
    first: Option<EgoSample>,
    offsets_m: Offsets,
}

/// Sums for the standard deviation of the lateral offset.
#[derive(Debug, Default)]
struct Offsets {
    count: f64,
    mean_m: f64,
    squares_m2: f64,
}

impl Offsets {
    /// Adds an offset (Welford 1962).
    fn add(&mut self, offset_m: f64) {
        self.count += 1.0;
        let off = offset_m - self.mean_m;
        self.mean_m += off / self.count;
        self.squares_m2 += off * (offset_m - self.mean_m);
    }

    fn sd_m(&self) -> f64 {
        if self.count > 1.0 { (self.squares_m2 / (self.count - 1.0)).sqrt() } else { 0.0 }
    }
}

impl ScriptedResponses {
    /// Starts with the events of a drive.
    pub fn new(trial: &RecordedTrial) -> Self {
        let moments = &trial.scripted;
        let watched = moments.iter().enumerate().map(|(k, moment)| {
            let after = |ended: u64| ended + Tick::at_seconds(AFTERWARDS_S).0;
            // Two events may begin at once.
            let next = moments[k + 1..].iter().map(|next| next.onset).find(|onset| *onset > moment.onset);
            let until = moment.ended.map_or(u64::MAX, after).min(next.map_or(u64::MAX, |onset| onset - 1));
            let response = ScriptedResponse { moment: moment.clone(), ..ScriptedResponse::default() };
            Watched { response, until, first: None, offsets_m: Offsets::default() }
        });
        Self { watched: watched.collect(), contacts_at: trial.contacts_at.clone() }
    }

    /// Adds the next row of the ego.
    pub fn add(&mut self, ego: &EgoSample) {
        for watched in &mut self.watched {
            if (watched.response.moment.onset..=watched.until).contains(&ego.tick) {
                watched.add(ego);
            }
        }
    }

    /// Returns the responses to all events that were seen, in the order of their onsets.
    pub fn finish(self) -> Vec<ScriptedResponse> {
        let finished = |Watched { mut response, offsets_m, .. }: Watched| {
            let onset_s = Tick(response.moment.onset).seconds();
            let within = onset_s..=onset_s + response.watched_s;
            let contact = self.contacts_at.iter().find(|contact| within.contains(&contact[0]));
            response.contact_mps = contact.map(|contact| contact[1]);
            response.sdlp_m = offsets_m.sd_m();
            response
        };
        self.watched.into_iter().filter(|watched| watched.first.is_some()).map(finished).collect()
    }
}

impl Watched {
    fn add(&mut self, ego: &EgoSample) {
        let first = *self.first.get_or_insert(*ego);
        let response = &mut self.response;
        let after_s = Tick(ego.tick - response.moment.onset).seconds();
        response.watched_s = after_s;
        response.speed_mps = first.speed_mps;
        response.could_brake = first.brake <= PRESSED;
        if first.throttle > PRESSED && ego.throttle <= PRESSED {
            response.release_s.get_or_insert(after_s);
        }
        if response.could_brake && ego.brake > PRESSED {
            response.brake_s.get_or_insert(after_s);
        }
        if (ego.wheel_rad - first.wheel_rad).abs() > STEERED_RAD {
            response.steering_s.get_or_insert(after_s);
        }
        let least = |known: Option<f64>, now: Option<f64>| known.into_iter().chain(now).reduce(f64::min);
        response.min_gap_m = least(response.min_gap_m, ego.gap_m);
        response.min_ttc_s = least(response.min_ttc_s, ego.ttc_s);
        response.max_decel_mps2 = response.max_decel_mps2.max(-ego.accel_mps2);
        self.offsets_m.add(ego.lane_offset_m);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(name: &str, onset: u64, ended: Option<u64>) -> ScriptedMoment {
        ScriptedMoment { name: name.into(), vehicle: None, onset, ended }
    }

    #[test]
    fn a_response_has_the_times_and_extremes_of_a_hand_made_drive() {
        let scripted = vec![moment("a", 1000, Some(1100)), moment("b", 2000, None)];
        let trial = RecordedTrial {
            scripted,
            contacts_at: vec![[9.0, 1.0], [13.5, 2.5], [14.0, 9.0]],
            ..RecordedTrial::default()
        };
        let mut responses = ScriptedResponses::new(&trial);
        for tick in 1..=2300_u64 {
            let ego = EgoSample {
                tick,
                // Released 0.7 s after the onset of "a", pressed again at 12 s, released 0.5 s after that of "b".
                throttle: if (1070..1200).contains(&tick) || tick >= 2050 { 0.0 } else { 0.3 },
                // The foot rests on the brake with 0.01, and presses it 1.1 s after the onset of "a".
                brake: if (1110..1150).contains(&tick) { 0.5 } else { 0.01 },
                wheel_rad: if tick >= 1300 { 0.10 } else { 0.05 },
                speed_mps: if tick == 1000 { 20.0 } else { 12.0 },
                accel_mps2: if tick == 1130 { -6.5 } else { 0.4 },
                // ±0.2 m in turns: with 601 rows the standard deviation is 0.2001665 m by hand.
                lane_offset_m: if tick.is_multiple_of(2) { 0.2 } else { -0.2 },
                gap_m: Some(if tick == 1200 { 7.5 } else { 30.0 }),
                ttc_s: (tick == 1150).then_some(1.75),
                ..EgoSample::default()
            };
            responses.add(&ego);
        }
        let [a, b] = &responses.finish()[..] else { panic!("two events") };
        assert_eq!((a.speed_mps, a.watched_s), (20.0, 6.0), "until 5 s after the end at 1 s");
        let times = [a.release_s, a.brake_s, a.steering_s, a.perception_response_s()];
        for (time_s, expected_s) in times.iter().zip([0.7, 1.1, 3.0, 0.7]) {
            assert!(time_s.is_some_and(|time_s| (time_s - expected_s).abs() < 1e-9), "{times:?}");
        }
        assert_eq!((a.min_ttc_s, a.min_gap_m, a.contact_mps), (Some(1.75), Some(7.5), Some(2.5)));
        assert_eq!(a.max_decel_mps2, 6.5);
        assert!((a.sdlp_m - 0.2001665).abs() < 1e-6, "{}", a.sdlp_m);
        assert_eq!((b.watched_s, b.release_s, b.brake_s, b.steering_s), (3.0, Some(0.5), None, None));
        assert_eq!((b.contact_mps, b.min_ttc_s, b.max_decel_mps2), (None, None, 0.0));
    }

    #[test]
    fn an_event_is_watched_until_the_next_one_is_seen() {
        let scripted = vec![moment("a", 100, Some(150)), moment("b", 200, Some(210)), moment("c", 200, Some(220))];
        let mut responses = ScriptedResponses::new(&RecordedTrial { scripted, ..RecordedTrial::default() });
        (1..=400).for_each(|tick| responses.add(&EgoSample { tick, ..EgoSample::default() }));
        let watched: Vec<f64> = responses.finish().iter().map(|response| response.watched_s).collect();
        assert_eq!(watched, [0.99, 2.0, 2.0], "of the last two until the end of the drive");
    }
}
