//! Moments of the events of a scenario in a drive. In: rows of the table of events, in order. Out: for each time that an event was seen, its onset and
//! its end, ticks.

use crate::sim::EventStage;

/// An event of the scenario that was seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScriptedMoment {
    /// Name of the event.
    pub name: String,
    /// Number of the vehicle that acted first; `None` without one.
    pub vehicle: Option<u32>,
    /// Tick of the first frame that showed it, or of the first action without frames.
    pub onset: u64,
    /// Tick of its end; `None` if it had none in the drive.
    pub ended: Option<u64>,
}

/// Adds a row of the table of events to the moments; other kinds have no effect. Of several actions of an event the first is its onset.
pub fn add(moments: &mut Vec<ScriptedMoment>, tick: u64, [kind, detail]: [&str; 2], vehicle: Option<u32>) {
    let is_onset = kind == EventStage::Onset.name();
    if !is_onset && kind != EventStage::Ended.name() {
        return;
    }
    match moments.iter_mut().rev().find(|moment| moment.name == detail && moment.ended.is_none()) {
        Some(moment) if is_onset => moment.vehicle = moment.vehicle.or(vehicle),
        Some(moment) => moment.ended = Some(tick),
        None if is_onset => moments.push(ScriptedMoment { name: detail.into(), vehicle, onset: tick, ended: None }),
        None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_seen_from_its_first_action_to_its_end_each_time() {
        let mut moments = Vec::new();
        for (tick, kind, detail, vehicle) in [
            (100, "event_triggered", "a", None),
            (101, "event_onset", "a", None),
            (101, "event_onset", "a", Some(3)),
            (150, "event_onset", "b", Some(4)),
            (160, "event_not_done", "a: no such vehicle", None),
            (200, "event_ended", "a", None),
            (300, "event_onset", "a", Some(5)),
        ] {
            add(&mut moments, tick, [kind, detail], vehicle);
        }
        let seen: Vec<_> = moments.iter().map(|m| (m.name.as_str(), m.vehicle, m.onset, m.ended)).collect();
        assert_eq!(seen, [("a", Some(3), 101, Some(200)), ("b", Some(4), 150, None), ("a", Some(5), 300, None)]);
    }
}
