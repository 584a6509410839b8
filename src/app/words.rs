//! A drive in words, for a terminal. In: a [`Summary`]. Out: lines.

use crate::{
    sim::{Scenario, Summary},
    units::SpeedUnit,
};

/// The summary of a drive, a line a figure; `who` drove.
pub fn summary(scenario: &Scenario, engine: &str, who: &str, summary: &Summary) -> String {
    let unit = scenario.units;
    let speed = |value: Option<f64>| value.map_or("-".into(), |v| both(v, unit));
    let in_range = summary.time_in_range.map_or("- (no advice)".into(), |share| format!("{:.1} %", 100.0 * share));
    let mut lines = vec![
        format!("{} cars on {}, {engine}, driver {who}, policy {}", scenario.vehicles, scenario.map, scenario.policy),
        format!("window                   {:.1} s to {:.1} s", summary.window_s[0], summary.window_s[1]),
        format!("mean speed, all cars     {}", speed(summary.mean_speed_mps)),
        format!("its standard deviation   {}", speed(summary.speed_sd_mps)),
        format!("mean speed, ego          {}", speed(summary.ego_mean_speed_mps)),
        format!("time in range            {in_range}"),
        format!("smallest gap             {}", summary.min_gap_m.map_or("-".into(), |gap| format!("{gap:.2} m"))),
        format!("contacts, off the road   {}, {}", summary.contact_count, summary.left_road),
    ];
    if let Some(contact) = summary.contacts.first() {
        let (at, car, closing) = (contact.time_s, contact.car, contact.closing_mps);
        lines.push(format!("first contact            at {at:.2} s with car {car}, closing at {closing:.2} m/s"));
    }
    match &summary.failure {
        Some(_) => {
            lines.push(format!("broken off               at {:.1} s: {}", summary.duration_s, summary.end_in_words()))
        }
        None if summary.ended.is_none() => {
            lines.push(format!("stopped                  at {:.1} s", summary.duration_s));
        }
        None => {}
    }
    lines.join("\n") + "\n"
}

fn both(speed_mps: f64, unit: SpeedUnit) -> String {
    format!("{speed_mps:.3} m/s ({:.2} {})", unit.from_mps(speed_mps), unit.label())
}
