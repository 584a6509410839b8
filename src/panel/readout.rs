//! Live numbers and the plot. In: [`Readings`] and a [`SpeedHistory`]. Out: widgets. Speeds are shown both in the
//! driver's unit and in m/s, the unit of the literature.

use egui::{Color32, RichText, Ui};
use egui_plot::{GridMark, Line, Plot};
use std::time::Duration;

use super::{PanelState, SpeedHistory, theme};
use crate::{
    policy::{Advice, DriverEstimate, ObservedDriver},
    sim::Snapshot,
    units::SpeedUnit,
};

/// Numbers of the current moment; SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Time since the start of the drive, seconds.
    pub time_s: f64,
    /// Ego speed, m/s; negative in reverse.
    pub speed_mps: f64,
    /// Current advice, if any.
    pub advice: Option<Advice>,
    /// Gap to the leader, m, and the leader's speed, m/s.
    pub leader: Option<(f64, f64)>,
    /// Mean speed of all vehicles, m/s.
    pub mean_speed_mps: f64,
}

impl From<&Snapshot> for Readings {
    fn from(snapshot: &Snapshot) -> Self {
        Self {
            time_s: snapshot.tick.seconds(),
            speed_mps: snapshot.ego.speed_mps,
            advice: snapshot.advice,
            leader: snapshot.leader.map(|leader| (leader.gap_m, leader.speed_mps)),
            mean_speed_mps: snapshot.mean_speed_mps,
        }
    }
}

impl Readings {
    /// Returns the position of the speed relative to the advised range as a word, and its colour.
    fn range_state(&self) -> (&'static str, Color32) {
        match self.advice {
            None => ("no advice", theme::DIM),
            Some(advice) if advice.accepts(self.speed_mps) => ("in range", theme::GREEN),
            Some(advice) if self.speed_mps < advice.target_mps => ("too slow", theme::TEXT),
            Some(_) => ("too fast", theme::TEXT),
        }
    }
}

/// Formats the time lost in stalls and their number.
pub fn dropped_time(dropped: Duration, stalls: u64) -> String {
    let stalls = if stalls == 1 { "1 stall".into() } else { format!("{stalls} stalls") };
    format!("{:.2} s in {stalls}", dropped.as_secs_f64())
}

/// Shows the numbers of the drive and of the program.
pub fn all_numbers(ui: &mut Ui, state: &PanelState<'_>) {
    numbers(ui, state);
    egui::Grid::new("program").num_columns(2).spacing([10.0, 3.0]).striped(true).show(ui, |ui| {
        row(ui, "Engine", state.engine, theme::DIM);
        let colour = if state.stalls > 0 { theme::AMBER } else { theme::DIM };
        row(ui, "Dropped time", &dropped_time(state.dropped, state.stalls), colour);
        row(ui, "Frame", &format!("{:.1} ms", state.frame_ms), theme::DIM);
    });
}

/// Shows the numbers of the drive.
pub fn numbers(ui: &mut Ui, state: &PanelState<'_>) {
    let unit = state.scenario.display.units;
    egui::Grid::new("readings").num_columns(2).spacing([10.0, 3.0]).striped(true).show(ui, |ui| {
        let Some(now) = state.readings else {
            row(ui, "Time", "not started", theme::DIM);
            return;
        };
        let (range_state, colour) = now.range_state();
        row(ui, "Time", &time(now.time_s), theme::TEXT);
        row(ui, "Speed", &speed(now.speed_mps, unit), colour);
        match now.advice {
            Some(advice) => {
                let (low, high) = advice.band_mps();
                let band = format!("{:5.1} – {:.1} {}", unit.from_mps(low), unit.from_mps(high), unit.label());
                row(ui, "Target", &speed(advice.target_mps, unit), theme::RED);
                row(ui, "Range", &format!("{band}  {range_state}"), colour);
            }
            None => {
                row(ui, "Target", "—", theme::DIM);
                row(ui, "Range", range_state, theme::DIM);
            }
        }
        if let Some(share) = state.in_range {
            row(ui, "In range", &format!("{:5.1} % so far", 100.0 * share), theme::TEXT);
        }
        match now.leader {
            Some((gap_m, leader_mps)) => {
                row(ui, "Gap", &format!("{gap_m:.1} m"), theme::TEXT);
                row(ui, "Leader", &speed(leader_mps, unit), theme::TEXT);
            }
            None => {
                row(ui, "Gap", "—", theme::DIM);
                row(ui, "Leader", "—", theme::DIM);
            }
        }
        row(ui, "Mean of all", &speed(now.mean_speed_mps, unit), theme::ACCENT);
    });
}

