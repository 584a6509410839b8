//! The card that a driver sees after a free drive. In: a finished drive. Out: lines: time in range, mean speed of all
//! vehicles, and the same for the same traffic without advice, which is simulated meanwhile in the background.

use crate::{
    drive_loop::offline::OfflineDrive,
    scenario::{DisplaySettings, Scenario},
    sim::Summary,
    traffic::EngineChoice,
};
use std::thread::JoinHandle;

/// Shortest duration of a drive that says something about traffic, s.
const LEAST_S: f64 = 30.0;

/// Lines of the card, and the simulation that still runs for them.
pub struct EndCard {
    in_range: Option<f64>,
    mean_mps: Option<f64>,
    scenario: Scenario,
    without: Option<JoinHandle<Option<f64>>>,
    without_mps: Option<f64>,
}

impl EndCard {
    /// Creates the card of a finished drive. The comparison, the same seed without advice, starts on a thread of its
    /// own, on the native engine, because SUMO can run only once in a process. Its line is left out if the native
    /// engine cannot drive the road, and after a drive without advice or shorter than [`LEAST_S`].
    pub fn begin(scenario: &Scenario, summary: &Summary) -> Self {
        let same = Scenario {
            traffic: scenario.traffic.without_sumo(),
            policy: "none".into(),
            driver: "idm".into(),
            duration_s: summary.duration_s,
            display: DisplaySettings { trees: 0, ..scenario.display.clone() },
            ..scenario.clone()
        };
        let worth = summary.advices > 0 && summary.duration_s >= LEAST_S;
        let drive = move || {
            let mut run = OfflineDrive::new(&same, [0.0, f64::INFINITY]).ok()?;
            run.until(same.duration_s).ok()?;
            run.summary().mean_speed_mps
        };
        let without = worth.then(|| std::thread::Builder::new().name("without advice".into()).spawn(drive).ok());
        Self {
            in_range: summary.time_in_range,
            mean_mps: summary.mean_speed_mps,
            scenario: scenario.clone(),
            without: without.flatten(),
            without_mps: None,
        }
    }

    /// Returns the lines so far.
    pub fn text(&mut self) -> String {
        if let Some(done) = self.without.take_if(|thread| thread.is_finished()) {
            // A panic was printed already.
            self.without_mps = done.join().ok().flatten();
        }
        let unit = self.scenario.display.units;
        let speed = |mps: f64| format!("{:.1} {} ({mps:.2} m/s)", unit.from_mps(mps), unit.label());
        let mut lines = Vec::new();
        lines.extend(self.in_range.map(|share| format!("Time in range: {:.0} %", 100.0 * share)));
        lines.extend(self.mean_mps.map(|mps| format!("Mean speed of all vehicles: {}", speed(mps))));
        lines.extend(match (self.without_mps, &self.without) {
            (Some(mps), _) => {
                let other = if self.scenario.traffic == EngineChoice::Sumo { ", native traffic" } else { "" };
                Some(format!("Without advice: {}{other}", speed(mps)))
            }
            (None, Some(_)) => Some("Without advice: being driven".into()),
            (None, None) => None,
        });
        lines.join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    #[test]
    #[expect(clippy::disallowed_methods, reason = "waits for another thread")]
    fn the_card_has_the_numbers_of_the_drive_and_of_the_comparison() {
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            driver: "perfect".into(),
            duration_s: 60.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let drive = |scenario: &Scenario| {
            let mut run = OfflineDrive::new(scenario, [0.0, f64::INFINITY]).unwrap();
            run.until(60.0).unwrap();
            run.summary()
        };
        let summary = drive(&scenario);
        let without = drive(&Scenario { policy: "none".into(), driver: "idm".into(), ..scenario.clone() });
        let mut card = EndCard::begin(&scenario, &summary);
        let begin = Instant::now();
        while card.text().contains("being driven") {
            assert!(begin.elapsed() < Duration::from_secs(60), "a minute for a minute of native traffic");
            std::thread::sleep(Duration::from_millis(20));
        }
        let words = card.text();
        let [own, other] = [&summary, &without].map(|of| format!("({:.2} m/s)", of.mean_speed_mps.unwrap()));
        let share = format!("Time in range: {:.0} %", 100.0 * summary.time_in_range.unwrap());
        for part in
            [share, format!("Mean speed of all vehicles: {:.1} mph {own}", summary.mean_speed_mps.unwrap() / 0.44704)]
        {
            assert!(words.contains(&part), "{part}\n{words}");
        }
        assert!(words.lines().last().is_some_and(|line| line.starts_with("Without advice") && line.ends_with(&other)));
        // Two SUMOs cannot run in one process: the other engine is named.
        card.scenario.traffic = EngineChoice::Sumo;
        assert!(card.text().ends_with(&format!("{other}, native traffic")));
        // A drive without advice has nothing to compare with.
        assert!(!EndCard::begin(&scenario, &without).text().contains("Without advice"));
    }
}
