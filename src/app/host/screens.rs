//! Which monitor a window goes to. In: what the system lists, what a person asked for. Out: one of them, or a message that
//! lists them all.

use crate::app::AppError;
use winit::{event_loop::ActiveEventLoop, monitor::MonitorHandle, window::Window};

/// The monitor of that number (from 1) or whose name contains these letters.
///
/// # Errors
/// There is none; the message lists those that there are.
pub fn named(event_loop: &ActiveEventLoop, asked: &str) -> Result<MonitorHandle, AppError> {
    let all: Vec<MonitorHandle> = event_loop.available_monitors().collect();
    let names: Vec<String> = all.iter().map(|monitor| monitor.name().unwrap_or_default()).collect();
    match index_of(&names, asked) {
        Some(index) => Ok(all[index].clone()),
        None => Err(AppError::NoMonitor { asked: asked.into(), there: list(&names) }),
    }
}

/// A monitor where `window` is not, if there are several.
pub fn another(event_loop: &ActiveEventLoop, window: &Window) -> Option<MonitorHandle> {
    let taken = window.current_monitor()?;
    event_loop.available_monitors().find(|monitor| *monitor != taken)
}

fn index_of(names: &[String], asked: &str) -> Option<usize> {
    if let Ok(number) = asked.parse::<usize>() {
        return number.checked_sub(1).filter(|index| *index < names.len());
    }
    let asked = asked.to_lowercase();
    names.iter().position(|name| !asked.is_empty() && name.to_lowercase().contains(&asked))
}

fn list(names: &[String]) -> String {
    let numbered: Vec<String> = (1..).zip(names).map(|(number, name)| format!("{number} ({name})")).collect();
    if numbered.is_empty() { "none is listed by the system".into() } else { numbered.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_monitor_is_asked_for_by_number_or_by_part_of_its_name() {
        let names = ["eDP-1", "HDMI-A-1"].map(str::to_owned);
        assert_eq!(index_of(&names, "1"), Some(0));
        assert_eq!(index_of(&names, "hdmi"), Some(1));
        for wrong in ["0", "3", "DP-7", ""] {
            assert_eq!(index_of(&names, wrong), None, "{wrong}");
        }
        assert_eq!(list(&names), "1 (eDP-1), 2 (HDMI-A-1)");
    }
}