/// Shows the policy's estimate of the driver's traits, each with its standard deviation.
pub fn driver(ui: &mut Ui, estimate: &DriverEstimate) {
    let DriverEstimate { mean, sd } = estimate;
    egui::Grid::new("driver").num_columns(2).spacing([10.0, 3.0]).striped(true).show(ui, |ui| {
        for (name, value) in [
            ("Reaction", format!("{:5.2} ± {:.2} s", mean.reaction_s, sd.reaction_s)),
            ("To advice", format!("{:+5.2} ± {:.2} m/s", mean.speed_bias_mps, sd.speed_bias_mps)),
            ("Error", format!("{:5.2} ± {:.2} m/s", mean.error_mps, sd.error_mps)),
            ("Time gap", format!("{:5.2} ± {:.2} × the others", mean.time_gap_factor, sd.time_gap_factor)),
            ("Follows", format!("{:5.0} ± {:.0} %", 100.0 * mean.willingness, 100.0 * sd.willingness)),
        ] {
            row(ui, name, &value, theme::TEXT);
        }
    });
}

/// Shows the driver as observed from their own history.
pub fn observed_driver(ui: &mut Ui, observed: &ObservedDriver) {
    let ObservedDriver { deviation_mps, reaction_s, time_gap_factor } = observed;
    egui::Grid::new("observed").num_columns(2).spacing([10.0, 3.0]).striped(true).show(ui, |ui| {
        row(ui, "Reaction", &format!("{reaction_s:5.2} s"), theme::TEXT);
        row(ui, "To advice", &format!("{deviation_mps:+5.2} m/s now"), theme::TEXT);
        row(ui, "Time gap", &format!("{time_gap_factor:5.2} × the others"), theme::TEXT);
    });
}

fn row(ui: &mut Ui, name: &str, value: &str, colour: Color32) {
    ui.label(RichText::new(name).color(theme::DIM));
    ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.add(egui::Label::new(RichText::new(value).monospace().color(colour)).truncate());
        ui.allocate_space(egui::vec2(ui.available_width(), 0.0));
    });
    ui.end_row();
}

/// Formats a speed as `9.8 mph   4.36 m/s`. Speeds below 0.005 m/s, of an ego that sways on its springs, are 0, never
/// -0.
fn speed(speed_mps: f64, unit: SpeedUnit) -> String {
    let speed_mps = if speed_mps.abs() < 0.005 { 0.0 } else { speed_mps };
    format!("{:5.1} {}  {speed_mps:6.2} m/s", unit.from_mps(speed_mps), unit.label())
}

/// Formats a time as minutes, seconds and tenths, rounded down.
pub fn time(time_s: f64) -> String {
    let tenths = (time_s * 10.0 + 1e-6).floor() as u64;
    format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10)
}

/// Lines of the plot and their colours.
const LINES: [(&str, Color32); 3] = [("mean of all", theme::ACCENT), ("ego", theme::AMBER), ("target", theme::RED)];

/// Returns marks from 0 to `until`, at the first of `steps` that gives at most `most` marks, or else the last.
fn marks(until: f64, most: f64, steps: &[f64]) -> Vec<GridMark> {
    let fits = |step: &&f64| until / **step <= most;
    let Some(&step) = steps.iter().find(fits).or(steps.last()) else { return Vec::new() };
    (0..=(until / step) as u32).map(|i| GridMark { value: f64::from(i) * step, step_size: step }).collect()
}

