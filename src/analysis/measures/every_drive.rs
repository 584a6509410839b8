//! Measures of every drive. In: the sums of a drive. Out: a number, or `None` where there is nothing to measure. SI units.

use super::{
    MeasuredValue,
    inputs::{all_cars, enough},
};
use crate::{
    analysis::{
        responses::{OnsetKind, ResponseTime, ScriptedResponse},
        statistics::middle,
    },
    metrics::{eyes_on_road_s, registry::measure},
};

/// Measures in the order of the tables.
pub(super) const OF_EVERY_DRIVE: &[MeasuredValue] = &[
    (measure("mean_speed_mps"), |s| s.totals.ticks.mean_speed_mps.get()),
    (measure("baseline_speed_mps"), |s| s.baseline?.ticks.mean_speed_mps.get()),
    (measure("speed_gain_mps"), |s| {
        Some(s.totals.ticks.mean_speed_mps.get()? - s.baseline?.ticks.mean_speed_mps.get()?)
    }),
    (measure("speed_sd_over_vehicles_mps"), |s| Some(all_cars(s.totals)?.speed_sd_over_vehicles_mps())),
    (measure("speed_sd_over_time_mps"), |s| Some(all_cars(s.totals)?.speed_sd_over_time_mps())),
    (measure("ego_speed_sd_over_time_mps"), |s| Some(enough(&s.totals.ego_traffic)?.speed_sd_over_time_mps())),
    (measure("passages_per_h"), |s| {
        s.per_hour(s.totals.passages as f64).filter(|_| all_cars(s.totals).is_some() && s.trial.setup.lap_m() > 0.0)
    }),
    (measure("stops"), |s| s.per_car(s.totals.traffic.stops as f64)),
    (measure("stopped_s"), |s| s.per_car(s.totals.traffic.stopped_s)),
    (measure("ego_stops"), |s| s.per_car(0.0).map(|_| s.totals.ego_traffic.stops as f64)),
    (measure("ego_stopped_s"), |s| s.per_car(0.0).map(|_| s.totals.ego_traffic.stopped_s)),
    (measure("hard_brakings"), |s| s.per_car(s.totals.traffic.hard_brakings as f64)),
    (measure("hard_braking_s"), |s| s.per_car(s.totals.traffic.hard_braking_s)),
    (measure("ego_hard_brakings"), |s| s.per_car(0.0).map(|_| s.totals.ego_traffic.hard_brakings as f64)),
    (measure("ego_hard_braking_s"), |s| s.per_car(0.0).map(|_| s.totals.ego_traffic.hard_braking_s)),
    (measure("last_disturbance_s"), |s| all_cars(s.totals)?.last_disturbance_s()),
    (measure("ego_mean_speed_mps"), |s| s.totals.ticks.ego_mean_speed_mps.get()),
    (measure("time_in_range"), |s| s.totals.ticks.time_in_range.get()),
    (measure("speed_error_mps"), |s| s.totals.absolute_error_mps.get()),
    (measure("speed_bias_mps"), |s| s.totals.error_mps.get()),
    (measure("time_in_range_by_driver"), |s| s.totals.in_range_by_driver.get()),
    (measure("time_in_range_by_collision"), |s| {
        Some(s.totals.ticks.time_in_range.get()? - s.totals.in_range_by_driver.get()?)
    }),
    (measure("changes"), |s| Some(s.count(OnsetKind::Change) + s.count(OnsetKind::Request))),
    (measure("requests"), |s| Some(s.count(OnsetKind::Request))),
    (measure("responded"), |s| ResponseTime::Reaction.share_with_response(s.responses)),
    (measure("responded_by_chance"), |s| ResponseTime::Chance.share_with_response(s.responses)),
    (measure("reaction_s"), |s| s.median_s(ResponseTime::Reaction)),
    (measure("movement_s"), |s| s.median_s(ResponseTime::Movement)),
    (measure("enter_range_s"), |s| s.median_s(ResponseTime::Compliance)),
    (measure("enter_range_steps"), |s| Some(s.median_s(ResponseTime::Compliance)? / s.totals.step_s())),
    (measure("idle_movement"), |s| s.responses.first().map(|response| response.threshold)),
    (measure("min_gap_m"), |s| s.totals.ticks.min_gap_m.0),
    (measure("min_headway_m"), |s| s.totals.headway_m.0),
    (measure("min_ttc_s"), |s| s.totals.ttc_s.0),
    (measure("max_drac_mps2"), |s| s.totals.most_drac_mps2),
    (measure("time_gap_s"), |s| s.totals.time_gap_s.get()),
    (measure("min_time_gap_s"), |s| s.totals.min_time_gap_s.0),
    (measure("time_headway_s"), |s| s.totals.time_headway_s.get()),
    (measure("min_time_headway_s"), |s| s.totals.min_time_headway_s.0),
    (measure("sdlp_m"), |s| s.totals.sdlp_m()),
    (measure("reversals_per_min"), |s| {
        let minutes = s.totals.duration_s / 60.0;
        (minutes > 0.0).then(|| s.totals.reversals.count as f64 / minutes)
    }),
    (measure("pedal_reversals_per_min"), |s| Some(s.per_hour(s.totals.pedal_reversals.count as f64)? / 60.0)),
    (measure("rms_jerk_mps3"), |s| Some(s.totals.square_jerk.get()?.sqrt())),
    (measure("ego_fuel_l_100km"), |s| enough(&s.totals.ego_traffic)?.fuel_l_100km()),
    (measure("fuel_l_100km"), |s| all_cars(s.totals)?.fuel_l_100km()),
    (measure("ego_fuel_sumo_l_100km"), |s| s.totals.sumo_fuel[1].l_100km()),
    (measure("fuel_sumo_l_100km"), |s| s.totals.sumo_fuel[0].l_100km()),
    (measure("fuel_saved_l_100km"), |s| {
        Some(all_cars(s.baseline?)?.fuel_l_100km()? - all_cars(s.totals)?.fuel_l_100km()?)
    }),
    (measure("hand_over_speed_sd_over_vehicles_mps"), |s| Some(s.trial.setup.manifest.hand_over.speed_sd_mps)),
    (measure("contact_count"), |s| Some(s.trial.contacts as f64)),
    (measure("object_contacts"), |s| Some(s.trial.road_events.object_contacts as f64)),
    (measure("detection_signals"), |s| Some(s.task.detection?.detection_signals.into())),
    (measure("detection_misses"), |s| Some(s.task.detection?.detection_misses.into())),
    (measure("detection_hit_rate"), |s| s.task.detection?.detection_hit_rate),
    (measure("detection_response_s"), |s| s.task.detection?.detection_response_s),
    (measure("detection_false_responses"), |s| Some(s.task.detection?.detection_false_responses.into())),
    (measure("n_back_digits"), |s| Some(s.task.n_back?.n_back_digits.into())),
    (measure("n_back_accuracy"), |s| s.task.n_back?.n_back_accuracy),
    (measure("n_back_hit_rate"), |s| s.task.n_back?.n_back_hit_rate),
    (measure("n_back_false_alarms"), |s| Some(s.task.n_back?.n_back_false_alarms.into())),
    (measure("search_displays"), |s| Some(s.task.search?.search_displays.into())),
    (measure("search_correct"), |s| s.task.search?.search_correct),
    (measure("search_response_s"), |s| s.task.search?.search_response_s),
    (measure("shutter_openings"), |s| Some(s.task.occlusion?.shutter_openings.into())),
    (measure("shutter_open_s"), |s| Some(s.task.occlusion?.shutter_open_s)),
    (measure("event_count"), |s| Some(s.events.len() as f64).filter(|count| *count > 0.0)),
    (measure("event_response_s"), |s| s.mean_of_events(ScriptedResponse::perception_response_s)),
    (measure("event_release_s"), |s| s.mean_of_events(|event| event.release_s)),
    (measure("event_brake_s"), |s| s.mean_of_events(|event| event.brake_s)),
    (measure("event_brake_share"), |s| {
        s.mean_of_events(|event| event.could_brake.then(|| f64::from(u8::from(event.brake_s.is_some()))))
    }),
    (measure("event_steering_s"), |s| s.mean_of_events(|event| event.steering_s)),
    (measure("event_min_gap_m"), |s| s.mean_of_events(|event| event.min_gap_m)),
    (measure("event_min_ttc_s"), |s| s.mean_of_events(|event| event.min_ttc_s)),
    (measure("event_max_decel_mps2"), |s| s.mean_of_events(|event| Some(event.max_decel_mps2))),
    (measure("event_contact_share"), |s| {
        s.mean_of_events(|event| Some(f64::from(u8::from(event.contact_mps.is_some()))))
    }),
    (measure("questions"), |s| Some(s.task.questions?.questions.into())),
    (measure("questions_unanswered"), |s| Some(s.task.questions?.questions_unanswered.into())),
    (measure("question_correct"), |s| s.task.questions?.question_correct),
    (measure("question_response_s"), |s| s.task.questions?.question_response_s),
    (measure("takeover_requests"), |s| Some(s.takeovers?.takeover_requests.into())),
    (measure("takeovers"), |s| Some(s.takeovers?.takeovers.into())),
    (measure("takeover_time_s"), |s| s.takeovers?.takeover_time_s),
    (measure("takeover_first_input_s"), |s| s.takeovers?.takeover_first_input_s),
    (measure("takeover_hands_on_s"), |s| s.takeovers?.takeover_hands_on_s),
    (measure("takeover_eyes_on_road_s"), |s| eyes_on_road_s(&s.trial.automation_changes, &s.trial.gaze)),
    (measure("takeover_min_ttc_s"), |s| s.takeovers?.takeover_min_ttc_s),
    (measure("takeover_lane_deviation_m"), |s| s.takeovers?.takeover_lane_deviation_m),
    (measure("minimal_risk_manoeuvres"), |s| Some(s.takeovers?.minimal_risk_manoeuvres.into())),
    (measure("left_road"), |s| Some(s.trial.left_road as f64)),
    (measure("dropped_s"), |s| s.trial.frames.dropped_s),
    (measure("frames_per_s"), |s| s.trial.frames.frames_per_s),
    (measure("longest_frame_s"), |s| s.trial.frames.longest_frame_s),
    (measure("latency_median_s"), |s| middle(&s.trial.frames.latencies_s)),
    (measure("latency_p99_s"), |s| {
        let sorted = &s.trial.frames.latencies_s;
        sorted.get((0.99 * sorted.len() as f64).ceil() as usize - usize::from(!sorted.is_empty())).copied()
    }),
    (measure("late_input_share"), |s| s.trial.frames.late_input_share),
    (measure("wave_speed_mps"), |s| Some(s.totals.waves.as_ref()?.wave()?.speed_mps)),
    (measure("wave_share"), |s| Some(s.totals.waves.as_ref()?.wave()?.share)),
    (measure("speed_sd_growth_per_min"), |s| s.totals.waves.as_ref()?.growth_per_min()),
    (measure("gain_at_0_03_hz"), |s| s.totals.waves.as_ref()?.gain(0.03)),
    (measure("gain_at_0_06_hz"), |s| s.totals.waves.as_ref()?.gain(0.06)),
    (measure("gain_at_0_1_hz"), |s| s.totals.waves.as_ref()?.gain(0.10)),
    (measure("gain_at_0_15_hz"), |s| s.totals.waves.as_ref()?.gain(0.15)),
];
