//! Speeds of all vehicles over the drive, for at most five minutes, one line each, the ego's thick. In: a [`DriveLog`].
//! Out: a plot; m/s.

use super::DriveLog;
use crate::panel::{readout, theme};
use egui::{Color32, Ui};
use egui_plot::{Line, Plot, PlotPoints};

/// Lines of the other vehicles: thin and pale, so that twenty of them make a band.
const OTHERS: Color32 = Color32::from_rgb(82, 138, 106);

/// Shows the plot over the available width.
pub fn cars(ui: &mut Ui, log: &DriveLog, time_s: f64, height: f32) {
    let [from_s, to_s] = log.window(time_s);
    let cars = log.speeds.back().map_or(0, |row| row.speeds_mps.len());
    let line = |car: usize| -> PlotPoints<'_> {
        let point = |row: &super::log::SpeedRow| Some([row.time_s, f64::from(*row.speeds_mps.get(car)?)]);
        log.speeds.iter().filter_map(point).collect()
    };
    readout::quiet(Plot::new("cars"), height, [from_s, to_s]).include_x(from_s).include_x(to_s).show(ui, |plot| {
        for car in 1..cars {
            plot.line(Line::new("", line(car)).id(("car", car)).color(OTHERS).width(0.8));
        }
        if cars > 0 {
            plot.line(Line::new("participant", line(0)).color(theme::AMBER).width(2.0));
        }
    });
}