/// Configures a fixed plot of speeds over time with few marks: seconds `from_s` to `to_s` across, m/s upwards from 0 to
/// at least 6.
pub fn quiet(plot: Plot<'_>, height: f32, [from_s, to_s]: [f64; 2]) -> Plot<'_> {
    const TIMES: [f64; 8] = [20.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 3600.0, 7200.0];
    let step = TIMES.into_iter().find(|step| (to_s - from_s) / step <= 3.0).unwrap_or(7200.0);
    // A low plot has room for few marks.
    let most = if height < 110.0 { 3.0 } else { 6.0 };
    plot.height(height)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .include_y(0.0)
        .include_y(6.0)
        .set_margin_fraction(egui::vec2(0.0, 0.04))
        .x_grid_spacer(move |_| marks(to_s, f64::INFINITY, &[step]))
        .y_grid_spacer(move |input| marks(input.bounds.1, most, &[2.0, 5.0, 10.0, 20.0]))
        .x_axis_formatter(|mark, _| time(mark.value).trim_end_matches(".0").to_owned())
        .y_axis_formatter(|mark, _| format!("{:.0}", mark.value))
        .y_axis_min_width(18.0)
        .grid_color(Color32::from_rgb(58, 64, 73))
        .grid_fade(0.0)
}

/// Shows the mean speed of all vehicles over time, with the ego's speed and the target.
pub fn plot(ui: &mut Ui, history: &SpeedHistory, height: f32) {
    let samples = history.samples();
    let line = |of: fn(&super::SpeedSample) -> f64| -> Vec<[f64; 2]> {
        samples.iter().map(|sample| [sample.time_s, of(sample)]).collect()
    };
    ui.horizontal(|ui| {
        for (name, colour) in LINES {
            ui.label(RichText::new(name).color(colour).small());
        }
        ui.label(RichText::new("m/s").color(theme::DIM).small());
    });
    // The first minute is shown at once, so that the first seconds do not fill the width.
    let until = samples.last().map_or(0.0, |sample| sample.time_s).max(60.0);
    quiet(Plot::new("speeds"), height, [0.0, until])
        .include_x(0.0)
        // Room for half of the last mark's text.
        .include_x(1.05 * until)
        .show(ui, |plot| {
            for (i, part) in targets(samples).into_iter().enumerate() {
                plot.line(Line::new(LINES[2].0, part).id(("target", i)).color(LINES[2].1).width(1.0));
            }
            plot.line(Line::new(LINES[1].0, line(|sample| sample.ego_mps)).color(LINES[1].1).width(1.2));
            plot.line(Line::new(LINES[0].0, line(|sample| sample.mean_mps)).color(LINES[0].1).width(2.2));
        });
}

/// Returns the target speeds, one line for each period with advice.
fn targets(samples: &[super::SpeedSample]) -> Vec<Vec<[f64; 2]>> {
    samples
        .chunk_by(|one, next| one.target_mps.is_some() == next.target_mps.is_some())
        .map(|part| part.iter().filter_map(|s| s.target_mps.map(|target| [s.time_s, target])).collect::<Vec<_>>())
        .filter(|part| !part.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_read_in_minutes() {
        assert_eq!(time(0.0), "0:00.0");
        assert_eq!(time(0.1 + 0.2), "0:00.3");
        assert_eq!(time(125.99), "2:05.9");
    }

    #[test]
    fn a_standing_vehicle_has_speed_0_without_a_sign() {
        assert_eq!(speed(-0.004, SpeedUnit::Mph), "  0.0 mph    0.00 m/s");
        assert_eq!(speed(-0.5, SpeedUnit::Mph), " -1.1 mph   -0.50 m/s");
        assert_eq!(speed(4.362, SpeedUnit::Mph), "  9.8 mph    4.36 m/s");
    }

    #[test]
    fn marks_are_few_at_any_length() {
        let steps = [20.0, 60.0, 120.0];
        assert_eq!(marks(60.0, 3.0, &steps).iter().map(|mark| mark.value).collect::<Vec<_>>(), [0.0, 20.0, 40.0, 60.0]);
        assert_eq!(marks(61.0, 3.0, &steps).len(), 2);
        assert_eq!(marks(300.0, 3.0, &steps).len(), 3);
    }

    #[test]
    fn a_period_without_advice_is_a_gap_in_the_line() {
        let mut history = SpeedHistory::default();
        for (i, target) in [None, Some(4.0), Some(4.0), None, Some(3.0)].into_iter().enumerate() {
            history.push(i as f64, 4.0, 4.0, target);
        }
        assert_eq!(targets(history.samples()), [vec![[1.0, 4.0], [2.0, 4.0]], vec![[4.0, 3.0]]]);
    }
}
